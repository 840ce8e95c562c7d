"""The inverse of the compliance on the nodes in contact, updated as nodes come and go (numpy only).

Newton's matrix differs from the compliance of the closed nodes only in the rows of sliding nodes:

    G = C_AA^-1,      f_A = G (v_A - w_A),     v_A zero but for the slips d of sliding nodes.

So an iteration solves for d alone. G changes by a few rows when a few nodes open or close
(bordering and its reverse), which costs a fraction of a new factorisation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dsyrk

from fingerdesign.arrays import Array, BoolArray, IntArray

_SMALL = 100  # Blocks of fewer dofs are inverted at once.
_TILE = 64  # Rows mirrored at a time, so that they stay in the processor's cache.
_ABOVE = np.triu(np.ones((_TILE, _TILE), dtype=bool), 1)
_RENEW = 0.3  # If more than this part of the nodes changes, a new inverse is cheaper.


Scratch = Callable[..., Array]  # shape (and dtype) -> unwritten memory, as from numpy.empty


class ScratchBuffers:
    """Memory for arrays of up to ``most``^2 entries that are computed again and again.

    Buffers are lent in turn: an array is valid until ``count`` calls after its own. Freed memory
    would come back from the system page by page, which takes as long as filling it.
    """

    def __init__(self, most: int, count: int) -> None:
        self._next, self._buffers = 0, [np.empty(most * most) for _ in range(count)]

    def __call__(self, shape: tuple[int, int], dtype: type[np.floating] = np.float64) -> Array:
        self._next = (self._next + 1) % len(self._buffers)
        here = self._buffers[self._next].view(dtype)
        return here[: shape[0] * shape[1]].reshape(shape)


@dataclass(frozen=True)
class ActiveInverse:
    """``inverse`` (k dim, k dim) of the compliance on ``nodes`` (k,), in their order."""

    nodes: IntArray
    inverse: Array

    @staticmethod
    def of(compliance: Array, nodes: IntArray, dim: int) -> ActiveInverse:
        """Invert the block of ``nodes``. Raises numpy.linalg.LinAlgError where it is singular."""
        dofs = dofs_of(nodes, dim)
        return ActiveInverse(nodes, inverse_of(block(compliance, dofs, dofs)))

    def moved_to(
        self, compliance: Array, nodes: IntArray, dim: int, scratch: Scratch = np.empty
    ) -> ActiveInverse:
        """Move the inverse to other ``nodes``: update it, or invert again where that is cheaper."""
        joining = np.zeros(len(compliance) // dim, dtype=bool)
        joining[nodes] = True
        stays = joining[self.nodes]
        joining[self.nodes] = False
        joins = np.flatnonzero(joining)
        changed = len(self.nodes) - int(np.count_nonzero(stays)) + len(joins)
        if changed == 0:
            return self
        if changed > _RENEW * len(nodes):
            return ActiveInverse.of(compliance, nodes, dim)
        if not len(joins):
            return self.restricted(stays, dim, scratch)
        return self.restricted(stays, dim)._with(compliance, joins, dim, scratch)

    def restricted(self, stays: BoolArray, dim: int, scratch: Scratch = np.empty) -> ActiveInverse:
        """On those of its nodes that stay (by position)."""
        if stays.all():
            return self
        keep = dofs_of(np.flatnonzero(stays), dim)
        drop = dofs_of(np.flatnonzero(~stays), dim)
        rows = self.inverse[drop]
        side = _root_of_inverse(rows[:, drop]) @ rows[:, keep]
        whole = scratch((len(keep), len(keep)))
        whole[:] = block(self.inverse, keep, keep)
        return ActiveInverse(self.nodes[stays], _corrected(whole, side, -1.0))

    def _with(
        self, compliance: Array, joins: IntArray, dim: int, scratch: Scratch
    ) -> ActiveInverse:
        """Bordered, in a form that keeps it symmetric to the last digit. Where it is not, each
        bordering multiplies its error by ten."""
        old, new = dofs_of(self.nodes, dim), dofs_of(joins, dim)
        new_rows = compliance[new]
        rows = new_rows[:, old]
        cross = rows @ self.inverse
        root = _root_of_inverse(new_rows[:, new] - cross @ rows.T)
        side = np.concatenate([root @ cross, -root], axis=1)
        k = len(old)
        whole = scratch((k + len(new), k + len(new)))
        whole[:k, :k], whole[k:] = self.inverse, 0.0
        nodes = np.concatenate([self.nodes, joins])
        return ActiveInverse(nodes, _corrected(whole, side, 1.0))

    def renamed(self, numbers: IntArray) -> ActiveInverse:
        """The same with node i called ``numbers[i]``; nodes with a negative number must be gone."""
        return ActiveInverse(numbers[self.nodes], self.inverse)


def _root_of_inverse(matrix: Array) -> Array:
    """R with R^T R the inverse of a symmetric positive definite matrix."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(0.5 * (matrix + matrix.T))))


def _corrected(matrix: Array, side: Array, sign: float) -> Array:
    """matrix (n, n) + sign side^T side of side (r, n), in place: its lower half, then mirrored."""
    if not len(matrix):  # no node is left, which BLAS refuses
        return matrix
    dsyrk(sign, side.T, beta=1.0, c=matrix.T, overwrite_c=1)
    for low in range(0, len(matrix), _TILE):
        high = low + _TILE
        matrix[low:high, high:] = matrix[high:, low:high].T
        corner = matrix[low:high, low:high]
        np.copyto(corner, corner.T.copy(), where=_ABOVE[: len(corner), : len(corner)])
    return matrix


def block(matrix: Array, rows: IntArray, columns: IntArray) -> Array:
    """The rows and columns given, (r, c); four times as fast as np.ix_ where there are hundreds."""
    return matrix[rows][:, columns]


def inverse_of(matrix: Array) -> Array:
    """Inverse (n, n) of a symmetric positive definite matrix, by halves.

    Two thirds of the operations of a general inverse, and nearly all in products of matrices.
    Raises numpy.linalg.LinAlgError where a block is singular.
    """
    n = len(matrix)
    if n <= _SMALL:
        inverse = np.linalg.inv(matrix)
        return np.asarray(0.5 * (inverse + inverse.T))
    half = n // 2
    first = inverse_of(matrix[:half, :half])
    cross = first @ matrix[:half, half:]
    second = inverse_of(matrix[half:, half:] - matrix[half:, :half] @ cross)
    side = -cross @ second
    whole = np.empty((n, n))
    whole[:half, :half] = first - side @ cross.T
    whole[:half, half:] = side
    whole[half:, :half] = side.T
    whole[half:, half:] = second
    return whole


def dofs_of(nodes: IntArray, dim: int) -> IntArray:
    """Dof numbers (k dim,) of nodes (k,)."""
    return np.asarray((nodes[:, None] * dim + np.arange(dim)).reshape(-1))
