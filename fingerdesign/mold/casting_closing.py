"""Casting notes of closing the mold: walls and plates in the order in which two hands can do it.

The walls' pins run along z, so the walls are put together upright, on the back end wall; the frame
that they make is set onto the base plate's keys. Without such pins they stand on the base plate
inside a rubber band until the insert's pins find them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from fingerdesign.mold.bill import bolt_length
from fingerdesign.mold.casting_bench import Bench, count_text, listed, numbers_text, of_kind, words
from fingerdesign.mold.part import INSERT, comb_names, wall_name

if TYPE_CHECKING:
    from fingerdesign.mold.plan import Bolt, Side, SidePlan

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
    told = "the core pin" if len(pins) == 1 else f"the {len(pins)} core pins"
    return f"{told} ({diameter:g} mm, with release agent)"


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
    told = [f"{s} x {n}" if n is not None else f"{s} threaded rod" for s, n in sizes]
    return f"the {len(bolts)} bolts ({listed(told)}), a washer under head and nut,"
