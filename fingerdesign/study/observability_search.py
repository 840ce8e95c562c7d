"""Which gages to keep: backward elimination, and the layouts that one would try unasked."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.runtime.progress import Tell
from fingerdesign.study.observability_learn import Errors, QuickLearner

Kept = tuple[int, ...]

_ONE_BY_ONE = 12  # with more gages than these, two go at a time


@dataclass(frozen=True)
class Elimination:
    """Gages taken away, least missed first.

    sets: kept gages -> errors, from all to none. without: for each gage the errors of all others.
    order: gages as they went; the last is the one that is missed most.
    """

    sets: dict[Kept, Errors]
    without: tuple[Errors, ...]
    order: Kept

    @property
    def counts(self) -> dict[int, Kept]:
        """The gages that were kept, by how many."""
        return {len(kept): kept for kept in self.sets}


def eliminate(learner: QuickLearner, gages: int, pool: Executor, tell: Tell) -> Elimination:
    """Take away what is missed least, by refitting without each in turn."""
    kept: Kept = tuple(range(gages))
    sets = {kept: learner.errors(kept)}
    order: list[int] = []
    without: tuple[Errors, ...] = ()
    while kept:
        tell(f"ranking gages: {len(kept)} left of {gages}")
        rest = [_less(kept, each) for each in kept]
        found = list(pool.map(learner.errors, rest))
        without = without or tuple(found)
        cheapest = np.argsort([each.both for each in found], kind="stable")
        out = [kept[k] for k in cheapest[: 2 if len(kept) > _ONE_BY_ONE else 1]]
        order += out
        kept = tuple(k for k in kept if k not in out)
        known = dict(zip(rest, found, strict=True))
        sets[kept] = known[kept] if kept in known else learner.errors(kept)
    return Elimination(sets, without, tuple(order))


def layouts(gage_x: Array, count: int) -> dict[str, Kept]:
    """Ways of placing ``count`` of the gages at ``gage_x`` (mm) that need no search.

    "spread": evenly over the array; "middle": neighbours about x = 0; "ends": half at each end.
    """
    order = np.argsort(gage_x, kind="stable")
    rank = np.arange(len(gage_x))
    even = np.unique(np.round(np.linspace(0, len(rank) - 1, count)).astype(int))
    near = rank[np.argsort(np.abs(gage_x[order]), kind="stable")[:count]]
    ends = [*rank[: (count + 1) // 2], *rank[len(rank) - count // 2 :]]
    return {
        name: tuple(sorted(int(order[k]) for k in places))
        for name, places in (("spread", even), ("middle", near), ("ends", ends))
    }


def _less(kept: Sequence[int], gage: int) -> Kept:
    return tuple(k for k in kept if k != gage)
