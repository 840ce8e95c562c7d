"""Numbers of many cases as records hold them: each with its count and a 95 % interval."""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field
from scipy.special import bdtr, betaln, stdtrit

from fingerdesign.records.base import Count, Size, closed

_Z = 1.959964  # of the normal distribution, for 95 %
_TAIL = 0.025  # outside either end of an interval
_RATES, _CORRELATIONS = 400, 40  # Points of the integrals; twice as many move no end by 0.002.

Rate = Annotated[float, Field(ge=0.0, le=1.0)]


@closed
@dataclass(frozen=True)
class Share:
    """``count`` of ``of``; low, high: Wilson's 95 % interval, as if trials were independent; null
    of nothing. Where trials come in clusters (steps of grips, lifts of fingers) the interval is
    that of the clusters: see clustered_share and beta_binomial_share.

    >>> share_of(99, 100).rate
    0.99
    """

    count: Count
    of: Count
    rate: Rate | None
    low: Rate | None
    high: Rate | None


def share_of(count: int, of: int, worth: float | None = None) -> Share:
    """A share with the score interval of its rate, good near 0 and 1 too.

    (p + z^2/2n -+ z sqrt(p (1 - p)/n + z^2/4n^2)) / (1 + z^2/n)

    (Wilson, J. Am. Stat. Assoc. 22 (1927) 209.) worth: n, where it is less than ``of``.
    """
    if not of:
        return Share(count, of, None, None, None)
    p, share = count / of, _Z * _Z / (worth or of)
    middle = p + 0.5 * share
    half = _Z * math.sqrt(p * (1.0 - p) * share / (_Z * _Z) + 0.25 * share * share / (_Z * _Z))
    low = (middle - half) / (1.0 + share) if count else 0.0
    high = (middle + half) / (1.0 + share) if count < of else 1.0
    return Share(count, of, p, low, high)


def clustered_share(counts: Iterable[int], of: Iterable[int]) -> Share:
    """Share of trials in clusters (k,): the n of Wilson's interval is cut to what they are worth,

    n = p (1 - p) / var(p),   var(p) = k / (k - 1) sum (y_i - p n_i)^2 / (sum n_i)^2,

    at most their number (Korn and Graubard, Surv. Methodol. 24 (1998) 193). Where there is none at
    all, the high end is of clusters that have one each: Wilson's of 0 in k, times k / sum n_i.
    """
    y, n = np.array(list(counts), dtype=float), np.array(list(of), dtype=float)
    y, n = y[n > 0.0], n[n > 0.0]
    total, clusters = float(n.sum()), len(n)
    if not clusters:
        return share_of(0, 0)
    p = float(y.sum()) / total
    if p == 0.0:
        high = share_of(0, clusters).high or 0.0
        return Share(0, int(total), 0.0, 0.0, high * clusters / total)
    worth = float(clusters)
    if clusters > 1:
        spread = clusters / (clusters - 1) * float(((y - p * n) ** 2).sum()) / total**2
        worth = min(p * (1.0 - p) / spread, total) if p < 1.0 and spread > 0.0 else total
    return share_of(int(y.sum()), int(total), worth)


def beta_binomial_share(counts: Iterable[int], of: Iterable[int]) -> Share:
    """Share of trials in clusters (k,), each with a rate of its own: lifts of fingers, say.

    y_i ~ BetaBinomial(n_i, p s, (1 - p) s),   s = (1 - r) / r,

    with the correlation r of two trials of a cluster. p and r are equally likely from 0 to 1
    beforehand; low and high are the ends of the middle 95 % of what is then likely of p, and 0 or 1
    where no trial or every one counts.
    """
    pairs = Counter(pair for pair in zip(counts, of, strict=True) if pair[1])
    count, total = (sum(k * pair[j] for pair, k in pairs.items()) for j in (0, 1))
    if not total:
        return share_of(0, 0)
    p = ((np.arange(_RATES) + 0.5) / _RATES)[:, None]
    r = (np.arange(_CORRELATIONS) + 0.5) / _CORRELATIONS
    a, b = p * (1.0 - r) / r, (1.0 - p) * (1.0 - r) / r
    likely = sum(k * (betaln(y + a, n - y + b) - betaln(a, b)) for (y, n), k in pairs.items())
    mass = np.exp(likely - np.max(likely)).sum(axis=1)
    below = np.concatenate([[0.0], np.cumsum(mass) / mass.sum()])
    low, high = np.interp([_TAIL, 1.0 - _TAIL], below, np.arange(_RATES + 1) / _RATES).tolist()
    low, high = low if count else 0.0, high if count < total else 1.0
    return Share(int(count), int(total), float(count / total), low, high)


@closed
@dataclass(frozen=True)
class Spread:
    """Distribution of the values that exist.

    low, high: quartiles. median_low, median_high: 95 % interval of the median, between two of the
    values by their order; null of fewer than six.
    """

    count: Count
    least: Size
    low: Size
    median: Size
    high: Size
    most: Size
    median_low: Size | None
    median_high: Size | None


def spread_of(values: Iterable[float | None]) -> Spread | None:
    """The spread of those values that are there; None where none is.

    The median lies between the k-th least and the k-th greatest value with a probability of
    1 - 2 P(B < k), B the heads among as many throws of a coin: at least 95 % for the k taken.
    """
    found = sorted(value for value in values if value is not None)
    if not found:
        return None
    low = high = None
    rank = next(k for k in range(len(found)) if bdtr(k, len(found), 0.5) > _TAIL)
    if rank:
        low, high = float(found[rank - 1]), float(found[-rank])
    first, median, third = np.quantile(found, [0.25, 0.5, 0.75]).tolist()
    return Spread(len(found), found[0], first, median, third, found[-1], low, high)


@closed
@dataclass(frozen=True)
class Rms:
    """Root mean square over all ``samples`` of ``count`` grips; low, high: its 95 % interval, grips
    being the independent cases; null of one grip."""

    count: Count
    samples: Count
    value: Size
    low: Size | None
    high: Size | None


def rms_of(errors: Iterable[float], samples: Iterable[int]) -> Rms | None:
    """Combine grips' own root mean squares (k,) over so many samples each; None of none.

    m = sum n_i e_i^2 / sum n_i is a ratio of sums over clusters, with the variance
    k / (k - 1) sum n_i^2 (e_i^2 - m)^2 / (sum n_i)^2. The interval is Student's (k - 1 degrees of
    freedom) of log m, halved: of an error, which is above 0.
    """
    error, n = np.array(list(errors), dtype=float), np.array(list(samples), dtype=float)
    clusters, total = len(error), n.sum()
    if not clusters:
        return None
    mean = float((n * error**2).sum() / total)
    value = math.sqrt(mean)
    if clusters == 1:
        return Rms(clusters, int(total), value, None, None)
    variance = clusters / (clusters - 1) * float(((n * (error**2 - mean)) ** 2).sum()) / total**2
    reach = 0.0
    if mean > 0.0:
        reach = 0.5 * float(stdtrit(clusters - 1, 1.0 - _TAIL)) * math.sqrt(variance) / mean
    factor = math.exp(min(reach, 50.0))
    return Rms(clusters, int(total), value, value / factor, value * factor)
