"""Tuning of a study's controllers before it begins: grips, processes, journal and record.

tuning = tune_controllers(bench, ("paper", "reactive"), journal, setting)
tuned = tuned_design(design, tuning)
"""

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import starmap
from operator import attrgetter
from pathlib import Path

from fingerdesign.checks.load import with_values
from fingerdesign.control.plants.remembered import Memory
from fingerdesign.design.grip import Grip
from fingerdesign.design.io import dump_design
from fingerdesign.design.keys import set_value
from fingerdesign.design.schema import Design
from fingerdesign.errors import SolverError
from fingerdesign.records.result import GripResult
from fingerdesign.report.page import sentences
from fingerdesign.runtime.isolate import ProcessError
from fingerdesign.runtime.journal import Journal
from fingerdesign.runtime.pool import Pool
from fingerdesign.trials.bench import GripBench
from fingerdesign.trials.grid import GOOD_AMPLIFIER, Cell
from fingerdesign.trials.record import ControllerTuningData, TunedTrialData, TuningData
from fingerdesign.trials.stored import stored_grips
from fingerdesign.trials.tuning import (
    BUDGET,
    Candidate,
    Judge,
    Report,
    Requested,
    Round,
    Tuning,
    Values,
    ranges_of,
    tune,
    tuning_cells,
)

DESIGN_FILE = "tuned.toml"
WORDS = Path(__file__).parent / "templates" / "words.txt.j2"
# This is added to the seed of all noise, so that tuning grips have another noise than the grid's.
_APART = 1009


@dataclass(frozen=True)
class TuningSetting:
    """Setting of a study's tuning. noises: of the gages, microstrain, in turn."""

    noises: tuple[float, ...] = (GOOD_AMPLIFIER,)
    budget: tuple[Round, ...] = BUDGET


def tune_controllers(
    design: Design,
    bench: GripBench,
    controllers: Sequence[str],
    journal: Journal,
    setting: TuningSetting,
    workers: int = 1,
    report: Report = lambda message, fraction: None,
) -> dict[str, Tuning]:
    """Tune each controller by the same procedure and the same number of grips.

    Trials that the journal holds are not run again. Raises SolverError where a process died.
    """
    stored = StoredTrials(journal)
    if stored.grips:
        report(f"continuing: {stored.grips} grips were made before", 0.0)
    budget, seed, found = setting.budget, bench.grid.seed, {}
    with bench_judge(replace(bench, opposite=None), workers) as judge:
        for number, name in enumerate(controllers):
            progress = _Progress(report, number, len(controllers), len(budget))
            found[name] = tune(
                name,
                default_values(design, name),
                tuning_cells(name, budget[-1].grips, seed, setting.noises),
                stored.judge(judge, progress.grips),
                budget=budget,
                seed=seed,
                report=progress.round,
            )
    return found


def default_values(design: Design, controller: str) -> dict[str, float]:
    """A design's own values of the parameters that a controller is tuned in."""
    return {each.key: float(attrgetter(each.key)(design)) for each in ranges_of(controller)}


def tuned_design(design: Design, tuned: dict[str, Tuning]) -> Design:
    """The design with the best values of all controllers, checked like a file.

    Where two controllers share a key (the oracles do), the last one's value is taken.
    """
    best = [each.best.values for each in tuned.values()]
    return with_values(design, {key: value for each in best for key, value in each.items()})


# Grips of trials, in processes, and their journal.


def tuned_grip(grip: Grip, values: Values) -> Grip:
    """A ``[grip]`` table with dotted keys of the design set, checked like a file."""
    data = {"grip": grip.model_dump(mode="json", exclude_none=True)}
    for key, value in values.items():
        set_value(data, key, value)
    return Grip.model_validate(data["grip"])


def run_cells(bench: GripBench, values: Values, cells: Sequence[Cell]) -> list[GripResult]:
    """The results of grips whose controllers take ``values``."""
    tuned = bench.with_grip(tuned_grip(bench.grip, values))
    return [tuned.run_cell(cell, Memory()) for cell in cells]


@contextmanager
def bench_judge(bench: GripBench, workers: int) -> Iterator[Judge]:
    """A judge of trials on a bench, over processes; ``workers`` 1: in this one.

    It raises SolverError where a process died.
    """
    seeded = replace(bench, grid=replace(bench.grid, seed=bench.grid.seed + _APART, tug=None))
    if workers <= 1:
        yield lambda requested: starmap(partial(run_cells, seeded), requested)
        return
    with Pool(workers, shared=(seeded,)) as pool:

        def judge(requested: Requested) -> Iterator[list[GripResult]]:
            waiting = [(dict(values), tuple(cells)) for values, cells in requested]
            try:
                yield from pool.in_order(run_cells, waiting)
            except ProcessError as error:
                words = f"a process of the tuning ended ({error}); was there memory enough?"
                raise SolverError(words) from error

        yield judge


class StoredTrials:
    """The grips of each trial in a journal; ResultError where a record is not that.

    The procedure is seeded, so a run that begins again makes the same trials: those of the journal
    are taken from it, in the middle of a round too.
    """

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        every = stored_grips(journal)
        self._found = {key: each for key, each in every.items() if key.startswith("trial ")}

    @property
    def grips(self) -> int:
        """Number of grips of the stored trials."""
        return sum(map(len, self._found.values()))

    def judge(
        self, judge: Judge, reported: Callable[[int, int], None] = lambda done, of: None
    ) -> Judge:
        """A judge that takes stored trials from the journal, and stores what ``judge`` makes.

        reported: is given the number of grips judged, and of those requested.
        """

        def judged(requested: Requested) -> list[list[GripResult]]:
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
    """The key of a trial's values and grips; a cell names its controller."""
    parts = [sorted(values.items()), [asdict(each) for each in cells]]
    return f"trial {hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:24]}"


# The record of a tuning.


def tuning_data(
    tuned: dict[str, Tuning], setting: TuningSetting, seed: int, digest: str
) -> TuningData:
    """The tunings as plain values; digest: of the design before them."""
    cells = tuning_cells("", setting.budget[-1].grips, seed, setting.noises)
    return {
        "digest": digest,
        "cells": [
            {
                "friction_coefficient": each.friction,
                "object_mass_g": each.mass_g,
                "noise_microstrain": each.noise,
            }
            for each in cells
        ],
        "controllers": {name: _controller_data(each) for name, each in tuned.items()},
    }


def _controller_data(tuning: Tuning) -> ControllerTuningData:
    return {
        "grips": tuning.grips,
        "ranges": [asdict(each) for each in tuning.ranges],
        "rounds": [asdict(each) for each in tuning.budget],
        "best": trial_data(tuning.best),
        "default": trial_data(tuning.default),
        "trials": [trial_data(each) for each in tuning.trials],
    }


def trial_data(trial: Candidate) -> TunedTrialData:
    """A trial as plain values; the reasons why its other grips failed are counted."""
    outcomes = trial.outcomes
    return {
        "values": trial.values,
        "round": trial.round,
        "grips": len(outcomes),
        "success_rate": trial.success,
        "held_rate": sum(each.holds_object for each in outcomes) / max(len(outcomes), 1),
        "mean_peak_ratio": trial.mean_peak_ratio,
        "dropped": sum(each.gross_slip for each in outcomes),
        "crushed": sum(each.crushed for each in outcomes),
        "not_lifted": sum(not each.lifted for each in outcomes),
    }


def tuned_text(design: Design, tuning: TuningData, seed: int) -> str:
    """The tuned design as a file whose first comment gives the tuning's grips and rates."""
    head = sentences(WORDS, "tuned", design.design.name, tuning, seed)
    return "".join(f"# {line}\n" for line in head) + f"\n{dump_design(design)}"


class _Progress:
    """Progress while controller ``number`` of ``of`` is tuned."""

    def __init__(self, report: Report, number: int, of: int, rounds: int) -> None:
        self._report, self._number, self._of, self._rounds = report, number, of, rounds
        self._message, self._share = "", 0.0

    def round(self, message: str, share: float) -> None:
        """Note that a round begins."""
        self._message, self._share = message, share

    def grips(self, done: int, of: int) -> None:
        """Report how many of the round's grips are made."""
        share = self._share + done / of / self._rounds
        message = f"{self._message}, {done} of {of} grips"
        self._report(message, (self._number + share) / self._of)
