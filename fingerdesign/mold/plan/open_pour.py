"""The open mold, of the fewest parts that a finger can be cast in: whether it can be, and its plan.

Contact insert, two half frames that meet at z = 0, and the base plate, which is pressed on last:
four parts, and where plates leave a comb in each frame's end and another on its outer face. It is
filled from above, so that no gate, riser or vent is needed. Two bolts along z clamp the frames;
four pins below the insert place both, lugs on the frames place the base plate, which is little
larger than the finger's base: its mount. Numbers only, mm.
"""

from dataclasses import replace

from fingerdesign.design.body import Body
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.mold.plan.base import open_holes_of
from fingerdesign.mold.plan.fasteners import (
    CORNERS,
    ENDS,
    FLANKS,
    LEAST_PIN,
    SLENDER,
    Columns,
    columns_of,
    insert_pin,
    insert_pin_length,
    most_draft,
    with_mount,
    z_bolt_height,
)
from fingerdesign.mold.plan.leg_room import Fixture, seam_of
from fingerdesign.mold.plan.outer import held_twice
from fingerdesign.mold.plan.plan import (
    SIDES,
    SPARE_MM,
    Bolt,
    Extent,
    Limits,
    Lug,
    MoldPlan,
    Pin,
    Side,
    SidePlan,
    frame_name,
    limits_of,
    refusal,
)

_END_WALLS = 3.0  # of the process's least wall, behind the comb: it is drawn by its end
# Between a comb and the outer one, which bends each plate's middle off its place, the less the
# farther they are apart (outer.bow): 0.006 mm of it are less than a comb's own tolerance.
_HELD_MM = 6.0
_LUG_MM = 2.0  # height of a lug, at most
_LUG_LONG_MM = 6.0  # at most
AUTO_BOLTS = ("M3", "M2.5", "M2")


def open_plan(
    design: Design, fixture: Fixture, extent: Extent
) -> tuple[MoldPlan | None, str | Fault]:
    """The plan of a finger's open mold; else None, and what of the finger needs a closed one, or
    the fault of walls that are given too thin."""
    why = _needs_walls(design, fixture, extent)
    if why:
        return None, why
    mold, limits = design.mold, limits_of(design.mold)
    plan = MoldPlan(
        **vars(extent),
        scale=fixture.scale,
        frames=fixture.frames,
        legs=fixture.legs,
        sides=tuple(_side(fixture, extent, side) for side in SIDES),
        plugs=(),
        top=extent.crest + mold.insert_mm,
        base=mold.base_mm,
        pour="open",
    )
    sizes = AUTO_BOLTS if mold.bolt == "auto" else (mold.bolt,)
    tried = [_columns(design, plan, columns_of(plan, mold, limits, size, True)) for size in sizes]
    # Bolts that leave room for a seam go before larger ones that do not.
    floors = (seam_of(limits), 0.0) if fixture.legs else (0.0,)
    fits = (c for floor in floors for c in tried if z_bolt_height(plan, c, floor) is not None)
    columns = next(fits, None)
    if columns is None:
        return None, f"its walls, {extent.rim:.3g} mm high, hold no bolt along z"
    why = _too_small(plan, columns)
    if why:
        return None, why
    if mold.wall_mm is not None and mold.wall_mm < columns.wall_z - 1e-9:
        of = {"limits": limits, "least": columns.wall_z}
        return None, refusal("thin_frames", "mold.wall_mm", mold.wall_mm, **of)
    plan = with_mount(design.body, plan)
    holes, lacking = open_holes_of(design, plan, limits)
    if lacking:
        return None, lacking[0]
    wall_z = _wall(design, columns.wall_z, max(side.sheet for side in plan.sides))
    plan = replace(plan, wall_x=columns.wall_x, wall_z=wall_z, base_holes=holes)
    plan = _mounted(_fastened(design.body, plan, columns), limits)
    plan = held_twice(design, plan, limits, columns.x1 + 0.5 * columns.hole)
    proud = max((side.sheet for side in plan.sides if side.outer), default=0.0)
    bolts = tuple(replace(b, low=b.low - proud, high=b.high + proud) for b in plan.bolts)
    return replace(plan, bolts=bolts), ""


def _needs_walls(design: Design, fixture: Fixture, extent: Extent) -> str:
    """What of a finger cannot be cast between two half frames; "": nothing."""
    body = design.body
    if body.core is not None:
        return "a core keeps air below it and is held by pins or screws"
    if body.step is not None and not extent.continued:
        return "the sides of a STEP body that are not flat may hold half frames"
    if any(leg.side.endswith("x") for leg in fixture.legs):
        return "plates leave at the right and left, across the draw of half frames"
    if fixture.plugs:
        return "plates leave through the contact surface, and the insert ends short of them"
    return ""


def _side(fixture: Fixture, extent: Extent, side: Side) -> SidePlan:
    """A side's plan; the window behind a comb is no wider than the comb, which is the finger's."""
    planned = fixture.side(side)
    if not side.endswith("z"):
        return planned
    window = planned.window
    if window is not None:
        half = extent.half_width
        window = (max(window[0], -half), min(window[1], half), window[2])
    return replace(planned, window=window, framed=True)


def _wall(design: Design, least: float, sheets: float) -> float:
    """The thickness of the frames' ends: given, else what they need and what combs stand apart."""
    if design.mold.wall_mm is not None:
        return max(design.mold.wall_mm, least)
    return max(least, _HELD_MM) if sheets else least


def _columns(design: Design, plan: MoldPlan, columns: Columns) -> Columns:
    """Columns of an open mold: bolts nearest to the finger, then pins."""
    limits, gap = columns.limits, columns.gap
    sheets = max(side.sheet for side in plan.sides)
    x3 = columns.x2
    reach_x = x3 + max(columns.radius, columns.socket) + gap
    least = 2.0 * (columns.socket + gap)  # the insert's pins, in each frame
    wall_z = max(sheets + _END_WALLS * limits.wall_mm, least - plan.half_depth)
    reach_z = plan.half_depth + _wall(design, wall_z, sheets)
    return replace(
        columns,
        reach=SLENDER * columns.small,
        x3=x3,
        deep=reach_z - gap - columns.socket,
        wall_x=reach_x - plan.half_width,
        ear=0.0,
        wall_z=wall_z,
    )


def _too_small(plan: MoldPlan, columns: Columns) -> str:
    """Why an open mold has no room for pins; "": it has."""
    if plan.rim - columns.gap - columns.clearance < LEAST_PIN * columns.big:
        return f"its walls, {plan.rim:.3g} mm high, hold no pins"
    if not columns.limits.dowels:
        long = insert_pin_length(plan, columns, columns.small, plan.rim)
        most = most_draft(columns.small, max(long, 1e-3), columns.limits.feature_mm)
        if columns.draft_deg > most:
            return f"mold.draft_deg above {most:.3g} leaves its pins no tips"
    return ""


def _fastened(body: Body, plan: MoldPlan, columns: Columns) -> MoldPlan:
    """The plan with its two bolts and four pins, of which one is small."""
    height = z_bolt_height(plan, columns, seam_of(columns.limits))
    height = z_bolt_height(plan, columns) if height is None else height
    assert height is not None
    reach, of = plan.reach_z, (columns.size, columns.hole)
    bolts = [Bolt("z", sign * columns.x1, height, -reach, reach, *of) for _, sign in FLANKS]
    pins: list[Pin] = []
    for (side, way), (_, sign) in CORNERS:
        small = way > 0.0 and sign > 0.0
        x, z = sign * columns.x3, way * columns.deep
        pins.append(insert_pin(body, plan, columns, (x, z), small, frame_name(side)))
    return replace(plan, bolts=tuple(bolts), pins=tuple(pins))


def _mounted(plan: MoldPlan, limits: Limits) -> MoldPlan:
    """The plan with its mount, and with the lugs of each frame: two beside it, one at its end."""
    x, z = plan.mount_x, plan.mount_z
    thick, high = limits.wall_mm + SPARE_MM, min(_LUG_MM, 0.5 * plan.base)
    near, long = limits.clearance_mm, max(min(_LUG_LONG_MM, x, 0.5 * z), limits.wall_mm)
    lugs = []
    for side, way in ENDS:
        for _, sign in FLANKS:
            left, right = sorted((sign * (x + near), sign * (x + near + thick)))
            low, far = sorted((way * (z - long), way * z))
            lugs.append(Lug((left, -high, low), (right, 0.0, far), frame_name(side)))
        low, far = sorted((way * (z + near), way * (z + near + thick)))
        lugs.append(Lug((-0.5 * long, -high, low), (0.5 * long, 0.0, far), frame_name(side)))
    return replace(plan, lugs=tuple(lugs))
