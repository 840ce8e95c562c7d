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

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.fem.body import CondensedBody
from fingerdesign.fem.system import Body
from fingerdesign.sensitivity.change import Change
from fingerdesign.sensitivity.forms import Fields, energies, products

_BLOCK = 64  # Right-hand sides that are solved for, or pairs of fields, at a time.


@dataclass(frozen=True)
class ResponseFields:
    """Fields s of unit loads on r rows Q: contact dofs of ``nodes``, then the gages of a body.

    rows (r,): their numbers among all rows of the model; values (r, r) Y; own (s,): the places of
    the rows that have a field, rising.
    """

    body: Body
    nodes: IntArray
    rows: IntArray
    own: IntArray
    fields: Fields
    values: Array

    @property
    def contact(self) -> int:
        """Number of rows that are contact displacements."""
        return len(self.nodes) * self.body.mesh.dimension

    @property
    def _facing(self) -> IntArray:
        """Those of ``own`` that are contact displacements."""
        return self.own[self.own < self.contact]

    def change_of(self, changes: Sequence[Change], loads: Array) -> Array:
        """d(Y f) (changes, r, k) of ``loads`` f (contact, k), per unit of each parameter; loads
        without a field count as 0, and so do the answers."""
        facing = self._facing
        right = self.fields.times(loads[facing])
        found = np.zeros((len(changes), len(self.rows), loads.shape[1]))
        every = -products(self.body, self.fields, right, changes)
        flat = self.fields.moved.reshape(-1, len(self.own))
        moved = right.moved.reshape(len(flat), -1)
        for whole, rate, change in zip(found, every, changes, strict=True):
            if (trace := self._trace_of(change)) is not None:
                rate[: len(facing)] += trace[facing] @ moved
                rate += (trace @ flat).T @ loads
            if change.gages is not None:
                rate[len(facing) :] += change.gages @ moved
            if change.attached is not None:
                rate -= flat.T @ (change.attached @ moved)
            if change.thickness:
                rate -= change.thickness * (self.values[self.own, : self.contact] @ loads)
            whole[self.own] = rate
        return found

    def between(self, changes: Sequence[Change], left: Array, right: Array) -> Array:
        """d(g^T Y f) (changes, k) of pairs of loads g and f (contact, k)."""
        found = np.empty((len(changes), right.shape[1]))
        for start in range(0, right.shape[1], _BLOCK):
            some = slice(start, start + _BLOCK)
            first, second = left[:, some], right[:, some]
            two = self.fields.times(second[self._facing])
            alike = np.array_equal(first, second)
            one = two if alike else self.fields.times(first[self._facing])
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


def response_fields(
    condensed: CondensedBody, nodes: IntArray, needed: BoolArray | None = None
) -> ResponseFields:
    """Solve for the fields of contact ``nodes`` and of the gages, a body's first readout.

    needed (n, dim): those of the nodes' dofs that have a field; None: all.
    """
    dim, contact = condensed.body.mesh.dimension, len(condensed.compliance)
    gages = len(condensed.readouts[0]) if condensed.readouts else 0
    dofs = (nodes[:, None] * dim + np.arange(dim)).ravel()
    rows = np.concatenate([dofs, contact + np.arange(gages)])
    chosen = np.ones(len(dofs), dtype=bool) if needed is None else needed.ravel()
    own = np.flatnonzero(np.append(chosen, np.ones(gages, dtype=bool)))
    system, factors = condensed.factors()
    lift = system.pressure_lift
    moved = np.empty((system.lift.shape[0], len(own)))
    pressure = np.empty((0 if lift is None else lift.shape[0], len(own)))
    for start in range(0, len(own), _BLOCK):
        some = slice(start, start + _BLOCK)
        forces = np.zeros((len(factors.matrix), len(own[some])))
        forces[rows[own[some]], np.arange(forces.shape[1])] = 1.0
        free = factors.fields(forces)
        moved[:, some] = system.lift @ free
        if lift is not None:
            pressure[:, some] = lift @ free
    fields = Fields(moved.reshape(-1, dim, len(own)), pressure)
    values = np.asarray(factors.matrix[np.ix_(rows, rows)])
    return ResponseFields(condensed.body, nodes, rows, own, fields, values)
