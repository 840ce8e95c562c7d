"""The least error that any unbiased estimate can have from the gages: Cramér and Rao's bound.

Hold both forces, let friction differ a little: readings e (g,) and stick ratio S move together, and
that is all that the gages say of S which the forces do not. With independent noise of deviation
sigma on each reading, no unbiased estimate from n samples in that state errs by less than

    sigma / (|de/dS| sqrt(n)),      de/dS = (de/dmu) / (dS/dmu) at the same F_n and F_t

(Cramér, Mathematical Methods of Statistics, 1946, 32.3). The state is reached by pressing to F_n
and pulling at constant F_n. The model is taken as known exactly, gains and all: a rig does worse.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces, solve_forces
from fingerdesign.contact.increment import ContactState
from fingerdesign.contact.measures import measure
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.estimator import LAGS
from fingerdesign.control.signals import gage_readings
from fingerdesign.errors import SolverError
from fingerdesign.study.observability_record import Floor

WINDOW = max(LAGS) + 1  # samples that the estimator looks back on
_FRICTIONS = (0.2, 0.4, 0.8)
_USED = (0.3, 0.6, 0.9)
_APART = 1.05  # friction above and below
_LEAST_CHANGE = 1e-4  # of the stick ratio: below it nothing is to be told


def floors(
    problem: ContactProblem,
    face: str,
    normal_forces: Sequence[float],
    noise: float,
    tell: Callable[[str], None] = lambda message: None,
) -> tuple[Floor, ...]:
    """Medians over frictions and shares of friction in use, for each normal force (N).

    Forces at which the model finds no state are left out. Raises SolverError for silent gages.
    """
    found = []
    for normal in normal_forces:
        tell(f"the least error at {normal:.3g} N")
        states = [each for mu in _FRICTIONS for each in _states(problem, face, normal, mu)]
        if states:
            change = float(np.median(states))  # microstrain per unit of stick ratio
            if not change > 0.0:
                raise SolverError("no gage answers to anything: their strains are all 0")
            found.append(Floor(normal, change, noise / change, noise / change / WINDOW**0.5))
    return tuple(found)


def _states(problem: ContactProblem, face: str, normal: float, friction: float) -> list[float]:
    """|de/dS|, microstrain, along one pull."""
    above = _pull(problem.with_friction(friction * _APART), face, normal, friction)
    below = _pull(problem.with_friction(friction / _APART), face, normal, friction)
    return [
        float(np.linalg.norm(more[0] - less[0])) / abs(more[1] - less[1])
        for more, less in zip(above, below, strict=False)
        if abs(more[1] - less[1]) > _LEAST_CHANGE
    ]


def _pull(
    problem: ContactProblem, face: str, normal: float, friction: float
) -> list[tuple[Array, float]]:
    """Readings and stick ratio at each share of the friction limit, as far as it is carried."""
    state, found = ContactState.untouched(problem), []
    for used in (0.0, *_USED):
        try:
            increment = solve_forces(problem, state, Forces(normal, used * friction * normal))
        except SolverError:
            break
        state = increment.state
        told = measure(problem, increment)
        if used > 0.0 and told.stick_ratio is not None:
            found.append((gage_readings(told.gages, face), told.stick_ratio))
    return found
