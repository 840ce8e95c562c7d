"""The rival of condensing: the whole stiffness, with the multipliers, factored at each iteration.

This is how general finite-element codes treat contact, here with the same contact laws and the
same traces, so that both ways have one answer and only the time differs:

    [ K        -R^T ] [u]   [ 0 ]       v = R u + w   gap and slip increment of the closed nodes
    [ V R       L   ] [f] = [ c ]       V v + L f = c   their laws, linearised (newton.py)

Open nodes have no force and drop out. With friction the matrix is not symmetric: MKL PARDISO's
general factorisation with scaling and matching, ordering anew as the contact changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.increment import Increment
from fingerdesign.contact.laws import OPEN, SLIP, certify, status_of
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.contact.solver.newton import classify, relative_residual
from fingerdesign.errors import SolverError
from fingerdesign.fem import factor

if TYPE_CHECKING:
    from fingerdesign.fem.body import CondensedBody


_FACTOR = 0.02  # of the augmentation, as in newton.py
_TOLERANCE = 1e-10  # of the residual, relative to the largest nodal force
_MOST_ITERATIONS = 40  # then the increment has failed


@dataclass(frozen=True)
class FullStep:
    """One increment: forces and motions of the contact nodes (m, dim), displacements (n dim,)."""

    motion: Motion
    multiplier: Array
    contact_motion: Array
    displacement: Array
    iterations: int


class FullSystem:
    """A body's whole equations beside the object that it faces.

    ``condensed`` gives the assembled stiffness and the traces, ``problem`` frames, gaps and
    friction; the condensed compliance is used by neither. ``modulus`` MPa scales the augmentation.
    """

    def __init__(self, condensed: CondensedBody, problem: ContactProblem, modulus: float) -> None:
        upper = condensed.factors()[0].stiffness
        self.problem = problem
        self.lift = condensed.factors()[0].lift
        self.stiffness = (upper + sp.triu(upper, k=1).T).tocsr()
        m, dim = problem.shape
        frames = sp.bsr_matrix(
            (problem.frames, np.arange(m), np.arange(m + 1)), shape=(m * dim, m * dim)
        )
        held = problem.model.locked.reshape(-1)  # these have no motion of their own
        operator = sp.diags_array((~held).astype(float)) @ condensed.trace.operator
        self.trace = sp.csr_matrix(frames @ operator @ self.lift)
        self.trace.eliminate_zeros()
        self.silent = np.diff(self.trace.indptr) == 0
        thickness = condensed.body.thickness
        areas = problem.model.areas
        lengths = np.full(m, thickness) if dim == 2 else np.sqrt(areas)
        # A node's own compliance is about 1 / (E length): no condensation tells it here.
        self.self_compliance = 1.0 / (modulus * lengths)

    @property
    def dofs(self) -> int:
        """Equations without the multipliers."""
        return int(self.stiffness.shape[0])

    def follow(self, path: Iterable[Motion]) -> Iterator[FullStep]:
        """One FullStep per row. Raises SolverError at the first that does not converge."""
        m, dim = self.problem.shape
        slip, multiplier = np.zeros((m, dim - 1)), np.zeros((m, dim))
        moved = np.zeros((m, dim))
        before = self.problem.offset(Motion(0.0, 0.0), slip)
        for motion in path:
            offset = self.problem.offset(motion, slip)
            step = self._increment(motion, offset, before, multiplier, moved)
            multiplier, moved = step.multiplier, step.contact_motion - offset
            slip = slip + step.contact_motion[:, 1:]
            before = self.problem.offset(motion, slip)
            yield step

    def _increment(
        self, motion: Motion, offset: Array, before: Array, multiplier: Array, moved: Array
    ) -> FullStep:
        """Newton from the last increment's forces and displacements ``moved`` = R u (m, dim)."""
        friction = self.problem.friction_coefficient
        rho = (_FACTOR / self.self_compliance)[:, None]
        local = moved + offset
        for iteration in range(1, _MOST_ITERATIONS + 1):
            seen = local
            if iteration == 1 and multiplier.any():  # what touched goes on touching (newton.py)
                seen = local.copy()
                seen[:, 0] += before[:, 0] - offset[:, 0]
            status, trial = classify(multiplier, seen, rho, friction)
            solution, multiplier = self._linear_step(status, trial, rho, multiplier, local, offset)
            local = (self.trace @ solution).reshape(offset.shape) + offset
            residual = relative_residual(multiplier, local, self.self_compliance, friction)
            if not np.isfinite(residual):
                break
            if residual <= _TOLERANCE:
                return FullStep(motion, multiplier, local, self.lift @ solution, iteration)
        raise SolverError(
            f"plain Newton did not converge in {iteration} iterations at {motion}: residual "
            f"{residual:.0e} of the largest force"
        )

    def _linear_step(
        self,
        status: IntArray,
        trial: Array,
        rho: Array,
        multiplier: Array,
        local: Array,
        offset: Array,
    ) -> tuple[Array, Array]:
        """Displacements q and forces (m, dim) of the laws linearised at the present point."""
        m, dim = offset.shape
        closed = np.flatnonzero(status != OPEN)
        forces = np.zeros((m, dim))
        if not len(closed):
            return np.zeros(self.dofs), forces
        friction = self.problem.friction_coefficient
        on_motion, on_force, right = _laws(
            friction, status[closed], trial[closed], rho[closed], multiplier[closed], local[closed]
        )
        right -= np.einsum("kab,kb->ka", on_motion, offset[closed])
        silent = self.silent.reshape(m, dim)[closed]
        on_motion[silent] = 0.0
        on_force[silent] = 0.0
        right[silent] = 0.0
        node, component = np.nonzero(silent)
        on_force[node, component, component] = 1.0
        rows = self.trace[(closed[:, None] * dim + np.arange(dim)).reshape(-1)]
        matrix = sp.bmat(
            [[self.stiffness, -rows.T], [_blocks(on_motion) @ rows, _blocks(on_force)]],
            format="csr",
        )
        matrix.sort_indices()
        loads = np.concatenate([np.zeros(self.dofs), right.reshape(-1)])
        found = _solve_general(matrix, loads)
        forces[closed] = found[self.dofs :].reshape(-1, dim)
        return found[: self.dofs], forces


def _laws(
    friction: float, status: IntArray, trial: Array, rho: Array, multiplier: Array, local: Array
) -> tuple[Array, Array, Array]:
    """V, L (k, dim, dim) and c (k, dim) of V v + L f = c: no gap, and no slip or the cone."""
    count, dim = local.shape
    on_motion = np.zeros((count, dim, dim))
    on_force = np.zeros((count, dim, dim))
    right = np.zeros((count, dim))
    on_motion[:] = np.eye(dim)
    sliding = status == SLIP
    if not sliding.any():
        return on_motion, on_force, right
    size = np.linalg.norm(trial[sliding, 1:], axis=1)
    direction = trial[sliding, 1:] / size[:, None]
    force = multiplier[sliding]
    bound = friction * np.maximum(force[:, 0], 0.0)
    ratio = np.minimum(bound / size, 1.0)[:, None, None]
    turn = ratio * (np.eye(dim - 1) - direction[:, :, None] * direction[:, None, :])
    keep = np.eye(dim - 1) - turn
    pull = friction * direction
    weight = rho[sliding][:, :, None] * turn
    on_motion[sliding, 1:, 1:] = weight
    on_force[sliding, 1:, 1:] = keep
    on_force[sliding, 1:, 0] = -pull
    wanted = bound[:, None] * direction - force[:, 1:]
    wanted += np.einsum("sab,sb->sa", keep, force[:, 1:]) - pull * force[:, :1]
    wanted += np.einsum("sab,sb->sa", weight, local[sliding, 1:])
    right[sliding, 1:] = wanted
    return on_motion, on_force, right


def _blocks(blocks: Array) -> sp.csr_matrix:
    """Block-diagonal matrix of blocks (k, dim, dim)."""
    count, dim = len(blocks), blocks.shape[1]
    matrix = sp.bsr_matrix(
        (blocks, np.arange(count), np.arange(count + 1)), shape=(count * dim, count * dim)
    ).tocsr()
    matrix.eliminate_zeros()
    return matrix


def _solve_general(matrix: sp.csr_matrix, load: Array) -> Array:
    """Order, scale, factor and solve once: nothing is kept for the next iteration."""
    if not factor.has_pardiso():
        from scipy.sparse.linalg import spsolve

        return np.asarray(spsolve(matrix.tocsc(), load))
    solver = factor._solver()
    solver.set_matrix_type(11)  # real, not symmetric
    for number, value in ((8, 2), (10, 13), (11, 1), (13, 1)):  # PARDISO's own for this type
        solver.set_iparm(number, value)
    solver.set_phase(13)
    try:
        return factor._call(solver, matrix, np.asfortranarray(load[:, None]))[:, 0]
    finally:
        solver.free_memory(everything=True)


def as_increment(problem: ContactProblem, step: FullStep) -> Increment:
    """A full step as an increment of the condensed ``problem``, so that it is measured alike."""
    local, multiplier = step.contact_motion, step.multiplier
    friction = problem.friction_coefficient
    status = status_of(multiplier, local, problem.self_compliance, friction)
    slid = np.where(status == SLIP, np.linalg.norm(local[:, 1:], axis=1), 0.0)
    force = problem.to_global(multiplier)
    state = ContactState(local[:, 1:], multiplier, step.motion, slid, slid)
    free = ~problem.model.locked.any(axis=0)
    reaction = problem.model.reaction_readout @ force.reshape(-1)
    certificate = certify(
        multiplier,
        local,
        problem.typical_compliance,
        friction,
        reaction[free],
        force.sum(axis=0)[free],
    )
    return Increment(
        motion=step.motion,
        multiplier=multiplier,
        gap=local[:, 0],
        slip_increment=local[:, 1:],
        status=status,
        force=force,
        state=state,
        iterations=step.iterations,
        residual=certificate.laws,
        certificate=certificate,
        method="full",
    )
