"""The bill of materials: what has to lie on the bench before a mold is made."""

import csv
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import numpy as np
from pydantic import Field
from typing_extensions import TypedDict

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.layout.leads import bundle
from fingerdesign.mold.part import BASE, CORE, SPACER, PartMesh
from fingerdesign.mold.plan.limits import comb_tolerance
from fingerdesign.mold.plan.pieces import Bolt
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.products.casting import Casting, rubber_words
from fingerdesign.mold.products.hours import joints_of
from fingerdesign.records.base import Count, Size, closed, write_csv

PROCESSES = {  # How a part is made, and of what.
    "sla": ("resin print", "resin"),
    "fdm": ("filament print", "filament"),
    "machined": ("machined", "aluminium"),
}
# The nut's height and the washer's thickness, mm (ISO 4032 and ISO 7089)
NUTS = {"M2": (1.6, 0.3), "M2.5": (2.0, 0.5), "M3": (2.4, 0.5), "M4": (3.2, 0.8)}
PROUD_MM = 1.0  # of a bolt beyond its nut: two turns or more
LENGTHS_MM = (
    *(5, 6, 8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70),
    *(80, 90, 100, 110, 120, 130, 140, 150),
)
SPARE = 0.2  # of the plates
# What is used up, and what a workshop has.
BENCH = Path(__file__).parents[1] / "templates" / "bench.csv"
_STEEL = "bought", "steel"
_CUT, _FINE = "cut or etched", "laser-cut or wire-cut"
_LEAST_ETCHED = 0.9  # Width of a slot over the sheet's thickness; assumed.
WIRE_MM = 200.0  # of thin wire a gage lead, to where it can be handled


When = Literal["order today", "make", "buy", "have"]


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
    when: Annotated[When, Field(description="order today: weeks | make | buy: days | have")]
    words: Annotated[str, Field(description="to send with the drawings of what is ordered")]


def _item(item: str, count: int, made: str, material: str, size: str, **more: Any) -> ItemData:
    """A row of the bill; ``when`` follows from how it is made where it is not given."""
    usual = {"bought": "buy", _CUT: "order today", _FINE: "order today"}.get(made, "make")
    own = {"item": item, "count": count, "made": made, "material": material, "size": size}
    rest = {"mass_g": None, "files": "", "when": usual, "words": ""}
    return cast(ItemData, own | rest | more)


def bill_of_materials(casting: Casting) -> tuple[ItemData, ...]:
    """Write all lines: what is ordered today, then what is made, bought, and in the workshop."""
    plates = sum(pattern.count + spare_of(pattern.count) for pattern in casting.patterns)
    gages = casting.design.gages.faces * plates
    items = (
        *(_part(casting, part) for part in (*casting.meshes.parts, *casting.meshes.coupon)),
        *_plates(casting),
        *hardware(casting.plan),
        *_elastomer(casting),
        *(_gages(casting, gages) if gages else ()),
        *_bench(casting),
    )
    order = ("order today", "make", "buy", "have")
    return tuple(sorted(items, key=lambda each: order.index(each["when"])))


def spare_of(count: int) -> int:
    """Plates to spare of a kind: a fifth, one at least.

    >>> spare_of(11), spare_of(3)
    (3, 1)
    """
    return math.ceil(SPARE * count)


def primer_words(design: Design) -> str:
    """The primer for plates of their material."""
    if "polyimide" in design.plates.material:
        return "primer for this elastomer on plastic film (polyimide, roughened or plasma-treated)"
    return "primer for this elastomer on metal"


def _words(name: str) -> str:
    return name.replace("_", " ")


def comb_made(plan: MoldPlan) -> str:
    """The way to make combs: etching makes no slot much narrower than the sheet is thick."""
    least = min((s.width for e in plan.sides if e.comb for s in e.slots), default=math.inf)
    return _FINE if least < _LEAST_ETCHED * plan.design.mold.comb.sheet_mm else _CUT


def _part(casting: Casting, part: PartMesh) -> ItemData:
    """A part of the mold or of the coupon."""
    design = casting.design
    x, y, z = _extent(part.vertices)
    files = f"{part.name}.stl, {part.name}.step"
    if part.made == "sheet":
        size = f"{max(x, z):.1f} x {y:.1f} mm, {min(x, z):g} mm thick"
        material = "sheet, brass or steel"
        files = f"{part.name}.dxf, {files}"
        words = (
            f"{part.name}.dxf: 1 of {size}, {material}; edges to {comb_tolerance(design.mold):g} mm"
        )
        made = comb_made(casting.plan)
        return _item(part.name, 1, made, material, size, files=files, words=words)
    made, material = PROCESSES[design.mold.process]
    if part.name == CORE and design.body.core is not None:
        made, material = "made", _words(design.body.core.material)
    if part.name == BASE:  # the second one is the bare finger's
        material += "; aluminium or polycarbonate for the real finger"
    size = f"{x:.1f} x {y:.1f} x {z:.1f} mm, {part.volume / 1000:.2f} cm³"
    count = {BASE: 2, SPACER: 2}.get(part.name, 1)
    when: When = "order today" if design.mold.process == "machined" else "make"
    return _item(part.name, count, made, material, size, files=files, when=when)


def _plates(casting: Casting) -> Iterator[ItemData]:
    """The plates by their patterns, and those that are cut once more for the coupon's cell."""
    name = casting.design.plates.material
    trial = {each.index for each in casting.trial}
    for pattern in casting.patterns:
        wide, long = _extent(pattern.outline)
        bend = pattern.bend_radius
        bent = "" if bend is None else f", bent to a radius of {bend:.2f} mm"
        size = f"{wide:.2f} x {long:.2f} mm, {pattern.thickness:g} mm thick{bent}"
        files = f"plates.dxf, {pattern.name}.stl, {pattern.name}.step"
        metal = _CUT, _words(name)
        spare, bare = spare_of(pattern.count), f"{pattern.name}, for the bare finger"
        words = (
            f"plates.dxf, {pattern.name}: {2 * pattern.count + spare} of {pattern.thickness:g} mm "
            f"{_words(name)}, cut to {comb_tolerance(casting.design.mold):g} mm, no burr, flat"
        )
        yield _item(pattern.name, pattern.count, *metal, size, files=files, words=words)
        yield _item(f"{pattern.name}, to spare", spare, *metal, "the same, 20 %")
        yield _item(bare, pattern.count, *metal, "the same, without gages")
        if more := trial.intersection(pattern.plates):
            files = f"nested_{name}_{pattern.thickness:g}mm.dxf"
            item = f"{pattern.name}, for the coupon"
            yield _item(item, len(more), *metal, "the same", files=files)


def _elastomer(casting: Casting) -> Iterator[ItemData]:
    """The elastomer as mixed, and its two parts."""
    silicone, mixing = casting.silicone, casting.mixing
    size = f"{silicone['mixed_cm3']:.2f} cm³ with {100 * silicone['excess']:g} % excess"
    material = _words(casting.design.body.material)
    yield _item(
        "elastomer, mixed", 1, "poured", material, size, mass_g=round(silicone["mass_g"], 1)
    )
    rubber = rubber_words(casting.design)
    if not mixing.known:
        rubber += "; hold the ratio against your data sheet"
    size = f"{mixing.part_a:g} : {mixing.part_b:g} by mass ({mixing.source})"
    for name, mass in zip("AB", mixing.shares(silicone["mass_g"]), strict=True):
        yield _item(f"elastomer, part {name}", 1, "bought", rubber, size, mass_g=round(mass, 1))


def _gages(casting: Casting, gages: int) -> Iterator[ItemData]:
    """The gages with what bonds and connects them."""
    own = casting.design.gages
    material = "tee rosette: two grids across each other" if own.grid == "tee" else "foil gage"
    found, size = casting.gage, f"{own.length_mm:g} mm x {own.width_mm:g} mm grid"
    if found is not None and found.kind in ("bar", "film"):
        material = {"bar": "bare silicon bar", "film": "film made on the sheet"}[found.kind]
        material += ", two grids across each other" if own.grid == "tee" else ""
    if found is None:
        size += ": none that is sold fits these plates, so choose mold.gage before you cut them"
    else:
        long, wide = found.carrier(own.length_mm, own.width_mm)
        size += f": {found.name}, {long:g} mm x {wide:g} mm in all"
    words = _order_words(casting, gages)
    yield _item("strain gage", gages, "bought", material, size, when="order today", words=words)
    if joints := joints_of(casting):
        plates = sum(pattern.count for pattern in casting.patterns)
        metres = math.ceil(own.lead_count * plates * WIRE_MM / 1000.0)
        wire = casting.design.mold.wire_mm / bundle(own.lead_count)
        thin = f", {wire:.2g} mm or thinner over its enamel" if wire else ""
        yield _item("gage wire", 1, "bought", "enamelled copper", f"{metres} m{thin}")
        adhesive = "cyanoacrylate or epoxy for gages"
        yield _item("gage adhesive", 1, "bought", adhesive, "a few drops")
        yield _item("solder and flux", 1, "bought", "thin, rosin", f"{joints} joints")
    else:
        legs = "of the front legs' pitch: elastomeric strip, or flex bonded by anisotropic film"
        yield _item("leg connector", 1, "bought", legs, f"{own.lead_count} contacts a leg")
    yield _item("primer", 1, "bought", primer_words(casting.design), "a few ml")


def _order_words(casting: Casting, gages: int) -> str:
    """The text that orders the gages."""
    own, found = casting.design.gages, casting.gage
    if found is None:
        return ""
    grid = f"grid {own.length_mm:g} x {own.width_mm:g} mm, {found.resistance_ohm:g} ohm"
    if found.to_measure:
        material = _words(casting.design.plates.material)
        return (
            f"Please quote {_words(found.name)} on {casting.design.plates.thickness_mm:g} mm "
            f"{material} sheet by plates.dxf (layer GAGES), {own.lead_count} traces a plate to the "
            f"front leg, on {own.faces} face{'s' * (own.faces > 1)}: {grid}, {gages} gages; some "
            f"{found.lead_weeks:g} weeks"
        )
    packs = math.ceil(gages / found.least_order) * found.least_order
    return f"{packs} of {_words(found.name)} ({grid}), at least {found.least_order} a pack"


def _bench(casting: Casting) -> Iterator[ItemData]:
    """Everything else that a caster uses up, and tools."""
    mold, material = casting.design.mold, casting.design.body.material
    coated = mold.process == "sla" and mold.cure == "platinum"
    rows = csv.reader(BENCH.read_text(encoding="utf-8").splitlines()[1:])
    for when, item, count, made, kind, size in rows:
        if item != "barrier coat" or (coated and not material.startswith("polyurethane")):
            yield _item(item, int(count), made, kind, size, when=when)


def _extent(points: Array) -> list[float]:
    return list(np.ptp(points, axis=0).tolist())


def write_bill(items: Sequence[ItemData], path: Path) -> None:
    """bill_of_materials.csv: a row an item, units in the column names."""
    write_csv(path, ItemData.__annotations__, (item.values() for item in items))


def bolt_length(bolt: Bolt) -> int | None:
    """Nominal length that clamps ``bolt``'s parts with a washer at each end and a nut, mm.

    None where no usual length does: threaded rod, cut to size.

    >>> from fingerdesign.mold.plan.pieces import Bolt
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


def bolts_in_words(plan: MoldPlan) -> dict[str, list[str]]:
    """The bolts along y and z, by their axis, as they are bought."""
    bolts = sorted(plan.bolts, key=lambda bolt: str((bolt.size, bolt_length(bolt))))
    return {axis: [bolt_words(bolt) for bolt in bolts if bolt.axis == axis] for axis in "yz"}


def hardware(plan: MoldPlan) -> Iterator[ItemData]:
    """Bolts with nuts and washers, dowels, core pins, core screws, what fastens the mount."""
    yield from _bolts(plan.bolts)
    dowels = _alike((pin.diameter, pin.length) for pin in plan.pins if pin.dowel)
    pins = _alike((pin.diameter, plan.reach(pin.side) - abs(pin.tip)) for pin in plan.core_pins)
    screws = _alike((hole.diameter,) for hole in plan.holes["screw"])
    for (wide, long), count in dowels:
        yield _item("dowel pin", count, *_STEEL, f"{wide:g} mm x {long:g} mm")
    for (wide, long), count in pins:
        size = f"{wide:g} mm, {long:g} mm or longer"
        yield _item("core pin", count, "bought", "steel rod or drill shank", size)
    for (wide,), count in screws:
        yield _item("core screw", count, *_STEEL, f"for a {wide:g} mm hole, {plan.base:g} mm plate")
    if plan.groove is not None:
        yield _item("receiver screw", 1, *_STEEL, "M3 x 8, against the base plate")
        if plan.design.mold.mount == "iso9409":
            yield _item("hand screw", 4, *_STEEL, "M6 x 16")
        else:
            yield _item("threaded insert", 2, "bought", "brass, set hot or glued in", "M3, 5 mm")
            yield _item("hand screw", 2, *_STEEL, "M3, by your hand")


def _bolts(bolts: Sequence[Bolt]) -> Iterator[ItemData]:
    """Bolts or rods by size, length and what they clamp; then their nuts and washers."""
    lengths = Counter((b.size, bolt_length(b), round(b.high - b.low, 2)) for b in bolts)
    sizes = Counter(bolt.size for bolt in bolts)
    rods = Counter(bolt.size for bolt in bolts if bolt_length(bolt) is None)
    for (size, length, grip), count in sorted(lengths.items(), key=str):
        item, words = ("bolt", f"{size} x {length}") if length else ("threaded rod", size)
        yield _item(item, count, *_STEEL, f"{words}, clamps {grip:g} mm")
    for size, count in sorted(sizes.items()):
        yield _item("nut", count + rods[size], *_STEEL, size)
        yield _item("washer", 2 * count, *_STEEL, size)


def _alike(sizes: Iterable[tuple[float, ...]]) -> list[tuple[tuple[float, ...], int]]:
    """Count each different size of a thing."""
    return sorted(
        Counter((wide, *(round(rest, 2) for rest in more)) for wide, *more in sizes).items()
    )
