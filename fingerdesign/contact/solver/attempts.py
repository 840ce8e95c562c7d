"""The attempts to solve one increment, in order (numpy only).

Small steps follow from the increment before (tracking.py). Of the others, Newton from the last
forces solves all but a few in a thousand. The rest mostly has a large friction coefficient: an
answer always exists, but there may be several. In the plane, complementary pivots find one of
Coulomb's law for certain; other laws are approached by it, each node with the coefficient that its
last force gives. In 3-D the answer is approached along the motion, along the friction coefficient,
and by Gauss-Seidel. Each attempt has a limit of iterations, so that nothing can hang.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.friction import Coulomb, Friction
from fingerdesign.contact.solver.active_inverse import ActiveInverse
from fingerdesign.contact.solver.gauss_seidel import gauss_seidel
from fingerdesign.contact.solver.guess import active_set_guess
from fingerdesign.contact.solver.newton import NewtonResult, newton
from fingerdesign.contact.solver.pivots import friction_pivots

Attempt = Callable[[Array], NewtonResult]

_WARM = 16  # Iterations from the guess; after more, another start is faster.
_CUTS = (2, 8)  # Pieces of the motion; they carry the iterate, not the friction history.
_SHARES = (0.0, 0.25, 0.5, 0.7, 0.85, 1.0)  # Steps of the friction bound.
_FACTORS = (0.01, 0.5)  # Other augmentations of Newton; 0.05 is the ordinary one.
_PATHS = 3  # Paths of pivots; the first fails only by rounding.
_COULOMB = 12  # Answers of Coulomb's law on the way to another law's.
_SWEEPS = (100, 1000, 3000)  # Sweeps of Gauss-Seidel, each time followed by Newton.


@dataclass(frozen=True)
class Task:
    """One increment on some nodes: find forces with gap and slip v = compliance f + offset.

    compliance (k dim, k dim); offset (k, dim) at the new motion, before (k, dim) at the last one;
    start (k, dim) the last forces, guess (k, dim) those that the path leads to expect; inverse from
    an earlier solve on these nodes, if there is one.
    """

    compliance: Array
    offset: Array
    before: Array
    friction: Friction
    start: Array
    guess: Array
    inverse: ActiveInverse | None = None
    try_slow_methods: bool = True

    def newton(self, start: Array, factor: float = 0.05, most: int = 40) -> NewtonResult:
        own = self.compliance, self.offset, self.friction
        return newton(*own, start, factor, self.inverse, most)

    def warm(self) -> NewtonResult:
        """Newton from the guess, its contact updated: mostly 3 to 6 steps. Newton from the last
        forces takes 6 to 8 but hardly ever cycles."""
        guess = self.guess
        if not np.array_equal(self.offset[:, 0], self.before[:, 0]) or not guess.any():
            guess = active_set_guess(self.compliance, self.offset, guess, self.friction)
        return self.newton(guess, most=_WARM)


def solve_task(task: Task) -> tuple[NewtonResult, str]:
    """The first attempt that converges, and its name; iterations are those of all attempts. Where
    none does, the iterate with the least residual and "none": the caller certifies."""
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
    """Yield the attempts: a name, and a function of the best forces so far."""
    yield "newton, warm", lambda best: task.warm()
    yield "newton", lambda best: task.newton(task.start)
    yield "newton, other augmentation", lambda best: task.newton(task.start, _FACTORS[0])
    if isinstance(task.friction, Coulomb):
        if task.offset.shape[1] == 2:
            for path in range(_PATHS):
                yield "pivots", partial(_pivots, task, task.friction, path)
    else:
        yield "coulomb, newton", partial(_by_coulomb, task)
    for pieces in _CUTS:
        yield "newton, walked", partial(_walk, task, pieces)
    for factor in _FACTORS[1:]:
        yield "newton, other augmentation", partial(task.newton, factor=factor)
    if not task.try_slow_methods:
        return
    yield "newton, friction raised", partial(_raise_friction, task)
    for sweeps in _SWEEPS:
        yield "gauss-seidel, newton", partial(_sweep, task, sweeps)


def _pivots(task: Task, friction: Coulomb, path: int, best: Array) -> NewtonResult:
    return friction_pivots(task.compliance, task.offset, friction, path)


def _by_coulomb(task: Task, best: Array) -> NewtonResult:
    """Newton from answers of Coulomb's law, with coefficients that the last answer's forces give.
    The first are those of the mean force of the nodes in contact."""
    force, spent = best, 0
    typical = np.mean(force[force[:, 0] > 0.0, 0]) if (force[:, 0] > 0.0).any() else 0.0
    pressed = np.where(force[:, 0] > 0.0, force[:, 0], typical)
    for _ in range(_COULOMB):
        coulomb = Coulomb(np.array(task.friction.secant(pressed)))
        found, _ = solve_task(replace(task, friction=coulomb, start=force, guess=force))
        result = task.newton(found.multiplier)
        spent += found.iterations + result.iterations
        if result.converged:
            break
        force = found.multiplier
        pressed = 0.5 * (pressed + np.maximum(force[:, 0], 0.0))
    return replace(result, iterations=spent)


def _walk(task: Task, pieces: int, best: Array) -> NewtonResult:
    """Newton along the way from the last motion; only the last piece has to converge."""
    way = task.offset - task.before
    shares = [piece / pieces for piece in range(1, pieces + 1)]
    return _along([replace(task, offset=task.before + way * s) for s in shares], task.start)


def _raise_friction(task: Task, best: Array) -> NewtonResult:
    """Newton from the frictionless answer, the friction bound growing to its own."""
    parts = [replace(task, friction=task.friction.scaled(share)) for share in _SHARES]
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
    """Gauss-Seidel, then Newton from its result; the better of both."""
    swept = gauss_seidel(task.compliance, task.offset, task.friction, best, sweeps)
    result = task.newton(swept.multiplier)
    spent = swept.iterations + result.iterations
    if not result.converged and swept.residual < result.residual:
        result = replace(swept, converged=False)
    return replace(result, iterations=spent)
