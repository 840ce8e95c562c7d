"""What a caster reads, made from the design: notes step by step, warnings, the bill of materials.

The words stand in ``templates``; here are the numbers that they are made from.
"""

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from typing_extensions import TypedDict

from fingerdesign.arrays import Array
from fingerdesign.design.grip import GRAVITY
from fingerdesign.design.schema import Design
from fingerdesign.layout.fitting import gage_fit, gage_words, sheet_words
from fingerdesign.layout.gaps import PlateGap, least_gap
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import outline_volume
from fingerdesign.materials import MATERIALS, gent_shore_a
from fingerdesign.mold.part import COUPON, MoldMeshes, axis_name
from fingerdesign.mold.plan.base import TILT_DEG
from fingerdesign.mold.plan.limits import density_of, limits_of
from fingerdesign.mold.plan.patterns import FlatPattern
from fingerdesign.mold.plan.plan import WORDS, Bolt, MoldPlan
from fingerdesign.mold.products.drawing import numbers_text
from fingerdesign.mold.profile import cell_plates
from fingerdesign.records.base import Count, Size, closed, write_csv
from fingerdesign.report.page import macros

TEMPLATES = Path(__file__).parents[1] / "templates"
_STEEP = 0.2  # sine of a plate's angle, from which a pitch parts plates
SURFACE_TENSION_N_M = 0.021  # of silicone oils; cured and uncured rubber differ little


@closed
class SiliconeData(TypedDict):
    """What has to be mixed, and of what that consists."""

    finger_cm3: Size
    locks_cm3: Size
    gate_risers_vents_cm3: Size
    flash_cm3: Size
    excess: Size
    mixed_cm3: Size
    density_g_cm3: Size
    mass_g: Size
    sentence: str


def silicone_of(design: Design, plan: MoldPlan, meshes: MoldMeshes) -> SiliconeData:
    """What rubber, base holes and slots hold; plates without rubber between leave no flash."""
    locks, openings = 0.0, 0.0
    for hole in plan.base_holes:
        d, outer = hole.diameter, hole.outer_diameter
        cone = math.pi * plan.base * (d**2 + d * outer + outer**2) / 12.0
        locks += cone if hole.kind == "lock" else 0.0
        openings += cone if hole.kind in ("gate", "riser", "vent") else 0.0
    held = 1e-3 * np.array([meshes.rubber.volume, locks, openings, _flash(plan)])
    finger, locks, openings, flash = held.tolist()
    where = "locks and flash" if plan.pour == "open" else "locks, gate, risers, vents and flash"
    excess, density = design.mold.excess, density_of(design)
    mixed = sum(held.tolist()) * (1.0 + excess)
    return {
        "finger_cm3": finger,
        "locks_cm3": locks,
        "gate_risers_vents_cm3": openings,
        "flash_cm3": flash,
        "excess": excess,
        "mixed_cm3": mixed,
        "density_g_cm3": density,
        "mass_g": mixed * density,
        "sentence": f"mix {mixed:.2f} cm³ ({mixed * density:.1f} g at {density:g} g/cm³): "
        f"{finger:.2f} cm³ of finger, {locks + openings + flash:.2f} cm³ in {where}, "
        f"and {100.0 * excess:.0f} % to spare",
    }


def _flash(plan: MoldPlan) -> float:
    """Slots less the legs in them, as deep as what holds them: sheets, or the whole wall."""
    whole = 0.0
    for side, slot, width in plan.leg_slots:
        metal = width * plan.thickness[slot.plate]
        free = max(0.0, slot.length * slot.width - metal)
        whole += free * (side.sheet or plan.wall(side.side))
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


def bill_of_materials(
    design: Design,
    plan: MoldPlan,
    meshes: MoldMeshes,
    patterns: Sequence[FlatPattern],
    silicone: SiliconeData,
) -> tuple[ItemData, ...]:
    """All lines, parts first, then plates, hardware and what is consumed."""
    plates = sum(pattern.count for pattern in patterns)
    gages = design.gages.faces * plates
    wire = design.mold.wire_mm / _BUNDLE[design.gages.leads]
    mixing = mixing_of(design.body.material, design.mold.cure)
    metres = math.ceil(design.gages.leads * plates * WIRE_MM / 1000.0)
    fit = gage_fit(design)
    gage = None if fit is None else fit.found
    rubber, open_ = rubber_words(design), plan.pour == "open"
    return (
        *_lines("parts", design, (*meshes.parts, *meshes.coupon), _extent),
        *_lines("plates", design, patterns, _extent, {each.index for each in cell_plates(plan)}),
        *hardware(plan),
        *_lines("consumed", rubber, design, silicone, mixing, gages, gage, metres, wire, open_),
    )


def _lines(macro: str, *given: Any) -> Iterator[ItemData]:
    """The lines of one of the macros of templates/bill.j2."""
    for line in getattr(macros(TEMPLATES / "bill.j2"), macro)(*given).splitlines():
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
    """How many there are of each different size of a thing."""
    counts = Counter((size[0], *(round(value, 2) for value in size[1:])) for size in sizes)
    return sorted(counts.items())


@dataclass(frozen=True)
class Mixing:
    """Parts A and B by mass; how long it can be poured; how it cures. source: of the numbers;
    known: they are the material's own, not what is usual of its cure."""

    part_a: float
    part_b: float
    pot_life: str
    cure: str
    source: str
    known: bool = True

    def shares(self, mass_g: float) -> tuple[float, float]:
        """Masses of A and B, g, that make ``mass_g``.

        >>> Mixing(10.0, 1.0, "", "", "").shares(11.0)
        (10.0, 1.0)
        """
        whole = self.part_a + self.part_b
        return mass_g * self.part_a / whole, mass_g * self.part_b / whole


_ROOM = "at room temperature"
# Typical figures of the makers' data sheets at about 23 degrees C, by the material's name; then
# what is usual where it is not known by name, which the notes say: to be held against your tin.
MIXINGS: Mapping[str, Mixing] = MappingProxyType(
    {
        "dragon_skin_20": Mixing(1, 1, "25 min", f"4 h {_ROOM}", "Smooth-On"),
        "dragon_skin_30": Mixing(1, 1, "45 min", f"16 h {_ROOM}", "Smooth-On"),
        "sylgard_184": Mixing(10, 1, "1.5 h", f"48 h {_ROOM}, or 4 h at 60 degrees C", "Dow"),
        "platinum": Mixing(
            *(1, 1, "20 to 60 min", f"4 to 24 h {_ROOM}", "usual of platinum silicones", False)
        ),
        "condensation": Mixing(
            *(100, 5, "30 to 90 min", f"24 h {_ROOM}, in moist air", "usual of tin silicones"),
            known=False,
        ),
        "polyurethane": Mixing(
            *(1, 1, "10 to 20 min", f"16 to 24 h {_ROOM}", "usual of casting polyurethanes", False)
        ),
    }
)


def mixing_of(material: str, cure: str) -> Mixing:
    """How a material is mixed, or what is usual of its cure."""
    usual = "polyurethane" if material.startswith("polyurethane") else cure
    return MIXINGS.get(material, MIXINGS[usual])


_ELASTOMERS = ("dragon_skin_20", "dragon_skin_30", "sylgard_184")
_LIKE = 1.25  # of a modulus: batches of one silicone differ as much


def rubber_words(design: Design) -> str:
    """What to buy for the body: its name, or the hardness that its modulus asks for and a silicone
    of that modulus where one is known."""
    name, modulus = design.body.material, design.material_of("body").youngs_modulus_MPa
    if name in MIXINGS:
        return name.replace("_", " ")
    words = (
        f"{name.replace('_', ' ')} of {modulus:g} MPa, Shore A {gent_shore_a(modulus):.0f} or so"
    )
    away, like = min(
        (abs(math.log(MATERIALS[each].youngs_modulus_MPa / modulus)), each) for each in _ELASTOMERS
    )
    if away < math.log(_LIKE):
        words += f" (such as {like.replace('_', ' ')})"
    return words


Up = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
PLATES = "plates"  # all of them, among the names of a view
_VIEW = re.compile(r"\[(put|take) ([+-][xyz]): ([\w ]+)\] *")


@dataclass(frozen=True)
class View:
    """What a step's picture shows: parts (and PLATES, and the rubber) that it puts in their places,
    or that are ``taken`` away, and the axis of mold space that is up on the bench."""

    section: str
    step: int
    up: Up
    taken: bool
    names: tuple[str, ...]

    @property
    def words(self) -> str:
        """What is seen, as a sentence.

        >>> View("Cure and open", 3, "+y", True, ("contact_insert",)).words
        'Step 3 of "Cure and open": contact insert is taken off.'
        """
        names = [name.replace("_", " ") for name in self.names]
        listed = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
        verb = "are" if len(names) > 1 or PLATES in names else "is"
        done = "taken off" if self.taken else "put in place"
        return f'Step {self.step} of "{self.section}": {listed} {verb} {done}.'


def casting_notes(
    design: Design,
    plan: MoldPlan,
    meshes: MoldMeshes,
    patterns: Sequence[FlatPattern],
    silicone: SiliconeData,
) -> tuple[list[dict[str, Any]], list[View]]:
    """Sections of steps, in the order of the work, and what there is to see of them; what this mold
    does not need is left out."""
    bolts = sorted(plan.bolts, key=lambda bolt: str((bolt.size, bolt_length(bolt))))
    trial = cell_plates(plan)
    apart = least_gap(trial)
    bar = next(part for part in meshes.coupon if part.name == COUPON)
    text = macros(TEMPLATES / "notes.j2").notes(
        design=design,
        plan=plan,
        parts=meshes.parts,
        thickness=lambda part: round(float(np.ptp(part.vertices, axis=0).min()), 4),
        patterns=patterns,
        silicone=silicone,
        mixing=mixing_of(design.body.material, design.mold.cure),
        numbers=numbers_text,
        bolts={axis: [bolt_words(bolt) for bolt in bolts if bolt.axis == axis] for axis in "yz"},
        front=WORDS,
        axis_name=axis_name,
        tilt=TILT_DEG,
        form=limits_of(design.mold).form_mm,
        trial=trial,
        gap=None if apart is None else apart.distance,
        bar=round(float(np.ptp(bar.vertices[:, 0])), 3),
    )
    sections = [section.partition("\n") for section in f"\n{text}".split("\n# ")[1:]]
    made: list[dict[str, Any]] = []
    views = []
    for title, _, lines in sections:
        steps = _items(lines)
        for number, step in enumerate(steps, start=1):
            for verb, up, names in _VIEW.findall(step):
                views.append(View(title, number, up, verb == "take", tuple(names.split())))
        if steps:
            made.append({"title": title, "steps": [_VIEW.sub("", step) for step in steps]})
    return made, views


def legs_share(design: Design, plan: MoldPlan) -> float:
    """The legs' volume over that of the finger's outline in mold space, 0 to 1."""
    return plan.legs_volume / (plan.scale**3 * outline_volume(design.body))


def warnings_of(design: Design, plan: MoldPlan, placement: Mapping[str, Any]) -> list[str]:
    """What a caster has to be warned of, found from the design: a sentence each."""
    share, worst = legs_share(design, plan), placement_worst(placement)
    fit = gage_fit(design)
    stock = sheet_words(design)
    if fit is not None and fit.found is not None and fit.unlike(design):
        stock.append(gage_words(design, fit) or "")
    given = design, plan, share, worst, WORDS, bridged_gap(design, plan)
    return stock + _items(macros(TEMPLATES / "notes.j2").warnings(*given))


def bridged_gap(
    design: Design, plan: MoldPlan
) -> tuple[PlateGap, float, float, float, float | None] | None:
    """The closest two plates, where rubber that closes the gap between them keeps the air in it:
    with the pressures of wetting and of buoyancy, Pa, the gap that would let it go, mm, and about
    the pitch of that (None of placed plates and level ones). None where buoyancy is the greater, or
    where the gap is wider than the plates are high: no channel.

    Wetting holds a meniscus across a gap g by 2 gamma / g; a bubble as high as the plate lifts by
    rho g h.
    """
    gap = least_gap(plan.frames)
    if gap is None:
        return None
    frame = next(frame for frame in plan.frames if frame.index == gap.first)
    sine, cosine = (abs(f(math.radians(frame.angle_deg))) for f in (math.sin, math.cos))
    high = frame.length * sine + frame.thickness * cosine
    if not 0.0 < gap.distance < high:
        return None
    wetting = 2.0 * SURFACE_TENSION_N_M / (1e-3 * gap.distance)
    buoyancy = 1e3 * density_of(design) * GRAVITY * 1e-3 * high
    if wetting <= buoyancy:
        return None
    apart = min(high, gap.distance * wetting / buoyancy)
    pitch = None
    if design.plates.placement is None and sine > _STEEP:
        pitch = design.plates.pitch_mm + (apart - gap.distance) / sine
    return gap, wetting, buoyancy, apart, pitch


def placement_worst(placement: Mapping[str, Any] | None) -> float:
    """The greatest change of a reading by plates off their places, over the largest reading; 0
    where it is not known."""
    if placement is None or placement.get("reason") is not None:
        return 0.0
    row = placement.get("row", {"together": {"worst": 0.0}})
    return math.hypot(placement["together"]["worst"], row["together"]["worst"])


def unknown_effect(reason: str) -> dict[str, Any]:
    """The record of plates off their places where there are no numbers."""
    sentence = f"What the plates' tolerance does to the gages is not known: {reason}."
    return {"reason": reason, "sentences": [sentence]}


def effect_sentences(design: Design, found: Mapping[str, Any], row: Mapping[str, Any]) -> list[str]:
    """What the numbers of ``placement.placement_effect`` say: of the plates, of the whole row."""
    guide = design.body.shape not in ("arc", "block") or not design.extruded
    embedded = any(frame.span < design.body.depth_mm - 1e-9 for frame in plate_frames(design))
    return _items(macros(TEMPLATES / "notes.j2").effect(found, row, guide, embedded, percent))


def percent(share: float) -> str:
    """A share in percent, two digits.

    >>> percent(0.0312), percent(1.234)
    ('3.1 %', '120 %')
    """
    value = 100.0 * share
    if value >= 10.0:
        value = round(value, 1 - math.floor(math.log10(value)))
        return f"{value:.0f} %"
    return f"{value:.2g} %"


def _items(text: str) -> list[str]:
    """The items of a list, each from a line that begins with a dash."""
    return [" ".join(item.split()) for item in f"\n{text}".split("\n- ")[1:]]
