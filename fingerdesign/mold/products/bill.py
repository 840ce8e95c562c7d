"""The bill of materials: what has to lie on the bench before a mold is made."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import TypedDict

from fingerdesign.arrays import Array
from fingerdesign.mold.plan.plan import Bolt, MoldPlan
from fingerdesign.mold.products.casting import Casting, rubber_words
from fingerdesign.records.base import Count, Size, closed, write_csv
from fingerdesign.report.page import macros

TEMPLATE = Path(__file__).parents[1] / "templates" / "bill.j2"
# The nut's height and the washer's thickness, mm (ISO 4032 and ISO 7089)
NUTS = {"M2": (1.6, 0.3), "M2.5": (2.0, 0.5), "M3": (2.4, 0.5), "M4": (3.2, 0.8)}
PROUD_MM = 1.0  # of a bolt beyond its nut: two turns or more
LENGTHS_MM = (
    *(5, 6, 8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70),
    *(80, 90, 100, 110, 120, 130, 140, 150),
)
# So many round wires in a round bundle take so many of their diameters.
_BUNDLE = {2: 2.0, 4: 1.0 + math.sqrt(2.0), 6: 3.0}
WIRE_MM = 200.0  # of thin wire a gage lead, to where it can be handled


@closed
class ItemData(TypedDict):
    """A row of the bill of materials."""

    item: str
    count: Count
    made: str
    material: str
    size: str
    mass_g: Size | None
    files: str


def bill_of_materials(casting: Casting) -> tuple[ItemData, ...]:
    """Write all lines, parts first, then plates, hardware and what is consumed."""
    design, plan, meshes, patterns = casting.design, casting.plan, casting.meshes, casting.patterns
    plates = sum(pattern.count for pattern in patterns)
    gages = design.gages.faces * plates
    wire = design.mold.wire_mm / _BUNDLE[design.gages.leads]
    metres = math.ceil(design.gages.leads * plates * WIRE_MM / 1000.0)
    gage = None if casting.fit is None else casting.fit.found
    rubber, open_ = rubber_words(design), plan.pour == "open"
    return (
        *_lines("parts", design, (*meshes.parts, *meshes.coupon), _extent),
        *_lines("plates", design, patterns, _extent, {each.index for each in casting.trial}),
        *hardware(plan),
        *_lines("consumed", rubber, casting, gages, gage, metres, wire, open_),
    )


def _lines(macro: str, *given: Any) -> Iterator[ItemData]:
    """The lines of one of the macros of templates/bill.j2."""
    for line in getattr(macros(TEMPLATE), macro)(*given).splitlines():
        if line.strip():
            item, count, *words, mass, files = map(str.strip, line.split("|"))
            cells = (item, int(count), *words, float(mass) if mass else None, files)
            found: Any = dict(zip(ItemData.__annotations__, cells, strict=True))
            yield found


def _extent(points: Array) -> list[float]:
    return list(np.ptp(points, axis=0).tolist())


def write_bill(items: Sequence[ItemData], path: Path) -> None:
    """bill_of_materials.csv: a row an item, units in the column names."""
    write_csv(path, ItemData.__annotations__, (item.values() for item in items))


def bolt_length(bolt: Bolt) -> int | None:
    """Nominal length that clamps ``bolt``'s parts with a washer at each end and a nut, mm.

    None where no usual length does: threaded rod, cut to size.

    >>> from fingerdesign.mold.plan.plan import Bolt
    >>> bolt_length(Bolt("z", 0.0, 5.0, -15.0, 15.0, "M3", 3.4))
    35
    """
    nut, washer = NUTS[bolt.size]
    needed = (bolt.high - bolt.low) + 2.0 * washer + nut + PROUD_MM
    return next((length for length in LENGTHS_MM if length >= needed - 1e-9), None)


def bolt_words(bolt: Bolt) -> str:
    """A bolt as it is bought; a threaded rod where no usual length does."""
    length = bolt_length(bolt)
    return f"{bolt.size} threaded rod" if length is None else f"{bolt.size} x {length}"


def hardware(plan: MoldPlan) -> tuple[ItemData, ...]:
    """Bolts with nuts and washers, dowels, core pins, core screws."""
    bolts = Counter((b.size, bolt_length(b), round(b.high - b.low, 2)) for b in plan.bolts)
    sizes = Counter(bolt.size for bolt in plan.bolts)
    rods = Counter(bolt.size for bolt in plan.bolts if bolt_length(bolt) is None)
    alike = (
        _alike((pin.diameter, pin.length) for pin in plan.pins if pin.dowel),
        _alike((pin.diameter, plan.reach(pin.side) - abs(pin.tip)) for pin in plan.core_pins),
        _alike((hole.diameter,) for hole in plan.base_holes if hole.kind == "screw"),
    )
    nuts = [(size, (count, rods[size])) for size, count in sorted(sizes.items())]
    return tuple(_lines("hardware", plan, sorted(bolts.items(), key=str), nuts, *alike))


def _alike(sizes: Iterable[tuple[float, ...]]) -> list[tuple[tuple[float, ...], int]]:
    """Count each different size of a thing."""
    counts = Counter((size[0], *(round(value, 2) for value in size[1:])) for size in sizes)
    return sorted(counts.items())
