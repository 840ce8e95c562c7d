"""The open mold, of the fewest parts that a finger can be cast in.

Contact insert, two half frames that meet at z = 0, and the base plate, which is pressed on last:
four parts, and where plates leave a comb in each frame's end and another on its outer face. It is
filled from above, so that no gate, riser or vent is needed. Two bolts along z clamp the frames;
four pins below the insert place both, lugs on the frames place the base plate, which is little
larger than the finger's base: its mount; mm.
"""

from dataclasses import replace

from fingerdesign.mold.plan.base import open_holes_of
from fingerdesign.mold.plan.fasteners import columns as places
from fingerdesign.mold.plan.fasteners import fasteners
from fingerdesign.mold.plan.fasteners.columns import CORNERS, ENDS, FLANKS, Columns
from fingerdesign.mold.plan.fixture.fixture import Fixture
from fingerdesign.mold.plan.fixture.outer import with_outer_combs
from fingerdesign.mold.plan.limits import SLENDER, SPARE_MM
from fingerdesign.mold.plan.pieces import RELIEF_MM, Bolt, Lug, Pin, SidePlan
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.refusals import Refusal

# The end of a frame behind its comb, over the process's least wall: the frame is drawn by it.
_END_WALLS = 3.0
# Distance of a comb from the outer one, which bends each plate's middle off its place, the less the
# farther they are apart (outer.bow): 0.006 mm of it are less than a comb's own tolerance.
_COMBS_APART_MM = 6.0
_LUG_MM = 2.0  # height of a lug, at most
_LUG_LONG_MM = 6.0  # at most


def open_plan(fixture: Fixture, outline: MoldPlan) -> MoldPlan | Refusal | str:
    """Plan a finger's open mold from its ``outline`` (legs, sides, plugs).

    Else what of the finger needs a closed one, in words; or the refusal of what was given.
    """
    if why := _needs_walls(outline):
        return why
    plan = replace(outline, sides=tuple(_framed(s, outline) for s in outline.sides), pour="open")
    columns = _columns(plan)
    if columns is None:
        return f"its walls, {plan.rim:.3g} mm high, hold no bolt along z"
    if why := _too_small(plan, columns):
        return why
    given, limits = plan.design.mold.wall_mm, plan.limits
    if given is not None and given < columns.wall_z - 1e-9:
        numbers = {"limits": limits, "least": columns.wall_z}
        return Refusal("thin_frames", "mold.wall_mm", given, numbers)
    wall_z = _wall(given, columns.wall_z, max(side.sheet for side in plan.sides))
    plan = fasteners.with_mount(replace(plan, wall_x=columns.wall_x, wall_z=wall_z))
    plan = _with_lugs(_fastened(plan, columns))
    plan = with_outer_combs(fixture, plan, columns.x1 + 0.5 * columns.hole)
    proud = max((side.sheet for side in plan.sides if side.outer), default=0.0)
    bolts = tuple(replace(b, low=b.low - proud, high=b.high + proud) for b in plan.bolts)
    holes = open_holes_of(plan)
    return holes if isinstance(holes, Refusal) else replace(plan, bolts=bolts, base_holes=holes)


def _needs_walls(plan: MoldPlan) -> str:
    """Name what of a finger cannot be cast between two half frames; "": nothing."""
    body = plan.design.body
    if body.core is not None:
        return "a core keeps air below it and is held by pins or screws"
    if body.step is not None and not plan.continued:
        return "the sides of a STEP body that are not flat may hold half frames"
    if any(leg.side.endswith("x") for leg in plan.legs):
        return "plates leave at the right and left, across the draw of half frames"
    if plan.plugs:
        return "plates leave through the contact surface, and the insert ends short of them"
    return ""


def _framed(planned: SidePlan, plan: MoldPlan) -> SidePlan:
    """Close an end by a half frame; its window is no wider than the comb, which is the finger's."""
    if not planned.side.endswith("z"):
        return planned
    window = planned.window
    if window is not None:
        window = (max(window[0], -plan.half_width), min(window[1], plan.half_width), window[2])
    return replace(planned, window=window, framed=True)


def _wall(given: float | None, least: float, sheets: float) -> float:
    """Thickness of the frames' ends: given, else what they and the distance of the combs need."""
    if given is not None:
        return max(given, least)
    return max(least, _COMBS_APART_MM) if sheets else least


def _columns(plan: MoldPlan) -> Columns | None:
    """Place the columns of an open mold: bolts nearest to the finger, then pins; None where no bolt
    fits. Bolts that leave room for a seam go before larger ones that do not."""
    tried = [_widened(plan, each) for each in places.columns_by_size(plan, True)]
    floors = (plan.limits.seam_mm, 0.0) if plan.legs else (0.0,)
    every = ((columns, floor) for floor in floors for columns in tried)
    return next((c for c, floor in every if places.z_bolt_height(plan, c, floor) is not None), None)


def _widened(plan: MoldPlan, columns: Columns) -> Columns:
    limits, gap = columns.limits, columns.gap
    sheets = max(side.sheet for side in plan.sides)
    reach_x = columns.x2 + max(columns.radius, columns.socket) + gap
    relief = RELIEF_MM if sheets else 0.0  # the insert's pins keep their wall under outer combs
    least = 2.0 * (columns.socket + gap) + relief  # the insert's pins, in each frame
    wall_z = max(sheets + _END_WALLS * limits.wall_mm, least - plan.half_depth)
    reach_z = plan.half_depth + _wall(plan.design.mold.wall_mm, wall_z, sheets)
    reach, deep = SLENDER * columns.small, reach_z - relief - gap - columns.socket
    placed = replace(columns, reach=reach, x3=columns.x2, deep=deep)
    return replace(placed, wall_x=reach_x - plan.half_width, ear=0.0, wall_z=wall_z)


def _too_small(plan: MoldPlan, columns: Columns) -> str:
    """Say why an open mold has no room for pins; "": it has."""
    if plan.rim - columns.gap - columns.clearance < fasteners.LEAST_PIN * columns.big:
        return f"its walls, {plan.rim:.3g} mm high, hold no pins"
    if not columns.limits.dowels:
        long = fasteners.insert_pin_length(plan, columns, columns.small, plan.rim)
        most = fasteners.most_draft(columns.small, max(long, 1e-3), columns.limits.feature_mm)
        if columns.draft_deg > most:
            return f"mold.draft_deg above {most:.3g} leaves its pins no tips"
    return ""


def _fastened(plan: MoldPlan, columns: Columns) -> MoldPlan:
    """Add two bolts and four pins, of which one is small."""
    height = places.z_bolt_height(plan, columns, columns.limits.seam_mm)
    height = places.z_bolt_height(plan, columns) if height is None else height
    assert height is not None
    reach, of = plan.reach_z, (columns.size, columns.hole)
    bolts = [Bolt("z", sign * columns.x1, height, -reach, reach, *of) for _, sign in FLANKS]
    pins: list[Pin] = []
    for (side, way), (_, sign) in CORNERS:
        small = way > 0.0 and sign > 0.0
        x, z = sign * columns.x3, way * columns.deep
        pins.append(fasteners.insert_pin(plan, columns, (x, z), small, plan.by_side[side].wall))
    return replace(plan, bolts=tuple(bolts), pins=tuple(pins))


def _with_lugs(plan: MoldPlan) -> MoldPlan:
    """Add the lugs of each frame around the mount: two at its flanks, one at its end."""
    x, z, limits = plan.mount_x, plan.mount_z, plan.limits
    thick, high = limits.wall_mm + SPARE_MM, min(_LUG_MM, 0.5 * plan.base)
    near, long = limits.clearance_mm, max(min(_LUG_LONG_MM, x, 0.5 * z), limits.wall_mm)
    lugs = []
    for side, way in ENDS:
        frame = plan.by_side[side].wall
        for _, sign in FLANKS:
            left, right = sorted((sign * (x + near), sign * (x + near + thick)))
            low, far = sorted((way * (z - long), way * z))
            lugs.append(Lug((left, -high, low), (right, 0.0, far), frame))
        low, far = sorted((way * (z + near), way * (z + near + thick)))
        lugs.append(Lug((-0.5 * long, -high, low), (0.5 * long, 0.0, far), frame))
    return replace(plan, lugs=tuple(lugs))
