"""A deformed finger faces a rigid object: the contact problem about their present places.

With rel = u - U the motion of a point of the finger relative to the object (U the object's own),
the object stays where it was, and the finger's points are at X + rel:

    gap = mean of distance(X + rel) + n . (change of rel),      slip = t . (rel - rel of last row)

n is the object's normal where the finger is now. For a plane this is exact at once; for a cylinder
or a sphere it becomes exact as the iteration ends.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.finite.body import FiniteBody, Linearised
from fingerdesign.fem.trace import TRACE_ORDER
from fingerdesign.mesh.cells import facet_kind
from fingerdesign.shapes.objects import Indenter


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
        trace, away = self.body.at_rest.trace, self.rigid.distance(self._points(values, motion))
        return trace.surface.mean(away, len(trace.nodes))

    def problem(
        self,
        tangent: Linearised,
        values: Array,
        motion: Motion,
        offset: Array,
        like: ContactProblem | None = None,
    ) -> ContactProblem:
        """The contact problem about ``values`` and the object at ``motion``; offset (m, dim) mm:
        contact displacements that the tangent gives at no force; like: the last one on it."""
        model = tangent.model(offset)
        relative = self.relative(values, motion)
        surface = replace(model.surface, points=self._points(values, motion))
        there = replace(model, points=model.points + relative, surface=surface)
        problem = contact_problem(there, self.rigid, self.friction_coefficient, like=like)
        gap0 = problem.gap0 - np.sum(problem.frames[:, 0] * relative, axis=1)
        return replace(problem, model=model, gap0=gap0)

    def _points(self, values: Array, motion: Motion) -> Array:
        points = self.body.at_rest.trace.surface.points
        size = self.body.system.body.mesh.points.size
        moved = np.asarray(self.rows @ values[:size]).reshape(points.shape)
        return np.asarray(points + moved - _shift(motion, points.shape[1]))


def facing(body: FiniteBody, rigid: Indenter, friction_coefficient: float) -> Facing:
    """The finger facing ``rigid``, which is placed at its first contact with the finger at rest."""
    mesh, facets = body.system.body.mesh, body.system.body.contact
    dim = mesh.dimension
    kind = facet_kind(facets)
    table = tabulate(kind, quadrature(kind, TRACE_ORDER)[0])
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
