"""Two learners: a quick one that ranks gages by the hundred, and a network that confirms a few.

The quick one is ridge regression on the features and on random rectified sums of them (Rahimi and
Recht, "Random features for large-scale kernel machines", NIPS 2007), solved by normal equations.
Every subset of the gages has the same random sums, less the terms of the missing gages, so that two
subsets differ by their gages and not by chance. Its error is half as large again as the network's,
but it orders subsets alike. The network is that of sensing/train, trained for fewer epochs.

The features of fewer gages are fewer columns of the features of all (:func:`columns`), so grips are
made and sampled once. A gage that reads 0 without being known as dead changes its own columns; they
are found by sampling the same grips with all gages at 0 (:meth:`Samples.with_dead`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.control.estimator import Layer, outputs_of, standardised
from fingerdesign.control.features import FingerCurves, feature_count, readings_at
from fingerdesign.errors import SolverError
from fingerdesign.sensing.train.network import center_and_scale, train_layers
from fingerdesign.sensing.train.paths import RandomGripPath, Settings
from fingerdesign.sensing.train.samples import sample

# These fractions of the grips test the network and choose gages; the rest is for training.
TESTED, CHOSEN_BY = 0.15, 0.15
LEAST_GRIPS = 20  # Fewer grips cannot be divided into three parts.
_SUMS, _GAIN, _EDGE, _RIDGE = 384, 2.0, 2.0, 1e-3
_SCHEDULE = ((2e-3, 25), (5e-4, 12), (1e-4, 8))  # learning rate, epochs

Array32 = NDArray[np.float32]


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
    def tested(self) -> BoolArray:
        """Rows (n,) of grips for testing alone."""
        return self.grip < round(TESTED * self.grips)

    @property
    def chosen_by(self) -> BoolArray:
        """Rows (n,) of grips by whose errors gages are ranked."""
        return ~self.tested & (self.grip < round((TESTED + CHOSEN_BY) * self.grips))

    def with_dead(self, gage: int) -> Array:
        """Inputs (n, f) when gage ``gage`` reads 0 without being known as dead."""
        if self.silent is None:
            raise ValueError("sampled without silent gages")
        own = gage_columns(gage, self.gages)
        inputs = self.inputs.copy()
        inputs[:, own] = self.silent[:, own]
        return inputs


def gage_columns(gage: int, gages: int) -> IntArray:
    """Columns of the features that gage ``gage`` of ``gages`` makes: now, by lag, since the pull,
    at touch."""
    return gage + np.array(readings_at(gages))


def columns(some: Sequence[int], gages: int) -> IntArray:
    """Columns of the features with some gages alone, rising; forces and moves stay.

    >>> columns([0, 1], 2).tolist() == list(range(feature_count(2)))
    True
    >>> len(columns([1], 2)) == feature_count(1)
    True
    """
    out = [gage_columns(k, gages) for k in range(gages) if k not in set(some)]
    lost = np.concatenate(out) if out else np.zeros(0, dtype=np.int64)
    return np.setdiff1d(np.arange(feature_count(gages)), lost)


def sample_all(
    grips: Sequence[RandomGripPath],
    curves: FingerCurves,
    settings: Settings,
    noise: float,
    silent: bool = False,
    replicate: int = 0,
) -> Samples:
    """Sample every grip once at ``noise`` (microstrain); ``silent``: also with gages that read 0.

    The noise of a grip has its own seed, another in each ``replicate``. Raises SolverError where
    the grips hold no samples.
    """
    rows, mute, truths, owner = [], [], [], []
    for number, grip in enumerate(grips):
        seed = [settings.seed, 3, replicate, number]
        inputs, truth = sample(grip, curves, settings, np.random.default_rng(seed), noise)
        rows.append(inputs)
        truths.append(truth)
        owner.append(np.full(len(inputs), number, dtype=np.int64))
        if silent:  # The same seed gives the same forces.
            rng = np.random.default_rng(seed)
            mute.append(sample(_muted(grip), curves, settings, rng, 0.0)[0])
    inputs = np.concatenate(rows)
    if not len(inputs):
        raise SolverError("no grip has a sample with contact: there is nothing to learn from")
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


@dataclass(frozen=True)
class Errors:
    """Root mean square errors of stick ratio and friction utilisation, and by grip.

    squares (g, 2): sums of squares of each grip; rows (g,): rows of it.
    """

    stick: float
    utilisation: float
    squares: Array
    rows: Array

    @property
    def both(self) -> float:
        """Root of the mean of both squares, by which gages are ranked."""
        return float(np.sqrt(0.5 * (self.stick**2 + self.utilisation**2)))

    @property
    def stick_std(self) -> float:
        """Standard error of ``stick`` over draws of as many grips."""
        mean = self.stick**2
        off = self.squares[:, 0] - mean * self.rows
        return float(np.sqrt((off**2).sum()) / self.rows.sum() / max(2.0 * self.stick, 1e-12))


def errors_of(outputs: Array, truths: Array, grip: IntArray) -> Errors:
    """Errors of outputs (n, 2), clipped to 0 and 1, against truths (n, 2)."""
    off = (np.clip(outputs, 0.0, 1.0) - truths) ** 2
    _, own = np.unique(grip, return_inverse=True)
    squares = np.zeros((int(own.max()) + 1, 2))
    np.add.at(squares, own, off)
    stick, utilisation = np.sqrt(off.mean(axis=0))
    return Errors(float(stick), float(utilisation), squares, np.bincount(own).astype(float))


class QuickLearner:
    """Ridge regression on random rectified features of one replicate; threads may share it."""

    def __init__(self, sampled: Samples, seed: int) -> None:
        self._sampled = sampled
        training = ~sampled.tested & ~sampled.chosen_by
        self._center, self._scale = center_and_scale(sampled.inputs[training])
        rows = _known(sampled.inputs, self._center, self._scale).astype(np.float32)
        rng = np.random.default_rng([seed, 4])
        self._weight = _GAIN * rng.standard_normal((rows.shape[1], _SUMS)).astype(np.float32)
        self._bias = rng.uniform(-_EDGE, _EDGE, _SUMS).astype(np.float32)
        self._training, self._truths = rows[training], sampled.truths[training]
        self._ranking = rows[sampled.chosen_by]

    def errors(self, some: Sequence[int]) -> Errors:
        """Errors with some gages alone, on the grips that gages are chosen by."""
        own = columns(some, self._sampled.gages)
        rows = self._expanded(self._training[:, own], own)
        gram = (rows.T @ rows).astype(float) / len(rows)
        gram[np.diag_indices_from(gram)] += _RIDGE
        target = (rows.T @ self._truths.astype(np.float32)).astype(float) / len(rows)
        answer = np.linalg.solve(gram, target).astype(np.float32)
        outputs = (self._expanded(self._ranking[:, own], own) @ answer).astype(float)
        chosen = self._sampled.chosen_by
        return errors_of(outputs, self._sampled.truths[chosen], self._sampled.grip[chosen])

    def _expanded(self, rows: Array32, own: IntArray) -> Array32:
        factor = np.float32(1.0 / np.sqrt(len(own)))
        sums = np.maximum(rows @ (factor * self._weight[own]) + self._bias, np.float32(0.0))
        return np.hstack([rows, sums, np.ones((len(rows), 1), dtype=np.float32)])


def _known(inputs: Array, center: Array, scale: Array) -> Array:
    """Features in standard deviations; 0, the mean, of the few that are unknown."""
    return np.nan_to_num(standardised(inputs, center, scale))


@dataclass(frozen=True)
class Network:
    """A trained network on the columns ``own`` of the features."""

    own: IntArray
    center: Array
    scale: Array
    layers: tuple[Layer, ...]

    def evaluate(self, inputs: Array) -> Array:
        """Stick ratio and friction utilisation (n, 2) of features (n, f) of all gages."""
        rows = _known(inputs[:, self.own], self.center, self.scale)
        return outputs_of(self.layers, rows)


def train_network(replicates: Sequence[Samples], some: Sequence[int], seed: int) -> Network:
    """Train the network with some gages alone on every replicate of the grips not tested.

    Call it inside :func:`without_convergence_warnings`, which threads share.
    """
    own = columns(some, replicates[0].gages)
    inputs = np.concatenate([each.inputs[~each.tested][:, own] for each in replicates])
    truths = np.concatenate([each.truths[~each.tested] for each in replicates])
    center, scale = center_and_scale(inputs)
    rows = _known(inputs, center, scale).astype(np.float32)
    layers = train_layers(rows, truths, _SCHEDULE, seed)
    return Network(own, center, scale, layers)


def network_errors(network: Network, sampled: Samples, inputs: Array | None = None) -> Errors:
    """Errors on the tested grips; ``inputs`` (n, f) replaces the sampled features."""
    rows = sampled.tested
    outputs = network.evaluate((sampled.inputs if inputs is None else inputs)[rows])
    return errors_of(outputs, sampled.truths[rows], sampled.grip[rows])
