"""What fasteners must fit: how high the walls are, and what they hold already; mm.

Places are found by trying: the nearest to the middle that leaves the process's wall.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.mold import Mold
from fingerdesign.mold.plan.plan import Limits, MoldPlan, Side
from fingerdesign.mold.plan.slots import clear, openings_of

# Clearance holes of the medium series (ISO 273), mm; M2.5 in the table of the same series.
CLEARANCE_HOLES = {"M2": 2.4, "M2.5": 2.9, "M3": 3.4, "M4": 4.5}
SPARE_MM = 0.05  # beyond the least wall: round holes are measured as triangles
SLENDER = 1.5  # a pin's length, in diameters
ENDS: tuple[tuple[Side, float], ...] = (("+z", 1.0), ("-z", -1.0))
FLANKS: tuple[tuple[Side, float], ...] = (("+x", 1.0), ("-x", -1.0))


@dataclass(frozen=True)
class Columns:
    """Places and sizes of fasteners beside the finger, mm.

    Going out along x: the z-bolts (x1), then the tapered pins along z and the y-bolts (x2), then
    the insert's pins and the base's keys (x3). Going out along z from the corner: the pins along z,
    then the y-bolts and the insert's pins.

    size         of the bolts; gap: wall that is left everywhere; hole: of a bolt, its diameter
    small, big   diameters of the pins: one of each kind is small, so that parts fit one way only
    reach        of a pin along z into its socket, sheets that it passes included
    x1, x2, x3   of the columns; ``deep``: |z| of the y-bolts and of the insert's pins
    bar_bolt, bar_pin   |z| of those of an insert that is narrowed along x
    wall_x, ear, wall_z   what the walls need
    """

    limits: Limits
    draft_deg: float
    size: str
    gap: float
    hole: float
    small: float
    big: float
    reach: float
    x1: float
    x2: float
    x3: float
    deep: float
    bar_bolt: float
    bar_pin: float
    wall_x: float
    ear: float
    wall_z: float

    @property
    def clearance(self) -> float:
        """Of a pin in its socket, all round."""
        return self.limits.clearance_mm

    @property
    def radius(self) -> float:
        """Of a bolt's hole."""
        return 0.5 * self.hole

    @property
    def socket(self) -> float:
        """Radius of the larger sockets."""
        return 0.5 * self.big + self.clearance

    @property
    def rise(self) -> float:
        """Height of wall that a bolt along z needs."""
        return self.hole + 2.0 * self.gap


def columns_of(plan: MoldPlan, mold: Mold, limits: Limits, size: str, wide: bool) -> Columns:
    """The columns for bolts of a size; ``wide``: the insert has pins in the side walls, which reach
    as far as the end walls."""
    bar = plan.plug("x") is not None
    sheets, beside = (
        max(planned.sheet for planned in plan.sides if planned.side.endswith(axis)) for axis in "zx"
    )
    tips = max(plan.tip(side) if plan.side(side).window else 0.0 for side, _ in ENDS)
    gap, hole = limits.wall_mm + SPARE_MM, CLEARANCE_HOLES[size]
    small = limits.pin_mm  # a big pin does not enter a small one's socket
    big = small + (1.0 if limits.dowels else max(0.5, 4.0 * limits.clearance_mm))
    socket, radius = 0.5 * big + limits.clearance_mm, 0.5 * hole
    reach = SLENDER * big + sheets
    if limits.dowels:  # as far into the side wall's end
        reach = min(reach, plan.corner - limits.wall_mm)
    most = max(radius, socket)
    x1 = plan.half_width + beside + gap + radius
    x2 = x1 + radius + gap + most
    x3 = x2 + most + gap + socket
    deep = plan.corner + reach + limits.clearance_mm + gap + most
    bar_bolt = max(plan.half_depth + sheets, tips) + gap + radius
    bar_pin = bar_bolt + radius + gap + socket
    reach_x, side_x = x3 + socket + gap, x2 + most + gap
    reach_z = max(deep + most + gap, bar_pin + socket + gap if bar else 0.0)
    side_x = reach_x if wide else side_x
    return Columns(
        *(limits, mold.draft_deg, size, gap, hole, small, big, reach),
        *(x1, x2, x3, deep, bar_bolt, bar_pin),
        *(side_x - plan.half_width, reach_x - side_x, reach_z - plan.half_depth),
    )


def most_draft(diameter: float, length: float, least: float) -> float:
    """The draft at which a tapered pin's tip, or a rib's edge, is still ``least`` wide, degrees."""
    return math.degrees(math.atan(max(diameter - least, 0.0) / (2.0 * length)))


_STEP_MM = 0.1  # of the places that are tried


def obstacles(plan: MoldPlan, side: Side) -> Array:
    """Where one side's wall has no material, or must keep it, seen along its draw: rectangles
    (n, 4) of windows, slots and core pins as of ``openings_of``."""
    pins = [
        [place + sign * 0.5 * pin.diameter for place in (pin.place, pin.y) for sign in (-1.0, 1.0)]
        for pin in plan.core_pins
        if pin.side == side
    ]
    return np.concatenate([openings_of(plan.side(side)), np.array(pins).reshape(-1, 4)])


def z_bolt_height(plan: MoldPlan, columns: Columns) -> float | None:
    """Height at which bolts along z pass through both side walls; None where none fits."""
    every = np.concatenate([obstacles(plan, side) for side, _ in FLANKS])
    return _free_height(plan.rim, columns.radius + columns.gap, every)


def _free_height(rim: float, room: float, held: Array) -> float | None:
    """The height nearest to the middle that is ``room`` away from 0, rim and obstacles (n, 4)."""
    heights = np.arange(room, rim - room + 1e-9, _STEP_MM)
    heights = heights[clear(heights, room, held[:, 2], held[:, 3])]
    return float(heights[np.argmin(np.abs(heights - 0.5 * rim))]) if len(heights) else None


def pin_height(plan: MoldPlan, columns: Columns, small: bool = True) -> float | None:
    """Height of the pins along z on the side walls' ends, of the small size or of both; None where
    none fits."""
    diameter = columns.small if small else columns.big
    near = plan.corner - columns.gap - (columns.reach if columns.limits.dowels else 0.0)
    every = np.concatenate([obstacles(plan, side) for side, _ in FLANKS])
    every = every[(every[:, 1] > near) | (every[:, 0] < -near)]
    return _free_height(plan.rim, 0.5 * diameter + columns.clearance + columns.gap, every)


def _free_place(most: float, room: float, held: Array) -> float:
    """The place nearest to the middle, within +-most, that is ``room`` away from obstacles."""
    if most < 0.0:
        return math.nan
    places = np.append(np.arange(0.0, most, _STEP_MM), most)
    places = np.concatenate([places, -places])
    places = places[clear(places, room, held[:, 0], held[:, 1])]
    return float(places[np.argmin(np.abs(places))]) if len(places) else math.nan


def bolt_place(plan: MoldPlan, columns: Columns, side: Side, away: float) -> float:
    """Place along a wall (z of a side wall, x of an end wall) of an upright bolt at distance
    ``away`` from the mid-plane; NaN where there is no room.

    It may cross an open window beyond the plates' ends: it clamps what of the wall is below.
    """
    room = columns.radius + columns.gap
    held = obstacles(plan, side)
    if away - room > plan.tip(side):
        held = held[np.isfinite(held[:, 3])]
    return _free_place(min(_reaches(plan, side)) - room, room, held)


def pin_place(plan: MoldPlan, columns: Columns, side: Side, small: bool) -> float:
    """Place along a wall of a pin below the insert; NaN where there is no room.

    The pin itself stands on the insert; its socket is in the wall, which reaches on beyond a plug.
    """
    diameter = columns.small if small else columns.big
    room = 0.5 * diameter + columns.clearance + columns.gap
    plug, reach = _reaches(plan, side)
    most = min(reach - room, plug - 0.5 * diameter - SPARE_MM)
    return _free_place(most, room, obstacles(plan, side))


def _reaches(plan: MoldPlan, side: Side) -> tuple[float, float]:
    """Half-width of the insert, infinite unless narrowed, and of the wall, along a side's wall."""
    plug = plan.plug("x" if side.endswith("z") else "z")
    wall = plan.corner if side.endswith("x") else plan.half_width
    return np.inf if plug is None else plug, wall
