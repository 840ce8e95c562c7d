"""Derivative of the condensed model: of contact displacements and readings under given forces.

    Y f = Q K^-1 Q^T f,      Q: contact trace of some nodes, then the gage rows
    d(Y f) = dQ u + s dQ^T f - s^T dK u,      u = K^-1 Q^T f,  s = K^-1 Q^T

The fields s are solved for once, whatever the number of parameters. The rows Q border the factors,
so that a field is half of a solve (fem/factor.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.fem.body import CondensedBody
from fingerdesign.fem.system import Body
from fingerdesign.sensitivity.change import Change
from fingerdesign.sensitivity.forms import Fields, energies, products

_BLOCK = 64  # Right-hand sides that are solved for, or pairs of fields, at a time.


@dataclass(frozen=True)
class ResponseFields:
    """Fields s of unit loads on r rows Q: contact dofs of ``nodes``, then the gages of a body.

    rows (r,): their numbers among all rows of the model; values (r, r) Y.
    """

    body: Body
    nodes: IntArray
    rows: IntArray
    fields: Fields
    values: Array

    @property
    def contact(self) -> int:
        """Number of rows that are contact displacements."""
        return len(self.nodes) * self.body.mesh.dimension

    def change_of(self, changes: Sequence[Change], loads: Array) -> Array:
        """d(Y f) (changes, r, k) of ``loads`` f (contact, k), per unit of each parameter."""
        right = self.fields.times(loads)
        found = -products(self.body, self.fields, right, changes)
        flat = self.fields.moved.reshape(-1, len(self.values))
        moved = right.moved.reshape(len(flat), -1)
        for rate, change in zip(found, changes, strict=True):
            if (trace := self._trace_of(change)) is not None:
                rate[: self.contact] += trace @ moved
                rate += (trace @ flat).T @ loads
            if change.gages is not None:
                rate[self.contact :] += change.gages @ moved
            if change.attached is not None:
                rate -= flat.T @ (change.attached @ moved)
            if change.thickness:
                rate -= change.thickness * (self.values[:, : self.contact] @ loads)
        return found

    def between(self, changes: Sequence[Change], left: Array, right: Array) -> Array:
        """d(g^T Y f) (changes, k) of pairs of loads g and f (contact, k)."""
        found = np.empty((len(changes), right.shape[1]))
        for start in range(0, right.shape[1], _BLOCK):
            some = slice(start, start + _BLOCK)
            first, second = left[:, some], right[:, some]
            two = self.fields.times(second)
            one = two if np.array_equal(first, second) else self.fields.times(first)
            found[:, some] = -energies(self.body, one, two, changes)
            for rate, change in zip(found[:, some], changes, strict=True):
                rate += self._beside(change, first, second, one, two)
        return found

    def _beside(
        self, change: Change, first: Array, second: Array, one: Fields, two: Fields
    ) -> Array | float:
        """What a parameter changes of g^T Y f besides the stiffness of cells."""
        found: Array | float = 0.0
        there, here = (each.moved.reshape(-1, first.shape[1]) for each in (one, two))
        if (trace := self._trace_of(change)) is not None:
            found += (first * (trace @ here)).sum(axis=0) + (second * (trace @ there)).sum(axis=0)
        if change.attached is not None:
            found -= (there * (change.attached @ here)).sum(axis=0)
        if change.thickness:
            own = self.values[: self.contact, : self.contact]
            found -= change.thickness * (first * (own @ second)).sum(axis=0)
        return found

    def _trace_of(self, change: Change) -> sp.csr_matrix | None:
        """The contact rows of dQ of one parameter."""
        if change.facing is None or change.facing.trace is None:
            return None
        return sp.csr_matrix(change.facing.trace[self.rows[: self.contact]])


def response_fields(condensed: CondensedBody, nodes: IntArray) -> ResponseFields:
    """Solve for the fields of contact ``nodes`` and of the gages, a body's first readout."""
    dim, contact = condensed.body.mesh.dimension, len(condensed.compliance)
    gages = len(condensed.readouts[0]) if condensed.readouts else 0
    dofs = (nodes[:, None] * dim + np.arange(dim)).ravel()
    rows = np.concatenate([dofs, contact + np.arange(gages)])
    system, factors = condensed.factors()
    own = system.pressure_lift
    moved = np.zeros((system.lift.shape[0], len(rows)))
    pressure = np.empty((0 if own is None else own.shape[0], len(rows)))
    for start in range(0, len(rows), _BLOCK):
        some = slice(start, start + _BLOCK)
        forces = np.zeros((len(factors.matrix), len(rows[some])))
        forces[rows[some], np.arange(forces.shape[1])] = 1.0
        free = factors.fields(forces)
        moved[:, some] = system.lift @ free
        if own is not None:
            pressure[:, some] = own @ free
    fields = Fields(moved.reshape(-1, dim, len(rows)), pressure)
    return ResponseFields(
        condensed.body, nodes, rows, fields, np.asarray(factors.matrix[np.ix_(rows, rows)])
    )
