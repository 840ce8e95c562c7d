"""Which region a cell lies in, which facets bound it, and which CAD face carries each facet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.tetra.carriers import Carriers
from fingerdesign.mesh.types import TETRA_FACETS, facet_keys

# Which points lie inside a closed triangulated surface: rays, counted (numpy only).

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


def regions_by_centroid(points: Array, tets: IntArray, frames: tuple[PlateFrame, ...]) -> IntArray:
    """0 for elastomer, k + 1 for plate k: the plate that holds a tetrahedron's centroid."""
    centroids = points[tets].mean(axis=1)
    regions = np.zeros(len(tets), dtype=np.int64)
    for frame in frames:
        regions[frame.holds(centroids)] = frame.index + 1
    return regions


@dataclass(frozen=True)
class BoundaryFacets:
    """Facets that lie on CAD faces: outside, and between elastomer and parts.

    corners (f, 3); carrier (f,): number of the CAD face; outside (f,): True on the body's outside;
    cell (f,): the cell they belong to, the part's for those between; name (f,): the boundary's, of
    outer facets; misfit (f,): greatest distance of a corner to the carrier, mm
    """

    corners: IntArray
    carrier: IntArray
    outside: BoolArray
    cell: IntArray
    name: NDArray[np.str_]
    misfit: Array

    def on_carriers(self, nodes: int, carriers: Carriers) -> BoolArray:
        """Whether each node lies on each carrier, (n, carriers): by its facets."""
        found = np.zeros((nodes, len(carriers.faces)), dtype=bool)
        for corner in range(3):
            found[self.corners[:, corner], self.carrier] = True
        return found


def boundary_facets(
    points: Array, tets: IntArray, regions: IntArray, carriers: Carriers, besides: IntArray
) -> BoundaryFacets:
    """Find the facets on CAD faces, and the face that carries each: the nearest by its corners.

    Among faces equally near (at a corner of the body), the best aligned one is taken. ``besides``
    (f, 3): corners of facets to leave out (slots of sheets).
    """
    local = np.array(TETRA_FACETS)
    opposite = np.array([6 - sum(facet) for facet in TETRA_FACETS])
    facets = tets[:, local].reshape(-1, 3)
    apexes = tets[:, opposite].reshape(-1)
    cells = np.repeat(np.arange(len(tets)), 4)
    keys = facet_keys(facets, len(points))
    order = np.argsort(keys, kind="stable")
    same = keys[order][1:] == keys[order][:-1]
    paired = np.zeros(len(order), dtype=bool)
    paired[:-1] |= same
    paired[1:] |= same
    lonely = order[~paired]
    if len(besides):
        lonely = lonely[~np.isin(keys[lonely], facet_keys(besides, len(points)))]
    first, second = order[:-1][same], order[1:][same]
    differ = regions[cells[first]] != regions[cells[second]]
    first, second = first[differ], second[differ]
    # A facet between two parts would count for the higher: such parts touch, which is refused.
    chosen = np.where(regions[cells[first]] > regions[cells[second]], first, second)
    picked = np.concatenate([lonely, chosen])
    outside = np.arange(len(picked)) < len(lonely)
    corners, cell = facets[picked], cells[picked]
    corners = _outward(points, corners, apexes[picked])
    carrier = np.zeros(len(picked), dtype=np.int64)
    misfit = np.zeros(len(picked))
    carrier[outside], misfit[outside] = _nearest(
        points, corners[outside], carriers, carriers.outside
    )
    for region, numbers in carriers.of_part.items():
        own = ~outside & (regions[cell] == region)
        carrier[own], misfit[own] = _nearest(points, corners[own], carriers, numbers)
    names = _names(points, corners, carrier, carriers)
    return BoundaryFacets(corners, carrier, outside, cell, names, misfit)


def _names(
    points: Array, corners: IntArray, carrier: IntArray, carriers: Carriers
) -> NDArray[np.str_]:
    """The boundary's name of each facet (f,).

    On a carrier of several boundaries, which join without an edge, the contact's facets are those
    with all corners on it, the others their middle's.
    """
    names = np.array([face.name for face in carriers.faces])[carrier]
    for number, face in enumerate(carriers.faces):
        rest = [name for name in face.boundaries if name != "contact"]
        if len(face.boundaries) == 1:
            continue
        rows = np.flatnonzero(carrier == number)
        used, inverse = np.unique(corners[rows], return_inverse=True)
        touching = (face.names(points[used]) == "contact")[inverse.reshape(-1, 3)].all(axis=1)
        middle = face.names(points[corners[rows]].mean(axis=1))
        middle = np.where(middle == "contact", rest[0], middle)
        names[rows] = np.where(touching, "contact", middle)
    return names


def _outward(points: Array, corners: IntArray, apex: IntArray) -> IntArray:
    """Turn triangles so that their normal points away from their cell's fourth corner."""
    a, b, c = (points[corners[:, i]] for i in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), points[apex] - a) > 0
    return np.asarray(np.where(inward[:, None], corners[:, [0, 2, 1]], corners))


def _nearest(
    points: Array, corners: IntArray, carriers: Carriers, numbers: tuple[int, ...]
) -> tuple[IntArray, Array]:
    if len(corners) == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    used, inverse = np.unique(corners, return_inverse=True)
    inverse = inverse.reshape(corners.shape)
    faces = [carriers.faces[number] for number in numbers]
    a, b, c = (points[corners[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    normal /= np.maximum(size, 1e-300)[:, None]
    middle = (a + b + c) / 3.0
    misfit = np.stack([face.misfit(points[used])[inverse].max(axis=1) for face in faces], axis=1)
    aligned = np.stack(
        [np.einsum("ij,ij->i", normal, face.normal(middle)) for face in faces], axis=1
    )
    # A facet as large as its misfit may lean either way: alignment decides between near rivals.
    cost = misfit + 0.25 * np.sqrt(size)[:, None] * (1.0 - aligned)
    best = cost.argmin(axis=1)
    rows = np.arange(len(best))
    return np.array(numbers, dtype=np.int64)[best], misfit[rows, best]
