"""A body at finite strain as contact sees it: linear about where it is now.

    K du = R^T f - r(u)         r forces and K stiffness at the displacement u, f contact forces (N)
    R (u + du) = C f + d        C = R K^-1 R^T,  d = R u - R K^-1 r

so the contact solver of the small-strain model finds f, and du follows. R is the contact trace of
the body at rest: forces are those of the whole, tractions per area at rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array
from fingerdesign.fem.body import CondensedBody, condense_body
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.finite.system import FiniteSystem, finite_system
from fingerdesign.fem.reduction import reduced_model
from fingerdesign.fem.system import Body
from fingerdesign.reduced import ReducedModel


@dataclass(frozen=True)
class FiniteBody:
    """A body, its equations, and its small-strain model at rest (trace, supports, readouts).

    trace (m dim, d): contact displacements of the free unknowns; free_ends, depth: as in
    fem.reduction.reduced_model.
    """

    system: FiniteSystem
    at_rest: CondensedBody
    trace: sp.csr_matrix
    free_ends: tuple[float, float] | None
    depth: float | None

    def contact_displacement(self, values: Array) -> Array:
        """R u (m, dim), mm."""
        moved = self.at_rest.trace.operator @ values[: self.system.body.mesh.points.size]
        return np.asarray(moved).reshape(-1, self.system.body.mesh.dimension)

    def loads(self, force: Array) -> Array:
        """Contact forces (m, dim) N on the free unknowns, (d,)."""
        return np.asarray(self.trace.T @ force.ravel())

    def supports(self, values: Array) -> Array:
        """Sum of the supports' forces on the body (dim,), N, at equilibrium."""
        body = self.system.body
        forces = self.system.forces(values)[: body.mesh.points.size]
        return np.asarray(np.where(body.fixed, forces, 0.0).reshape(body.mesh.points.shape).sum(0))

    def linearised(
        self, values: Array, before: Array | None = None, spent: Linearised | None = None
    ) -> Linearised:
        """The tangent at ``values``, the end of a step from ``before`` (FiniteSystem.tangent).

        spent: a tangent of this body that is no longer needed; its order of elimination is used
        again. Raises SolverError where the tangent is not that of a stable body.
        """
        forces, stiffness = self.system.tangent(values, before)
        silent = np.diff(self.trace.indptr) == 0  # constrained motions
        if spent is None:
            rows = self.trace[~silent].tocsr()
            condensation = Condensation(stiffness, rows, self.system.pressures)
        else:
            condensation = spent.condensation
            condensation.renew(stiffness)
        compliance = np.zeros((len(silent), len(silent)))
        compliance[np.ix_(~silent, ~silent)] = condensation.matrix
        return Linearised(self, forces, condensation, compliance)


@dataclass(frozen=True)
class Linearised:
    """One tangent of a body: forces (count,) where it was taken, compliance (m dim, m dim)."""

    body: FiniteBody
    forces: Array
    condensation: Condensation
    compliance: Array

    def response(self, loads: Array) -> Array:
        """Change of the values (count,) by loads (d,) on the free unknowns."""
        change = np.zeros(self.body.system.count)
        change[self.body.system.free] = self.condensation.solve(loads[:, None])[:, 0]
        return change

    def model(self, offset: Array) -> ReducedModel:
        """The model that contact sees; ``offset`` (m, dim) mm: displacement without force."""
        body, moved = self.body, offset.ravel()
        condensed = replace(body.at_rest, compliance=self.compliance, load_displacement=moved)
        return reduced_model(condensed, free_ends=body.free_ends, depth=body.depth)


def finite_body(
    body: Body,
    free_ends: tuple[float, float] | None = None,
    depth: float | None = None,
    at_rest: CondensedBody | None = None,
) -> FiniteBody:
    """The body, ready to be followed; at_rest: its small-strain model, where there is one. Raises
    SolverError as condense_body and finite_system do."""
    system = finite_system(body)
    at_rest = condense_body(body) if at_rest is None else at_rest
    trace = (at_rest.trace.operator @ system.lift).tocsr()
    trace.eliminate_zeros()
    trace.sort_indices()
    return FiniteBody(system, at_rest, trace, free_ends, depth)
