"""What fasteners must fit: how high the walls are, and what they hold already; mm.

Places are found by trying: the nearest to the middle that leaves the process's wall.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fingerdesign.mold.columns import SPARE_MM, Columns
from fingerdesign.mold.extent import Extent
from fingerdesign.mold.plan import CorePin, Plug, Side, SidePlan
from fingerdesign.mold.slots import openings_corners

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

    def obstacles(self, side: Side) -> tuple[Obstacle, ...]:
        """The windows, slots and core pins of one side's wall."""
        planned = next(each for each in self.sides if each.side == side)
        found = []
        if planned.window is not None:
            low, high, bottom = planned.window
            found.append(Obstacle(low, high, bottom, np.inf, True))
        elif planned.slots:
            for corners in openings_corners(planned.slots):
                (low, bottom), (high, top) = corners.min(axis=0), corners.max(axis=0)
                ends = (float(low), float(high))
                found.append(Obstacle(*ends, float(bottom), float(top), False))
        for pin in self.core_pins:
            if pin.side == side:
                r = 0.5 * pin.diameter
                found.append(Obstacle(pin.place - r, pin.place + r, pin.y - r, pin.y + r, False))
        return tuple(found)


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


def _free_place(most: float, room: float, obstacles: list[Obstacle]) -> float | None:
    """The place nearest to the middle, within +-most, that is ``room`` away from obstacles."""
    if most < 0.0:
        return None
    places = np.append(np.arange(0.0, most, _STEP_MM), most)
    places = np.concatenate([places, -places])
    for each in obstacles:
        places = places[(places < each.low - room) | (places > each.high + room)]
    return float(places[np.argmin(np.abs(places))]) if len(places) else None


def bolt_place(walls: Walls, columns: Columns, side: Side, away: float) -> float | None:
    """Place along a wall (z of a side wall, x of an end wall) of an upright bolt at distance
    ``away`` from the mid-plane; None where there is no room.

    It may cross an open window beyond the plates' ends: it clamps what of the wall is below.
    """
    room = columns.radius + columns.gap
    plug, reach = _reaches(walls, side)
    passed = away - room > walls.tips.get(side, 0.0)
    every = [each for each in walls.obstacles(side) if not (each.open and passed)]
    return _free_place(min(reach, plug) - room, room, every)


def pin_place(walls: Walls, columns: Columns, side: Side, small: bool) -> float | None:
    """Place along a wall of a pin below the insert; None where there is no room.

    The pin itself stands on the insert; its socket is in the wall, which reaches on beyond a plug.
    """
    diameter = columns.small if small else columns.big
    room = 0.5 * diameter + columns.clearance + columns.gap
    plug, reach = _reaches(walls, side)
    most = min(reach - room, plug - 0.5 * diameter - SPARE_MM)
    return _free_place(most, room, list(walls.obstacles(side)))


def _reaches(walls: Walls, side: Side) -> tuple[float, float]:
    """Half-width of the insert, infinite unless narrowed, and of the wall, along a side's wall."""
    plug = walls.plug("x" if side.endswith("z") else "z")
    wall = walls.extent.corner if side.endswith("x") else walls.extent.half_width
    return np.inf if plug is None else plug, wall
