"""What fasteners must fit: how high the walls are, and what they hold already; mm.

Places are found by trying: the nearest to the middle that leaves the process's wall.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fingerdesign.mold.plan.extent import Extent
from fingerdesign.mold.plan.plan import CorePin, Limits, Plug, Side, SidePlan
from fingerdesign.mold.plan.slots import openings_of

# Clearance holes of the medium series (ISO 273), mm; M2.5 in the table of the same series.
CLEARANCE_HOLES = {"M2": 2.4, "M2.5": 2.9, "M3": 3.4, "M4": 4.5}
SPARE_MM = 0.05  # beyond the least wall: round holes are measured as triangles
SLENDER = 1.5  # a pin's length, in diameters


@dataclass(frozen=True)
class Columns:
    """Places and sizes of fasteners beside the finger, mm.

    Going out along x: the z-bolts (x1), then the tapered pins along z and the y-bolts (x2), then
    the insert's pins and the base's keys (x3). Going out along z from the corner: the pins along z,
    then the y-bolts and the insert's pins.

    gap          wall that is left everywhere; hole: diameter of a bolt's clearance hole
    small, big   diameters of the pins: one of each kind is small, so that parts fit one way only
    clearance    of a pin in its socket, all round
    reach        of a pin along z into its socket, sheets that it passes included
    x1, x2, x3   of the columns; ``deep``: |z| of the y-bolts and of the insert's pins
    bar_bolt, bar_pin   |z| of those of an insert that is narrowed along x
    wall_x, ear, wall_z   what the walls need
    """

    size: str
    gap: float
    hole: float
    small: float
    big: float
    clearance: float
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


def columns_of(walls: Walls, limits: Limits, size: str, wide: bool) -> Columns:
    """The columns for bolts of a size; ``wide``: the insert has pins in the side walls, which reach
    as far as the end walls."""
    extent, bar = walls.extent, walls.plug("x") is not None
    sheets, beside = (
        max(planned.thick for planned in walls.sides if planned.side.endswith(axis))
        for axis in "zx"
    )
    ends = [planned.side for planned in walls.sides if planned.side.endswith("z")]
    tips = max(walls.tips[side] if walls.planned(side).window else 0.0 for side in ends)
    gap, hole = limits.wall_mm + SPARE_MM, CLEARANCE_HOLES[size]
    small = limits.pin_mm  # a big pin does not enter a small one's socket
    big = small + (1.0 if limits.dowels else max(0.5, 4.0 * limits.clearance_mm))
    socket, radius = 0.5 * big + limits.clearance_mm, 0.5 * hole
    reach = SLENDER * big + sheets
    if limits.dowels:  # as far into the side wall's end
        reach = min(reach, extent.corner - limits.wall_mm)
    most = max(radius, socket)
    x1 = extent.half_width + beside + gap + radius
    x2 = x1 + radius + gap + most
    x3 = x2 + most + gap + socket
    deep = extent.corner + reach + limits.clearance_mm + gap + most
    bar_bolt = max(extent.half_depth + sheets, tips) + gap + radius
    bar_pin = bar_bolt + radius + gap + socket
    reach_x, side_x = x3 + socket + gap, x2 + most + gap
    reach_z = max(deep + most + gap, bar_pin + socket + gap if bar else 0.0)
    side_x = reach_x if wide else side_x
    return Columns(
        size=size,
        gap=gap,
        hole=hole,
        small=small,
        big=big,
        clearance=limits.clearance_mm,
        reach=reach,
        x1=x1,
        x2=x2,
        x3=x3,
        deep=deep,
        bar_bolt=bar_bolt,
        bar_pin=bar_pin,
        wall_x=side_x - extent.half_width,
        ear=reach_x - side_x,
        wall_z=reach_z - extent.half_depth,
    )


def most_draft(diameter: float, length: float, least: float) -> float:
    """The draft at which a tapered pin's tip, or a rib's edge, is still ``least`` wide, degrees."""
    return math.degrees(math.atan(max(diameter - least, 0.0) / (2.0 * length)))


_STEP_MM = 0.1  # of the places that are tried
ENDS: tuple[tuple[Side, float], ...] = (("+z", 1.0), ("-z", -1.0))
FLANKS: tuple[tuple[Side, float], ...] = (("+x", 1.0), ("-x", -1.0))


@dataclass(frozen=True)
class Obstacle:
    """What a wall has no material in, or must keep, seen along its draw: a rectangle; mm.

    open: a window, clear from ``bottom`` to the wall's top; beyond the plates' ends a bolt may
    cross it.
    """

    low: float
    high: float
    bottom: float
    top: float
    open: bool


@dataclass(frozen=True)
class Walls:
    """What fasteners must fit: the finger's extent, its sides, plugs and core pins, heights.

    seam   height of the walls' top at (x, z) beside the finger
    tips   how far plates' ends reach on each side
    """

    extent: Extent
    sides: tuple[SidePlan, ...]
    plugs: tuple[Plug, ...]
    core_pins: tuple[CorePin, ...]
    tips: dict[Side, float]
    seam: Callable[[float, float], float]
    top: float
    base: float
    draft_deg: float
    dowels: bool

    def plug(self, axis: str) -> float | None:
        """Half-width of the insert where it is narrowed along an axis; None where it is not."""
        return next((plug.at_surface for plug in self.plugs if plug.axis == axis), None)

    def planned(self, side: Side) -> SidePlan:
        """How one side is closed."""
        return next(each for each in self.sides if each.side == side)

    def obstacles(self, side: Side) -> list[Obstacle]:
        """The windows, slots and core pins of one side's wall."""
        planned = self.planned(side)
        open_ = planned.window is not None
        found = [Obstacle(*bounds, open_) for bounds in openings_of(planned)]
        for pin in self.core_pins:
            if pin.side == side:
                r = 0.5 * pin.diameter
                found.append(Obstacle(pin.place - r, pin.place + r, pin.y - r, pin.y + r, False))
        return found


def z_bolt_height(walls: Walls, columns: Columns) -> float | None:
    """Height at which bolts along z pass through both side walls; None where none fits."""
    every = [each for side, _ in FLANKS for each in walls.obstacles(side)]
    return _free_height(walls.extent.rim, columns.radius + columns.gap, every)


def _free_height(rim: float, room: float, obstacles: list[Obstacle]) -> float | None:
    """The height nearest to the middle that is ``room`` away from 0, rim and obstacles."""
    heights = np.arange(room, rim - room + 1e-9, _STEP_MM)
    for each in obstacles:
        heights = heights[(heights < each.bottom - room) | (heights > each.top + room)]
    if not len(heights):
        return None
    return float(heights[np.argmin(np.abs(heights - 0.5 * rim))])


def pin_height(walls: Walls, columns: Columns, small: bool = True) -> float | None:
    """Height of the pins along z on the side walls' ends, of the small size or of both; None where
    none fits."""
    diameter = columns.small if small else columns.big
    near = walls.extent.corner - columns.gap - (columns.reach if walls.dowels else 0.0)
    every = [
        each
        for side, _ in FLANKS
        for each in walls.obstacles(side)
        if each.high > near or each.low < -near
    ]
    room = 0.5 * diameter + columns.clearance + columns.gap
    return _free_height(walls.extent.rim, room, every)


def _free_place(most: float, room: float, obstacles: list[Obstacle]) -> float:
    """The place nearest to the middle, within +-most, that is ``room`` away from obstacles."""
    if most < 0.0:
        return math.nan
    places = np.append(np.arange(0.0, most, _STEP_MM), most)
    places = np.concatenate([places, -places])
    for each in obstacles:
        places = places[(places < each.low - room) | (places > each.high + room)]
    return float(places[np.argmin(np.abs(places))]) if len(places) else math.nan


def bolt_place(walls: Walls, columns: Columns, side: Side, away: float) -> float:
    """Place along a wall (z of a side wall, x of an end wall) of an upright bolt at distance
    ``away`` from the mid-plane; NaN where there is no room.

    It may cross an open window beyond the plates' ends: it clamps what of the wall is below.
    """
    room = columns.radius + columns.gap
    plug, reach = _reaches(walls, side)
    passed = away - room > walls.tips.get(side, 0.0)
    every = [each for each in walls.obstacles(side) if not (each.open and passed)]
    return _free_place(min(reach, plug) - room, room, every)


def pin_place(walls: Walls, columns: Columns, side: Side, small: bool) -> float:
    """Place along a wall of a pin below the insert; NaN where there is no room.

    The pin itself stands on the insert; its socket is in the wall, which reaches on beyond a plug.
    """
    diameter = columns.small if small else columns.big
    room = 0.5 * diameter + columns.clearance + columns.gap
    plug, reach = _reaches(walls, side)
    most = min(reach - room, plug - 0.5 * diameter - SPARE_MM)
    return _free_place(most, room, walls.obstacles(side))


def _reaches(walls: Walls, side: Side) -> tuple[float, float]:
    """Half-width of the insert, infinite unless narrowed, and of the wall, along a side's wall."""
    plug = walls.plug("x" if side.endswith("z") else "z")
    wall = walls.extent.corner if side.endswith("x") else walls.extent.half_width
    return np.inf if plug is None else plug, wall
