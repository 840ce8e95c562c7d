"""Sensitivity of each objective to each parameter: its share of the variance, and its direction.

By the model that proposes trials (propose.py), a Gaussian process through all of them:

share      of the metric's variance that goes with the parameter, alone or together with others:
           E[(f(x') - f(x))^2] / (2 var), where x' is x with the parameter of another trial (total
           effect, M. J. W. Jansen, Comput. Phys. Commun. 117, 1999)
direction  rank correlation of the changes f(x') - f(x) with those of the parameter; None for
           choices without an order

Trials of a search lie thick where fingers are good: what decides there is reported, not what
decides everywhere. ``explained`` says how far to believe it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve

from fingerdesign.arrays import Array
from fingerdesign.records.outcome import Outcome
from fingerdesign.runtime.threads import one_thread
from fingerdesign.search.optimise.propose import (
    MOST_KNOWN,
    gaussian_process,
    inputs_of,
    likeliest_kernel,
    shares_of,
)
from fingerdesign.search.study.file import Study
from fingerdesign.search.study.values import all_numbers

# Trials: below, nothing is reported. Of 15 trials by four seeds the first key of `better_maeno` was
# that of all 60.
LEAST = 12
SHUFFLES = 16
WEAK = 0.3  # explained: below, shares are no more than hints


@dataclass(frozen=True)
class Effect:
    """Effect of one parameter on one metric."""

    parameter: str
    share: float
    direction: float | None


@dataclass(frozen=True)
class Sensitivity:
    """Sensitivity of one metric; ``explained``: R2 of each trial by the others; effects: largest
    first."""

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
    with one_thread():
        return tuple(_of(study, outcomes, each.metric) for each in study.objectives)


def _of(study: Study, outcomes: Sequence[Outcome], metric: str) -> Sensitivity:
    known = [
        (outcome.values, float(value))
        for outcome in outcomes
        if (value := outcome.metrics.get(metric)) is not None
        and outcome.values.keys() >= study.parameters.keys()
    ]
    every = np.array([value for _, value in known])
    if len(known) < LEAST or np.ptp(every) <= 1e-9 * float(np.abs(every).max()):
        return Sensitivity(metric, len(known), None)
    chance = np.random.default_rng([study.study.seed, 3])
    some = np.sort(chance.permutation(len(known))[:MOST_KNOWN])
    inputs, of_key = inputs_of(study, shares_of(study, [known[k][0] for k in some]))
    model = gaussian_process(likeliest_kernel(inputs, every[some]), inputs, every[some])
    # Each trial by all others, in closed form; in units of the trials' own deviation.
    inverse = cho_solve((model.L_, True), np.eye(len(some)))
    left = np.square(model.alpha_ / inverse.diagonal()).mean()
    effects = []
    for place, (key, parameter) in enumerate(study.parameters.items()):
        columns = np.flatnonzero(of_key == place)
        own = np.tile(inputs, (SHUFFLES, 1))
        other = own.copy()
        other[:, columns] = inputs[chance.integers(len(inputs), size=len(own))][:, columns]
        change = model.predict(other) - np.tile(model.predict(inputs), SHUFFLES)
        share = 0.5 * float(np.square(change).mean()) / float(every.var())
        ordered = all_numbers(parameter)
        way = _correlation((other - own)[:, columns[0]], change) if ordered else None
        effects.append(Effect(key, share, way))
    effects.sort(key=lambda effect: -effect.share)
    return Sensitivity(metric, len(known), 1.0 - float(left), tuple(effects))


def _correlation(first: Array, second: Array) -> float:
    """Rank correlation; 0 where one of them does not change."""
    from scipy.stats import spearmanr

    still = min(np.ptp(first), np.ptp(second)) <= 0.0
    return 0.0 if still else float(spearmanr(first, second).statistic)
