"""Bolts and pins: what clamps the mold's parts and brings them to their places; mm.

z-bolts clamp end wall, side walls and end wall; where the side walls are too low for one (or a
window is in its way), y-bolts clamp them between insert and base plate. y-bolts go through insert,
end walls and base plate. Tapered pins along z reach out of the side walls' ends, others below the
insert; where a pin along z does not fit, the insert's pins locate the side walls, too. One pin of
each kind differs in size: parts fit one way only. The base plate, whose place counts little, lies
in a frame that is bolted below the walls.
"""

import math
from dataclasses import replace
from itertools import product

import numpy as np

from fingerdesign.mold.part import INSERT
from fingerdesign.mold.plan.extent import seam_height
from fingerdesign.mold.plan.fasteners.columns import CORNERS, FLANKS, LEDGE_MM, ONE, Columns, Fit
from fingerdesign.mold.plan.limits import SLENDER, SPARE_MM
from fingerdesign.mold.plan.pieces import Bolt, Pin
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.refusals import Refusal

FOOTPRINT = 2.0  # area of the mount over that of the finger's base, at most
LEAST_LEDGE_MM = 0.5  # the mount reaches so far beyond the finger, at least
LEAST_PIN = 0.4  # length over diameter: a shorter pin guides nothing
LIP_MM = 2.0  # thickness of the base frame below the base plate, at least


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


def fastened(plan: MoldPlan, fit: Fit) -> MoldPlan:
    """Add every bolt and pin of a closed mold, of whose fit nothing is refused."""
    columns, height = fit.columns, fit.bolt_height
    lip, walls = max(LIP_MM, columns.gap), (columns.wall_x, columns.wall_z)
    plan = replace(plan, wall_x=walls[0], wall_z=walls[1], ear=columns.ear, lip=lip)
    middle = fit.pin_height if fit.both is None else fit.both
    of = (columns.size, columns.hole)
    bolts, pins = list[Bolt](), list[Pin]()
    if height is not None:
        reach = plan.reach_z
        bolts = [Bolt("z", sign * columns.x1, height, -reach, reach, *of) for _, sign in FLANKS]
    for (end, way), (flank, sign) in CORNERS if middle is not None else ():
        small = fit.both is None or (end, flank) == ONE
        root = (sign * columns.x2, middle or 0.0, way * plan.corner)
        on, into = plan.by_side[flank].wall, plan.by_side[end].wall
        pins.append(_pin(columns, root, (0.0, 0.0, way), small, columns.reach, on, into))
    upright = [(sign * columns.x2, way * columns.deep) for (_, way), (_, sign) in CORNERS]
    upright += [(x, z) for _, x, z in fit.bolts]
    bolts += [Bolt("y", x, z, -plan.base - lip, plan.top, *of) for x, z in upright]
    for side, x, z, small in fit.pins:
        pins.append(insert_pin(plan, columns, (x, z), small, plan.by_side[side].wall))
    return replace(plan, bolts=tuple(bolts), pins=tuple(pins))


def with_mount(plan: MoldPlan) -> MoldPlan:
    """The plan with its base plate's size: beyond finger and combs by a ledge, so that its area is
    at most FOOTPRINT times that of the finger's base, but for very small fingers."""
    sheets = max(side.sheet for side in plan.sides)
    a, b = 2.0 * plan.half_width, 2.0 * (plan.half_depth + sheets)
    base = 2.0 * a * plan.half_depth * (0.25 * math.pi if plan.design.body.kind.turned else 1.0)
    # (a + 2 l) (b + 2 l) is the plate's area.
    room = (a + b) ** 2 - 4.0 * (a * b - FOOTPRINT * base)
    ledge = min(max(0.25 * (math.sqrt(max(room, 0.0)) - a - b), LEAST_LEDGE_MM), LEDGE_MM)
    return replace(plan, mount_x=0.5 * a + ledge, mount_z=0.5 * b + ledge)


def insert_pin(
    plan: MoldPlan, columns: Columns, place: tuple[float, float], small: bool, into: str
) -> Pin:
    """A pin below the insert at (x, z), its root at the greatest height of the walls' top there."""
    x, z = place
    steps = columns.socket * np.array([-1.0, 0.0, 1.0])
    around = [seam_height(plan, x + i, z + k) for i, k in product(steps, steps)]
    diameter = columns.small if small else columns.big
    length = insert_pin_length(plan, columns, diameter, min(around)) + max(around) - min(around)
    return _pin(columns, (x, max(around), z), (0.0, -1.0, 0.0), small, length, INSERT, into)


def insert_pin_length(plan: MoldPlan, columns: Columns, diameter: float, seam: float) -> float:
    """Depth to which a pin below the insert reaches into a wall that is ``seam`` high; half frames
    may end short of the base plate."""
    short = columns.limits.seam_mm if plan.pour == "open" else 0.0
    most = seam - short - columns.gap - columns.clearance
    if columns.limits.dowels:
        most = min(most, plan.top - plan.crest - columns.gap)
    return min(SLENDER * diameter, most)


def most_draft(diameter: float, length: float, least: float) -> float:
    """The draft at which a tapered pin's tip, or a rib's edge, is still ``least`` wide, degrees."""
    return math.degrees(math.atan(max(diameter - least, 0.0) / (2.0 * length)))


def fastener_refusals(plan: MoldPlan, fit: Fit) -> list[Refusal]:
    """Refuse bolts and pins that do not fit the walls of a closed mold."""
    mold, columns, found = plan.design.mold, fit.columns, list[Refusal]()
    if mold.wall_mm is not None and mold.wall_mm < columns.wall_z - 1e-9:
        numbers = {"limits": columns.limits, "columns": columns}
        found.append(Refusal("thin_end_walls", "mold.wall_mm", mold.wall_mm, numbers))
    return [
        *found,
        *_low_walls(plan, columns, fit.bolt_height is None),
        *_pointed_pins(plan, columns, fit.pin_height is not None),
        *_no_room(plan, fit),
    ]


def _low_walls(plan: MoldPlan, columns: Columns, low: bool) -> list[Refusal]:
    """Refuse walls too low for the bolt that was requested, or for anything."""
    found, rim, wall = list[Refusal](), plan.rim, columns.limits.wall_mm
    if (bolt := plan.design.mold.bolt) != "auto" and low:
        numbers = {"rim": rim, "columns": columns}
        found.append(Refusal("big_bolt", "mold.bolt", bolt, numbers))
    most = rim - LEAST_PIN * columns.big - columns.clearance - SPARE_MM
    if wall > most + 1e-9:
        of = {"most": most, "rim": rim, "columns": columns, "higher": wall - most}
        kind = "thick_walls" if most > 0 else "low_walls"
        found.append(Refusal(kind, "mold.limits.wall_mm", wall, of))
    return found


def _pointed_pins(plan: MoldPlan, columns: Columns, level: bool) -> list[Refusal]:
    """Refuse pins without a tip; ``level``: there are pins along z, too."""
    if columns.limits.dowels:
        return []
    mold, least = plan.design.mold, columns.limits.feature_mm
    longest = insert_pin_length(plan, columns, columns.small, plan.rim)
    if level:
        longest = max(longest, columns.reach)
    most = most_draft(columns.small, max(longest, 1e-3), least)
    if mold.draft_deg <= most or (most <= 0.0 and mold.limits.pin_mm is not None):
        return []  # the pin that is too thin is refused
    if most <= 0.0:
        return [Refusal("webs_on_pins", "mold.limits.feature_mm", least, {"columns": columns})]
    of = {"most": most, "columns": columns, "limits": columns.limits}
    return [Refusal("great_draft", "mold.draft_deg", mold.draft_deg, of)]


def _no_room(plan: MoldPlan, fit: Fit) -> list[Refusal]:
    """Refuse upright bolts and pins without a place next to what the walls hold."""
    found, columns, low = list[Refusal](), fit.columns, fit.bolt_height is None
    bolt = plan.design.mold.bolt
    bolts = fit.bolts if bolt == "auto" or not low else ()
    lacking = next((side for side, x, z in bolts if math.isnan(x + z)), None)
    if lacking is not None:
        length = 2.0 * (plan.corner if lacking.endswith("x") else plan.half_width)
        of = {"side": lacking, "columns": columns, "rim": plan.rim, "length": length}
        found.append(Refusal("no_low_bolt" if low else "no_bolt", "mold.bolt", bolt, of))
    lacking = next((side for side, x, z, _ in fit.pins if math.isnan(x + z)), None)
    if lacking is not None:
        room = 2.0 * (0.5 * columns.small + columns.clearance + columns.gap)
        key, pin = "mold.limits.pin_mm", columns.limits.pin_mm
        found.append(Refusal("no_pin", key, pin, {"side": lacking, "room": room}))
    return found
