"""Graded meshes of blocks, structured and repeatable: verification and users' second bodies.

A rectangle in the section, or a box in 3-D, below y = 0: fine about the origin, where an object
touches it, and growing geometrically with depth and to the sides, so that a body hundreds of
contact widths deep costs little more than a shallow one. Names of the facets: "contact" (y = 0),
"base" (y = -depth), "left" and "right" of a rectangle, "side" of a box, "symmetry" (z = 0 of a half
box). No CAD and no mesher: numpy only.
"""

from itertools import pairwise, permutations

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.cells import TETRA_EDGES, TETRA_FACETS, TRIANGLE_EDGES, quadratic
from fingerdesign.mesh.types import Mesh


def graded(size: float, fine: float, extent: float, growth: float = 1.3) -> Array:
    """Coordinates from 0 to ``extent``: even steps up to ``fine``, then growing ones.

    size   largest step up to ``fine`` (mm), which is reached exactly
    growth each step beyond is at most this times the one before. Raises MeshError where the
           lengths are not 0 < size and 0 < fine <= extent, or growth <= 1.

    >>> graded(1.0, 2.0, 9.0, 2.0).tolist()
    [0.0, 1.0, 2.0, 3.0, 5.0, 9.0]
    """
    if not (size > 0.0 and 0.0 < fine <= extent and growth > 1.0):
        raise MeshError(
            f"a grading needs 0 < size, 0 < fine <= extent and growth > 1, not size = {size:g}, "
            f"fine = {fine:g}, extent = {extent:g}, growth = {growth:g}"
        )
    steps = max(1, int(np.ceil(fine / size - 1e-9)))
    even = np.linspace(0.0, fine, steps + 1)
    rest, step = extent - fine, fine / steps
    if rest <= 1e-12 * extent:
        return even
    count = int(np.ceil(np.log1p(rest / step * (growth - 1.0) / growth) / np.log(growth) - 1e-9))
    lengths = growth ** np.arange(count)
    beyond = fine + rest * np.cumsum(lengths) / lengths.sum()
    beyond[-1] = extent  # to the last digit: borders are found by it
    return np.concatenate([even, beyond])


def both_sides(coordinates: Array) -> Array:
    """Coordinates from 0 mirrored: -extent ... 0 ... extent."""
    return np.concatenate([-coordinates[:0:-1], coordinates])


def rectangle(x: Array, y: Array) -> Mesh:
    """Quadratic triangles between the lines x and y (both ascending), mirrored in x = 0.

    Each cell of the grid is cut from its inner upper corner to its outer lower one.
    """
    nx, ny = len(x), len(y)
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    i, j = (part.ravel() for part in np.meshgrid(range(nx - 1), range(ny - 1), indexing="ij"))
    low, right, up, far = i * ny + j, (i + 1) * ny + j, i * ny + j + 1, (i + 1) * ny + j + 1
    falling = (x[i] + x[i + 1] >= 0.0)[:, None]
    first = np.where(falling, np.stack([low, right, up], 1), np.stack([low, right, far], 1))
    second = np.where(falling, np.stack([right, far, up], 1), np.stack([low, far, up], 1))
    nodes, cells = quadratic(points, np.vstack([first, second]))
    on = {
        "contact": nodes[:, 1] == y[-1],
        "base": nodes[:, 1] == y[0],
        "left": nodes[:, 0] == x[0],
        "right": nodes[:, 0] == x[-1],
    }
    facets = {name: facets_on(cells, mask, 2) for name, mask in on.items()}
    return Mesh(nodes, cells, np.zeros(len(cells), dtype=np.int64), facets, "block")


def block_section(
    half_width: float, depth: float, fine: float, size: float, growth: float = 1.3
) -> Mesh:
    """Rectangle |x| <= half_width, -depth <= y <= 0: facets of ``size`` in |x| <= ``fine`` (mm).

    The mesh is as fine down to fine / 2.
    """
    x = both_sides(graded(size, fine, half_width, growth))
    y = -graded(size, min(0.5 * fine, depth), depth, growth)[::-1]
    return rectangle(x, y)


def block_half(
    half_width: float, depth: float, fine: float, size: float, growth: float = 1.6
) -> Mesh:
    """Box |x| <= half_width, -depth <= y <= 0, 0 <= z <= half_width: the half of a mirrored block.

    A core |x|, z <= ``fine`` with facets of ``size`` on top lies in nested shells, each a larger
    copy of the core's surface and ``growth`` times as thick as the one inside it: nodes grow with
    the logarithm of the block. Mirrored in x = 0 too.
    """
    across = graded(size, fine, fine, growth)
    down = graded(size, 0.3 * fine, 0.9 * fine, 1.35)
    points, cells = _mirrored_core(across, down)
    scales = shell_scales(size / fine, half_width / fine, growth)
    core_depth = float(down[-1])
    vertical = 1.0 + (scales - 1.0) * (depth / core_depth - 1.0) / (half_width / fine - 1.0)
    outer = _outside(points, fine, core_depth)
    points, cells = _shells(points, cells, outer, np.stack([scales, vertical, scales], axis=1))
    nodes, cells = quadratic(points, cells)
    reach = np.abs(nodes) >= np.array([half_width, depth, half_width]) * (1.0 - 1e-12)
    on = {
        "contact": [np.abs(nodes[:, 1]) < 1e-12 * depth],
        "base": [reach[:, 1]],
        "side": [reach[:, 0] & (nodes[:, 0] < 0), reach[:, 0] & (nodes[:, 0] > 0), reach[:, 2]],
        "symmetry": [np.abs(nodes[:, 2]) < 1e-12 * half_width],
    }
    facets = {
        name: np.vstack([facets_on(cells, mask, 3) for mask in masks]) for name, masks in on.items()
    }
    regions = np.zeros(len(cells), dtype=np.int64)
    return Mesh(nodes, cells, regions, facets, "block", symmetric=True)


def facets_on(cells: IntArray, mask: NDArray[np.bool_], dimension: int) -> IntArray:
    """Facets (f, 3 or 6) of quadratic cells all of whose corners are in ``mask`` (n,).

    For masks of one flat or smooth piece of the boundary: an inner facet would be found too.
    """
    local: list[tuple[int, ...]]
    if dimension == 2:
        local = [(*edge, 3 + k) for k, edge in enumerate(TRIANGLE_EDGES)]
    else:
        middle = {edge: 4 + k for k, edge in enumerate(TETRA_EDGES)}
        local = [(a, b, c, middle[a, b], middle[b, c], middle[a, c]) for a, b, c in TETRA_FACETS]
    found = [cells[mask[cells[:, each[:dimension]]].all(axis=1)][:, each] for each in local]
    return np.vstack(found)


def shell_scales(first: float, last: float, growth: float) -> Array:
    """Scales of the nested shells from 1 to ``last``; the first is about ``first`` thick."""
    count = max(1, round(np.log1p((last - 1.0) / first * (growth - 1.0)) / np.log(growth)))
    thicknesses = growth ** np.arange(count)
    share = np.cumsum(thicknesses) / thicknesses.sum()
    return np.concatenate([[1.0], 1.0 + (last - 1.0) * share])


def near(mesh: Mesh, facets: str, reach: float) -> IntArray:
    """The named facets all of whose corners are within ``reach`` (mm) of the y axis."""
    chosen = mesh.facets[facets]
    across = mesh.points[chosen[:, : mesh.dimension]][:, :, ::2]
    return np.asarray(chosen[(np.linalg.norm(across, axis=2) <= reach * (1.0 + 1e-9)).all(axis=1)])


def upside_down(mesh: Mesh) -> Mesh:
    """The mesh mirrored in y = 0: a body that comes from above, cells still well oriented."""
    points = mesh.points * np.where(np.arange(mesh.dimension) == 1, -1.0, 1.0)
    swapped = [1, 0, 2, 3, 5, 4] if mesh.dimension == 2 else [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]
    return Mesh(
        points,
        mesh.cells[:, swapped],
        mesh.regions,
        mesh.facets,
        mesh.mesher,
        mesh.symmetric,
        mesh.notes,
    )


def _mirrored_core(across: Array, down: Array) -> tuple[Array, IntArray]:
    """Tetrahedra of the core: x >= 0 cut along its diagonals from the middle, then mirrored."""
    n, m = len(across), len(down)
    grid = np.stack(np.meshgrid(across, -down, across, indexing="ij"), axis=-1)
    number = np.arange(n * m * n).reshape(n, m, n)
    tetrahedra = []
    for order in permutations(range(3)):
        corner = np.zeros(3, dtype=int)
        path = [corner.copy()]
        for axis in order:
            corner[axis] = 1
            path.append(corner.copy())
        tetrahedra.append(
            np.stack(
                [number[a : n - 1 + a, b : m - 1 + b, c : n - 1 + c].ravel() for a, b, c in path],
                axis=1,
            )
        )
    points, cells = grid.reshape(-1, 3), np.vstack(tetrahedra)
    other = number.copy()
    other[1:] = n * m * n + np.arange((n - 1) * m * n).reshape(n - 1, m, n)
    mirrored = points[number[1:].ravel()] * [-1.0, 1.0, 1.0]
    return np.vstack([points, mirrored]), np.vstack([cells, other.ravel()[cells]])


def _outside(points: Array, fine: float, depth: float) -> NDArray[np.bool_]:
    """Nodes (n, 3 faces) of the core's outer surface: |x| = fine, y = -depth, z = fine."""
    return np.stack(
        [np.abs(points[:, 0]) == fine, points[:, 1] == -depth, points[:, 2] == fine], axis=1
    )


def _shells(
    points: Array, cells: IntArray, outer: NDArray[np.bool_], scales: Array
) -> tuple[Array, IntArray]:
    """Add one layer of wedges per scale (k, 3) around the core, each cut into three tetrahedra.

    The cuts follow the order of the node numbers, so that neighbours agree on them.
    """
    cells = _oriented(points, cells)
    triangles = []
    for face in outer.T:
        for a, b, c in TETRA_FACETS:
            triangle = cells[:, (a, b, c)]
            triangles.append(triangle[face[triangle].all(axis=1)])
    surface = np.sort(np.vstack(triangles), axis=1)
    nodes, local = np.unique(surface, return_inverse=True)
    local = local.reshape(surface.shape)
    layers = [nodes]
    layers += [len(points) + k * len(nodes) + np.arange(len(nodes)) for k in range(len(scales) - 1)]
    wedges = [
        np.hstack([inner[local][:, k:], outside[local][:, : k + 1]])
        for inner, outside in pairwise(layers)
        for k in range(3)
    ]
    everything = np.vstack([points, *(points[nodes] * scale for scale in scales[1:])])
    return everything, _oriented(everything, np.vstack([cells, *wedges]))


def _oriented(points: Array, cells: IntArray) -> IntArray:
    """Tetrahedra with their first corners swapped where the volume is negative."""
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    cells = cells.copy()
    wrong = np.linalg.det(edges) < 0.0
    cells[wrong, :2] = cells[wrong, 1::-1]
    return cells
