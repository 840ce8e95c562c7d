"""Which points lie inside a closed triangulated surface: rays, counted (numpy only)."""

from __future__ import annotations

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import MeshError

_PAIRS = 4_000_000  # of point and triangle, tested at a time: memory stays under 1 GB
# The rays' direction: along no edge and in no plane of a finger, so that none grazes a triangle.
_AXES = np.linalg.qr(np.array([[0.9, 0.31, 0.17], [-0.2, 0.87, 0.41], [0.13, -0.29, 0.93]]))[0]


def enclosed(points: Array, vertices: Array, triangles: IntArray) -> BoolArray:
    """Whether points (n, 3) lie inside the closed surface of triangles (t, 3), (n,).

    A ray from each point is inside where it crosses the surface an odd number of times. Triangles
    are sorted into the cells of a grid across the rays, so that each ray meets few.
    """
    turned, corners = points @ _AXES, (vertices @ _AXES)[triangles]
    low = corners[..., :2].min(axis=(0, 1))
    extent = np.ptp(corners[..., :2].reshape(-1, 2), axis=0)
    cells = int(np.clip(2.0 * np.sqrt(len(triangles)), 16, 512))
    scale = cells / (extent * (1.0 + 1e-9))
    first = np.floor((corners[..., :2].min(axis=1) - low) * scale).astype(np.int64)
    last = np.floor((corners[..., :2].max(axis=1) - low) * scale).astype(np.int64)
    counts = last - first + 1
    number = np.repeat(np.arange(len(triangles)), counts.prod(axis=1))
    within = _ranges(counts.prod(axis=1))
    column = first[number, 0] + within // counts[number, 1]
    row = first[number, 1] + within % counts[number, 1]
    cell = column * cells + row
    order = np.argsort(cell, kind="stable")
    number, start = number[order], np.searchsorted(cell[order], np.arange(cells * cells + 1))

    found = np.zeros(len(points), dtype=bool)
    place = np.floor((turned[:, :2] - low) * scale).astype(np.int64)
    near = np.flatnonzero(((place >= 0) & (place < cells)).all(axis=1))
    own = place[near, 0] * cells + place[near, 1]
    amount = start[own + 1] - start[own]
    ends = np.cumsum(amount)
    begin = 0
    while begin < len(near):
        done = ends[begin - 1] if begin else 0
        stop = max(int(np.searchsorted(ends, done + _PAIRS)), begin + 1)
        rows = slice(begin, stop)
        point = np.repeat(near[rows], amount[rows])
        triangle = number[np.repeat(start[own[rows]], amount[rows]) + _ranges(amount[rows])]
        crossed = point[_above(turned[point], corners[triangle])]
        found ^= np.bincount(crossed, minlength=len(points)) % 2 == 1
        begin = stop
    return found


def check_closed(vertices: Array, triangles: IntArray) -> None:
    """MeshError unless every edge has two triangles: rays would miscount."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    if np.any(uses != 2):
        raise MeshError(f"the outside is not closed: {int((uses != 2).sum())} edges are open")


def _above(points: Array, corners: Array) -> BoolArray:
    """Whether the ray from each point along the third axis crosses its triangle, (n,)."""
    a, b, c = (corners[:, k] - points for k in range(3))
    u = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    v = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    w = c[:, 0] * a[:, 1] - c[:, 1] * a[:, 0]
    inside = ((u > 0) & (v > 0) & (w > 0)) | ((u < 0) & (v < 0) & (w < 0))
    total = np.where(inside, u + v + w, 1.0)
    return np.asarray(inside & ((u * c[:, 2] + v * a[:, 2] + w * b[:, 2]) / total > 0.0))


def _ranges(counts: IntArray) -> IntArray:
    """0 .. count - 1 for each count, one after the other."""
    starts = np.cumsum(counts) - counts
    return np.asarray(np.arange(counts.sum()) - np.repeat(starts, counts))
