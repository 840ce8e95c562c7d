"""Derivative of the condensed model: of contact displacements and readings under given forces.

    Y f = Q K^-1 Q^T f,      Q: contact trace of some nodes, then the gage rows
    d(Y f) = dQ u + s dQ^T f - s^T dK u,      u = K^-1 Q^T f,  s = K^-1 Q^T

The fields s are solved for once, whatever the number of parameters. The rows Q border the factors,
so that a field is half of a solve (fem/factor.py).
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.fem.body import CondensedBody
from fingerdesign.sensitivity.change import Change
from fingerdesign.sensitivity.forms import products


class ResponseFields:
    """Fields s of unit loads on r rows Q: contact dofs of ``nodes``, then a body's first readout.

    rows (r,): their numbers among all rows of the model, of which ``contact`` are displacements;
    values (r, r) Y; own (s,): the places of the rows that have a field, rising; fields (d + 1, s):
    the system's unknowns, then zeros.
    """

    def __init__(
        self, condensed: CondensedBody, nodes: IntArray, needed: BoolArray | None = None
    ) -> None:
        """Solve for the fields. needed (n, dim): the nodes' dofs that have one; None: all."""
        self.body, self.nodes = condensed.body, nodes
        dim, first = self.body.mesh.dimension, len(condensed.compliance)
        gages = len(condensed.readouts[0]) if condensed.readouts else 0
        dofs = (nodes[:, None] * dim + np.arange(dim)).ravel()
        self.contact, self.rows = len(dofs), np.append(dofs, first + np.arange(gages))
        chosen = np.ones(len(dofs), dtype=bool) if needed is None else needed.ravel()
        self.own = np.flatnonzero(np.append(chosen, np.ones(gages, dtype=bool)))
        self.system, factors = condensed.factors()
        self.fields: Array = factors.fields(self.rows[self.own])
        self.values = np.asarray(factors.matrix[np.ix_(self.rows, self.rows)])

    def rates(
        self, changes: Sequence[Change], loads: Array, pairs: tuple[Array, Array]
    ) -> tuple[Array, Array]:
        """d(Y f) (changes, r, k) of ``loads`` f (contact, k), per unit of each parameter, and
        d(g^T Y f) (changes, j) of pairs of loads g and f (contact, j).

        Loads without a field count as 0, and so do the answers.
        """
        facing = self.own[self.own < self.contact]
        some, (here, there) = loads[facing], (side[facing] for side in pairs)
        found = np.zeros((len(changes), len(self.rows), loads.shape[1]))
        every, between = products(self.body, self.system, changes, self.fields, some, (here, there))
        first, own = len(facing), self.values[: self.contact, : self.contact]
        for whole, rate, pair, change in zip(found, every, between, changes, strict=True):
            rate *= -1.0
            pair *= -1.0
            if change.facing is not None and change.facing.trace is not None:
                read = self._read(change.facing.trace[self.rows[: self.contact]])
                rate[:first] += read[:first, facing].T @ some
                rate += read @ loads
                pair += (pairs[0] * (read[:first].T @ there)).sum(axis=0)
                pair += (pairs[1] * (read[:first].T @ here)).sum(axis=0)
            if change.gages is not None:
                rate[first:] += self._read(change.gages)[:first].T @ some
            if change.attached is not None:
                where = np.unique(change.attached.nonzero()[0])
                bars = change.attached[where][:, where]
                ends = self._read(sp.identity(change.attached.shape[0], format="csr")[where])
                rate -= ends @ (bars @ (ends[:first].T @ some))
                pair -= ((ends[:first].T @ here) * (bars @ (ends[:first].T @ there))).sum(axis=0)
            if change.stiffer:
                rate -= change.stiffer * (self.values[self.own, : self.contact] @ loads)
                pair -= change.stiffer * (pairs[0] * (own @ pairs[1])).sum(axis=0)
            whole[self.own] = rate
        return found, between

    def _read(self, rows: sp.csr_matrix) -> Array:
        """Values (s, a) of rows (a, n dim) of nodal displacements, in each field."""
        held = sp.csr_matrix(rows @ self.system.lift)
        used = np.unique(held.indices)
        return np.asarray((held[:, used] @ self.fields.take(used, axis=0, mode="clip")).T)
