"""The search for better fingers: draw a few trials, evaluate them together, learn, go on.

Optuna's TPE proposes (S. Watanabe, Tree-structured Parzen estimator, arXiv:2304.11127, 2023; for
several objectives Y. Ozaki et al., J. Artif. Intell. Res. 73, 2022; constraints by
their excess). A variant that cannot exist is reported as infeasible and costs nothing. Trials are
drawn ``batch`` at a time and reported only when all of them are done: what is drawn does not hang
on which worker is quicker, nor on interruptions.
"""

import hashlib
import itertools
import os
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from fingerdesign.checks.load import with_values
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.outcome import Outcome
from fingerdesign.runtime.journal import JournalError, held
from fingerdesign.search.compare.recommend import fails_purpose
from fingerdesign.search.run.evaluate import Job
from fingerdesign.search.run.run import Planned, planned
from fingerdesign.search.study.file import Limits, Optimise, Study
from fingerdesign.search.study.metrics import METRICS_VERSION
from fingerdesign.search.study.values import Choice, Parameter, Range, value_of
from fingerdesign.search.study.variants import Variant, variant_of
from fingerdesign.version import __version__

# Trials on disk: Optuna's study in a journal, which an interrupted optimisation goes on from.
#
# What is drawn for a trial hangs on the study's seed, the trial's number and the trials that were
# reported before it, so that one that was interrupted ends as one that was not. One process at a
# time writes a journal; the work itself is done in parallel by the evaluator.

ABSENT = 1e9  # the loss reported where there is none: finite, as Optuna wants it; never a result
_FAILED, _PURPOSE, _MOST_EXCESS = "failed", "purpose", 1e6


def lacks(study: Study, outcomes: Sequence[Outcome]) -> dict[str, str]:
    """What a finger is for and a trial is not, by the rule of ``compare``: what it lacks in any
    scene -> a sentence."""
    analysed = (each for each in outcomes if each.status == "ok")
    return {
        lack: said
        for each in analysed
        for lack, said in fails_purpose(each, study.constraints).items()
    }


def reported(study: Study, outcomes: Sequence[Outcome]) -> tuple[list[float], dict[str, float]]:
    """Objectives, and constraints (above 0: broken), of a trial's outcomes: the worst scene's.

    What failed or misses an objective is infeasible; its objectives are the worst there are. What
    fails its purpose (:func:`lacks`) is infeasible too, by one for each thing that it lacks.
    """
    values = []
    for wanted in study.objectives:
        found = [outcome.metrics.get(wanted.metric) for outcome in outcomes]
        known = [value for value in found if value is not None]
        if len(known) < len(found) or any(each.status != "ok" for each in outcomes):
            worst = [ABSENT if each.direction == "min" else -ABSENT for each in study.objectives]
            every = (_PURPOSE, *study.constraints)
            return worst, {_FAILED: 1.0} | dict.fromkeys(every, _MOST_EXCESS)
        values.append(max(known) if wanted.direction == "min" else min(known))
    broken = {
        name: min(max(bound.excess(each.metrics.get(name)) for each in outcomes), _MOST_EXCESS)
        for name, bound in study.constraints.items()
    }
    return values, {_FAILED: 0.0, _PURPOSE: float(len(lacks(study, outcomes)))} | broken


def _distribution(parameter: Parameter) -> Any:
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if not isinstance(parameter, Range):
        return CategoricalDistribution(parameter)
    low, step, log = parameter.low, parameter.step, parameter.log
    levels = parameter.levels
    high = parameter.high if levels is None else low + (step or 1) * (levels - 1)
    if parameter.whole:
        return IntDistribution(int(low), int(high), log=log, step=int(step or 1))
    return FloatDistribution(float(low), float(high), log=log, step=step)


def _value(parameter: Parameter, drawn: Choice) -> Choice:
    if not isinstance(parameter, Range):
        return drawn
    if parameter.whole:
        return int(drawn)
    digits = 6 if parameter.levels is None else 10
    value = float(f"{drawn:.{digits}g}")
    return min(max(value, float(parameter.low)), float(parameter.high))


_NAME, _IDENTITY = "trials", "identity"
_FIRST = b'{"op_code":'
RANDOM_TRIALS = 20  # before the sampler learns from what it has seen


@dataclass(frozen=True)
class Trial:
    """A trial that was drawn: its number, from 1, and the values of the studied keys."""

    number: int
    values: dict[str, Choice]


class Trials(ExitStack):
    """The trials of one study in the file ``journal``. A context manager.

    Raises DesignError where the file holds the trials of another study, JournalError where it
    cannot be written or another process has it open.
    """

    def __init__(self, study: Study, base: Design, journal: Path) -> None:
        super().__init__()
        self._study, self._path = study, journal
        self._identity = _identity(study, base)
        self._space = {key: _distribution(each) for key, each in study.parameters.items()}
        self._directions = [f"{each.direction}imize" for each in study.objectives]
        self._trials: Any = None

    def __enter__(self) -> Self:
        try:
            self.enter_context(held(self._path))
            self._path.open("ab").close()
            # Optuna's own lock, that a killed process leaves for half a minute.
            Path(f"{self._path}.lock").unlink(missing_ok=True)
            content = self._path.read_bytes()
            if not _FIRST.startswith(content[: len(_FIRST)]):
                raise self._other("it is no journal of trials")
            whole = content.rfind(b"\n") + 1
            if whole:
                self._kept()  # refused before anything is written
            if whole < len(content):  # a killed process or a full disk left a line without an end
                os.truncate(self._path, whole)
            self._trials = self._kept() if whole else self._begun()
            if _IDENTITY not in self._trials.user_attrs:
                self._trials.set_user_attr(_IDENTITY, self._identity)
        except BaseException as error:
            self.close()
            if isinstance(error, OSError):
                raise self._failed(error) from error
            raise
        return self

    def drawn(self, waiting: bool = False) -> tuple[Trial, ...]:
        """All trials that were drawn, in order, or those that nothing was reported of yet."""
        some = (each for each in self._every() if not (waiting and each.state.is_finished()))
        kinds = self._study.parameters.items()
        return tuple(
            Trial(each.number + 1, {key: _value(kind, each.params[key]) for key, kind in kinds})
            for each in some
        )

    def draw(self, count: int) -> None:
        """Draw further trials; each is one line of the journal, so it is there whole or not."""
        import optuna
        from optuna.trial import TrialState, create_trial

        # The sampler writes its notes into a copy: the journal takes whole trials alone.
        copy = optuna.create_study(directions=self._directions)
        copy.add_trials(self._trials.get_trials())
        try:
            for _ in range(count):
                copy.sampler = self._sampler(len(copy.get_trials(deepcopy=False)))
                drawn = copy.ask(self._space).params
                self._trials.add_trial(
                    create_trial(state=TrialState.RUNNING, params=drawn, distributions=self._space)
                )
        except OSError as error:
            raise self._failed(error) from error

    def report(self, number: int, values: Sequence[float], broken: dict[str, float]) -> None:
        """Keep what came of a trial: its objectives, and its constraints (above 0: broken)."""
        from optuna.trial import Trial as Handle  # constraints are reported by it

        try:
            trial = Handle(self._trials, self._every()[number - 1]._trial_id)
            for name, excess in broken.items():
                if name not in trial.constraints:  # reported by a process that was killed at it
                    trial.set_constraint(name, excess)
            self._trials.tell(trial, list(values))
        except OSError as error:
            raise self._failed(error) from error

    def _every(self) -> list[Any]:
        found: list[Any] = self._trials.get_trials(deepcopy=False)
        return found

    def _sampler(self, index: int) -> Any:
        """What draws the trial of that number, from 0: its seed is the trial's own."""
        from optuna.samplers import TPESampler

        seeds = f"{self._study.study.seed} {index}".encode()
        return TPESampler(
            seed=int.from_bytes(hashlib.sha256(seeds).digest()[:4]),
            n_startup_trials=RANDOM_TRIALS,
            multivariate=True,
        )

    def _storage(self) -> Any:
        import optuna
        from optuna.storages import JournalStorage
        from optuna.storages.journal import JournalFileBackend, JournalFileOpenLock

        optuna.logging.set_verbosity(optuna.logging.WARNING)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            # The other kind, a link, needs rights on Windows.
            lock = JournalFileOpenLock(str(self._path))
            return JournalStorage(JournalFileBackend(str(self._path), lock))

    def _kept(self) -> Any:
        """The study of a journal that has a whole line; nothing is written."""
        import optuna

        try:
            sampler = optuna.samplers.RandomSampler()
            found = optuna.load_study(study_name=_NAME, storage=self._storage(), sampler=sampler)
            drawn = found.get_trials(deepcopy=False)
            kept = found.user_attrs.get(_IDENTITY)
        except (OSError, MemoryError):
            raise
        except Exception as error:  # Optuna asserts what its own lines hold
            why = type(error).__name__
            raise self._other(f"it is no journal of trials ({why})") from error
        if kept != self._identity and (kept is not None or drawn):
            raise self._other("it holds trials of another study, base or version")
        return found

    def _begun(self) -> Any:
        import optuna

        return optuna.create_study(
            storage=self._storage(),
            sampler=optuna.samplers.RandomSampler(),
            study_name=_NAME,
            directions=self._directions,
        )

    def _failed(self, error: OSError) -> JournalError:
        return JournalError(f"the trials cannot be kept in {self._path}: {error}")

    def _other(self, why: str) -> DesignError:
        bound = "the trials of this study"
        remedy = f"{why}: choose another --out, or delete the file to begin anew"
        return DesignError([Fault("--out", self._path, bound, remedy)])


def _identity(study: Study, base: Design) -> str:
    """What must be the same for trials to go on: not how many, how they are confirmed or limits."""
    decides = study.model_copy(update={"optimise": Optimise(), "limits": Limits()})
    reported = (
        decides.digest(),
        base.digest(),
        __version__,
        f"metrics {METRICS_VERSION}",
        _PURPOSE,
    )
    return hashlib.sha256("\n".join(reported).encode()).hexdigest()


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
        return list(planned(self.study, [variant], self.scenes))


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
        drawn, waiting = kept.drawn(), kept.drawn(waiting=True)
        report(len(drawn) - len(waiting), max(most, len(drawn)))
        missing = _to_draw(len(drawn), len(waiting), most, batch)
        if missing:
            kept.draw(missing)
            waiting = kept.drawn(waiting=True)
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
