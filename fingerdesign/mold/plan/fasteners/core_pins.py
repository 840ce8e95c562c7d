"""Pins that hold a core clear of the base while the rubber cures, drawn with their walls."""

from itertools import product

import numpy as np

from fingerdesign.mold.plan.fasteners.columns import clear
from fingerdesign.mold.plan.limits import Limits
from fingerdesign.mold.plan.plan import ENDS, FLANKS, CorePin, MoldPlan, SidePlan
from fingerdesign.mold.plan.refusals import Refusal

DIAMETERS_MM = (2.0, 1.5, 1.2, 1.0, 0.8, 0.6, 0.5)  # steel pins and wire that are sold
_MOST_DEPTH_MM = 3.0
_DEPTH_SHARE = 0.3  # of the core's length
_STEP_MM = 0.1
_WEB_MM = 0.3  # of the core around a pin's hole, which is drilled


def core_pins_of(plan: MoldPlan) -> tuple[tuple[CorePin, ...], list[Refusal]]:
    """Place straight pins through the walls, two on either side where the core is wide enough, else
    one; or refuse a core that none can hold."""
    limits, core, box = plan.limits, plan.design.body.core, plan.core
    if core is None or box is None or box[0][1] == 0.0:
        return (), []
    low, high = box
    height, y = float(high[1] - low[1]), 0.5 * float(low[1] + high[1])
    for axis, diameter in product((ENDS, FLANKS), _diameters(limits, height, y)):
        hole = diameter + 2.0 * limits.clearance_mm
        half, end = (high[0], high[2]) if axis[0].endswith("z") else (high[2], high[0])
        places = _places(float(half), y, hole, [plan.by_side[side] for side in axis], limits)
        if places:
            depth = min(_MOST_DEPTH_MM, _DEPTH_SHARE * 2.0 * float(end))
            pins = (
                CorePin(side, place, y, diameter, float(end) - depth, depth)
                for side, place in product(axis, places)
            )
            return tuple(pins), []
    pin = min((d for d in DIAMETERS_MM if d >= limits.hole_mm), default=limits.hole_mm)
    least = pin + 2.0 * limits.clearance_mm + 2.0 * _WEB_MM
    if height < least:
        numbers = {"least": least, "pin": pin, "web": _WEB_MM}
        return (), [Refusal("thin_core", "body.core.height_mm", core.height_mm, numbers)]
    return (), [Refusal("core_not_reached", "body.core.bottom_mm", core.bottom_mm, {})]


def _diameters(limits: Limits, height: float, y: float) -> list[float]:
    """Diameters that fit a core's ``height``; thinner ones alone where the foot of the wall below
    the holes, at a height of ``y``, would be too low."""
    most = height - 2.0 * (limits.clearance_mm + _WEB_MM)
    sizes = [d for d in DIAMETERS_MM if limits.hole_mm <= d <= most + 1e-9]
    footed = [d for d in sizes if 0.5 * d + limits.clearance_mm + limits.wall_mm <= y + 1e-9]
    return footed or sizes


def _places(
    half: float, y: float, hole: float, sides: list[SidePlan], limits: Limits
) -> list[float]:
    """Find places across the core, alike on both sides: two far apart, else one, else none."""
    most = half - 0.5 * hole - _WEB_MM
    if most < 0.0:
        return []
    places = np.arange(0.0, most + 1e-9, _STEP_MM)
    room = 0.5 * hole + limits.wall_mm
    low, high, bottom, top = np.concatenate([planned.openings for planned in sides]).T
    level = (bottom - room < y) & (y < top + room)
    right, left = (clear(sign * places, room, low[level], high[level]) for sign in (1.0, -1.0))
    both = places[right & left]
    if len(both) and both[-1] >= hole + 0.5 * limits.wall_mm:
        return [-float(both[-1]), float(both[-1])]
    one = [*places[right][:1], *-places[left][:1]]
    return [float(one[0])] if one else []
