"""Columns of fasteners next to the finger: sizes of bolts and pins, and places with room for them.

Places are found by trying: the nearest to the middle that leaves the process's wall; mm.
"""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.mold.plan.limits import SLENDER, SPARE_MM, Limits
from fingerdesign.mold.plan.pieces import Side
from fingerdesign.mold.plan.plan import MoldPlan

LEDGE_MM = 2.0  # the mount reaches so far beyond the finger, at most
_STEP_MM = 0.1  # between the places that are tried
# Clearance holes of the medium series (ISO 273), mm; M2.5 in the table of the same series.
CLEARANCE_HOLES = {"M2": 2.4, "M2.5": 2.9, "M3": 3.4, "M4": 4.5}
ENDS: tuple[tuple[Side, float], ...] = (("+z", 1.0), ("-z", -1.0))
FLANKS: tuple[tuple[Side, float], ...] = (("+x", 1.0), ("-x", -1.0))
CORNERS = tuple(product(ENDS, FLANKS))
ONE = ("+z", "+x")  # the corner whose pin is small: parts fit one way only
AUTO_BOLTS = ("M3", "M2.5", "M2")


@dataclass(frozen=True)
class Columns:
    """Places and sizes of fasteners next to the finger, mm.

    Going out along x: the z-bolts (x1), then the tapered pins along z and the y-bolts (x2), then
    the insert's pins (x3). Going out along z from the corner: the pins along z,
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
        """Clearance of a pin in its socket, all round."""
        return self.limits.clearance_mm

    @property
    def radius(self) -> float:
        """Radius of a bolt's hole."""
        return 0.5 * self.hole

    @property
    def socket(self) -> float:
        """Radius of the larger sockets."""
        return 0.5 * self.big + self.clearance

    @property
    def rise(self) -> float:
        """Height of wall that a bolt along z needs."""
        return self.hole + 2.0 * self.gap


def columns_by_size(plan: MoldPlan, wide: bool) -> list[Columns]:
    """The columns for each size of bolts that may be taken, the preferred first."""
    bolt = plan.design.mold.bolt
    return [columns_of(plan, size, wide) for size in (AUTO_BOLTS if bolt == "auto" else (bolt,))]


def columns_of(plan: MoldPlan, size: str, wide: bool) -> Columns:
    """Place the columns for bolts of a size; ``wide``: the insert has pins in the side walls, which
    reach as far as the end walls."""
    bar, limits = "x" in plan.plug_widths, plan.limits
    sheets, side_sheets = (
        max(planned.sheet for planned in plan.sides if planned.side.endswith(axis)) for axis in "zx"
    )
    tips = max(plan.tips.get(side, 0.0) if plan.by_side[side].window else 0.0 for side, _ in ENDS)
    gap, hole = limits.wall_mm + SPARE_MM, CLEARANCE_HOLES[size]
    small = limits.pin_mm  # a big pin does not enter a small one's socket
    big = small + (1.0 if limits.dowels else max(0.5, 4.0 * limits.clearance_mm))
    socket, radius = 0.5 * big + limits.clearance_mm, 0.5 * hole
    reach = SLENDER * big + sheets
    if limits.dowels:  # as far into the side wall's end
        reach = min(reach, plan.corner - limits.wall_mm)
    most = max(radius, socket)
    x1 = plan.half_width + side_sheets + gap + radius
    x2 = x1 + radius + gap + most
    x3 = x2 + most + gap + socket
    deep = plan.corner + reach + limits.clearance_mm + gap + most
    bar_bolt = max(plan.half_depth + sheets, tips) + LEDGE_MM + limits.clearance_mm
    bar_bolt += gap + radius
    bar_pin = bar_bolt + radius + gap + socket
    reach_x, side_x = x3 + socket + gap, x2 + most + gap
    reach_z = max(deep + most + gap, bar_pin + socket + gap if bar else 0.0)
    reach_z = max(reach_z, plan.half_depth + sheets + gap)  # round bodies are parted within
    side_x = reach_x if wide else side_x
    return Columns(
        *(limits, plan.design.mold.draft_deg, size, gap, hole, small, big, reach),
        *(x1, x2, x3, deep, bar_bolt, bar_pin),
        *(side_x - plan.half_width, reach_x - side_x, reach_z - plan.half_depth),
    )


def clear(places: Array, room: float, low: Array, high: Array) -> BoolArray:
    """True for places (n,) ``room`` away from all that reaches from ``low`` to ``high`` (k,)."""
    away = (places[:, None] < low - room) | (places[:, None] > high + room)
    return np.asarray(away.all(axis=1))


def _obstacles(plan: MoldPlan, *sides: Side) -> Array:
    """Rectangles (n, 4), as of ``SidePlan.openings``, where walls have no material or must keep it,
    seen along their draw: windows, slots and core pins."""
    openings = [plan.by_side[side].openings for side in sides]
    for pin in plan.core_pins:
        if pin.side in sides:
            room = 0.5 * pin.diameter + pin.clearance
            near = [pin.place - room, pin.place + room, pin.y - room, pin.y + room]
            openings.append(np.array([near]))
    return np.concatenate(openings)


def z_bolt_height(plan: MoldPlan, columns: Columns, floor: float = 0.0) -> float | None:
    """Find the height at which bolts along z pass through both side walls, which begin at a height
    of ``floor``; None where none fits."""
    return _free_height(plan.rim, columns.radius + columns.gap, _obstacles(plan, "+x", "-x"), floor)


def _free_height(rim: float, room: float, taken: Array, floor: float = 0.0) -> float | None:
    """The height nearest to the middle that is ``room`` away from floor, rim and obstacles."""
    heights = np.arange(floor + room, rim - room + 1e-9, _STEP_MM)
    heights = heights[clear(heights, room, taken[:, 2], taken[:, 3])]
    return float(heights[np.argmin(np.abs(heights - 0.5 * rim))]) if len(heights) else None


def pin_height(plan: MoldPlan, columns: Columns, small: bool = True) -> float | None:
    """Height of the pins along z on the side walls' ends, small or big; None where none fits."""
    diameter = columns.small if small else columns.big
    near = plan.corner - columns.gap - (columns.reach if columns.limits.dowels else 0.0)
    every = _obstacles(plan, "+x", "-x")
    every = every[(every[:, 1] > near) | (every[:, 0] < -near)]
    return _free_height(plan.rim, 0.5 * diameter + columns.clearance + columns.gap, every)


def _free_place(most: float, room: float, taken: Array) -> float:
    """The place nearest to the middle, within +-most, that is ``room`` away from obstacles."""
    if most < 0.0:
        return math.nan
    places = np.append(np.arange(0.0, most, _STEP_MM), most)
    places = np.concatenate([places, -places])
    places = places[clear(places, room, taken[:, 0], taken[:, 1])]
    return float(places[np.argmin(np.abs(places))]) if len(places) else math.nan


def _bolt_place(plan: MoldPlan, columns: Columns, side: Side, away: float) -> float:
    """Place along a wall (z of a side wall, x of an end wall) of an upright bolt at distance
    ``away`` from the mid-plane; NaN where there is no room.

    It may cross an open window beyond the plates' ends: it clamps what of the wall is below.
    """
    room = columns.radius + columns.gap
    taken = _obstacles(plan, side)
    if away - room > plan.tips.get(side, 0.0):
        taken = taken[np.isfinite(taken[:, 3])]
    return _free_place(min(_reaches(plan, side)) - room, room, taken)


def _pin_place(plan: MoldPlan, columns: Columns, side: Side, small: bool) -> tuple[float, bool]:
    """Place along a wall of a pin below the insert, and True where it is small: as wished, or where
    a big one has no room. NaN: there is no room.

    The pin itself is on the insert, where a dowel has a hole; its socket is in the wall, which
    reaches on beyond a plug.
    """
    diameter = columns.small if small else columns.big
    room = 0.5 * diameter + columns.clearance + columns.gap
    plug, reach = _reaches(plan, side)
    own = room if columns.limits.dowels else 0.5 * diameter + SPARE_MM
    place = _free_place(min(reach - room, plug - own), room, _obstacles(plan, side))
    if math.isnan(place) and not small:
        return _pin_place(plan, columns, side, True)
    return place, small


def _reaches(plan: MoldPlan, side: Side) -> tuple[float, float]:
    """Half-width of the insert, infinite unless narrowed, and of the wall, along a side's wall."""
    axis, wall = ("z", plan.corner) if side.endswith("x") else ("x", plan.half_width)
    return plan.plug_widths.get(axis, math.inf), wall


def _insert_bolts(plan: MoldPlan, columns: Columns, low: bool) -> list[tuple[Side, float, float]]:
    """Places of upright bolts (side, x, z) other than those at the end walls' ears. NaN: no room.

    They go through the side walls where these are too ``low`` for bolts along z, or where the
    insert ends short of the end walls; through the end walls where it ends short of the side walls.
    """
    found, away = list[tuple[Side, float, float]](), columns.bar_bolt
    if "x" in plan.plug_widths:
        found += [(end, _bolt_place(plan, columns, end, away), way * away) for end, way in ENDS]
    away = columns.x2
    if low or "z" in plan.plug_widths:
        found += [
            (each, sign * away, _bolt_place(plan, columns, each, away)) for each, sign in FLANKS
        ]
    return found


def _insert_pins(
    plan: MoldPlan, columns: Columns, low: bool
) -> list[tuple[Side, float, float, bool]]:
    """Places of the insert's pins: (side of the wall, x, z, small). NaN: no room.

    Next to windows they are all small where the big ones have no room.
    """
    found: list[tuple[Side, float, float, bool]] = []
    if "x" in plan.plug_widths:
        for end, way in ENDS:
            x, small = _pin_place(plan, columns, end, end == "+z")
            found.append((end, x, way * columns.bar_pin, small))
        return found
    narrow = "z" in plan.plug_widths
    for (end, way), (flank, sign) in CORNERS if not narrow else ():
        found.append((end, sign * columns.x3, way * columns.deep, (end, flank) == ONE))
    if narrow or low:
        for flank, sign in FLANKS:
            z, small = _pin_place(plan, columns, flank, narrow and flank == "+x")
            found.append((flank, sign * columns.x3, z, small))
    return found


def _closed_columns(plan: MoldPlan) -> Columns:
    """Place the columns of a closed mold, for the given bolts or the largest that fit along z."""
    plugged = "z" in plan.plug_widths
    tried = columns_by_size(plan, plugged)
    columns = next((c for c in tried if z_bolt_height(plan, c) is not None), tried[-1])
    low = pin_height(plan, columns) is None and "x" not in plan.plug_widths
    return columns_of(plan, columns.size, plugged or low)


@dataclass(frozen=True)
class Fit:
    """Places that were found for the fasteners of a closed mold.

    columns       of bolts and pins
    bolt_height   of bolts along z; None where none fits
    pin_height    of pins along z, of the small size; None where none fits. both: of both sizes
    bolts         (side, x, z) of upright bolts other than those at the end walls' ears; NaN where
                  there is no room
    pins          (side of the wall, x, z, small) of the insert's pins; NaN likewise
    """

    columns: Columns
    bolt_height: float | None
    pin_height: float | None
    both: float | None
    bolts: tuple[tuple[Side, float, float], ...]
    pins: tuple[tuple[Side, float, float, bool], ...]


def fit_of(plan: MoldPlan) -> Fit:
    """Find places for all fasteners of a closed mold."""
    columns = _closed_columns(plan)
    height, level = z_bolt_height(plan, columns), pin_height(plan, columns)
    both = pin_height(plan, columns, small=False)
    bolts = _insert_bolts(plan, columns, height is None)
    pins = _insert_pins(plan, columns, level is None)
    return Fit(columns, height, level, both, tuple(bolts), tuple(pins))
