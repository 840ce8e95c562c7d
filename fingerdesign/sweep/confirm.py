"""From quick trials to fingers that are believed: which are analysed again, and what stands then.

The search runs at the study's fidelity. Of its front, those that together dominate most beyond the
reference (the study's base) are analysed at ``confirm_fidelity``, and so is the reference: a
finger is better only where it is better than the reference by the same model.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.sweep.evaluate import Job
from fingerdesign.sweep.optimise import Evaluator, Search, Tried, reference_plan
from fingerdesign.sweep.pareto import beats, hypervolume, most_volume, strictly_beats
from fingerdesign.sweep.recommend import dominated
from fingerdesign.sweep.search_space import told

if TYPE_CHECKING:
    from fingerdesign.sweep.outcome import Outcome
    from fingerdesign.sweep.study_file import Study

MARGIN = 0.1  # of the front's range, beyond its worst end, where no reference bounds the volume


@dataclass(frozen=True)
class Judged:
    """One finger against the study: losses (less is better) in the objectives' order.

    metrics: of each objective and constraint, the worst scene's. failure: "" where it was analysed.
    """

    name: str
    losses: Array
    metrics: dict[str, float | None]
    feasible: bool
    failure: str = ""

    def dominates(self, other: Judged) -> bool:
        """Nowhere worse and somewhere better, and it meets the constraints."""
        return self.feasible and not other.failure and beats(self.losses, other.losses)

    def better_in_all(self, other: Judged) -> bool:
        """Better in every objective, and it meets the constraints."""
        return self.feasible and not other.failure and strictly_beats(self.losses, other.losses)


@dataclass(frozen=True)
class Confirmed:
    """A finger by the quick model and by the thorough one."""

    number: int
    quick: Judged
    thorough: Judged


@dataclass(frozen=True)
class Confirmation:
    """What the search found, and what stands of it.

    fidelity: of the thorough model, "" where nothing was confirmed. reference: by the quick model,
    and by the thorough one (None where nothing was confirmed). front, dominating: numbers of trials
    that none dominates, and that dominate the reference. volumes: hypervolume that the trials up to
    each one dominate, over that of all. outcomes: of the reference and of all confirmations.
    """

    reference: Judged
    front: tuple[int, ...]
    dominating: tuple[int, ...]
    volumes: tuple[float, ...]
    fidelity: str = ""
    thorough_reference: Judged | None = None
    confirmed: tuple[Confirmed, ...] = ()
    outcomes: tuple[Outcome, ...] = ()

    @property
    def standing(self) -> tuple[Confirmed, ...]:
        """Those that dominate the reference by the thorough model, too."""
        known = self.thorough_reference
        return tuple(c for c in self.confirmed if known and c.thorough.dominates(known))


def judged(study: Study, name: str, outcomes: Sequence[Outcome]) -> Judged:
    """The outcomes of a finger, a scene each, as what the study asks."""
    values, broken = told(study, outcomes)
    signs = [1.0 if each.direction == "min" else -1.0 for each in study.objectives]
    failures = [each.failure.sentence for each in outcomes if each.failure is not None]
    wanted = {each.metric: value for each, value in zip(study.objectives, values, strict=True)}
    metrics: dict[str, float | None] = {}
    for metric in (*wanted, *study.constraints):
        found = [each.metrics.get(metric) for each in outcomes]
        absent = None in found or broken["failed"] > 0.0
        metrics[metric] = None if absent else wanted.get(metric, found[0])
    return Judged(
        name,
        np.array(values) * signs,
        metrics,
        feasible=all(excess <= 0.0 for excess in broken.values()),
        failure="; ".join(failures) or ("misses an objective" if broken["failed"] else ""),
    )


def confirm(
    search: Search,
    tried: Sequence[Tried],
    evaluated: Evaluator,
    tell: Callable[[str], None] = lambda message: None,
) -> Confirmation:
    """Analyse the reference and the best trials again. Raises what ``evaluated`` raises."""
    study, table = search.study, search.study.optimise
    name = reference_plan(search)[0].name
    tell("the reference")
    outcomes = list(evaluated(reference_plan(search)))
    reference = judged(study, name, outcomes)
    every = [judged(study, each.outcomes[0].name, each.outcomes) for each in tried]
    front = front_of(every)
    found = Confirmation(
        reference,
        tuple(tried[k].number for k in front),
        tuple(
            each.number for each, own in zip(tried, every, strict=True) if own.dominates(reference)
        ),
        volumes(every, reference),
        outcomes=tuple(outcomes),
    )
    chosen = promising(every, front, reference, table.confirm)
    fidelity = table.confirm_fidelity
    if not chosen or fidelity == study.study.fidelity:
        return found
    plans = [reference_plan(search, fidelity)]
    plans += [_again(search, tried[k], fidelity) for k in chosen]
    tell(f"{len(chosen)} trials and the reference, {fidelity}")
    again = list(evaluated([replace(j, name=f"{j.name}-{fidelity}") for p in plans for j in p]))
    deep, rest = [], list(again)
    for plan in plans:
        deep.append(judged(study, rest[0].name, rest[: len(plan)]))
        del rest[: len(plan)]
    return replace(
        found,
        fidelity=fidelity,
        thorough_reference=deep[0],
        confirmed=tuple(
            Confirmed(tried[k].number, every[k], own)
            for k, own in zip(chosen, deep[1:], strict=True)
        ),
        outcomes=(*again, *outcomes),
    )


def front_of(every: Sequence[Judged]) -> tuple[int, ...]:
    """Places of the feasible fingers that no other feasible one dominates."""
    feasible = [k for k, own in enumerate(every) if own.feasible]
    if not feasible:
        return ()
    worse = dominated(np.array([every[k].losses for k in feasible]))
    return tuple(k for k, out in zip(feasible, worse, strict=True) if not out)


def promising(
    every: Sequence[Judged], front: Sequence[int], reference: Judged, count: int
) -> tuple[int, ...]:
    """Up to ``count`` of the front, that together dominate most; then any others of it.

    The volume ends at the reference where one of them dominates it, else beyond the front.
    """
    if not front or count < 1:
        return ()
    losses = np.array([every[k].losses for k in front])
    low, high = losses.min(axis=0), losses.max(axis=0)
    scale = np.where(high > low, high - low, 1.0)
    corner = (high - low) / scale + MARGIN
    if any(every[k].dominates(reference) for k in front):
        corner = (reference.losses - low) / scale + 1e-9
    scaled = (losses - low) / scale
    taken = most_volume(scaled, corner, count)
    left = sorted(set(range(len(front))) - set(taken), key=lambda k: float(np.sum(scaled[k] ** 2)))
    return tuple(front[k] for k in (*taken, *left)[:count])


def volumes(every: Sequence[Judged], reference: Judged) -> tuple[float, ...]:
    """After each trial, the volume that is dominated so far, over the one at the end.

    0 throughout where none is feasible. It ends where the reference does, or beyond the front.
    """
    front = front_of(every)
    if not front:
        return (0.0,) * len(every)
    losses = np.array([every[k].losses for k in front])
    low, high = losses.min(axis=0), losses.max(axis=0)
    corner = high + MARGIN * np.where(high > low, high - low, 1.0)
    if any(every[k].dominates(reference) for k in front):
        corner = np.maximum(corner, reference.losses)
    whole = hypervolume(losses, corner)
    found, so_far, value = [], np.empty((0, losses.shape[1])), 0.0
    for own in every:
        if own.feasible and not any(beats(each, own.losses) for each in so_far):
            so_far = np.vstack([so_far, own.losses])
            value = hypervolume(so_far, corner)
        found.append(value / whole)
    return tuple(found)


def _again(search: Search, tried: Tried, fidelity: str) -> list[Job]:
    from fingerdesign.sweep.trials import Trial

    trial = Trial(tried.number, tried.outcomes[0].values)
    return [replace(j, fidelity=fidelity) for j in search.plan(trial) if isinstance(j, Job)]
