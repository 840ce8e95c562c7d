"""Straight pins through the walls that hold a core while the rubber cures around it; mm.

For a core that is clear of the base: two pins on either side where it is wide enough, else one.
They are drawn with their walls; what they leave in the rubber is filled afterwards.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.design.faults import at_least
from fingerdesign.errors import Fault
from fingerdesign.mold.base_plan import core_box
from fingerdesign.mold.plan import CorePin, Side, SidePlan
from fingerdesign.mold.slots import openings_corners

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.profiles import Limits

DIAMETERS_MM = (2.0, 1.5, 1.2, 1.0, 0.8, 0.6, 0.5)  # steel pins and wire that are sold
_MOST_DEPTH_MM = 3.0
_DEPTH_SHARE = 0.3  # of the core's length
_STEP_MM = 0.1
_WEB_MM = 0.3  # of the core around a pin's hole, which is drilled
_AXES: tuple[tuple[Side, Side], ...] = (("+z", "-z"), ("+x", "-x"))


def core_pins_of(
    design: Design, scale: float, sides: tuple[SidePlan, ...], limits: Limits
) -> tuple[tuple[CorePin, ...], list[Fault]]:
    """The core's pins, and the fault of a core that none can hold."""
    box = core_box(design, scale)
    if box is None or box[0][1] == 0.0:
        return (), []
    low, high = box
    height = float(high[1] - low[1])
    y = 0.5 * float(low[1] + high[1])
    sizes = [
        d
        for d in DIAMETERS_MM
        if d >= limits.hole_mm and d + 2.0 * (limits.clearance_mm + _WEB_MM) <= height + 1e-9
    ]
    # Thinner pins where the wall's foot below their holes would be too low.
    footed = [d for d in sizes if 0.5 * d + limits.clearance_mm + limits.wall_mm <= y + 1e-9]
    sizes = footed or sizes
    for axis, diameter in product(_AXES, sizes):
        hole = diameter + 2.0 * limits.clearance_mm
        half, end = (high[0], high[2]) if axis[0].endswith("z") else (high[2], high[0])
        places = _places(float(half), y, hole, [s for s in sides if s.side in axis], limits)
        if places:
            depth = min(_MOST_DEPTH_MM, _DEPTH_SHARE * 2.0 * float(end))
            pins = [
                CorePin(side, place, y, diameter, float(end) - depth, depth)
                for side in axis
                for place in places
            ]
            return tuple(pins), []
    return (), [_fault(design, height, limits)]


def _places(
    half: float, y: float, hole: float, sides: list[SidePlan], limits: Limits
) -> list[float]:
    """Places across the core, alike on both sides: two far apart, else one, else none."""
    most = half - 0.5 * hole - _WEB_MM
    if most < 0.0:
        return []
    places = np.arange(0.0, most + 1e-9, _STEP_MM)
    room = 0.5 * hole + limits.wall_mm
    free = {sign: np.ones(len(places), dtype=bool) for sign in (1.0, -1.0)}
    for planned in sides:
        for low, high, bottom, top in _openings(planned):
            if not (bottom - room < y < top + room):
                continue
            for sign, fits in free.items():
                fits &= (sign * places < low - room) | (sign * places > high + room)
    both = places[free[1.0] & free[-1.0]]
    if len(both) and both[-1] >= hole + 0.5 * limits.wall_mm:
        return [-float(both[-1]), float(both[-1])]
    for sign, fits in free.items():
        if fits.any():
            return [sign * float(places[fits][0])]
    return []


def _openings(planned: SidePlan) -> list[tuple[float, float, float, float]]:
    """Rectangles (low, high, bottom, top) of a side's window or slots."""
    if planned.window is not None:
        low, high, bottom = planned.window
        return [(low, high, bottom, np.inf)]
    if not planned.slots:
        return []
    corners = openings_corners(planned.slots)
    least, most = corners.min(axis=1), corners.max(axis=1)
    return [
        (float(a[0]), float(b[0]), float(a[1]), float(b[1]))
        for a, b in zip(least, most, strict=True)
    ]


def _fault(design: Design, height: float, limits: Limits) -> Fault:
    core = design.body.core
    assert core is not None
    pin = min((d for d in DIAMETERS_MM if d >= limits.hole_mm), default=limits.hole_mm)
    least = pin + 2.0 * limits.clearance_mm + 2.0 * _WEB_MM
    if height < least:
        bound = (
            f"at least {at_least(least)} for a mold: a pin of {pin:g} mm holds the core, with "
            f"{_WEB_MM:g} mm of core above and below its hole"
        )
        remedy = "thicken it or stand it on the base (body.core.bottom_mm = 0)"
        return Fault("body.core.height_mm", core.height_mm, bound, remedy)
    bound = "where pins through the walls reach the core clear of the plates' slots and windows"
    remedy = "move it away from them or stand it on the base (body.core.bottom_mm = 0)"
    return Fault("body.core.bottom_mm", core.bottom_mm, bound, remedy)
