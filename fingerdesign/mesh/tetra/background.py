"""A size field as fTetWild reads it: its values at the points of a grid of tetrahedra."""

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.layout.clearance import plate_points
from fingerdesign.mesh.sizing import SizeField

GRID_POINTS = 200_000


def background_grid(
    field: SizeField, low: Array, high: Array
) -> tuple[Array, NDArray[np.int32], Array]:
    """A rectilinear grid of tetrahedra over a box with the field's value at each of its points.

    low, high (3,): the box to cover (a margin is added). The grid is fine where the field is steep;
    where that would take more than about GRID_POINTS points, all of it is coarser. Returns points
    (n, 3), positively oriented tetrahedra (t, 4), values (n,).
    """
    axes = _grid_axes(field, low, high)
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    shape = tuple(len(axis) for axis in axes)
    numbers = np.arange(len(points)).reshape(shape)

    def corner(step: Array) -> IntArray:
        i, j, k = (int(s) for s in step)
        nx, ny, nz = shape
        return numbers[i : nx - 1 + i, j : ny - 1 + j, k : nz - 1 + k].reshape(-1)

    tets = []
    for order in permutations(range(3)):  # Kuhn's six tetrahedra of a brick
        path = [np.zeros(3)]
        for axis in order:
            path.append(path[-1] + np.eye(3)[axis])
        tet = np.stack([corner(step) for step in path], axis=1)
        even = np.linalg.det(np.diff(np.array(path), axis=0)) > 0
        tets.append(tet if even else tet[:, [0, 2, 1, 3]])
    return points, np.vstack(tets).astype(np.int32), field(points)


def _grid_axes(field: SizeField, low: Array, high: Array) -> list[Array]:
    """Grid coordinates along x, y and z: fine around plates and the contact surface's heights."""
    sizes, extent = field.sizes, high - low
    coarse = np.minimum(np.array([0.5, 0.5, 1.0]) * sizes.far, 0.25 * extent)
    fine = np.minimum(np.array([2.0, 0.7, 2.0]) * sizes.contact, coarse)
    first, last = low.copy(), high.copy()
    first[1] = _zone_floor(field, high) - 2.0 * sizes.contact
    half_depth = field.zone.half_depth
    round_zone = half_depth is not None or field.surface.curvatures[1] > 0.0
    steep_in_z = round_zone
    if field.frames:
        end = min(field.end_size(frame) for frame in field.frames)
        corners = np.vstack([plate_points(frame) for frame in field.frames])
        least, most = corners.min(axis=0), corners.max(axis=0)
        across = 2 if all(frame.along == "x" for frame in field.frames) else 1
        fine[:across] = np.minimum(fine[:across], [2.0 * end, end][:across])
        first[1] = min(first[1], least[1] - 2.0 * end)
        first[0], last[0] = least[0] - 2.0 * end, most[0] + 2.0 * end
        if across == 1:
            fine[1:] = np.minimum(fine[1:], [end, 2.0 * end])
            first[2], last[2] = least[2] - 2.0 * end, most[2] + 2.0 * end
        steep_in_z |= across == 1 or least[2] > low[2] + 1e-6 or most[2] < high[2] - 1e-6
    elif half_depth is not None:
        reach = 1.5 * half_depth
        first[2], last[2] = max(low[2], -reach), min(high[2], reach)
    if not steep_in_z:
        fine[2] = coarse[2] = 0.5 * extent[2]
    factor = 1.0
    while True:
        axes = [
            _graded_axis(low[i], high[i], first[i], last[i], factor * fine[i], factor * coarse[i])
            for i in range(3)
        ]
        if np.prod([float(len(axis)) for axis in axes]) <= GRID_POINTS:
            return axes
        factor *= 1.1


def _graded_axis(
    low: float, high: float, first: float, last: float, fine: float, coarse: float
) -> Array:
    """Coordinates from below ``low`` to above ``high``, spaced ``fine`` from first to last."""
    margin = 0.05 * (high - low) + 1e-6
    start, stop = low - margin, high + margin
    first, last = max(first, start), min(last, stop)
    pieces = [(start, first, coarse), (first, last, fine), (last, stop, coarse)]
    found = [np.array([start])]
    for begin, end, step in pieces:
        if end - begin > 1e-9 * (stop - start):
            count = int(np.ceil((end - begin) / step))
            found.append(np.linspace(begin, end, count + 1)[1:])
    return np.concatenate(found)


def _zone_floor(field: SizeField, high: Array) -> float:
    """Least height of the contact surface over the zone, mm."""
    x = np.linspace(0.0, min(field.zone.half_width, float(high[0])), 9)
    deep = field.zone.half_depth if field.zone.half_depth is not None else float(high[2])
    z = np.linspace(0.0, deep, 9)
    heights = field.surface.height(*(axis.reshape(-1) for axis in np.meshgrid(x, z)))
    known = heights[np.isfinite(heights)]
    return float(known.min()) if len(known) else field.surface.lowest
