"""Check how thin the parts are, by rays inward from seeded points of their surfaces.

Webs between slots are measured exactly, on sections: the least distance of their outlines. A ray
that ends on a face which looks the other way within 30 degrees has crossed a wall; one that
ends on another face has crossed an edge, which making it blunts. Sharper edges count as thin walls.
"""

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.mold import solids
from fingerdesign.mold.checks.assembly import Assembly, from_slot, place_text, seen_from
from fingerdesign.mold.part import INSERT, Check, PartMesh
from fingerdesign.mold.plan.pieces import SidePlan, across, direction, in_space
from fingerdesign.mold.plan.plan import MoldPlan

WALL_POINTS = 2500  # and as many centroids: on 2500 mm^2 two in a square millimetre
CLEAR_MM = 0.3  # of an outer comb from the insert, which it would clamp
_NEAR_SLOT_MM = 0.05
_NEAR_PIN_MM = 0.02


def clearance_checks(assembly: Assembly) -> list[Check]:
    """Check that outer combs, which are slid on the frames, are clear of the insert."""
    found, insert = [], assembly.solids[INSERT]
    for side in assembly.plan.sides:
        if side.outer_comb is not None:
            gap = insert.min_gap(assembly.solids[side.outer_comb], 2.0 * CLEAR_MM)
            words = f"{side.outer_comb}: {gap:.3f} mm from the contact insert"
            name = "clear of insert"
            found.append(Check.least(name, side.outer_comb, gap, CLEAR_MM, words, 1e-3))
    return found


def wall_checks(assembly: Assembly, rng: np.random.Generator) -> list[Check]:
    """Least wall of every part that is made, least web between the slots of those that hold."""
    found: list[Check] = []
    sides = {side.holder: side for side in assembly.plan.sides if side.slots}
    sides |= {side.outer_comb: side for side in assembly.plan.sides if side.outer_comb}
    for part in assembly.meshes.parts:
        if part.made not in ("process", "sheet"):
            continue
        points, normals = solids.surface_points(part.vertices, part.triangles, WALL_POINTS, rng)
        found += _of_part(assembly, part, sides.get(part.name), points, normals)
    return found


def _of_part(
    assembly: Assembly, part: PartMesh, side: SidePlan | None, points: Array, normals: Array
) -> list[Check]:
    """Walls, webs and sheets at points that lie on no pin; then these."""
    thick = solids.thicknesses(assembly.solids[part.name], points, normals)
    limits, pins = assembly.plan.limits, _on_pins(assembly.plan, part.name, points)
    kinds = [("wall", ~pins, limits.wall_mm)]
    if side is not None and part.made == "sheet":
        flat = np.abs(normals @ direction(side.side)) > solids.OPPOSITE
        kinds = [("sheet", flat, side.sheet)]
    elif side is not None:
        kinds = [("wall", ~pins & ~_at_slots(side, points, normals, thick), limits.wall_mm)]
    if pins.any():
        kinds.append(("pin", pins, limits.feature_mm))
    slack, found = 2.0 * part.chord + 1e-3, []  # a round hole's chords, and rounding
    for kind, where, bound in kinds:
        name = f"least {kind}"
        row = int(np.argmin(np.where(where, thick, np.inf)))
        least = thick[row]
        if not (where[row] and np.isfinite(least)):
            text = f"{part.name}: has no {kind}"
            found.append(Check(name, part.name, True, None, bound, "mm", text))
            continue
        text = f"{part.name}: {name} {least:.3f} mm, at {place_text(points[row])}; "
        text += f"{bound:g} mm can be made"
        found.append(Check.least(name, part.name, least, bound, text, slack))
    return found if side is None else [*found, _least_web(assembly, part, side, slack)]


def _least_web(assembly: Assembly, part: PartMesh, side: SidePlan, slack: float) -> Check:
    """The least distance between outlines in the sections of a part that holds plates: just below
    both faces, and between them. Of a wall those count that are slots."""
    sheet, plan = part.made == "sheet", assembly.plan
    bound = plan.design.mold.comb.web_mm if sheet else plan.limits.feature_mm
    out = part.vertices @ direction(side.side)
    low, high = plan.half(side.side), plan.reach(side.side)
    if sheet:
        low, high = float(out.min()), float(out.max())
    least, place = np.inf, np.zeros(2)
    for share in (0.5,) if sheet else (0.02, 0.5, 0.98):
        level = low + share * (high - low)
        loops = solids.section_loops(assembly.solids[part.name], side.side, level)
        for group in [loops] if sheet else _next_to_slots(side, loops, level):
            distance, where = solids.least_distance(group)
            if distance < least:
                least, place = distance, where
    if not np.isfinite(least):
        text = f"{part.name}: has no web"
        return Check("least web", part.name, True, None, bound, "mm", text)
    text = f"{part.name}: least web {least:.3f} mm, at {place_text(place)} of its outline; "
    text += f"{bound:g} mm can be made"
    return Check.least("least web", part.name, least, bound, text, slack)


def _next_to_slots(side: SidePlan, loops: list[Array], level: float) -> list[list[Array]]:
    """Pairs of outlines in a wall's section, the first of them that of a slot."""
    slots = [each for each in loops if _is_slot(side, each, level)]
    return [[each, other] for each in slots for other in loops if other is not each]


def _is_slot(side: SidePlan, loop: Array, level: float) -> bool:
    """True where an outline in a wall's section is that of a planned slot, or of its mouth."""
    points = in_space(side.side, 0.0, 0.0, level) + np.outer(loop[:, 0], across(side.side))
    points[:, 1] = loop[:, 1]
    return any(bool((np.abs(from_slot(each, points)) < _NEAR_SLOT_MM).all()) for each in side.slots)


def _on_pins(plan: MoldPlan, name: str, points: Array) -> BoolArray:
    """Points on the planned pins that stand on a part: their tips may be as thin as a feature."""
    found = np.zeros(len(points), dtype=bool)
    for pin in plan.pins:
        if pin.on != name or pin.dowel:
            continue
        away = points - np.array(pin.root)
        along = away @ np.array(pin.direction)
        radius = np.linalg.norm(away - along[:, None] * np.array(pin.direction), axis=1)
        near = (along > solids.START_MM) & (along < pin.length + _NEAR_PIN_MM)
        found |= near & (radius < 0.5 * pin.diameter + _NEAR_PIN_MM)
    return found


def _at_slots(side: SidePlan, points: Array, normals: Array, thick: Array) -> BoolArray:
    """Points with a slot's face at one end of their rays: between it and the other lies a web."""
    ends = points - np.where(np.isfinite(thick), thick, 0.0)[:, None] * normals
    found = np.zeros(len(points), dtype=bool)
    for slot in side.slots:
        for each in (points, ends):
            found |= np.abs(from_slot(slot, each)) < _NEAR_SLOT_MM
    place, _ = seen_from(side.side, normals)
    return np.asarray(found & (np.hypot(place, normals[:, 1]) > solids.OPPOSITE))
