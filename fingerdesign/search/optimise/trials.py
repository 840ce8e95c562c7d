"""Trials on disk: Optuna's study in a journal, which an interrupted optimisation goes on from.

The draw of a trial depends on the study's seed, the trial's number and the trials reported before
it, so that an interrupted search ends as an uninterrupted one. One process at a time writes a
journal; the work itself is done in parallel by the evaluator.
"""

import hashlib
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.extras import needs
from fingerdesign.runtime.journal import JournalError, held
from fingerdesign.search.study.file import Limits, Optimise, Study
from fingerdesign.search.study.metrics import METRICS_VERSION
from fingerdesign.search.study.values import Choice, Parameter, Range
from fingerdesign.version import __version__

RANDOM_TRIALS = 20  # The sampler learns only after these.
PURPOSE = "purpose"
_NAME, _IDENTITY = "trials", "identity"
_FIRST = b'{"op_code":'
_NO_JOURNAL = "it is no journal of trials"


@dataclass(frozen=True)
class Trial:
    """A trial that was drawn: its number, from 1, and the values of the studied keys."""

    number: int
    values: dict[str, Choice]


# Values near to others, by a generator of random numbers.
Near = Callable[[Mapping[str, Choice], np.random.Generator], Mapping[str, Choice]]


class Trials(ExitStack):
    """The trials of one study in the file ``journal``. A context manager.

    starts: values of the first trials, in the ranges of the study; the sampler draws the others.
    near: values near to those of the best trial of an only objective; draws instead of the sampler.
    Raises DesignError where the file holds the trials of another study, JournalError where it
    cannot be written or another process has it open.
    """

    def __init__(
        self,
        study: Study,
        base: Design,
        journal: Path,
        starts: Sequence[Mapping[str, Choice]] = (),
        near: Near | None = None,
    ) -> None:
        super().__init__()
        self._study, self._path, self._starts, self._near = study, journal, starts, near
        self._identity = _identity(study, base)
        self._space = {key: _distribution(each) for key, each in study.parameters.items()}
        self._directions = [f"{each.direction}imize" for each in study.objectives]
        self._trials: Any = None

    def __enter__(self) -> Self:
        needs("search", "optuna")
        try:
            refuse_other_file(self._path)
            self.enter_context(held(self._path))
            self._path.open("ab").close()
            # Optuna's own lock, that a killed process leaves for half a minute.
            Path(f"{self._path}.lock").unlink(missing_ok=True)
            content = self._path.read_bytes()
            whole = content.rfind(b"\n") + 1
            if whole:
                self._load()  # refused before anything is written
            if whole < len(content):  # a killed process or a full disk left a line without an end
                os.truncate(self._path, whole)
            self._trials = self._load() if whole else self._created()
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
        return tuple(Trial(each.number + 1, self._values(each)) for each in some)

    def _values(self, drawn: Any) -> dict[str, Choice]:
        kinds = self._study.parameters.items()
        return {key: _value(kind, drawn.params[key]) for key, kind in kinds}

    def draw(self, count: int) -> None:
        """Draw further trials; each is one line of the journal, so it is there whole or not."""
        import optuna
        from optuna.samplers import TPESampler
        from optuna.trial import TrialState, create_trial

        # The sampler writes its notes into a copy: the journal takes whole trials alone.
        copy = optuna.create_study(directions=self._directions)
        copy.add_trials(self._trials.get_trials())
        try:
            for _ in range(count):
                index = len(copy.get_trials(deepcopy=False))
                # Each trial has its own seed.
                copy.sampler = TPESampler(
                    seed=self._seed(index), n_startup_trials=RANDOM_TRIALS, multivariate=True
                )
                if (known := self._known(index)) is not None:
                    copy.enqueue_trial(dict(known))
                drawn = copy.ask(self._space).params
                self._trials.add_trial(
                    create_trial(state=TrialState.RUNNING, params=drawn, distributions=self._space)
                )
        except OSError as error:
            raise self._failed(error) from error

    def _known(self, index: int) -> Mapping[str, Choice] | None:
        """Values of the trial of that index, from 0; None where the sampler draws it."""
        if index < len(self._starts):
            return self._starts[index]
        done = [each for each in self._every() if each.state.is_finished() and each.values]
        if self._near is None or not (done or self._starts):
            return None
        values = self._starts[0] if not done else self._values(min(done, key=lambda t: t.values[0]))
        return self._near(values, np.random.default_rng(self._seed(index)))

    def report(self, number: int, values: Sequence[float], broken: dict[str, float]) -> None:
        """Store the results of a trial: its objectives, and its constraints (above 0: broken)."""
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

    def _seed(self, index: int) -> int:
        seeds = f"{self._study.study.seed} {index}".encode()
        return int.from_bytes(hashlib.sha256(seeds).digest()[:4])

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

    def _load(self) -> Any:
        """The study of a journal that has a whole line; nothing is written."""
        import optuna

        try:
            sampler = optuna.samplers.RandomSampler()
            found = optuna.load_study(study_name=_NAME, storage=self._storage(), sampler=sampler)
            drawn = found.get_trials(deepcopy=False)
            stored = found.user_attrs.get(_IDENTITY)
        except (OSError, MemoryError):
            raise
        except Exception as error:  # Optuna asserts what its own lines hold
            raise _other(self._path, f"{_NO_JOURNAL} ({type(error).__name__})") from error
        if stored != self._identity and (stored is not None or drawn):
            raise _other(self._path, "it holds trials of other keys, another design or version")
        return found

    def _created(self) -> Any:
        import optuna

        sampler, storage = optuna.samplers.RandomSampler(), self._storage()
        return optuna.create_study(
            study_name=_NAME, storage=storage, sampler=sampler, directions=self._directions
        )

    def _failed(self, error: OSError) -> JournalError:
        return JournalError(f"the trials cannot be stored in {self._path}: {error}")


def refuse_other_file(path: Path) -> None:
    """Refuse a journal's path where something else is there. Raises DesignError."""
    if path.is_dir() or (path.is_symlink() and not path.exists()):
        raise _other(path, "it is a folder" if path.is_dir() else "it is a link to nothing")
    if path.is_file():
        with path.open("rb") as stream:
            if not _FIRST.startswith(stream.read(len(_FIRST))):
                raise _other(path, _NO_JOURNAL)


def _other(path: Path, why: str) -> DesignError:
    bound = "a place for the trials of this search"
    remedy = f"{why}: choose another --out, or delete it to begin again"
    return DesignError([Fault("--out", path, bound, remedy)])


def _identity(study: Study, base: Design) -> str:
    """Digest of what must be unchanged to continue: not the number of trials, their confirmation or
    limits."""
    decides = study.model_copy(update={"optimise": Optimise(), "limits": Limits()})
    metrics = f"metrics {METRICS_VERSION}"
    reported = "\n".join((decides.digest(), base.digest(), __version__, metrics, PURPOSE))
    return hashlib.sha256(reported.encode()).hexdigest()


def _distribution(parameter: Parameter) -> Any:
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if not isinstance(parameter, Range):
        return CategoricalDistribution(parameter)
    low, step, log = parameter.low, parameter.step, parameter.log
    levels = parameter.levels
    high = parameter.high if levels is None else low + (step or 1) * (levels - 1)
    if parameter.whole:
        return IntDistribution(int(low), int(high), log=log, step=int(step or 1))
    return FloatDistribution(float(low), float(f"{high:.12g}"), log=log, step=step)


def _value(parameter: Parameter, drawn: Choice) -> Choice:
    if not isinstance(parameter, Range):
        return drawn
    if parameter.whole:
        return int(drawn)
    digits = 6 if parameter.levels is None else 10
    value = float(f"{drawn:.{digits}g}")
    return min(max(value, float(parameter.low)), float(parameter.high))
