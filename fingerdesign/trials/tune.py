"""``fingerdesign tune``: every controller of a design tuned alike, and the design that comes of it.

record = tune_controllers(design, ("paper", "reactive"), journal)
tuned = tuned_design(design, record.to_json())
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.analysis.case import gage_array
from fingerdesign.analysis.stages import one_thread
from fingerdesign.analysis.summary import versions
from fingerdesign.checks.load import dump_design
from fingerdesign.control.metrics import Outcome
from fingerdesign.control.roster import needs_training
from fingerdesign.errors import DesignError
from fingerdesign.records.result import ResultError
from fingerdesign.runtime.journal import Journal, JournalError
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.sensing.lessons import lesson_for
from fingerdesign.sensing.model import CONTACT_SIZE_MM, grip_problem
from fingerdesign.trials.bench import GripBench
from fingerdesign.trials.grid import GOOD_AMPLIFIER, Cell, ControlGrid
from fingerdesign.trials.run import hardware_of
from fingerdesign.trials.tuning import (
    BUDGET,
    Asked,
    BenchJudge,
    Judge,
    Report,
    Round,
    Values,
    bench_judge,
    ranges_of,
    tune,
    tuning_cells,
)
from fingerdesign.trials.tuning_record import (
    RECORD_FILE,
    TuningRecord,
    tuned_comment,
    tuned_design,
    tuning_data,
)

if TYPE_CHECKING:
    from fingerdesign.control.estimator import GripEstimator
    from fingerdesign.design.schema import Design


# What an unfinished tuning has done: judged trials and finished controllers.
#
# The procedure is seeded, so a run that is begun anew asks for the same trials: those that stand
# here are taken from here, and it goes on in the middle of a round.
#
#     kept = Kept(path, digest)
#     tune(..., judge=kept.judge(judge, reported))

Estimated = Callable[[int, int], None]  # grips judged of those asked for at once


class Kept:
    """The journal of a run with ``digest``; a file of something else is a ResultError.

    controllers: finished tunings by name.
    """

    def __init__(self, path: Path, digest: str) -> None:
        try:
            self._journal = Journal(path, "a tuning", digest)
        except JournalError as error:
            raise ResultError(str(error)) from error
        self.controllers: dict[str, dict[str, Any]] = {}
        self._judged: dict[str, list[Outcome]] = {}
        for key, record in self._journal:
            kind, _, name = key.partition(" ")
            if kind == "trial":
                self._judged[name] = [Outcome(**each) for each in record]
            else:
                self.controllers[name] = record

    @property
    def grips(self) -> int:
        """How many grips of trials are kept."""
        return sum(len(each) for each in self._judged.values())

    def add(self, controller: str, tuning: dict[str, Any]) -> None:
        """Keep a finished tuning."""
        self._journal.add({f"controller {controller}": tuning})
        self.controllers[controller] = tuning

    def add_trial(self, values: Values, cells: Sequence[Cell], outcomes: list[Outcome]) -> None:
        """Keep what came of a trial's grips."""
        key = _key(values, cells)
        self._journal.add({f"trial {key}": [asdict(each) for each in outcomes]})
        self._judged[key] = outcomes

    def judge(self, judge: BenchJudge, reported: Estimated = lambda done, of: None) -> Judge:
        """A judge that recalls what is kept and keeps, trial by trial, what ``judge`` makes."""

        def judged(requested: Asked) -> list[list[Outcome]]:
            of = sum(len(cells) for _, cells in requested)
            left = [each for each in requested if _key(*each) not in self._judged]
            done = of - sum(len(cells) for _, cells in left)
            reported(done, of)

            def made(k: int, outcomes: list[Outcome]) -> None:
                nonlocal done
                self.add_trial(*left[k], outcomes)
                done += len(outcomes)
                reported(done, of)

            if left:
                judge(left, made)
            return [self._judged[_key(*each)] for each in requested]

        return judged

    def close(self) -> None:
        """Let go of the file."""
        self._journal.close()


def _key(values: Values, cells: Sequence[Cell]) -> str:
    """Of a trial's values and grips; a cell names its controller."""
    reported = [sorted(values.items()), [asdict(each) for each in cells]]
    return hashlib.sha256(json.dumps(reported).encode()).hexdigest()[:24]


DESIGN_FILE = "tuned.toml"


def _tuning_digest(
    design: Design,
    budget: Sequence[Round],
    noises: Sequence[float],
    seed: int,
    contact_size_mm: float,
    estimator: GripEstimator | None,
) -> str:
    """SHA-256, in hexadecimal, of all that the trials of a tuning depend on."""
    rounds = [asdict(each) for each in budget]
    taught = None if estimator is None else estimator.to_json()
    parts = [design.digest(), versions()["fingerdesign"], rounds, [*noises], seed, contact_size_mm]
    return hashlib.sha256(json.dumps([*parts, taught]).encode()).hexdigest()


def _model_data(
    design: Design, contact_size_mm: float, nodes: int, gages: int
) -> dict[str, object]:
    """The model that was gripped with, as plain values."""
    return {
        "fidelity": "plane-strain",
        "contact_size_mm": contact_size_mm,
        "contact_nodes": nodes,
        "gages": gages,
        "preload_mm": design.grip.preload_mm,
        "max_approach_mm": design.grip.max_approach_mm,
        "max_steps": design.grip.max_steps,
    }


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
    contact_size_mm: float = CONTACT_SIZE_MM,
    report: Report = lambda message, fraction: None,
) -> TuningRecord:
    """Tune those controllers that the file ``journal`` does not hold yet, trial by trial.

    estimator: the regulator's; without one it is taught on this design, or taken from the cache.
    noises: of the gages in the tuning grips, microstrain, in turn. The journal stays: whoever has
    written the record may delete it. Raises DesignError for wrong input, ResultError for a journal
    of something else, SolverError where a process died.
    """
    names = tuple(dict.fromkeys(controllers))
    _refuse(names, noises, seed)
    start = time.perf_counter()
    problem = grip_problem(design, contact_size_mm, lambda message: report(message, 0.0))
    if any(map(needs_training, names)) and estimator is None:
        estimator = lesson_for(design, problem, lambda said: report(said, 0.0), workers).estimator
    hardware = hardware_of(design)
    grid = replace(ControlGrid(seed=seed), tug=None)
    plates = gage_array(design)
    bench = GripBench(problem, design.gages.face, plates, design.grip, hardware, grid, estimator)
    digest = _tuning_digest(design, budget, noises, seed, contact_size_mm, estimator)
    kept = Kept(journal, digest)
    if kept.grips:
        report(f"going on: {kept.grips} grips were made before", 0.0)
    left = [name for name in names if name not in kept.controllers]
    with one_thread(), bench_judge(bench, workers) as judge:
        for number, name in enumerate(left):
            progress = _Progress(report, number, len(left), len(budget))
            found = tune(
                name,
                default_values(design, name),
                tuning_cells(name, budget[-1].grips, seed, noises),
                kept.judge(judge, progress.grips),
                budget=budget,
                seed=seed,
                report=progress.round,
            )
            kept.add(name, tuning_data(found))
    kept.close()
    varied = "gage_noise_microstrain"
    return TuningRecord(
        design=design.design.name,
        digest=digest,
        seed=seed,
        cells=tuple(tuning_cells("", budget[-1].grips, seed, noises)),
        hardware={key: value for key, value in asdict(hardware).items() if key != varied},
        model=_model_data(design, contact_size_mm, problem.model.nodes, len(plates)),
        controllers={name: kept.controllers[name] for name in names},
        versions=versions(),
        seconds=time.perf_counter() - start,
    )


def default_values(design: Design, controller: str) -> dict[str, float]:
    """A design's own values of the parameters that a controller is tuned in."""
    found = {}
    for each in ranges_of(controller):
        value: Any = design
        for name in each.key.split("."):
            value = getattr(value, name)
        found[each.key] = float(value)
    return found


def write_tuning(record: TuningRecord, design: Design, folder: Path) -> None:
    """tuning.json and the tuned design, into a folder that exists; the record comes last.

    The design's first comment says by what it was tuned, on what and how well.
    """
    text = record.to_json()
    tuned = tuned_comment(record) + dump_design(tuned_design(design, text))
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


def _refuse(names: Sequence[str], noises: Sequence[float], seed: int) -> None:
    faults = ControlGrid(noises=tuple(noises), seed=seed).faults()
    for name in names:
        if name not in CONTROLLERS.names():
            faults.append(CONTROLLERS.fault(name, "--controller"))
    if faults:
        raise DesignError(faults)
