"""Number of elements that a size field leads to: the integral over the body."""

from collections.abc import Callable
from itertools import product

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.mesh.sizing import SizeField

_CELL = 0.7  # largest cell of the integral over the size at its middle
_DEEPEST = 12
_FIRST = 6  # cells across the body's shortest extent to begin with
# Cells of one level: of more, some stand for all, so that an astronomic mesh is predicted at once.
_MOST_CELLS = 25_000


def expected_elements(field: SizeField, low: Array, high: Array) -> float:
    """Number of tetrahedra of the field's size within the body between low and high (3,). By the
    volume of a regular tetrahedron, h^3 / (6 sqrt 2), stretched."""
    sizes = field.sizes
    stretch = np.array([1.0, 1.0, sizes.stretch])
    extent = (high - low) / stretch
    return elements_within(
        field,
        (low, high),
        np.maximum(np.round(_FIRST * extent / extent.min()), 1),
        lambda cells, _: field.surface.encloses(cells).astype(float),
        lambda size: sizes.stretch * size**3 / (6.0 * np.sqrt(2.0)),
        (_CELL, _DEEPEST, _MOST_CELLS),
        stretch,
    )


def elements_within(
    field: Callable[[Array], Array],
    box: tuple[Array, Array],
    count: Array,
    inside: Callable[[Array, Array], Array],
    element: Callable[[Array], Array],
    bounds: tuple[float, int, int],
    stretch: Array | float = 1.0,
) -> float:
    """Elements of the field's size within a box: two corners (d,), ``count`` (d,) cells at first.

    The cells are cut up until they suit the size at their middles, ``stretch`` times as long by
    direction. inside(middles, edges): the share of each cell that counts; element(size): the volume
    or area of one. bounds: the largest cell over the size, the deepest level, the most cells used
    of a level; of more, some stand for all.
    """
    (low, high), (most, deepest, many) = box, bounds
    step = (high - low) / count
    axes = [low[k] + step[k] * (np.arange(int(count[k])) + 0.5) for k in range(len(count))]
    cells = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(count))
    corners = np.array(list(product((-1, 1), repeat=len(count))))
    total, stands_for = 0.0, 1.0
    for level in range(deepest + 1):
        target = field(cells)
        good = ((step / stretch).max() <= most * target) | (level == deepest)
        if good.any():
            share = inside(cells[good], step) / element(target[good])
            total += stands_for * float(share.sum() * step.prod())
        cells, share_used = some_of(cells[~good], many)
        if not len(cells):
            break
        stands_for /= share_used
        step = 0.5 * step
        cells = (cells[:, None] + 0.5 * step * corners).reshape(-1, len(step))
    return total


def some_of(cells: Array, most: int) -> tuple[Array, float]:
    """No more than ``most`` of the cells, by chance but always the same ones, and their share."""
    if len(cells) <= most:
        return cells, 1.0
    chosen = np.random.default_rng(0).choice(len(cells), most, replace=False)
    return cells[chosen], most / len(cells)
