"""Which of the outcomes to take: the Pareto front, and the finger nearest to the best of all.

Compromise programming (P. L. Yu, A class of solutions for group decision problems, Management
Science 19, 1973): each objective is scaled by its range over the front, 0 its best and 1 its worst;
the point of the front at the least Euclidean distance from all zeros is recommended. Of points
equally near, as two that are all of a front of two objectives, the one that is nearer when scaled
by the range over all that were compared. No objective weighs more than another; whoever sees it
otherwise reads the front.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.compare.facts import Bound, Wanted

LEAST_DEEP = 2  # 3-D outcomes that are enough to choose among


@dataclass(frozen=True)
class Recommendation:
    """What is recommended; numbers are places among the outcomes given.

    feasible: meet the constraints and have every objective. group: those that were compared, of one
    scene and fidelity; front: those of the group that none of it dominates; chosen: None where the
    front is empty; best: by objective the front's best, the nearest to ``chosen``'s kind first.
    alike: others of the front, as near as ``chosen``. runner_up: the next of the front, or of the
    group where the front has one alone. scene, fidelity: the group's.
    """

    feasible: tuple[int, ...] = ()
    group: tuple[int, ...] = ()
    front: tuple[int, ...] = ()
    chosen: int | None = None
    best: tuple[int, ...] = ()
    alike: tuple[int, ...] = ()
    runner_up: int | None = None
    scene: str = ""
    fidelity: str = ""


def recommend(
    outcomes: Sequence[Outcome], objectives: Sequence[Wanted], constraints: Sequence[Bound]
) -> Recommendation:
    """Front and recommended finger of those feasible; nothing is chosen without objectives."""
    feasible = tuple(
        number
        for number, outcome in enumerate(outcomes)
        if outcome.status == "ok"
        and all(outcome.metrics.get(each.metric) is not None for each in objectives)
        and all(bound.holds(outcome) for bound in constraints)
    )
    if not feasible or not objectives:
        return Recommendation(feasible)
    scene, fidelity = _group(outcomes, feasible)
    group = tuple(
        number
        for number in feasible
        if (outcomes[number].scene, outcomes[number].fidelity) == (scene, fidelity)
    )
    values = losses(outcomes, group, objectives)
    free = ~dominated(values)
    front = tuple(number for number, kept in zip(group, free, strict=True) if kept)
    scaled = _scaled(values[free])
    distance = np.round(np.sqrt((scaled**2).sum(axis=1)), 9)
    of_all = np.sqrt((_scaled(values) ** 2).sum(axis=1))
    ranked = np.lexsort((of_all[free], distance))
    first = int(ranked[0])
    chosen = front[first]
    near = np.flatnonzero(distance == distance[first])
    alike = tuple(front[k] for k in near if k != first)
    best = tuple(
        front[int(np.lexsort((distance, scaled[:, column]))[0])]
        for column in range(scaled.shape[1])
    )
    if len(front) > 1:
        second: int | None = front[int(ranked[1])]
    else:
        others = [number for _, number in sorted(zip(of_all.tolist(), group, strict=True))]
        second = next((number for number in others if number != chosen), None)
    return Recommendation(feasible, group, front, chosen, best, alike, second, scene, fidelity)


def losses(
    outcomes: Sequence[Outcome], numbers: Sequence[int], objectives: Sequence[Wanted]
) -> Array:
    """The objectives, turned so that less is better: shape (numbers, objectives)."""
    signs = [1.0 if each.goal == "min" else -1.0 for each in objectives]
    return np.array(
        [
            [
                sign * float(outcomes[number].metrics[each.metric] or 0.0)
                for sign, each in zip(signs, objectives, strict=True)
            ]
            for number in numbers
        ]
    )


def dominated(values: Array) -> NDArray[np.bool_]:
    """Which rows another row is nowhere worse than and somewhere better; less is better.

    >>> dominated(np.array([[1.0, 2.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]])).tolist()
    [False, False, True, False]
    """
    found = np.zeros(len(values), dtype=bool)
    for row, own in enumerate(values):
        found[row] = bool(np.any((values <= own).all(axis=1) & (values < own).any(axis=1)))
    return found


def _group(outcomes: Sequence[Outcome], feasible: Sequence[int]) -> tuple[str, str]:
    """Scene and fidelity to compare in: of 3-D where it has a choice, else the most frequent."""
    count = Counter((outcomes[number].scene, outcomes[number].fidelity) for number in feasible)
    deep = {key: many for key, many in count.items() if key[1] == "3d" and many >= LEAST_DEEP}
    among = deep or count
    return max(among, key=lambda key: among[key])


def _scaled(values: Array) -> Array:
    low, high = values.min(axis=0), values.max(axis=0)
    width = np.where(high > low, high - low, 1.0)
    scaled: Array = (values - low) / width
    return scaled
