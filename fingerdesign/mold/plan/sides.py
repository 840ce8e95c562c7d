"""Sides of a mold: where its walls part, how each is closed and holds plates, and the plugs; mm.

A round or tapering body may be parted at any of several |z|: the first is taken at which every leg
leaves through a wall that is drawn along it.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fingerdesign.layout.bodies import surface_height
from fingerdesign.mold.part import EDGE_DEG
from fingerdesign.mold.plan.extent import half_extent
from fingerdesign.mold.plan.fixture.fixture import Fixture
from fingerdesign.mold.plan.fixture.refusals import CLOSE_MM
from fingerdesign.mold.plan.pieces import SIDES, Plug, Side, SidePlan, Slot, in_space, slot_corners
from fingerdesign.mold.plan.plan import Extent, MoldPlan
from fingerdesign.mold.plan.refusals import Refusal
from fingerdesign.mold.plan.slots import sheet_thickness

CORNERS = (1.0, 0.85, 0.7, 0.5)  # fractions of the outermost |z| at which walls may part
_FEATHERLESS = 0.8  # cosine of 37 degrees, at which an insert's edge is not yet a feather edge
_SAMPLES = 2001  # places along a side at which a wall's edge is looked for
_WINDOW_MM = 0.5  # around slots: room for leads, and to see the plates


def sides_of(fixture: Fixture, wrong: Sequence[Refusal]) -> tuple[MoldPlan, list[Refusal]]:
    """Plan outline, legs, sides and plugs, without fasteners and base.

    Refusals, one a key: those that are ``wrong`` with the legs, then legs in the way of walls.
    """
    found = []
    whole, mold = fixture.room.extent, fixture.design.mold
    for part in (1.0,) if whole.continued or not fixture.legs else CORNERS:
        extent = replace(whole, corner=part * whole.corner)
        unique: dict[str, Refusal] = {}
        for refusal in (*wrong, *blocked(fixture, extent)):
            unique.setdefault(refusal.key, refusal)
        found.append((extent, list(unique.values())))
        if not unique:
            break
    extent, refusals = min(found, key=lambda each: len(each[1]))
    plan = MoldPlan(
        **vars(extent),
        design=fixture.design,
        scale=fixture.scale,
        frames=fixture.frames,
        legs=fixture.legs,
        sides=tuple(_side(fixture, side) for side in SIDES),
        plugs=_plugs(fixture),
        top=extent.crest + mold.insert_mm,
        base=mold.base_mm,
    )
    return plan, refusals


def blocked(fixture: Fixture, extent: Extent) -> list[Refusal]:
    """Refuse legs that run through a wall drawn across them, or too near to the base."""
    loose, openings, room = fixture.loose, fixture.openings, replace(fixture.room, extent=extent)
    if not loose:
        return []
    found, sunk = [], room.sunk(openings)
    worst = int(np.argmax(sunk))
    if sunk[worst] > CLOSE_MM:
        plate = loose[worst].plate
        key, value = fixture.row(plate).blame(plate, "cover_mm")
        numbers = {"web": room.web, "plate": plate, "bottom": float(openings.bottom[worst])}
        found.append(Refusal("low_slots", key, value, numbers))
    into = room.blocked([leg.side for leg in loose], openings, fixture.exits)
    worst = int(np.argmax(into))
    if into[worst] > CLOSE_MM:
        leg, row = loose[worst], fixture.row(loose[worst].plate)
        key, value = row.blame(leg.plate, "pitch_mm" if len(row.frames) > 1 else "offset_mm")
        wall, other = ("end", "side") if leg.side.endswith("z") else ("side", "end")
        of: dict[str, object] = {"plate": leg.plate, "wall": wall, "other": other}
        of |= {"corner": extent.corner, "into": float(into[worst])}
        found.append(Refusal("legs_in_walls", key, value, of))
    return found


def _side(fixture: Fixture, side: Side) -> SidePlan:
    """Plan how one side is closed and holds its plates."""
    holding, slots = fixture.holding(side), fixture.slots(side)
    if holding == "slots" and fixture.design.body.step is None:
        high = {leg.plate for leg, _ in fixture.high if leg.side == side}
        slots = tuple(_mouthed(fixture, s) if s.plate in high else s for s in slots)
    window = _window(fixture, side, slots) if holding == "comb" else None
    return SidePlan(side, holding, sheet_thickness(fixture.design, holding), window, slots)


def _mouthed(fixture: Fixture, slot: Slot) -> Slot:
    """Give a slot a mouth where the wall below it would begin in too sharp an edge, since the slot
    leaves a contact surface that is nearly level."""
    half, web = half_extent(fixture.design.body, slot.side), fixture.limits.feature_mm
    scale, lean = fixture.scale, math.radians(slot.angle_deg)
    if min(abs(math.sin(lean)), abs(math.cos(lean))) > math.sin(math.radians(EDGE_DEG)):
        return slot  # no side of it is as level as that
    outs = np.linspace(0.0, half, _SAMPLES)
    points = [[in_space(slot.side, at / scale, 0.0, o) for o in outs] for at, _ in slot.lower]
    x, _, z = np.moveaxis(np.array(points), 2, 0)
    with np.errstate(invalid="ignore"):
        top = scale * surface_height(fixture.design.body, x, z)  # (2, outs); NaN beyond the body
    thick = slot.lower[:, 1:] - np.where(np.isnan(top), -np.inf, top)
    begins, whole = (int((thick > least).argmax(axis=1).max()) for least in (0.0, web))
    run = scale * (outs[whole] - outs[begins])
    if not np.isfinite(top[:, whole]).all() or run <= web / math.tan(math.radians(EDGE_DEG)):
        return slot
    return replace(slot, mouth=(scale * float(outs[whole]), float(top[:, whole].min())))


def _window(fixture: Fixture, side: Side, slots: tuple[Slot, ...]) -> tuple[float, float, float]:
    """Place the opening behind a comb, around all of its slots; walls below it, and in side walls
    on either side of it, stay as thick as they must be."""
    room = fixture.room
    corners = slot_corners(slots).reshape(-1, 2)
    (low, bottom), (high, _) = corners.min(axis=0), corners.max(axis=0)
    most = room.extent.corner - room.wall if side.endswith("x") else np.inf
    return (
        float(max(low - _WINDOW_MM, min(-most, low))),
        float(min(high + _WINDOW_MM, max(most, high))),
        float(max(bottom - _WINDOW_MM, min(room.wall + fixture.limits.seam_mm, bottom))),
    )


def _plugs(fixture: Fixture) -> tuple[Plug, ...]:
    """The insert's plugs: as wide as the legs next to them allow, narrowed by the draft.

    On a revolved body's border a seam would meet the upright side at the angle whose sine is the
    rest: farther out than _FEATHERLESS the insert ends there in a feather edge.
    """
    plugs, room, body = [], fixture.room, fixture.design.body
    for axis in ("x", "z"):
        nearest = [out for leg, out in fixture.high if leg.side.endswith(axis)]
        if nearest:
            seam, zone = math.inf, room.zone_x if axis == "x" else room.zone_z
            if body.kind.turned:
                seam = max(_FEATHERLESS * 0.5 * body.width_mm * fixture.scale, zone)
            top = min(min(nearest) - room.web, seam + room.narrowing)
            plugs.append(Plug(axis, top - room.narrowing, top))
    return tuple(plugs)
