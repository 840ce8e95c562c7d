"""From quadratic contact facets to nodal contact forces that cannot lie.

Multipliers live on the corner nodes with hat functions phi_i; the displacement trace is quadratic.
Row i of the trace operator is the phi_i-weighted mean of the displacement,

    (M u)_i = (1 / a_i) integral phi_i u dA,     a_i = integral phi_i dA,

and its transpose spreads a nodal force f_i as the traction f_i phi_i / a_i. Source: the
quadratic/linear pair of mortar contact (Puso, Laursen, Solberg, CMAME 197 (2008) 555).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import inverse_map, quadrature, tabulate
from fingerdesign.mesh.types import TETRA_FACETS, TRIANGLE_EDGES, Mesh, with_mid_nodes
from fingerdesign.reduced import ReducedModel, SurfaceQuadrature

_CHUNK = 256  # points at a time, against all facets
_OUTSIDE = 1e-3  # barycentric: an edge of the one body may miss that of the other by rounding


def facing_rows(mesh: Mesh, facets: IntArray, finger: ReducedModel) -> sp.csr_matrix:
    """Rows (m dim, n dim): displacement of a body with ``facets`` (f, 3 or 6) at finger nodes.

    Row i of a component is the mean, weighted with the finger's phi_i, of the body's displacement
    at the points of its facets that have the same x (and z) as the finger's quadrature points.
    Raises SolverError for a point that faces no facet, or one that looks away; and for a body no
    part of which lies above the finger (overlapping it is no fault: that is what an approach is).
    """
    points, dimension = mesh.points, mesh.dimension
    targets = finger.surface.points
    if targets.shape[1] != dimension:
        raise SolverError(
            f"the object has {dimension} dimensions, the finger {targets.shape[1]}: both need the "
            "same"
        )
    down = facing_down(mesh, facets)
    if points[:, 1].max() <= targets[:, 1].max():
        raise SolverError(
            "the object lies behind the finger's contact face: it must lie above it (larger y)"
        )
    facet, reference = facing_points(points, facets, targets, down)
    shape = tabulate(dimension - 1, reference).value  # (nodes, q)
    surface = finger.surface
    entry = surface.weight * shape[:, surface.point]
    row = np.broadcast_to(surface.node, entry.shape)
    column = facets[facet[surface.point]].T
    scalar = sp.coo_matrix(
        (entry.ravel(), (row.ravel(), column.ravel())), shape=(finger.nodes, len(points))
    )
    return sp.csr_matrix(sp.kron(scalar.tocsr(), sp.identity(dimension), format="csr"))


def owners(mesh: Mesh, facets: IntArray) -> IntArray:
    """The cell (f,) that each facet (f, 3 or 6) of a body's boundary bounds.

    Raises SolverError for what is no facet: wrong width, nodes the mesh has not, corners that are
    no face of one cell, mid-edge nodes that are not between their corners.
    """
    dimension = mesh.dimension
    width = 3 * (dimension - 1)
    if facets.ndim != 2 or facets.shape[1] != width:
        raise SolverError(
            f"contact facets have the shape {facets.shape}: each must be {dimension} corners, then "
            f"{width - dimension} mid-edge nodes"
        )
    if len(facets) and not 0 <= facets.min() <= facets.max() < len(mesh.points):
        raise SolverError(
            f"contact facets name nodes {facets.min()} to {facets.max()}, the mesh has 0 to "
            f"{len(mesh.points) - 1}"
        )
    faces = TRIANGLE_EDGES if dimension == 2 else TETRA_FACETS
    named = np.zeros(len(mesh.points), dtype=bool)
    named[facets[:, :dimension]] = True
    near = np.flatnonzero(named[mesh.corners].sum(axis=1) >= dimension)
    corners = np.sort(mesh.corners[near][:, np.array(faces)], axis=2).reshape(-1, dimension)
    wanted = np.sort(facets[:, :dimension], axis=1)
    _, label = np.unique(np.concatenate([corners, wanted]), axis=0, return_inverse=True)
    label = label.reshape(-1)
    twice = len(facets) - len(np.unique(label[len(corners) :]))
    if twice:
        raise SolverError(f"{twice} contact facets are named more than once")
    cell = np.full(label.max(initial=-1) + 1, -1)
    cell[label[: len(corners)]] = near.repeat(len(faces))
    times = np.bincount(label[: len(corners)], minlength=len(cell))[label[len(corners) :]]
    if (times == 0).any():
        raise SolverError(
            f"{int((times == 0).sum())} contact facets are no face of a cell: name the corners "
            "first, then the mid-edge nodes"
        )
    if (times > 1).any():
        raise SolverError(
            f"{int((times > 1).sum())} contact facets lie inside the body: name those of its "
            "boundary"
        )
    found: IntArray = cell[label[len(corners) :]]
    wrong = (with_mid_nodes(mesh.cells[found], facets[:, :dimension]) != facets).any(axis=1)
    if wrong.any():
        raise SolverError(
            f"{int(wrong.sum())} contact facets have a mid-edge node that is not between its "
            "corners: name them in the order of the edges (0, 1), (1, 2), (0, 2)"
        )
    return found


def facing_down(mesh: Mesh, facets: IntArray) -> BoolArray:
    """Facets (f,) whose outward normal has n_y < 0; flat ones through the corners."""
    dimension = mesh.dimension
    cell = owners(mesh, facets)
    corners = mesh.points[facets[:, :dimension]]
    inner = mesh.points[mesh.corners[cell]].mean(axis=1) - corners[:, 0]
    edge = corners[:, 1:] - corners[:, :1]
    if dimension == 2:
        normal = np.stack([edge[:, 0, 1], -edge[:, 0, 0]], axis=1)
    else:
        normal = np.cross(edge[:, 0], edge[:, 1])
    inward = np.einsum("fa,fa->f", normal, inner) > 0.0
    return np.asarray(np.where(inward, -normal[:, 1], normal[:, 1]) < 0.0)


def facing_points(
    points: Array, facets: IntArray, targets: Array, down: BoolArray
) -> tuple[IntArray, Array]:
    """Facet (q,) and its reference coordinates (dim - 1, q) over each target (q, dim).

    down (f,): facets that look down, as all must that lie over a target.
    """
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
    reference = inverse_map(nodes[facet], wanted[target])
    least = np.minimum(reference.min(axis=0), 1.0 - reference.sum(axis=0))
    away = np.unique(facet[(least > _OUTSIDE) & ~down[facet]])
    if len(away):
        raise SolverError(
            f"{len(away)} contact facets of the object over the finger look away from it: name "
            "those on its lower side (outward normal with n_y < 0)"
        )
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


TRACE_ORDER = 6  # phi (1) x gap of a curved facet (2 and more) x Jacobian


@dataclass(frozen=True)
class ContactTrace:
    """nodes (m,) of the mesh; facets (f, dim) among them; operator (m dim, n dim)."""

    nodes: IntArray
    facets: IntArray
    facet_areas: Array
    areas: Array
    operator: sp.csr_matrix
    surface: SurfaceQuadrature


def contact_trace(points: Array, facets: IntArray, thickness: float = 1.0) -> ContactTrace:
    """Trace on quadratic ``facets`` (f, 3 or 6) of a mesh with ``points`` (n, dim)."""
    dimension = points.shape[1]
    where, weights = quadrature(dimension - 1, TRACE_ORDER)
    table = tabulate(dimension - 1, where)
    hats = tabulate(dimension - 1, where, degree=1).value
    corners = facets[:, :dimension]
    nodes, local = np.unique(corners, return_inverse=True)
    local = local.reshape(corners.shape)  # facet corners numbered among the nodes

    tangents = np.einsum("fna,nbq->fqab", points[facets], table.gradient, optimize=True)
    if dimension == 2:
        stretch = np.linalg.norm(tangents[..., 0], axis=2) * thickness
    else:
        stretch = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=2)
    measure: Array = stretch * weights  # (f, q)

    integral = np.einsum("iq,fq->fi", hats, measure)
    areas: Array = np.bincount(local.ravel(), integral.ravel(), minlength=len(nodes)).astype(float)
    blocks = np.einsum("iq,nq,fq->fin", hats, table.value, measure, optimize=True)
    blocks /= areas[local][:, :, None]
    row = np.broadcast_to(local[:, :, None], blocks.shape).ravel()
    column = np.broadcast_to(facets[:, None, :], blocks.shape).ravel()
    scalar = sp.coo_matrix((blocks.ravel(), (row, column)), shape=(len(nodes), len(points)))
    operator = sp.kron(scalar, sp.identity(dimension), format="csr")

    positions = np.einsum("nq,fna->fqa", table.value, points[facets], optimize=True)
    entry = (hats[None] * measure[:, None, :]) / areas[local][:, :, None]  # (f, i, q)
    count = positions.shape[1]
    number = np.arange(len(facets) * count).reshape(len(facets), 1, count)
    surface = SurfaceQuadrature(
        points=positions.reshape(-1, dimension),
        node=np.broadcast_to(local[:, :, None], entry.shape).ravel(),
        point=np.broadcast_to(number, entry.shape).ravel(),
        weight=entry.ravel(),
    )
    facet_areas: Array = measure.sum(axis=1)
    return ContactTrace(nodes, local, facet_areas, areas, operator, surface)
