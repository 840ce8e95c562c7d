"""Layers along z for the extruded mesher: thin at free ends and where plates end."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from fingerdesign.arrays import Array, IntArray

LEAST_DEG = 1.1  # issue 4 asks 1 degree of extruded layers; snapped nodes may take a little of it
_GROWTH = 1.15  # from the free end, where the field changes fastest, toward the mid-plane
_SAME = 1e-9  # mm: borders that are one


def layer_heights(half_depth: float, layers: int, most: float = np.inf) -> Array:
    """Layer borders from z = 0 to the free end, thinning toward it; mm.

    ``layers`` of them, or more where none may be taller than ``most`` (mm): from the free end they
    then grow as they would and stop at that height.
    """
    steps = _GROWTH ** np.arange(layers)
    steps *= half_depth / steps.sum()
    if steps[-1] > most:
        grown = np.minimum(steps, most)
        missing = int(np.ceil((half_depth - grown.sum()) / most - 1e-9))
        steps = np.concatenate([grown, np.full(missing, most)])
        steps *= half_depth / steps.sum()
    return np.asarray(np.concatenate([[0.0], np.cumsum(steps[::-1])]))


def graded_heights(borders: Array, fine: Array, first: float, most: float = np.inf) -> Array:
    """Layer borders that hold all of ``borders``, ascending; mm.

    At the heights ``fine`` layers are ``first`` (mm) tall, and grow from there as those of
    layer_heights do, up to ``most``.
    """
    found = [np.array([borders[0]])]
    for low, high in pairwise(borders):
        place = np.linspace(low, high, 401)
        away = np.abs(place[:, None] - fine[None, :]).min(axis=1)
        density = 1.0 / np.minimum(first + (_GROWTH - 1.0) * away, most)
        total = np.concatenate(
            [[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(place))]
        )
        count = max(1, int(np.ceil(total[-1] - 0.05)))
        found.append(np.interp(np.linspace(0.0, total[-1], count + 1)[1:], total, place))
        found[-1][-1] = high
    return np.concatenate(found)


def distinct(values: Array) -> Array:
    """Values in order, those that are the same but for rounding once."""
    ordered = np.sort(values)
    keep = np.concatenate([[True], np.diff(ordered) > _SAME])
    return np.asarray(ordered[keep])


def tallest_layer(points: Array, triangles: IntArray, tallest: float) -> float:
    """Greatest height (mm) of a layer whose tetrahedra keep dihedral angles of LEAST_DEG.

    points (n, 2), triangles (t, 3) of the section; tallest: the greatest height that is wanted.
    Prisms far taller than their triangles are cut into tetrahedra as flat as the triangles are
    small: where plates are thin, and nowhere else.
    """
    angle = least_dihedral(points, triangles, tallest)
    for _ in range(8):
        if angle >= LEAST_DEG:
            break
        tallest *= float(np.clip(0.98 * angle / LEAST_DEG, 0.2, 0.98))
        angle = least_dihedral(points, triangles, tallest)
    return tallest


def least_dihedral(points: Array, triangles: IntArray, height: float) -> float:
    """Least dihedral angle, degrees, of a layer of ``height`` (mm) cut into tetrahedra."""
    both = np.column_stack([np.tile(points, (2, 1)), np.repeat([0.0, height], len(points))])
    corners = both[prisms(triangles, len(points), 0)]
    gradients = np.linalg.inv(corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    gradients = np.concatenate([-gradients.sum(axis=1, keepdims=True), gradients], axis=1)
    gradients /= np.linalg.norm(gradients, axis=2, keepdims=True)
    first, second = np.triu_indices(4, k=1)
    cosine = -np.einsum("tij,tij->ti", gradients[:, first], gradients[:, second])
    return float(np.degrees(np.arccos(np.clip(cosine.max(), -1.0, 1.0))))


def prisms(triangles: IntArray, stride: int, layer: int) -> IntArray:
    """Three tets a prism (3 t, 4); sorted triangle vertices make neighbours agree on diagonals."""
    low = np.sort(triangles, axis=1) + layer * stride
    high = low + stride
    parts = [
        np.column_stack([low, high[:, 2]]),
        np.column_stack([low[:, :2], high[:, 1:]]),
        np.column_stack([low[:, 0], high]),
    ]
    return np.stack(parts, axis=1).reshape(-1, 4)
