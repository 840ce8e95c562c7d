"""The search for better fingers: draw a few trials, evaluate them together, learn, go on.

A model of the known trials proposes the next (propose.py). A variant that cannot exist is reported
as infeasible and costs nothing. Trials are drawn ``batch`` at a time and reported only when all of
them are done: the draws depend neither on the speed of workers nor on interruptions.
"""

import itertools
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fingerdesign.checks.load import with_values
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.compare.recommend import fails_purpose
from fingerdesign.search.optimise.propose import MOST_EXCESS
from fingerdesign.search.optimise.trials import FAILED, PURPOSE, Trial, Trials
from fingerdesign.search.run.evaluate import Job
from fingerdesign.search.run.run import Planned, planned
from fingerdesign.search.study.file import Study
from fingerdesign.search.study.values import value_of
from fingerdesign.search.study.variants import Variant, variant_of

ABSENT = 1e9  # The loss of a failed trial: no result is as large.
BATCH = 4  # So many trials keep 2 to 4 cores busy; the model learns one batch late.
# Jobs to their outcomes, in order (run.run_jobs on a cluster); what is stored costs nothing.
Evaluator = Callable[[Sequence[Planned]], Sequence[Outcome]]


def lacks(study: Study, outcomes: Sequence[Outcome]) -> dict[str, str]:
    """Return the purposes that a trial fails in any scene, by the rule of ``compare``: name ->
    sentence."""
    found: dict[str, str] = {}
    for each in outcomes:
        if each.status == "ok":
            found |= fails_purpose(each, study.constraints)
    return found


def reported(study: Study, outcomes: Sequence[Outcome]) -> tuple[list[float], dict[str, float]]:
    """Objectives, and constraints (above 0: broken), of a trial's outcomes: the worst scene's.

    What failed or misses an objective is infeasible; its objectives are the worst there are. What
    fails its purpose (:func:`lacks`) is infeasible too, by one for each thing that it lacks.
    """
    values = []
    for objective in study.objectives:
        known = [v for each in outcomes if (v := each.metrics.get(objective.metric)) is not None]
        if len(known) < len(outcomes) or any(each.status != "ok" for each in outcomes):
            worst = [ABSENT if each.direction == "min" else -ABSENT for each in study.objectives]
            every = (PURPOSE, *study.constraints)
            return worst, {FAILED: 1.0} | dict.fromkeys(every, MOST_EXCESS)
        values.append(max(known) if objective.direction == "min" else min(known))
    broken = {
        name: min(max(bound.excess(each.metrics.get(name)) for each in outcomes), MOST_EXCESS)
        for name, bound in study.constraints.items()
    }
    return values, {FAILED: 0.0, PURPOSE: float(len(lacks(study, outcomes)))} | broken


@dataclass(frozen=True)
class Tried:
    """A trial with what came of it, an outcome a scene."""

    number: int
    outcomes: tuple[Outcome, ...]


@dataclass(frozen=True)
class Search:
    """Input of an optimisation: the study, its base with [fixed] set, its scenes by name."""

    study: Study
    base: Design
    scenes: Mapping[str, Scene | None]

    def plan(self, trial: Trial) -> list[Planned]:
        """The jobs of a trial, a scene each; one outcome where it is no finger."""
        variant = variant_of(self.study, self.base, trial.number, trial.values)
        return list(planned(self.study, [variant], self.scenes))


def searched(
    search: Search,
    journal: Trials,
    evaluated: Evaluator,
    trials: int | None = None,
    batch: int = BATCH,
    report: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[Tried, ...]:
    """All trials of the study, those of earlier runs too, in order.

    journal: the trials on disk, open and locked by the caller. trials: number in all (None: the
    study's). report: receives how many are done, and of how many. Raises JournalError, and
    whatever ``evaluated`` raises: run again, it goes on.
    """
    most = search.study.optimise.trials if trials is None else trials
    found: dict[int, Tried] = {}

    def evaluate(some: Sequence[Trial]) -> None:
        for tried in _evaluated(search, some, evaluated) if some else ():
            journal.report(tried.number, *reported(search.study, tried.outcomes))
            found[tried.number] = tried

    waiting = journal.drawn(waiting=True)
    # Those of earlier runs, first: what failed then may be analysed now.
    evaluate([trial for trial in journal.drawn() if trial not in waiting])
    while True:
        drawn, waiting = journal.drawn(), journal.drawn(waiting=True)
        report(len(drawn) - len(waiting), max(most, len(drawn)))
        missing = _to_draw(len(drawn), len(waiting), most, batch)
        if missing:
            journal.draw(missing)
            waiting = journal.drawn(waiting=True)
        if not waiting:
            break
        evaluate(waiting)
    return tuple(found[number] for number in sorted(found))


def refuse_aimless(study: Study, file: Path) -> None:
    """DesignError for a study without objectives."""
    if not study.objectives:
        remedy = 'write [[objectives]] with metric = "stick_error", and others'
        fault = Fault("objectives", "(absent)", "at least one objective", remedy)
        raise DesignError([fault], str(file))


def _to_draw(drawn: int, waiting: int, most: int, batch: int) -> int:
    """Number of trials to draw now: to the end of the batch, unless some wait for theirs."""
    begun = drawn % batch
    if waiting and (begun == 0 or waiting < begun):
        return 0
    return max(0, min(batch - begun, most - drawn))


def _evaluated(search: Search, trials: Sequence[Trial], evaluated: Evaluator) -> list[Tried]:
    plans = [search.plan(trial) for trial in trials]
    rest = iter(evaluated([each for plan in plans for each in plan]))
    return [
        Tried(trial.number, tuple(itertools.islice(rest, len(plan))))
        for trial, plan in zip(trials, plans, strict=True)
    ]


def reference_plan(search: Search, fidelity: str | None = None) -> list[Job]:
    """The jobs of the study's base itself, named reference-BASE: what trials are to beat."""
    stem = re.sub(r"[^A-Za-z0-9_-]", "-", Path(search.study.study.base).stem)[:50]
    design = with_values(search.base, {"design.name": f"reference-{stem}"})
    values = {key: value_of(design, key) for key in search.study.parameters if "/" not in key}
    known = {key: value for key, value in values.items() if value is not None}
    variant = Variant(0, design.design.name, known, design)
    plan = planned(search.study, [variant], search.scenes)
    jobs = [job for job in plan if isinstance(job, Job)]
    return [replace(job, fidelity=fidelity or job.fidelity) for job in jobs]
