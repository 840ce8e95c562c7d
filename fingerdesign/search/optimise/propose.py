"""The next trial of a search: where a model of those that are known expects the most.

A Gaussian process (Matern 5/2, a length for each input; scikit-learn) is fitted to each objective,
and one to whether a trial is feasible. Of some thousand candidates, drawn at random and near the
best trials, the next is the one that maximises

    P(feasible)^2 E[growth of the volume that feasible trials dominate]

where the square keeps it off the borders at which trials fail: the best often lie there.

The volume is the mean, over random directions w > 0, of the greatest min_k ((c_k - y_k) / w_k)^m of
a trial, for m losses y below a corner c (J. Deng and Q. Zhang, IEEE Trans. Evol. Comput. 23, 2019).
A trial that waits for its results counts with what the model predicts of it (D. Ginsbourger, R. Le
Riche and L. Carraro, Kriging is well-suited to parallelize optimization, Springer 2010).
"""

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import compress, starmap
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.runtime.threads import one_thread
from fingerdesign.search.compare.recommend import dominated
from fingerdesign.search.study.file import Study
from fingerdesign.search.study.values import Choice, Range, all_numbers
from fingerdesign.search.study.variants import Values, at_shares, combinations

MOST_EXCESS = 1e6  # Of a constraint; that of a trial that failed.
FIRST = 4  # Trials that are spread over the ranges, before a model proposes any.
MOST_LISTED = 2000  # Combinations of values that are searched for one that is left.
MOST_KNOWN = 300  # Trials in a model: its time grows with their cube.
_APART = 0.02  # of the ranges: nearer to a known trial little is new.
_CANDIDATES, _STEP = 1024, 0.12  # So many at random and near good trials; a share's deviation.
_TRIES = 20  # Of the best candidates, and as many of all, until one can exist: 0.08 s each.
_DIRECTIONS, _DRAWS, _RESTARTS = 32, 16, 2
# Beyond so many inputs one length is for all, and beyond so many numbers one start: else a batch
# of 100 keys would wait for minutes.
_MOST_LENGTHS, _MANY = 20, 1000
# Bounds of a model's lengths, of its noise and of its variance, relative to ranges and variance.
# A length below 0.3 follows the jumps of peak_ratio, which are noise to a search.
_LENGTHS, _NOISES, _SCALES = (0.3, 10.0), (1e-4, 1.0), (0.05, 20.0)
_NEAR_FEASIBLE = -0.2  # Of a trial that nearly is feasible; 1: it is, -1: the farthest from it.


@dataclass(frozen=True)
class Known:
    """A trial: its values, the losses of its objectives (None where it failed), and the excess of
    each constraint (above 0: broken); both None where it waits for its results."""

    values: Mapping[str, Choice]
    losses: tuple[float, ...] | None = None
    broken: tuple[float, ...] | None = None


class Proposer:
    """Proposes trials one after the other; each then counts as one that waits for its results.

    known: all trials so far, in order; sound: whether values are a finger. What is none is proposed
    only where many others are none either.
    """

    def __init__(
        self, study: Study, known: Sequence[Known], sound: Callable[[Values], bool]
    ) -> None:
        self._study, self._known, self._sound = study, [*known], sound
        self._kernels: list[Any] = []  # Fitted to results, which do not change meanwhile.

    def next(self, seed: int) -> Values | None:
        """The values of the next trial; they depend on the seed and the known trials alone. None
        where all values are known."""
        done = [each for each in self._known if each.losses is not None]
        with one_thread():
            if len(self._known) < FIRST or len(done) < 2:
                ranked = _spread(self._study, len(self._known))
            else:
                ranked = self._ranked(np.random.default_rng(seed))
        rows = _first_and_some(ranked.tolist(), _TRIES)
        every = [at_shares(self._study, tuple(row)) for row in rows]
        new = self._new(every) or self._left(every)
        if not new:
            return None
        found = next(filter(self._sound, new[: 2 * _TRIES]), new[0])
        self._known.append(Known(found))
        return found

    def _new(self, every: Sequence[Values]) -> list[Values]:
        known = [each.values for each in self._known]
        return [each for each in every if each not in known]

    def _left(self, every: list[Values]) -> list[Values]:
        """Values that are not known yet, of all; of a space without end those that were drawn."""
        listed = combinations(self._study, MOST_LISTED)
        return every if listed is None else self._new(listed)

    def _ranked(self, chance: np.random.Generator) -> Array:
        """Shares of candidates for the next trial, the best first."""
        from scipy.spatial.distance import cdist

        study, models = self._study, _Models(self._study, _fewer(self._known), self._kernels)
        self._kernels = models.kernels
        near = models.best[chance.integers(len(models.best), size=_CANDIDATES)]
        near += _STEP * chance.standard_normal(near.shape) * (chance.random(near.shape) < 0.5)
        shares = np.vstack([chance.random(near.shape), np.clip(near, 0.0, 1.0)])
        inputs = inputs_of(study, shares)[0]
        known = inputs_of(study, shares_of(study, [each.values for each in self._known]))[0]
        apart = cdist(inputs, known, "chebyshev").min(axis=1) > _APART
        scores = np.where(apart, models.scores(inputs, chance), -1.0)
        return shares[np.argsort(-scores, kind="stable")]


def _first_and_some(items: list[Any], count: int) -> list[Any]:
    """The first items, and about as many of the others."""
    return [*items[:count], *items[count :: 1 + len(items) // count]]


def shares_of(study: Study, rows: Sequence[Mapping[str, Choice]]) -> Array:
    """Shares (n, parameters) of the ranges and choices that give the values."""
    return np.array(
        [
            [
                each.share(row[key])  # type: ignore[arg-type]
                if isinstance(each, Range)
                else (each.index(row[key]) + 0.5) / len(each)
                for key, each in study.parameters.items()
            ]
            for row in rows
        ]
    )


def inputs_of(study: Study, shares: Array) -> tuple[Array, IntArray]:
    """Columns from 0 to 1 of trials at shares: one of a number, one for each choice that has no
    order; and the place of the parameter that each column is of."""
    columns, of_key = list[Array](), list[int]()
    for place, (parameter, share) in enumerate(
        zip(study.parameters.values(), shares.T, strict=True)
    ):
        count = parameter.levels if isinstance(parameter, Range) else len(parameter)
        index = np.minimum((share * (count or 1)).astype(int), (count or 1) - 1)
        if isinstance(parameter, Range):
            own = [share if count is None else (index + 0.5) / count]
        elif all_numbers(parameter):
            numbers = np.array(parameter, dtype=float)
            own = [((numbers - numbers.min()) / (np.ptp(numbers) or 1.0))[index]]
        else:
            own = [(index == k).astype(float) for k in range(len(parameter))]
        columns += own
        of_key += [place] * len(own)
    return np.column_stack(columns), np.array(of_key)


def _spread(study: Study, index: int) -> Array:
    """Shares for the trial of an index; behind them those that no other of the first has."""
    from scipy.stats import qmc

    points: Any = qmc.Halton(len(study.parameters), rng=study.study.seed)
    return np.asarray(points.random(index + 2 * _TRIES * FIRST)[index::FIRST])


def _fewer(known: Sequence[Known]) -> list[Known]:
    """The trials for a model: the newest, and of the others those with least total loss."""
    if len(known) <= MOST_KNOWN:
        return list(known)
    newest, others = known[-MOST_KNOWN // 2 :], known[: -MOST_KNOWN // 2]
    done = [each for each in others if each.losses is not None]
    total = _tamed(np.array([each.losses for each in done])).sum(axis=1) if done else np.empty(0)
    total += 100.0 * np.array([max(each.broken or (0.0,), default=0.0) > 0.0 for each in done])
    best = [done[k] for k in np.argsort(total, kind="stable")]
    return [*best[: MOST_KNOWN - len(newest)], *newest]


class _Models:
    """Models of losses and of feasibility; best: shares of the trials to draw candidates near.

    kernels: of models that were fitted to the same results; none: they are fitted.
    """

    def __init__(self, study: Study, known: Sequence[Known], kernels: list[Any]) -> None:
        shares = shares_of(study, [each.values for each in known])
        inputs = inputs_of(study, shares)[0]
        done = np.array([each.broken is not None for each in known])
        valued = np.array([each.losses is not None for each in known])
        feasible = _feasibility([each.broken or () for each in compress(known, done)])
        losses = _tamed(np.array([each.losses for each in compress(known, valued)]))
        known_of = [(inputs[done], feasible), *((inputs[valued], each) for each in losses.T)]
        self.kernels = kernels or list(starmap(likeliest_kernel, known_of))
        self._feasible, *self._losses = (
            gaussian_process(kernel, *own, inputs[~done])
            for kernel, own in zip(self.kernels, known_of, strict=True)
        )
        # The model's own means, for a result that is good by chance alone is not to be beaten.
        means = np.column_stack([each.predict(inputs) for each in self._losses])
        label = np.ones(len(known))
        label[done] = feasible
        if not done.all():
            label[~done] = self._feasible.predict(inputs[~done])
        good = (valued | ~done) & (label > 0.0)
        self._corner = means.max(axis=0) + 0.1 * np.ptp(means, axis=0) + 1e-9
        self._reached = means[good]
        self.best = shares[_best(means, good & valued, np.where(valued, label, -2.0))]

    def scores(self, inputs: Array, chance: np.random.Generator) -> Array:
        """Scores of candidates (n,); where no trial is feasible, the probability that they are."""
        from scipy.special import ndtr

        mean, std = self._feasible.predict(inputs, return_std=True)
        likely: Array = ndtr(mean / np.maximum(std, 1e-9))
        if not len(self._reached):
            return likely
        found = [each.predict(inputs, return_std=True) for each in self._losses]
        mean, std = (np.column_stack(each) for each in zip(*found, strict=True))
        drawn = mean + std * chance.standard_normal((_DRAWS, 1, mean.shape[1]))
        grown = np.zeros(len(inputs))
        for way in np.abs(chance.standard_normal((_DIRECTIONS, mean.shape[1]))):
            reached = self._along(way, self._reached).max()
            grown += np.maximum(self._along(way, drawn) - reached, 0.0).mean(axis=0)
        return likely**2 * grown

    def _along(self, way: Array, losses: Array) -> Array:
        """The share (..., n) of a direction in the volume that losses (..., n, m) dominate."""
        way = np.maximum(way / np.linalg.norm(way), 1e-6)
        inside = ((self._corner - losses) / way).min(axis=-1)
        return np.asarray(np.maximum(inside, 0.0) ** len(way))


def _best(losses: Array, good: BoolArray, label: Array) -> IntArray:
    """Places of the good trials that no other dominates; where none is good those nearest to it."""
    front = np.flatnonzero(good)
    if not len(front):
        return np.argsort(-label, kind="stable")[:3]
    return np.asarray(front[~dominated(losses[front])])


def _feasibility(broken: Iterable[tuple[float, ...]]) -> Array:
    """1 for a feasible trial; for others below 0, less the more they break. What failed breaks all
    by an excess that says nothing of the others'."""
    excess = np.maximum(np.array([(*each, 0.0) for each in broken]), 0.0)
    most = np.where(excess < MOST_EXCESS, excess, 0.0).max(axis=0)
    total = np.minimum(excess / np.maximum(most, 1e-300), 1.0).sum(axis=1)
    worst = _NEAR_FEASIBLE - (1.0 + _NEAR_FEASIBLE) * total / max(total.max(), 1e-300)
    return np.where(total > 0.0, worst, 1.0)


def _tamed(losses: Array) -> Array:
    """Losses (n, m) relative to the median, in widths of the middle half; extremes are drawn in."""
    low, middle, high = np.percentile(losses, (25, 50, 75), axis=0)
    width = np.where(high > low, high - low, losses.std(axis=0))
    return np.asarray(np.arcsinh((losses - middle) / np.where(width > 0.0, width, 1.0)))


def likeliest_kernel(inputs: Array, values: Array) -> Any:
    """The kernel under which values are likeliest."""
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    count, size = inputs.shape
    smooth = Matern(np.full(size, 0.7), _LENGTHS, nu=2.5)
    if size > _MOST_LENGTHS:
        smooth = Matern(0.3 * np.sqrt(size), (0.3, 10.0 * np.sqrt(size)), nu=2.5)
    kernel = ConstantKernel(1.0, _SCALES) * smooth + WhiteKernel(1e-2, _NOISES)
    restarts = _RESTARTS if count * size < _MANY else 0
    model = GaussianProcessRegressor(
        kernel, normalize_y=True, n_restarts_optimizer=restarts, random_state=0
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # A length may end at its bound.
        return model.fit(inputs, values).kernel_


def gaussian_process(
    kernel: Any, inputs: Array, values: Array, waiting: Array | None = None
) -> Any:
    """A Gaussian process through values, and through its own means at the inputs that wait."""
    from sklearn.gaussian_process import GaussianProcessRegressor

    model = GaussianProcessRegressor(kernel, optimizer=None, normalize_y=True)
    model.fit(inputs, values)
    if waiting is None or not len(waiting):
        return model
    again = GaussianProcessRegressor(kernel, optimizer=None, normalize_y=True)
    return again.fit(np.vstack([inputs, waiting]), np.append(values, model.predict(waiting)))
