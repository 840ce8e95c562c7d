"""Bolts and pins: what clamps the mold's parts and brings them to their places; mm.

z-bolts clamp end wall, side walls and end wall; where the side walls are too low for one (or a
window is in its way), y-bolts clamp them between insert and base plate. y-bolts go through insert,
end walls and base plate. Tapered pins along z stand on the side walls' ends, others below the
insert; where a pin along z does not fit, the insert's pins locate the side walls, too. One pin of
each kind differs in size: parts fit one way only. The base plate, whose place counts little, lies
in a frame that is bolted below the walls. Places are found by trying: the nearest to the middle
that leaves the process's wall.
"""

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.body import Body
from fingerdesign.design.mold import Mold
from fingerdesign.errors import Fault
from fingerdesign.mold.part import INSERT
from fingerdesign.mold.plan.extent import seam_height
from fingerdesign.mold.plan.leg_room import seam_of
from fingerdesign.mold.plan.plan import (
    SPARE_MM,
    Bolt,
    Limits,
    MoldPlan,
    Pin,
    Pour,
    Side,
    refusal,
    wall_name,
)
from fingerdesign.mold.plan.slots import clear, openings_of

# Clearance holes of the medium series (ISO 273), mm; M2.5 in the table of the same series.
CLEARANCE_HOLES = {"M2": 2.4, "M2.5": 2.9, "M3": 3.4, "M4": 4.5}
SLENDER = 1.5  # a pin's length, in diameters
ENDS: tuple[tuple[Side, float], ...] = (("+z", 1.0), ("-z", -1.0))
FLANKS: tuple[tuple[Side, float], ...] = (("+x", 1.0), ("-x", -1.0))


@dataclass(frozen=True)
class Columns:
    """Places and sizes of fasteners beside the finger, mm.

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
    bar_bolt = max(plan.half_depth + sheets, tips) + LEDGE_MM + limits.clearance_mm
    bar_bolt += gap + radius
    bar_pin = bar_bolt + radius + gap + socket
    reach_x, side_x = x3 + socket + gap, x2 + most + gap
    reach_z = max(deep + most + gap, bar_pin + socket + gap if bar else 0.0)
    reach_z = max(reach_z, plan.half_depth + sheets + gap)  # round bodies are parted within
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


def z_bolt_height(plan: MoldPlan, columns: Columns, floor: float = 0.0) -> float | None:
    """Height at which bolts along z pass through both side walls, which begin at a height of
    ``floor``; None where none fits."""
    every = np.concatenate([obstacles(plan, side) for side, _ in FLANKS])
    return _free_height(plan.rim, columns.radius + columns.gap, every, floor)


def _free_height(rim: float, room: float, held: Array, floor: float = 0.0) -> float | None:
    """The height nearest to the middle that is ``room`` away from floor, rim and obstacles
    (n, 4)."""
    heights = np.arange(floor + room, rim - room + 1e-9, _STEP_MM)
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

    The pin itself stands on the insert, where a dowel has a hole; its socket is in the wall, which
    reaches on beyond a plug.
    """
    diameter = columns.small if small else columns.big
    room = 0.5 * diameter + columns.clearance + columns.gap
    plug, reach = _reaches(plan, side)
    beside = room if columns.limits.dowels else 0.5 * diameter + SPARE_MM
    most = min(reach - room, plug - beside)
    return _free_place(most, room, obstacles(plan, side))


def _reaches(plan: MoldPlan, side: Side) -> tuple[float, float]:
    """Half-width of the insert, infinite unless narrowed, and of the wall, along a side's wall."""
    plug = plan.plug("x" if side.endswith("z") else "z")
    wall = plan.corner if side.endswith("x") else plan.half_width
    return np.inf if plug is None else plug, wall


# Every bolt and pin at its place.

FOOTPRINT = 2.0  # area of the mount over that of the finger's base, at most
LEAST_LEDGE_MM, LEDGE_MM = 0.5, 2.0  # of the mount beside the finger: least and most
LIP_MM = 2.0  # of the base frame below the base plate, at least
LEAST_PIN = 0.4  # of its diameter: a shorter pin guides nothing
CORNERS = tuple(product(ENDS, FLANKS))
_ONE = ("+z", "+x")  # the corner whose pin is small


def _pin(
    columns: Columns,
    root: tuple[float, float, float],
    direction: tuple[float, float, float],
    small: bool,
    length: float,
    on: str,
    into: str,
) -> Pin:
    """A pin of the small or the big size on one part that reaches ``length`` into another."""
    diameter, dowel = columns.small if small else columns.big, columns.limits.dowels
    tip, whole = diameter, 2.0 * length
    if not dowel:
        tip, whole = diameter - whole * math.tan(math.radians(columns.draft_deg)), length
    return Pin(root, direction, diameter, tip, whole, columns.clearance, on, into, dowel)


def fastened(body: Body, plan: MoldPlan, columns: Columns) -> MoldPlan:
    """The plan with every bolt and pin; what it cannot have is told by :func:`fastener_faults`."""
    plan = replace(plan, wall_x=columns.wall_x, wall_z=columns.wall_z, ear=columns.ear)
    lip = max(LIP_MM, columns.gap)
    plan = replace(plan, lip=lip)
    height, level = z_bolt_height(plan, columns), pin_height(plan, columns)
    both = pin_height(plan, columns, small=False)
    middle = level if both is None else both
    of = (columns.size, columns.hole)
    bolts, pins = list[Bolt](), list[Pin]()
    if height is not None:
        reach = plan.reach_z
        bolts = [Bolt("z", sign * columns.x1, height, -reach, reach, *of) for _, sign in FLANKS]
    for (end, way), (flank, sign) in CORNERS if middle is not None else ():
        small = both is None or (end, flank) == _ONE
        root = (sign * columns.x2, middle or 0.0, way * plan.corner)
        on, into = wall_name(flank), wall_name(end)
        pins.append(_pin(columns, root, (0.0, 0.0, way), small, columns.reach, on, into))
    upright = [(sign * columns.x2, way * columns.deep) for (_, way), (_, sign) in CORNERS]
    upright += [(x, z) for _, x, z in insert_bolts(plan, columns, height is None)]
    bolts += [Bolt("y", x, z, -plan.base - lip, plan.top, *of) for x, z in upright]
    for side, x, z, small in insert_pins(plan, columns, level is None):
        pins.append(insert_pin(body, plan, columns, (x, z), small, wall_name(side)))
    return replace(plan, bolts=tuple(bolts), pins=tuple(pins))


def with_mount(body: Body, plan: MoldPlan) -> MoldPlan:
    """The plan with its base plate's size: beyond finger and combs by a ledge, so that its area is
    at most FOOTPRINT times that of the finger's base, but for very small fingers."""
    sheets = max(side.sheet for side in plan.sides)
    a, b = 2.0 * plan.half_width, 2.0 * (plan.half_depth + sheets)
    base = 2.0 * a * plan.half_depth * (0.25 * math.pi if body.kind.turned else 1.0)
    # (a + 2 l) (b + 2 l) is the plate's area.
    room = (a + b) ** 2 - 4.0 * (a * b - FOOTPRINT * base)
    ledge = min(max(0.25 * (math.sqrt(max(room, 0.0)) - a - b), LEAST_LEDGE_MM), LEDGE_MM)
    return replace(plan, mount_x=0.5 * a + ledge, mount_z=0.5 * b + ledge)


def insert_bolts(plan: MoldPlan, columns: Columns, low: bool) -> list[tuple[Side, float, float]]:
    """Where upright bolts (side, x, z) are beside those at the end walls' ears: through the side
    walls where these are too ``low`` for bolts along z, or where the insert ends short of the end
    walls; through the end walls where it ends short of the side walls. NaN: no room."""
    found: list[tuple[Side, float, float]] = []
    if plan.plug("x") is not None:
        for end, way in ENDS:
            x = bolt_place(plan, columns, end, columns.bar_bolt)
            found.append((end, x, way * columns.bar_bolt))
    if low or plan.plug("z") is not None:
        for flank, sign in FLANKS:
            z = bolt_place(plan, columns, flank, columns.x2)
            found.append((flank, sign * columns.x2, z))
    return found


def insert_pins(
    plan: MoldPlan, columns: Columns, low: bool
) -> list[tuple[Side, float, float, bool]]:
    """Where the insert has pins: (side of the wall, x, z, small). NaN: no room.

    Beside windows they are all small where the big ones have no room.
    """
    found: list[tuple[Side, float, float, bool]] = []
    if plan.plug("x") is not None:
        for end, way in ENDS:
            x, small = _small_or_big(plan, columns, end, end == "+z")
            found.append((end, x, way * columns.bar_pin, small))
        return found
    narrow = plan.plug("z") is not None
    for (end, way), (flank, sign) in CORNERS if not narrow else ():
        found.append((end, sign * columns.x3, way * columns.deep, (end, flank) == _ONE))
    if narrow or low:
        for flank, sign in FLANKS:
            z, small = _small_or_big(plan, columns, flank, narrow and flank == "+x")
            found.append((flank, sign * columns.x3, z, small))
    return found


def _small_or_big(plan: MoldPlan, columns: Columns, side: Side, small: bool) -> tuple[float, bool]:
    place = pin_place(plan, columns, side, small)
    small = small or math.isnan(place)
    return pin_place(plan, columns, side, small), small


def insert_pin(
    body: Body,
    plan: MoldPlan,
    columns: Columns,
    place: tuple[float, float],
    small: bool,
    into: str,
) -> Pin:
    """A pin below the insert at (x, z): its root is at the greatest height of the walls' top around
    it."""
    x, z = place
    steps = columns.socket * np.array([-1.0, 0.0, 1.0])
    around = [seam_height(body, plan, x + i, z + k) for i, k in product(steps, steps)]
    diameter = columns.small if small else columns.big
    length = insert_pin_length(plan, columns, diameter, min(around)) + max(around) - min(around)
    return _pin(columns, (x, max(around), z), (0.0, -1.0, 0.0), small, length, INSERT, into)


def insert_pin_length(plan: MoldPlan, columns: Columns, diameter: float, seam: float) -> float:
    """How deep a pin below the insert reaches into a wall that is ``seam`` high; half frames may
    end short of the base plate."""
    short = seam_of(columns.limits) if plan.pour == "open" else 0.0
    most = seam - short - columns.gap - columns.clearance
    if columns.limits.dowels:
        most = min(most, plan.top - plan.crest - columns.gap)
    return min(SLENDER * diameter, most)


def limit_faults(mold: Mold, limits: Limits, reach: float, pour: Pour) -> list[Fault]:
    """Limits that contradict each other, plates of the mold below the process's wall, and holes
    that are asked for below its hole; pins reach as far as ``reach`` into their sockets."""
    faults = []
    given = mold.limits.model_dump(exclude_none=True)

    def limit(words: str, name: str, /, **of: object) -> None:
        value = getattr(limits, name)
        faults.append(refusal(words, f"mold.limits.{name}", value, limits=limits, **of))

    if limits.feature_mm > limits.wall_mm:
        name = "feature_mm" if "feature_mm" in given or "wall_mm" not in given else "wall_mm"
        limit("contradiction", name, name=name)
    thick = _least_pin(mold, limits, reach)
    if limits.pin_mm < thick and "pin_mm" in given:
        limit("thin_pins", "pin_mm", thick=thick, draft=mold.draft_deg)
    if limits.clearance_mm > 0.25 * limits.pin_mm and "pin_mm" not in given:
        limit("wide_sockets", "clearance_mm", most=0.25 * limits.pin_mm)
    walls, holes = ("insert_mm", "base_mm"), ("lock_mm", "gate_mm", "vent_mm")
    for key in (*walls, *(holes if pour == "closed" else holes[:1])):
        size, usual = getattr(mold, key), Mold.model_fields[key].default
        least = limits.wall_mm if key in walls else limits.hole_mm
        if size is not None and size < least and (key in walls or size != usual):
            words = "thin_wall" if key in walls else "narrow_hole"
            faults.append(refusal(words, f"mold.{key}", size, limits=limits))
    return faults


def _least_pin(mold: Mold, limits: Limits, reach: float) -> float:
    """Least diameter of the small pins, mm: four clearances, and a tip that can be made.

    Pins get shorter as they get thinner: ``reach`` moves with the big pins' diameter.
    """
    least = 4.0 * limits.clearance_mm
    if limits.dowels:
        return max(least, limits.feature_mm)
    lean = 2.0 * math.tan(math.radians(mold.draft_deg))
    slope = 1.0 - SLENDER * lean
    if slope <= 0.0:  # no diameter helps: the draft itself is refused
        return least
    rest = max(reach - SLENDER * limits.pin_mm, 0.0)
    return max(least, (limits.feature_mm + lean * rest) / slope)


def fastener_faults(mold: Mold, plan: MoldPlan, columns: Columns) -> list[Fault]:
    """What of bolts and pins does not fit the walls of a mold."""
    faults, of = [], {"limits": columns.limits, "columns": columns}
    if mold.wall_mm is not None and mold.wall_mm < columns.wall_z - 1e-9:
        faults.append(refusal("thin_end_walls", "mold.wall_mm", mold.wall_mm, **of))
    return [
        *faults,
        *_height_faults(mold, plan, columns),
        *_draft_faults(mold, plan, columns),
        *_room_faults(mold, plan, columns),
    ]


def _height_faults(mold: Mold, plan: MoldPlan, columns: Columns) -> list[Fault]:
    """Walls too low for the bolt that was asked for, or for anything."""
    faults, rim, wall = [], plan.rim, columns.limits.wall_mm
    if mold.bolt != "auto" and z_bolt_height(plan, columns) is None:
        faults.append(refusal("big_bolt", "mold.bolt", mold.bolt, rim=rim, columns=columns))
    most = rim - LEAST_PIN * columns.big - columns.clearance - SPARE_MM
    if wall > most + 1e-9:
        of = {"most": most, "rim": rim, "columns": columns, "higher": wall - most}
        faults.append(refusal("low_walls", "mold.limits.wall_mm", wall, **of))
    return faults


def _draft_faults(mold: Mold, plan: MoldPlan, columns: Columns) -> list[Fault]:
    """Pins without a tip."""
    if columns.limits.dowels:
        return []
    least = columns.limits.feature_mm
    longest = insert_pin_length(plan, columns, columns.small, plan.rim)
    if pin_height(plan, columns) is not None:
        longest = max(longest, columns.reach)
    most = most_draft(columns.small, max(longest, 1e-3), least)
    if mold.draft_deg <= most or (most <= 0.0 and mold.limits.pin_mm is not None):
        return []  # the pin that is too thin is refused
    if most <= 0.0:
        return [refusal("webs_on_pins", "mold.limits.feature_mm", least, columns=columns)]
    of = {"most": most, "columns": columns, "limits": columns.limits}
    return [refusal("great_draft", "mold.draft_deg", mold.draft_deg, **of)]


def _room_faults(mold: Mold, plan: MoldPlan, columns: Columns) -> list[Fault]:
    """No place for an upright bolt or pin beside what the walls hold."""
    faults = []
    low = z_bolt_height(plan, columns) is None
    bolts = insert_bolts(plan, columns, low) if mold.bolt == "auto" or not low else []
    lacking = next((side for side, x, z in bolts if math.isnan(x + z)), None)
    if lacking is not None:
        length = 2.0 * (plan.corner if lacking.endswith("x") else plan.half_width)
        of = {"side": lacking, "columns": columns, "low": low, "rim": plan.rim, "length": length}
        faults.append(refusal("no_bolt", "mold.bolt", mold.bolt, **of))
    pins = insert_pins(plan, columns, pin_height(plan, columns) is None)
    lacking = next((side for side, x, z, _ in pins if math.isnan(x + z)), None)
    if lacking is not None:
        room = 2.0 * (0.5 * columns.small + columns.clearance + columns.gap)
        pin = columns.limits.pin_mm
        faults.append(refusal("no_pin", "mold.limits.pin_mm", pin, side=lacking, room=room))
    return faults
