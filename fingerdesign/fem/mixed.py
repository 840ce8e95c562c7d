"""The pressure of a nearly incompressible material as an unknown of its own (Taylor-Hood).

    [ A   B ] [u]   [f]      A = integral 2 mu eps(u) : eps(v)
    [ B^T -M ] [p] = [0],     B = - integral p div v,    M = integral p q / lame

with quadratic displacements and linear continuous pressures p = -lame div u (MPa, compression
positive), so that the volume does not lock as lame grows. Each material has pressures of its own:
they jump where it ends. Source: Hughes, The Finite Element Method (1987), 4.3-4.4; stability of the
pair: Taylor and Hood, Computers and Fluids 1 (1973) 73.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.fem.assembly import lame_parameters, straight_cells
from fingerdesign.fem.elements import (
    inverse_jacobians,
    physical_gradients,
    quadrature,
    tabulate,
)

_ORDER = 2  # pressure (1) times divergence (1)


@dataclass(frozen=True)
class Pressures:
    """nodes (pressures,): the corner of each; coupling (n dim, pressures): B; compliance
    (pressures, pressures): upper triangle of M."""

    nodes: IntArray
    coupling: sp.csr_matrix
    compliance: sp.csr_matrix


def pressure_coupling(
    points: Array,
    cells: IntArray,
    youngs_modulus: Array,
    poissons_ratio: Array,
    thickness: float = 1.0,
) -> Pressures:
    """B and M of the given cells (c, 6 or 10), all of which carry pressures (0 < nu < 0.5)."""
    dimension = points.shape[1]
    corners = dimension + 1
    first, _ = lame_parameters(youngs_modulus, poissons_ratio)
    numbers, nodes = pressure_nodes(cells[:, :corners], youngs_modulus, poissons_ratio)
    count = len(nodes)
    coupling, mass = _blocks(points, cells)
    row = (cells[:, :, None, None] * dimension + np.arange(dimension)[:, None]).repeat(corners, 3)
    column = np.broadcast_to(numbers[:, None, None, :], row.shape)
    entries = (-thickness * coupling.ravel(), (row.ravel(), column.ravel()))
    b = sp.coo_matrix(entries, shape=(points.size, count)).tocsr()
    mass *= (thickness / first)[:, None, None]
    low = np.broadcast_to(numbers[:, :, None], mass.shape).ravel()
    high = np.broadcast_to(numbers[:, None, :], mass.shape).ravel()
    upper = low <= high
    m = sp.coo_matrix((mass.ravel()[upper], (low[upper], high[upper])), shape=(count, count))
    return Pressures(nodes, b, m.tocsr())


def pressure_nodes(
    corners: IntArray, youngs_modulus: Array, poissons_ratio: Array
) -> tuple[IntArray, IntArray]:
    """Pressure numbers (c, corners), one a material and corner node, and the node of each."""
    pairs = np.column_stack([youngs_modulus, poissons_ratio])
    materials = np.unique(pairs, axis=0, return_inverse=True)[1].reshape(-1, 1)
    size = int(corners.max()) + 1
    keys = materials * size + corners
    used, numbers = np.unique(keys, return_inverse=True)
    return numbers.reshape(corners.shape).astype(np.int64), used % size


def _blocks(points: Array, cells: IntArray) -> tuple[Array, Array]:
    """Integrals of dN_i/dx_k L_m as (c, i, k, m), and of L_m L_n as (c, m, n)."""
    dimension = points.shape[1]
    rule = quadrature(dimension, _ORDER)
    table, linear = tabulate(dimension, *rule), tabulate(dimension, *rule, degree=1)
    straight = straight_cells(points, cells)
    inverse, determinant = inverse_jacobians(points, cells, straight)
    constant = np.einsum("iaq,mq,q->iam", table.gradient, linear.value, table.weights)
    mass = np.einsum("mq,nq,q->mn", linear.value, linear.value, table.weights)
    scaled = determinant[:, None, None] * inverse
    coupling = np.einsum("iam,cak->cikm", constant, scaled, optimize=True)
    masses = determinant[:, None, None] * mass
    curved = np.flatnonzero(~straight)
    gradients, weights = physical_gradients(points, cells[curved], _ORDER)
    coupling[curved] = np.einsum(
        "cqik,mq,cq->cikm", gradients, linear.value, weights, optimize=True
    )
    masses[curved] = np.einsum("mq,nq,cq->cmn", linear.value, linear.value, weights, optimize=True)
    return coupling, masses
