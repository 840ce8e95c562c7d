"""Triangles and tetrahedra: scikit-fem's reference bases, mapped isoparametrically."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import skfem
from skfem.quadrature import get_quadrature

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.mesh.measures import curved_cells
from fingerdesign.mesh.types import TETRA_EDGES, TRIANGLE_EDGES

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


_FOUND = 1e-14  # of a cell: nothing moves any more


def _refuse_inverted(determinant: Array) -> None:
    inverted = ~(determinant > 0.0)
    if inverted.any():
        count = int(inverted.reshape(len(inverted), -1).any(axis=1).sum())
        raise ValueError(f"{count} inverted cells")


# Stiffness of linear isotropic elasticity on quadratic simplices, in a few large products.
#
#     K[(i,k),(j,l)] = lame T_ij[k,l] + mu T_ij[l,k] + mu delta_kl sum_m T_ij[m,m],
#     T_ij[k,l] = integral of dN_i/dx_k dN_j/dx_l
#
# On a straight cell the shape gradients are those of the reference cell times a constant matrix, so
# one product with a constant table gives the blocks of all cells; curved cells are integrated point
# by point. Equal to scikit-fem's own elasticity form with the same quadrature to 1e-12 (tested),
# and many times faster. Only node pairs i <= j are formed: the factorisation wants the upper
# triangle.

_CHUNK = 8192  # curved cells at a time: 60 MB of temporaries in 3-D
_ORDER = 2  # of the quadrature: strain times strain
STRAIGHT = 1e-13  # of the edge: a middle this close to its place leaves the mapping affine


def lame_parameters(youngs_modulus: Array, poissons_ratio: Array) -> tuple[Array, Array]:
    """Lame's first parameter and the shear modulus (MPa), also those of plane strain."""
    shear = youngs_modulus / (2.0 * (1.0 + poissons_ratio))
    first = youngs_modulus * poissons_ratio / ((1 + poissons_ratio) * (1 - 2 * poissons_ratio))
    return first, shear


def stiffness_blocks(
    points: Array, cells: IntArray, first: Array, shear: Array, degree: int = 2
) -> tuple[IntArray, IntArray, Array]:
    """Local node pairs i <= j and their blocks (pairs, c, d d), N/mm per mm of depth in 2-D.

    degree 1: linear shape functions on the corners (same geometry). Raises ValueError where a cell
    is inverted.
    """
    dimension = points.shape[1]
    table = tabulate(dimension, *quadrature(dimension, _ORDER), degree)
    rows, columns = np.triu_indices(len(table.value))
    products = np.einsum("iaq,jbq,q->ijab", table.gradient, table.gradient, table.weights)
    constant = products[rows, columns].reshape(len(rows), -1)
    straight = ~curved_cells(points, cells, STRAIGHT)
    inverse, determinant = inverse_jacobians(points, cells, straight)
    unit = np.einsum("c,cak,cbl->abckl", determinant, inverse, inverse, optimize=True)
    unit = isotropic(unit, first, shear).reshape(len(constant.T), -1)
    blocks = (constant @ unit).reshape(len(rows), len(cells), -1)
    curved = np.flatnonzero(~straight)
    for start in range(0, len(curved), _CHUNK):
        part = curved[start : start + _CHUNK]
        gradients, weights = physical_gradients(points, cells[part], _ORDER, degree)
        flat = gradients.reshape(*gradients.shape[:2], -1)
        product = np.matmul((flat * weights[:, :, None]).transpose(0, 2, 1), flat)
        size = len(table.value)
        product = product.reshape(len(part), size, dimension, size, dimension)
        pairs = product[:, rows, :, columns, :]  # (pairs, c, d, d)
        blocks[:, part] = isotropic(pairs, first[part], shear[part]).reshape(
            len(rows), len(part), -1
        )
    return rows, columns, blocks


def isotropic(product: Array, first: Array, shear: Array) -> Array:
    """lame T + mu T^T + mu tr T for products T (..., c, d, d)."""
    trace = np.einsum("...kk->...", product)
    result = first[:, None, None] * product
    result += shear[:, None, None] * np.swapaxes(product, -1, -2)
    for k in range(product.shape[-1]):
        result[..., k, k] += shear * trace
    return result


def sum_blocks(rows: IntArray, columns: IntArray, blocks: Array, nodes: int) -> sp.csr_matrix:
    """Sum blocks (pairs, c, d d) at node pairs (pairs, c) into an upper-triangular CSR matrix.

    Each pair of nodes stands once, whichever is first; ``blocks`` is overwritten.
    """
    width = blocks.shape[-1]
    dimension = round(width**0.5)
    swapped = rows > columns
    turned = np.arange(width).reshape(dimension, dimension).T.ravel()
    blocks[swapped] = blocks[swapped][:, turned]
    key = (np.minimum(rows, columns) * nodes + np.maximum(rows, columns)).ravel()
    position = np.argsort(key)
    ordered = key[position]
    start = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    add = sp.csr_matrix(
        (np.ones(len(key)), position, np.append(start, len(key))), shape=(len(start), len(key))
    )
    summed = add @ blocks.reshape(-1, width)
    row, column = np.divmod(ordered[start], nodes)
    pointer = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=nodes))])
    matrix = sp.bsr_matrix(
        (summed.reshape(-1, dimension, dimension), column, pointer),
        shape=(nodes * dimension, nodes * dimension),
    ).tocsr()
    row_of = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    return take(matrix, matrix.indices >= row_of, row_of)


def take(matrix: sp.csr_matrix, mask: BoolArray, row_of: IntArray) -> sp.csr_matrix:
    """The entries of a sorted CSR matrix that ``mask`` keeps; ``row_of``: their rows."""
    kept = matrix.indices[mask]
    pointer = np.concatenate([[0], np.cumsum(np.bincount(row_of[mask], minlength=matrix.shape[0]))])
    return sp.csr_matrix((matrix.data[mask], kept, pointer), shape=matrix.shape)
