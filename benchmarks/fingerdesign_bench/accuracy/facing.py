"""A second elastic body above the finger: what it yields to the finger's contact forces.

Its compliance, at the finger's contact nodes, is added to the finger's (contact_problem).
"""

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.body import check_sound, condensed_rows
from fingerdesign.fem.elements import inverse_map, margin, tabulate
from fingerdesign.fem.reduction import check_balance
from fingerdesign.fem.system import Body
from fingerdesign.mesh.cells import facet_kind
from fingerdesign.reduced import ReducedModel

_CHUNK = 256  # points at a time, against all facets
_OUTSIDE = 1e-3  # barycentric: an edge of the one body may miss that of the other by rounding


def facing_compliance(body: Body, finger: ReducedModel) -> Array:
    """Compliance (m dim, m dim) mm/N of an elastic object, at the finger's contact nodes.

    Minus the object's displacement there, a mean weighted with the finger's phi_i, per force on the
    *finger* (the object bears its opposite): the compliances of both bodies add up. Points of the
    finger meet those of the object's contact facets, all on its lower side, that have the same x
    (and z). Raises SolverError where the finger's candidates reach beyond these facets.
    """
    check_sound(body)
    rows = facing_rows(body, finger)
    system, _, blocks, _ = condensed_rows(body, [rows])
    size = rows.shape[0]
    reaction = blocks[1][:, :size] - (rows @ system.held).toarray().T
    check_balance(reaction, finger.locked, finger.nodes)
    compliance = blocks[0][:, :size].copy()
    locked = finger.locked.reshape(-1)
    compliance[locked] = 0.0
    compliance[:, locked] = 0.0
    return compliance


def facing_rows(body: Body, finger: ReducedModel) -> sp.csr_matrix:
    """Rows (m dim, n dim): row i of a component is the mean, weighted with the finger's phi_i, of
    the body's displacement over the finger's quadrature points."""
    points, surface = body.mesh.points, finger.surface
    kind = facet_kind(body.contact)
    facet, reference = facing_points(points, body.contact, surface.points)
    shape = tabulate(kind, reference).value  # (nodes, q)
    entry = surface.weight * shape[:, surface.point]
    row = np.broadcast_to(surface.node, entry.shape)
    column = body.contact[facet[surface.point]].T
    scalar = sp.coo_matrix(
        (entry.ravel(), (row.ravel(), column.ravel())), shape=(finger.nodes, len(points))
    )
    return sp.csr_matrix(sp.kron(scalar.tocsr(), sp.identity(body.mesh.dimension), format="csr"))


def facing_points(points: Array, facets: IntArray, targets: Array) -> tuple[IntArray, Array]:
    """Facet (q,) and its reference coordinates (dim - 1, q) over each target (q, dim)."""
    across = [0] if points.shape[1] == 2 else [0, 2]
    nodes = points[facets][:, :, across]
    low, high = nodes.min(axis=1), nodes.max(axis=1)
    kind, room = facet_kind(facets), 0.05 * (high - low).max(axis=1, keepdims=True)
    places = targets[:, across]
    pairs = []
    for start in range(0, len(places), _CHUNK):
        place = places[start : start + _CHUNK, None]
        near = ((place >= low - room) & (place <= high + room)).all(axis=2)
        pairs.append(np.argwhere(near) + np.array([start, 0]))
    target, facet = np.concatenate(pairs).T
    reference = inverse_map(kind, nodes[facet], places[target])
    least = margin(kind, reference)
    order = np.lexsort((-least, target))
    first = order[np.unique(target[order], return_index=True)[1]]
    found = np.zeros(len(places), dtype=bool)
    found[target[first]] = least[first] > -_OUTSIDE
    if not found.all():
        lost = targets[~found][0]
        raise SolverError(
            f"{int((~found).sum())} points of the finger's contact zone face no contact facet of "
            f"the other body (the first at x = {lost[0]:.4g} mm)"
        )
    return facet[first], reference[:, first]
