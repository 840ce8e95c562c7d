"""What triangles say of themselves: edges, fans, shells, heights, areas, volume (numpy, scipy)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fingerdesign.arrays import Array, IntArray

# Flat faces differ by rounding only; the CAD turns curved ones by up to 0.3 rad a triangle.
_FLAT_RAD, _SMOOTH_RAD = 1e-5, 0.4


@dataclass(frozen=True)
class Topology:
    """Of a triangle mesh: edges that are not of two triangles, edges that both of their triangles
    run the same way, vertices beyond one fan each, and connected shells."""

    open_edges: int
    turned_edges: int
    extra_fans: int
    shells: int


def topology(triangles: IntArray) -> Topology:
    """Edges, fans and shells of triangles (t, 3); fans are counted over whole edges alone.

    >>> topology(np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))
    Topology(open_edges=0, turned_edges=0, extra_fans=0, shells=1)
    """
    count = len(triangles)
    tail, head = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    size = int(triangles.max()) + 1
    edge = np.minimum(tail, head) * size + np.maximum(tail, head)
    _, inverse, uses = np.unique(edge, return_inverse=True, return_counts=True)
    rising = np.bincount(inverse.reshape(-1), weights=tail < head, minlength=len(uses))
    turned = int(np.sum((uses == 2) & (rising != 1)))
    first, second = partners(triangles)
    shells = _parts(first // 3, second // 3, count)
    # A corner follows the next one about its vertex: across the edge that leaves the vertex.
    beyond = 3 * (second // 3) + (second + 1) % 3
    fans = _parts(first, beyond, 3 * count)
    return Topology(int(np.sum(uses != 2)), turned, fans - len(np.unique(tail)), shells)


def partners(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Half-edges 3 t + k (from corner k to k + 1) with the one that runs back along each."""
    tail, head = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    size = int(triangles.max()) + 1
    there, back = tail * size + head, head * size + tail
    order = np.argsort(there, kind="stable")
    place = np.minimum(np.searchsorted(there[order], back), len(order) - 1)
    second = order[place]
    found = there[second] == back
    return np.flatnonzero(found), second[found]


def doubled_areas(vertices: Array, triangles: IntArray) -> Array:
    """Normals times twice the area (t, 3), by the right-hand rule."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.asarray(np.cross(b - a, c - a))


def areas(vertices: Array, triangles: IntArray) -> Array:
    """Area of each triangle (t,), mm^2."""
    return np.asarray(0.5 * np.linalg.norm(doubled_areas(vertices, triangles), axis=1))


def heights(vertices: Array, triangles: IntArray) -> Array:
    """Least height of each triangle (t,), mm: twice its area over its longest side."""
    corners = vertices[triangles]
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    double = np.linalg.norm(doubled_areas(vertices, triangles), axis=1)
    return np.asarray(double / np.maximum(longest, np.finfo(float).tiny))


def volume(vertices: Array, triangles: IntArray) -> float:
    """Enclosed volume, mm^3, positive where wound outward; about the vertices' middle."""
    a, b, c = (vertices[triangles[:, k]] - vertices.mean(axis=0) for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def curved(vertices: Array, triangles: IntArray) -> NDArray[np.bool_]:
    """Which triangles (t,) stand for curved faces: a neighbour is turned, but only a little."""
    normals = doubled_areas(vertices, triangles)
    sizes = np.linalg.norm(normals, axis=1)
    normals = normals / np.maximum(sizes, np.finfo(float).tiny)[:, None]
    first, second = partners(triangles)
    turn = np.linalg.norm(normals[first // 3] - normals[second // 3], axis=1)
    found = np.zeros(len(triangles), dtype=bool)
    found[first[(turn > _FLAT_RAD) & (turn < _SMOOTH_RAD)] // 3] = True
    return found


def curved_area(vertices: Array, triangles: IntArray) -> float:
    """Area of the triangles that stand for curved faces, mm^2."""
    return float(areas(vertices, triangles)[curved(vertices, triangles)].sum())


def _parts(first: IntArray, second: IntArray, count: int) -> int:
    links = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(count, count))
    return int(connected_components(links, directed=False, return_labels=False))


# Seeded points on triangle meshes, and rays from them through solids. Lengths in mm.

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
