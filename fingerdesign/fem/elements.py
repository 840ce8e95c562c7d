"""Lines, triangles, squares, tetrahedra and prisms: reference bases, mapped isoparametrically.

Those of simplices are scikit-fem's; a square's and a prism's are products, a prism's of a triangle
in the section and a line along z.
"""

from dataclasses import dataclass

import numpy as np
import skfem
from skfem.quadrature import get_quadrature

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.mesh.cells import LINE, PRISM, SQUARE, TETRA, TRIANGLE, CellKind, kind_of

_FOUND = 1e-14  # A smaller step, relative to a cell, ends the search for a point.
_SIMPLICES = {
    LINE: (skfem.refdom.RefLine, skfem.ElementLineP1(), skfem.ElementLineP2()),
    TRIANGLE: (skfem.refdom.RefTri, skfem.ElementTriP1(), skfem.ElementTriP2()),
    TETRA: (skfem.refdom.RefTet, skfem.ElementTetP1(), skfem.ElementTetP2()),
}
# Products: kinds of the factors, and which node of each every node of the cell stands on.
_PRODUCTS = {
    SQUARE: (LINE, LINE, ((0, 1, 1, 0, 2, 1, 2, 0, 2), (0, 0, 1, 1, 0, 2, 1, 2, 2))),
    PRISM: (
        *(TRIANGLE, LINE),
        (
            (0, 1, 2, 0, 1, 2, 3, 4, 5, 3, 4, 5, 0, 1, 2, 3, 4, 5),
            (0, 0, 0, 1, 1, 1, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2, 2, 2),
        ),
    ),
}


@dataclass(frozen=True)
class Tabulation:
    """Shape functions at reference points: value (n, q), gradient (n, d, q), weights (q,)."""

    value: Array
    gradient: Array
    weights: Array


def tabulate(
    kind: CellKind, points: Array, weights: Array | None = None, degree: int = 2
) -> Tabulation:
    """Shape functions (quadratic, or linear) of the reference cell at ``points`` (d, q)."""
    used = np.ones(points.shape[1]) if weights is None else weights
    if kind in _PRODUCTS:
        first, second, nodes = _PRODUCTS[kind]
        count = kind.nodes if degree == 2 else kind.corners
        low, high = (np.array(which[:count]) for which in nodes)
        one = tabulate(first, points[: first.dimension], degree=degree)
        two = tabulate(second, points[first.dimension :], degree=degree)
        a, b = one.value[low], two.value[high]
        slopes = [one.gradient[low] * b[:, None], a[:, None] * two.gradient[high]]
        return Tabulation(a * b, np.concatenate(slopes, axis=1), used)
    element = _SIMPLICES[kind][degree]
    count = len(element.doflocs)
    value, gradient = np.empty((count, *points.shape[1:])), np.empty((count, *points.shape))
    for i in range(count):
        value[i], gradient[i] = element.lbasis(points, i)
    return Tabulation(value, gradient, used)


def quadrature(kind: CellKind, order: int) -> tuple[Array, Array]:
    """Points (d, q) and weights (q,) exact to ``order`` (of products: in each factor)."""
    if kind in _PRODUCTS:
        (low, one), (high, two) = (quadrature(factor, order) for factor in _PRODUCTS[kind][:2])
        places = [np.repeat(low, len(two), axis=1), np.tile(high, (1, len(one)))]
        return np.concatenate(places), np.outer(one, two).ravel()
    points, weights = get_quadrature(_SIMPLICES[kind][0], order)
    return np.asarray(points), np.asarray(weights)


def strain_order(kind: CellKind) -> int:
    """The order at which products of two shape gradients are exact on straight cells."""
    return 4 if kind in _PRODUCTS else 2


def margin(kind: CellKind, reference: Array) -> Array:
    """Least barycentric coordinate (...) of places (d, ...) in a cell; < 0 outside."""
    if kind in _PRODUCTS:
        first, second, _ = _PRODUCTS[kind]
        parts = reference[: first.dimension], reference[first.dimension :]
        return np.minimum(margin(first, parts[0]), margin(second, parts[1]))
    return np.asarray(np.minimum(reference.min(axis=0), 1.0 - reference.sum(axis=0)))


def centre(kind: CellKind) -> Array:
    """Reference coordinates (d,) of a cell's centre."""
    if kind in _PRODUCTS:
        return np.concatenate([centre(factor) for factor in _PRODUCTS[kind][:2]])
    return np.full(kind.dimension, 1.0 / kind.corners)


def jacobians(nodes: Array, gradient: Array) -> Array:
    """Jacobians (c, q, d, d), J[a, b] = d x_a / d X_b, of cells with nodes (c, n, d)."""
    return np.asarray(np.einsum("cna,nbq->cqab", nodes, gradient, optimize=True))


def inverse_jacobians(points: Array, cells: IntArray, straight: BoolArray) -> tuple[Array, Array]:
    """d X_a / d x_k (c, d, d) mm^-1 and det (c,) mm^d of cells, from their first d + 1 corners.

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
    kind = kind_of(cells)
    rule = quadrature(kind, order)
    jacobian = jacobians(points[cells], tabulate(kind, *rule).gradient)
    table = tabulate(kind, *rule, degree)
    determinant = np.linalg.det(jacobian)
    _refuse_inverted(determinant)
    inverse = np.linalg.inv(jacobian)
    gradients = np.einsum("nbq,cqba->cqna", table.gradient, inverse, optimize=True)
    return gradients, determinant * table.weights


def inverse_map(kind: CellKind, nodes: Array, places: Array) -> Array:
    """Reference coordinates (d, k) of ``places`` (k, d) in cells with nodes (k, n, d): Newton's."""
    dimension = kind.dimension
    reference = np.repeat(centre(kind)[:, None], len(nodes), axis=1)
    for _ in range(8):
        table = tabulate(kind, reference)
        miss = places - np.einsum("kna,nk->ka", nodes, table.value)
        jacobian = np.einsum("kna,nbk->kab", nodes, table.gradient)
        size = np.abs(jacobian).max(axis=(1, 2)) ** dimension
        steep = np.abs(np.linalg.det(jacobian)) < 1e-12 * size
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
