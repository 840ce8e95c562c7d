"""The law of friction mu = mu_0 (F / F_0)^-n on measured slips, and the lifts that it foretells.

n is by least squares of log mu against log F, with Student's 95 % interval over groups. Coulomb's
law has n = 0, contact at constant shear strength n = 1/3 where its area grows as F^(2/3).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

import numpy as np
from scipy.special import stdtrit

from fingerdesign.arrays import Array
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import Count, Size, closed
from fingerdesign.records.statistics import Share, share_of
from fingerdesign.trials.recorded.pillars import Lift, PillarData, read_pillars

CONSTANT = 1.0 / 3.0  # the exponent at constant shear strength: of theory, not fitted


@closed
@dataclass(frozen=True)
class Exponent:
    """The exponent n with its 95 % interval; of so many values in so many groups."""

    value: float
    low: float
    high: float
    count: Count
    groups: Count


@closed
@dataclass(frozen=True)
class Foretold:
    """Forces at which each weight slips, by a law with the exponent n that knows the lightest
    weight's friction alone; right: of the other weights' lifts, those foretold right."""

    law: str
    n: float
    slips_at_N: tuple[Size, ...]
    right: Share


@closed
@dataclass(frozen=True)
class FrictionData:
    """The law of friction on a set of lifts. slow_N: mean forces at which each weight slips slowly;
    own_N: those of the authors' hand; whole: the exponent of the whole contact, by weight over
    force at slow slip; single: of single pillars as they slip."""

    weights_N: tuple[Size, ...]
    slow_N: tuple[Size, ...]
    own_N: tuple[Size, ...]
    whole: Exponent
    single: Exponent
    foretold: tuple[Foretold, ...]


def exponent(
    force: Array, friction: Array, groups: Sequence[object], levels: Sequence[object] = ()
) -> Exponent:
    """n of friction (k,) against force (k,) N; each of the ``levels`` has its own mu_0.

    The variance is that of sums over groups, G / (G - 1) sum_g (sum_i x_i e_i)^2 / (sum x^2)^2 with
    x about its level's mean (Liang and Zeger, Biometrika 73 (1986) 13), and Student's t has G - 2
    degrees of freedom. ValueError for fewer than 3 groups.
    """
    level, group = (
        np.unique([str(each) for each in labels], return_inverse=True)[1]
        for labels in (levels or [0] * len(force), groups)
    )
    count = int(group.max()) + 1
    if count < 3:
        raise ValueError(f"{count} groups: an exponent's interval needs 3")
    x, y = np.log(force), np.log(friction)
    x, y = (v - (np.bincount(level, v) / np.bincount(level))[level] for v in (x, y))
    slope = float(x @ y / (x @ x))
    sums = np.bincount(group, x * (y - slope * x))
    deviation = np.sqrt(count / (count - 1) * (sums @ sums)) / (x @ x)
    reach = float(stdtrit(count - 2, 0.975) * deviation)
    return Exponent(-slope, -slope - reach, -slope + reach, len(x), count)


def read_friction(path: Path) -> FrictionData:
    """The laws on a workbook; DesignError where it is another file, or has too few slips."""
    data = read_pillars(path)
    try:
        with np.errstate(divide="raise", over="raise", invalid="raise"):
            return judge_friction(data)
    except (ValueError, ArithmeticError) as error:
        fault = Fault("recording", str(path), "of forces over 0", f"fetch it again ({error})")
        raise DesignError([fault]) from None


def judge_friction(data: PillarData) -> FrictionData:
    """The exponents of the thesis's lifts, and what three laws foretell of them."""
    slow = [each for each in data.lifts if each.outcome == "slipped slowly"]
    weight, force = np.array([(each.weight, each.force) for each in slow]).T
    weights = np.unique(weight)
    means = [float(force[weight == w].mean()) for w in weights]
    own = [fmean(each.force for each in data.own if each.weight == w) for w in weights]
    normal, tangential = np.array([(each.normal, each.tangential) for each in data.pillars]).T
    lifts, names = [each.lift for each in data.pillars], [each.name for each in data.pillars]
    single = exponent(normal, tangential / normal, lifts, names)
    laws = {"Coulomb": 0.0, "of single pillars": single.value, "constant strength": CONSTANT}
    foretold = tuple(_foretold(data.lifts, *law, weights, means[0]) for law in laws.items())
    whole = exponent(force, weight / force, weight.tolist())
    return FrictionData(tuple(weights.tolist()), tuple(means), tuple(own), whole, single, foretold)


def _foretold(lifts: Sequence[Lift], law: str, n: float, weights: Array, first: float) -> Foretold:
    """Forecast of a law: W = mu_0 (F / F_0)^-n F at the slip, from the lightest weight's F."""
    at = (first * (weights / weights[0]) ** (1.0 / (1.0 - n))).tolist()
    slips_at = dict(zip(weights.tolist(), at, strict=True))
    others = [each for each in lifts if each.weight > weights[0]]
    right = sum((each.force > slips_at[each.weight]) == (each.outcome == "held") for each in others)
    return Foretold(law, n, tuple(at), share_of(right, len(others)))
