"""Quadratic triangles and tetrahedra: scikit-fem's reference bases, mapped isoparametrically."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import skfem
from numpy.typing import NDArray
from skfem.quadrature import get_quadrature

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

_ELEMENTS = {
    1: skfem.ElementLineP2(),
    2: skfem.ElementTriP2(),
    3: skfem.ElementTetP2(),
}


@dataclass(frozen=True)
class Tabulation:
    """Shape functions at reference points: value (n, q), gradient (n, d, q), weights (q,)."""

    value: Array
    gradient: Array
    weights: Array


def tabulate(dimension: int, points: Array, weights: Array | None = None) -> Tabulation:
    """Quadratic shape functions of the reference simplex at ``points`` (d, q)."""
    element = _ELEMENTS[dimension]
    count = len(element.doflocs)
    values, gradients = [], []
    for i in range(count):
        value, gradient = element.lbasis(points, i)
        values.append(np.broadcast_to(value, points.shape[1:]))
        gradients.append(np.broadcast_to(gradient, points.shape))
    used = np.ones(points.shape[1]) if weights is None else weights
    return Tabulation(np.array(values), np.array(gradients), used)


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


def physical_gradients(points: Array, cells: IntArray, order: int) -> tuple[Array, Array]:
    """Shape gradients (c, q, n, d) in mm^-1 and volume weights (c, q) in mm^d.

    Raises ValueError where a Jacobian is not positive (an inverted cell).
    """
    dimension = points.shape[1]
    table = tabulate(dimension, *quadrature(dimension, order))
    jacobian = jacobians(points[cells], table.gradient)
    determinant = np.linalg.det(jacobian)
    if not (determinant > 0.0).all():
        raise ValueError(f"{int((determinant <= 0).any(axis=1).sum())} inverted cells")
    inverse = np.linalg.inv(jacobian)
    gradients = np.einsum("nbq,cqba->cqna", table.gradient, inverse, optimize=True)
    return gradients, determinant * table.weights
