"""How each side is closed and holds the plates: slots, windows behind combs, plugs between legs.

Numbers only; mm. What cannot be held is a fault of fixture_faults.py.
"""

from __future__ import annotations

import math

import numpy as np

from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.plan import slots
from fingerdesign.mold.plan.extent import Exits, exits_of
from fingerdesign.mold.plan.leg_room import Room
from fingerdesign.mold.plan.plan import SIDES, Holding, Leg, Limits, Plug, Side, SidePlan, Slot
from fingerdesign.mold.plan.slots import end_of, scale_of, turned_bar

# Slots that lack webs between them: which key is owed the change, and remedies that were tried.


_FEATHERLESS = 0.8  # cosine of 37 degrees
_WINDOW_MM = 0.5  # beside and below the slots: room for leads, and to see


def slots_on(
    design: Design,
    frames: tuple[PlateFrame, ...],
    legs: tuple[Leg, ...],
    limits: Limits,
    side: Side,
) -> tuple[Slot, ...]:
    """The slots of one side, in the legs' order."""
    by_index = {frame.index: frame for frame in frames}
    here = slots.on_side(legs, side)
    holding = slots.holding_of(design, here)
    return tuple(slots.slot_of(design, holding, limits, by_index[leg.plate], leg) for leg in here)


def _side(
    design: Design,
    frames: tuple[PlateFrame, ...],
    legs: tuple[Leg, ...],
    limits: Limits,
    side: Side,
) -> SidePlan:
    here = slots.on_side(legs, side)
    holding = slots.holding_of(design, here)
    openings = slots_on(design, frames, legs, limits, side)
    room = Room.of(design, scale_of(design), limits)
    sheet = slots.sheets_thickness(design, holding, limits)
    shift = 0.0
    if holding == "jig":
        by_index = {frame.index: frame for frame in frames}
        shift = min(
            0.5 * (slot.width - turned_bar(by_index[leg.plate], leg.width, leg.offset).thickness)
            for slot, leg in zip(openings, here, strict=True)
        )
    return SidePlan(side, holding, sheet, shift, _window(side, holding, openings, room), openings)


def _window(
    side: Side, holding: Holding, openings: tuple[Slot, ...], room: Room
) -> tuple[float, float, float] | None:
    """The opening behind a comb or jig, around all of its slots; walls below it, and in side walls
    beside it, stay as thick as they must be."""
    if holding not in ("comb", "jig"):
        return None
    corners = slots.openings_corners(openings).reshape(-1, 2)
    (low, bottom), (high, _) = corners.min(axis=0), corners.max(axis=0)
    most = room.corner - room.wall if side.endswith("x") else np.inf
    return (
        float(max(low - _WINDOW_MM, min(-most, low))),
        float(min(high + _WINDOW_MM, max(most, high))),
        float(max(bottom - _WINDOW_MM, min(room.wall, bottom))),
    )


def leg_exits(
    design: Design, frames: tuple[PlateFrame, ...], legs: tuple[Leg, ...], limits: Limits
) -> tuple[Exits, Exits]:
    """How legs leave the finger, and how their slots do."""
    by_index = {frame.index: frame for frame in frames}
    bars, openings, reliefs = [], [], []
    for leg in legs:
        frame = by_index[leg.plate]
        bar = turned_bar(frame, leg.width, leg.offset)
        slot = slots.slot_of(design, "slots", limits, frame, leg)
        bars.append(bar)
        openings.append(slots.as_bar(bar, slot))
        reliefs.append(slots.as_relief(bar, slot))
    sides = [leg.side for leg in legs]
    starts = [end_of(by_index[leg.plate], leg.side) for leg in legs]
    scale = scale_of(design)
    return (
        exits_of(design.body, scale, bars, sides, starts),
        exits_of(design.body, scale, openings, sides, starts, follow=False).with_others(
            exits_of(design.body, scale, reliefs, sides, starts, follow=False)
        ),
    )


def in_walls(design: Design, legs: tuple[Leg, ...]) -> tuple[Leg, ...]:
    """The legs that are held by slots in walls."""
    found: tuple[Leg, ...] = ()
    for side in SIDES:
        here = slots.on_side(legs, side)
        found += here if slots.holding_of(design, here) == "slots" else ()
    return found


def legs_above(
    design: Design, frames: tuple[PlateFrame, ...], legs: tuple[Leg, ...], limits: Limits
) -> tuple[Room, list[tuple[Leg, float]]]:
    """The room for legs; and the legs that leave so high that the insert must end short of them,
    each with its nearest exit."""
    room = Room.of(design, scale_of(design), limits)
    loose = in_walls(design, legs)
    if not loose:
        return room, []
    exits, openings = leg_exits(design, frames, loose, limits)
    above = room.above(openings)
    found = [(leg, float(exits.nearest[k])) for k, leg in enumerate(loose) if above[k]]
    return room, found


def _seam_on(design: Design, room: Room, axis: str) -> float:
    """How far out the seam of a plug may lie on the contact surface, mm.

    On a revolved body's border it would meet the upright side at the angle whose sine is the rest:
    farther out than this the insert ends there in a feather edge.
    """
    if not design.body.kind.turned:
        return math.inf
    zone = room.zone_x if axis == "x" else room.zone_z
    return max(_FEATHERLESS * 0.5 * design.body.width_mm * scale_of(design), zone)


def plugs_of(
    design: Design, frames: tuple[PlateFrame, ...], legs: tuple[Leg, ...], limits: Limits
) -> tuple[Plug, ...]:
    """The insert's plugs: as wide as the legs beside them allow, narrowed by the draft."""
    room, above = legs_above(design, frames, legs, limits)
    plugs = []
    for axis in ("x", "z"):
        nearest = [out for leg, out in above if leg.side.endswith(axis)]
        if nearest:
            top = min(min(nearest) - room.web, _seam_on(design, room, axis) + room.narrowing)
            plugs.append(Plug(axis, top - room.narrowing, top))
    return tuple(plugs)


# Plates that no fixture can hold: webs, crossing legs, exits in the contact zone; with remedies.
#
# Each fault names the key that is owed the change; bounds are found by trying, and only reported
# where the changed design is sound.
