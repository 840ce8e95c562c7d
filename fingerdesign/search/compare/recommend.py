"""What is wanted of a finger, and which of the outcomes to take: the nearest to the best of all.

Compromise programming (P. L. Yu, A class of solutions for group decision problems, Management
Science 19, 1973): each objective is scaled by its range over the front, 0 its best and 1 its worst;
the point of the front at the least Euclidean distance from all zeros is recommended. Of points
equally near, as two that are all of a front of two objectives, the one that is nearer when scaled
by the range over all that were compared. No objective weighs more than another; whoever sees it
otherwise reads the front.
"""

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError
from typing_extensions import TypedDict

from fingerdesign.arrays import Array
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import closed
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.study.metrics import METRICS, Goal, Metric

# What a comparison must know beside the outcomes: what is wanted, and of which study they are.

GOALS = ("min", "max")
# Without objectives of the user's, the first of these that the outcomes have, up to three.
USUAL_OBJECTIVES = ("stick_error", "grip_success", "peak_ratio", "least_margin", "cost")
MOST_USUAL = 3
LEAST_DEEP = 2  # 3-D outcomes that are enough to choose among


@dataclass(frozen=True)
class Wanted:
    """An objective: a metric, and which end of it is better."""

    metric: str
    goal: Goal


@dataclass(frozen=True)
class Bound:
    """A constraint: what a metric must at least, and at most, be; None: no bound."""

    metric: str
    at_least: float | None = None
    at_most: float | None = None

    def holds(self, outcome: Outcome) -> bool:
        """Whether the outcome has the metric, within the bound."""
        return not self.broken_by(outcome)

    def broken_by(self, outcome: Outcome) -> str:
        """What of the outcome breaks the bound, and by how much; "" where it holds."""
        value = outcome.metrics.get(self.metric)
        if value is None:
            return f"no {self.metric}, asked is {self.words}"
        if self.at_least is not None and value < self.at_least:
            requested, away = f"at least {self.at_least:g}", self.at_least - value
        elif self.at_most is not None and value > self.at_most:
            requested, away = f"at most {self.at_most:g}", value - self.at_most
        else:
            return ""
        return f"{self.metric} {value:.4g}, asked is {requested} (off by {away:.2g})"

    @property
    def words(self) -> str:
        """As "cost <= 40"."""
        low = "" if self.at_least is None else f"{self.at_least:g} <= "
        high = "" if self.at_most is None else f" <= {self.at_most:g}"
        return f"{low}{self.metric}{high}"


@dataclass(frozen=True)
class StudyFacts:
    """The study: a name to head the page, what is wanted, and what repeats it.

    assumed_objectives: the user named none. record: further facts, name -> text (sampling, seed,
    digest of the study, ...). sources: where the outcomes were read.
    """

    name: str
    objectives: tuple[Wanted, ...] = ()
    constraints: tuple[Bound, ...] = ()
    metrics: tuple[Metric, ...] = ()
    assumed_objectives: bool = False
    record: dict[str, str] = field(default_factory=dict)
    sources: tuple[str, ...] = ()


def known_metrics(outcomes: Iterable[Outcome]) -> tuple[Metric, ...]:
    """Facts of every metric that an outcome has: of those known here first, in their order."""
    found = dict.fromkeys(name for outcome in outcomes for name in outcome.metrics)
    ordered = dict.fromkeys([*METRICS, *found])
    return tuple(METRICS.get(name, Metric(name)) for name in ordered if name in found)


def usual_objectives(outcomes: Iterable[Outcome]) -> list[Wanted]:
    """What a finger is wanted for where nobody said: of metrics that every good outcome has."""
    good = [outcome for outcome in outcomes if outcome.status == "ok"]
    found = [
        Wanted(name, better)
        for name in USUAL_OBJECTIVES
        if (better := METRICS[name].better) is not None
        and good
        and all(outcome.metrics.get(name) is not None for outcome in good)
    ]
    return found[:MOST_USUAL]


def why_not(
    outcome: Outcome, objectives: Iterable[Wanted], constraints: Iterable[Bound]
) -> tuple[str, ...]:
    """Why an analysed outcome is not feasible: each objective it lacks, each bound it breaks."""
    if outcome.status != "ok":
        return ()
    lacking = [
        f"no {each.metric}, an objective"
        for each in objectives
        if outcome.metrics.get(each.metric) is None
    ]
    return (*lacking, *filter(None, (bound.broken_by(outcome) for bound in constraints)))


@closed
class _Ends(TypedDict, total=False):
    at_least: float | None
    at_most: float | None


class _Requested(TypedDict, total=False):
    objectives: tuple[Wanted, ...]
    constraints: dict[str, _Ends]


_MUST_BE = {
    "objectives": "{metric, goal = min or max}",
    "constraints": "{at_least, at_most} of numbers",
}


def requested(record: dict[str, Any], source: str) -> tuple[tuple[Wanted, ...], tuple[Bound, ...]]:
    """Objectives, [{metric, goal}], and constraints, {metric: {at_least, at_most}}, of a study's
    record; DesignError for any other."""
    given = {key: record[key] for key in _MUST_BE if record.get(key)}
    try:
        found = TypeAdapter(_Requested).validate_json(json.dumps(given), strict=True)
    except ValidationError as error:
        key, *place = error.errors()[0]["loc"]
        value = given[str(key)]
        where = f"{key}.{place[0]}" if isinstance(value, dict) and place else str(key)
        shown = str(value[place[0]] if place else value)[:200]
        fault = Fault(where, shown, _MUST_BE[str(key)], "run the study again")
        raise DesignError([fault], source) from error
    bounds = (Bound(name, **ends) for name, ends in found.get("constraints", {}).items())
    return found.get("objectives", ()), tuple(bounds)


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
        if outcome.status == "ok" and not why_not(outcome, objectives, constraints)
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
