"""Whether the parts come off, one after another, along their draws.

Two ways that hold each other: the part moved by a few steps must not overlap what is still there
(all of its volume, some of its path), and points just under its surface, and under the plates',
must not run into anything on the whole way (some of its volume, all of its path).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.mold.checks.assembly import (
    Assembly,
    areas,
    bounds,
    curved,
    inside,
    pairs,
    place_text,
    surface_points,
)
from fingerdesign.mold.part import RUBBER, Check, PartMesh, axis_name, doubled_areas

POINTS = 1500  # and as many centroids, a part; a tenth of it a plate
FLAT_MM = 1e-6  # parts that slide along flat faces meet within rounding
SLIDING = 0.3  # faces steeper to the draw part by more than a chord at the first step
STEPS_MM = (0.05, 0.3, 1.5, 6.0)  # then clear of everything: undercuts bind at once, hooks later


def demolding_checks(assembly: Assembly, rng: np.random.Generator) -> list[Check]:
    """One check a part that is drawn: the greatest overlap on its way."""
    drawn = [part for part in assembly.meshes.parts if part.draw is not None]
    fixed = [part for part in assembly.meshes.parts if part.draw is None]
    staying = (RUBBER, *(each.name for each in (*assembly.meshes.plates, *fixed)))
    found = []
    for part in sorted(drawn, key=lambda each: each.order):
        # Those of one order that are drawn one way move together.
        apart = [p for p in drawn if p.order == part.order and p.draw != part.draw]
        left = [p.name for p in drawn if p.order > part.order or p in apart]
        found.append(_check(assembly, part, (*staying, *left), rng))
    return found


@dataclass(frozen=True)
class Obstacle:
    """What is still there while a part is drawn, with the corners of its box."""

    name: str
    solid: Manifold
    low: Array
    high: Array

    def shared(self, moved: Manifold) -> float:
        """Volume that it shares with a part whose box it reaches, mm^3."""
        low, high = bounds(moved)
        near = np.all(self.low < high) and np.all(low < self.high)
        return float((moved ^ self.solid).volume()) if near else 0.0


def _check(
    assembly: Assembly, part: PartMesh, there: tuple[str, ...], rng: np.random.Generator
) -> Check:
    solid, draw = assembly.solids[part.name], np.array(part.draw)
    way = axis_name(draw.tolist())
    solids = [(name, assembly.solids[name]) for name in there]
    obstacles = [Obstacle(name, each, *bounds(each)) for name, each in solids]
    # How far it must be drawn until its box has parted from all others.
    far = max(max(each.low @ draw, each.high @ draw) for each in obstacles)
    clear = max(0.0, float(far - min(corner @ draw for corner in bounds(solid)))) + 1.0
    bound = slack(part, obstacles, assembly.chord)
    worst, where, name = 0.0, 0.0, ""
    for step in (step for step in STEPS_MM if step < clear):
        moved = solid.translate(tuple(step * draw))
        shares = {each.name: each.shared(moved) for each in obstacles}
        if sum(shares.values()) > worst:
            worst, where = sum(shares.values()), step
            name = max(shares, key=lambda each: shares[each])
    ok = worst <= bound
    words = f"moved {clear:.1f} mm along {way} it passes everything that is still there"
    if not ok:
        words = f"{where:g} mm along {way} it overlaps {name} by {worst:.3g} mm^3"
    else:
        hits = _hits_on_way(assembly, part, obstacles, clear, rng)
        if hits:
            ok, (far, met, at) = False, min(hits, key=lambda hit: hit[0])
            words = f"after {far:.2f} mm along {way} it runs into {met} at {place_text(at)}"
    return Check("demolding", part.name, ok, worst, bound, "mm^3", f"{part.name}: {words}")


def slack(part: PartMesh, obstacles: list[Obstacle], chord: float) -> float:
    """Overlap by triangles alone, mm^3: curved faces that slide along an obstacle lie up to two
    chords apart from where they should; flat ones meet within rounding."""
    normals = doubled_areas(part.vertices, part.triangles)
    sizes = np.linalg.norm(normals, axis=1)
    units = normals / np.maximum(sizes, np.finfo(float).tiny)[:, None]
    sliding = curved(part.vertices, part.triangles)
    sliding &= np.abs(units @ np.array(part.draw)) < SLIDING
    rows = np.flatnonzero(sliding)
    beside = part.vertices[part.triangles[rows]].mean(axis=1) + 3.0 * chord * units[rows]
    rows = rows[_taken(beside, obstacles)]
    return float(chord * sizes[rows].sum() + FLAT_MM * 0.5 * sizes.sum())


def _hits_on_way(
    assembly: Assembly,
    part: PartMesh,
    obstacles: list[Obstacle],
    clear: float,
    rng: np.random.Generator,
) -> list[tuple[float, str, Array]]:
    """Collisions of points on the whole way: after how many mm, with what, and where.

    Points lie three chords under the surface, so that faces which merely slide are not met; those
    of plates not deeper than a quarter of their thickness.
    """
    way = clear * np.array(part.draw)
    depth = 3.0 * assembly.chord + 1e-4
    solid = assembly.solids[part.name]
    points, normals = surface_points(part.vertices, part.triangles, POINTS, rng)
    points = points - depth * normals
    points = points[inside(solid, points)]
    points = points[~_taken(points, obstacles)]
    found: list[tuple[float, str, Array]] = []
    for each in obstacles:
        found += [(far, each.name, at) for far, at in _hits(each.solid, points, way)]
    for plate in assembly.meshes.plates:
        points, normals = surface_points(plate.vertices, plate.triangles, POINTS // 10, rng)
        thick = 2.0 * abs(plate.volume) / areas(plate.vertices, plate.triangles).sum()
        points = points - min(depth, 0.25 * thick) * normals
        points = points[inside(assembly.solids[plate.name], points)]
        points = points[~inside(solid, points)]
        hits = _hits(solid, points, -way)
        found += [(far, plate.name, at + way * far / clear) for far, at in hits]
    return found


def _taken(points: Array, obstacles: list[Obstacle]) -> BoolArray:
    """Whether points (n, 3) lie in any obstacle."""
    found = np.zeros(len(points), dtype=bool)
    for each in obstacles:
        rest = np.flatnonzero(~found)
        found[rest[inside(each.solid, points[rest])]] = True
    return found


def _hits(solid: Manifold, points: Array, way: Array) -> list[tuple[float, Array]]:
    """How far points (n, 3) come along a way before they meet a solid, and where; those that do."""
    low, high = bounds(solid)
    ends = points + way
    near = np.all((np.minimum(points, ends) <= high) & (np.maximum(points, ends) >= low), axis=1)
    length = float(np.linalg.norm(way))
    found = []
    for start, end in pairs(points[near], ends[near]):
        hits = solid.ray_cast(start, end)
        if hits:
            found.append((length * hits[0].distance, np.array(hits[0].position)))
    return found
