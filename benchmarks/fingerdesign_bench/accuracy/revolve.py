"""Bodies of revolution about y, the half z >= 0 of them: balls, domes, round blocks (numpy only).

A section in x >= 0 is swept through half a turn in a few even steps; nodes between the steps lie on
their circles. Rings follow a round contact, so that a fine contact costs few nodes: eight quadratic
steps carry cos(angle) to 1e-3. Facets keep their names; z = 0 is "symmetry".
"""

from itertools import pairwise

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.cells import TETRA_EDGES, quadratic, with_mid_nodes
from fingerdesign.mesh.measures import oriented
from fingerdesign.mesh.types import Mesh
from fingerdesign_bench.accuracy.block import (
    MIRRORED,
    graded,
    rectangle,
    section_mesh,
    shell_scales,
)


def round_block_section(
    radius: float, depth: float, fine: float, size: float, growth: float = 1.6
) -> Mesh:
    """The section 0 <= x <= radius, -depth <= y <= 0 of a round block, to be revolved about y.

    A core x <= ``fine`` (mm) with facets of ``size`` on top lies in nested shells, each ``growth``
    times as thick as the one inside it. Facets: "contact" (y = 0), "base", "side" (x = radius).
    """
    across, down = graded(size, fine, fine, growth), graded(size, 0.3 * fine, 0.9 * fine, 1.35)
    core_depth = float(down[-1])
    core = rectangle(across, -down[::-1])
    points = core.points[: len(across) * len(down)]
    right, bottom = points[:, 0] == fine, points[:, 1] == -core_depth
    # Round the core's outside, from the top's edge to the axis.
    outside = np.flatnonzero(right | bottom)
    outside = outside[np.lexsort((-points[outside, 0], -points[outside, 1]))]
    scales = shell_scales(size / fine, radius / fine, growth)[1:]
    vertical = 1.0 + (scales - 1.0) * (depth / core_depth - 1.0) / (radius / fine - 1.0)
    count = len(outside)
    layers = [outside, *(len(points) + k * count + np.arange(count) for k in range(len(scales)))]
    shells = [
        np.stack([inner[:-1], inner[1:], outer[1:], inner[:-1], outer[1:], outer[:-1]], axis=1)
        for inner, outer in pairwise(layers)
    ]
    points = np.vstack(
        [points, *(points[outside] * each for each in np.stack([scales, vertical], axis=1))]
    )
    triangles = np.vstack([core.corners, np.vstack(shells).reshape(-1, 3)])
    nodes, cells = quadratic(points, oriented(points, triangles))
    on = {
        "contact": nodes[:, 1] == 0.0,
        "base": nodes[:, 1] <= -depth * (1.0 - 1e-12),
        "side": nodes[:, 0] >= radius * (1.0 - 1e-12),
    }
    return section_mesh(nodes, cells, on)


def revolved_half(section: Mesh, steps: int = 12) -> Mesh:
    """Quadratic tetrahedra of the half z >= 0 of a body whose ``section`` lies in x >= 0.

    section: quadratic triangles; its named facets are swept, but for edges on the axis x = 0. Each
    triangle sweeps wedges that are cut in the order of the section's nodes, so that neighbours
    agree. Raises MeshError for a section that is not plane or crosses the axis.
    """
    if section.dimension != 2 or section.points[:, 0].min() < 0.0:
        raise MeshError("only a plane section in x >= 0 can be revolved")
    count = len(section.points)
    axis = section.points[:, 0] == 0.0
    own = np.arange(count)
    rings = [np.where(axis, own, own + k * count) for k in range(steps + 1)]
    triangles = np.sort(section.corners, axis=1)
    swept = _swept(triangles, rings)
    corners, place = np.unique(swept, return_inverse=True)
    angle = np.where(axis[corners % count], np.nan, corners // count * (np.pi / steps))
    flat = section.points[corners % count]
    cells = oriented(_placed(flat, angle), place.reshape(swept.shape))
    nodes, cells = quadratic(np.column_stack([flat, np.nan_to_num(angle)]), cells)
    _turn_middles(section, corners % count, angle, nodes, cells)

    def named(lower: IntArray) -> IntArray:
        """Swept facets by their corners in the numbers of rings, with their mid-edge nodes."""
        return with_mid_nodes(cells, np.searchsorted(corners, lower))

    facets = {}
    for name, edges in section.facets.items():
        ends = np.sort(edges[:, :2], axis=1)
        ends = ends[~axis[ends].all(axis=1)]
        if len(ends):
            facets[name] = named(_swept(ends, rings))
    facets["symmetry"] = named(np.vstack([rings[0][triangles], rings[-1][triangles]]))
    points = _placed(nodes[:, :2], nodes[:, 2])
    points[np.unique(facets["symmetry"]), 2] = 0.0
    regions = np.zeros(len(cells), dtype=np.int64)
    return Mesh(points, cells, regions, facets, "revolve", symmetric=True)


def both_halves(half: Mesh) -> Mesh:
    """The whole body of a half z >= 0: its cells and named facets, and their mirror images."""
    count = len(half.points)
    on_plane = half.points[:, 2] == 0.0
    number = np.where(on_plane, np.arange(count), count + np.cumsum(~on_plane) - 1)
    points = np.vstack([half.points, half.points[~on_plane] * [1.0, 1.0, -1.0]])
    cells = np.vstack([half.cells, number[half.cells][:, MIRRORED[3]]])
    facets = {
        name: np.vstack([each, number[each]])
        for name, each in half.facets.items()
        if name != "symmetry"
    }
    regions = np.concatenate([half.regions, half.regions])
    return Mesh(points, cells, regions, facets, half.mesher)


def _swept(simplices: IntArray, rings: list[IntArray]) -> IntArray:
    """Sorted simplices swept from ring to ring: those of one dimension more, fewer at the axis."""
    size = simplices.shape[1]
    swept = np.vstack(
        [
            np.hstack([low[simplices[:, k:]], high[simplices[:, : k + 1]]])
            for low, high in pairwise(rings)
            for k in range(size)
        ]
    )
    distinct = (np.diff(np.sort(swept, axis=1), axis=1) > 0).all(axis=1)
    return np.asarray(swept[distinct])


def _placed(flat: Array, angle: Array) -> Array:
    """(distance from the axis, y) and the angle from +x toward +z -> (x, y, z)."""
    turn = np.nan_to_num(angle)
    return np.column_stack([flat[:, 0] * np.cos(turn), flat[:, 1], flat[:, 0] * np.sin(turn)])


def _turn_middles(
    section: Mesh, own: IntArray, angle: Array, nodes: Array, cells: IntArray
) -> None:
    """Put mid-edge nodes where the section has them, half-way in angle; in place.

    own, angle (corners,): section node and angle, NaN on the axis; nodes (n, 3): x, y, angle.
    """
    for local, (a, b) in enumerate(TETRA_EDGES):
        first, second, added = cells[:, a], cells[:, b], cells[:, 4 + local]
        ends = np.column_stack([own[first], own[second]])
        apart = ends[:, 0] != ends[:, 1]
        middles = with_mid_nodes(section.cells, ends[apart])[:, 2]
        nodes[added[apart], :2] = section.points[middles]
        here = np.where(np.isnan(angle[first]), angle[second], angle[first])
        there = np.where(np.isnan(angle[second]), angle[first], angle[second])
        nodes[added, 2] = np.nan_to_num(0.5 * (here + there))
