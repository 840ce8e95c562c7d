"""Every slot, hole, pin, wall and web of a plan against what process and comb hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import Manifold
from scipy.spatial import cKDTree

from fingerdesign.arrays import Array
from fingerdesign.design.mold import Mold
from fingerdesign.layout.volume import plate_volume
from fingerdesign.mold.checks.assembly import Assembly
from fingerdesign.mold.checks.triangles import pairs
from fingerdesign.mold.part import BASE, Check
from fingerdesign.mold.plan.plan import Bolt, Limits, MoldPlan, SidePlan, Slot

# Whether the planned holes are there, in the triangles as they are made: rays through each.
#
# A hole that was filled leaves every part sound and the block filled; only the plan knows of it.

AROUND = 12
INSET = 0.9  # of a hole's radius: where rays pass that must meet nothing
SLACK_MM = 0.02  # of a measured diameter, chords of round holes apart
_BEYOND_MM = 0.5
_NEAR_FACE = 0.05  # of the plate's thickness, from its faces


def hole_checks(assembly: Assembly) -> list[Check]:
    """The base plate's holes are open and as wide as planned, bolts pass, plates are all there."""
    return [_open(assembly), _widths(assembly), _bolts(assembly), _plates(assembly)]


def _ring(radius: float) -> Array:
    """Places (n, 2) around a hole's axis, and on it."""
    turns = 2.0 * np.pi * (np.arange(AROUND) + 0.5) / AROUND
    ring = radius * np.column_stack([np.cos(turns), np.sin(turns)])
    return np.vstack([ring, np.zeros((1, 2))])


def _blocked(solid: Manifold, starts: Array, ends: Array) -> bool:
    return any(solid.ray_cast(start, end) for start, end in pairs(starts, ends))


def _open(assembly: Assembly) -> Check:
    plan, closed = assembly.plan, []
    for hole in plan.base_holes:
        at = _ring(0.5 * INSET * hole.diameter) + np.array([hole.x, hole.z])
        low = np.insert(at, 1, -plan.base - _BEYOND_MM, axis=1)
        high = np.insert(at, 1, _BEYOND_MM, axis=1)
        if _blocked(assembly.solids[BASE], low, high):
            closed.append(f"{hole.kind} at ({hole.x:.2f}, {hole.z:.2f})")
    words = f"{BASE}: each of {len(plan.base_holes)} planned holes is open"
    if closed:
        words = f"{BASE}: {len(closed)} planned holes are closed, first of them the {closed[0]}"
    return Check("open holes", BASE, not closed, float(len(closed)), 0.0, "holes", words)


def _widths(assembly: Assembly) -> Check:
    """The greatest error of any diameter at both faces: the undercut of locks, too."""
    plan, worst, words = assembly.plan, 0.0, f"{BASE}: has no holes"
    solid = assembly.solids[BASE]
    for hole in plan.base_holes:
        for share in (_NEAR_FACE, 1.0 - _NEAR_FACE):
            planned = hole.diameter + share * (hole.outer_diameter - hole.diameter)
            start = np.array([hole.x, -share * plan.base, hole.z])
            ways = np.insert(_ring(1.0)[:-1], 1, 0.0, axis=1)
            reach = planned + 1.0
            found = []
            for a, b in pairs(np.tile(start, (AROUND, 1)), start + reach * ways):
                hits = solid.ray_cast(a, b)
                found.append(2.0 * reach * hits[0].distance if hits else np.inf)
            off = float(np.abs(np.array(found) - planned).max())
            if off >= worst:
                worst = off
                words = (
                    f"{BASE}: diameters of holes are within {off:.3f} mm of the plan; the worst, "
                    f"the {hole.kind} at ({hole.x:.2f}, {hole.z:.2f}), is planned {planned:.3f}"
                )
    bound = SLACK_MM + 2.0 * assembly.chord
    if not np.isfinite(worst):
        return Check("widths of holes", BASE, False, None, bound, "mm", words)
    return Check("widths of holes", BASE, worst <= bound, worst, bound, "mm", words)


def _bolts(assembly: Assembly) -> Check:
    closed = []
    for number, bolt in enumerate(assembly.plan.bolts, 1):
        starts, ends = _bolt_rays(bolt)
        closed += [
            f"bolt {number} ({bolt.size} along {bolt.axis}) in {part.name}"
            for part in assembly.meshes.parts
            if _blocked(assembly.solids[part.name], starts, ends)
        ]
    words = f"each of {len(assembly.plan.bolts)} bolts passes all parts on its way"
    if closed:
        words = f"{len(closed)} times a bolt meets a part: first {closed[0]}"
    return Check("bolts pass", "", not closed, float(len(closed)), 0.0, "places", words)


def _bolt_rays(bolt: Bolt) -> tuple[Array, Array]:
    at = _ring(0.5 * INSET * bolt.diameter) + np.array([bolt.first, bolt.second])
    axis = 1 if bolt.axis == "y" else 2
    low, high = bolt.low - _BEYOND_MM, bolt.high + _BEYOND_MM
    return np.insert(at, axis, low, axis=1), np.insert(at, axis, high, axis=1)


def _plates(assembly: Assembly) -> Check:
    """Every plate of the plan is in the mold, no other, and each is no less than its span."""
    plan = assembly.plan
    made = {plate.name: plate.volume for plate in assembly.meshes.plates}
    wanted = {f"plate_{frame.index}": plate_volume(frame) for frame in plan.frames}
    wrong = sorted(set(made) ^ set(wanted))
    wrong += [name for name in wanted if name in made and made[name] < 0.999 * wanted[name]]
    words = f"all {len(wanted)} plates of the plan are in the mold"
    if wrong:
        words = f"{len(wrong)} plates are missing, too many or too small: first {wrong[0]}"
    return Check("plates", "", not wrong, float(len(wrong)), 0.0, "plates", words)


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
