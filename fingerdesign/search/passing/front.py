"""The two goals of the gages over all trials of a search, and the front where they conflict.

A trial has a rank correlation (slip sensing; more is better) and a smallest stick change (gage
signal; less is better). The front is the trials that no other trial is better than in both.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from fingerdesign.analysis.detection import WANTED_STICK_CHANGE
from fingerdesign.analysis.shortfall import GAGE_SIGNAL, SLIP_SENSING
from fingerdesign.analysis.verdicts import GOOD_CORRELATION
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.compare.recommend import dominated

GOALS = (SLIP_SENSING, GAGE_SIGNAL)
Pair = tuple[float, float]


@dataclass(frozen=True)
class Front:
    """Trials as (rank correlation, smallest stick change), and those of the front, by falling
    correlation."""

    trials: tuple[Pair, ...]
    best: tuple[Pair, ...]

    @property
    def follows(self) -> tuple[Pair, ...]:
        """Trials whose gage area follows the stick area."""
        return tuple(pair for pair in self.trials if pair[0] >= GOOD_CORRELATION)

    @property
    def responds(self) -> tuple[Pair, ...]:
        """Trials whose gages show the change that is wanted."""
        return tuple(pair for pair in self.trials if pair[1] <= WANTED_STICK_CHANGE)

    @property
    def excludes(self) -> bool:
        """True if each goal is reached by some trial, and both by none."""
        follows, responds = {*self.follows}, {*self.responds}
        return bool(follows and responds) and not follows & responds

    def sentence(self) -> str:
        """Sentence on the front: the goals exclude each other, or at least one trial has both."""
        names = " and ".join(GOALS).capitalize()
        if not self.excludes:
            both = len(set(self.follows) & set(self.responds))
            return f"{names}: {both} of {len(self.trials)} trials reach both."
        near, far = min(self.follows, key=lambda pair: pair[1]), max(self.responds)
        return (
            f"{names} exclude each other here: on a front of {len(self.best)} trials "
            f"a rank correlation of {near[0]:.2f} comes with a smallest stick change of "
            f"{near[1]:.2g}, and a change of {far[1]:.2g} with a correlation of {far[0]:.2f}."
        )


def front_of(outcomes: Iterable[Outcome]) -> Front:
    """The front of the trials that have both numbers."""
    pairs = tuple(pair for each in outcomes for pair in pair_of(each))
    if not pairs:
        return Front((), ())
    behind = dominated(np.array(pairs) * [-1.0, 1.0])
    best = {pair for pair, worse in zip(pairs, behind, strict=True) if not worse}
    return Front(pairs, tuple(sorted(best, reverse=True)))


def pair_of(outcome: Outcome) -> Iterator[Pair]:
    """The outcome's two numbers; nothing where one lacks."""
    area, change = map(outcome.metrics.get, ("area_correlation", "smallest_stick_change"))
    if area is not None and change is not None:
        yield area, change
