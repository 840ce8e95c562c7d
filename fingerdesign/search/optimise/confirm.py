"""Confirmation of the best quick trials by a more thorough model.

The search runs at the study's fidelity. Of its front, those that together dominate most beyond the
reference (the study's base) are analysed at ``confirm_fidelity``, and so is the reference: a
finger is better only where it is better than the reference by the same model.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from itertools import chain, islice
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.compare.recommend import dominated, failed_verdicts
from fingerdesign.search.optimise.optimise import (
    Evaluator,
    Search,
    Tried,
    lacks,
    reference_plan,
    reported,
)
from fingerdesign.search.optimise.propose import MOST_LISTED
from fingerdesign.search.optimise.sensitivity import Sensitivity, sensitivities
from fingerdesign.search.optimise.trials import Trial
from fingerdesign.search.optimise.volume import beats, hypervolume, most_volume
from fingerdesign.search.run.evaluate import Job
from fingerdesign.search.study.file import Study
from fingerdesign.search.study.variants import combinations

MARGIN = 0.1  # of the front's range, beyond its worst end, where no reference bounds the volume


@dataclass(frozen=True)
class Judged:
    """One finger against the study: losses (less is better) in the objectives' order.

    metrics: of each objective and constraint, the worst scene's. failure: "" where it was analysed.
    lacks: what it is for and is not, with a sentence each; feasible is what lacks nothing and meets
    the constraints. fails: number of verdicts that it fails, where they were judged.
    """

    name: str
    losses: Array
    metrics: dict[str, float | None]
    feasible: bool
    failure: str = ""
    lacks: Mapping[str, str] = field(default_factory=dict)
    fails: int = 0

    def dominates(self, other: Judged) -> bool:
        """Nowhere worse and somewhere better, and it is feasible."""
        return self.feasible and not other.failure and beats(self.losses, other.losses)

    def better_in_all(self, other: Judged) -> bool:
        """Better in every objective, and it is feasible."""
        return self.feasible and not other.failure and bool((self.losses < other.losses).all())

    def data(self) -> dict[str, Any]:
        """For study.json and scripts."""
        own = {"name": self.name, "metrics": self.metrics, "feasible": self.feasible}
        return own | {"failure": self.failure or None, "fails_purpose": list(self.lacks.values())}


@dataclass(frozen=True)
class Confirmed:
    """A finger by the quick model and by the thorough one."""

    number: int
    quick: Judged
    thorough: Judged


@dataclass(frozen=True)
class Optimised:
    """A search that is done: its results, and those that were confirmed.

    judged: the trials against the study, in order. reference: by the quick model, and by the
    thorough one (None where nothing was confirmed, and fidelity, of the thorough model, is "").
    front, dominating: numbers of trials that none dominates, and that dominate the reference.
    volumes: hypervolume that the trials up to each one dominate, over that of all. again: outcomes
    of the reference and of all confirmations.
    """

    search: Search
    tried: tuple[Tried, ...]
    judged: tuple[Judged, ...]
    reference: Judged
    front: tuple[int, ...]
    dominating: tuple[int, ...]
    volumes: tuple[float, ...]
    fidelity: str = ""
    thorough_reference: Judged | None = None
    confirmed: tuple[Confirmed, ...] = ()
    again: tuple[Outcome, ...] = ()

    @property
    def standing(self) -> tuple[Confirmed, ...]:
        """Trials that dominate the reference by the thorough model, too."""
        known = self.thorough_reference
        return tuple(c for c in self.confirmed if known and c.thorough.dominates(known))

    @property
    def needs_confirming(self) -> bool:
        """True where a more thorough model than that of the trials could say otherwise."""
        return self.search.study.study.fidelity == "plane-strain"

    @property
    def better_in_all(self) -> int:
        """Number of confirmed fingers that are better in every objective."""
        deep = self.thorough_reference
        return sum(deep is not None and c.thorough.better_in_all(deep) for c in self.standing)

    @property
    def outcomes(self) -> tuple[Outcome, ...]:
        """All: the reference and confirmations first, then trials."""
        return (*self.again, *chain.from_iterable(each.outcomes for each in self.tried))

    @cached_property
    def sensitivities(self) -> tuple[Sensitivity, ...]:
        """Sensitivities of each objective to each parameter, over the trials of the first scene."""
        return sensitivities(self.search.study, [each.outcomes[0] for each in self.tried])

    def counts(self) -> dict[str, int]:
        """Trials, and of them those that are no finger, that failed, and that are feasible."""
        failures = [
            next((o.failure.kind for o in each.outcomes if o.failure is not None), "")
            for each in self.tried
        ]
        return {
            "trials": len(self.tried),
            "invalid": failures.count("invalid"),
            "failed": sum(kind not in ("", "invalid") for kind in failures),
            "fail_purpose": sum(bool(each.lacks) for each in self.judged),
            "front": len(self.front),
            "dominate_reference": len(self.dominating),
            "confirmed": len(self.standing),
        }

    def sentences(self) -> Iterator[str]:
        """Counts of the trials, the reference's own faults, and what was confirmed."""
        counts, reference = self.counts(), self.reference
        goals = " and ".join(
            f"{'lowest' if each.direction == 'min' else 'highest'} {each.metric}"
            for each in self.search.study.objectives
        )
        yield (
            f"{many(counts['trials'], 'trial', 'trials')} ({counts['invalid']} no finger, "
            f"{counts['failed']} failed) for {goals}: {counts['front']} on the front, "
            f"{many(counts['dominate_reference'], 'dominates', 'dominate')} {reference.name}."
        )
        every = combinations(self.search.study, MOST_LISTED)
        if every is not None and len(every) == counts["trials"]:
            yield "These trials are all combinations that the parameters have."
        lacked = Counter(lack for each in self.judged for lack in each.lacks)
        if lacked:
            fail = many(counts["fail_purpose"], "trial fails", "trials fail")
            verb = "is" if counts["fail_purpose"] == 1 else "are"
            lacking = ", ".join(f"{what} ({count})" for what, count in lacked.items())
            yield (
                f"{fail} the purpose of a finger, as compare judges it, and {verb} not feasible; "
                f"lacking: {lacking}."
            )
        if reference.failure:
            yield f"The reference could not be analysed: {reference.failure}"
        elif reference.lacks:
            yield f"The reference itself fails its purpose: {'; '.join(reference.lacks.values())}."
        elif not reference.feasible:
            yield "The reference itself misses a constraint."
        if self.thorough_reference is None:
            if self.needs_confirming:
                yield "Nothing was confirmed by a more thorough model."
            return
        confirmed = len(self.standing)
        yield (
            f"Analysed again by {self.fidelity}, as the reference was, {confirmed} of "
            f"{len(self.confirmed)} {'dominates' if confirmed == 1 else 'dominate'} it there too, "
            f"{self.better_in_all} in every objective."
        )

    def data(self) -> dict[str, Any]:
        """For study.json and scripts."""
        names = {each.number: each.outcomes[0].name for each in self.tried}
        deep = self.thorough_reference
        return {
            **self.counts(),
            "reference": self.reference.data(),
            "front_names": [names[number] for number in self.front],
            "dominating_names": [names[number] for number in self.dominating],
            "confirm_fidelity": self.fidelity,
            "thorough_reference": None if deep is None else deep.data(),
            "confirmations": [
                {
                    "trial": each.number,
                    "quick": each.quick.data(),
                    "thorough": each.thorough.data(),
                    "dominates": deep is not None and each.thorough.dominates(deep),
                    "better_in_all": deep is not None and each.thorough.better_in_all(deep),
                }
                for each in self.confirmed
            ],
            "volumes": [round(each, 6) for each in self.volumes],
            "sensitivities": [asdict(each) | {"words": each.words} for each in self.sensitivities],
            "sentences": list(self.sentences()),
        }


def many(count: int, one: str, more: str) -> str:
    """A number of things in words."""
    return f"{count} {one if count == 1 else more}"


def judge(study: Study, outcomes: Sequence[Outcome]) -> Judged:
    """Judge the outcomes of a finger, one for each scene, against the study.

    metrics: objectives and constraints, those of the scene where they are worst.
    """
    values, broken = reported(study, outcomes)
    signs = [1.0 if each.direction == "min" else -1.0 for each in study.objectives]
    objectives = dict(zip((each.metric for each in study.objectives), values, strict=True))
    metrics: dict[str, float | None] = {}
    for metric in (*objectives, *study.constraints):
        known = [v for each in outcomes if (v := each.metrics.get(metric)) is not None]
        absent = len(known) < len(outcomes) or broken["failed"] > 0.0
        worst = objectives.get(metric)
        if worst is None and not absent:
            worst = max(known, key=study.constraints[metric].beyond)
        metrics[metric] = None if absent else worst
    return Judged(
        outcomes[0].name,
        np.array(values) * signs,
        metrics,
        feasible=all(excess <= 0.0 for excess in broken.values()),
        failure=_failure(outcomes, broken["failed"] > 0.0),
        lacks=lacks(study, outcomes),
        fails=max(map(failed_verdicts, outcomes)),
    )


def _failure(outcomes: Sequence[Outcome], failed: bool) -> str:
    """The sentences of the outcomes that failed, or that an objective is missing; "" else."""
    failures = [each.failure.sentence for each in outcomes if each.failure is not None]
    return "; ".join(failures) or ("misses an objective" if failed else "")


def confirm(
    search: Search,
    tried: Sequence[Tried],
    evaluated: Evaluator,
    report: Callable[[str], None] = lambda message: None,
) -> Optimised:
    """Analyse the reference and the best trials again. Raises what ``evaluated`` raises."""
    study, table = search.study, search.study.optimise
    report("the reference")
    outcomes = tuple(evaluated(reference_plan(search)))
    reference = judge(study, outcomes)
    every = tuple(judge(study, each.outcomes) for each in tried)
    front = front_of(every)
    found = Optimised(
        search,
        tuple(tried),
        every,
        reference,
        tuple(tried[k].number for k in front),
        tuple(tried[k].number for k, own in enumerate(every) if own.dominates(reference)),
        volumes(every, reference),
        again=outcomes,
    )
    chosen = promising(every, front, reference, table.confirm)
    fidelity = table.confirm_fidelity
    if not chosen or fidelity == study.study.fidelity:
        return found
    report(f"{len(chosen)} trials and the reference, {fidelity}")
    plans = [reference_plan(search, fidelity)]
    plans += [_again(search, tried[k], fidelity) for k in chosen]
    jobs = [replace(j, name=f"{j.name}-{fidelity}") for j in chain.from_iterable(plans)]
    again = evaluated(jobs)
    rest = iter(again)
    thorough, *deep = [judge(study, [*islice(rest, len(plan))]) for plan in plans]
    pairs = zip(chosen, deep, strict=True)
    return replace(
        found,
        fidelity=fidelity,
        thorough_reference=thorough,
        confirmed=tuple(Confirmed(tried[k].number, every[k], own) for k, own in pairs),
        again=(*again, *outcomes),
    )


def front_of(every: Sequence[Judged]) -> tuple[int, ...]:
    """Places of the feasible fingers that no other feasible one dominates."""
    feasible = [k for k, own in enumerate(every) if own.feasible]
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
    trial = Trial(tried.number, tried.outcomes[0].values)
    return [replace(j, fidelity=fidelity) for j in search.plan(trial) if isinstance(j, Job)]
