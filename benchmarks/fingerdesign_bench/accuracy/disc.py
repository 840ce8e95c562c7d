"""Graded meshes of a disc and its lower or upper half in plane strain: rollers, cylinders, domes.

Lines run along the arc and along the radius, fine at the crest (0, 0) and growing away from it;
they meet in the centre (0, -radius). Every node that belongs on the arc, mid-edge nodes too, lies
on it to rounding. Names of the facets: "contact" (the whole arc) and, of a half, "base" (its flat).
"""

from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.mesh.cells import TRIANGLE_EDGES, quadratic
from fingerdesign.mesh.types import Mesh
from fingerdesign_bench.accuracy.block import both_sides, graded, rectangle, section_mesh


def half_disc(radius: float, fine: float, size: float, growth: float = 1.3) -> Mesh:
    """Half of a disc with its crest at the origin and its flat on y = -radius.

    fine, size: mm along the arc: facets of ``size`` within ``fine`` of the crest, growing beyond by
    ``growth`` at most; as fine down to fine / 2. Raises MeshError for lengths that do not fit.
    """
    return _wheel(radius, 0.5 * np.pi, fine, size, growth)


def disc(radius: float, fine: float, size: float, growth: float = 1.3) -> Mesh:
    """A whole disc, its crest at the origin and its centre at (0, -radius); see ``half_disc``.

    The node opposite to the crest is at (0, -2 radius).
    """
    return _wheel(radius, np.pi, fine, size, growth)


def right_half(mesh: Mesh) -> Mesh:
    """The cells of a section that lie in x >= 0, to be revolved; their facets keep their names."""
    keep = (mesh.points[mesh.corners, 0] >= 0.0).all(axis=1)
    used = np.unique(mesh.cells[keep])
    number = np.full(len(mesh.points), -1)
    number[used] = np.arange(len(used))
    facets = {name: number[each] for name, each in mesh.facets.items()}
    return replace(
        mesh,
        points=mesh.points[used],
        cells=number[mesh.cells[keep]],
        regions=mesh.regions[keep],
        facets={name: each[(each >= 0).all(axis=1)] for name, each in facets.items()},
    )


def _wheel(radius: float, half_angle: float, fine: float, size: float, growth: float) -> Mesh:
    whole = half_angle == np.pi
    angles = both_sides(graded(size / radius, fine / radius, half_angle, growth))
    distances = radius - graded(size, 0.5 * fine, radius, growth)[::-1]
    distances[0] = 0.0
    polar, triangles = _corners(angles, distances, whole)
    nodes, cells = quadratic(polar, triangles)
    _turn_middles(nodes, cells)
    on = {"contact": nodes[:, 1] == radius}
    if not whole:
        on["base"] = (np.abs(nodes[:, 0]) == half_angle) | (nodes[:, 1] == 0.0)
    return section_mesh(_placed(nodes, radius), cells, on, "disc")


def _corners(angles: Array, distances: Array, whole: bool) -> tuple[Array, IntArray]:
    """Corner nodes (n, 2) as angle and distance, the centre once, and their triangles (c, 3)."""
    flat = rectangle(angles, distances)
    count = len(angles) * len(distances)
    polar, triangles = flat.points[:count], flat.corners
    same = np.arange(count)
    same[polar[:, 1] == 0.0] = 0
    if whole:  # the last ray is the first
        same[-len(distances) :] = same[: len(distances)]
    triangles = same[triangles]
    proper = (triangles[:, 0] != triangles[:, 1]) & (triangles[:, 1] != triangles[:, 2])
    proper &= triangles[:, 0] != triangles[:, 2]
    used, number = np.unique(triangles[proper], return_inverse=True)
    return polar[used], number.reshape(-1, 3)


def _turn_middles(nodes: Array, cells: IntArray) -> None:
    """Set mid-edge nodes half-way in angle (across the seam too) and in distance, in place."""
    for local, (a, b) in enumerate(TRIANGLE_EDGES):
        first, second = nodes[cells[:, a]], nodes[cells[:, b]]
        turn = 0.5 * (second[:, 0] - first[:, 0])
        turn -= np.pi * np.round(turn / np.pi)
        angle = first[:, 0] + turn
        angle = np.where(first[:, 1] == 0.0, second[:, 0], angle)  # the centre has no angle
        angle = np.where(second[:, 1] == 0.0, first[:, 0], angle)
        nodes[cells[:, 3 + local], 0] = angle


def _placed(polar: Array, radius: float) -> Array:
    """(angle from the crest toward +x, distance from the centre) -> (x, y)."""
    angle, distance = polar.T
    # Written so that the crest is at y = 0 exactly and points near it lose no digits.
    y = distance - radius - 2.0 * distance * np.sin(0.5 * angle) ** 2
    return np.column_stack([distance * np.sin(angle), y])
