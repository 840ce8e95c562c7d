"""Stiffness of linear isotropic elasticity on quadratic cells, in a few large products.

    K[(i,k),(j,l)] = lame T_ij[k,l] + mu T_ij[l,k] + mu delta_kl sum_m T_ij[m,m],
    T_ij[k,l] = integral of dN_i/dx_k dN_j/dx_l

On a straight cell the shape gradients are those of the reference cell times a constant matrix, so
one product with a constant table gives the blocks of all cells; curved cells are integrated point
by point. The result equals scikit-fem's own elasticity form with the same quadrature to 1e-12
(tested), and is many times faster. Only node pairs i <= j are formed: the factorisation needs the
upper triangle alone.
"""

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.fem.elements import (
    inverse_jacobians,
    physical_gradients,
    quadrature,
    strain_order,
    tabulate,
)
from fingerdesign.mesh.cells import kind_of
from fingerdesign.mesh.measures import curved_cells

_CHUNK = 8192  # Curved cells integrated at a time: 60 MB of temporaries in 3-D.
# A mid-node this close to the middle, relative to the edge, leaves the mapping affine.
STRAIGHT = 1e-13


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
    kind = kind_of(cells)
    order = strain_order(kind)
    table = tabulate(kind, *quadrature(kind, order), degree)
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
        gradients, weights = physical_gradients(points, cells[part], order, degree)
        flat = gradients.reshape(*gradients.shape[:2], -1)
        product = np.matmul((flat * weights[:, :, None]).transpose(0, 2, 1), flat)
        size = len(table.value)
        product = product.reshape(len(part), size, dimension, size, dimension)
        pairs = isotropic(product[:, rows, :, columns, :], first[part], shear[part])
        blocks[:, part] = pairs.reshape(len(rows), len(part), -1)
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
    """Sum blocks (pairs, c, d d) at node pairs (pairs, c) into an upper-triangular CSR matrix. Each
    pair of nodes occurs once, in either order; ``blocks`` is overwritten."""
    width = blocks.shape[-1]
    dimension = round(width**0.5)
    swapped = rows > columns
    turned = np.arange(width).reshape(dimension, dimension).T.ravel()
    blocks[swapped] = blocks[swapped][:, turned]
    key = (np.minimum(rows, columns) * nodes + np.maximum(rows, columns)).ravel()
    position = np.argsort(key)
    ordered = key[position]
    start = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    ends, shape = np.append(start, len(key)), (len(start), len(key))
    add = sp.csr_matrix((np.ones(len(key)), position, ends), shape=shape)
    summed = add @ blocks.reshape(-1, width)
    row, column = np.divmod(ordered[start], nodes)
    pointer = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=nodes))])
    entries = summed.reshape(-1, dimension, dimension), column, pointer
    matrix = sp.bsr_matrix(entries, shape=(nodes * dimension, nodes * dimension)).tocsr()
    # A node's own block comes first in its rows: what of it lies below the diagonal goes.
    above = np.tile(np.arange(dimension), nodes) * (np.diff(matrix.indptr) > 0)
    upper = np.ones(matrix.nnz, dtype=bool)
    for below in range(1, dimension):
        upper[matrix.indptr[:-1][above == below][:, None] + np.arange(below)] = False
    pointer = matrix.indptr - np.append(0, np.cumsum(above))
    return sp.csr_matrix((matrix.data[upper], matrix.indices[upper], pointer), shape=matrix.shape)
