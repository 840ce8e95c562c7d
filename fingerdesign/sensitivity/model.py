"""Derivative of the condensed model: of contact displacements and readings under given forces.

    Y f = Q K^-1 Q^T f,      Q: contact trace of some nodes, then the gage rows
    d(Y f) = dQ u + s dQ^T f - s^T dK u,      u = K^-1 Q^T f,  s = K^-1 Q^T

The fields s are solved for once, whatever the number of parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.fem.body import CondensedBody
from fingerdesign.fem.system import Body
from fingerdesign.sensitivity.change import Change
from fingerdesign.sensitivity.forms import Fields, products

_BLOCK = 64  # Right-hand sides that are solved for at a time.


@dataclass(frozen=True)
class ResponseFields:
    """Fields of unit loads: rows (r, n dim) Q, of which the first ``contact`` are dofs of contact
    nodes ``nodes``; fields s; values (r, r) Y."""

    body: Body
    nodes: IntArray
    rows: sp.csr_matrix
    fields: Fields
    values: Array

    @property
    def contact(self) -> int:
        """Number of rows that are contact displacements."""
        return len(self.nodes) * self.body.mesh.dimension

    def change_of(self, changes: Sequence[Change], loads: Array) -> Array:
        """d(Y f) (changes, r, k) of ``loads`` f (r, k), per unit of each parameter."""
        right = self.fields.times(loads)
        found = -products(self.body, self.fields, right, changes)
        flat = self.fields.moved.reshape(-1, len(self.values))
        moved = right.moved.reshape(len(flat), -1)
        for number, change in enumerate(changes):
            rows = self._rows_of(change)
            if rows is not None:
                found[number] += rows @ moved + (rows @ flat).T @ loads
            if change.attached is not None:
                found[number] -= flat.T @ (change.attached @ moved)
            if change.thickness:
                found[number] -= change.thickness * (self.values @ loads)
        return found

    def _rows_of(self, change: Change) -> sp.csr_matrix | None:
        """dQ of one parameter."""
        trace = None if change.facing is None else change.facing.trace
        if trace is None and change.gages is None:
            return None
        dim, width = self.body.mesh.dimension, self.rows.shape[1]
        dofs = (self.nodes[:, None] * dim + np.arange(dim)).ravel()
        top = sp.csr_matrix((self.contact, width)) if trace is None else trace[dofs]
        below = change.gages
        if below is None:
            below = sp.csr_matrix((self.rows.shape[0] - self.contact, width))
        return sp.csr_matrix(sp.vstack([top, below]))


def response_fields(
    condensed: CondensedBody, nodes: IntArray, gages: sp.csr_matrix
) -> ResponseFields:
    """Solve for the fields of unit forces at contact ``nodes`` and of the gage rows."""
    body = condensed.body
    dim = body.mesh.dimension
    dofs = (nodes[:, None] * dim + np.arange(dim)).ravel()
    rows = sp.csr_matrix(sp.vstack([condensed.trace.operator[dofs], gages]))
    system, condensation = condensed.factors()
    loads = (rows @ system.lift).T.toarray()
    solved = [
        condensation.solve(loads[:, start : start + _BLOCK])
        for start in range(0, loads.shape[1], _BLOCK)
    ]
    free = np.hstack(solved)
    moved = system.lift @ free
    own = system.pressure_lift
    pressure = np.empty((0, free.shape[1])) if own is None else own @ free
    fields = Fields(moved.reshape(-1, dim, free.shape[1]), pressure)
    return ResponseFields(body, nodes, rows, fields, np.asarray(rows @ moved))
