"""How thin the parts are: rays inward from seeded points of their surfaces.

A ray that ends on a face which looks the other way within 30 degrees has crossed a wall; one that
ends on another face has crossed an edge, which making it blunts. Sharper edges count as thin walls.
"""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.mold.checks.assembly import (
    Assembly,
    bounds,
    from_slot,
    pairs,
    place_text,
    seen_from,
    surface_points,
)
from fingerdesign.mold.part import BASE, Check, PartMesh
from fingerdesign.mold.plan.plan import MoldPlan, SidePlan, direction

POINTS = 2500  # and as many centroids: on 2500 mm^2 two in a square millimetre
OPPOSITE = np.cos(np.radians(30.0))
_START_MM = 1e-6  # off the surface that the ray starts from
_NEAR_SLOT_MM = 0.05
_NEAR_PIN_MM = 0.02


def wall_checks(assembly: Assembly, rng: np.random.Generator) -> list[Check]:
    """Least wall of every part that is made, least web between the slots of those that hold."""
    found: list[Check] = []
    sides = {side.holder: side for side in assembly.plan.sides if side.slots}
    for part in assembly.meshes.parts:
        if part.made not in ("process", "sheet"):
            continue
        points, normals = surface_points(part.vertices, part.triangles, POINTS, rng)
        found += _of_part(assembly, part, sides.get(part.name), points, normals)
    return found


def thicknesses(solid: Manifold, points: Array, normals: Array) -> Array:
    """Thickness (n,) mm of a solid at points (n, 3) of its surface, inward along outward normals;
    infinite where none is met."""
    low, high = bounds(solid)
    reach = float(np.linalg.norm(high - low))
    starts, ends = points - _START_MM * normals, points - reach * normals
    found = np.full(len(points), np.inf)
    for row, (start, end) in enumerate(pairs(starts, ends)):
        for hit in solid.ray_cast(start, end):
            distance = hit.distance * (reach - _START_MM)
            if distance > _START_MM:
                if float(np.dot(hit.normal, normals[row])) < -OPPOSITE:
                    found[row] = distance + _START_MM
                break
    return found


def _of_part(
    assembly: Assembly, part: PartMesh, side: SidePlan | None, points: Array, normals: Array
) -> list[Check]:
    """Walls, webs and sheets at points that lie on no pin or key; then these."""
    thick = thicknesses(assembly.solids[part.name], points, normals)
    limits, pins = assembly.limits, _on_pins(assembly.plan, part.name, points)
    if side is None:
        kinds = [("wall", ~pins, limits.wall_mm)]
    elif part.made == "sheet":
        flat = np.abs(normals @ direction(side.side)) > OPPOSITE
        kinds = [("sheet", flat, side.sheet), ("web", ~flat, assembly.design.mold.comb.web_mm)]
    else:
        slotted = _at_slots(side, points, normals, thick)
        kinds = [("wall", ~pins & ~slotted, limits.wall_mm)]
        kinds += [("web", ~pins & slotted, limits.feature_mm)]
    if pins.any():
        kinds.append(("pin", pins, limits.feature_mm))
    slack, found = 2.0 * part.chord + 1e-3, []  # a round hole's chords, and rounding
    for kind, where, bound in kinds:
        name = f"least {kind}"
        row = int(np.argmin(np.where(where, thick, np.inf)))
        least = thick[row]
        if not (where[row] and np.isfinite(least)):
            said = f"{part.name}: has no {kind}"
            found.append(Check(name, part.name, True, None, bound, "mm", said))
            continue
        said = f"{part.name}: {name} {least:.3f} mm, at {place_text(points[row])}; "
        said += f"{bound:g} mm can be made"
        found.append(Check.least(name, part.name, least, bound, said, slack))
    return found


def _on_pins(plan: MoldPlan, name: str, points: Array) -> BoolArray:
    """Points on the planned pins and keys that stand on a part: their tips may be as thin as a
    feature."""
    found = np.zeros(len(points), dtype=bool)
    for pin in plan.pins:
        if pin.on != name or pin.dowel:
            continue
        away = points - np.array(pin.root)
        along = away @ np.array(pin.direction)
        radius = np.linalg.norm(away - along[:, None] * np.array(pin.direction), axis=1)
        near = (along > _START_MM) & (along < pin.length + _NEAR_PIN_MM)
        found |= near & (radius < 0.5 * pin.diameter + _NEAR_PIN_MM)
    for key in plan.keys if name == BASE else ():
        low, high = np.array(key.low), np.array(key.high)
        within = (points > low - _NEAR_PIN_MM) & (points < high + _NEAR_PIN_MM)
        found |= within.all(axis=1) & (points[:, 1] > _START_MM)
    return found


def _at_slots(side: SidePlan, points: Array, normals: Array, thick: Array) -> BoolArray:
    """Points with a slot's face at one end of their rays: between it and the other lies a web."""
    ends = points - np.where(np.isfinite(thick), thick, 0.0)[:, None] * normals
    found = np.zeros(len(points), dtype=bool)
    for slot in side.slots:
        for each in (points, ends):
            found |= np.abs(from_slot(slot, each)) < _NEAR_SLOT_MM
    place, _ = seen_from(side.side, normals)
    return np.asarray(found & (np.hypot(place, normals[:, 1]) > OPPOSITE))
