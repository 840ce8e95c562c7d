"""Casting notes from the cup to the finger: mix, pour, cure, open, finish."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from fingerdesign.mold.base_plan import TILT_DEG
from fingerdesign.mold.casting_bench import Bench, count_text, listed, of_kind, words
from fingerdesign.mold.elastomers import mixing_of
from fingerdesign.mold.part import INSERT, PartMesh

if TYPE_CHECKING:
    from fingerdesign.mold.plan import BaseHole

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
    told = ", ".join(f"{words(part.name)} ({_axis(part)})" for part in rest)
    if rest:
        yield f"Draw, each straight outward, in this order: {told}."
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
