"""Whether a part stands behind every place of the finger's surface."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from fingerdesign.arrays import Array
from fingerdesign.mold.checks.assembly import Assembly
from fingerdesign.mold.checks.openings import planned
from fingerdesign.mold.checks.rays import inside, surface_points
from fingerdesign.mold.part import Check

POINTS = 10000  # 0.08 mm^2 each on a finger of 800 mm^2
# A sheet's slot is wider than planned by no more than its fillets; seams are closed.
SLACK_MM = 0.05


def backing_check(assembly: Assembly, rng: np.random.Generator) -> Check:
    """Points two chords outside the outline must lie in a part, a plate or a planned opening."""
    outline = assembly.meshes.outline
    points, normals = surface_points(outline.vertices, outline.triangles, POINTS, rng)
    points = points[:POINTS] + 2.0 * assembly.chord * normals[:POINTS]
    left = ~planned(assembly.plan, points, assembly.limits.clearance_mm, SLACK_MM)
    wanted = int(left.sum())
    for part in (*assembly.meshes.parts, *assembly.meshes.plates):
        rest = np.flatnonzero(left)
        left[rest[inside(assembly.solids[part.name], points[rest])]] = False
    bare = points[left]
    share = len(bare) / POINTS
    where, size = _largest(bare)
    sentence = f"a part stands behind each of {wanted} points on the finger's surface"
    if len(bare):
        place = ", ".join(f"{value:.2f}" for value in where)
        sentence = (
            f"{len(bare)} of {POINTS} points on the finger's surface have no part behind them; the "
            f"largest hole is about {size:.2f} mm wide, at ({place})"
        )
    return Check("surface backed by parts", "", not len(bare), share, 0.0, "1", sentence)


def _largest(points: Array) -> tuple[Array, float]:
    """Middle and greatest extent of the largest cluster of points (n, 3), mm."""
    if not len(points):
        return np.zeros(3), 0.0
    near = cKDTree(points).query_pairs(1.0, output_type="ndarray")
    shape = (len(points), len(points))
    links = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=shape)
    _, labels = connected_components(links, directed=False)
    cluster = points[labels == np.bincount(labels).argmax()]
    return cluster.mean(axis=0), float(np.ptp(cluster, axis=0).max())
