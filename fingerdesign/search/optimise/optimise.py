"""The search for better fingers: draw a few trials, evaluate them together, learn, go on.

Optuna's TPE proposes (S. Watanabe, Tree-structured Parzen estimator, arXiv:2304.11127, 2023; for
several objectives Y. Ozaki et al., J. Artif. Intell. Res. 73, 2022; constraints by
their excess). A variant that cannot exist is reported as infeasible and costs nothing. Trials are
drawn ``batch`` at a time and reported only when all of them are done: what is drawn does not hang
on which worker is quicker, nor on interruptions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.checks.load import with_values
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.optimise.trials import Trial, Trials, reported
from fingerdesign.search.run.evaluate import Job
from fingerdesign.search.run.run import Planned, planned_variant
from fingerdesign.search.study.values import value_of
from fingerdesign.search.study.variants import Variant, variant_of

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.search.study.file import Study

BATCH = 8  # keeps 2 to 4 cores busy; what it learns from is that much older

# Jobs to their outcomes, in order (run.run_jobs on a cluster); what is stored costs nothing.
Evaluator = Callable[[Sequence[Planned]], Sequence[Outcome]]


@dataclass(frozen=True)
class Tried:
    """A trial with what came of it, an outcome a scene."""

    number: int
    outcomes: tuple[Outcome, ...]


@dataclass(frozen=True)
class Search:
    """What an optimisation has: the study, its base with [fixed] set, its scenes by name."""

    study: Study
    base: Design
    scenes: Mapping[str, Scene | None]

    def plan(self, trial: Trial) -> list[Planned]:
        """The jobs of a trial, a scene each; one outcome where it is no finger."""
        variant = variant_of(self.study, self.base, trial.number, trial.values)
        return planned_variant(self.study, variant, self.scenes)


def searched(
    search: Search,
    kept: Trials,
    evaluated: Evaluator,
    trials: int | None = None,
    batch: int = BATCH,
    report: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[Tried, ...]:
    """All trials of the study, those of earlier runs too, in order.

    kept: the trials on disk, open, and closed to other processes as long as the caller holds them;
    trials: how many in all (None: the study's). report: how many are done, and of how many. Raises
    JournalError, and whatever ``evaluated`` raises: run again, it goes on.
    """
    most = search.study.optimise.trials if trials is None else trials
    found: dict[int, Tried] = {}
    while True:
        drawn, waiting = kept.drawn(), kept.waiting()
        report(len(drawn) - len(waiting), max(most, len(drawn)))
        missing = _to_draw(len(drawn), len(waiting), most, batch)
        if missing:
            kept.draw(missing)
            waiting = kept.waiting()
        if not waiting:
            break
        for tried in _evaluated(search, waiting, evaluated):
            kept.report(tried.number, *reported(search.study, tried.outcomes))
            found[tried.number] = tried
    earlier = [trial for trial in kept.drawn() if trial.number not in found]
    found |= {tried.number: tried for tried in _evaluated(search, earlier, evaluated)}
    return tuple(found[number] for number in sorted(found))


def refuse_aimless(study: Study) -> None:
    """DesignError for a study without objectives."""
    if not study.objectives:
        remedy = 'write [[objectives]] with metric = "stick_error", and others'
        raise DesignError([Fault("objectives", "(absent)", "at least one objective", remedy)])


def _to_draw(drawn: int, waiting: int, most: int, batch: int) -> int:
    """How many trials to draw now: to the end of the batch, unless some wait for theirs."""
    begun = drawn % batch
    if waiting and (begun == 0 or waiting < begun):
        return 0
    return max(0, min(batch - begun, most - drawn))


def _evaluated(search: Search, trials: Sequence[Trial], evaluated: Evaluator) -> list[Tried]:
    """The trials with their outcomes."""
    plans = [search.plan(trial) for trial in trials]
    outcomes = list(evaluated([each for plan in plans for each in plan]))
    found = []
    for trial, plan in zip(trials, plans, strict=True):
        found.append(Tried(trial.number, tuple(outcomes[: len(plan)])))
        del outcomes[: len(plan)]
    return found


def reference_plan(search: Search, fidelity: str | None = None) -> list[Job]:
    """The jobs of the study's base itself, named reference-BASE: what trials are to beat."""
    stem = re.sub(r"[^A-Za-z0-9_-]", "-", Path(search.study.study.base).stem)[:50]
    design = with_values(search.base, {"design.name": f"reference-{stem}"})
    values = {key: value_of(design, key) for key in search.study.parameters if "/" not in key}
    known = {key: value for key, value in values.items() if value is not None}
    variant = Variant(0, design.design.name, known, design)
    plan = planned_variant(search.study, variant, search.scenes)
    jobs = [job for job in plan if isinstance(job, Job)]
    return [replace(job, fidelity=fidelity or job.fidelity) for job in jobs]
