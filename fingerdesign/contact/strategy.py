"""What is tried, in which order, to solve one increment (numpy only).

Newton from the last forces solves all but a few increments in a thousand. What is left is mostly a
large friction coefficient, where an answer always exists but need not be the only one: in the plane
complementary pivots find one for certain; in 3-D it is approached along the motion, along the
friction coefficient, and by Gauss-Seidel. Each way is limited in iterations: nothing can hang.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.active import ActiveInverse
from fingerdesign.contact.newton import NewtonResult, newton
from fingerdesign.contact.pivots import friction_pivots
from fingerdesign.contact.pressing import pressed
from fingerdesign.contact.sweeps import gauss_seidel

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
