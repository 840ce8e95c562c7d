"""The choice of gages: backward elimination, layouts without a search, and the least error.

The least error of any unbiased estimate from the gages is Cramér and Rao's bound, by the change of
readings with the stick ratio (analysis/detection.py).
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from fingerdesign.analysis.detection import stick_changes
from fingerdesign.arrays import Array
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.features import LAGS
from fingerdesign.errors import SolverError
from fingerdesign.runtime.progress import Report
from fingerdesign.validate.gages.learners import Errors, QuickLearner
from fingerdesign.validate.gages.record import Floor

WINDOW = max(LAGS) + 1  # The estimator looks back on so many samples.
_FRICTIONS = (0.2, 0.4, 0.8)
_ONE_BY_ONE = 12  # While more gages than this are left, two go at a time.

Chosen = tuple[int, ...]  # numbers of gages, rising


@dataclass(frozen=True)
class Elimination:
    """Gages removed one after the other, the least important first.

    sets: remaining gages -> errors, from all to none. without: for each gage the errors of all
    others. order: the gages as they were removed; the last is the most important.
    """

    sets: dict[Chosen, Errors]
    without: tuple[Errors, ...]
    order: Chosen

    @property
    def counts(self) -> dict[int, Chosen]:
        """The remaining gages, by their number."""
        return {len(each): each for each in self.sets}


def eliminate(learner: QuickLearner, gages: int, pool: Executor, report: Report) -> Elimination:
    """Remove the least important gages, by refitting without each in turn."""
    left: Chosen = tuple(range(gages))
    sets = {left: learner.errors(left)}
    order: list[int] = []
    without: tuple[Errors, ...] = ()
    while left:
        report(f"ranking gages: {len(left)} left of {gages}")
        rest = [tuple(k for k in left if k != each) for each in left]
        found = list(pool.map(learner.errors, rest))
        without = without or tuple(found)
        cheapest = np.argsort([each.both for each in found], kind="stable")
        out = [left[k] for k in cheapest[: 2 if len(left) > _ONE_BY_ONE else 1]]
        order += out
        left = tuple(k for k in left if k not in out)
        known = dict(zip(rest, found, strict=True))
        sets[left] = known[left] if left in known else learner.errors(left)
    return Elimination(sets, without, tuple(order))


def layouts(gage_x: Array, count: int) -> dict[str, Chosen]:
    """Place ``count`` of the gages at ``gage_x`` (mm) without a search.

    "spread": evenly over the array; "middle": neighbours about x = 0; "ends": half at each end.
    """
    order = np.argsort(gage_x, kind="stable")
    rank = np.arange(len(gage_x))
    even = np.unique(np.round(np.linspace(0, len(rank) - 1, count)).astype(int))
    near = rank[np.argsort(np.abs(gage_x[order]), kind="stable")[:count]]
    ends = [*rank[: (count + 1) // 2], *rank[len(rank) - count // 2 :]]
    return {
        name: tuple(sorted(int(order[k]) for k in places))
        for name, places in (("spread", even), ("middle", near), ("ends", ends))
    }


def floors(
    problem: ContactProblem,
    face: str,
    normal_forces: Sequence[float],
    noise: float,
    report: Report = lambda message: None,
) -> tuple[Floor, ...]:
    """Find the least error at each normal force (N): medians over frictions and utilisations.

    Forces at which the model finds no state are left out. Raises SolverError for gages that do not
    respond.
    """
    found = []
    for normal in normal_forces:
        report(f"the least error at {normal:.3g} N")
        states = [c for mu in _FRICTIONS for c in stick_changes(problem, face, normal, mu)]
        if states:
            change = float(np.median(states))
            if not change > 0.0:
                raise SolverError("no gage responds: all strains are 0")
            found.append(Floor(normal, change, noise / change, noise / change / WINDOW**0.5))
    return tuple(found)
