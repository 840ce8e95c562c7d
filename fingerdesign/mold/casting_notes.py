"""Casting notes made from the design: what to do, step by step, in words and numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fingerdesign.mold.base_plan import TILT_DEG
from fingerdesign.mold.bill import bolt_length
from fingerdesign.mold.elastomers import mixing_of
from fingerdesign.mold.part import CORE, INSERT, PartMesh, comb_names, wall_name

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.flat_pattern import FlatPattern
    from fingerdesign.mold.plan import BaseHole, Bolt, MoldPlan, Side, SidePlan
    from fingerdesign.mold.silicone import Silicone


_SIDES: dict[str, tuple[Side, Side]] = {"x": ("+x", "-x"), "z": ("+z", "-z")}


@dataclass(frozen=True)
class Notes:
    """One section of the notes: its title and its steps, in order."""

    title: str
    steps: tuple[str, ...]


@dataclass(frozen=True)
class Bench:
    """What the notes are made from."""

    design: Design
    plan: MoldPlan
    parts: Sequence[PartMesh]
    patterns: Sequence[FlatPattern]
    silicone: Silicone

    @property
    def core(self) -> bool:
        """Whether a core is cast in."""
        return any(part.name == CORE for part in self.parts)


def casting_notes(bench: Bench) -> tuple[Notes, ...]:
    """All sections; what this mold does not need is left out."""
    sections = (
        ("Make the parts", _make(bench)),
        ("Clean, cure, test", _prepare(bench)),
        ("Plates and gages", _plates(bench)),
        ("Close the mold", _close(bench)),
        ("Mix and pour", _pour(bench)),
        ("Cure and open", _open(bench)),
        ("Finish and measure", _finish(bench)),
    )
    made = (Notes(title, tuple(steps)) for title, steps in sections)
    return tuple(notes for notes in made if notes.steps)


def _make(bench: Bench) -> Iterator[str]:
    mold = bench.design.mold
    names = [_words(p.name) for p in bench.parts if p.made == "process"]
    how = "Machine" if mold.process == "machined" else "Print"
    yield f"{how} {_listed(names)}."
    if mold.process == "machined":
        yield (
            "The parts' STEP files are exact. Drill and ream the dowel holes of parts that share a "
            "dowel together, where your machine allows it."
        )
    else:
        yield (
            "mold.3mf holds them in millimetres, each on its largest flat face with the side that "
            "forms the finger up; keep supports off that side. The STL files have the same parts "
            "in their places in the closed mold."
        )
    for sheet in (p for p in bench.parts if p.made == "sheet"):
        thick = _thickness(sheet)
        yield f"Cut or etch {_words(sheet.name)} from {thick:g} mm sheet by {sheet.name}.dxf."
    yield from _insert_finish(bench)
    if bench.core and bench.design.body.core is not None:
        material = _words(bench.design.body.core.material)
        yield f"Make the core of {material} by core.step, with its holes; roughen it."


def _insert_finish(bench: Bench) -> Iterator[str]:
    if bench.design.body.shape == "block":
        yield (
            "The finger's contact surface is flat: polish the contact insert, or bond a piece of "
            "glass over its face and make the insert thinner by the glass (mold.insert_mm)."
        )
        return
    steps = {
        "sla": "wet-sand the contact insert's face from 400 to 2000 grit and polish it",
        "fdm": "fill and sand the contact insert's face until no layer line can be felt",
        "machined": "polish the contact insert's face from 600 grit to a mirror",
    }
    step = steps[bench.design.mold.process]
    yield (
        f"The contact surface copies every scratch: {step}. Stay off its rim, where the seam lies."
    )


def _prepare(bench: Bench) -> Iterator[str]:
    mold = bench.design.mold
    if mold.process == "sla":
        yield "Wash the prints twice in fresh isopropanol, 5 min each, and let them dry for 30 min."
        yield "Cure them under ultraviolet light as the resin's maker says, both sides."
    if mold.process == "sla" and mold.cure == "platinum":
        yield (
            "Bake the cured prints for 2 h at 80 degrees C (or what the resin stands): that drives "
            "out what would stop a platinum cure. Then spray a thin barrier coat (acrylic or "
            "polyvinyl alcohol) onto every face that meets silicone."
        )
        yield (
            "Inhibition test: cure a drop of mixed silicone on a print's back. Go on only if it "
            "does not stay tacky against the resin; else bake and coat again."
        )
    elif mold.cure == "platinum":
        yield (
            "Inhibition test: cure a drop of mixed silicone on one part and on the tape you will "
            "use. Sulfur, tin and amines stop a platinum cure: no latex gloves, no sulfur clay."
        )
    yield "Close the mold dry, without plates: every part slides into its place without force."
    yield "Degrease every face with isopropanol; from now on wear nitrile gloves."


def _plates(bench: Bench) -> Iterator[str]:
    design = bench.design
    if not bench.patterns:
        return
    material = _words(design.plates.material)
    for pattern in bench.patterns:
        count = len(pattern.plates)
        bend = (
            ""
            if pattern.bend_radius is None
            else f", bent over a rod to a radius of {pattern.bend_radius:.2f} mm across its axis"
        )
        yield (
            f"Cut {count} of {_words(pattern.name)} (plates {numbers_text(pattern.plates)}) from "
            f"{pattern.thickness:g} mm {material} by plates.dxf{bend}. Deburr; keep them flat."
        )
    yield "Mark each plate's number on a leg: the placement table says where each one goes."
    faces = {"upper": "the upper face", "lower": "the lower face", "both": "both faces"}
    yield (
        f"Bond the gages at the marks of layer GAGES on {faces[design.gages.face]}, with a film as "
        "thin as it gets, and solder the leads at the gage's end toward a leg."
    )
    if design.mold.wire_mm > 0.0:
        yield (
            f"Lead the wires along the leg: its slot has {design.mold.wire_mm:g} mm more length "
            "for them. Seal the joints with a thin coat of lacquer."
        )
    else:
        yield "mold.wire_mm is 0: no slot has room for wires; add the gages' leads elsewhere."
    yield "Check each gage's resistance now: afterwards nothing can be mended."
    yield "Wipe the plates with primer for this elastomer on metal; gages, if their maker agrees."


def _close(bench: Bench) -> Iterator[str]:
    plan = bench.plan
    yield (
        "Release agent, a thin film: contact insert, end walls, side walls, combs or jigs. None on "
        "the base plate, plates or core."
    )
    yield "Primer on the base plate's inner face and in its locks: it stays on the finger."
    screws = _of_kind(plan.base_holes, "screw")
    if bench.core and screws:
        yield f"Screw the core onto the base plate ({len(screws)} screws); prime it."
    yield "Lay the base plate down, keys up."
    yield from _walls(bench, "x")
    yield from _walls(bench, "z")
    if plan.core_pins:
        diameter = plan.core_pins[0].diameter
        yield (
            f"Push the {len(plan.core_pins)} core pins ({diameter:g} mm, greased with release "
            "agent) through the walls into the core until they stop."
        )
    z_bolts = [bolt for bolt in plan.bolts if bolt.axis == "z"]
    y_bolts = [bolt for bolt in plan.bolts if bolt.axis == "y"]
    if z_bolts:
        yield f"Put in {_bolts(z_bolts)} along z, finger-tight."
    yield "Set the contact insert on from above; its pins find the end walls."
    if y_bolts:
        yield f"Put in {_bolts(y_bolts)} along y, finger-tight."
    if z_bolts or y_bolts:
        yield "Tighten crosswise in two rounds, those along z first: snug, no more."
    yield (
        "Look through the gate: each plate stands in its place, no wire touches another. Tape or "
        "clay (sulfur-free) over every slot outside, then turn the mold over: base up."
    )


def _walls(bench: Bench, axis: str) -> Iterator[str]:
    """The two walls of an axis, with the plates that they or their sheets hold."""
    first, second = (bench.plan.side(side) for side in _SIDES[axis])
    names = [_words(wall_name(side.side)) for side in (first, second)]
    onto = "against the middle" if axis == "x" else "onto the pins of the side walls"
    if not (first.slots or second.slots):
        yield f"Slide {_listed(names)} along their keys {onto}."
        return
    for number, side in enumerate((first, second)):
        sheets = _listed([_words(name) for name in comb_names(side.side, side.holding)])
        holder, place = (sheets, " onto the pins") if sheets else (names[number], f" {onto}")
        if not side.slots:
            yield f"Slide {names[number]} along its keys {onto}."
            continue
        legs = f"{_count(len(side.slots), 'leg')}, by the plates' numbers,"
        if number == 0:
            yield f"Slide {holder}{place if axis == 'z' else ''}."
            yield f"From the other side, push the {legs} into the slots of {holder}."
        else:
            yield f"Thread {holder} over the {legs} one by one, then slide it{place}."
        yield from _held(side)
    if first.holding in ("comb", "jig") or second.holding in ("comb", "jig"):
        yield (
            f"Slide {_listed(names)} along their keys {onto}, up to the sheets; lead tabs and "
            "wires out through the windows."
        )


def _held(side: SidePlan) -> Iterator[str]:
    if side.holding == "jig" and side.shift > 0.0:
        yield (
            f"Shift the outer sheet by {side.shift:g} mm along the plates' normal, until they are "
            "clamped."
        )
    shims = sorted({round(slot.shim, 3) for slot in side.slots if slot.shim > 0.0})
    if shims:
        sizes = _listed([f"{shim:g}" for shim in shims])
        yield f"Push a {sizes} mm shim into each slot, on the plate's lower side."


def _pour(bench: Bench) -> Iterator[str]:
    design, silicone, plan = bench.design, bench.silicone, bench.plan
    mixing, known = mixing_of(design.body.material, design.mold.cure)
    a, b = mixing.shares(silicone.mass_g)
    least = "" if silicone.mass_g >= 10.0 else " (mix more if your scale is no better than 0.1 g)"
    doubt = "" if known else f" These are {mixing.source}: take your data sheet's ratio."
    yield (
        f"Weigh {a:.2f} g of A and {b:.2f} g of B ({mixing.part_a:g} : {mixing.part_b:g} by mass; "
        f"{silicone.mass_g:.1f} g, {silicone.mixed_cm3:.1f} cm^3, {design.mold.excess:.0%} more "
        f"than the mold takes){least}.{doubt}"
    )
    yield (
        "Mix slowly for 3 min, scrape the walls, mix again in a second cup. It can be poured for "
        f"{mixing.pot_life}."
    )
    yield (
        "De-air at 1 kPa or less until the froth has risen, fallen and stayed down for 2 min, in "
        "a cup of four times the volume. Without a pump: pour a stream as thin as a thread from "
        "30 cm."
    )
    gates, risers = _of_kind(plan.base_holes, "gate"), _of_kind(plan.base_holes, "riser")
    vents = _of_kind(plan.base_holes, "vent")
    tilt = f", so that the vent at {_place(vents[0])} is highest" if vents else ""
    at = f" ({_listed([_place(hole) for hole in gates])})" if gates else ""
    yield (
        f"Tilt the mold by {TILT_DEG:g} degrees{tilt}. Pour in at the gate{at}, a thin stream, "
        "slowly and without stopping: the silicone must rise from below, along the plates."
    )
    yield (
        f"Go on until it stands in {_count(len(risers), 'riser')} and "
        f"{_count(len(vents), 'vent')}; close with tape what runs over early. Tilt the mold toward "
        "each vent in turn, tap it for a minute, set it level and top it up. If you have a pump: "
        "de-air the filled mold once more at 5 kPa."
    )


def _open(bench: Bench) -> Iterator[str]:
    mixing, known = mixing_of(bench.design.body.material, bench.design.mold.cure)
    doubt = "" if known else f" ({mixing.source}: see your data sheet)"
    yield f"Cure level, base up: {mixing.cure}{doubt}. A drop beside the mold tells when."
    if bench.design.mold.process == "fdm":
        yield "Keep below 45 degrees C: filament prints creep, and the plates' places with them."
    yield "Take out all bolts."
    if bench.plan.core_pins:
        yield "Pull the core pins, turning them."
    order: dict[int, list[PartMesh]] = {}
    for part in bench.parts:
        if part.draw is not None:
            order.setdefault(part.order, []).append(part)
    for _, parts in sorted(order.items()):
        for part in parts:
            yield f"Draw {_words(part.name)} {_direction(part)}, straight, without turning."
    yield "The base plate stays on the finger: it is its base."


def _finish(bench: Bench) -> Iterator[str]:
    plan, mold = bench.plan, bench.design.mold
    yield "Trim silicone in gate, risers and vents flush with the base plate's back."
    if plan.legs:
        yield (
            "Cut the legs flush with the rubber with sharp cutters, wires kept; do not pull. Seal "
            "the cut ends with a drop of silicone."
        )
    if plan.core_pins:
        yield f"Fill the {len(plan.core_pins)} tunnels of the core pins with mixed silicone; cure."
    s = mold.shrinkage_used
    if s > 0.0:
        yield (
            f"The mold is {plan.scale:.4f} times the finger's size, for a shrinkage of {s:.1%}. "
            "Measure width and height after a week; set mold.shrinkage to what you found."
        )
    else:
        yield (
            "The mold has the finger's size: no shrinkage is allowed for. A hot cure shrinks by "
            "about 0.1 % for each 4 K above room temperature; measure, and set mold.shrinkage."
        )
    body = bench.design.body
    yield f"Measure: {body.width_mm:g} mm wide, {body.depth_mm:g} mm deep at the base."
    if bench.patterns:
        yield "Check each gage's resistance again, press, calibrate: each plate reads its own way."


def _bolts(bolts: Sequence[Bolt]) -> str:
    sizes = sorted({(bolt.size, bolt_length(bolt)) for bolt in bolts}, key=str)
    told = [f"{s} x {n}" if n is not None else f"{s} threaded rod" for s, n in sizes]
    return f"the {len(bolts)} bolts ({_listed(told)}), a washer under head and nut,"


def _direction(part: PartMesh) -> str:
    x, y, z = part.draw or (0.0, 0.0, 0.0)
    names = {"+x": x, "-x": -x, "+y": y, "-y": -y, "+z": z, "-z": -z}
    name = max(names, key=lambda key: names[key])
    if part.name == INSERT:
        return f"off the contact surface ({name}; it looks down while the base is up)"
    return f"outward along {name}"


def _thickness(sheet: PartMesh) -> float:
    extent = sheet.vertices.max(axis=0) - sheet.vertices.min(axis=0)
    return round(float(extent.min()), 4)


def _of_kind(holes: Sequence[BaseHole], kind: str) -> list[BaseHole]:
    return [hole for hole in holes if hole.kind == kind]


def _place(hole: BaseHole) -> str:
    return f"x = {hole.x:.1f}, z = {hole.z:.1f} mm"


def _count(number: int, what: str) -> str:
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"


def numbers_text(plates: Sequence[int]) -> str:
    """Whole numbers, runs shortened.

    >>> numbers_text([0, 1, 2, 5, 7, 8])
    '0-2, 5, 7-8'
    """
    runs: list[list[int]] = []
    for plate in sorted(plates):
        if runs and plate == runs[-1][-1] + 1:
            runs[-1].append(plate)
        else:
            runs.append([plate])
    return ", ".join(str(r[0]) if len(r) == 1 else f"{r[0]}-{r[-1]}" for r in runs)


def _listed(words: Sequence[str]) -> str:
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} and {words[-1]}"


def _words(name: str) -> str:
    return name.replace("_", " ")
