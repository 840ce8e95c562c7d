"""The law of friction mu = mu_0 (F / F_0)^-n on measured slips, and the lifts that it foretells.

n is by least squares of log mu against log F, with Student's 95 % interval over groups: trials at
one weight, or of one lift, are one case. Contact at constant shear strength has n = 1/3 where its
area grows as F^2/3, and n = 0 is Coulomb's law.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from fingerdesign.arrays import Array
from fingerdesign.records.statistics import Share, share_of
from fingerdesign.trials.recorded.pillars import Lift, PillarData

SPHERE = 1.0 / 3.0  # The exponent at constant shear strength: of theory, not fitted.


@dataclass(frozen=True)
class Exponent:
    """The exponent n with its 95 % interval; of so many values in so many groups."""

    value: float
    low: float
    high: float
    count: int
    groups: int


def exponent(
    force: Array, friction: Array, groups: Sequence[Hashable], levels: Sequence[Hashable] = ()
) -> Exponent:
    """n of friction (k,) against force (k,) N; each of the ``levels`` has its own mu_0.

    The variance is that of sums over groups, G / (G - 1) sum_g (sum_i x_i e_i)^2 / (sum x^2)^2 with
    x about its level's mean, and Student's t has G - 2 degrees of freedom (Liang and Zeger,
    Biometrika 73 (1986) 13). Raises ValueError for fewer than 3 groups.
    """
    x, y = np.log(force), np.log(friction)
    level = np.unique([str(each) for each in levels or [0] * len(x)], return_inverse=True)[1]
    group = np.unique([str(each) for each in groups], return_inverse=True)[1]
    count = int(group.max()) + 1
    if count < 3:
        raise ValueError(f"{count} groups: an exponent's interval needs 3")
    number = np.bincount(level)
    x, y = (each - (np.bincount(level, each) / number)[level] for each in (x, y))
    slope = float(x @ y / (x @ x))
    sums = np.bincount(group, x * (y - slope * x))
    variance = count / (count - 1) * float(sums @ sums) / float(x @ x) ** 2
    reach = float(stdtrit(count - 2, 0.975)) * float(np.sqrt(variance))
    return Exponent(-slope, -slope - reach, -slope + reach, len(x), count)


@dataclass(frozen=True)
class Foretold:
    """Forces (N) at which each weight slips, by a law that knows the lightest weight's friction
    alone; right: of the other weights' lifts, held or not, those foretold right."""

    name: str
    slips_at: tuple[float, ...]
    right: Share


def foretold(data: PillarData, name: str, n: float) -> Foretold:
    """What the law with the exponent n foretells: W = mu_0 (F / F_0)^-n F at the slip."""
    slow = slow_slips(data)
    (first, force), *_ = sorted(slow.items())
    at = {w: force * (w / first) ** (1.0 / (1.0 - n)) for w in sorted(slow)}
    others = [each for each in data.lifts if each.weight != first]
    right = sum((each.force > at[each.weight]) == (each.outcome == "held") for each in others)
    return Foretold(name, tuple(at.values()), share_of(right, len(others)))


def slow_slips(data: PillarData) -> dict[float, float]:
    """Mean force (N) of the lifts that slipped slowly, for each weight (N) that has some."""
    slow = _slow(data)
    weights = sorted({each.weight for each in slow})
    return {w: float(np.mean([e.force for e in slow if e.weight == w])) for w in weights}


def _slow(data: PillarData) -> list[Lift]:
    return [each for each in data.lifts if each.outcome == "slipped slowly"]


def whole_exponent(data: PillarData) -> Exponent:
    """n of whole contacts, by weight over normal force at slow slip; a weight is a group."""
    slow = _slow(data)
    force = np.array([each.force for each in slow])
    weight = np.array([each.weight for each in slow])
    return exponent(force, weight / force, weight.tolist())


def pillar_exponent(data: PillarData) -> Exponent:
    """n of single pillars as they slip, each pillar with its own mu_0; a lift is a group."""
    normal = np.array([each.normal for each in data.pillars])
    tangential = np.array([each.tangential for each in data.pillars])
    names = [each.name for each in data.pillars]
    return exponent(normal, tangential / normal, [each.lift for each in data.pillars], names)
