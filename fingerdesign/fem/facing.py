"""A second elastic body above the finger: what it yields to the finger's contact forces.

Its compliance, at the finger's contact nodes, is added to the finger's (contact_problem).
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.body import Body, check_balance, check_sound, condensed_rows
from fingerdesign.fem.elements import inverse_map, tabulate
from fingerdesign.fem.trace import owners
from fingerdesign.mesh.types import Mesh
from fingerdesign.reduced import ReducedModel

_CHUNK = 256  # points at a time, against all facets
_OUTSIDE = 1e-3  # barycentric: an edge of the one body may miss that of the other by rounding


def facing_compliance(body: Body, finger: ReducedModel) -> Array:
    """Compliance (m dim, m dim) mm/N of an elastic object, at the finger's contact nodes.

    Minus the object's displacement there, a mean weighted with the finger's phi_i, per force on the
    *finger* (the object bears its opposite): the compliances of both bodies add up. Points of the
    finger meet those of the object's contact facets that have the same x (and z). Raises
    SolverError where the finger's candidates reach beyond these facets, and where the object does
    not lie above the finger (its facets' outward normals have n_y < 0).
    """
    check_sound(body)
    rows = facing_rows(body.mesh, body.contact, finger)
    system, _, blocks, _ = condensed_rows(body, [rows])
    size = rows.shape[0]
    reaction = blocks[1][:, :size] - (rows @ system.held).toarray().T
    check_balance(reaction, finger.locked, finger.nodes)
    compliance = blocks[0][:, :size].copy()
    locked = finger.locked.reshape(-1)
    compliance[locked] = 0.0
    compliance[:, locked] = 0.0
    return compliance


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
