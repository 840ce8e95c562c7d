"""From quadratic contact facets to nodal contact forces that cannot lie.

Multipliers live on the corner nodes with hat functions phi_i; the displacement trace is quadratic.
Row i of the trace operator is the phi_i-weighted mean of the displacement,

    (M u)_i = (1 / a_i) integral phi_i u dA,     a_i = integral phi_i dA,

and its transpose spreads a nodal force f_i as the traction f_i phi_i / a_i. Source: the
quadratic/linear pair of mortar contact (Puso, Laursen, Solberg, CMAME 197 (2008) 555).
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.mesh.cells import FACETS_BY_NODES, SQUARE, facet_kind, with_mid_nodes
from fingerdesign.mesh.types import Mesh
from fingerdesign.reduced import SurfaceQuadrature

TRACE_ORDER = 6  # The degree of phi (1) x gap of a curved facet (2 and more) x Jacobian.


def owners(mesh: Mesh, facets: IntArray) -> IntArray:
    """The cell (f,) that each facet (f, nodes) of a body's boundary bounds.

    Raises SolverError for what is no facet: wrong width, nodes the mesh has not, corners that are
    no face of one cell, mid-edge nodes that are not between their corners.
    """
    kind = FACETS_BY_NODES.get(facets.shape[-1]) if facets.ndim == 2 else None
    own = {len(facet) for facet in mesh.kind.facets}
    if kind is None or kind.corners not in own:
        known = ", or ".join(
            f"{each.corners} corners, then {len(each.edges)} mid-edge nodes"
            + ", then the centre" * len(each.squares)
            for each in FACETS_BY_NODES.values()
            if each.corners in own
        )
        raise SolverError(f"contact facets have the shape {facets.shape}: each must be {known}")
    width = kind.corners
    if len(facets) and not 0 <= facets.min() <= facets.max() < len(mesh.points):
        raise SolverError(
            f"contact facets name nodes {facets.min()} to {facets.max()}, the mesh has 0 to "
            f"{len(mesh.points) - 1}"
        )
    faces = [facet for facet in mesh.kind.facets if len(facet) == width]
    named = np.zeros(len(mesh.points), dtype=bool)
    named[facets[:, :width]] = True
    near = np.flatnonzero(named[mesh.corners].sum(axis=1) >= width)
    corners = np.sort(mesh.corners[near][:, np.array(faces)], axis=2).reshape(-1, width)
    sought = np.sort(facets[:, :width], axis=1)
    _, label = np.unique(np.concatenate([corners, sought]), axis=0, return_inverse=True)
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
    wrong = (with_mid_nodes(mesh.cells[found], facets[:, :width]) != facets).any(axis=1)
    if wrong.any():
        raise SolverError(
            f"{int(wrong.sum())} contact facets have a mid-edge node that is not between its "
            "corners: name them in the order of the edges (0, 1), (1, 2), (0, 2)"
        )
    return found


@dataclass(frozen=True)
class ContactTrace:
    """nodes (m,) of the mesh; facets (f, dim) among them, a square as two triangles; operator
    (m dim, n dim)."""

    nodes: IntArray
    facets: IntArray
    facet_areas: Array
    areas: Array
    operator: sp.csr_matrix
    surface: SurfaceQuadrature


def contact_trace(points: Array, facets: IntArray, thickness: float = 1.0) -> ContactTrace:
    """Trace on quadratic ``facets`` (f, nodes) of a mesh with ``points`` (n, dim)."""
    dimension, kind = points.shape[1], facet_kind(facets)
    where, weights = quadrature(kind, TRACE_ORDER)
    table = tabulate(kind, where)
    hats = tabulate(kind, where, degree=1).value
    corners = facets[:, : kind.corners]
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
    if kind is SQUARE:
        local, facet_areas = _halved(points[nodes], local, facet_areas)
    return ContactTrace(nodes, local, facet_areas, areas, operator, surface)


def on_another(trace: ContactTrace, own: Mesh, other: Mesh) -> ContactTrace:
    """The trace on ``own``, read off the displacements of another mesh of the same surface.

    Both are swept: nodes of the surface lie in rows along x and z, and displacements are quadratic
    over each three of a row. The nodes remain those of ``own``. Raises SolverError where the other
    surface's nodes are not in rows.
    """
    seen, known = (np.unique(mesh.facets["contact"]) for mesh in (own, other))
    weights, crossings = np.ones((len(seen), len(known))), 1
    for axis in (0, 2):
        at, rows = (np.round(m.points[n, axis], 9) for m, n in ((own, seen), (other, known)))
        stations, row = np.unique(rows, return_inverse=True)
        weights *= _quadratic(stations, at)[:, row.ravel()]
        crossings *= len(stations)
    if crossings != len(known):
        raise SolverError("the nodes of the contact surface are not in rows along x and z")
    place = sp.csr_matrix(weights).tocoo()
    shape = (len(own.points), len(other.points))
    scalar = sp.coo_matrix((place.data, (seen[place.row], known[place.col])), shape)
    moved = sp.kron(scalar, sp.identity(other.dimension), format="csr")
    return replace(trace, operator=sp.csr_matrix(trace.operator @ moved))


def _quadratic(stations: Array, at: Array) -> Array:
    """Weights (k, n) by which values at n stations, rising, give those at places (k,)."""
    last = len(stations) // 2 - 1
    first = 2 * np.clip(np.searchsorted(stations[::2], at, side="right") - 1, 0, last)
    three = np.array([stations[first + k] for k in range(3)])
    weights = np.zeros((len(at), len(stations)))
    for k, own in enumerate(three):
        others = np.delete(three, k, axis=0)
        weights[np.arange(len(at)), first + k] = np.prod((at - others) / (own - others), axis=0)
    return weights


def _halved(points: Array, squares: IntArray, areas: Array) -> tuple[IntArray, Array]:
    """Squares (f, 4) cut into triangles (2 f, 3) of half their areas (f,). The cuts of squares that
    mirror in the middle of their range of x, or in z = 0, mirror as well."""
    middle = points[squares].mean(axis=1)
    first = points[squares[:, 0]] - middle
    centre = [0.5 * (points[:, 0].min() + points[:, 0].max()), 0.0, 0.0]
    rising = (first * (middle - centre))[:, [0, 2]].prod(axis=1) > 0.0
    turned = np.where(rising[:, None], squares, np.roll(squares, 1, axis=1))
    return np.vstack([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]), np.tile(0.5 * areas, 2)
