"""Edges that came out longer than the size field: fTetWild stops when shapes are good, not sizes.

It makes no element much smaller than a fortieth of the body, so that a small contact on a large
finger would be a few facets. The longest edges are halved first (after Rivara, IJNME 20 (1984)
745), all at once that no other split touches, until none is too long. Numpy only.
"""

from collections.abc import Callable

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.mesh.cells import TETRA_EDGES

TOO_LONG = 1.6  # times the target size; a good mesh has edges of 0.6 to 1.5 times
MOST_ROUNDS = 60


def refine(
    points: Array,
    tets: IntArray,
    regions: IntArray,
    size: Callable[[Array], Array],
    scale: Array,
    most: int,
) -> tuple[Array, IntArray, IntArray]:
    """Points, tetrahedra and regions with no edge over TOO_LONG times ``size`` at its ends.

    Lengths are measured after multiplying coordinates by ``scale`` (3,). New points are edges'
    middles, at the end. Stops at ``most`` tetrahedra: the caller judges their number.
    """
    pairs, target = np.array(TETRA_EDGES), size(points)
    for _ in range(MOST_ROUNDS):
        ends = tets[:, pairs]  # (t, 6, 2)
        length = np.linalg.norm((points[ends[..., 1]] - points[ends[..., 0]]) * scale, axis=2)
        long = length > TOO_LONG * 0.5 * target[ends].sum(axis=2)
        around = np.flatnonzero(long.any(axis=1))  # every cell of a long edge finds it long
        if len(around) == 0 or len(tets) > most:
            break
        new, cut, upper, lower = _halves(points, tets[around], long[around], length[around])
        cells = around[cut]
        tets = np.vstack([tets, lower])
        tets[cells] = upper
        regions = np.concatenate([regions, regions[cells]])
        points, target = np.vstack([points, new]), np.concatenate([target, size(new)])
    return points, tets, regions


def _halves(
    points: Array, tets: IntArray, long: BoolArray, length: Array
) -> tuple[Array, IntArray, IntArray, IntArray]:
    """One round: new points, the tetrahedra that are halved, and their two halves.

    Of the edges that are too ``long`` those are split that are the longest such in every
    tetrahedron around them: no two are in one, and the longest of all is among them.
    """
    pairs = np.array(TETRA_EDGES)
    ends = np.sort(tets[:, pairs].reshape(-1, 2), axis=1)
    names = ends[:, 0] * len(points) + ends[:, 1]
    keys, first, of_edge = np.unique(names, return_index=True, return_inverse=True)
    of_edge, edges = of_edge.reshape(len(tets), 6), ends[first]
    rank = np.empty(len(keys))
    rank[np.argsort(length.reshape(-1)[first], kind="stable")] = np.arange(len(keys))
    rank[~long.reshape(-1)[first]] = -1.0
    local = rank[of_edge].argmax(axis=1)
    longest = of_edge[np.arange(len(tets)), local]
    around = np.bincount(of_edge.reshape(-1), minlength=len(keys))
    chosen = np.bincount(longest, minlength=len(keys)) == around
    number = np.cumsum(chosen) - 1 + len(points)
    cut = np.flatnonzero(chosen[longest])
    rows, place = np.arange(len(cut)), local[cut]
    upper, lower = tets[cut].copy(), tets[cut].copy()
    upper[rows, pairs[place, 0]] = number[longest[cut]]
    lower[rows, pairs[place, 1]] = number[longest[cut]]
    return points[edges[chosen]].mean(axis=1), cut, upper, lower
