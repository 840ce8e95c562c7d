"""Every slot, hole, pin, wall and web of a plan against what process and comb hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from fingerdesign.arrays import Array
from fingerdesign.design.mold import Mold
from fingerdesign.mold.part import Check
from fingerdesign.mold.plan import MoldPlan, SidePlan, Slot
from fingerdesign.mold.profiles import Limits

_ROUNDING_MM = 1e-9
ROOM_MM = 0.005  # beside a plate and its shim, or they cannot be pushed in


def plan_checks(plan: MoldPlan, mold: Mold, limits: Limits) -> list[Check]:
    """One check a kind of feature: its least size against its limit."""
    walls = [plan.wall_x, plan.wall_z, plan.top - plan.crest, plan.base]
    holes = [d for hole in plan.base_holes for d in (hole.diameter, hole.outer_diameter)]
    holes += [bolt.diameter for bolt in plan.bolts]
    holes += [pin.diameter for pin in plan.core_pins]
    clearances = [pin.clearance for pin in plan.pins] + [key.clearance for key in plan.keys]
    found = [
        _least("planned walls", "", walls, limits.wall_mm, "wall, insert or base plate"),
        _least("planned holes", "", holes, limits.hole_mm, "round hole"),
        _least("planned pins", "", [p.diameter for p in plan.pins], limits.pin_mm, "pin"),
        _least("planned clearances", "", clearances, limits.clearance_mm, "clearance"),
    ]
    for side in plan.sides:
        if side.slots:
            found += _side(plan, side, mold, limits)
    return found


def _side(plan: MoldPlan, side: SidePlan, mold: Mold, limits: Limits) -> list[Check]:
    cut = side.holding == "comb"
    least = mold.comb.slot_mm if cut else limits.slot_mm
    web = mold.comb.web_mm if cut else limits.feature_mm
    thick = {frame.index: frame.thickness for frame in plan.frames}
    room = [slot.width - slot.shim - thick[slot.plate] for slot in side.slots]
    leads = [_for_leads(side, slot) for slot in side.slots if slot.wire > 0.0]
    wire = max((slot.wire for slot in side.slots), default=0.0)
    where = f"side {side.side}"
    return [
        _least("planned slots", where, [s.width for s in side.slots], least, f"slot of {where}"),
        _least(
            "room of plates", where, room, ROOM_MM, f"room beside a plate and its shim, {where}"
        ),
        _least("leads pass", where, leads, wire, f"hole for a plate's leads, {where},"),
        _least("planned webs", where, [least_web(side.slots)], web, f"web of {where}"),
    ]


def _for_leads(side: SidePlan, slot: Slot) -> float:
    """Diameter that is free for leads beside a leg anywhere in its slot, mm.

    A jig's two holes are shifted against each other; a leg's end may stand in the hole's edge.
    """
    centre = np.hypot(slot.relief_centre[0] - slot.place, slot.relief_centre[1] - slot.y)
    reaches = 0.5 * slot.length - (centre - 0.5 * slot.relief)  # into the slot
    return float(slot.relief - max(reaches, 0.0) - 2.0 * side.shift)


def _least(name: str, where: str, sizes: Sequence[float], bound: float, what: str) -> Check:
    """Of nothing, nothing is too small."""
    title = f"{name}, {where}" if where else name
    least = min(sizes, default=np.inf)
    if not np.isfinite(least):
        return Check(title, "", True, None, bound, "mm", f"there is no {what}")
    ok = bool(least >= bound - _ROUNDING_MM)
    sentence = f"the least {what} is {least:.3f} mm, {bound:g} mm are needed"
    return Check(title, "", ok, float(least), bound, "mm", sentence)


def least_web(slots: Sequence[Slot]) -> float:
    """The least distance between any two slots of a side, mm; 0 where they cross; infinite for
    one."""
    if len(slots) < 2:
        return float("inf")
    centres = np.array([[slot.place, slot.y] for slot in slots])
    corners = [_corners(slot) for slot in slots]
    reach = max(float(np.hypot(slot.length, slot.width)) + 2.0 * slot.relief for slot in slots)
    nearest = cKDTree(centres).query(centres, k=2)[0][:, 1].min()
    near = cKDTree(centres).query_pairs(nearest + 2.0 * reach, output_type="ndarray")
    between = [_between(corners[i], corners[j]) for i, j in near]
    for i, j in near:
        for one, other in ((i, j), (j, i)):
            if slots[one].relief:
                between.append(_from_relief(slots[one], slots[other]))
    return min(between)


def _from_relief(one: Slot, other: Slot) -> float:
    """Distance of a slot's round relief from another slot and its relief; 0 where they overlap."""
    centre = np.array(one.relief_centre)
    corners = _corners(other)
    edges = np.roll(corners, -1, axis=0) - corners
    offset = centre - corners
    if (edges[:, 0] * offset[:, 1] - edges[:, 1] * offset[:, 0] >= 0.0).all():
        return 0.0
    found = _to_sides(centre[None], corners)
    if other.relief:
        apart = float(np.linalg.norm(centre - np.array(other.relief_centre)))
        found = min(found, apart - 0.5 * other.relief)
    return max(found - 0.5 * one.relief, 0.0)


def _corners(slot: Slot) -> Array:
    angle = np.radians(slot.angle_deg)
    along = 0.5 * slot.length * np.array([np.cos(angle), np.sin(angle)])
    over = 0.5 * slot.width * np.array([-np.sin(angle), np.cos(angle)])
    middle = np.array([slot.place, slot.y])
    return np.array(
        [middle - along - over, middle + along - over, middle + along + over, middle - along + over]
    )


def _between(first: Array, second: Array) -> float:
    """Distance between two rectangles of corners (4, 2); 0 where they overlap."""
    gaps = []
    for one, other in ((first, second), (second, first)):
        edges = np.roll(one, -1, axis=0) - one
        lengths = np.linalg.norm(edges, axis=1)
        units = edges / lengths[:, None]
        outward = np.stack([units[:, 1], -units[:, 0]], axis=1)
        offset = other[:, None, :] - one[None, :, :]
        gaps.append(np.einsum("kij,ij->ki", offset, outward).min(axis=0).max())
    if max(gaps) <= 0.0:  # no side of either parts them
        return 0.0
    return min(_to_sides(first, second), _to_sides(second, first))


def _to_sides(points: Array, corners: Array) -> float:
    starts, edges = corners, np.roll(corners, -1, axis=0) - corners
    offset = points[:, None, :] - starts[None]
    share = np.einsum("kij,ij->ki", offset, edges) / np.einsum("ij,ij->i", edges, edges)
    feet = np.clip(share, 0.0, 1.0)[..., None] * edges
    return float(np.linalg.norm(offset - feet, axis=2).min())
