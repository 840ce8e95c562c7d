"""Sensitivity of each objective to each parameter: its share of the variance, and its direction.

share      of the metric's variance that goes with the parameter, alone or in concert: half the
           growth of a forest's squared error when the parameter's values are shuffled, on trials
           that it was not trained on (permutation importance, L. Breiman, Random forests, Machine
           Learning 45, 2001; the half makes it the total effect of M. J. W. Jansen, Comput. Phys.
           Commun. 117, 1999)
direction  rank correlation with the metric, the other parameters' ranks held (partial rank
           correlation); None for choices without an order

Trials of a search lie thick where fingers are good: what decides there is reported, not what
decides everywhere. ``explained`` says how far to believe it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.optimise.propose import inputs_of, shares_of
from fingerdesign.search.study.file import Study
from fingerdesign.search.study.values import all_numbers

LEAST = 20  # trials: below, nothing is reported
TREES, FOLDS, SHUFFLES = 60, 5, 4
WEAK = 0.3  # explained: below, shares are no more than hints


@dataclass(frozen=True)
class Effect:
    """Effect of one parameter on one metric; ``spread``: standard error of ``share`` over folds."""

    parameter: str
    share: float
    spread: float
    direction: float | None


@dataclass(frozen=True)
class Sensitivity:
    """Sensitivity of one metric; ``explained``: R2 on other trials; effects: largest first."""

    metric: str
    count: int
    explained: float | None
    effects: tuple[Effect, ...] = ()

    @property
    def words(self) -> str:
        """Sentence on how reliable it is."""
        if self.explained is None:
            return f"{self.metric}: of {self.count} trials too few differ (at least {LEAST})"
        much = f"{100 * max(self.explained, 0.0):.0f} % of its variance is predicted"
        hint = "; the shares are hints at best" if self.explained < WEAK else ""
        return f"{self.metric}: over {self.count} trials {much}{hint}"


def sensitivities(study: Study, outcomes: Sequence[Outcome]) -> tuple[Sensitivity, ...]:
    """Compute the sensitivity of each of the study's objectives to each parameter; seeded."""
    return tuple(_of(study, outcomes, each.metric) for each in study.objectives)


def _of(study: Study, outcomes: Sequence[Outcome], metric: str) -> Sensitivity:
    keys = list(study.parameters)
    known = [
        (outcome, float(value))
        for outcome in outcomes
        if (value := outcome.metrics.get(metric)) is not None
        and all(key in outcome.values for key in keys)
    ]
    truth = np.array([value for _, value in known])
    if len(known) < LEAST or np.ptp(truth) <= 1e-9 * float(np.abs(truth).max()):
        return Sensitivity(metric, len(known), None)
    shares = shares_of(study, [outcome.values for outcome, _ in known])
    inputs, of_key = inputs_of(study, shares)
    explained, shares = _importance(inputs, of_key, truth, study.study.seed)
    directions = _directions(study, inputs, of_key, truth)
    spreads = shares.std(axis=0, ddof=1) / np.sqrt(len(shares))
    columns = zip(keys, shares.mean(axis=0).tolist(), spreads.tolist(), directions, strict=True)
    effects = sorted((Effect(*each) for each in columns), key=lambda e: -e.share)
    return Sensitivity(metric, len(known), explained, tuple(effects))


def _importance(inputs: Array, of_key: IntArray, truth: Array, seed: int) -> tuple[float, Array]:
    """R2 on held-out trials; and (folds, parameters) shares of the variance."""
    from sklearn.ensemble import RandomForestRegressor

    rng = np.random.default_rng([seed, 3])
    fold = rng.permutation(np.arange(len(truth)) % FOLDS)
    reported = np.empty_like(truth)
    shares = np.zeros((FOLDS, int(of_key.max()) + 1))
    variance = float(truth.var())
    for k in range(FOLDS):
        out = fold == k
        forest = RandomForestRegressor(TREES, min_samples_leaf=2, random_state=seed)
        forest.fit(inputs[~out], truth[~out])
        reported[out] = forest.predict(inputs[out])
        error = float(((reported[out] - truth[out]) ** 2).mean())
        mixed = np.tile(inputs[out], (shares.shape[1], SHUFFLES, 1, 1))
        for place, shuffles in enumerate(mixed):
            columns = np.flatnonzero(of_key == place)
            for own in shuffles:
                # From all trials, not of these few alone: a fold's own shuffles are few.
                own[:, columns] = inputs[rng.integers(len(truth), size=len(own))][:, columns]
        # All at once: a forest takes milliseconds to begin.
        found = forest.predict(mixed.reshape(-1, inputs.shape[1])).reshape(mixed.shape[:3])
        worse = ((found - truth[out]) ** 2).mean(axis=2).mean(axis=1)
        shares[k] = 0.5 * (worse - error) / variance
    return 1.0 - float(((reported - truth) ** 2).mean()) / variance, shares


def _directions(study: Study, inputs: Array, of_key: IntArray, truth: Array) -> list[float | None]:
    """Partial rank correlation of each parameter that has an order; equal values share a rank."""
    from scipy.stats import rankdata

    ranks, target = (
        each - each.mean(axis=0) for each in (rankdata(inputs, axis=0), rankdata(truth))
    )
    found: list[float | None] = []
    for place, parameter in enumerate(study.parameters.values()):
        if not all_numbers(parameter):
            found.append(None)
            continue
        own = of_key == place
        others = np.column_stack([ranks[:, ~own], np.ones(len(truth))])
        rest = [
            each - others @ np.linalg.lstsq(others, each, rcond=None)[0]
            for each in (ranks[:, own][:, 0], target)
        ]
        size = float(np.linalg.norm(rest[0]) * np.linalg.norm(rest[1]))
        found.append(float(rest[0] @ rest[1]) / size if size > 1e-9 * len(truth) else 0.0)
    return found
