"""A deformed finger faces a rigid object: the contact problem about where both are now.

With rel = u - U the motion of a point of the finger relative to the object (U the object's own),
the object is left where it stood, and the finger's points are at X + rel:

    gap = mean of distance(X + rel) + n . (change of rel),      slip = t . (rel - rel of last row)

n the object's normal where the finger is now. For a plane this is exact at once; about a cylinder
or a sphere it becomes so as the iteration ends (``gap_error``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array
from fingerdesign.contact.increment import ContactState
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.finite_body import FiniteBody, Linearised
from fingerdesign.fem.trace import TRACE_ORDER

if TYPE_CHECKING:
    from fingerdesign.contact.objects import Indenter


@dataclass(frozen=True)
class Facing:
    """A finger and the object it faces; rows (q dim, n dim): displacements at the points on the
    exact surface where gaps are measured."""

    body: FiniteBody
    rigid: Indenter
    friction_coefficient: float
    rows: sp.csr_matrix

    def relative(self, values: Array, motion: Motion) -> Array:
        """rel (m, dim) mm of the contact nodes; zero where they have no motion of their own."""
        moved = self.body.contact_displacement(values)
        moved -= _shift(motion, moved.shape[1])
        body = self.body.system.body
        moved[body.fixed.reshape(body.mesh.points.shape)[self.body.at_rest.trace.nodes]] = 0.0
        return moved

    def gap(self, values: Array, motion: Motion) -> Array:
        """Gaps (m,) mm, true to the object's shape."""
        trace = self.body.at_rest.trace
        return trace.surface.mean(
            self.rigid.distance(self._points(values, motion)), len(trace.nodes)
        )

    def problem(
        self, tangent: Linearised, values: Array, motion: Motion, offset: Array
    ) -> ContactProblem:
        """The contact problem about ``values`` and the object at ``motion``; offset (m, dim) mm:
        contact displacements that the tangent gives at no force."""
        model = tangent.model(offset)
        relative = self.relative(values, motion)
        surface = replace(model.surface, points=self._points(values, motion))
        there = replace(model, points=model.points + relative, surface=surface)
        problem = contact_problem(there, self.rigid, self.friction_coefficient)
        gap0 = problem.gap0 - np.sum(problem.frames[:, 0] * relative, axis=1)
        return replace(problem, model=model, gap0=gap0)

    def _points(self, values: Array, motion: Motion) -> Array:
        points = self.body.at_rest.trace.surface.points
        size = self.body.system.body.mesh.points.size
        moved = np.asarray(self.rows @ values[:size]).reshape(points.shape)
        return np.asarray(points + moved - _shift(motion, points.shape[1]))


@dataclass(frozen=True)
class Past:
    """What the last row left: values (count,), contact forces (m, dim) N in x, y(, z), rel (m, dim)
    mm, the object's motion, and per node the way slid and the last slip (ContactState)."""

    values: Array
    force: Array
    relative: Array
    motion: Motion
    travelled: Array
    sliding: Array

    def state(self, problem: ContactProblem, guess: Array) -> ContactState:
        """This past in a problem's own components, with forces (m, dim) N to start from."""
        slip = np.einsum("mab,mb->ma", problem.frames[:, 1:], self.relative)
        multiplier = np.einsum("mab,mb->ma", problem.frames, guess)
        motion = replace(self.motion, load=1.0)
        return ContactState(slip, multiplier, motion, self.travelled, self.sliding)


def untouched(facing: Facing) -> Past:
    """Before the first row."""
    m, dim = len(facing.body.at_rest.trace.nodes), facing.body.system.body.mesh.dimension
    values = facing.body.system.at_rest
    none = np.zeros((m, dim))
    return Past(values, none, none, Motion(0.0, 0.0), np.zeros(m), np.zeros(m))


def facing(body: FiniteBody, rigid: Indenter, friction_coefficient: float) -> Facing:
    """The finger facing ``rigid``, which stands where it first touches the finger at rest."""
    mesh, facets = body.system.body.mesh, body.system.body.contact
    dim = mesh.dimension
    table = tabulate(dim - 1, quadrature(dim - 1, TRACE_ORDER)[0])
    count = table.value.shape[1]
    row = np.arange(len(facets) * count).reshape(len(facets), count)
    value = np.broadcast_to(table.value, (len(facets), *table.value.shape))
    rows = np.broadcast_to(row[:, None, :], value.shape)
    columns = np.broadcast_to(facets[:, :, None], value.shape)
    entries = (value.ravel(), (rows.ravel(), columns.ravel()))
    scalar = sp.csr_matrix(entries, shape=(row.size, len(mesh.points)))
    return Facing(body, rigid, friction_coefficient, sp.kron(scalar, sp.identity(dim), "csr"))


def _shift(motion: Motion, dim: int) -> Array:
    """The object's own displacement U (dim,), mm."""
    return np.array([motion.shear, -motion.approach, motion.shear_z])[:dim]
