"""Where one body's contact points meet the quadratic contact facets of another, along y."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import tabulate
from fingerdesign.reduced import ReducedModel

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

_CHUNK = 256  # points at a time, against all facets
_OUTSIDE = 1e-3  # barycentric: an edge of the one body may miss that of the other by rounding


def facing_rows(points: Array, facets: IntArray, finger: ReducedModel) -> sp.csr_matrix:
    """Rows (m dim, n dim): displacement of a body with ``facets`` (f, 3 or 6) at finger nodes.

    Row i of a component is the mean, weighted with the finger's phi_i, of the body's displacement
    at the points of its facets that have the same x (and z) as the finger's quadrature points.
    Raises SolverError for a point that faces no facet.
    """
    dimension = points.shape[1]
    facet, reference = facing_points(points, facets, finger.surface.points)
    shape = tabulate(dimension - 1, reference).value  # (nodes, q)
    surface = finger.surface
    entry = surface.weight * shape[:, surface.point]
    row = np.broadcast_to(surface.node, entry.shape)
    column = facets[facet[surface.point]].T
    scalar = sp.coo_matrix(
        (entry.ravel(), (row.ravel(), column.ravel())), shape=(finger.nodes, len(points))
    )
    return sp.csr_matrix(sp.kron(scalar.tocsr(), sp.identity(dimension), format="csr"))


def facing_points(points: Array, facets: IntArray, targets: Array) -> tuple[IntArray, Array]:
    """Facet (q,) and its reference coordinates (dim - 1, q) over each target (q, dim)."""
    across = [0] if points.shape[1] == 2 else [0, 2]
    nodes = points[facets][:, :, across]
    low, high = nodes.min(axis=1), nodes.max(axis=1)
    margin = 0.05 * (high - low).max(axis=1, keepdims=True)
    wanted = targets[:, across]
    pairs = []
    for start in range(0, len(wanted), _CHUNK):
        place = wanted[start : start + _CHUNK, None]
        near = ((place >= low - margin) & (place <= high + margin)).all(axis=2)
        pairs.append(np.argwhere(near) + np.array([start, 0]))
    target, facet = np.concatenate(pairs).T
    reference = _inverse(nodes[facet], wanted[target])
    least = np.minimum(reference.min(axis=0), 1.0 - reference.sum(axis=0))
    order = np.lexsort((-least, target))
    first = order[np.unique(target[order], return_index=True)[1]]
    found = np.zeros(len(wanted), dtype=bool)
    found[target[first]] = least[first] > -_OUTSIDE
    if not found.all():
        lost = targets[~found][0]
        raise SolverError(
            f"{int((~found).sum())} points of the finger's contact zone face no contact facet of "
            f"the other body (the first at x = {lost[0]:.4g} mm): make the zone narrower or that "
            "body wider"
        )
    return facet[first], reference[:, first]


def _inverse(nodes: Array, places: Array) -> Array:
    """Reference coordinates (d, k) of ``places`` (k, d) in facets seen along y (k, nodes, d)."""
    dimension = places.shape[1]
    reference = np.full((dimension, len(nodes)), 1.0 / (dimension + 1))
    for _ in range(8):
        table = tabulate(dimension, reference)
        miss = places - np.einsum("kna,nk->ka", nodes, table.value)
        jacobian = np.einsum("kna,nbk->kab", nodes, table.gradient)
        steep = (
            np.abs(np.linalg.det(jacobian)) < 1e-12 * np.abs(jacobian).max(axis=(1, 2)) ** dimension
        )
        jacobian[steep] = np.eye(dimension)  # a facet seen edge on: left outside by the clip
        reference = reference + np.linalg.solve(jacobian, miss[:, :, None])[:, :, 0].T
        np.clip(reference, -2.0, 3.0, out=reference)
    reference[:, steep] = -2.0
    return reference
