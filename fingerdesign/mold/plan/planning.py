"""Design -> MoldPlan: every number of a mold, or every reason why there is none."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from fingerdesign.checks.load import with_values
from fingerdesign.design.mold import Mold
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.mold.plan.base import base_holes_of, core_pins_of
from fingerdesign.mold.plan.fasteners import (
    Columns,
    columns_of,
    fastened,
    fastener_faults,
    limit_faults,
    pin_height,
    z_bolt_height,
)
from fingerdesign.mold.plan.fixture_faults import fixture_faults, with_walls
from fingerdesign.mold.plan.leg_room import Fixture
from fingerdesign.mold.plan.legs import fixture_of
from fingerdesign.mold.plan.plan import SIDES, Extent, Limits, MoldPlan, limits_of

# Remedies for faults of room are found by planning the mold again, a value so many times as large.
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
            said = (f"{v:g}" if isinstance(v, float) else repr(v) for v in values.values())
            return ", ".join(f"{name} = {value}" for name, value in zip(values, said, strict=True))
    return ""


def _candidates(design: Design, key: str) -> Iterator[Mapping[str, float | str]]:
    """Values of a key, the nearest to what it is first; a round body's width is its depth."""
    body, process = design.body, design.mold.process
    if key == _PROCESS:
        yield from ({key: name} for name in ("sla", "machined", "fdm") if name != process)
    elif key.startswith("body."):
        if body.step is not None:
            return
        if key == _DEPTH and body.kind.turned:
            return
        keys = (key, _DEPTH) if key == _WIDTH and body.kind.turned else (key,)
        now = float(getattr(body, key.removeprefix("body.")))
        values = (round(share * now, 1) for share in _UP)
        yield from (dict.fromkeys(keys, value) for value in values if value > now)
    else:
        now = float(getattr(limits_of(design.mold), key.removeprefix("mold.limits.")))
        yield from ({key: round(share * now, 2)} for share in _DOWN)


AUTO_BOLTS = ("M3", "M2.5", "M2")
CORNERS = (1.0, 0.85, 0.7, 0.5)  # of the outermost |z| at which end and side walls may meet


def plan_mold(design: Design) -> MoldPlan:
    """The plan of a sound design's mold; DesignError with every fault.

    It is cast with the base up, tilted by ``base.TILT_DEG`` toward the first vent, in the corner
    +x +z: this is then the highest place of the rubber. A core that parts the base leaves more such
    places, each with a vent of its own.
    """
    plan, faults = _planned(design)
    if plan is None:
        raise DesignError(_with_remedies(design, faults), design.design.name)
    return plan


def _planned(design: Design) -> tuple[MoldPlan | None, list[Fault]]:
    """The plan, or its faults, remedies of room left out."""
    mold, limits, fixture = design.mold, limits_of(design.mold), fixture_of(design)
    extent, unheld = _parted(fixture, fixture.room.extent)
    plan = MoldPlan(
        **vars(extent),
        scale=fixture.scale,
        frames=fixture.frames,
        legs=fixture.legs,
        sides=tuple(fixture.side(side) for side in SIDES),
        plugs=fixture.plugs,
        top=extent.crest + mold.insert_mm,
        base=mold.base_mm,
    )
    holes, no_room = base_holes_of(design, plan, limits)
    core_pins, no_pins = core_pins_of(design, plan, limits)
    plan = replace(plan, base_holes=holes, core_pins=core_pins)
    columns = _columns(plan, mold, limits)
    faults = [
        *limit_faults(mold, limits, columns.reach),
        *unheld,
        *no_pins,
        *no_room,
        *fastener_faults(mold, plan, columns),
    ]
    if faults:
        return None, list({str(fault): fault for fault in faults}.values())
    if mold.wall_mm is not None:
        columns = replace(columns, wall_z=mold.wall_mm)
    return fastened(design.body, plan, columns), []


def _parted(fixture: Fixture, extent: Extent) -> tuple[Extent, list[Fault]]:
    """The extent with end and side walls parted where legs leave through the right ones, and the
    faults that are left: a round or tapering body may be parted at any of several |z|."""
    held = fixture_faults(fixture)
    shares = (1.0,) if extent.continued or not fixture.legs else CORNERS
    found = []
    for share in shares:
        parted = replace(extent, corner=share * extent.corner)
        found.append((parted, with_walls(fixture, held, parted.corner)))
        if not found[-1][1]:
            break
    return min(found, key=lambda each: len(each[1]))


def _columns(plan: MoldPlan, mold: Mold, limits: Limits) -> Columns:
    """Columns for the given bolts, or for the largest of ``AUTO_BOLTS`` that fit along z."""
    plugged = plan.plug("z") is not None
    sizes = AUTO_BOLTS if mold.bolt == "auto" else (mold.bolt,)
    tried = [columns_of(plan, mold, limits, size, plugged) for size in sizes]
    columns = next((c for c in tried if z_bolt_height(plan, c) is not None), tried[-1])
    low = pin_height(plan, columns) is None and plan.plug("x") is None
    return columns_of(plan, mold, limits, columns.size, plugged or low)
