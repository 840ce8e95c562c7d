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

from fingerdesign.arrays import Array, IntArray
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.reduced import SurfaceQuadrature

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
    hats = _hat_functions(where)
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


def _hat_functions(where: Array) -> Array:
    """Linear shape functions (dim, q) at reference points (dim - 1, q)."""
    return np.vstack([1.0 - where.sum(axis=0), where])
