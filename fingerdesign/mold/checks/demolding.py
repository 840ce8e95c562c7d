"""Whether the parts come off, one after another, along their draws.

Two ways that hold each other: the part moved by a few steps must not overlap what is still there
(all of its volume, some of its path), and points just under its surface, and under the plates',
must not run into anything on the whole way (some of its volume, all of its path).
"""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold, OpType
from numpy.typing import NDArray

from fingerdesign.mold.checks.assembly import Assembly
from fingerdesign.mold.checks.rays import bounds, inside, pairs, surface_points
from fingerdesign.mold.checks.triangles import areas, curved, doubled_areas
from fingerdesign.mold.part import Check, PartMesh

Array = NDArray[np.float64]

POINTS = 800  # and as many centroids, a part; a tenth of it a plate
FLAT_MM = 1e-6  # parts that slide along flat faces meet within rounding
SLIDING = 0.3  # faces steeper to the draw part by more than a chord at the first step
STEPS_MM = (0.05, 0.3, 1.5, 6.0)  # then clear of everything: undercuts bind at once, hooks later


def demolding_checks(assembly: Assembly, rng: np.random.Generator) -> list[Check]:
    """One check a part that is drawn: the greatest overlap on its way."""
    drawn = [part for part in assembly.meshes.parts if part.draw is not None]
    found = []
    for part in sorted(drawn, key=lambda each: each.order):
        left = [p.name for p in drawn if p.order >= part.order and p.name != part.name]
        found.append(_check(assembly, part, (*assembly.staying, *left), rng))
    return found


def _check(
    assembly: Assembly, part: PartMesh, there: tuple[str, ...], rng: np.random.Generator
) -> Check:
    solid, draw = assembly.solids[part.name], np.array(part.draw)
    obstacle = Manifold.batch_boolean([assembly.solids[name] for name in there], OpType.Add)
    clear = clearing(solid, obstacle, draw)
    worst, where = 0.0, 0.0
    for step in (*(s for s in STEPS_MM if s < clear),):
        overlap = float((solid.translate(tuple(step * draw)) ^ obstacle).volume())
        if overlap > worst:
            worst, where = overlap, step
    bound = slack(part, obstacle, assembly.chord)
    words = f"moved {clear:.1f} mm along {_said(draw)} it passes everything that is still there"
    if worst > bound:
        name = _names(assembly, there, solid.translate(tuple(where * draw)))
        words = f"{where:g} mm along {_said(draw)} it overlaps {name} by {worst:.3g} mm^3"
    ok = worst <= bound
    if ok:
        hit = _first_hit(assembly, part, obstacle, clear, rng)
        if hit is not None:
            ok, step = False, hit[0]
            name = _names(assembly, there, solid.translate(tuple((step + 0.05) * draw)))
            place = ", ".join(f"{value:.2f}" for value in hit[1])
            words = f"after {step:.2f} mm along {_said(draw)} it runs into {name} at ({place})"
    return Check("demolding", part.name, ok, worst, bound, "mm^3", f"{part.name}: {words}")


def slack(part: PartMesh, obstacle: Manifold, chord: float) -> float:
    """Overlap by triangles alone, mm^3: curved faces that slide along an obstacle lie up to two
    chords apart from where they should; flat ones meet within rounding."""
    normals = doubled_areas(part.vertices, part.triangles)
    sizes = np.linalg.norm(normals, axis=1)
    units = normals / np.maximum(sizes, np.finfo(float).tiny)[:, None]
    sliding = curved(part.vertices, part.triangles)
    sliding &= np.abs(units @ np.array(part.draw)) < SLIDING
    rows = np.flatnonzero(sliding)
    beside = part.vertices[part.triangles[rows]].mean(axis=1) + 3.0 * chord * units[rows]
    rows = rows[inside(obstacle, beside)]
    return float(chord * sizes[rows].sum() + FLAT_MM * 0.5 * sizes.sum())


def clearing(solid: Manifold, obstacle: Manifold, draw: Array) -> float:
    """How far a solid must be drawn until the boxes of both have parted, mm."""
    (low, _), (_, high) = bounds(solid), bounds(obstacle)
    if draw.sum() < 0.0:  # draws run along axes
        (_, low), (high, _) = bounds(solid), bounds(obstacle)
    return max(0.0, float((high - low) @ draw)) + 1.0


def _first_hit(
    assembly: Assembly, part: PartMesh, obstacle: Manifold, clear: float, rng: np.random.Generator
) -> tuple[float, Array] | None:
    """The shortest way to a collision, and its place; None if there is none.

    Points lie three chords under the surface, so that faces which merely slide are not met, and
    inside the part alone: a sheet's thin webs may be passed through.
    """
    draw = np.array(part.draw)
    depth = 3.0 * assembly.chord + 1e-4
    hits: list[tuple[float, Array]] = []
    solid = assembly.solids[part.name]
    points, normals = surface_points(part.vertices, part.triangles, POINTS, rng)
    points = points - depth * normals
    points = points[inside(solid, points)]
    points = points[~inside(obstacle, points)]
    hits += _hits(obstacle, points, clear * draw)
    for plate in assembly.meshes.plates:
        points, normals = surface_points(plate.vertices, plate.triangles, POINTS // 10, rng)
        points = points - min(depth, 0.25 * _thin(plate)) * normals
        points = points[inside(assembly.solids[plate.name], points)]
        points = points[~inside(solid, points)]
        hits += [(far, at + far * draw) for far, at in _hits(solid, points, -clear * draw)]
    return min(hits, key=lambda hit: hit[0]) if hits else None


def _hits(solid: Manifold, points: Array, way: Array) -> list[tuple[float, Array]]:
    length = float(np.linalg.norm(way))
    found = []
    for start, end in pairs(points, points + way):
        hits = solid.ray_cast(start, end)
        if hits:
            found.append((length * hits[0].distance, np.array(hits[0].position)))
    return found


def _thin(plate: PartMesh) -> float:
    """About a plate's thickness, mm: twice its volume over its area."""
    return float(2.0 * abs(plate.volume) / areas(plate.vertices, plate.triangles).sum())


def _names(assembly: Assembly, there: tuple[str, ...], moved: Manifold) -> str:
    """Which of the obstacles a moved part overlaps most."""
    overlaps = {name: float((moved ^ assembly.solids[name]).volume()) for name in there}
    return max(overlaps, key=lambda name: overlaps[name])


def _said(draw: Array) -> str:
    axis = int(np.argmax(np.abs(draw)))
    return f"{'+' if draw[axis] > 0 else '-'}{'xyz'[axis]}"
