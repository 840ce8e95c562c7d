"""Casting notes made from the design: what to do, step by step, in words and numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

from fingerdesign.mold.part import INSERT, PartMesh, comb_names, wall_name
from fingerdesign.mold.plan.base import TILT_DEG
from fingerdesign.mold.products.bill import bolt_length
from fingerdesign.mold.products.preparation import (
    Bench,
    count_text,
    listed,
    making,
    numbers_text,
    of_kind,
    plates_and_gages,
    preparing,
    words,
)

if TYPE_CHECKING:
    from fingerdesign.mold.plan.plan import BaseHole, Bolt, Side, SidePlan


# Casting notes of closing the mold: walls and plates in the order in which two hands can do it.
#
# The walls' pins run along z, so the walls are put together upright, on the back end wall; the
# frame that they make is set onto the base plate's keys. Without such pins they stand on the base
# plate inside a rubber band until the insert's pins find them.

# The side that is put down first, and the one that leads come out of, last.
_PAIRS: dict[str, tuple[Side, Side]] = {"x": ("-x", "+x"), "z": ("-z", "+z")}


def closing(bench: Bench) -> Iterator[str]:
    """From bare parts to a closed mold, base up."""
    plan = bench.plan
    sheets = {side.holding for side in plan.sides} & {"comb", "jig"}
    coated = ["contact insert", "end walls", "side walls", *sorted(f"{name}s" for name in sheets)]
    bare = ["base plate", *(["plates"] if plan.frames else []), *(["core"] if bench.core else [])]
    yield f"Release agent, a thin film: {listed(coated)}. None on {listed(bare)}."
    yield "Primer on the base plate's inner face and in its locks: it stays on the finger."
    screws = of_kind(plan.base_holes, "screw")
    if bench.core and screws:
        yield f"Screw the core onto the base plate ({count_text(len(screws), 'screw')}); prime it."
    z_bolts = [bolt for bolt in plan.bolts if bolt.axis == "z"]
    y_bolts = [bolt for bolt in plan.bolts if bolt.axis == "y"]
    yield from _flanks(bench)
    yield from _frame(bench)
    if z_bolts:
        parts = "walls and sheets" if sheets else "the walls"
        yield f"Put in {_bolts(z_bolts)} along z, finger-tight: {parts} now hold together."
    else:
        yield "Put a rubber band around the four walls, until the insert is bolted on."
    if plan.keys:
        yield (
            "Lay the base plate down, keys up, and lower the walls onto it, base side down, until "
            "the keys are in the end walls' grooves; the side walls have none."
        )
    else:
        yield "Lay the base plate down, inner face up, and lower the walls onto it, base side down."
    yield from _shims(bench)
    if plan.legs:
        yield "Look from above: each plate is in its place, no wire touches another or the surface."
    if any(pin.on == INSERT for pin in plan.pins):
        into = sorted({words(pin.into) for pin in plan.pins if pin.on == INSERT})
        yield f"Set the contact insert on from above; its pins find {listed(into)}."
    else:
        yield "Set the contact insert on from above."
    if y_bolts:
        yield f"Put in {_bolts(y_bolts)} along y, finger-tight."
    if z_bolts or y_bolts:
        yield "Tighten crosswise in two rounds, those along z first: snug, no more."
    yield (
        "Tape or clay (sulfur-free) over every opening but those of the base, and around the wires "
        "where they come out; turn it: base up."
    )


def _flanks(bench: Bench) -> Iterator[str]:
    """The side walls, where plates stand between them: a packet before all else."""
    left, right = (bench.plan.side(side) for side in _PAIRS["x"])
    if not (left.slots or right.slots):
        return
    if left.slots:
        yield f"Lay side wall left on the bench, inner face up{_with_sheets(left)}."
        yield _pushed(left)
    if right.slots:
        yield from _threaded(right, held=bool(left.slots))
    yield "Set side wall right over them and hold both side walls together with a rubber band."


def _frame(bench: Bench) -> Iterator[str]:
    """The four walls, upright on the back end wall, with the plates that the end walls hold."""
    plan = bench.plan
    back, front = (plan.side(side) for side in _PAIRS["z"])
    upright = [pin for pin in plan.pins if abs(pin.direction[2]) > 0.5]
    flanks = plan.side("+x").slots or plan.side("-x").slots
    back_pins = [pin for pin in plan.core_pins if pin.side == "-z"]
    front_pins = [pin for pin in plan.core_pins if pin.side == "+z"]
    yield f"Lay end wall back on the bench, inner face up{_with_sheets(back)}."
    if back_pins:
        pushed = f"push {_core_pins(back_pins)} through it from below until {_stop(back_pins)}"
        yield f"Rest it on two blocks and {pushed}."
    both = "the packet of side walls" if flanks else "side wall right and left"
    if upright:
        yield f"Stand {both} on it, base side toward you: their pins go into its sockets."
    else:
        yield f"Stand {both} on it, base side toward you, flush at the base; hold them by a band."
    if bench.core and plan.core_pins:
        on = ", onto the pin" + ("s" if len(back_pins) > 1 else "") if back_pins else ""
        yield f"Prime the core and put it between the side walls{on}."
    if back.slots:
        yield _pushed(back)
    if front.slots:
        yield from _threaded(front, held=bool(back.slots))
    onto = "over the side walls' pins" if upright else "against the side walls"
    if front.holding == "slots":
        yield f"Lower end wall front all the way, {onto}, drawing the wires after."
    else:
        lead = ", legs and wires into its window and out" if front.slots else ""
        yield f"Set end wall front on from above {onto}{lead}."
    if front_pins:
        yield f"Push {_core_pins(front_pins)} through it into the core until {_stop(front_pins)}."
    flank_pins = [pin for pin in plan.core_pins if pin.side.endswith("x")]
    if flank_pins:
        yield f"Push {_core_pins(flank_pins)} through the side walls into the core until they stop."


def _core_pins(pins: Sequence[object]) -> str:
    diameter = getattr(pins[0], "diameter", 0.0)
    reported = "the core pin" if len(pins) == 1 else f"the {len(pins)} core pins"
    return f"{reported} ({diameter:g} mm, with release agent)"


def _stop(pins: Sequence[object]) -> str:
    return "it stops" if len(pins) == 1 else "they stop"


def _with_sheets(side: SidePlan) -> str:
    sheets = [words(sheet) for sheet in comb_names(side.side, side.holding)]
    if not sheets:
        return ""
    if len(sheets) == 1:
        return f", and {sheets[0]} on it"
    return (
        f", and {listed(sheets)} on it, their slots together: each {side.shift:.3g} mm off its "
        "place along the plates' normal"
    )


def _pushed(side: SidePlan) -> str:
    """Plates into the slots of the side that lies on the bench."""
    numbers = numbers_text([slot.plate for slot in side.slots])
    wires = ", end without wires first" if any(s.wire > 0.0 for s in side.slots) else ""
    step = f"From above, push plates {numbers} into their slots there, each into its own{wires}."
    return step + (f" {_CLAMP}" if side.holding == "jig" else "")


_CLAMP = (
    "Shift the sheets until their holes fall together: that clamps the plates, and pins that bear "
    "on the holes' sides keep it so."
)


def _threaded(side: SidePlan, held: bool) -> Iterator[str]:
    """What holds a side over the ends of plates; ``held``: they stand in the other side's."""
    wall = words(wall_name(side.side))
    sheets = [words(sheet) for sheet in comb_names(side.side, side.holding)]
    holder = listed(sheets) or wall
    numbers = numbers_text([slot.plate for slot in side.slots])
    if any(slot.wire > 0.0 for slot in side.slots):
        yield (
            f"Each plate's bundle of wires first: through the round relief of its slot in {holder},"
            " before its leg. No connector is on them yet."
        )
    apart = f" ({_with_sheets(side).split(' on it, ')[1]})" if len(sheets) > 1 else ""
    if held:
        yield f"Thread {holder}{apart} over the plates' other ends, one by one."
    else:
        yield f"Put plates {numbers} into the slots of {holder}{apart}, each into its own."
    if len(sheets) > 1:
        yield _CLAMP


def _shims(bench: Bench) -> Iterator[str]:
    """Shims by what each slot really measures, from outside."""
    slots = [slot for side in bench.plan.sides for slot in side.slots if slot.shim > 0.0]
    if not slots:
        return
    sizes = listed([f"{size:g}" for size in sorted({round(slot.shim, 3) for slot in slots})])
    yield (
        "Measure the gap beside each leg with feeler stock; a slot comes out wider or narrower "
        f"than drawn, where {sizes} mm would fill it. From outside, push the thickest shim that "
        "slides in without force beside each leg, on the plate's lower side; leave its end "
        "standing out, to be pulled by."
    )


def _bolts(bolts: Sequence[Bolt]) -> str:
    sizes = sorted({(bolt.size, bolt_length(bolt)) for bolt in bolts}, key=str)
    reported = [f"{s} x {n}" if n is not None else f"{s} threaded rod" for s, n in sizes]
    return f"the {len(bolts)} bolts ({listed(reported)}), a washer under head and nut,"


# How elastomers are mixed and cured: their makers' usual advice, to be held against your tin.


@dataclass(frozen=True)
class Mixing:
    """Parts A and B by mass; how long it can be poured; how it cures. source: of the numbers."""

    part_a: float
    part_b: float
    pot_life: str
    cure: str
    source: str

    def shares(self, mass_g: float) -> tuple[float, float]:
        """Masses of A and B, g, that make ``mass_g``.

        >>> Mixing(10.0, 1.0, "", "", "").shares(11.0)
        (10.0, 1.0)
        """
        whole = self.part_a + self.part_b
        return mass_g * self.part_a / whole, mass_g * self.part_b / whole


# Typical figures of the makers' data sheets at about 23 degrees C.
KNOWN: Mapping[str, Mixing] = MappingProxyType(
    {
        "dragon_skin_20": Mixing(1, 1, "25 min", "4 h at room temperature", "Smooth-On"),
        "dragon_skin_30": Mixing(1, 1, "45 min", "16 h at room temperature", "Smooth-On"),
        "sylgard_184": Mixing(
            10, 1, "1.5 h", "48 h at room temperature, or 4 h at 60 degrees C", "Dow"
        ),
    }
)
# What is usual where the material is not known by name: said to be so in the notes.
USUAL: Mapping[str, Mixing] = MappingProxyType(
    {
        "platinum": Mixing(
            1, 1, "20 to 60 min", "4 to 24 h at room temperature", "usual of platinum silicones"
        ),
        "condensation": Mixing(
            100,
            5,
            "30 to 90 min",
            "24 h at room temperature, in moist air",
            "usual of tin silicones",
        ),
    }
)
POLYURETHANE = Mixing(
    1, 1, "10 to 20 min", "16 to 24 h at room temperature", "usual of casting polyurethanes"
)


def mixing_of(material: str, cure: str) -> tuple[Mixing, bool]:
    """How a material is mixed, and whether it is known by name (else what is usual of its cure)."""
    known = KNOWN.get(material)
    if known is None and material.startswith("polyurethane"):
        return POLYURETHANE, False
    return (known, True) if known is not None else (USUAL[cure], False)


# Casting notes from the cup to the finger: mix, pour, cure, open, finish.

LEAST_G = 10.0  # what is mixed well in a cup and weighed to 1 % on a scale of 0.1 g


def pouring(bench: Bench) -> Iterator[str]:
    """Weigh, mix, de-air, pour, let the air out."""
    design, silicone, plan = bench.design, bench.silicone, bench.plan
    mixing, known = mixing_of(design.body.material, design.mold.cure)
    a, b = mixing.shares(silicone.mass_g)
    least = ""
    if silicone.mass_g < LEAST_G:
        more = " and ".join(f"{part:.1f} g" for part in mixing.shares(LEAST_G))
        least = f" So little is hard to weigh and mix: take {more}, and leave the rest."
    doubt = "" if known else f" These are {mixing.source}: take your data sheet's ratio."
    yield (
        f"Weigh {a:.2f} g of A and {b:.2f} g of B ({mixing.part_a:g} : {mixing.part_b:g} by mass; "
        f"{silicone.mass_g:.1f} g, {silicone.mixed_cm3:.1f} cm³, {100 * design.mold.excess:g} % "
        f"more than the mold takes).{least}{doubt}"
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
    gates, risers = of_kind(plan.base_holes, "gate"), of_kind(plan.base_holes, "riser")
    vents = of_kind(plan.base_holes, "vent")
    tilt = f", so that the vent at {_place(vents[0])} is highest" if vents else ""
    at = f" ({listed([_place(hole) for hole in gates])})" if gates else ""
    yield (
        f"Tilt the mold by {TILT_DEG:g} degrees{tilt}. Pour in at the gate{at}, a thin stream, "
        "slowly and without stopping: it must rise from below, along the plates. The plan of the "
        "base plate in the report shows each hole as you see it."
    )
    locks = of_kind(plan.base_holes, "lock")
    if locks:
        yield (
            f"It rises in the {count_text(len(locks), 'lock')}, too: they are through holes, wider "
            "at the back. Let them fill, and leave them open; cured, they hold the finger."
        )
    yield (
        f"Go on until it stands in {count_text(len(risers), 'riser')} and "
        f"{count_text(len(vents), 'vent')}; close with tape what runs over early. Tilt the mold "
        "toward each vent in turn, tap it for a minute, set it level and top it up. If you have a "
        "pump: de-air the filled mold once more at 5 kPa."
    )


def opening(bench: Bench) -> Iterator[str]:
    """Cure, and take the parts off in their order."""
    mixing, known = mixing_of(bench.design.body.material, bench.design.mold.cure)
    doubt = "" if known else f" ({mixing.source}: see your data sheet)"
    yield f"Cure level, base up: {mixing.cure}{doubt}. A drop beside the mold tells when."
    if bench.design.mold.process == "fdm":
        yield "Keep below 45 degrees C: filament prints creep, and the plates' places with them."
    yield "Take out all bolts."
    if bench.plan.core_pins:
        yield "Pull the core pins, turning them."
    yield "Turn the mold over: contact insert up."
    drawn = [part for part in bench.parts if part.draw is not None]
    drawn.sort(key=lambda part: part.order)
    for part in drawn:
        if part.name == INSERT:
            yield f"Draw {words(part.name)} {_direction(part)}, straight, without turning."
    slots = [slot for side in bench.plan.sides for slot in side.slots]
    if any(slot.wire > 0.0 for slot in slots):
        yield (
            "Take tape and clay off the wires and straighten them: wall and sheet slide off along "
            "them. They must have no connector yet."
        )
    if any(slot.shim > 0.0 for slot in slots):
        yield "Pull every shim out of its slot before a wall is drawn."
    rest = [part for part in drawn if part.name != INSERT]
    reported = ", ".join(f"{words(part.name)} ({_axis(part)})" for part in rest)
    if rest:
        yield f"Draw, each straight outward, in this order: {reported}."
    yield "The base plate stays on the finger: it is its base."


def finishing(bench: Bench) -> Iterator[str]:
    """Trim, fill, measure."""
    plan, mold = bench.plan, bench.design.mold
    yield (
        f"Trim the {bench.elastomer} in gate, risers, vents and locks flush with the base plate's "
        "back."
    )
    if plan.legs:
        yield (
            "Cut the legs flush with the rubber with sharp cutters, wires kept; do not pull. Seal "
            f"the cut ends with a drop of {bench.elastomer}."
        )
    if plan.core_pins:
        count = len(plan.core_pins)
        yield f"Fill the {count} tunnels of the core pins with mixed {bench.elastomer}; cure."
    s = mold.shrinkage_used
    if s > 0.0:
        yield (
            f"The mold is {plan.scale:.4f} times the finger's size, for a shrinkage of "
            f"{100 * s:g} %. "
            "Measure width and height after a week; set mold.shrinkage to what you found."
        )
    else:
        yield (
            "The mold has the finger's size: no shrinkage is allowed for. A hot cure shrinks by "
            "about 0.1 % for each 4 K above room temperature; measure, and set mold.shrinkage."
        )
    body = bench.design.body
    yield (
        f"Measure: {body.width_mm:g} mm wide, {body.depth_mm:g} mm deep at the base, "
        f"{plan.crest / plan.scale:.2f} mm high."
    )
    if bench.patterns:
        yield (
            "Put the connectors on, check each gage's resistance again, press, calibrate: each "
            "plate reads its own way."
        )


def _axis(part: PartMesh) -> str:
    x, y, z = part.draw or (0.0, 0.0, 0.0)
    names = {"+x": x, "-x": -x, "+y": y, "-y": -y, "+z": z, "-z": -z}
    return max(names, key=lambda key: names[key])


def _direction(part: PartMesh) -> str:
    return f"upward, off the contact surface ({_axis(part)})"


def _place(hole: BaseHole) -> str:
    return f"x = {hole.x:.1f}, z = {hole.z:.1f} mm"


@dataclass(frozen=True)
class Notes:
    """One section of the notes: its title and its steps, in order."""

    title: str
    steps: tuple[str, ...]


def casting_notes(bench: Bench) -> tuple[Notes, ...]:
    """All sections; what this mold does not need is left out."""
    sections = (
        ("Make the parts", making(bench)),
        ("Clean, cure, test", preparing(bench)),
        ("Plates and gages", plates_and_gages(bench)),
        ("Close the mold", closing(bench)),
        ("Mix and pour", pouring(bench)),
        ("Cure and open", opening(bench)),
        ("Finish and measure", finishing(bench)),
    )
    made = (Notes(title, tuple(steps)) for title, steps in sections)
    return tuple(notes for notes in made if notes.steps)
