"""Tuning of a study's controllers before it begins: one procedure and number of grips for all.

    tuning = tune_controllers(design, bench, ("paper", "reactive"), journal, setting)
    tuned = tuned_design(design, tuning)

Rounds of trials, each judged on more grips than the last and searched in a smaller box:

    trials are Sobol points of the box of a controller's parameters, the design's own values first;
    the best go on to the next round, with new points of a box a third as wide around the best one.

A round's grips are the last round's and more, so what was gripped once is not gripped again. The
score is the success rate; ties (and they are frequent) go to the lower mean of the peak force over
the least force that would hold, of the grips that succeed. The best of the last round is taken.

The same seed gives the same trials, whatever the number of processes. A controller without
parameters of its own would still be given every round; an oracle has one. A study of perturbed
fingers tunes on such fingers, with the same faults, but on none that it judges.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from operator import attrgetter

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.checks.load import with_values
from fingerdesign.control.roster import ControllerKind, Range
from fingerdesign.design.io import dump_design
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.result import GripResult
from fingerdesign.runtime.journal import Journal
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.runtime.streams import seed_for, stream
from fingerdesign.trials.bench import Bench, GripBench
from fingerdesign.trials.grid import (
    FRICTIONS,
    GOOD_AMPLIFIER,
    MASSES_G,
    NONE,
    Cell,
    ControlGrid,
    Perturbed,
)
from fingerdesign.trials.record import ControllerTuningData, TunedTrialData, TuningData
from fingerdesign.trials.stored import Report, run_batches

DESIGN_FILE = "tuned.toml"

Values = Mapping[str, float]
# The results of batches of cells; the cells of a batch have the same values.
Judge = Callable[[Sequence[tuple[Cell, ...]], Report], list[list[GripResult]]]


@dataclass(frozen=True)
class Round:
    """New trials, next to the default and the best ones of the last round, judged on so many
    grips. The first round's trials include the default."""

    new: int
    best: int
    grips: int


BUDGET = (Round(32, 0, 16), Round(8, 8, 48), Round(4, 4, 96))  # 1808 grips
_SHRINK = 1.0 / 3.0  # The box of a round is so wide as a part of the last round's.


@dataclass(frozen=True)
class TuningSetting:
    """Setting of a study's tuning. noises: of the gages, microstrain, in turn."""

    noises: tuple[float, ...] = (GOOD_AMPLIFIER,)
    budget: tuple[Round, ...] = BUDGET


@dataclass(frozen=True)
class Candidate:
    """Parameters, and what came of them. round: the one that it was made in, from 0."""

    values: dict[str, float]
    round: int
    outcomes: tuple[GripResult, ...] = ()

    @property
    def success(self) -> float:
        """Share of its grips that succeed; 0 of none."""
        return sum(each.success for each in self.outcomes) / max(len(self.outcomes), 1)

    @property
    def mean_peak_ratio(self) -> float | None:
        """Mean over the grips that succeed; None where none does."""
        found = [each.peak_ratio for each in self.outcomes if each.success]
        return float(np.mean(found)) if found else None

    @property
    def order(self) -> tuple[float, float]:
        """Greater is better."""
        peak = self.mean_peak_ratio
        return self.success, -np.inf if peak is None else -peak


@dataclass(frozen=True)
class Tuning:
    """A controller's trials in the order they were made, on all the grips they were judged on.

    best: the trial to take. default: the design's own values, judged on the last round's grips.
    """

    ranges: tuple[Range, ...]
    budget: tuple[Round, ...]
    trials: tuple[Candidate, ...]
    best: Candidate
    default: Candidate

    @property
    def grips(self) -> int:
        """Number of its grips."""
        return sum(len(trial.outcomes) for trial in self.trials)


def tune(
    controller: str,
    default: Values,
    cells: Sequence[Cell],
    judge: Judge,
    *,
    budget: Sequence[Round] = BUDGET,
    seed: int = 0,
    report: Report = lambda message, fraction: None,
) -> Tuning:
    """Tune one controller; ``default`` holds the design's own values of those parameters that
    are tuned.

    cells: the grips, as many as the last round asks for; each round takes them from the start.
    Raises DesignError for a controller without ranges or too few grips.
    """
    own = tuple(each for each in ranges_of(controller) if each.key in default)
    if len(cells) < budget[-1].grips:
        bound = f"at least {budget[-1].grips}, as the last round asks for"
        raise DesignError([Fault("grips", len(cells), bound, "give more")])
    everything: list[Candidate] = []  # as last judged, in the order they were made
    going: list[int] = []  # those of the last round, the best first
    box = np.tile([0.0, 1.0], (len(own), 1))
    for number, each in enumerate(budget):

        def shown(message: str, part: float, begun: int = number) -> None:
            words = f"tuning {controller}: round {begun + 1} of {len(budget)}"
            report(words, (begun + part) / len(budget))

        made = [Candidate(dict(default), 0)] if number == 0 else []
        rng = stream(seed, "trials of a tuning", controller, number)
        points = points_of(box, each.new - len(made), rng)
        made += [Candidate(values_at(own, point), number) for point in points]
        best = [k for k in going if k != 0][: each.best]
        # The default stays to the end: it is what the tuning improves on.
        chosen = [*([0] if going else []), *best]
        chosen += range(len(everything), len(everything) + len(made))
        everything += made
        # On those of the grips that they were not judged on yet.
        batches = [_cells_of(everything[k], cells[: each.grips]) for k in chosen]
        for k, found in zip(chosen, judge(batches, shown), strict=True):
            everything[k] = replace(everything[k], outcomes=(*everything[k].outcomes, *found))
        going = sorted(chosen, key=lambda k: everything[k].order, reverse=True)
        box = box_around(own, everything[going[0]].values, _SHRINK ** (number + 1))
    first, trials = everything[going[0]], tuple(everything)
    return Tuning(own, tuple(budget), trials, first, trials[0])


def _cells_of(trial: Candidate, cells: Sequence[Cell]) -> tuple[Cell, ...]:
    """Those of the cells on which a trial was not judged yet, with its values."""
    values = tuple(trial.values.items())
    return tuple(replace(cell, values=values) for cell in cells[len(trial.outcomes) :])


def ranges_of(controller: str) -> tuple[Range, ...]:
    """The parameters that a controller is tuned in. Raises DesignError for an unknown name."""
    own: ControllerKind = CONTROLLERS.find(controller, "--controller")
    return own.tuned


def points_of(box: Array, count: int, rng: np.random.Generator) -> Array:
    """``count`` Sobol points (count, d) of a box (d, 2) of shares."""
    points = _sobol(len(box), count, int(rng.integers(2**31)))
    return np.asarray(box[:, 0] + points * (box[:, 1] - box[:, 0]))


def _sobol(dimension: int, count: int, seed: int) -> Array:
    from scipy.stats import qmc

    power = max(count - 1, 0).bit_length()
    drawn = qmc.Sobol(dimension, scramble=True, seed=seed).random_base2(power)
    return np.asarray(drawn[:count])


def values_at(ranges: Sequence[Range], point: Array) -> dict[str, float]:
    """Values (by key) at a point of shares in [0, 1)."""
    return {each.key: each.at(float(share)) for each, share in zip(ranges, point, strict=True)}


def box_around(ranges: Sequence[Range], values: Values, width: float) -> Array:
    """A box of that width, as a share of the whole, around ``values``, inside the whole."""
    middle = np.array([each.share(values[each.key]) for each in ranges])
    low = np.clip(middle - 0.5 * width, 0.0, 1.0 - width)
    return np.column_stack([low, low + width])


def tuning_cells(
    controller: str,
    count: int,
    seed: int = 0,
    noises: Sequence[float] = (GOOD_AMPLIFIER,),
    perturbed: Perturbed | None = None,
) -> list[Cell]:
    """``count`` grips, the same for every controller; masses evenly by their logarithm.

    Frictions and masses are Sobol points of the grid's own span, none of them a point of the grid:
    a controller is not tuned to what it is judged on later. perturbed: each finger, of its faults
    in turn, lifts as many objects as in the study.
    """
    labels, lifts = ((NONE,), count) if perturbed is None else (perturbed.labels, perturbed.lifts)
    smooth, rough, light, heavy = FRICTIONS[0], FRICTIONS[-1], MASSES_G[0], MASSES_G[-1]
    return [
        Cell(
            controller,
            round(float(smooth + x * (rough - smooth)), 4),
            round(float(light * (heavy / light) ** y), 1),
            float(noises[k % len(noises)]),
            fault=labels[k // lifts % len(labels)],
            plant=k // lifts,
        )
        for k, (x, y) in enumerate(_sobol(2, count, seed_for(seed, "objects of a tuning")))
    ]


def tune_controllers(
    design: Design,
    bench: Bench,
    controllers: Sequence[str],
    journal: Journal,
    setting: TuningSetting,
    workers: int = 1,
    report: Report = lambda message, fraction: None,
) -> dict[str, Tuning]:
    """Tune each controller by the same procedure and the same number of grips.

    Grips that the journal holds are not run again. Raises SolverError where a process died.
    """
    budget, seed, found = setting.budget, bench.grid.seed, {}
    judge = bench_judge(bench, design, journal, workers)
    for number, name in enumerate(controllers):

        def shown(message: str, part: float, begun: int = number) -> None:
            report(message, (begun + part) / len(controllers))

        found[name] = tune(
            name,
            default_values(design, name),
            tuning_cells(name, budget[-1].grips, seed, setting.noises, bench.grid.perturbed),
            judge,
            budget=budget,
            seed=seed,
            report=shown,
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


def bench_judge(bench: Bench, design: Design, journal: Journal, workers: int) -> Judge:
    """A judge of trials on a bench that stores their grips; ``workers``: see run_batches.

    Both fingers are alike there, and noise and perturbed fingers are not the grid's.
    """
    grid = replace(bench.grid, seed=seed_for(bench.grid.seed, "tuning"), tug=None)
    tried: Bench = replace(bench, grid=grid)
    if isinstance(tried, GripBench):
        tried = replace(tried, opposite=None)

    def judged(batches: Sequence[tuple[Cell, ...]], report: Report) -> list[list[GripResult]]:
        once = list(dict.fromkeys(batches))  # Values may be tried twice.
        if grid.perturbed is not None:
            once = _by_finger(once)
        found = run_batches(tried, once, journal, workers, report, design.digest())
        return [[found[cell] for cell in batch] for batch in batches]

    return judged


def _by_finger(batches: Sequence[tuple[Cell, ...]]) -> list[tuple[Cell, ...]]:
    """The cells of all batches, those of one finger together: its model is made once."""
    fingers: dict[tuple[str, int], list[Cell]] = {}
    for cell in (cell for batch in batches for cell in batch):
        fingers.setdefault((cell.fault, cell.plant), []).append(cell)
    return [tuple(cells) for cells in fingers.values()]


def tuning_data(
    tuned: dict[str, Tuning], setting: TuningSetting, grid: ControlGrid, digest: str
) -> TuningData:
    """The tunings as plain values; digest: of the design before them."""
    count = setting.budget[-1].grips
    cells = tuning_cells("", count, grid.seed, setting.noises, grid.perturbed)
    fingers = 0 if grid.perturbed is None else len({cell.plant for cell in cells})
    return {
        "digest": digest,
        "fingers": fingers,
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
    cells = tuning["cells"]
    frictions, masses, noises = (
        [each[key] for each in cells]
        for key in ("friction_coefficient", "object_mass_g", "noise_microstrain")
    )
    levels = ", ".join(f"{noise:g}" for noise in sorted(set(noises)))
    own = f" of {tuning['fingers']} perturbed fingers" if tuning["fingers"] else ""
    head = [
        f"{design.design.name}, its controllers tuned by `fingerdesign study --tune` "
        f"(seed {seed}).",
        f"On {len(cells)} grips{own}: friction {min(frictions):.2g} to {max(frictions):.2g}, "
        f"{min(masses):.0f} to {max(masses):.0f} g, gage noise {levels} microstrain.",
        *(f"{name}: {_success(each)}" for name, each in tuning["controllers"].items()),
        "Other grips have other rates: see the study.",
    ]
    return "".join(f"# {line}\n" for line in head) + f"\n{dump_design(design)}"


def _success(found: ControllerTuningData) -> str:
    best, default = found["best"], found["default"]
    peak = best["mean_peak_ratio"]
    return (
        f"success {100 * best['success_rate']:.0f} % (before: {100 * default['success_rate']:.0f} "
        f"%), held {100 * best['held_rate']:.0f} %"
        f"{'' if peak is None else f', mean peak {peak:.2f} times the least force'}"
    )
