"""The outcomes of a large study that a page shows: its front, and those nearest to it.

A page of 100,000 fingers is no page. Of an objective less is taken for better after its sign; those
that break a bound, fail or lack an objective are left out. The front is never thinned unless it is
itself longer than the page.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.records.columns import metrics_at, outcomes_at
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.compare.recommend import USUAL_OBJECTIVES, Bound, Objective
from fingerdesign.search.run.run import Store, StoreError
from fingerdesign.search.study.metrics import METRICS

COLUMNS_FILE = "outcomes.sqlite"
MANY = 5000  # outcomes: above that a study is stored in columns; 5,000 lines take 250 MB
MOST_SHOWN = 300  # of those, on a page: it opens in a second
_WHOLE = 40  # of them with their design, paths and grips, as the user's store has them


def best_of(
    paths: Sequence[Path], objectives: Sequence[Objective], bounds: Sequence[Bound]
) -> tuple[tuple[Outcome, ...], ...]:
    """The outcomes to show of files of columns, of all together, file by file.

    Without objectives the usual ones count that a row has. Raises ColumnError.
    """
    chosen = tuple(objectives) or tuple(
        Objective(name, METRICS[name].better or "min") for name in USUAL_OBJECTIVES
    )
    names = [each.metric for each in chosen] + [each.metric for each in bounds]
    tables, parts = zip(*(metrics_at(path, names) for path in paths), strict=True)
    table, good = np.concatenate(tables), np.concatenate(parts)
    losses = table[:, : len(chosen)] * [1.0 if each.goal == "min" else -1.0 for each in chosen]
    if not objectives:
        losses = losses[:, np.isfinite(losses[good]).any(axis=0)]
    within = _within(table[:, len(chosen) :], bounds)
    feasible = good & within & np.isfinite(losses).all(axis=1)
    among = next((np.flatnonzero(m) for m in (feasible, good) if m.any()), np.arange(len(good)))
    rows = among[_first(np.nan_to_num(losses[among], nan=np.inf))]
    return _outcomes(paths, [*map(len, parts)], rows)


def _outcomes(
    paths: Sequence[Path], counts: Sequence[int], rows: IntArray
) -> tuple[tuple[Outcome, ...], ...]:
    """Outcomes of rows of all files together, file by file; the first ones as the store has them.

    counts: rows of each file.
    """
    ends, whole = np.cumsum(counts), set(rows[:_WHOLE].tolist())
    of_file, found = np.searchsorted(ends, rows, side="right"), []
    for number, path in enumerate(paths):
        own = rows[of_file == number]
        outcomes = outcomes_at(path, (own - int(ends[number]) + counts[number]).tolist())
        pairs = zip(own.tolist(), outcomes, strict=True)
        found.append(tuple(_whole(each) if row in whole else each for row, each in pairs))
    return tuple(found)


def _within(values: Array, bounds: Sequence[Bound]) -> BoolArray:
    """Mark the rows whose values (n, bounds) are within all bounds."""
    found = np.ones(len(values), dtype=bool)
    for each, value in zip(bounds, values.T, strict=True):
        low = -np.inf if each.at_least is None else each.at_least
        high = np.inf if each.at_most is None else each.at_most
        found &= (value >= low) & (value <= high)
    return found


def _first(losses: Array) -> IntArray:
    """Numbers of the rows to show: those of the front by their distance, then the others'."""
    low, high = losses.min(axis=0), losses.max(axis=0)
    width = np.where((high > low) & np.isfinite(high - low), high - low, np.inf)
    scaled = np.nan_to_num((losses - low) / width, nan=0.0)
    distance = (scaled**2).sum(axis=1)
    return np.asarray(np.lexsort((distance, ~on_front(scaled)))[:MOST_SHOWN])


def on_front(losses: Array) -> BoolArray:
    """Mark rows that no other row beats in all columns at once or in one at no cost.

    >>> on_front(np.array([[1.0, 2.0], [2.0, 1.0], [2.0, 2.0]])).tolist()
    [True, True, False]
    """
    left = np.lexsort((np.arange(len(losses)), losses.sum(axis=1)))  # a row beats only later ones
    found = np.zeros(len(losses), dtype=bool)
    while len(left):
        own = losses[left[0]]
        found[left[0]] = True
        beaten = (losses[left] >= own).all(axis=1) & (losses[left] > own).any(axis=1)
        beaten[0] = True
        left = left[~beaten]
    return found


def _whole(own: Outcome) -> Outcome:
    """The outcome as the user's store has it, with the names and values of its study."""
    try:
        found = Store().get(own.digest)
    except (StoreError, ValueError):
        return own
    if found is None or found.status != own.status:
        return own
    return replace(found, name=own.name, values=own.values, scene=own.scene, metrics=own.metrics)
