"""One way of tuning for every controller: the same procedure, the same number of grips.

Rounds of trials, each judged on more grips than the last and searched in a smaller box:

    trials are Sobol points of the box of a controller's parameters, the design's own values first;
    the best go on to the next round, with new points of a box a third as wide around the best one.

A round's grips are the last round's and more, so what was gripped once is not gripped again. The
score is the success rate; ties (and they are frequent) go to the lower mean of the peak force over
the least force that would hold, of the grips that succeed. The best of the last round is taken.

The same seed gives the same trials, whatever the number of processes. A controller without
parameters of its own would still be given every round; an oracle has one.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.roster import ControllerKind, Range
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.result import GripResult
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials.grid import FRICTIONS, GOOD_AMPLIFIER, MASSES_G, Cell

Values = Mapping[str, float]
Report = Callable[[str, float], None]
Requested = Sequence[tuple[Values, Sequence[Cell]]]  # parameters, and the grips to judge them on
# Outcomes of each of what is requested, in order, each as soon as its grips are over.
Judge = Callable[[Requested], Iterable[list[GripResult]]]


@dataclass(frozen=True)
class Round:
    """New trials, next to the default and the best ones of the last round, judged on so many
    grips. The first round's trials include the default."""

    new: int
    best: int
    grips: int


BUDGET = (Round(32, 0, 16), Round(8, 8, 48), Round(4, 4, 96))  # 1808 grips
_SHRINK = 1.0 / 3.0  # of the box, from round to round


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

    controller: str
    seed: int
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
    ranges: Sequence[Range] | None = None,
    budget: Sequence[Round] = BUDGET,
    seed: int = 0,
    report: Report = lambda message, fraction: None,
) -> Tuning:
    """Tune one controller; ``default`` holds the design's own values of its parameters.

    cells: the grips, as many as the last round asks for; each round takes them from the start.
    Raises DesignError for a controller without ranges or too few grips.
    """
    own = ranges_of(controller) if ranges is None else tuple(ranges)
    if len(cells) < budget[-1].grips:
        bound = f"at least {budget[-1].grips}, as the last round asks for"
        raise DesignError([Fault("grips", len(cells), bound, "give more")])
    everything: list[Candidate] = []  # as last judged, in the order they were made
    going: list[int] = []  # those of the last round, the best first
    box = np.tile([0.0, 1.0], (len(own), 1))
    for number, each in enumerate(budget):
        report(f"{controller}: round {number + 1} of {len(budget)}", number / len(budget))
        made = [Candidate(dict(default), 0)] if number == 0 else []
        points = _points(box, each.new - len(made), np.random.default_rng([seed, number]))
        made += [Candidate(_values(own, point), number) for point in points]
        best = [k for k in going if k != 0][: each.best]
        # The default stays to the end: it is what the tuning improves on.
        chosen = [*([0] if going else []), *best]
        chosen += range(len(everything), len(everything) + len(made))
        everything += made
        # On those of the grips that they were not judged on yet.
        requested = [
            (everything[k].values, cells[len(everything[k].outcomes) : each.grips]) for k in chosen
        ]
        for k, found in zip(chosen, judge(requested), strict=True):
            everything[k] = replace(everything[k], outcomes=(*everything[k].outcomes, *found))
        going = sorted(chosen, key=lambda k: everything[k].order, reverse=True)
        box = _box_around(own, everything[going[0]].values, _SHRINK ** (number + 1))
    first, trials = everything[going[0]], tuple(everything)
    return Tuning(controller, seed, own, tuple(budget), trials, first, trials[0])


def ranges_of(controller: str) -> tuple[Range, ...]:
    """The parameters that a controller is tuned in. Raises DesignError for an unknown name."""
    own: ControllerKind = CONTROLLERS.find(controller, "--controller")
    return own.tuned


def _points(box: Array, count: int, rng: np.random.Generator) -> Array:
    """``count`` Sobol points (count, d) of a box (d, 2) of shares."""
    points = _sobol(len(box), count, int(rng.integers(2**31)))
    return np.asarray(box[:, 0] + points * (box[:, 1] - box[:, 0]))


def _sobol(dimension: int, count: int, seed: int) -> Array:
    from scipy.stats import qmc

    power = max(count - 1, 0).bit_length()
    drawn = qmc.Sobol(dimension, scramble=True, seed=seed).random_base2(power)
    return np.asarray(drawn[:count])


def _values(ranges: Sequence[Range], point: Array) -> dict[str, float]:
    return {each.key: each.at(float(share)) for each, share in zip(ranges, point, strict=True)}


def _box_around(ranges: Sequence[Range], values: Values, width: float) -> Array:
    """A box of that width, as a share of the whole, around ``values``, inside the whole."""
    middle = np.array([each.share(values[each.key]) for each in ranges])
    low = np.clip(middle - 0.5 * width, 0.0, 1.0 - width)
    return np.column_stack([low, low + width])


def tuning_cells(
    controller: str,
    count: int,
    seed: int = 0,
    noises: Sequence[float] = (GOOD_AMPLIFIER,),
) -> list[Cell]:
    """``count`` grips, the same for every controller; masses evenly by their logarithm.

    Frictions and masses are Sobol points of the grid's own span, none of them a point of the grid:
    a controller is not tuned to what it is judged on later.
    """
    smooth, rough, light, heavy = FRICTIONS[0], FRICTIONS[-1], MASSES_G[0], MASSES_G[-1]
    return [
        Cell(
            controller,
            round(float(smooth + x * (rough - smooth)), 4),
            round(float(light * (heavy / light) ** y), 1),
            float(noises[k % len(noises)]),
        )
        for k, (x, y) in enumerate(_sobol(2, count, seed))
    ]
