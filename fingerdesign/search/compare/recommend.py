"""Objectives of a comparison, its Pareto front, and the recommended design.

Compromise programming (P. L. Yu, A class of solutions for group decision problems, Management
Science 19, 1973): each objective is scaled by its range over the front, 0 its best and 1 its worst;
the point of the front at the least Euclidean distance from all zeros is recommended. Of points
equally near, as two that are all of a front of two objectives, the one that is nearer when scaled
by the range over all that were compared. All objectives have
equal weight.

What fails the purpose of a tactile finger is never recommended, however good its other numbers.
And one value is better than another only where they differ by more than ``SHOWN`` standard
deviations of what chance changes in their difference.
"""

import json
import math
from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError
from typing_extensions import TypedDict

from fingerdesign.analysis.detection import UNSEEN_STICK_CHANGE
from fingerdesign.arrays import Array, BoolArray
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import closed
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.study.metrics import METRICS, Goal, Metric

GOALS = ("min", "max")
# Without objectives of the user's, the first of these that the outcomes have, up to three.
USUAL_OBJECTIVES = ("stick_error", "grip_success", "peak_ratio", "least_margin", "cost")
MOST_USUAL = 3
SHOWN = 2.0  # standard deviations: one difference in twenty is that large by chance
GRIPS_MEASURED = 3  # in the grips that Metric.noisy was measured with
LEAST_DEEP = 2  # 3-D outcomes that are enough to choose among
_MUST_BE = {
    "objectives": "{metric, goal = min or max}",
    "constraints": "{at_least, at_most} of numbers",
}


@dataclass(frozen=True)
class Objective:
    """An objective: a metric, and which end of it is better."""

    metric: str
    goal: Goal


@dataclass(frozen=True)
class Bound:
    """A constraint: what a metric must at least, and at most, be; None: no bound."""

    metric: str
    at_least: float | None = None
    at_most: float | None = None

    def broken_by(self, outcome: Outcome) -> str:
        """Describe how the outcome breaks the bound, and by how much; "" where it holds."""
        value = outcome.metrics.get(self.metric)
        if value is None:
            return f"no {self.metric}, required is {self.words}"
        if self.at_least is not None and value < self.at_least:
            requested, away = f"at least {self.at_least:g}", self.at_least - value
        elif self.at_most is not None and value > self.at_most:
            requested, away = f"at most {self.at_most:g}", value - self.at_most
        else:
            return ""
        return f"{self.metric} {value:.4g}, required is {requested} (off by {away:.2g})"

    @property
    def words(self) -> str:
        """The bound as text: "cost <= 40"."""
        low = "" if self.at_least is None else f"{self.at_least:g} <= "
        high = "" if self.at_most is None else f" <= {self.at_most:g}"
        return f"{low}{self.metric}{high}"


@dataclass(frozen=True)
class StudyFacts:
    """A study: its name, objectives, constraints and metrics, and the facts that repeat it.

    assumed_objectives: the user named none. record: further facts, name -> text (sampling, seed,
    digest of the study, ...). sources: where the outcomes were read. best_of: how many outcomes
    large studies have, of which only the best are compared. missing: sentences
    on studies whose file has not all outcomes.
    """

    name: str
    objectives: tuple[Objective, ...] = ()
    constraints: tuple[Bound, ...] = ()
    metrics: tuple[Metric, ...] = ()
    assumed_objectives: bool = False
    record: dict[str, str] = field(default_factory=dict)
    sources: tuple[str, ...] = ()
    best_of: int = 0
    missing: tuple[str, ...] = ()


def known_metrics(outcomes: Iterable[Outcome]) -> tuple[Metric, ...]:
    """Facts of every metric that an outcome has: of those known here first, in their order."""
    found = dict.fromkeys(name for outcome in outcomes for name in outcome.metrics)
    ordered = dict.fromkeys([*METRICS, *found])
    return tuple(METRICS.get(name, Metric(name)) for name in ordered if name in found)


def usual_objectives(outcomes: Iterable[Outcome]) -> list[Objective]:
    """Objectives where the user gave none: of the metrics that every good outcome has."""
    good = [outcome for outcome in outcomes if outcome.status == "ok"]
    good = [outcome for outcome in good if not fails_purpose(outcome)] or good
    found = [
        Objective(name, better)
        for name in USUAL_OBJECTIVES
        if (better := METRICS[name].better) is not None
        and good
        and all(outcome.metrics.get(name) is not None for outcome in good)
    ]
    return found[:MOST_USUAL]


def fails_purpose(outcome: Outcome, bounded: Collection[str] = ()) -> dict[str, str]:
    """Return the purposes of a tactile finger that the outcome fails: name -> sentence.

    A metric that is not known fails nothing, and one that is ``bounded`` is its constraint's to
    judge. An optimisation judges its trials by this, too.
    """
    own = {name: value for name, value in outcome.metrics.items() if name not in bounded}
    found = {}
    if own.get("grip_success") == 0.0:
        found["a grip that lifts"] = "it lifts nothing: no grip is without complete slip"
    change = own.get("smallest_stick_change")
    if own.get("plates") == 0.0:
        found["gages"] = "it has no gages and measures nothing"
    elif change is not None and change >= UNSEEN_STICK_CHANGE:
        found["gages that can be measured"] = (
            f"its gages show a change of the stick ratio from {change:.2g} on; from a safe hold to "
            f"a lost object it changes by {UNSEEN_STICK_CHANGE:g} only"
        )
    return found


def failed_verdicts(outcome: Outcome) -> int:
    """The number of verdicts that the outcome fails; 0 where it is not known."""
    return int(outcome.metrics.get("failed_verdicts") or 0.0)


def passes(outcome: Outcome) -> bool:
    """True if every verdict that was judged passes."""
    return outcome.metrics.get("failed_verdicts") == 0.0


def why_not(
    outcome: Outcome, objectives: Iterable[Objective], constraints: Sequence[Bound]
) -> tuple[str, ...]:
    """List why an analysed outcome is not feasible: each objective it lacks, each bound it breaks,
    each purpose it fails."""
    if outcome.status != "ok":
        return ()
    lacking = [
        f"no {each.metric}, an objective"
        for each in objectives
        if outcome.metrics.get(each.metric) is None
    ]
    broken = filter(None, (bound.broken_by(outcome) for bound in constraints))
    purpose = fails_purpose(outcome, [bound.metric for bound in constraints])
    return (*lacking, *broken, *purpose.values())


def uncertainty(outcome: Outcome, name: str) -> float:
    """Standard deviation of what chance changes in a metric of the outcome, in its own unit.

    0 where it is exact (plates, cost), where it has no value, and where nothing is known of it. Of
    the share of n noisy grips, k of them good, that of a beta distribution after k and n - k
    (Laplace's rule of succession). An estimated error of the mesh is added, in squares.
    """
    metric, value = METRICS.get(name), outcome.metrics.get(name)
    if metric is None or value is None:
        return 0.0
    grips = len(outcome.grips) or GRIPS_MEASURED
    share, step = metric.share, metric.step
    if _noisy(outcome):
        share = metric.noisy * math.sqrt(GRIPS_MEASURED / grips) or share
        if name == "grip_success":
            held = value * grips
            step = math.sqrt((held + 1) * (grips - held + 1) / (grips + 3)) / (grips + 2)
    if not (share or step):
        return 0.0
    mesh = (outcome.validity.mesh_error or 0.0) if share else 0.0
    return math.hypot(share * value, step, mesh * value)


def _noisy(outcome: Outcome) -> bool:
    """Return True where [grip.hardware] gives the controller's signals noise."""
    grip = outcome.design.get("grip")
    hardware = grip.get("hardware") if isinstance(grip, dict) else None
    chances = hardware.items() if isinstance(hardware, dict) else ()
    return any(value for key, value in chances if "noise" in key or key.endswith("_spread"))


@closed
class _Ends(TypedDict, total=False):
    at_least: float | None
    at_most: float | None


class _Requested(TypedDict, total=False):
    objectives: tuple[Objective, ...]
    constraints: dict[str, _Ends]


def requested(
    record: dict[str, Any], source: str
) -> tuple[tuple[Objective, ...], tuple[Bound, ...]]:
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
    """The recommendation; numbers are indices of the given outcomes.

    feasible: meet the constraints and have every objective. group: those that were compared, of one
    scene and fidelity, and only those that pass all verdicts where any does; failing: the others of
    them, then; front: those of the group that none of it dominates; chosen: None where the front is
    empty; best: by objective the front's best, the nearest to ``chosen``'s kind first; alike:
    others of the front, as near as ``chosen``; same: others of the group from which nothing shows
    it to differ, in any objective; runner_up: the next of the front, or of the group where the
    front has one alone. scene, fidelity: the group's.
    """

    feasible: tuple[int, ...] = ()
    group: tuple[int, ...] = ()
    failing: tuple[int, ...] = ()
    front: tuple[int, ...] = ()
    chosen: int | None = None
    best: tuple[int, ...] = ()
    alike: tuple[int, ...] = ()
    same: tuple[int, ...] = ()
    runner_up: int | None = None
    scene: str = ""
    fidelity: str = ""


def recommend(
    outcomes: Sequence[Outcome], objectives: Sequence[Objective], constraints: Sequence[Bound]
) -> Recommendation:
    """Front and recommended finger of those feasible; nothing is chosen without objectives."""
    feasible = tuple(
        number
        for number, each in enumerate(outcomes)
        if each.status == "ok" and not why_not(each, objectives, constraints)
    )
    if not feasible or not objectives:
        return Recommendation(feasible)
    kind = _kind(outcomes, feasible)
    group, failing = _group(outcomes, feasible, kind)
    values, unsure = _losses(outcomes, group, objectives)
    free = ~dominated(values, unsure)
    front = _others(group, free)
    scaled = _scaled(values[free], unsure[free])
    distance = np.round(np.sqrt((scaled**2).sum(axis=1)), 9)
    of_all = np.sqrt((_scaled(values, unsure) ** 2).sum(axis=1))
    # Where nothing shows a difference, the one with the better numbers as they stand.
    as_they_stand = (_scaled(values, 0.0 * unsure) ** 2).sum(axis=1)
    ranked = np.lexsort((as_they_stand[free], of_all[free], distance))
    chosen = front[ranked[0]]
    row = group.index(chosen)
    near_by = np.logical_not(differs(values, unsure, values[row], unsure[row]).any(axis=1))
    next_of = [front[k] for k in ranked]
    if len(front) == 1:
        next_of = [group[k] for k in np.argsort(of_all, kind="stable")]
    return Recommendation(
        feasible,
        group,
        failing,
        front,
        chosen,
        best=tuple(front[np.lexsort((distance, column))[0]] for column in values[free].T),
        alike=_others(front, distance == distance[ranked[0]], chosen),
        same=_others(group, near_by, chosen),
        runner_up=next((number for number in next_of if number != chosen), None),
        scene=kind[0],
        fidelity=kind[1],
    )


def _others(
    numbers: Sequence[int], marked: BoolArray, chosen: int | None = None
) -> tuple[int, ...]:
    """The marked ones of ``numbers`` but ``chosen``."""
    return tuple(k for k, own in zip(numbers, marked, strict=True) if own and k != chosen)


def _losses(
    outcomes: Sequence[Outcome], numbers: Sequence[int], objectives: Sequence[Objective]
) -> tuple[Array, Array]:
    """The objectives, turned so that less is better, and their standard deviations by chance.

    Both are of shape (numbers, objectives).
    """
    signs = np.array([1.0 if each.goal == "min" else -1.0 for each in objectives])
    rows = [[outcomes[k].metrics[each.metric] or 0.0 for each in objectives] for k in numbers]
    chance = [[uncertainty(outcomes[k], each.metric) for each in objectives] for k in numbers]
    return signs * np.array(rows, dtype=float), np.array(chance, dtype=float)


def differs(values: Array, unsure: Array, own: Array, own_unsure: Array) -> BoolArray:
    """Return True where values differ from ``own`` by more than chance; shapes are broadcast.

    >>> differs(np.array([1.0, 1.3]), np.array([0.1, 0.1]), np.array(1.0), np.array(0.1)).tolist()
    [False, True]
    """
    return np.asarray(np.abs(values - own) > SHOWN * np.hypot(unsure, own_unsure))


def dominated(values: Array, unsure: Array | None = None) -> BoolArray:
    """Mark rows that another row dominates: nowhere worse and somewhere shown to be better; less is
    better. unsure: standard deviations of the values; without them each is exact.

    >>> dominated(np.array([[1.0, 2.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]])).tolist()
    [False, False, True, False]
    """
    unsure = np.zeros_like(values) if unsure is None else unsure
    found = np.zeros(len(values), dtype=bool)
    for row, own in enumerate(values):
        better = (values < own) & differs(values, unsure, own, unsure[row])
        found[row] = bool(np.any((values <= own).all(axis=1) & better.any(axis=1)))
    return found


def _kind(outcomes: Sequence[Outcome], feasible: Sequence[int]) -> tuple[str, str]:
    """Scene and fidelity to compare in: of 3-D where it has a choice, else the most frequent; of
    equally frequent ones 3-D."""
    count = Counter((outcomes[number].scene, outcomes[number].fidelity) for number in feasible)
    deep = {key: many for key, many in count.items() if key[1] == "3d" and many >= LEAST_DEEP}
    among = deep or count
    return max(among, key=lambda key: (among[key], key[1] == "3d"))


def _group(
    outcomes: Sequence[Outcome], feasible: Sequence[int], kind: tuple[str, str]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """What is compared of a scene and fidelity: those that pass all verdicts, where any does; and
    the others of it."""
    alike = tuple(k for k in feasible if (outcomes[k].scene, outcomes[k].fidelity) == kind)
    group = tuple(k for k in alike if passes(outcomes[k])) or alike
    return group, tuple(k for k in alike if k not in group)


def _scaled(values: Array, unsure: Array) -> Array:
    """By the range of each column, 0 its least; all 0 where its ends are not shown to differ.

    >>> _scaled(np.array([[2.0, 1.0], [4.0, 3.0]]), np.array([[0.0, 0.0], [0.0, 1.0]])).tolist()
    [[0.0, 0.0], [1.0, 0.0]]
    """
    low, high = values.min(axis=0), values.max(axis=0)
    chance = SHOWN * math.sqrt(2.0) * unsure.max(axis=0)
    width = np.where(high - low > chance, high - low, np.inf)
    scaled: Array = (values - low) / width
    return scaled
