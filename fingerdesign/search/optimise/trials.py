"""Trials on disk: what was drawn and what came of it, so that an interrupted search goes on.

The draw of a trial depends on the study's seed, the trial's number and the trials before it, so
that an interrupted search ends as an uninterrupted one. One process at a time writes a journal; the
work itself is done in parallel by the evaluator.
"""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NotRequired, Self

import numpy as np
from pydantic import TypeAdapter, ValidationError
from typing_extensions import TypedDict

from fingerdesign.design.schema import Design
from fingerdesign.records.base import closed
from fingerdesign.records.outcome import bounded
from fingerdesign.runtime.journal import Journal, held
from fingerdesign.search.optimise.propose import Known, Proposer
from fingerdesign.search.study.file import Limits, Optimise, Study
from fingerdesign.search.study.metrics import METRICS_VERSION
from fingerdesign.search.study.values import Choice, has_value
from fingerdesign.search.study.variants import Values, variant_of
from fingerdesign.version import __version__

KIND, ENDING = "trials", ".trials.sqlite"
FAILED, PURPOSE = "failed", "purpose"


@dataclass(frozen=True)
class Trial:
    """A trial that was drawn: its number, from 1, and the values of the studied keys."""

    number: int
    values: Values


@closed
class _Record(TypedDict):
    values: dict[str, Choice]
    objectives: NotRequired[list[float]]
    broken: NotRequired[dict[str, float]]


# Values near to others, by a generator of random numbers.
Near = Callable[[Mapping[str, Choice], np.random.Generator], Values]


class Trials(ExitStack):
    """The trials of one study in the file ``path``. A context manager.

    starts: values of the first trials, in the ranges of the study; others are proposed. near:
    values near to those of the best trial of an only objective, in the place of proposals. Raises
    DesignError where the file holds the trials of another study, JournalError where it cannot be
    written or another process has it open.
    """

    _journal: Journal

    def __init__(
        self,
        study: Study,
        base: Design,
        path: Path,
        starts: Sequence[Values] = (),
        near: Near | None = None,
    ) -> None:
        super().__init__()
        self._study, self._base, self._path = study, base, path
        self._starts, self._near = starts, near

    def __enter__(self) -> Self:
        try:
            self.enter_context(held(self._path))
            identity = _identity(self._study, self._base)
            self._journal = self.enter_context(Journal(self._path, KIND, identity))
            if not self._is_whole():
                raise self._journal.foreign()
        except BaseException:
            self.close()
            raise
        return self

    def drawn(self, waiting: bool = False) -> tuple[Trial, ...]:
        """All trials that were drawn, in order, or those that nothing was reported of yet."""
        some = self._every().items()
        return tuple(Trial(k, r["values"]) for k, r in some if not (waiting and "broken" in r))

    def draw(self, count: int) -> None:
        """Draw further trials, fewer where no other values are left; each is stored whole or not at
        all."""
        proposer = Proposer(
            self._study, [self._known(each) for each in self._every().values()], self._is_finger
        )
        for number in range(len(self._journal) + 1, len(self._journal) + 1 + count):
            values = self._known_values(number) or proposer.next(self._seed(number))
            if values is None:
                return
            self._journal.add({str(number): {"values": values}})

    def report(self, number: int, values: Sequence[float], broken: Mapping[str, float]) -> None:
        """Store the results of a trial: its objectives, and its constraints (above 0: broken)."""
        known = self._journal.get(str(number))
        record = known | {"objectives": list(values), "broken": dict(broken)}
        if record != known:
            self._journal.add({str(number): record})

    def _is_whole(self) -> bool:
        """True if the journal has a record that this study writes for each number from 1 on."""
        records = [record for _, record in self._journal]
        try:
            found = TypeAdapter(list[_Record]).validate_python(records, strict=True)
        except ValidationError:
            return False
        numbers = {key for key, _ in self._journal}
        return numbers == {str(k + 1) for k in range(len(found))} and all(map(self._is_own, found))

    def _is_own(self, record: "_Record") -> bool:
        values, parameters = record["values"], self._study.parameters
        if values.keys() != parameters.keys():
            return False
        if not all(has_value(each, values[key]) for key, each in parameters.items()):
            return False
        if "broken" not in record:
            return "objectives" not in record
        names = {FAILED, PURPOSE, *self._study.constraints}
        return (
            record["broken"].keys() == names
            and len(record.get("objectives", ())) == len(self._study.objectives)
            and all(map(bounded, record["objectives"]))
        )

    def _every(self) -> dict[int, Any]:
        return dict(sorted((int(key), record) for key, record in self._journal))

    def _known_values(self, number: int) -> Values | None:
        """Values of a trial by what the caller knows; None: a model proposes them."""
        if number <= len(self._starts):
            return self._starts[number - 1]
        every = [*self._every().values()]
        if self._near is None or not every:
            return None
        done = [each for each in every if "broken" in each]
        best = min(done, key=lambda each: each["objectives"][0]) if done else every[0]
        return self._near(best["values"], np.random.default_rng(self._seed(number)))

    def _known(self, record: Any) -> Known:
        if "broken" not in record:
            return Known(record["values"])
        signs = (1.0 if each.direction == "min" else -1.0 for each in self._study.objectives)
        losses = (s * v for s, v in zip(signs, record["objectives"], strict=True))
        failed = record["broken"].get(FAILED, 0.0) > 0.0
        broken = tuple(record["broken"].values())
        return Known(record["values"], None if failed else tuple(losses), broken)

    def _is_finger(self, values: Values) -> bool:
        return variant_of(self._study, self._base, 1, values).design is not None

    def _seed(self, number: int) -> int:
        seeds = f"{self._study.study.seed} {number - 1}".encode()
        return int.from_bytes(hashlib.sha256(seeds).digest()[:4])


def refuse_other_file(path: Path) -> None:
    """Refuse a journal's path where something else is there. Raises DesignError, JournalError."""
    Journal(path, KIND, None).close()


def _identity(study: Study, base: Design) -> str:
    """Digest of what must be unchanged to continue: not the number of trials, their confirmation or
    limits."""
    decides = study.model_copy(update={"optimise": Optimise(), "limits": Limits()})
    metrics = f"metrics {METRICS_VERSION}"
    reported = "\n".join((decides.digest(), base.digest(), __version__, metrics, PURPOSE))
    return hashlib.sha256(reported.encode()).hexdigest()
