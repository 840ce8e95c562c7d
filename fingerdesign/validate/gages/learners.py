"""Two learners: a quick one that ranks gages by the hundred, and a network that confirms a few.

The quick one is ridge regression on the features and on random rectified sums of them (Rahimi and
Recht, "Random features for large-scale kernel machines", NIPS 2007), solved by normal equations.
Every subset of the gages has the same random sums, less what the left-out gages add, so that two
subsets differ by their gages and not by luck. It errs by half as much again as the network but
orders subsets alike; the network is the one of teach.py, taught for fewer epochs.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.control.estimator import (
    LAGS,
    FingerCurves,
    Layer,
    feature_count,
    outputs_of,
    standardised,
)
from fingerdesign.errors import SolverError
from fingerdesign.sensing.train.estimator import (
    RandomGripPath,
    Settings,
    sample,
    standard,
    trained,
)

# Grips as rows of features, once for all subsets of the gages: what gages tell is read from these.
#
# The features of fewer gages are fewer columns of the features of all (:func:`columns`), so grips
# are made and sampled once. A gage that reads 0 and is not known to be dead puts other numbers into
# its own columns; they are found by hearing the same grips with all gages silent
# (:meth:`Samples.with_dead`).

JUDGED, CHOSEN_BY = 0.15, 0.15  # of the grips; the rest is taught
LEAST_GRIPS = 20  # fewer make no third part
_PER_FORCES, _PER_LAG = 4, 7  # features that hold no gage (estimator.features)


@dataclass(frozen=True)
class Samples:
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
            raise ValueError("sampled without silent gages")
        own = gage_columns(gage, self.gages)
        inputs = self.inputs.copy()
        inputs[:, own] = self.silent[:, own]
        return inputs


def gage_columns(gage: int, gages: int) -> IntArray:
    """Columns of the features that gage ``gage`` of ``gages`` makes: now, by lag, since the pull,
    at touch."""
    first, each = gages + _PER_FORCES, gages + _PER_LAG
    return gage + np.array([0, *(first + each * np.arange(len(LAGS) + 2))])


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


def sample_all(
    grips: Sequence[RandomGripPath],
    curves: FingerCurves,
    settings: Settings,
    noise: float,
    silent: bool = False,
    hearing: int = 0,
) -> Samples:
    """Every grip sampled once at ``noise`` (microstrain); ``silent``: and with gages that read 0.

    Noise of a grip is from a seed of its own, another in each ``hearing``. Raises SolverError where
    the grips hold no samples.
    """
    rows, mute, truths, owner = [], [], [], []
    for number, grip in enumerate(grips):
        seed = [settings.seed, 3, hearing, number]
        inputs, truth = sample(grip, curves, settings, np.random.default_rng(seed), noise)
        rows.append(inputs)
        truths.append(truth)
        owner.append(np.full(len(inputs), number, dtype=np.int64))
        if silent:  # the same draws, and so the same forces
            rng = np.random.default_rng(seed)
            mute.append(sample(_muted(grip), curves, settings, rng, 0.0)[0])
    inputs = np.concatenate(rows)
    if not len(inputs):
        raise SolverError("no grip holds a sample with contact: nothing can be taught")
    return Samples(
        inputs,
        np.concatenate(mute) if silent else None,
        np.concatenate(truths),
        np.concatenate(owner),
        len(grips),
        curves.pressed.shape[1],
    )


def _muted(grip: RandomGripPath) -> RandomGripPath:
    moments = tuple(
        replace(each, sample=replace(each.sample, readings=np.zeros_like(each.sample.readings)))
        for each in grip.moments
    )
    return replace(grip, moments=moments)


Array32 = NDArray[np.float32]

_SUMS, _GAIN, _EDGE, _RIDGE = 384, 2.0, 2.0, 1e-3
_TEACHING = ((2e-3, 25), (5e-4, 12), (1e-4, 8))  # learning rate, epochs


@dataclass(frozen=True)
class Errors:
    """Root mean squares over rows of (stick ratio, used), and by grip.

    squares (g, 2): sums of squares of each grip; rows (g,): rows of it.
    """

    stick: float
    used: float
    squares: Array
    rows: Array

    @property
    def both(self) -> float:
        """Root of the mean of both squares, by which gages are ranked."""
        return float(np.sqrt(0.5 * (self.stick**2 + self.used**2)))

    @property
    def stick_spread(self) -> float:
        """Standard error of ``stick``: another draw of as many grips would move it by that."""
        mean = self.stick**2
        off = self.squares[:, 0] - mean * self.rows
        return float(np.sqrt((off**2).sum()) / self.rows.sum() / max(2.0 * self.stick, 1e-12))


def errors_of(said: Array, truths: Array, grip: NDArray[np.int64]) -> Errors:
    """Errors of what was said (n, 2), held within 0 and 1, against truths (n, 2)."""
    off = (np.clip(said, 0.0, 1.0) - truths) ** 2
    _, own = np.unique(grip, return_inverse=True)
    squares = np.zeros((int(own.max()) + 1, 2))
    np.add.at(squares, own, off)
    stick, used = np.sqrt(off.mean(axis=0))
    return Errors(float(stick), float(used), squares, np.bincount(own).astype(float))


class QuickLearner:
    """Ridge regression on random rectified features of one hearing; threads may share it."""

    def __init__(self, sampled: Samples, seed: int) -> None:
        self._sampled = sampled
        taught = ~sampled.judged & ~sampled.chosen_by
        self._center, self._scale = standard(sampled.inputs[taught])
        rows = standardised(sampled.inputs, self._center, self._scale).astype(np.float32)
        rng = np.random.default_rng([seed, 4])
        self._weight = _GAIN * rng.standard_normal((rows.shape[1], _SUMS)).astype(np.float32)
        self._bias = rng.uniform(-_EDGE, _EDGE, _SUMS).astype(np.float32)
        self._taught, self._taught_truths = rows[taught], sampled.truths[taught]
        self._ranking = rows[sampled.chosen_by]

    def errors(self, kept: Sequence[int]) -> Errors:
        """On the grips that gages are chosen by, with the gages ``kept`` alone."""
        own = columns(kept, self._sampled.gages)
        taught = self._made(self._taught[:, own], own)
        gram = (taught.T @ taught).astype(float) / len(taught)
        gram[np.diag_indices_from(gram)] += _RIDGE
        aim = (taught.T @ self._taught_truths.astype(np.float32)).astype(float) / len(taught)
        answer = np.linalg.solve(gram, aim).astype(np.float32)
        said = self._made(self._ranking[:, own], own) @ answer
        rows = self._sampled.chosen_by
        return errors_of(said.astype(float), self._sampled.truths[rows], self._sampled.grip[rows])

    def _made(self, rows: Array32, own: NDArray[np.int64]) -> Array32:
        share = np.float32(1.0 / np.sqrt(len(own)))
        sums = np.maximum(rows @ (share * self._weight[own]) + self._bias, np.float32(0.0))
        return np.hstack([rows, sums, np.ones((len(rows), 1), dtype=np.float32)])


@dataclass(frozen=True)
class Network:
    """A taught network on the columns ``own`` of the features."""

    own: NDArray[np.int64]
    center: Array
    scale: Array
    layers: tuple[Layer, ...]

    def say(self, inputs: Array) -> Array:
        """Stick ratio and used (n, 2) of features (n, f) of all gages."""
        rows = standardised(inputs[:, self.own], self.center, self.scale)
        return outputs_of(self.layers, rows)


def teach_network(hearings: Sequence[Samples], kept: Sequence[int], seed: int) -> Network:
    """Teach the network with the gages ``kept`` on every hearing of the grips not judged.

    Inside :func:`ends_as_meant`, which threads share.
    """
    own = columns(kept, hearings[0].gages)
    inputs = np.concatenate([each.inputs[~each.judged][:, own] for each in hearings])
    truths = np.concatenate([each.truths[~each.judged] for each in hearings])
    center, scale = standard(inputs)
    rows = standardised(inputs, center, scale).astype(np.float32)
    layers = trained(rows, truths, _TEACHING, seed)
    return Network(own, center, scale, layers)


def judged_errors(network: Network, sampled: Samples, inputs: Array | None = None) -> Errors:
    """On the judged grips; ``inputs`` (n, f) instead of those that were sampled."""
    rows = sampled.judged
    said = network.say((sampled.inputs if inputs is None else inputs)[rows])
    return errors_of(said, sampled.truths[rows], sampled.grip[rows])
