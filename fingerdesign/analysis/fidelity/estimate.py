"""The error of a model, estimated from its difference to the one before it.

An answer on elements of size h is taken to be off by c h^p. Two answers with sizes in the ratio
rho = h_coarse / h_fine differ by D, so the finer one is off by about

    D / (rho^p - 1)

(Richardson), p = ORDERS by quantity: plates' ends are singular, borders of contact and stick move
by parts of a facet. They were settled on three fingers of another seed than the bench's: the
largest whole or half orders at which four of five errors are under their estimate. (Median share
of the estimate, and in 95 of 100 cases: F_n 0.24, 1.4; F_t 0.51, 0.91; stick ratio 0.36, 1.3;
gages 0.29, 1.0.)

A quantity's error is that of 95 % of its readings; of the path, that of its worst quantity. Stick
ratios count where something pulls sideways: under approach alone they say how the path was cut
into increments.
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.analysis.fidelity.readings import NOT_PULLED, Readings, errors
from fingerdesign.arrays import Array

# Goals are what a controller reads, not energies. Contact width is reported, but not read.
GOALS = ("normal_force", "tangential_force", "stick_ratio", "gage")
ORDERS = {"normal_force": 1.0, "tangential_force": 2.0, "stick_ratio": 2.0, "gage": 1.0}
_PULLED = 1e-3  # of the path's largest F_t
SHARE = 0.95  # of the readings of a quantity that an error is meant for


@dataclass(frozen=True)
class Estimate:
    """Estimated errors by quantity, parts of one (see readings.errors for what they relate to)."""

    by_quantity: dict[str, float]

    @property
    def worst(self) -> float:
        """Estimated error of the worst quantity."""
        return max(self.by_quantity.values(), default=0.0)

    @property
    def worst_quantity(self) -> str:
        """Which quantity that is."""
        return max(self.by_quantity, key=lambda name: self.by_quantity[name])

    def plus(self, other: "Estimate") -> "Estimate":
        """Both errors together, at their worst."""
        names = {**self.by_quantity, **other.by_quantity}
        return Estimate(
            {n: self.by_quantity.get(n, 0.0) + other.by_quantity.get(n, 0.0) for n in names}
        )

    def refined(self, ratio: float) -> "Estimate":
        """Errors that are left on sizes ``ratio`` times smaller."""
        return Estimate({n: each / ratio ** ORDERS[n] for n, each in self.by_quantity.items()})


def difference(found: Readings, other: Readings) -> Estimate:
    """Distance of 95 % of the readings of each quantity are from ``other`` at the most."""
    return Estimate({name: of_most(each) for name, each in goal_errors(found, other).items()})


def goal_errors(found: Readings, truth: Readings) -> dict[str, Array]:
    """Errors of what a scene reads, by quantity, each in one row."""
    apart = errors(found, truth)
    every = {name: apart[name].reshape(-1) for name in GOALS}
    pull = np.abs(truth.tangential_force)
    most = float(pull.max(initial=0.0))
    if most > NOT_PULLED * np.abs(truth.normal_force).max(initial=0.0):
        every["stick_ratio"] = every["stick_ratio"][pull > _PULLED * most]
    return every


def of_most(values: Array) -> float:
    """The value that SHARE of all do not exceed; 0 of none."""
    flat = np.asarray(values).reshape(-1)
    return float(np.quantile(flat, SHARE)) if flat.size else 0.0


def discretisation(fine: Readings, coarse: Readings, ratio: float) -> Estimate:
    """The finer answer's own error, sizes being in ``ratio`` > 1. ValueError for another ratio."""
    if not ratio > 1.0:
        raise ValueError(f"ratio = {ratio} must be above 1: the coarser size over the finer one")
    apart = difference(coarse, fine).by_quantity
    return Estimate({name: each / (ratio ** ORDERS[name] - 1.0) for name, each in apart.items()})
