"""The bill of materials: everything that has to lie on the bench before the mold is closed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np

from fingerdesign.design.schema import Design
from fingerdesign.mold.part import CORE, MoldMeshes, PartMesh
from fingerdesign.mold.plan.plan import Bolt, MoldPlan, density_of
from fingerdesign.mold.products.flat_pattern import FlatPattern
from fingerdesign.records.base import write_csv


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
WIRE_MM = 200.0  # of thin wire a gage lead, to where it can be handled
PROCESS_WORDS = {"sla": "resin print", "fdm": "filament print", "machined": "machined"}


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
    return (
        *(_part(design, part) for part in meshes.parts),
        *(_plate(design, pattern) for pattern in patterns),
        *hardware(plan),
        *_consumed(design, patterns, silicone),
    )


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
    items = []
    bolts = Counter((b.size, bolt_length(b), round(b.high - b.low, 2)) for b in plan.bolts)
    for (size, nominal, grip), count in sorted(bolts.items(), key=str):
        name = "threaded rod" if nominal is None else "bolt"
        long = size if nominal is None else f"{size} x {nominal}"
        items.append(Item(name, count, "bought", "steel", f"{long}, clamps {grip:g} mm"))
    sizes = Counter(bolt.size for bolt in plan.bolts)
    for size, count in sorted(sizes.items()):
        rods = sum(b.size == size and bolt_length(b) is None for b in plan.bolts)
        items.append(Item("nut", count + rods, "bought", "steel", size))
        items.append(Item("washer", 2 * count, "bought", "steel", size))
    pins = [(pin.diameter, plan.reach(pin.side) - abs(pin.tip)) for pin in plan.core_pins]
    screws = [(hole.diameter,) for hole in plan.base_holes if hole.kind == "screw"]
    threaded = f"for a {{:g}} mm hole, {plan.base:g} mm plate"
    shims = [
        (slot.shim, width, plan.wall(side.side)) for side, slot, width in plan.held() if slot.shim
    ]
    stock = "shim stock, assorted, brass or steel: measure the slots"
    dowels = [(pin.diameter, pin.length) for pin in plan.pins if pin.dowel]
    return (
        *items,
        *_alike("dowel pin", "bought", "steel", dowels, "{:g} mm x {:g} mm"),
        *_alike(
            "core pin", "bought", "steel rod or drill shank", pins, "{:g} mm, {:g} mm or longer"
        ),
        *_alike("core screw", "bought", "steel", screws, threaded),
        *_alike("shim", "cut", stock, shims, "{:g} mm thick as drawn, {:g} mm wide x {:g} mm"),
    )


def _alike(
    item: str, made: str, material: str, sizes: Iterable[tuple[float, ...]], words: str
) -> Iterator[Item]:
    """A line for each different size of a thing, which ``words`` say."""
    counts = Counter((size[0], *(round(value, 2) for value in size[1:])) for size in sizes)
    for size, count in sorted(counts.items()):
        yield Item(item, count, made, material, words.format(*size))


def _part(design: Design, part: PartMesh) -> Item:
    x, y, z = np.ptp(part.vertices, axis=0).tolist()
    size = f"{x:.1f} x {y:.1f} x {z:.1f} mm, {part.volume / 1000.0:.2f} cm³"
    files = f"{part.name}.stl, {part.name}.step"
    if part.made == "sheet":
        thick = min(x, z)
        size = f"{max(x, z):.1f} x {y:.1f} mm, {thick:g} mm thick"
        return Item(
            *(part.name, 1, "cut or etched", "sheet, brass or steel", size),
            files=f"{part.name}.dxf, {files}",
        )
    process = design.mold.process
    if part.name == CORE and design.body.core is not None:
        return Item(part.name, 1, "made", _words(design.body.core.material), size, files=files)
    material = {"sla": "resin", "fdm": "filament", "machined": "aluminium"}[process]
    return Item(part.name, 1, PROCESS_WORDS[process], material, size, files=files)


def _plate(design: Design, pattern: FlatPattern) -> Item:
    wide, long = np.ptp(pattern.outline, axis=0).tolist()
    size = f"{wide:.2f} x {long:.2f} mm, {pattern.thickness:g} mm thick"
    if pattern.bend_radius is not None:
        size += f", bent to a radius of {pattern.bend_radius:.2f} mm"
    return Item(
        *(pattern.name, len(pattern.plates), "cut or etched", _words(design.plates.material), size),
        files=f"plates.dxf, {pattern.name}.stl, {pattern.name}.step",
    )


def _consumed(
    design: Design, patterns: Sequence[FlatPattern], silicone: Silicone
) -> Iterable[Item]:
    mold, plates = design.mold, sum(len(pattern.plates) for pattern in patterns)
    name = _words(design.body.material)
    mixed = f"{silicone.mixed_cm3:.2f} cm³ with {100 * mold.excess:g} % excess"
    yield Item("elastomer, mixed", 1, "poured", name, mixed, round(silicone.mass_g, 1))
    if plates:
        faces = 2 if design.gages.face == "both" else 1
        gage = f"{design.gages.length_mm:g} mm x {design.gages.width_mm:g} mm grid"
        yield Item("strain gage", faces * plates, "bought", "foil gage", gage)
        metres = math.ceil(2 * faces * plates * WIRE_MM / 1000.0)
        # So many round wires in a round bundle: four take 2.41 of their diameters, two take 2.
        each = mold.wire_mm / (1.0 + math.sqrt(2.0) if faces == 2 else 2.0)
        across = f", {each:.2g} mm or thinner over its enamel" if mold.wire_mm > 0.0 else ""
        yield Item("gage wire", 1, "bought", "enamelled copper", f"{metres} m{across}")
        yield Item("gage adhesive", 1, "bought", "cyanoacrylate or epoxy for gages", "a few drops")
        yield Item("metal primer", 1, "bought", "for this elastomer on metal", "a few ml")
    yield Item("base primer", 1, "bought", "for this elastomer on the base plate", "a few ml")
    yield Item("release agent", 1, "bought", "spray or wax, safe for this elastomer", "a thin film")
    yield Item("tape or clay", 1, "bought", "sulfur-free", "to stop leaks")


def _words(name: str) -> str:
    return name.replace("_", " ")
