"""One increment of the path: a frozen state and a motion in, an accepted increment out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.laws import (
    OPEN,
    SLIP,
    STICK,
    Certificate,
    certify,
    lengths,
    project,
    status_of,
)
from fingerdesign.contact.newton import ActiveInverse, NewtonResult, block, dofs_of
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.contact.strategy import Task, solve_task
from fingerdesign.errors import SolverError


class ZoneExhausted(SolverError):
    """The contact reaches the rim of the candidate zone: a wider zone is needed."""


ACCEPT = 1e-8  # the laws; Newton ends below 1e-10, so a pass is never a close call
ACCEPT_BALANCE = 1e-6  # the model's own rounding, not the solver's (fem.model)
_ON_LIMIT = 1e-9  # relative: rounding of forces and slips
_MOST = 0.5  # of the nodes: with more than these near, all are solved for
_LONGEST = 1.5  # times the last increment: as far as its change is taken on
_MARGIN = 0.1  # of the deepest overlap: nodes this near join the first solve


@dataclass(frozen=True)
class ContactState:
    """What the past leaves: slip so far (m, dim - 1) mm, and the last forces as a first guess."""

    slip: Array
    multiplier: Array
    motion: Motion
    travelled: Array  # (m,) accumulated slip while in contact, mm
    sliding: Array  # (m,) length of the last slip of nodes that are on their friction limit, mm

    @staticmethod
    def untouched(problem: ContactProblem) -> ContactState:
        m, dim = problem.shape
        return ContactState(
            np.zeros((m, dim - 1)), np.zeros((m, dim)), Motion(0.0, 0.0), np.zeros(m), np.zeros(m)
        )


@dataclass(frozen=True)
class Increment:
    """An accepted increment. Local components; forces N of the modelled part, motions mm."""

    motion: Motion
    multiplier: Array  # (m, dim)
    gap: Array  # (m,)
    slip_increment: Array  # (m, dim - 1)
    status: IntArray  # (m,) OPEN, STICK, SLIP
    force: Array  # (m, dim) nodal forces in x, y(, z)
    state: ContactState  # to start the next increment from
    iterations: int
    residual: float
    certificate: Certificate
    method: str


class Workspace:
    """What the last increment of a path leaves to speed up the next: its inverse, its change.

    It saves time and changes no answer by more than rounding. One per path; friction and state are
    not in it.
    """

    def __init__(self) -> None:
        self.inverse: ActiveInverse | None = None
        self.patient = True  # False: leave out the last, slow ways (strategy.py)
        self._last: tuple[ContactState, ContactState] | None = None

    def passed(self, before: ContactState, after: ContactState) -> None:
        """Note an accepted increment."""
        self._last = before, after

    def predicted(self, state: ContactState, motion: Motion, friction_coefficient: float) -> Array:
        """Forces to start from: going on as in the last increment, as far as the motion does.

        Nodes that touch nothing yet are left so, and the forces are admissible.
        """
        if self._last is None or self._last[1] is not state:
            return state.multiplier
        before = self._last[0]
        last = state.motion.amplitudes - before.motion.amplitudes
        now = motion.amplitudes - state.motion.amplitudes
        length = float(last @ last)
        share = min(float(last @ now) / length, _LONGEST) if length > 0.0 else 0.0
        if share <= 0.0:
            return state.multiplier
        guess = state.multiplier + share * (state.multiplier - before.multiplier)
        guess[state.multiplier[:, 0] <= 0.0] = 0.0
        return project(guess, friction_coefficient)

    def on(self, index: IntArray, nodes: int, dim: int) -> ActiveInverse | None:
        """The inverse with its nodes numbered by their place in ``index``."""
        if self.inverse is None:
            return None
        place = np.full(nodes, -1)
        place[index] = np.arange(len(index))
        return self.inverse.restricted(place[self.inverse.nodes] >= 0, dim).renamed(place)


def solve_increment(
    problem: ContactProblem,
    state: ContactState,
    motion: Motion,
    workspace: Workspace | None = None,
) -> Increment:
    """Forces and slips after ``motion`` (total, from touch), the friction history being ``state``.

    Evaluating twice gives the same answer: nothing is stored, but in a ``workspace`` that the
    caller may give to save time along a path. Raises SolverError, with the reason, where no iterate
    passes the certificate or the candidate zone is exhausted.
    """
    workspace = Workspace() if workspace is None else workspace
    offset = problem.offset(motion, state.slip)
    if not np.isfinite(offset).all():
        raise SolverError(f"the motion {motion} is not finite")
    guess = workspace.predicted(state, motion, problem.friction_coefficient)
    result, method = _solve(problem, state, guess, offset, workspace)
    m, dim = problem.shape
    multiplier = result.multiplier
    local = (problem.compliance @ multiplier.reshape(-1)).reshape(m, dim) + offset
    force = problem.to_global(multiplier)
    free = ~problem.model.locked.any(axis=0)
    reaction = problem.model.reaction_readout @ force.reshape(-1)
    certificate = certify(
        multiplier,
        local,
        problem.typical_compliance,
        problem.friction_coefficient,
        reaction[free],
        force.sum(axis=0)[free],
    )
    if not (certificate.laws <= ACCEPT and certificate.balance <= ACCEPT_BALANCE):
        raise SolverError(
            f"no accepted answer at {motion} (friction {problem.friction_coefficient:g}): "
            f"{certificate} after {result.iterations} iterations; use smaller increments"
        )
    _check_zone(problem, multiplier, local[:, 0], motion)
    status = status_of(multiplier, local, problem.self_compliance, problem.friction_coefficient)
    slip = local[:, 1:] + state.slip
    sliding = _sliding(problem, state, multiplier, local[:, 1:])
    status[(sliding > 0.0) & (status == STICK)] = SLIP
    # A sticking node has not moved, whatever the rounding; an open one starts anew.
    moved = np.where(status == SLIP, lengths(local[:, 1:]), 0.0)
    travelled = np.where(status != OPEN, state.travelled + moved, 0.0)
    after = ContactState(slip, multiplier, motion, travelled, sliding)
    workspace.passed(state, after)
    return Increment(
        motion=motion,
        multiplier=multiplier,
        gap=local[:, 0],
        slip_increment=local[:, 1:],
        status=status,
        force=force,
        state=after,
        iterations=result.iterations,
        residual=result.residual,
        certificate=certificate,
        method=method,
    )


def _sliding(problem: ContactProblem, state: ContactState, multiplier: Array, slip: Array) -> Array:
    """Slip (m,) mm of nodes on their friction limit; their last one where nothing has moved.

    A motion that stands still leaves such nodes on the limit without a slip of their own: they are
    still those that slid.
    """
    limit = problem.friction_coefficient * np.maximum(multiplier[:, 0], 0.0)
    on_limit = (multiplier[:, 0] > 0.0) & (lengths(multiplier[:, 1:]) >= limit * (1.0 - _ON_LIMIT))
    moved = lengths(slip)
    still = moved <= _ON_LIMIT * problem.self_compliance * multiplier[:, 0]
    return np.where(on_limit, np.where(still, state.sliding, moved), 0.0)


def _solve(
    problem: ContactProblem,
    state: ContactState,
    guess: Array,
    offset: Array,
    workspace: Workspace,
) -> tuple[NewtonResult, str]:
    """Solve on the nodes that the object could reach; any other that it does reach is added."""
    m, dim = problem.shape
    before = problem.offset(state.motion, state.slip)
    # A rigid finger would overlap the object here; an elastic one yields, and mostly touches less.
    margin = _MARGIN * max(0.0, -float(offset[:, 0].min()))
    near = (np.minimum(offset, before)[:, 0] <= margin) | (state.multiplier[:, 0] > 0.0)
    multiplier = np.zeros((m, dim))
    spent = 0
    while True:
        # Cutting out most of the matrix costs more than it saves.
        whole = np.count_nonzero(near) > _MOST * m
        index = np.arange(m) if whole else np.flatnonzero(near)
        columns = dofs_of(index, dim)
        compliance = problem.compliance if whole else block(problem.compliance, columns, columns)
        task = Task(
            compliance,
            offset[index],
            before[index],
            problem.friction_coefficient,
            state.multiplier[index],
            guess[index],
            workspace.on(index, m, dim),
            workspace.patient,
        )
        result, method = solve_task(task)
        spent += result.iterations
        multiplier[index] = result.multiplier
        workspace.inverse = result.inverse.renamed(index) if result.inverse is not None else None
        missed = ~near & ~whole
        if missed.any():
            rows = block(problem.compliance, dim * np.flatnonzero(missed), columns)
            gap = offset[missed, 0] + rows @ multiplier[index].reshape(-1)
            missed[missed] = gap < 0.0
        if not missed.any():
            return NewtonResult(multiplier, result.residual, spent, result.converged), method
        near |= missed


def _check_zone(problem: ContactProblem, multiplier: Array, gap: Array, motion: Motion) -> None:
    rim = problem.model.rim
    if (multiplier[rim, 0] > 0.0).any():
        where = problem.model.points[rim & (multiplier[:, 0] > 0.0), 0]
        raise ZoneExhausted(
            f"the contact reaches the end of the candidate zone (x = {where[0]:.2f} mm) at "
            f"{motion}; widen the zone"
        )
