"""Casting notes of closing the mold: walls and plates in the order in which they fit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from fingerdesign.mold.bill import bolt_length
from fingerdesign.mold.casting_bench import Bench, listed, numbers_text, of_kind, words
from fingerdesign.mold.part import comb_names, wall_name

if TYPE_CHECKING:
    from fingerdesign.mold.plan import Bolt, Side, SidePlan

_SIDES: dict[str, tuple[Side, Side]] = {"x": ("+x", "-x"), "z": ("+z", "-z")}


def closing(bench: Bench) -> Iterator[str]:
    """From the bare base plate to a closed mold, base up."""
    plan = bench.plan
    sheets = {side.holding for side in plan.sides} & {"comb", "jig"}
    coated = ["contact insert", "end walls", "side walls", *sorted(f"{name}s" for name in sheets)]
    bare = ["base plate", *(["plates"] if plan.frames else []), *(["core"] if bench.core else [])]
    yield f"Release agent, a thin film: {listed(coated)}. None on {listed(bare)}."
    yield "Primer on the base plate's inner face and in its locks: it stays on the finger."
    screws = of_kind(plan.base_holes, "screw")
    if bench.core and screws:
        yield f"Screw the core onto the base plate ({len(screws)} screws); prime it."
    yield "Lay the base plate down, keys up."
    yield from _walls(bench, "x")
    if plan.core_pins:
        yield "Prime the core and lay it between the side walls."
    yield from _walls(bench, "z")
    if plan.core_pins:
        diameter = plan.core_pins[0].diameter
        yield (
            f"Lift the core and push the {len(plan.core_pins)} core pins ({diameter:g} mm, greased "
            "with release agent) through the walls into its holes until they stop."
        )
    z_bolts = [bolt for bolt in plan.bolts if bolt.axis == "z"]
    y_bolts = [bolt for bolt in plan.bolts if bolt.axis == "y"]
    if z_bolts:
        yield f"Put in {_bolts(z_bolts)} along z, finger-tight."
    if plan.legs:
        yield "Look from above: each plate is in its place, no wire touches another or the surface."
    yield "Set the contact insert on from above; its pins find the end walls."
    if y_bolts:
        yield f"Put in {_bolts(y_bolts)} along y, finger-tight."
    if z_bolts or y_bolts:
        yield "Tighten crosswise in two rounds, those along z first: snug, no more."
    yield "Tape or clay (sulfur-free) over every opening but those of the base; turn it: base up."


def _walls(bench: Bench, axis: str) -> Iterator[str]:
    """The two walls of an axis, with the plates that they or their sheets hold."""
    first, second = (bench.plan.side(side) for side in _SIDES[axis])
    names = [words(wall_name(side.side)) for side in (first, second)]
    onto = "against the middle" if axis == "x" else "onto the pins of the side walls"
    if not (first.slots or second.slots):
        yield f"Slide {listed(names)} along their keys {onto}."
        return
    threaded = False
    for name, side in zip(names, (first, second), strict=True):
        if not side.slots:
            yield f"Slide {name} along its keys {onto}."
            continue
        yield from _threaded(side, name, onto, axis, threaded)
        threaded = True
    if first.holding in ("comb", "jig") or second.holding in ("comb", "jig"):
        yield (
            f"Slide {listed(names)} along their keys {onto}, up to the sheets; lead tabs and "
            "wires out through the windows."
        )


def _threaded(side: SidePlan, wall: str, onto: str, axis: str, held: bool) -> Iterator[str]:
    """Plates into what holds them at a side; ``held``: they stand in the other side's already."""
    numbers = numbers_text([slot.plate for slot in side.slots])
    sheets = [words(sheet) for sheet in comb_names(side.side, side.holding)]
    jig = len(sheets) > 1
    it, its = ("them", "their") if jig else ("it", "its")
    holder = listed(sheets) or wall
    place = f"slide {it} along {its} keys {onto}"
    if sheets:
        place = f"set {it} on {its} place" if axis == "x" else f"slide {it} {onto}"
    if jig:
        yield (
            f"Lay {holder} on each other so that their slots fall together, "
            f"{2.0 * side.shift:.3g} mm off their places along the plates' normal."
        )
    if held:
        after = "" if jig else f"; {place}"
        yield f"Thread {holder} over the plates' other ends, one by one{after}."
    else:
        if not jig:
            yield f"Take {holder}: {place}."
        yield f"From the other side, push plates {numbers} into {its} slots, each into its own."
    if jig:
        yield f"Shift the sheets until their holes fall together: that clamps the plates; {place}."
    shims = sorted({round(slot.shim, 3) for slot in side.slots if slot.shim > 0.0})
    if shims:
        sizes = listed([f"{shim:g}" for shim in shims])
        yield f"Push a {sizes} mm shim into each slot, on the plate's lower side."


def _bolts(bolts: Sequence[Bolt]) -> str:
    sizes = sorted({(bolt.size, bolt_length(bolt)) for bolt in bolts}, key=str)
    told = [f"{s} x {n}" if n is not None else f"{s} threaded rod" for s, n in sizes]
    return f"the {len(bolts)} bolts ({listed(told)}), a washer under head and nut,"
