"""Bolts, pins and keys: what clamps the mold's parts and brings them to their places; mm.

z-bolts clamp end wall, side walls and end wall; where the side walls are too low for one (or a
window is in its way), y-bolts clamp them between insert and base plate. y-bolts go through insert,
end walls and base plate. Tapered pins along z stand on the side walls' ends, others below the
insert; where a pin along z does not fit, the insert's pins locate the side walls, too. Keys on the
base plate run along the end walls' draw; the side walls have none, for its groove would open into
the finger. One pin and one side's keys differ in size: parts fit one way only.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np

from fingerdesign.design.body import Body
from fingerdesign.design.mold import Mold
from fingerdesign.errors import Fault
from fingerdesign.mold.part import INSERT
from fingerdesign.mold.plan.extent import seam_height
from fingerdesign.mold.plan.plan import Bolt, Key, Limits, MoldPlan, Pin, Side, refusal, wall_name
from fingerdesign.mold.plan.walls import (
    ENDS,
    FLANKS,
    SLENDER,
    SPARE_MM,
    Columns,
    bolt_place,
    most_draft,
    pin_height,
    pin_place,
    z_bolt_height,
)

KEY_MM = 2.0  # most height of a key
_PASSING_MM = 0.2  # between a key and a pin that passes over it
_LEAST_PIN = 0.4  # of its diameter: a shorter pin guides nothing
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
    """The plan with every bolt, pin and key; what cannot be had is a fault of
    :func:`fastener_faults`."""
    plan = replace(plan, wall_x=columns.wall_x, wall_z=columns.wall_z, ear=columns.ear)
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
    bolts += [Bolt("y", x, z, -plan.base, plan.top, *of) for x, z in upright]
    for side, x, z, small in insert_pins(plan, columns, level is None):
        pins.append(_insert_pin(body, plan, columns, x, z, small, wall_name(side)))
    keys = _keys(plan, columns)
    return replace(plan, bolts=tuple(bolts), pins=tuple(pins), keys=tuple(keys))


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


def _insert_pin(
    body: Body, plan: MoldPlan, columns: Columns, x: float, z: float, small: bool, into: str
) -> Pin:
    """A pin below the insert: its root is at the greatest height of the walls' top around it."""
    steps = columns.socket * np.array([-1.0, 0.0, 1.0])
    around = [seam_height(body, plan, x + i, z + k) for i, k in product(steps, steps)]
    diameter = columns.small if small else columns.big
    length = insert_pin_length(plan, columns, diameter, min(around)) + max(around) - min(around)
    return _pin(columns, (x, max(around), z), (0.0, -1.0, 0.0), small, length, INSERT, into)


def insert_pin_length(plan: MoldPlan, columns: Columns, diameter: float, seam: float) -> float:
    """How deep a pin below the insert reaches into a wall that is ``seam`` high."""
    most = seam - columns.gap - columns.clearance
    if columns.limits.dowels:
        most = min(most, plan.top - plan.crest - columns.gap)
    return min(SLENDER * diameter, most)


def key_height(plan: MoldPlan, columns: Columns) -> float:
    """Height of the keys: half the wall's at most, with a wall left above the groove, and below the
    pins along z, which pass over them when the side walls are drawn."""
    rim = plan.rim
    most = min(KEY_MM, 0.5 * rim, rim - columns.gap - columns.clearance)
    both, level = pin_height(plan, columns, small=False), pin_height(plan, columns)
    if both is not None:
        return min(most, both - 0.5 * columns.big - _PASSING_MM)
    return most if level is None else min(most, level - 0.5 * columns.small - _PASSING_MM)


def _keys(plan: MoldPlan, columns: Columns) -> list[Key]:
    """Ribs beside the side walls, from the end walls' inner faces to the insert's pins' sockets."""
    found = []
    height = key_height(plan, columns)
    start = plan.corner + 0.5 * columns.clearance
    end = columns.deep - columns.socket - columns.gap - columns.clearance
    for (side, way), (_, sign) in CORNERS:
        half = 0.5 * (columns.small if way > 0 else columns.big)
        near, far = sorted((way * start, way * end))
        low = (sign * columns.x3 - half, 0.0, near)
        high = (sign * columns.x3 + half, height, far)
        found.append(Key(low, high, columns.draft_deg, columns.clearance, wall_name(side)))
    return found


_LEAST_KEY_MM = 0.3


def limit_faults(mold: Mold, limits: Limits, reach: float) -> list[Fault]:
    """Limits that contradict each other, and plates of the mold below the process's wall; pins
    reach as far as ``reach`` into their sockets."""
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
    walls, holes = ("insert_mm", "base_mm"), ("gate_mm", "vent_mm", "lock_mm")
    for key in (*walls, *holes):
        size = getattr(mold, key)
        least = limits.wall_mm if key in walls else limits.hole_mm
        if size is not None and size < least:
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
    key = limits.feature_mm + lean * KEY_MM
    return max(least, key, (limits.feature_mm + lean * rest) / slope)


def fastener_faults(mold: Mold, plan: MoldPlan, columns: Columns) -> list[Fault]:
    """What of bolts, pins and keys does not fit the walls of a mold."""
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
    most = rim - _LEAST_PIN * columns.big - columns.clearance - SPARE_MM
    most = min(most, rim - _LEAST_KEY_MM - columns.clearance - SPARE_MM)
    if wall > most + 1e-9:
        of = {"most": most, "rim": rim, "columns": columns, "higher": wall - most}
        faults.append(refusal("low_walls", "mold.limits.wall_mm", wall, **of))
    return faults


def _draft_faults(mold: Mold, plan: MoldPlan, columns: Columns) -> list[Fault]:
    least = columns.limits.feature_mm
    bounds = {"keys": most_draft(columns.small, max(key_height(plan, columns), 1e-3), least)}
    if not columns.limits.dowels:
        longest = insert_pin_length(plan, columns, columns.small, plan.rim)
        if pin_height(plan, columns) is not None:
            longest = max(longest, columns.reach)
        bounds["pins"] = most_draft(columns.small, max(longest, 1e-3), least)
    what = min(bounds, key=lambda each: bounds[each])
    most = bounds[what]
    if mold.draft_deg <= most or (most <= 0.0 and mold.limits.pin_mm is not None):
        return []  # the pin that is too thin is refused
    if most <= 0.0:
        return [refusal("webs_on_pins", "mold.limits.feature_mm", least, columns=columns)]
    of = {"most": most, "what": what, "columns": columns, "limits": columns.limits}
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
