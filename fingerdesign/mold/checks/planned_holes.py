"""Whether the planned holes are there, in the triangles as they are made: rays through each.

A hole that was filled leaves every part sound and the block filled; only the plan knows of it.
"""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from fingerdesign.arrays import Array
from fingerdesign.geometry.checks import plate_volume
from fingerdesign.mold.checks.assembly import Assembly
from fingerdesign.mold.checks.rays import pairs
from fingerdesign.mold.part import BASE, Check
from fingerdesign.mold.plan import Bolt

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
