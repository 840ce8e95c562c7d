"""One increment of the path: a frozen state and a motion in, an accepted increment out."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.linalg.lapack import dposv

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.kernel import tracker_of
from fingerdesign.contact.laws import Certificate, project
from fingerdesign.contact.newton import (
    ActiveInverse,
    NewtonResult,
    block,
    dofs_of,
    newton,
    relative_residual,
)
from fingerdesign.contact.outcome import Answer, Outcome
from fingerdesign.contact.pivots import friction_pivots
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.contact.tracking import Tracker
from fingerdesign.errors import SolverError

# What is tried, in which order, to solve one increment (numpy only).
#
# Small steps follow from the one before (tracking.py). Of all that is solved anew, Newton from the
# last forces solves all but a few increments in a thousand. What is left is mostly
# a large friction coefficient, where an answer always exists but need not be the only one: in the
# plane complementary pivots find one for certain; in 3-D it is approached along the motion, along
# the friction coefficient, and by Gauss-Seidel. Each way is limited in iterations: nothing can
# hang.

# Which nodes touch, from the normal forces alone: a cheap first guess for Newton (numpy only).
#
# Tangential forces being held, contact is a linear complementarity problem in the normal forces, a
# third of the unknowns (half in the plane) and a small part of the work. An active set, from the
# nodes that touched before, mostly ends in three or four steps.

_STEPS = 12  # what is wrong after them Newton mends


def pressed(compliance: Array, offset: Array, guess: Array, friction_coefficient: float) -> Array:
    """Admissible forces (m, dim): normal ones that close ``offset``'s gap under ``guess``'s pull.

    compliance (m dim, m dim), offset (m, dim) as in newton.newton. Never fails: a guess.
    """
    m, dim = offset.shape
    pull = guess.copy()
    pull[:, 0] = 0.0
    gap = offset[:, 0] + (compliance @ pull.reshape(-1))[::dim]
    closed = guess[:, 0] > 0.0
    if not closed.any():
        closed = gap < 0.0
    normal, pressing = np.zeros(m), np.ascontiguousarray(compliance[::dim, ::dim])
    for _ in range(_STEPS):
        index = np.flatnonzero(closed)
        normal[:] = 0.0
        if len(index):
            rows = pressing[index]  # by symmetry the gaps that they cause
            *_, force, info = dposv(rows[:, index].T, -gap[index], overwrite_a=1)
            if info:
                return guess
            normal[index] = force
        now = np.where(closed, normal > 0.0, gap + normal @ pressing < 0.0)
        if (now == closed).all():
            break
        closed = now
    pull[:, 0] = np.maximum(normal, 0.0)
    return project(pull, friction_coefficient)


# Projected Gauss-Seidel over the contact nodes: slow, and very hard to throw off (numpy only).
#
# Each node in turn takes the normal force that closes its gap, then the tangential force nearest to
# sticking within its friction disc, all others held (Jean, CMAME 177 (1999) 235; Siconos calls it
# NSGS). A node's change moves all others by a column of the compliance, so a visit costs one
# product of a vector, and nothing where the node stays as it is.

_LOOK = 10  # sweeps between looks at the residual and the clock


def gauss_seidel(
    compliance: Array,
    offset: Array,
    friction_coefficient: float,
    start: Array,
    sweeps: int = 500,
    tolerance: float = 1e-8,
    time_limit: float = np.inf,
) -> NewtonResult:
    """Sweep until the natural residual is below ``tolerance``, or sweeps or processor time run out.

    compliance (m dim, m dim) symmetric, offset and start (m, dim), as in newton.newton. The best
    iterate looked at is returned, with converged = False where the tolerance was not met.
    ``time_limit``: seconds of processor time.
    """
    m, dim = offset.shape
    diagonal = np.diag(compliance).reshape(m, dim)
    normal_diagonal = diagonal[:, 0].tolist()
    # A step by the largest eigenvalue of the tangential block overshoots in no direction.
    tangential = (diagonal[:, 1] if dim == 2 else _largest(compliance, m, dim)).tolist()
    force = start.copy()
    rows = compliance.reshape(m, dim, m * dim)
    best, best_residual = force.copy(), np.inf
    until = time.process_time() + time_limit
    sweep = 0
    while sweep < sweeps:
        # Made anew at each look: rounding of the updates does not add up.
        motion = (compliance @ force.reshape(-1)).reshape(m, dim) + offset
        for _ in range(min(_LOOK, sweeps - sweep)):
            _one_sweep(force, motion, rows, normal_diagonal, tangential, friction_coefficient)
            sweep += 1
        motion = (compliance @ force.reshape(-1)).reshape(m, dim) + offset
        residual = relative_residual(force, motion, diagonal[:, 0], friction_coefficient)
        if residual < best_residual:
            best, best_residual = force.copy(), residual
        if residual <= tolerance:
            return NewtonResult(best, best_residual, sweep, True)
        if time.process_time() > until:
            break
    return NewtonResult(best, best_residual, sweep, False)


def _one_sweep(
    force: Array,
    motion: Array,
    rows: Array,
    normal_diagonal: list[float],
    tangential: list[float],
    friction_coefficient: float,
) -> None:
    """Visit each node once; ``force`` and ``motion`` (m, dim) are changed in place."""
    flat = motion.reshape(-1)
    for i, stiff in enumerate(normal_diagonal):
        old, moved = force[i].tolist(), motion[i].tolist()
        normal = old[0] - moved[0] / stiff
        if normal <= 0.0:
            if any(old):
                flat -= force[i] @ rows[i]
                force[i] = 0.0
            continue
        change, bound = normal - old[0], friction_coefficient * normal
        dim = len(old)
        own = rows[i, 1:, i * dim].tolist()
        trial = [old[k] - (moved[k] + change * own[k - 1]) / tangential[i] for k in range(1, dim)]
        size = abs(trial[0]) if dim == 2 else (trial[0] ** 2 + trial[1] ** 2) ** 0.5
        if size > bound:
            trial = [value * (bound / size) for value in trial]
        new = np.array([normal, *trial])
        flat += (new - force[i]) @ rows[i]
        force[i] = new


def _largest(compliance: Array, m: int, dim: int) -> Array:
    """Largest eigenvalue (m,) of each node's own tangential block."""
    here = np.arange(m)
    blocks = compliance.reshape(m, dim, m, dim)[here, :, here, :][:, 1:, 1:]
    return np.asarray(np.linalg.eigvalsh(blocks)[:, -1])


Attempt = Callable[[Array], NewtonResult]

_WARM = 16  # iterations: what takes longer from the guess is better begun anew
_CUTS = (2, 8)  # pieces that carry the iterate, not the friction history, to the motion
_SHARES = (0.0, 0.25, 0.5, 0.7, 0.85, 1.0)  # of the friction coefficient
_FACTORS = (0.01, 0.5)  # of Newton's augmentation; 0.05 is the ordinary one
_PATHS = 3  # of pivots: the first fails by rounding alone
_SWEEPS = (100, 1000, 3000)


@dataclass(frozen=True)
class Task:
    """One increment on some nodes: find forces with gap and slip v = compliance f + offset.

    compliance (k dim, k dim); offset (k, dim) at the motion asked, before (k, dim) at the last one;
    start (k, dim) the last forces, guess (k, dim) those that the path leads to expect; inverse from
    an earlier solve on these nodes, if there is one.
    """

    compliance: Array
    offset: Array
    before: Array
    friction_coefficient: float
    start: Array
    guess: Array
    inverse: ActiveInverse | None = None
    patient: bool = True  # else without the last, slow ways: one of many trials need not succeed

    def newton(self, start: Array, factor: float = 0.05, most: int = 40) -> NewtonResult:
        friction = self.friction_coefficient
        return newton(self.compliance, self.offset, friction, start, factor, self.inverse, most)

    def warm(self) -> NewtonResult:
        """From the guess, its contact brought up to date: mostly 3 to 6 steps, where newton from
        the last forces takes 6 to 8 but hardly ever cycles."""
        guess = self.guess
        if not np.array_equal(self.offset[:, 0], self.before[:, 0]) or not guess.any():
            guess = pressed(self.compliance, self.offset, guess, self.friction_coefficient)
        return self.newton(guess, most=_WARM)


def solve_task(task: Task) -> tuple[NewtonResult, str]:
    """The first attempt that converges, and its name; iterations are those of all attempts.

    Where none does, the iterate with the least residual and "none": the caller certifies.
    """
    if not len(task.offset):
        return NewtonResult(task.start, 0.0, 0, True), "no contact"
    best, spent = NewtonResult(task.start, np.inf, 0, False), 0
    for name, attempt in _attempts(task):
        result = attempt(best.multiplier)
        spent += result.iterations
        if result.converged:
            return replace(result, iterations=spent), name
        best = min((best, result), key=lambda each: each.residual)
    return replace(best, iterations=spent, converged=False), "none"


def _attempts(task: Task) -> Iterator[tuple[str, Attempt]]:
    """Names, and what to do with the best forces so far."""
    yield "newton, warm", lambda best: task.warm()
    yield "newton", lambda best: task.newton(task.start)
    yield "newton, other augmentation", lambda best: task.newton(task.start, _FACTORS[0])
    if task.offset.shape[1] == 2:
        for path in range(_PATHS):
            yield "pivots", partial(_pivots, task, path)
    for pieces in _CUTS:
        yield "newton, walked", partial(_walk, task, pieces)
    for factor in _FACTORS[1:]:
        yield "newton, other augmentation", partial(task.newton, factor=factor)
    if not task.patient:
        return
    yield "newton, friction raised", partial(_raise_friction, task)
    for sweeps in _SWEEPS:
        yield "gauss-seidel, newton", partial(_sweep, task, sweeps)


def _pivots(task: Task, path: int, best: Array) -> NewtonResult:
    return friction_pivots(task.compliance, task.offset, task.friction_coefficient, path)


def _walk(task: Task, pieces: int, best: Array) -> NewtonResult:
    """Newton along the way from the last motion; only the last piece has to converge."""
    way = task.offset - task.before
    shares = [piece / pieces for piece in range(1, pieces + 1)]
    return _along([replace(task, offset=task.before + way * s) for s in shares], task.start)


def _raise_friction(task: Task, best: Array) -> NewtonResult:
    """Newton from the frictionless answer, the friction coefficient growing to its own."""
    whole = task.friction_coefficient
    parts = [replace(task, friction_coefficient=share * whole) for share in _SHARES]
    return _along(parts, np.zeros_like(task.start))


def _along(parts: Sequence[Task], guess: Array) -> NewtonResult:
    """Newton on one task after the other, each from the last one's forces."""
    spent = 0
    for part in parts:
        result = part.newton(guess)
        spent += result.iterations
        guess = result.multiplier
    return replace(result, iterations=spent)


def _sweep(task: Task, sweeps: int, best: Array) -> NewtonResult:
    """Gauss-Seidel, then Newton from where it got; whichever came nearer."""
    swept = gauss_seidel(task.compliance, task.offset, task.friction_coefficient, best, sweeps)
    result = task.newton(swept.multiplier)
    spent = swept.iterations + result.iterations
    if not result.converged and swept.residual < result.residual:
        result = replace(swept, converged=False)
    return replace(result, iterations=spent)


class ZoneExhausted(SolverError):
    """The contact reaches the rim of the candidate zone: a wider zone is needed."""


ACCEPT = 1e-8  # the laws; Newton ends below 1e-10, so a pass is never a close call
TRACKED = "tracking"  # an increment's method where none of Newton's attempts was needed
STARTED = "tracking, from a guess"
ACCEPT_BALANCE = 1e-6  # the model's own rounding, not the solver's (fem.model)
_MOST = 0.5  # of the nodes: with more than these near, all are solved for
_LONGEST = 1.5  # times the last increment: as far as its change is taken on
_MARGIN = 0.1  # of the deepest overlap: nodes this near join the first solve


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
    not in it. follows: begin from the last increment (tracking.py), else solve each anew.
    """

    def __init__(self, follows: bool = True) -> None:
        self.follows = follows
        self.inverse: ActiveInverse | None = None
        self.patient = True  # False: leave out the last, slow ways
        self._tracker: Tracker | None = None
        self._last: tuple[ContactState, ContactState] | None = None

    def tracker(self, problem: ContactProblem) -> Tracker:
        """Of the increments on this compliance, at this friction."""
        tracker, friction = self._tracker, problem.friction_coefficient
        if (
            tracker is None
            or tracker.compliance is not problem.compliance
            or (tracker.friction != friction)
        ):
            tracker = tracker_of(problem.compliance, problem.self_compliance, friction)
            self._tracker = tracker
        return tracker

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
    change = motion.amplitudes - state.motion.amplitudes
    found, outcome, method = _answer(problem, state, motion, change, offset, workspace)
    if not _accepts(outcome.certificate):
        raise SolverError(
            f"no accepted answer at {motion} (friction {problem.friction_coefficient:g}): "
            f"{outcome.certificate} after {found.iterations} iterations; use smaller increments"
        )
    if outcome.at_rim:
        raise _exhausted(problem, found.multiplier, motion)
    after = ContactState(outcome.slip, found.multiplier, motion, outcome.travelled, outcome.sliding)
    workspace.tracker(problem).know(found, outcome, change, state.slip)
    workspace.passed(state, after)
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
) -> tuple[Answer, Outcome, str]:
    """What is found near the last increment if the certificate accepts it, else by a solve anew.

    With what it amounts to, and the name of the way. change: of the motion's amplitudes (5,).
    """
    tracker, friction = workspace.tracker(problem), problem.friction_coefficient
    ways = (TRACKED, STARTED) if tracker.starts else (TRACKED,)
    for method in ways if workspace.follows else ():
        base = tracker.base
        if method == TRACKED:
            near = tracker.solve(offset, change, state.slip)
        else:
            guess = workspace.predicted(state, motion, friction)
            near = tracker.start(offset, pressed(problem.compliance, offset, guess, friction))
        if tracker.base is not None and tracker.base is not base:
            workspace.inverse = tracker.base.active
        if near is not None:
            outcome = tracker.outcome(problem, state, near)
            if _accepts(outcome.certificate):
                return near, outcome, method
    guess = workspace.predicted(state, motion, friction)
    result, method = _solve(problem, state, guess, offset, workspace)
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


def _exhausted(problem: ContactProblem, multiplier: Array, motion: Motion) -> ZoneExhausted:
    where = problem.model.points[problem.model.rim & (multiplier[:, 0] > 0.0), 0]
    return ZoneExhausted(
        f"the contact reaches the end of the candidate zone (x = {where[0]:.2f} mm) at "
        f"{motion}; widen the zone"
    )
