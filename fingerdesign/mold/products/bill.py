"""The bill of materials: everything that has to lie on the bench before the mold is closed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.mold.part import MoldMeshes
from fingerdesign.mold.plan.plan import Bolt, MoldPlan, density_of
from fingerdesign.mold.products.flat_pattern import FlatPattern
from fingerdesign.records.base import write_csv
from fingerdesign.report.page import macros


@dataclass(frozen=True)
class Silicone:
    """Volumes in cm^3: the finger's rubber as cast, what stands in locks, in gate, risers and
    vents, and the flash around plates in their slots; ``excess`` is the share mixed beyond."""

    finger: float
    locks: float
    gate_risers_vents: float
    flash: float
    excess: float
    density_g_cm3: float

    @property
    def mixed_cm3(self) -> float:
        """Volume to mix, cm^3."""
        filled = self.finger + self.locks + self.gate_risers_vents + self.flash
        return filled * (1.0 + self.excess)

    @property
    def mass_g(self) -> float:
        """Mass to mix, both components together, g."""
        return self.mixed_cm3 * self.density_g_cm3

    @property
    def sentence(self) -> str:
        """The amount in words."""
        return (
            f"mix {self.mixed_cm3:.2f} cm³ ({self.mass_g:.1f} g at {self.density_g_cm3:g} "
            f"g/cm³): {self.finger:.2f} cm³ of finger, "
            f"{self.locks + self.gate_risers_vents + self.flash:.2f} cm³ in locks, gate, risers, "
            f"vents and flash, and {100.0 * self.excess:.0f} % to spare"
        )


def silicone_of(design: Design, plan: MoldPlan, meshes: MoldMeshes) -> Silicone:
    """What rubber, base holes and slots hold; plates without rubber between leave no flash."""
    locks, openings = 0.0, 0.0
    for hole in plan.base_holes:
        d, outer = hole.diameter, hole.outer_diameter
        cone = math.pi * plan.base * (d**2 + d * outer + outer**2) / 12.0
        locks += cone if hole.kind == "lock" else 0.0
        openings += cone if hole.kind in ("gate", "riser", "vent") else 0.0
    volumes = np.array([meshes.rubber.volume, locks, openings, _flash(plan)])
    finger, locks, openings, flash = (1e-3 * volumes).tolist()
    return Silicone(finger, locks, openings, flash, design.mold.excess, density_of(design))


def _flash(plan: MoldPlan) -> float:
    """Slots less the legs in them, as deep as what holds them: sheets, or the whole wall."""
    whole = 0.0
    for side, slot, width in plan.held():
        metal = width * (plan.thickness[slot.plate] + slot.shim)
        hole = 0.25 * np.pi * (slot.relief**2 - slot.wire**2) if slot.relief else 0.0
        free = max(0.0, slot.length * slot.width - metal) + hole
        whole += free * (side.thick or plan.wall(side.side))
    return float(whole)


# nut's height and washer's thickness, mm (ISO 4032 and ISO 7089)
NUTS = {"M2": (1.6, 0.3), "M2.5": (2.0, 0.5), "M3": (2.4, 0.5), "M4": (3.2, 0.8)}
PROUD_MM = 1.0  # of a bolt beyond its nut: two turns or more
LENGTHS_MM = (
    *(5, 6, 8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70),
    *(80, 90, 100, 110, 120, 130, 140, 150),
)
# So many round wires in a round bundle take so many of their diameters.
_BUNDLE = {2: 2.0, 4: 1.0 + math.sqrt(2.0), 6: 3.0}
WIRE_MM = 200.0  # of thin wire a gage lead, to where it can be handled
TEMPLATE = Path(__file__).parents[1] / "templates" / "bill.j2"


@dataclass(frozen=True)
class Item:
    """One line: ``count`` of a thing, how it is made, of what, how large, of what mass."""

    item: str
    count: int
    made: str
    material: str
    size: str
    mass_g: float | None = None
    files: str = ""


def bill_of_materials(
    design: Design,
    plan: MoldPlan,
    meshes: MoldMeshes,
    patterns: Sequence[FlatPattern],
    silicone: Silicone,
) -> tuple[Item, ...]:
    """All lines, parts first, then plates, hardware and what is consumed."""
    plates = sum(pattern.count for pattern in patterns)
    gages = design.gages.faces * plates
    wire = design.mold.wire_mm / _BUNDLE[design.gages.leads]
    metres = math.ceil(design.gages.leads * plates * WIRE_MM / 1000.0)
    return (
        *_items("parts", design, meshes.parts, _extent),
        *_items("plates", design, patterns, _extent),
        *hardware(plan),
        *_items("consumed", design, silicone, gages, metres, wire),
    )


def _items(macro: str, *given: Any) -> Iterator[Item]:
    """The lines of one of the macros of templates/bill.j2."""
    for line in getattr(macros(TEMPLATE), macro)(*given).splitlines():
        if line.strip():
            item, count, made, material, size, mass, files = map(str.strip, line.split("|"))
            mass_g = float(mass) if mass else None
            yield Item(item, int(count), made, material, size, mass_g, files)


def _extent(points: Array) -> list[float]:
    return list(np.ptp(points, axis=0).tolist())


def write_bill(items: Sequence[Item], path: Path) -> None:
    """bill_of_materials.csv: a row an item, units in the column names."""
    write_csv(path, Item.__annotations__, (astuple(item) for item in items))


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


def hardware(plan: MoldPlan) -> tuple[Item, ...]:
    """Bolts with nuts and washers, dowels, core pins, core screws, shims."""
    bolts = Counter((b.size, bolt_length(b), round(b.high - b.low, 2)) for b in plan.bolts)
    sizes = Counter(bolt.size for bolt in plan.bolts)
    rods = Counter(bolt.size for bolt in plan.bolts if bolt_length(bolt) is None)
    shims = (
        (slot.shim, width, plan.wall(side.side)) for side, slot, width in plan.held() if slot.shim
    )
    alike = (
        _alike((pin.diameter, pin.length) for pin in plan.pins if pin.dowel),
        _alike((pin.diameter, plan.reach(pin.side) - abs(pin.tip)) for pin in plan.core_pins),
        _alike((hole.diameter,) for hole in plan.base_holes if hole.kind == "screw"),
        _alike(shims),
    )
    nuts = [(size, (count, rods[size])) for size, count in sorted(sizes.items())]
    return tuple(_items("hardware", plan, sorted(bolts.items(), key=str), nuts, *alike))


def _alike(sizes: Iterable[tuple[float, ...]]) -> list[tuple[tuple[float, ...], int]]:
    """How many there are of each different size of a thing."""
    counts = Counter((size[0], *(round(value, 2) for value in size[1:])) for size in sizes)
    return sorted(counts.items())
