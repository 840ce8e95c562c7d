"""The inverse of the compliance on the nodes in contact, carried along as nodes come and go.

Newton's matrix differs from the closed nodes' compliance only in the rows of sliding ones. With

    G = C_AA^-1,      f_A = G (v_A - w_A),     v_A zero but for the slips d of sliding nodes,

an iteration solves for d alone. G changes by a few rows when a few nodes open or close (bordering
and its reverse), which costs a fraction of a new factorisation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray

_SMALL = 100  # dofs: smaller blocks are inverted at once
_RENEW = 0.3  # part of the nodes changing from which a new inverse is cheaper


@dataclass(frozen=True)
class ActiveInverse:
    """``inverse`` (k dim, k dim) of the compliance on ``nodes`` (k,), in their order."""

    nodes: IntArray
    inverse: Array

    @staticmethod
    def of(compliance: Array, nodes: IntArray, dim: int) -> ActiveInverse:
        """Made anew. Raises numpy.linalg.LinAlgError where the block is singular."""
        dofs = dofs_of(nodes, dim)
        return ActiveInverse(nodes, inverse_of(block(compliance, dofs, dofs)))

    def moved_to(self, compliance: Array, nodes: IntArray, dim: int) -> ActiveInverse:
        """The inverse on other ``nodes``, by the cheaper of updating and making anew."""
        wanted = np.zeros(len(compliance) // dim, dtype=bool)
        wanted[nodes] = True
        stays = wanted[self.nodes]
        wanted[self.nodes] = False
        joins = np.flatnonzero(wanted)
        changed = len(self.nodes) - int(np.count_nonzero(stays)) + len(joins)
        if changed == 0:
            return self
        if changed > _RENEW * len(nodes):
            return ActiveInverse.of(compliance, nodes, dim)
        return self._without(~stays, dim)._with(compliance, joins, dim)

    def _without(self, leaves: NDArray[np.bool_], dim: int) -> ActiveInverse:
        if not leaves.any():
            return self
        keep = dofs_of(np.flatnonzero(~leaves), dim)
        drop = dofs_of(np.flatnonzero(leaves), dim)
        cross = block(self.inverse, keep, drop)
        corner = block(self.inverse, drop, drop)
        inverse = block(self.inverse, keep, keep) - cross @ np.linalg.solve(corner, cross.T)
        return ActiveInverse(self.nodes[~leaves], inverse)

    def _with(self, compliance: Array, joins: IntArray, dim: int) -> ActiveInverse:
        if not len(joins):
            return self
        old, new = dofs_of(self.nodes, dim), dofs_of(joins, dim)
        cross = self.inverse @ block(compliance, old, new)
        corner = np.linalg.inv(block(compliance, new, new) - block(compliance, new, old) @ cross)
        side = -cross @ corner
        inverse = np.block([[self.inverse - side @ cross.T, side], [side.T, corner]])
        return ActiveInverse(np.concatenate([self.nodes, joins]), inverse)

    def renamed(self, numbers: IntArray) -> ActiveInverse:
        """The same with node i called ``numbers[i]``; nodes with a negative number must be gone."""
        return ActiveInverse(numbers[self.nodes], self.inverse)

    def restricted(self, keep: NDArray[np.bool_], dim: int) -> ActiveInverse:
        """On those of its nodes for which ``keep`` (by position) holds."""
        return self._without(~keep, dim)


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
