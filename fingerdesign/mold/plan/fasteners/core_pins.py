"""Pins that hold a core clear of the base while the rubber cures, drawn with their walls."""

from itertools import product

import numpy as np

from fingerdesign.mold.plan.fasteners.columns import clear
from fingerdesign.mold.plan.limits import SPARE_MM, Limits
from fingerdesign.mold.plan.pieces import ENDS, FLANKS, CorePin, SidePlan
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.refusals import Refusal

DIAMETERS_MM = (2.0, 1.5, 1.2, 1.0, 0.8, 0.6, 0.5)  # steel pins and wire that are sold
CORE_CLEARANCE_MM = 0.05  # all round in the core, whose hole is drilled: 0.1 mm over the pin
_MOST_DEPTH_MM = 3.0
_DEPTH_SHARE = 0.3  # of the core's length
_STEP_MM = 0.1
_WEB_MM = 0.25  # of the core around a hole: a thin drill wanders by 0.05 in 3 mm, at most 0.1


def core_pins_of(plan: MoldPlan) -> tuple[tuple[CorePin, ...], list[Refusal]]:
    """Place straight pins through the walls, two on either side where the core is wide enough, else
    one, as thick as the core allows; or refuse a core that none can hold."""
    limits, core, box = plan.limits, plan.design.body.core, plan.core
    if core is None or box is None or box[0][1] == 0.0:
        return (), []
    low, high = box
    for axis, diameter in product((ENDS, FLANKS), DIAMETERS_MM):
        # The wall's hole is at least what the process makes.
        clearance = max(limits.clearance_mm, 0.5 * (limits.hole_mm - diameter))
        y = _height(float(low[1]), float(high[1]), diameter, clearance, limits)
        half, end = (high[0], high[2]) if axis[0].endswith("z") else (high[2], high[0])
        hole, sides = diameter + 2.0 * clearance, [plan.by_side[side] for side in axis]
        places = [] if y is None else _places(float(half), y, hole, sides, limits)
        if y is not None and places:
            depth = min(_MOST_DEPTH_MM, _DEPTH_SHARE * 2.0 * float(end))
            pins = (
                CorePin(side, place, y, diameter, float(end) - depth, depth, clearance)
                for side, place in product(axis, places)
            )
            return tuple(pins), []
    least = DIAMETERS_MM[-1] + 2.0 * (CORE_CLEARANCE_MM + _WEB_MM)
    if high[1] - low[1] < least:
        numbers = {"least": least, "pin": DIAMETERS_MM[-1], "web": _WEB_MM}
        return (), [Refusal("thin_core", "body.core.height_mm", core.height_mm, numbers)]
    return (), [Refusal("core_not_reached", "body.core.bottom_mm", core.bottom_mm, {})]


def _height(
    low: float, high: float, diameter: float, clearance: float, limits: Limits
) -> float | None:
    """The height in a core from ``low`` to ``high``, nearest to its middle, at which the wall below
    the hole is thick enough; None: there is none."""
    around = 0.5 * diameter + CORE_CLEARANCE_MM + _WEB_MM
    least = max(low + around, 0.5 * diameter + clearance + limits.wall_mm + SPARE_MM)
    most = high - around
    return None if least > most + 1e-9 else min(max(0.5 * (low + high), least), most)


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
