"""Triangles and tetrahedra: scikit-fem's reference bases, mapped isoparametrically."""

from dataclasses import dataclass

import numpy as np
import skfem
from skfem.quadrature import get_quadrature

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.mesh.cells import TETRA_EDGES, TRIANGLE_EDGES

_FOUND = 1e-14  # A smaller step, relative to a cell, ends the search for a point.
EDGES = {2: TRIANGLE_EDGES, 3: TETRA_EDGES}
_ELEMENTS = {
    (1, 1): skfem.ElementLineP1(),
    (2, 1): skfem.ElementTriP1(),
    (3, 1): skfem.ElementTetP1(),
    (1, 2): skfem.ElementLineP2(),
    (2, 2): skfem.ElementTriP2(),
    (3, 2): skfem.ElementTetP2(),
}


@dataclass(frozen=True)
class Tabulation:
    """Shape functions at reference points: value (n, q), gradient (n, d, q), weights (q,)."""

    value: Array
    gradient: Array
    weights: Array


def tabulate(
    dimension: int, points: Array, weights: Array | None = None, degree: int = 2
) -> Tabulation:
    """Shape functions (quadratic, or linear) of the reference simplex at ``points`` (d, q)."""
    element = _ELEMENTS[dimension, degree]
    count = len(element.doflocs)
    value, gradient = np.empty((count, *points.shape[1:])), np.empty((count, *points.shape))
    for i in range(count):
        value[i], gradient[i] = element.lbasis(points, i)
    used = np.ones(points.shape[1]) if weights is None else weights
    return Tabulation(value, gradient, used)


def quadrature(dimension: int, order: int) -> tuple[Array, Array]:
    """Points (d, q) and weights (q,) exact to ``order`` on the reference simplex."""
    points, weights = (
        get_quadrature(skfem.refdom.RefLine, order)
        if dimension == 1
        else (get_quadrature(skfem.refdom.RefTri if dimension == 2 else skfem.refdom.RefTet, order))
    )
    return np.asarray(points), np.asarray(weights)


def jacobians(nodes: Array, gradient: Array) -> Array:
    """Jacobians (c, q, d, d), J[a, b] = d x_a / d X_b, of cells with nodes (c, n, d)."""
    return np.asarray(np.einsum("cna,nbq->cqab", nodes, gradient, optimize=True))


def inverse_jacobians(points: Array, cells: IntArray, straight: BoolArray) -> tuple[Array, Array]:
    """d X_a / d x_k (c, d, d) mm^-1 and det (c,) mm^d of cells, from their corners.

    Raises ValueError where a ``straight`` cell is inverted; others need :func:`physical_gradients`.
    """
    corners = points[cells[:, : points.shape[1] + 1]]
    jacobian = (corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    determinant: Array = np.linalg.det(jacobian)
    _refuse_inverted(determinant[straight])
    jacobian[determinant == 0.0] = np.eye(points.shape[1])
    return np.linalg.inv(jacobian).astype(float, copy=False), determinant


def physical_gradients(
    points: Array, cells: IntArray, order: int, degree: int = 2
) -> tuple[Array, Array]:
    """Shape gradients (c, q, n, d) in mm^-1 and volume weights (c, q) in mm^d.

    degree: of the shape functions; the geometry is quadratic. Raises ValueError where a Jacobian is
    not positive (an inverted cell).
    """
    dimension = points.shape[1]
    rule = quadrature(dimension, order)
    jacobian = jacobians(points[cells], tabulate(dimension, *rule).gradient)
    table = tabulate(dimension, *rule, degree)
    determinant = np.linalg.det(jacobian)
    _refuse_inverted(determinant)
    inverse = np.linalg.inv(jacobian)
    gradients = np.einsum("nbq,cqba->cqna", table.gradient, inverse, optimize=True)
    return gradients, determinant * table.weights


def inverse_map(nodes: Array, places: Array) -> Array:
    """Reference coordinates (d, k) of ``places`` (k, d) in cells with nodes (k, n, d): Newton's."""
    dimension = nodes.shape[2]
    reference = np.full((dimension, len(nodes)), 1.0 / (dimension + 1))
    for _ in range(8):
        table = tabulate(dimension, reference)
        miss = places - np.einsum("kna,nk->ka", nodes, table.value)
        jacobian = np.einsum("kna,nbk->kab", nodes, table.gradient)
        steep = (
            np.abs(np.linalg.det(jacobian)) < 1e-12 * np.abs(jacobian).max(axis=(1, 2)) ** dimension
        )
        jacobian[steep] = np.eye(dimension)  # a facet seen edge on: left outside by the clip
        before = reference
        reference = reference + np.linalg.solve(jacobian, miss[:, :, None])[:, :, 0].T
        np.clip(reference, -2.0, 3.0, out=reference)
        if np.abs(reference - before).max(initial=0.0) < _FOUND:
            break
    reference[:, steep] = -2.0
    return reference


def _refuse_inverted(determinant: Array) -> None:
    inverted = ~(determinant > 0.0)
    if inverted.any():
        count = int(inverted.reshape(len(inverted), -1).any(axis=1).sum())
        raise ValueError(f"{count} inverted cells")
