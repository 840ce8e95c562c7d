"""Dominance and hypervolume of sets of designs: rows are designs, columns losses."""

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.search.compare.recommend import dominated


def beats(own: Array, other: Array) -> bool:
    """Return True where ``own`` (losses of one design) is nowhere worse and somewhere better.

    >>> beats(np.array([1.0, 2.0]), np.array([1.0, 3.0]))
    True
    """
    return bool((own <= other).all() and (own < other).any())


def hypervolume(losses: Array, corner: Array) -> float:
    """The volume that the rows dominate below ``corner``; rows not below it add nothing.

    The exclusive volumes of the rows one after the other (L. While, L. Bradstreet and L. Barone, A
    fast way of calculating exact hypervolumes, IEEE Trans. Evol. Comput. 16, 2012).

    >>> hypervolume(np.array([[0.0, 1.0], [1.0, 0.0]]), np.array([2.0, 2.0]))
    3.0
    """
    inside = losses[(losses < corner).all(axis=1)]
    return _volume(_front(inside), corner)


def most_volume(losses: Array, corner: Array, count: int) -> tuple[int, ...]:
    """Rows taken one by one, each the one that adds most volume to those before it.

    Fewer than ``count`` where no other row adds any. It is the usual greedy choice of a few that
    stand for a front: its volume is at least 1 - 1/e of the best choice's.
    """
    taken: list[int] = []
    volume = 0.0
    while len(taken) < count:
        gains = [
            -np.inf if row in taken else hypervolume(losses[[*taken, row]], corner) - volume
            for row in range(len(losses))
        ]
        best = int(np.argmax(gains)) if gains else -1
        if best < 0 or gains[best] <= 1e-12 * max(volume, 1e-300):
            break
        taken.append(best)
        volume += float(gains[best])
    return tuple(taken)


def _volume(points: Array, corner: Array) -> float:
    if len(points) == 0:
        return 0.0
    # The worst first: what it leaves to the others is soon empty.
    points = points[np.argsort(-points[:, -1], kind="stable")]
    total = 0.0
    for row, own in enumerate(points):
        shared = _front(np.maximum(points[row + 1 :], own))
        total += float(np.prod(corner - own)) - _volume(shared, corner)
    return total


def _front(points: Array) -> Array:
    """The rows that no other dominates, none twice."""
    if len(points) < 2:
        return points
    rows: Array = np.unique(points[~dominated(points)], axis=0)
    return rows
