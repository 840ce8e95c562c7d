"""Stiffness of linear isotropic elasticity on quadratic simplices, one batched product.

    K[(i,k),(j,l)] = lame T_ij[k,l] + mu T_ij[l,k] + mu delta_kl sum_m T_ij[m,m],
    T_ij[k,l] = integral of dN_i/dx_k dN_j/dx_l

Equal to scikit-fem's own elasticity form with the same quadrature to 1e-12 (tested), and several
times faster in 3-D. Only node pairs i <= j are formed: the factorisation wants the upper triangle.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.fem.elements import physical_gradients

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

_CHUNK = 8192  # cells at a time: 60 MB of temporaries in 3-D


def lame_parameters(youngs_modulus: Array, poissons_ratio: Array) -> tuple[Array, Array]:
    """Lame's first parameter and the shear modulus (MPa), also those of plane strain."""
    shear = youngs_modulus / (2.0 * (1.0 + poissons_ratio))
    first = youngs_modulus * poissons_ratio / ((1 + poissons_ratio) * (1 - 2 * poissons_ratio))
    return first, shear


def element_blocks(
    points: Array, cells: IntArray, first: Array, shear: Array, order: int
) -> tuple[IntArray, IntArray, Array]:
    """Blocks (c, pairs, d, d) of the local node pairs i <= j, and those pairs."""
    dimension = points.shape[1]
    gradients, weights = physical_gradients(points, cells, order)
    count, quadrature_points, nodes, _ = gradients.shape
    flat = gradients.reshape(count, quadrature_points, nodes * dimension)
    product = np.matmul((flat * weights[:, :, None]).transpose(0, 2, 1), flat)
    product = product.reshape(count, nodes, dimension, nodes, dimension)
    rows, columns = np.triu_indices(nodes)
    blocks = product[:, rows, :, columns, :].transpose(1, 0, 2, 3)
    trace = np.einsum("cpmm->cp", blocks)
    result = first[:, None, None, None] * blocks
    result += shear[:, None, None, None] * blocks.transpose(0, 1, 3, 2)
    result += (shear[:, None] * trace)[:, :, None, None] * np.eye(dimension)
    return rows, columns, result


def assemble_stiffness(
    points: Array,
    cells: IntArray,
    youngs_modulus: Array,
    poissons_ratio: Array,
    thickness: float = 1.0,
    order: int = 2,
) -> sp.csr_matrix:
    """Upper triangle (n dim, n dim) in CSR, N/mm; dof of node i, component k is i dim + k.

    youngs_modulus, poissons_ratio: (c,) per cell, MPa and 1; in 2-D plane strain of the given
    ``thickness`` (mm), so that forces are those of the whole depth.
    """
    dimension, nodes = points.shape[1], len(points)
    first, shear = lame_parameters(youngs_modulus, poissons_ratio)
    all_low, all_high, all_blocks = [], [], []
    for start in range(0, len(cells), _CHUNK):
        part = slice(start, start + _CHUNK)
        rows, columns, blocks = element_blocks(points, cells[part], first[part], shear[part], order)
        low, high = cells[part][:, rows], cells[part][:, columns]
        swapped = low > high
        blocks[swapped] = blocks[swapped].transpose(0, 2, 1)
        all_low.append(np.minimum(low, high).ravel())
        all_high.append(np.maximum(low, high).ravel())
        all_blocks.append(blocks.reshape(-1, dimension, dimension))
    low, high = np.concatenate(all_low), np.concatenate(all_high)
    blocks = np.concatenate(all_blocks) * thickness
    return _sum_blocks(low, high, blocks, nodes)


def _sum_blocks(low: IntArray, high: IntArray, blocks: Array, nodes: int) -> sp.csr_matrix:
    """Sum blocks (e, d, d) at node pairs low <= high into an upper-triangular CSR matrix."""
    dimension = blocks.shape[1]
    key = low.astype(np.int64) * nodes + high
    position = np.argsort(key, kind="stable")
    sorted_key = key[position]
    first = np.flatnonzero(np.concatenate([[True], sorted_key[1:] != sorted_key[:-1]]))
    summed = np.add.reduceat(blocks.reshape(len(low), -1)[position], first, axis=0)
    unique = sorted_key[first]
    row, column = unique // nodes, unique % nodes
    pointer = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=nodes))])
    matrix = sp.bsr_matrix(
        (summed.reshape(-1, dimension, dimension), column, pointer),
        shape=(nodes * dimension, nodes * dimension),
    ).tocsr()
    upper = sp.triu(matrix, format="csr")
    upper.sort_indices()
    return upper
