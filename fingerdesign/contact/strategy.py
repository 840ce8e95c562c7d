"""What is tried, in which order, to solve one increment (numpy only).

Newton from the last forces solves all but a few increments in a thousand. What is left is mostly a
large friction coefficient, where an answer always exists but need not be the only one: in the plane
complementary pivots find one for certain; in 3-D it is approached along the motion, along the
friction coefficient, and by Gauss-Seidel. Each way is limited in iterations: nothing can hang.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.laws import project
from fingerdesign.contact.newton import ActiveInverse, NewtonResult, newton, relative_residual
from fingerdesign.contact.pivots import friction_pivots

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
    normal = np.zeros(m)
    for _ in range(_STEPS):
        index = np.flatnonzero(closed)
        rows = compliance[dim * index][:, ::dim]  # by symmetry the gaps that they cause
        try:
            force = np.linalg.solve(rows[:, index], -gap[index]) if len(index) else np.empty(0)
        except np.linalg.LinAlgError:
            return guess
        normal[:] = 0.0
        normal[index] = force
        now = np.where(closed, normal > 0.0, gap + force @ rows < 0.0)
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

    def newton(self, start: Array, factor: float = 0.05) -> NewtonResult:
        return newton(
            self.compliance, self.offset, self.friction_coefficient, start, factor, self.inverse
        )

    def warm(self) -> NewtonResult:
        """From the guess, its contact brought up to date: mostly 3 to 6 steps, where newton from
        the last forces takes 6 to 8 but hardly ever cycles."""
        guess = self.guess
        if not np.array_equal(self.offset[:, 0], self.before[:, 0]) or not guess.any():
            guess = pressed(self.compliance, self.offset, guess, self.friction_coefficient)
        return newton(
            self.compliance,
            self.offset,
            self.friction_coefficient,
            guess,
            inverse=self.inverse,
            max_iterations=_WARM,
        )


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
    guess, spent = task.start, 0
    for piece in range(1, pieces + 1):
        part = task.before + (task.offset - task.before) * (piece / pieces)
        result = replace(task, offset=part).newton(guess)
        spent += result.iterations
        guess = result.multiplier
    return replace(result, iterations=spent)


def _raise_friction(task: Task, best: Array) -> NewtonResult:
    """Newton from the frictionless answer, the friction coefficient growing to its own."""
    guess, spent = np.zeros_like(task.start), 0
    for share in _SHARES:
        part = replace(task, friction_coefficient=share * task.friction_coefficient)
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
