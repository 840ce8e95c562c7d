"""What a caster has to be warned of, found from the design: one sentence each, with its remedy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from fingerdesign.mold.part import WORDS

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.plan.plan import MoldPlan

LEGS_SHARE = 1e-3  # of the body; above it legs in the rubber are no longer nothing
DOUBTFUL_SHARE = 0.5  # of the largest reading; above it the fixture does not place the gages
PLACEMENT_SHARE = 0.1  # of the largest reading; above it a plate's place decides what it reads
THIN_MM = 0.05  # foil that bends under a finger


def warnings_of(
    design: Design, plan: MoldPlan, legs_share: float, placement: dict[str, Any]
) -> tuple[str, ...]:
    """All warnings. legs_share: the volume of legs in the rubber over the body's."""
    return (
        *_chemistry(design),
        *_surface(design),
        *_fixture(design, plan, legs_share),
        *_placement(placement),
        *_shrinkage(design),
    )


def _chemistry(design: Design) -> Iterator[str]:
    mold = design.mold
    if design.body.material.startswith("polyurethane"):
        yield (
            "Polyurethane bonds to prints and metals: release agent on every face but the base, "
            "and dry parts, or it foams."
        )
        return
    if mold.cure == "platinum":
        yield (
            "Solder flux, epoxies with amine hardeners, sulfur and tin stop a platinum cure where "
            "they touch it: wash joints, seal glue lines, no latex gloves, no sulfur clay."
        )
    if mold.process == "sla" and mold.cure == "platinum":
        yield (
            "Resin prints can stop the cure of platinum silicone: wash, cure and bake them, spray "
            "a barrier coat, and test with a drop first; or set mold.process = 'machined'."
        )


def _surface(design: Design) -> Iterator[str]:
    if design.mold.process == "fdm":
        yield (
            "Filament prints leave their layers on the contact surface: fill, sand and polish the "
            "contact insert, or make it alone by another process."
        )
    yield (
        "Air: de-air the mixed elastomer, or pour a thread of it; bubbles under plates change what "
        "their gages read."
    )


def _fixture(design: Design, plan: MoldPlan, legs_share: float) -> Iterator[str]:
    requested = design.mold.plate_fixture
    other = [side for side in plan.sides if side.slots and side.holding != requested]
    for side in other:
        yield (
            f"Plates are held by {side.holding} at the {WORDS[side.side]} ({side.side}), not by "
            f"mold.plate_fixture = {requested!r}: they do not leave through one flat face there."
        )
    if any(slot.shim > 0.0 for side in plan.sides for slot in side.slots):
        yield (
            "Slots are wider than the plates: without their shims the plates stand where they like."
        )
    if legs_share > LEGS_SHARE:
        yield (
            f"Legs of the plates take {100 * legs_share:.2f} % of the rubber's place and stay in "
            "it: the model does not know them; mold.leg_mm makes them narrower."
        )
    if design.plates.number and design.plates.thickness_mm < THIN_MM:
        yield (
            f"Plates of {design.plates.thickness_mm:g} mm bend in handling: bond the gages while "
            "they lie on a flat carrier."
        )
    if plan.core_pins:
        yield (
            "The core hangs on pins while the rubber cures: their tunnels have to be filled, and "
            "are weaker than the rest."
        )


def placement_worst(placement: dict[str, Any] | None) -> float:
    """The greatest change of a reading by plates off their places, over the largest reading; 0
    where it is not known."""
    if placement is None or placement.get("reason") is not None:
        return 0.0
    row = placement.get("row", {"together": {"worst": 0.0}})
    return math.hypot(placement["together"]["worst"], row["together"]["worst"])


def placement_remedy(holdings: Iterable[str]) -> str:
    """What to change where plates are not placed well, by what holds them at any side."""
    held = set(holdings)
    ways = ["give the plates wider legs (mold.leg_mm)", "a longer span"]
    if "slots" in held:
        ways.append("a flat face to leave through, so that a comb can hold them")
    elif "jig" in held:
        ways.append("a comb (mold.plate_fixture)")
    elif "comb" in held:
        ways.append("a finer comb ([mold.comb])")
    return f"{', '.join(ways[:-1])} or {ways[-1]}"


def _placement(placement: dict[str, Any]) -> Iterator[str]:
    worst = placement_worst(placement)
    if worst > PLACEMENT_SHARE:
        yield (
            f"Plates off their places by what fixture and pins allow change a reading by up to "
            f"{100 * worst:.0f} % of the largest: calibrate each finger after it is cast."
        )


def _shrinkage(design: Design) -> Iterator[str]:
    if design.mold.shrinkage is None and design.mold.shrinkage_used > 0.0:
        yield (
            f"Shrinkage is assumed to be {100 * design.mold.shrinkage_used:g} %: it goes with "
            "batch and shape; cast a test piece and set mold.shrinkage."
        )
