"""Grips as rows of features, once for all subsets of the gages: what gages tell is read from these.

The features of fewer gages are fewer columns of the features of all (:func:`columns`), so grips are
made and heard once. A gage that reads 0 and is not known to be dead puts other numbers into its own
columns; they are found by hearing the same grips with all gages silent (:meth:`Heard.with_dead`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.control.estimator import LAGS, FingerCurves, feature_count
from fingerdesign.errors import SolverError
from fingerdesign.study.grip_paths import Wandering
from fingerdesign.study.teach import Settings, hear

JUDGED, CHOSEN_BY = 0.15, 0.15  # of the grips; the rest is taught
LEAST_GRIPS = 20  # fewer make no third part
_PER_FORCES, _PER_LAG = 3, 5  # features that hold no gage (estimator.features)


@dataclass(frozen=True)
class Heard:
    """Features of grips at one noise, with the truth.

    inputs (n, f); silent (n, f) or None: the same with every gage reading 0; truths (n, 2): stick
    ratio and F_t / (mu F_n); grip (n,): number of the grip that a row is of, of ``grips``.
    """

    inputs: Array
    silent: Array | None
    truths: Array
    grip: IntArray
    grips: int
    gages: int

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Rows (n,) of grips that nothing is taught on or chosen by."""
        return self.grip < round(JUDGED * self.grips)

    @property
    def chosen_by(self) -> NDArray[np.bool_]:
        """Rows (n,) of grips by whose errors gages are ranked."""
        return ~self.judged & (self.grip < round((JUDGED + CHOSEN_BY) * self.grips))

    def with_dead(self, gage: int) -> Array:
        """Inputs (n, f) when gage ``gage`` reads 0 and nobody knows."""
        if self.silent is None:
            raise ValueError("heard without silent gages")
        own = gage_columns(gage, self.gages)
        inputs = self.inputs.copy()
        inputs[:, own] = self.silent[:, own]
        return inputs


def gage_columns(gage: int, gages: int) -> IntArray:
    """Columns of the features that gage ``gage`` of ``gages`` makes: now, and over each lag."""
    first = gages + _PER_FORCES
    return np.array([gage, *(first + k * (gages + _PER_LAG) + gage for k in range(len(LAGS)))])


def columns(kept: Sequence[int], gages: int) -> IntArray:
    """Columns of the features that are left with the gages ``kept``, rising; forces and moves stay.

    >>> columns([0, 1], 2).tolist() == list(range(feature_count(2)))
    True
    >>> len(columns([1], 2)) == feature_count(1)
    True
    """
    out = [gage_columns(k, gages) for k in range(gages) if k not in set(kept)]
    lost = np.concatenate(out) if out else np.zeros(0, dtype=np.int64)
    return np.setdiff1d(np.arange(feature_count(gages)), lost)


def hear_all(
    grips: Sequence[Wandering],
    curves: FingerCurves,
    settings: Settings,
    noise: float,
    silent: bool = False,
    hearing: int = 0,
) -> Heard:
    """Every grip heard once at ``noise`` (microstrain); ``silent``: and with gages that read 0.

    Noise of a grip is from a seed of its own, another in each ``hearing``. Raises SolverError where
    the grips hold no samples.
    """
    rows, mute, truths, owner = [], [], [], []
    for number, grip in enumerate(grips):
        seed = [settings.seed, 3, hearing, number]
        inputs, truth = hear(grip, curves, settings, np.random.default_rng(seed), noise)
        rows.append(inputs)
        truths.append(truth)
        owner.append(np.full(len(inputs), number, dtype=np.int64))
        if silent:  # the same draws, and so the same forces
            rng = np.random.default_rng(seed)
            mute.append(hear(_muted(grip), curves, settings, rng, 0.0)[0])
    inputs = np.concatenate(rows)
    if not len(inputs):
        raise SolverError("no grip holds a sample with contact: nothing can be taught")
    return Heard(
        inputs,
        np.concatenate(mute) if silent else None,
        np.concatenate(truths),
        np.concatenate(owner),
        len(grips),
        curves.pressed.shape[1],
    )


def _muted(grip: Wandering) -> Wandering:
    moments = tuple(
        replace(each, sample=replace(each.sample, readings=np.zeros_like(each.sample.readings)))
        for each in grip.moments
    )
    return replace(grip, moments=moments)
