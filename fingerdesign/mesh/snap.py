"""Put boundary nodes exactly on the CAD faces that they stand for, in closed form (numpy only).

fTetWild's surface sits micrometres inside the true one, several percent of a 0.1 mm approach. Every
node takes the faces of the facets around it: one on a face moves to it, one on an edge to both
faces, one at a corner to all three.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.mesh.boundary import Carriers
from fingerdesign.mesh.types import TETRA_EDGES, TRIANGLE_EDGES

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

# Least Jacobian of a curved tetrahedron over its straight one's; below, it is straightened.
LEAST_JACOBIAN_RATIO = 0.1


def snap_to_carriers(points: Array, lies_on: BoolArray, carriers: Carriers) -> Array:
    """Move points (n, 3) onto every CAD face that they lie on, (n, carriers); returns new points.

    The flat faces that meet in a node are perpendicular, so going to one after the other is exact;
    on the curved face a node then slides within its flat faces by Newton's method.
    """
    snapped = points.copy()
    for number, plane in enumerate(carriers.planes):
        rows = np.flatnonzero(lies_on[:, number])
        if len(rows):
            away = plane.distance(snapped[rows])
            snapped[rows] -= away[:, None] * np.array(plane.normal)
    curved = np.flatnonzero(lies_on[:, carriers.contact_number])
    if len(curved):
        snapped[curved] = _onto_contact(snapped[curved], lies_on[curved], carriers)
    return snapped


def _onto_contact(points: Array, lies_on: BoolArray, carriers: Carriers) -> Array:
    planes = [carriers.planes[number] for number in carriers.of_body]
    on_plane = lies_on[:, list(carriers.of_body)]
    blocked = on_plane[:, :, None] * np.array([plane.normal for plane in planes])
    points = points.copy()
    for _ in range(30):
        away = carriers.contact.distance(points)
        if np.abs(away).max() < 1e-13 * carriers.contact.radius:
            break
        normal = carriers.contact.normal(points)
        across = np.einsum("nij,nj->ni", blocked, normal)
        slide = normal - np.einsum("nij,ni->nj", blocked, across)
        slope = np.einsum("nj,nj->n", slide, slide)
        points -= (away / np.maximum(slope, 1e-3))[:, None] * slide
    return points


def tet_volumes(points: Array, tets: IntArray) -> Array:
    """Signed volumes (c,), mm^3, of tetrahedra by their first four nodes."""
    a, b, c, d = (points[tets[:, i]] for i in range(4))
    return np.asarray(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0)


def quadratic_facets(cells: IntArray, corners: IntArray, points: int) -> IntArray:
    """Mid-edge nodes for boundary triangles (f, 3) -> (f, 6), looked up in quadratic cells (c, 10).

    ``points`` is the number of nodes of the quadratic mesh.
    """
    ends = np.sort(np.stack([cells[:, list(pair)] for pair in TETRA_EDGES], axis=1), axis=2)
    keys = (ends[..., 0] * points + ends[..., 1]).reshape(-1)
    middles = cells[:, 4:].reshape(-1)
    keys, first = np.unique(keys, return_index=True)
    wanted = np.sort(np.stack([corners[:, list(p)] for p in TRIANGLE_EDGES], axis=1), axis=2)
    place = np.searchsorted(keys, wanted[..., 0] * points + wanted[..., 1])
    return np.hstack([corners, middles[first[place]]])


@dataclass(frozen=True)
class CurvedNodes:
    """Nodes with mid-nodes on the true surface; ``straightened``: how many could not be."""

    points: Array
    straightened: int


def curve_contact(
    points: Array, cells: IntArray, lies_on: BoolArray, carriers: Carriers, facets: IntArray
) -> CurvedNodes:
    """Project the mid-nodes of the contact facets (f, 6) onto the true surface.

    lies_on (corner nodes, carriers). Where a curved tetrahedron's Jacobian would fall below
    LEAST_JACOBIAN_RATIO of the straight one's, the mid-nodes of its edges stay straight, and are
    counted.
    """
    middles, first = np.unique(facets[:, 3:], return_index=True)
    ends = np.stack([facets[:, list(pair)] for pair in TRIANGLE_EDGES], axis=1).reshape(-1, 2)[
        first
    ]
    # An edge lies on a face only if both ends do; on the contact face it does by construction.
    edge_on = lies_on[ends[:, 0]] & lies_on[ends[:, 1]]
    straight = points[middles]
    curved = points.copy()
    curved[middles] = snap_to_carriers(straight, edge_on, carriers)
    bent = np.isin(cells[:, 4:], middles).any(axis=1)
    touched = cells[bent]
    backed_off: set[int] = set()
    for _ in range(10):
        bad = touched[least_jacobian_ratio(curved, touched) < LEAST_JACOBIAN_RATIO]
        back = np.intersect1d(bad[:, 4:], middles)
        if len(back) == 0:
            break
        backed_off.update(int(node) for node in back)
        curved[back] = straight[np.searchsorted(middles, back)]
    return CurvedNodes(curved, len(backed_off))


def least_jacobian_ratio(points: Array, cells: IntArray) -> Array:
    """Least Jacobian of quadratic tetrahedra (c, 10) over the straight one's, (c,).

    Sampled at corners, edges' middles and centroid; 1 for straight edges, <= 0 inverted.
    """
    if len(cells) == 0:
        return np.ones(0)
    corners = np.eye(4)
    middles = [0.5 * (corners[i] + corners[j]) for i, j in TETRA_EDGES]
    samples = np.vstack([corners, middles, np.full((1, 4), 0.25)])
    nodes = points[cells]
    straight = 6.0 * tet_volumes(points, cells)
    least = np.full(len(cells), np.inf)
    to_local = np.vstack([-np.ones(3), np.eye(3)])  # barycentric coordinates by local ones
    for sample in samples:
        gradient = np.zeros((10, 4))
        gradient[:4] = np.diag(4.0 * sample - 1.0)
        for edge, (i, j) in enumerate(TETRA_EDGES):
            gradient[4 + edge, i] = 4.0 * sample[j]
            gradient[4 + edge, j] = 4.0 * sample[i]
        jacobian = np.einsum("cni,nj->cij", nodes, gradient @ to_local)
        least = np.minimum(least, np.linalg.det(jacobian))
    return np.asarray(least / straight)
