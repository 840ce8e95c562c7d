"""Design -> MoldPlan: every number of a mold, or every reason why there is none.

Cast with the base up, tilted by ``base.TILT_DEG`` toward the first vent of ``base_holes``, in
the corner +x +z: ``base.pour_up`` points up. The highest place of the rubber is then that
corner of the base (of a round base: its rim there); a backing core that parts the base leaves more
such places, each with a vent of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from fingerdesign.checks.load import with_values
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.mold.plan.base import base_holes_of, core_pins_of
from fingerdesign.mold.plan.extent import Extent, extent_of, seam_height
from fingerdesign.mold.plan.fasteners import fastener_faults, fasteners_of, limit_faults
from fingerdesign.mold.plan.fixture_faults import fixture_faults, with_walls
from fingerdesign.mold.plan.leg_room import Fixture
from fingerdesign.mold.plan.legs import fixture_of
from fingerdesign.mold.plan.plan import (
    SIDES,
    Limits,
    MoldPlan,
    limits_of,
)
from fingerdesign.mold.plan.slots import scale_of
from fingerdesign.mold.plan.walls import Columns, Walls, columns_of, pin_height, z_bolt_height

# Remedies with numbers for faults of room: found by planning the mold again with another value.

_UP = (1.05, 1.1, 1.2, 1.3, 1.5, 1.75, 2.0, 2.5)
_DOWN = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)
_BOLT, _PIN, _WALL = "mold.bolt", "mold.limits.pin_mm", "mold.limits.wall_mm"
_GATE, _VENT, _HOLE = "mold.gate_mm", "mold.vent_mm", "mold.limits.hole_mm"
_HEIGHT, _WIDTH, _DEPTH = "body.base_height_mm", "body.width_mm", "body.depth_mm"
_PROCESS = "mold.process"
# Faults that one change may mend together -> the keys that are tried.
_GROUPS: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = (
    ((_BOLT, _PIN, _WALL), (_HEIGHT, _DEPTH, _WALL, _PIN, _PROCESS)),
    ((_GATE, _VENT), (_HOLE, _WIDTH, _DEPTH, _WALL, _PROCESS)),
)


def _with_remedies(design: Design, faults: list[Fault]) -> list[Fault]:
    """The same faults; where one of room has a change of one key that mends it, its remedy says so.

    A change is named only if a design with it has none of the faults of its group any more, and no
    new ones.
    """
    before = {fault.key for fault in faults}
    for keys, tried in _GROUPS:
        group = {fault.key for fault in faults if fault.key in keys}
        if not group:
            continue
        found = [text for key in tried if (text := _mended(design, key, group, before))]
        if found:
            remedy = f"one of these mends it: {'; '.join(found)}"
            faults = [replace(f, remedy=remedy) if f.key in group else f for f in faults]
    return faults


def _mended(design: Design, key: str, group: set[str], before: set[str]) -> str:
    """The first change of a key that mends a group of faults, as in a design file; "" for none."""
    for values in _candidates(design, key):
        try:
            after = {fault.key for fault in _planned(with_values(design, dict(values)))[1]}
        except DesignError:
            continue
        if not after & group and after <= before:
            return ", ".join(f"{name} = {_said(value)}" for name, value in values.items())
    return ""


def _candidates(design: Design, key: str) -> Iterator[Mapping[str, float | str]]:
    """Values of a key, the nearest to what it is first; a round body's width is its depth."""
    body, process = design.body, design.mold.process
    if key == _PROCESS:
        yield from ({key: name} for name in ("sla", "machined", "fdm") if name != process)
    elif key.startswith("body."):
        if body.step is not None:
            return
        name = key.removeprefix("body.")
        if name == "depth_mm" and body.kind.turned:
            return
        also = {_DEPTH} if name == "width_mm" and body.kind.turned else set[str]()
        now = float(getattr(body, name))
        for share in _UP:
            value = round(share * now, 1)
            if value > now:
                yield dict.fromkeys((key, *also), value)
    else:
        now = float(getattr(limits_of(design.mold), key.removeprefix("mold.limits.")))
        yield from ({key: round(share * now, 2)} for share in _DOWN)


def _said(value: float | str) -> str:
    return f"'{value}'" if isinstance(value, str) else f"{value:g}"


AUTO_BOLTS = ("M3", "M2.5", "M2")
CORNERS = (1.0, 0.85, 0.7, 0.5)  # of the outermost |z| at which end and side walls may meet


def plan_mold(design: Design) -> MoldPlan:
    """The plan of a sound design's mold.

    Up while casting is ``base.pour_up(plan)``: the base up, tilted so that the first vent's corner
    is the highest place of the rubber. Raises DesignError with every fault.
    """
    plan, faults = _planned(design)
    if plan is None:
        raise DesignError(_with_remedies(design, faults), design.design.name)
    return plan


def mold_faults(design: Design) -> list[Fault]:
    """Every fault that keeps a sound design's mold from being made; empty where it can be."""
    return _with_remedies(design, _planned(design)[1])


def _planned(design: Design) -> tuple[MoldPlan | None, list[Fault]]:
    """The plan, or its faults, remedies of room left out."""
    mold = design.mold
    limits, scale = limits_of(mold), scale_of(design)
    fixture = fixture_of(design)
    extent, unheld = _parted(fixture, extent_of(design, scale))
    sides = tuple(fixture.side(side) for side in SIDES)
    core_pins, no_pins = core_pins_of(design, scale, sides, limits)
    holes, no_room = base_holes_of(design, extent, scale, limits)

    def seam(x: float, z: float) -> float:
        return seam_height(design, extent, scale, x, z)

    walls = Walls(
        extent=extent,
        sides=sides,
        plugs=fixture.plugs,
        core_pins=core_pins,
        tips={side: max((leg.tip for leg in fixture.on(side)), default=0.0) for side in SIDES},
        seam=seam,
        top=extent.crest + mold.insert_mm,
        base=mold.base_mm,
        draft_deg=mold.draft_deg,
        dowels=limits.dowels,
    )
    columns = _columns(walls, limits, mold.bolt)
    faults = [
        *limit_faults(mold, limits, columns.reach),
        *unheld,
        *no_pins,
        *no_room,
        *fastener_faults(mold, limits, walls, columns),
    ]
    if faults:
        return None, list({str(fault): fault for fault in faults}.values())
    if mold.wall_mm is not None:
        columns = replace(columns, wall_z=mold.wall_mm)
    plan = MoldPlan(
        scale=scale,
        frames=fixture.frames,
        legs=fixture.legs,
        sides=sides,
        plugs=walls.plugs,
        half_width=extent.half_width,
        half_depth=extent.half_depth,
        corner=extent.corner,
        rim=extent.rim,
        crest=extent.crest,
        top=walls.top,
        wall_x=columns.wall_x,
        wall_z=columns.wall_z,
        ear=columns.ear,
        base=walls.base,
        **fasteners_of(walls, columns),
        base_holes=holes,
        core_pins=core_pins,
    )
    return plan, []


def _parted(fixture: Fixture, extent: Extent) -> tuple[Extent, list[Fault]]:
    """The extent with end and side walls parted where legs leave through the right ones, and the
    faults that are left: a round or tapering body may be parted at any of several |z|."""
    held = fixture_faults(fixture)
    shares = (1.0,) if extent.continued or not fixture.legs else CORNERS
    found = []
    for share in shares:
        trial = replace(extent, corner=share * extent.corner)
        faults = with_walls(fixture, held, trial.corner)
        found.append((trial, faults))
        if not faults:
            break
    return min(found, key=lambda each: len(each[1]))


def _columns(walls: Walls, limits: Limits, bolt: str) -> Columns:
    """Columns for the given bolts, or for the largest of ``AUTO_BOLTS`` that fit along z."""
    thick = {p.side: p.sheet * {"comb": 1, "jig": 2}.get(p.holding, 0) for p in walls.sides}
    sheets, beside = max(thick["+z"], thick["-z"]), max(thick["+x"], thick["-x"])
    ends = [planned for planned in walls.sides if planned.side.endswith("z")]
    open_ends = [planned.side for planned in ends if planned.window is not None]
    tips = max((walls.tips[side] for side in open_ends), default=0.0)
    bar, plugged = walls.plug("x") is not None, walls.plug("z") is not None

    def of(size: str, wide: bool) -> Columns:
        return columns_of(walls.extent, limits, size, sheets, beside, tips, bar, wide)

    sizes = AUTO_BOLTS if bolt == "auto" else (bolt,)
    size = next((s for s in sizes if z_bolt_height(walls, of(s, plugged)) is not None), sizes[-1])
    low = pin_height(walls, of(size, plugged)) is None and not bar
    return of(size, plugged or low)
