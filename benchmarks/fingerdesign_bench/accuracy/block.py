"""Graded meshes of blocks, structured and repeatable.

A rectangle in the section below y = 0: fine about the origin, where an object touches it, and
growing geometrically with depth and to the sides, so that a body hundreds of contact widths deep
costs little more than a shallow one. Names of the facets: "contact" (y = 0), "base" (y = -depth),
"left" and "right". No CAD and no mesher: numpy only.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.cells import TRIANGLE_EDGES, quadratic
from fingerdesign.mesh.types import Mesh

# The order of a mirrored cell's nodes that keeps its size above 0.
MIRRORED = {2: [1, 0, 2, 3, 5, 4], 3: [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]}


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
    return section_mesh(nodes, cells, on)


def block_section(
    half_width: float, depth: float, fine: float, size: float, growth: float = 1.3
) -> Mesh:
    """Rectangle |x| <= half_width, -depth <= y <= 0: facets of ``size`` in |x| <= ``fine`` (mm).

    The mesh is as fine down to fine / 2.
    """
    x = both_sides(graded(size, fine, half_width, growth))
    y = -graded(size, min(0.5 * fine, depth), depth, growth)[::-1]
    return rectangle(x, y)


def section_mesh(
    nodes: Array, cells: IntArray, on: Mapping[str, BoolArray], mesher: str = "block"
) -> Mesh:
    """A section of one material, its facets by names: the edges both of whose ends are in a mask
    (n,) of ``on``.

    For masks of one flat or smooth piece of the boundary: an inner facet would be found too.
    """
    local = np.array([(*edge, 3 + k) for k, edge in enumerate(TRIANGLE_EDGES)])
    edges = cells[:, local].swapaxes(0, 1).reshape(-1, 3)
    facets = {name: edges[mask[edges[:, :2]].all(axis=1)] for name, mask in on.items()}
    return Mesh(nodes, cells, np.zeros(len(cells), dtype=np.int64), facets, mesher)


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
    return replace(mesh, points=points, cells=mesh.cells[:, MIRRORED[mesh.dimension]])
