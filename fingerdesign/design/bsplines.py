"""B-spline bases with derivatives, for many parameters at once (numpy only).

Piegl and Tiller, The NURBS Book (2nd ed.), eqs. 2.5 and 2.7.
"""

from __future__ import annotations

import numpy as np

from fingerdesign.arrays import Array, IntArray


def basis(knots: Array, degree: int, t: Array, order: int = 2) -> tuple[IntArray, Array]:
    """The B-splines that are not 0 at t (n,): number of the first, (n,); values and derivatives up
    to ``order``, (order + 1, n, degree + 1). Beyond the knots the end spans' polynomials go on.
    """
    last = len(knots) - degree - 2
    span = np.clip(np.searchsorted(knots, t, side="right") - 1, degree, last)
    while True:  # an empty span at the end
        empty = (knots[span + 1] <= knots[span]) & (span > degree)
        if not empty.any():
            break
        span = np.where(empty, span - 1, span)
    values = [np.ones((len(t), 1))]
    for p in range(1, degree + 1):
        values.append(_raise(knots, span, p, values[-1], t))
    found = np.zeros((order + 1, len(t), degree + 1))
    found[0] = values[degree]
    for times in range(1, min(order, degree) + 1):
        lower = values[degree - times]
        for p in range(degree - times + 1, degree + 1):
            lower = _slope(knots, span, p, lower)
        found[times] = lower
    return np.asarray(span - degree, dtype=np.int64), found


def _raise(knots: Array, span: IntArray, p: int, lower: Array, t: Array) -> Array:
    """Values of degree p (n, p + 1) from those of degree p - 1 (n, p); eq. 2.5."""
    out = np.zeros((len(t), p + 1))
    for j in range(p):  # B-spline number span - p + 1 + j of degree p - 1
        left, right = knots[span - p + 1 + j], knots[span + 1 + j]
        share = lower[:, j] / (right - left)
        out[:, j] += (right - t) * share
        out[:, j + 1] += (t - left) * share
    return out


def _slope(knots: Array, span: IntArray, p: int, lower: Array) -> Array:
    """Derivatives of degree p (n, p + 1) from those of one order less at degree p - 1; eq. 2.7."""
    out = np.zeros((len(lower), p + 1))
    for j in range(p):
        share = p * lower[:, j] / (knots[span + 1 + j] - knots[span - p + 1 + j])
        out[:, j] -= share
        out[:, j + 1] += share
    return out
