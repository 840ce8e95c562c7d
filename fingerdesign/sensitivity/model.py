"""Derivative of the condensed model: of contact displacements and readings under given forces.

    Y f = Q K^-1 Q^T f,      Q: contact trace of some nodes, then the gage rows
    d(Y f) = dQ u + Q K^-1 (dQ^T f - dK u),      u = K^-1 Q^T f

The rows Q border the factors, so that Q K^-1 is half of a solve, and so is K^-1 Q^T (fem/factor).
Either the loads in brackets are solved for, of each parameter and f; or, where f are many, the
fields K^-1 Q^T once, which take more memory.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.fem.body import CondensedBody
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.system import Body, System
from fingerdesign.sensitivity.change import Change
from fingerdesign.sensitivity.forms import Fields, energies, reactions

_BLOCK = 64  # Right-hand sides that are solved for at a time.


@dataclass(frozen=True)
class Responses:
    """Responses Y (r, r) of a body: of contact dofs of ``nodes``, then of all gages.

    rows (r,): their numbers among the rows that border the factors; by_fields: see the module.
    """

    body: Body
    nodes: IntArray
    rows: IntArray
    system: System
    factors: Condensation
    by_fields: bool

    @property
    def contact(self) -> int:
        """Number of rows that are contact displacements."""
        return len(self.nodes) * self.body.mesh.dimension

    @cached_property
    def values(self) -> Array:
        """Y (r, r)."""
        return np.asarray(self.factors.matrix[np.ix_(self.rows, self.rows)])

    def change_of(self, changes: Sequence[Change], loads: Array) -> Array:
        """d(Y f) (changes, r, k) of ``loads`` f (contact, k), per unit of each parameter."""
        found = np.zeros((len(changes), len(self.rows), loads.shape[1]))
        if not loads.size:
            return found
        right = self._fields(loads)
        moved = right.moved.reshape(-1, loads.shape[1])
        size = max(1, _BLOCK // loads.shape[1])
        for start in range(0, len(changes), size):
            some = changes[start : start + size]
            force = reactions(self.body, right, some)
            blocks = np.split(force.moved.reshape(len(moved), -1), len(some), axis=1)
            for change, block in zip(some, blocks, strict=True):
                if change.attached is not None:
                    block += change.attached @ moved
                if (trace := self._trace_of(change)) is not None:
                    block -= trace.T @ loads
            flat = -self._responses(force).reshape(len(self.rows), len(some), -1)
            found[start : start + size] = flat.swapaxes(0, 1)
        for rate, change in zip(found, changes, strict=True):
            if (trace := self._trace_of(change)) is not None:
                rate[: self.contact] += trace @ moved
            if change.gages is not None:
                rate[self.contact :] += change.gages @ moved
            if change.thickness:
                rate -= change.thickness * (self.values[:, : self.contact] @ loads)
        return found

    def between(self, changes: Sequence[Change], left: Array, right: Array) -> Array:
        """d(g^T Y f) (changes, k) of pairs of loads g and f (contact, k)."""
        found = np.empty((len(changes), right.shape[1]))
        for some in _blocks(right.shape[1]):
            first, second = left[:, some], right[:, some]
            two = self._fields(second)
            one = two if np.array_equal(first, second) else self._fields(first)
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

    def _fields(self, loads: Array) -> Fields:
        """Fields of forces (contact, k) on the contact nodes."""
        forces = np.zeros((len(self.factors.matrix), loads.shape[1]))
        forces[self.rows[: self.contact]] = loads
        return self._whole(self.factors.fields(forces))

    def _whole(self, free: Array) -> Fields:
        """Fields of the system's unknowns (d, k)."""
        system = self.system
        moved = (system.lift @ free).reshape(-1, self.body.mesh.dimension, free.shape[1])
        own = system.pressure_lift
        return Fields(moved, np.empty((0, free.shape[1])) if own is None else own @ free)

    def _responses(self, force: Fields) -> Array:
        """Q K^-1 F (r, k) of nodal forces and pressures' flows F."""
        loads = self.system.lift.T @ force.moved.reshape(-1, force.moved.shape[2])
        if self.system.pressure_lift is not None:
            loads += self.system.pressure_lift.T @ force.pressure
        if self.by_fields:
            return np.asarray(self._all.T @ loads)
        return self.factors.responses(loads)[self.rows]

    @cached_property
    def _all(self) -> Array:
        """K^-1 Q^T (d, r)."""
        found = np.empty((self.system.dofs, len(self.rows)), order="F")
        for some in _blocks(len(self.rows)):
            forces = np.zeros((len(self.factors.matrix), len(self.rows[some])))
            forces[self.rows[some], np.arange(forces.shape[1])] = 1.0
            found[:, some] = self.factors.fields(forces)
        return found


def responses_of(condensed: CondensedBody, nodes: IntArray, by_fields: bool = False) -> Responses:
    """Responses of a body whose first readout are the gages, if it has any.

    by_fields: for more than some 5 loads of 50 parameters, one after the other.
    """
    dim, contact = condensed.body.mesh.dimension, len(condensed.compliance)
    gages = len(condensed.readouts[0]) if condensed.readouts else 0
    dofs = (nodes[:, None] * dim + np.arange(dim)).ravel()
    rows = np.concatenate([dofs, contact + np.arange(gages)])
    return Responses(condensed.body, nodes, rows, *condensed.factors(), by_fields)


def _blocks(count: int) -> Iterator[slice]:
    for start in range(0, count, _BLOCK):
        yield slice(start, start + _BLOCK)
