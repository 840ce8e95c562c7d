"""What is tried, in which order, to solve one increment (numpy only)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fingerdesign.contact.active import ActiveInverse
from fingerdesign.contact.newton import NewtonResult, newton
from fingerdesign.contact.sweeps import gauss_seidel

Array = NDArray[np.float64]

_CUTS = (2, 8, 32)  # pieces that carry the iterate, not the friction history, to the motion


@dataclass(frozen=True)
class Task:
    """One increment on some nodes: find forces with gap and slip v = compliance f + offset.

    compliance (k dim, k dim); offset (k, dim) at the motion asked, before (k, dim) at the last one;
    start (k, dim) the last forces; inverse from an earlier solve on these nodes, if there is one.
    """

    compliance: Array
    offset: Array
    before: Array
    friction_coefficient: float
    start: Array
    inverse: ActiveInverse | None = None

    def newton(self, start: Array, factor: float = 0.05) -> NewtonResult:
        # From the last answer, what touched goes on touching for a first step (newton.py).
        before = self.before if start is self.start and start.any() else None
        return newton(
            self.compliance,
            self.offset,
            self.friction_coefficient,
            start,
            factor,
            self.inverse,
            before,
        )


def solve_task(task: Task) -> tuple[NewtonResult, str]:
    """Newton from the last forces; then by a walk of the motion; then from Gauss-Seidel.

    Returns the best iterate and the method, "none" where nothing converged: the caller certifies.
    """
    if not len(task.offset):
        return NewtonResult(task.start, 0.0, 0, True), "no contact"
    result = task.newton(task.start)
    if result.converged:
        return result, "newton"
    spent, best = result.iterations, result
    for pieces in _CUTS:
        result = _walk(task, pieces)
        spent += result.iterations
        if result.converged:
            return replace(result, iterations=spent), "newton, walked"
    for factor in (0.01, 0.5):
        result = task.newton(best.multiplier, factor)
        spent += result.iterations
        if result.converged:
            return replace(result, iterations=spent), "newton, other augmentation"
    for sweeps in (100, 1000):
        swept = gauss_seidel(
            task.compliance, task.offset, task.friction_coefficient, best.multiplier, sweeps
        )
        result = task.newton(swept.multiplier)
        spent += swept.iterations + result.iterations
        if result.converged:
            return replace(result, iterations=spent), "gauss-seidel, newton"
        best = min((swept, result, best), key=lambda each: each.residual)
    return replace(best, iterations=spent, converged=False), "none"


def _walk(task: Task, pieces: int) -> NewtonResult:
    """Newton along the way from the last motion; only the last piece has to converge."""
    guess, spent = task.start, 0
    for piece in range(1, pieces + 1):
        part = task.before + (task.offset - task.before) * (piece / pieces)
        result = replace(task, offset=part).newton(guess)
        spent += result.iterations
        guess = result.multiplier
    return replace(result, iterations=spent)
