"""One increment of the path: a frozen state and a motion in, an accepted increment out."""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.friction import Friction
from fingerdesign.contact.laws import Certificate, project
from fingerdesign.contact.outcome import Answer, Outcome
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.contact.solver.active_inverse import ActiveInverse, block, dofs_of
from fingerdesign.contact.solver.attempts import Task, solve_task
from fingerdesign.contact.solver.guess import active_set_guess
from fingerdesign.contact.solver.kernel import tracker_of
from fingerdesign.contact.solver.newton import NewtonResult
from fingerdesign.contact.solver.tracking import Tracker
from fingerdesign.errors import SolverError
from fingerdesign.shapes.friction import FrictionLaw

# The bound of the laws' errors. Newton ends below 1e-10, so a pass is never a close call.
ACCEPT = 1e-8
TRACKED = "tracking"  # The method of an increment that needed none of the attempts.
STARTED = "tracking, from a guess"
ACCEPT_BALANCE = 1e-6  # The rounding of the model (fem.reduction), not of the solver.
_MOST = 0.5  # Solve on all nodes if more than this fraction is near contact.
_LONGEST = 1.5  # The longest extrapolation, in lengths of the last increment.
_MARGIN = 0.1  # Nodes nearer than this part of the deepest overlap join the first solve.


class ZoneExhausted(SolverError):
    """The contact reaches the rim of the candidate zone: a wider zone is needed."""


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
    """Data of the last increment that speed up the next one: its inverse, its change.

    It saves time and changes no answer by more than rounding. Each path has its own: it holds the
    last two states and a tracker, which is made again where the compliance differs.
    follows: start from the last increment (tracking.py), else from nothing.
    """

    def __init__(self, follows: bool = True) -> None:
        self.follows = follows
        self.inverse: ActiveInverse | None = None
        self._tracker: Tracker | None = None
        self._law: FrictionLaw | None = None
        self._shares: Array | None = None
        self._last: tuple[ContactState, ContactState] | None = None

    def tracker(self, problem: ContactProblem) -> Tracker:
        """Get the tracker of the increments on this compliance, at this friction."""
        compliance, tracker = problem.compliance, self._tracker
        if tracker is None or tracker.compliance is not compliance:
            tracker = tracker_of(compliance, problem.self_compliance, problem.friction)
        elif not (self._law == problem.law and self._shares is problem.friction_share):
            tracker.meet(problem.friction)
        self._tracker, self._law, self._shares = tracker, problem.law, problem.friction_share
        return tracker

    def record(self, before: ContactState, after: ContactState) -> None:
        """Note an accepted increment."""
        self._last = before, after

    def predicted(self, state: ContactState, motion: Motion, friction: Friction) -> Array:
        """Extrapolate the forces of the last increment along the motion; they are admissible. Nodes
        that were not in contact stay without force."""
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
        return project(guess, friction)

    def inverse_on(self, index: IntArray, nodes: int, dim: int) -> ActiveInverse | None:
        """Renumber the inverse's nodes by their place in ``index``."""
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
    try_slow_methods: bool = True,
) -> Increment:
    """Find the forces and slips after ``motion`` (total, from first contact) from ``state``.

    Evaluating twice gives the same answer: nothing is stored, except in a ``workspace`` that saves
    time along a path. Without ``try_slow_methods`` the last attempts are left out: for one of many
    trials, which need not succeed. Raises SolverError, with the reason, where no iterate passes the
    certificate or the candidate zone is exhausted.
    """
    workspace = Workspace() if workspace is None else workspace
    offset = problem.offset(motion, state.slip)
    if not np.isfinite(offset).all():
        raise SolverError(f"the motion {motion} is not finite")
    change = motion.amplitudes - state.motion.amplitudes
    found, outcome, method = _answer(
        problem, state, motion, change, offset, workspace, try_slow_methods
    )
    if not _accepts(outcome.certificate):
        raise SolverError(
            f"no accepted answer at {motion} (friction {problem.law}): "
            f"{outcome.certificate} after {found.iterations} iterations; use smaller increments"
        )
    if outcome.at_rim:
        where = problem.model.points[problem.model.rim & (found.multiplier[:, 0] > 0.0), 0]
        raise ZoneExhausted(
            f"the contact reaches the end of the candidate zone (x = {where[0]:.2f} mm) at "
            f"{motion}; widen the zone"
        )
    reached = problem.found_motion(motion, found.multiplier)
    slid = outcome.travelled, outcome.sliding
    after = ContactState(outcome.slip, found.multiplier, reached, *slid)
    workspace.tracker(problem).know(found, outcome, change, state.slip)
    workspace.record(state, after)
    return Increment(
        motion=motion,
        multiplier=found.multiplier,
        gap=found.motion[:, 0],
        slip_increment=found.motion[:, 1:],
        status=outcome.status,
        force=outcome.force,
        state=after,
        iterations=found.iterations,
        residual=found.residual,
        certificate=outcome.certificate,
        method=method,
    )


def _answer(
    problem: ContactProblem,
    state: ContactState,
    motion: Motion,
    change: Array,
    offset: Array,
    workspace: Workspace,
    try_slow_methods: bool,
) -> tuple[Answer, Outcome, str]:
    """Find an answer near the last increment that the certificate accepts, else solve again.

    Returned with its outcome and the name of the method. change: of the motion's amplitudes (5,).
    """
    tracker, friction = workspace.tracker(problem), problem.friction
    ways = (TRACKED, STARTED) if tracker.starts else (TRACKED,)
    for method in ways if workspace.follows else ():
        base = tracker.base
        if method == TRACKED:
            near = tracker.solve(offset, change, state.slip)
        else:
            guess = workspace.predicted(state, motion, friction)
            guess = active_set_guess(problem.compliance, offset, guess, friction)
            near = tracker.start(offset, guess)
        # A new working set has the inverse of its nodes: the next full solve starts from it.
        if tracker.base is not None and tracker.base is not base:
            workspace.inverse = tracker.base.active
        if near is not None:
            outcome = tracker.outcome(problem, state, near)
            if _accepts(outcome.certificate):
                return near, outcome, method
    guess = workspace.predicted(state, motion, friction)
    result, method = _solve(problem, state, guess, offset, workspace, try_slow_methods)
    yielded = (problem.compliance @ result.multiplier.reshape(-1)).reshape(offset.shape)
    found = Answer(result.multiplier, yielded, yielded + offset, result.residual, result.iterations)
    return found, tracker.outcome(problem, state, found), method


def _accepts(certificate: Certificate) -> bool:
    return certificate.laws <= ACCEPT and certificate.balance <= ACCEPT_BALANCE


def _solve(
    problem: ContactProblem,
    state: ContactState,
    guess: Array,
    offset: Array,
    workspace: Workspace,
    try_slow_methods: bool,
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
            problem.friction if whole else problem.friction.at(index),
            state.multiplier[index],
            guess[index],
            workspace.inverse_on(index, m, dim),
            try_slow_methods,
        )
        result, method = solve_task(task)
        spent += result.iterations
        multiplier[index] = result.multiplier
        workspace.inverse = result.inverse.renamed(index) if result.inverse is not None else None
        missed = ~near & ~whole
        if missed.any():
            rows = block(problem.compliance, dim * np.flatnonzero(missed), columns)
            gap = offset[missed, 0] + rows @ multiplier[index].reshape(-1)
            # Of the nodes left out, those that overlap the object: `gap` has one row for each.
            missed[missed] = gap < 0.0
        if not missed.any():
            return NewtonResult(multiplier, result.residual, spent, result.converged), method
        near |= missed
