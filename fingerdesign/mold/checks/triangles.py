"""What triangles say of themselves: edges, fans, shells, heights, areas, volume (numpy, scipy)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
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
