"""Seeded points on triangle meshes, and rays from them through solids. Lengths in mm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.mold.checks.triangles import doubled_areas

# Rays run nearly along axes, where the library finds what they pass quickest, but not so near
# that they would run within a face.
_ASKEW = np.array([0.0131, 0.0071, 0.0097])


def surface_points(
    vertices: Array, triangles: IntArray, count: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """``count`` points drawn evenly over the area, then every triangle's centroid (at most as many
    again, the largest first), with the outward unit normals: (n, 3) each."""
    normals = doubled_areas(vertices, triangles)
    sizes = np.linalg.norm(normals, axis=1)
    whole = sizes > 0.0
    triangles, normals, sizes = triangles[whole], normals[whole], sizes[whole]
    normals = normals / sizes[:, None]
    chosen = rng.choice(len(triangles), size=count, p=sizes / sizes.sum())
    u, v = rng.random((2, count))
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    a, b, c = (vertices[triangles[chosen, k]] for k in range(3))
    drawn = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    large = np.argsort(-sizes, kind="stable")[:count]
    centroids = vertices[triangles[large]].mean(axis=1)
    return np.vstack([drawn, centroids]), np.vstack([normals[chosen], normals[large]])


def inside(solid: Manifold, points: Array) -> NDArray[np.bool_]:
    """Whether points (n, 3) lie inside a solid: on the shortest way out of its box, a ray passes
    its surface oddly often."""
    low, high = bounds(solid)
    near = np.flatnonzero(np.all((points >= low) & (points <= high), axis=1))
    starts = points[near]
    ways = np.hstack([high - starts, starts - low])
    least = np.argmin(ways, axis=1)
    direction = np.vstack([np.eye(3), -np.eye(3)])[least] + _ASKEW
    ends = starts + direction * (1.02 * ways.min(axis=1) + 0.01)[:, None]
    held = np.zeros(len(points), dtype=bool)
    held[near] = [len(solid.ray_cast(a, b)) % 2 == 1 for a, b in pairs(starts, ends)]
    return held


def pairs(first: Array, second: Array) -> Sequence[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Rows of two arrays (n, 3) as plain numbers, for the library's rays."""
    both = zip(first.tolist(), second.tolist(), strict=True)
    return [(tuple(a), tuple(b)) for a, b in both]


def bounds(solid: Manifold) -> tuple[Array, Array]:
    """Low and high corners of a solid's box."""
    box = np.asarray(solid.bounding_box(), dtype=float)
    return box[:3], box[3:]
