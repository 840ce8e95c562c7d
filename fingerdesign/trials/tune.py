"""``fingerdesign tune``: every controller of a design tuned alike, and the design that comes of it.

record = tune_controllers(design, ("paper", "reactive"), journal)
tuned = tuned_design(design, record.to_json())
"""

import hashlib
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

from fingerdesign.analysis.case import Clock
from fingerdesign.analysis.stages import one_thread
from fingerdesign.checks.load import with_values
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.metrics import JudgedGrip
from fingerdesign.design.io import dump_design
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import json_text
from fingerdesign.report.page import sentences
from fingerdesign.runtime.journal import Journal
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.sensing.model import MESHED, model_data
from fingerdesign.trials.bench import GOOD_AMPLIFIER, Cell, ControlGrid, refuse
from fingerdesign.trials.run import VARIED, grip_bench, kept_records
from fingerdesign.trials.tuning import (
    BUDGET,
    Candidate,
    Judge,
    Report,
    Requested,
    Round,
    Tuning,
    Values,
    bench_judge,
    ranges_of,
    tune,
    tuning_cells,
)
from fingerdesign.version import versions

FORMAT = "fingerdesign tuning, 1"
KIND = "a tuning"  # of journals
RECORD_FILE = "tuning.json"
WORDS = Path(__file__).parent / "templates" / "words.txt.j2"


@dataclass(frozen=True)
class TuningRecord:
    """What was tuned, on what: tuning.json, with every trial and the values to take.

    digest: of all that decides it. cells: the grips, as many as the last round's. hardware, model:
    plain values that say what was gripped with. controllers: by name, see :func:`tuning_data`.
    """

    design: str
    digest: str
    seed: int
    cells: tuple[Cell, ...]
    hardware: dict[str, Any]
    model: dict[str, Any]
    controllers: dict[str, dict[str, Any]]
    versions: dict[str, str]
    seconds: float

    def data(self) -> dict[str, Any]:
        """The record as plain values."""
        names = "friction_coefficient", "object_mass_g", "noise_microstrain"
        cells = [
            dict(zip(names, (each.friction, each.mass_g, each.noise), strict=True))
            for each in self.cells
        ]
        own = {key: value for key, value in vars(self).items() if key != "cells"}
        return {"format": FORMAT, **own, "seconds": round(self.seconds, 1), "cells": cells}

    def to_json(self) -> str:
        """The record as text; NaN is never written."""
        return json_text(self.data(), indent=1)


def tuning_data(tuning: Tuning) -> dict[str, Any]:
    """A tuning as plain values: its ranges and rounds, every trial, the best and the default."""
    return {
        "grips": tuning.grips,
        "ranges": [asdict(each) for each in tuning.ranges],
        "rounds": [asdict(each) for each in tuning.budget],
        "best": trial_data(tuning.best),
        "default": trial_data(tuning.default),
        "trials": [trial_data(each) for each in tuning.trials],
    }


def trial_data(trial: Candidate) -> dict[str, Any]:
    """A trial as plain values; why its other grips failed is counted."""
    outcomes = trial.outcomes
    return {
        "values": trial.values,
        "round": trial.round,
        "grips": len(outcomes),
        "success_rate": trial.success,
        "held_rate": sum(each.held for each in outcomes) / max(len(outcomes), 1),
        "mean_peak_ratio": trial.mean_peak_ratio,
        "dropped": sum(each.dropped for each in outcomes),
        "crushed": sum(each.crushed for each in outcomes),
        "not_lifted": sum(not each.lifted for each in outcomes),
    }


def best_values(text: str) -> dict[str, float]:
    """The best values of all controllers of a record, by key of the design.

    Where two controllers share a key (the oracles do) the last one's stands. Raises DesignError for
    a text that is no such record.
    """
    try:
        record = json.loads(text)
        if record["format"] != FORMAT:
            raise ValueError(f"its format is {record['format']!r}")
        best = [tuned["best"]["values"] for tuned in record["controllers"].values()]
        return {str(key): float(value) for each in best for key, value in each.items()}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        fault = Fault(
            "--tuning", RECORD_FILE, f"a record of {FORMAT!r}", f"choose another: {error!r}"
        )
        raise DesignError([fault]) from error


def tuned_design(design: Design, text: str) -> Design:
    """The design with the best values of a record, checked like a file.

    Raises DesignError for a record that is none or holds what the design refuses.
    """
    return with_values(design, best_values(text))


Estimated = Callable[[int, int], None]  # grips judged of those asked for at once


class Kept:
    """The journal of an unfinished run; ResultError where a record is none of a tuning.

    It holds the grips of each trial. The procedure is seeded, so a run that is begun anew asks for
    the same trials: those that are kept are taken from here, in the middle of a round too.
    """

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._found = kept_records(journal, list[JudgedGrip], "a record of a tuning")

    @property
    def grips(self) -> int:
        """How many grips of trials are kept."""
        return sum(map(len, self._found.values()))

    def judge(self, judge: Judge, reported: Estimated = lambda done, of: None) -> Judge:
        """A judge that recalls what is kept and keeps, trial by trial, what ``judge`` makes."""

        def judged(requested: Requested) -> list[list[JudgedGrip]]:
            keys = [_key(*each) for each in requested]  # tried values may be alike
            pairs = zip(keys, requested, strict=True)
            left = {key: each for key, each in pairs if key not in self._found}
            of = sum(len(cells) for _, cells in requested)
            done = of - sum(len(cells) for _, cells in left.values())
            reported(done, of)
            for key, outcomes in zip(left, judge(list(left.values())), strict=True):
                self._journal.add({key: [asdict(each) for each in outcomes]})
                self._found[key] = outcomes
                done += len(outcomes)
                reported(done, of)
            return [self._found[key] for key in keys]

        return judged


def _key(values: Values, cells: Sequence[Cell]) -> str:
    """Of a trial's values and grips; a cell names its controller."""
    reported = [sorted(values.items()), [asdict(each) for each in cells]]
    return f"trial {hashlib.sha256(json.dumps(reported).encode()).hexdigest()[:24]}"


DESIGN_FILE = "tuned.toml"


def _tuning_digest(
    design: Design,
    budget: Sequence[Round],
    noises: Sequence[float],
    seed: int,
    problem: ContactProblem,
    estimator: GripEstimator | None,
) -> str:
    """SHA-256, in hexadecimal, of all that the trials of a tuning depend on."""
    rounds = [asdict(each) for each in budget]
    taught = None if estimator is None else estimator.to_json()
    model = [model_data(problem), MESHED]
    parts = [design.digest(), versions()["fingerdesign"], rounds, [*noises], seed, model]
    return hashlib.sha256(
        json.dumps([*parts, taught, *CONTROLLERS.contents()]).encode()
    ).hexdigest()


def tune_controllers(
    design: Design,
    controllers: Sequence[str],
    journal: Path,
    *,
    estimator: GripEstimator | None = None,
    noises: Sequence[float] = (GOOD_AMPLIFIER,),
    seed: int = 0,
    budget: Sequence[Round] = BUDGET,
    workers: int = 1,
    report: Report = lambda message, fraction: None,
    fidelity: str = "plane-strain",
) -> TuningRecord:
    """Tune those controllers that the file ``journal`` does not hold yet, trial by trial.

    estimator: the regulator's; without one it is taught on this design, or taken from the cache.
    noises: of the gages in the tuning grips, microstrain, in turn. The journal stays: whoever has
    written the record may delete it. Raises DesignError for wrong input, ResultError for a journal
    of something else, SolverError where a process died.
    """
    names = tuple(dict.fromkeys(controllers))
    refuse(ControlGrid(noises=tuple(noises), seed=seed), names)
    start = time.perf_counter()
    grid = replace(ControlGrid(seed=seed), tug=None)
    bench = grip_bench(
        design, names, grid, estimator, workers, report, Clock(), fidelity, opposed=False
    )
    digest = _tuning_digest(design, budget, noises, seed, bench.problem, bench.estimator)
    found, records = {}, Journal(journal, KIND, digest)
    with records, one_thread(), bench_judge(bench, workers) as judge:
        if (kept := Kept(records)).grips:
            report(f"going on: {kept.grips} grips were made before", 0.0)
        for number, name in enumerate(names):
            progress = _Progress(report, number, len(names), len(budget))
            found[name] = tune(
                name,
                default_values(design, name),
                tuning_cells(name, budget[-1].grips, seed, noises),
                kept.judge(judge, progress.grips),
                budget=budget,
                seed=seed,
                report=progress.round,
            )
    return TuningRecord(
        design=design.design.name,
        digest=digest,
        seed=seed,
        cells=tuple(tuning_cells("", budget[-1].grips, seed, noises)),
        hardware=design.grip.hardware.model_dump(exclude=VARIED),
        model={
            **model_data(bench.problem),
            "gages": len(bench.plates),
            **design.grip.model_dump(include={"preload_mm", "max_approach_mm", "max_steps"}),
        },
        controllers={name: tuning_data(each) for name, each in found.items()},
        versions=versions(),
        seconds=time.perf_counter() - start,
    )


def default_values(design: Design, controller: str) -> dict[str, float]:
    """A design's own values of the parameters that a controller is tuned in."""
    return {each.key: float(attrgetter(each.key)(design)) for each in ranges_of(controller)}


def write_tuning(record: TuningRecord, design: Design, folder: Path) -> None:
    """tuning.json and the tuned design, into a folder that exists; the record comes last.

    The design's first comment says by what it was tuned, on what and how well.
    """
    text = record.to_json()
    head = "".join(f"# {line}\n" for line in sentences(WORDS, "tuned", record))
    tuned = f"{head}\n{dump_design(tuned_design(design, text))}"
    (folder / DESIGN_FILE).write_text(tuned, encoding="utf-8")
    (folder / RECORD_FILE).write_text(text, encoding="utf-8")


class _Progress:
    """What is reported while controller ``number`` of ``of`` is tuned."""

    def __init__(self, report: Report, number: int, of: int, rounds: int) -> None:
        self._report, self._number, self._of, self._rounds = report, number, of, rounds
        self._message, self._share = "", 0.0

    def round(self, message: str, share: float) -> None:
        """A round begins."""
        self._message, self._share = message, share

    def grips(self, done: int, of: int) -> None:
        """So many of the round's grips are made."""
        share = self._share + done / of / self._rounds
        message = f"{self._message}, {done} of {of} grips"
        self._report(message, (self._number + share) / self._of)
