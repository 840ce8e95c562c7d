"""Second methods for the stability map's judge.

Both solve one increment in local components (normal first), v = C f + w, with Signorini's law and
Coulomb's on the slip increments. ``lemke`` follows complementary pivots (2-D: there Coulomb's law
is linear); ``fixed_bound`` iterates on the friction bound, a convex problem each time (any
dimension). Both say None where they find nothing: neither proves that there is nothing. They share
no line with the production solver.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array

_TIE = 1e-12  # ratios nearer than this are one ratio
_PIVOTS = 4000


def lemke(compliance: Array, offset: Array, friction: float, starts: int = 4) -> Array | None:
    """Forces (m, 2) by complementary pivoting (Cottle, Pang, Stone, The Linear Complementarity
    Problem, 4.4), or None where each of ``starts`` covering vectors ends on a ray.

    With r = t + mu p, s = mu p - t >= 0 and the slip d = a - b:  p with gap, r with a, b with s are
    complementary pairs, and gap, a, s are linear in p, r, b.
    """
    m = len(offset)
    length = max(float(np.abs(offset).max()), 1e-300)
    unit = float(np.median(np.diag(compliance)))
    scaled = compliance / unit
    nn, nt = scaled[::2, ::2], scaled[::2, 1::2]
    tn, tt = scaled[1::2, ::2], scaled[1::2, 1::2]
    eye, none = np.eye(m), np.zeros((m, m))
    matrix = np.block(
        [
            [nn - friction * nt, nt, none],
            [tn - friction * tt, tt, eye],
            [2.0 * friction * eye, -eye, none],
        ]
    )
    load = np.concatenate([offset[:, 0], offset[:, 1], np.zeros(m)]) / length
    rng = np.random.default_rng(3)
    for start in range(starts):
        cover = np.ones(3 * m) if start == 0 else rng.uniform(0.1, 1.0, 3 * m)
        found = _pivots(matrix, load, cover)
        if found is not None:
            normal, pushed = found[:m], found[m : 2 * m]
            force = np.column_stack([normal, pushed - friction * normal])
            return np.asarray(force * (length / unit))
    return None


def _pivots(matrix: Array, load: Array, cover: Array) -> Array | None:
    """z >= 0 with M z + q >= 0 and z . (M z + q) = 0; columns: w (n), z (n), the artificial one."""
    n = len(load)
    if (load >= 0.0).all():
        return np.zeros(n)
    columns = np.hstack([np.eye(n), -matrix, -cover[:, None]])
    table = np.hstack([columns, load[:, None]])
    basis = np.arange(n)
    row, entering = int(np.argmin(load / cover)), 2 * n
    for _ in range(_PIVOTS):
        _eliminate(table, row, entering)
        leaving, basis[row] = int(basis[row]), entering
        if leaving == 2 * n:
            return _solution(columns, basis, load)
        entering = leaving + n if leaving < n else leaving - n
        chosen = _leaving_row(table, entering, basis, 2 * n)
        if chosen is None:
            return None
        row = chosen
    return None


def _leaving_row(table: Array, entering: int, basis: NDArray[np.int64], last: int) -> int | None:
    column = table[:, entering]
    rows = np.flatnonzero(column > 1e-11)
    if not len(rows):
        return None
    ratios = np.maximum(table[rows, -1], 0.0) / column[rows]
    least = rows[ratios <= ratios.min() + _TIE]
    if (basis[least] == last).any():
        return int(least[basis[least] == last][0])
    # Of equals the lexicographically least, which keeps pivots from going round (4.9 there).
    n = len(table)
    for k in range(n):
        if len(least) == 1:
            break
        values = table[least, k] / column[least]
        least = least[values <= values.min() + _TIE]
    return int(least[np.argmax(column[least])])


def _eliminate(table: Array, row: int, column: int) -> None:
    table[row] /= table[row, column]
    factors = table[:, column].copy()
    factors[row] = 0.0
    table -= np.outer(factors, table[row])


def _solution(columns: Array, basis: NDArray[np.int64], load: Array) -> Array:
    """Solved anew on the last basis, without the pivots' rounding."""
    n = len(load)
    values = np.linalg.solve(columns[:, basis], load)
    everything = np.zeros(2 * n + 1)
    everything[basis] = np.maximum(values, 0.0)
    return everything[n : 2 * n]


def fixed_bound(
    compliance: Array,
    offset: Array,
    friction: float,
    tolerance: float = 1e-10,
    budget: int = 4000,
) -> Array | None:
    """Forces (m, dim): p from a bound mu p of the round before until it no longer changes.

    Each round minimises 1/2 f C f + w f over p >= 0, |t| <= bound: Haslinger's fixed point. None
    where the rounds do not settle (they need not for a large friction coefficient) within
    ``budget`` gradient steps in all.
    """
    m, dim = offset.shape
    scale = np.sqrt(np.repeat(np.diag(compliance).reshape(m, dim).max(axis=1), dim))
    matrix = compliance / np.outer(scale, scale)
    load = offset.reshape(-1) / scale
    step = 1.0 / float(np.linalg.eigvalsh(matrix)[-1])
    weight = scale[::dim]  # one scale a node keeps its disc round
    force = np.zeros(m * dim)
    bound = np.zeros(m)
    while budget > 0:
        force, spent = _descend(matrix, load, step, bound, force, dim)
        budget -= spent
        wanted = friction * force[::dim]
        change = float(np.abs(wanted - bound).max())
        bound = wanted
        if change <= tolerance * max(float(np.abs(force).max()), 1e-300):
            force, _ = _descend(matrix, load, step, bound, force, dim)
            return np.asarray(force.reshape(m, dim) / weight[:, None])
    return None


def _descend(
    matrix: Array, load: Array, step: float, bound: Array, start: Array, dim: int
) -> tuple[Array, int]:
    """Projected gradient with momentum, restarted where it overshoots (O'Donoghue, Candes 2015).

    Returns the forces and the steps taken.
    """
    force, ahead, momentum = start, start, 1.0
    for count in range(1, 2001):
        new = _admissible(ahead - step * (matrix @ ahead + load), bound, dim)
        moved = new - force
        size = float(np.abs(new).max())
        if float(np.abs(moved).max()) <= 1e-12 * size and float(np.abs(new - ahead).max()) <= (
            1e-12 * size
        ):
            return new, count
        if (ahead - new) @ moved > 0.0:
            momentum, ahead, force = 1.0, new, new
            continue
        following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
        ahead = new + (momentum - 1.0) / following * moved
        force, momentum = new, following
    return force, count


def _admissible(force: Array, bound: Array, dim: int) -> Array:
    shaped = force.reshape(-1, dim).copy()
    shaped[:, 0] = np.maximum(shaped[:, 0], 0.0)
    size = np.sqrt(np.sum(shaped[:, 1:] ** 2, axis=1))
    over = size > bound
    shaped[over, 1:] *= (bound[over] / size[over])[:, None]
    return np.asarray(shaped.reshape(-1))
