"""The outline of a sheet part, from the triangles of its flat face: what a cutter follows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import GeometryError
from fingerdesign.mold.drawing import polygon_area
from fingerdesign.mold.part import PartMesh
from fingerdesign.mold.plan import Side

MICRON = 3  # decimals
ROUND = 12  # corners of a polygon that may stand for a circle
STRAIGHT = 1e-7  # mm; a point this near the line between its neighbours adds nothing


@dataclass(frozen=True)
class Outline:
    """What is cut around (n, 2), polygons cut out of it, and round holes (x, y, radius)."""

    around: Array
    openings: tuple[Array, ...]
    circles: tuple[tuple[float, float, float], ...]


def sheet_outline(part: PartMesh, side: Side) -> Outline:
    """Outline, openings and round holes of a sheet that lies across a side's direction.

    Drawn as (x, y) for the sides +z and -z (seen from +z), as (z, y) for +x and -x (seen from -x).
    GeometryError where the flat face is not one piece, or where outline times thickness is not the
    sheet's volume.
    """
    axis = 2 if side.endswith("z") else 0
    direction = np.zeros(3)
    direction[axis] = 1.0 if side.startswith("+") else -1.0
    corners = part.vertices[part.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(across, axis=1)
    reach = float((part.vertices @ direction).max())
    facing = across @ direction > 0.999 * np.maximum(size, 1e-300)
    facing &= np.abs(corners @ direction - reach).max(axis=1) < 1e-6
    if not facing.any():
        raise GeometryError(f"{part.name} has no flat face across {side}")
    plane = [0, 1] if axis == 2 else [2, 1]
    loops = [
        _without_straight_points(part.vertices[loop][:, plane])
        for loop in border_loops(part.triangles[facing], part.name)
    ]
    loops.sort(key=polygon_area, reverse=True)
    outline, openings = loops[0], tuple(loops[1:])
    area = polygon_area(outline) - sum(polygon_area(loop) for loop in openings)
    thickness = float(np.ptp(part.vertices[:, axis]))
    border = sum(_length(loop) for loop in loops)
    # A chord cuts off that much at most; single precision moves both faces by half a step each.
    rounding = float(np.spacing(np.float32(np.abs(part.vertices[:, axis]).max()))) / thickness
    allowed = max(part.chord, 1e-6) * border + (rounding + 1e-6) * area
    if abs(area * thickness - part.volume) > allowed * thickness:
        raise GeometryError(
            f"{part.name}: its outline times its thickness is {area * thickness:.6g} mm^3, the "
            f"solid {part.volume:.6g} mm^3"
        )
    rounds = {k: circle for k, loop in enumerate(openings) if (circle := as_circle(loop))}
    polygons = tuple(loop for k, loop in enumerate(openings) if k not in rounds)
    return Outline(outline, polygons, tuple(rounds.values()))


def as_circle(points: Array) -> tuple[float, float, float] | None:
    """The circle (x, y, radius) that a polygon's corners (n, 2) lie on, to 0.001 mm, as it is cut
    and measured; None where they do not.

    Corners of a triangulated round hole lie on its exact edge; it has twelve of them or more.
    """
    if len(points) < ROUND:
        return None
    system = np.column_stack([2.0 * points, np.ones(len(points))])
    (x, y, rest), *_ = np.linalg.lstsq(system, (points**2).sum(axis=1), rcond=None)
    radius = float(np.sqrt(max(rest + x**2 + y**2, 0.0)))
    apart = np.abs(np.hypot(points[:, 0] - x, points[:, 1] - y) - radius)
    if apart.max() >= 1e-6:
        return None
    return round(float(x), MICRON) + 0.0, round(float(y), MICRON) + 0.0, round(radius, MICRON)


def border_loops(triangles: IntArray, name: str) -> list[list[int]]:
    """The closed loops of vertices around a patch of triangles, each in the triangles' sense.

    GeometryError where a vertex joins more than two border edges: the patch pinches there.
    """
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    both = {(int(a), int(b)) for a, b in edges}
    follows: dict[int, int] = {}
    for a, b in both:
        if (b, a) not in both:
            if a in follows:
                raise GeometryError(f"{name}: the border of its flat face meets itself")
            follows[a] = b
    loops = []
    while follows:
        start, at = follows.popitem()
        loop = [start]
        while at != start:
            loop.append(at)
            at = follows.pop(at)
        loops.append(loop)
    return loops


def _length(points: Array) -> float:
    return float(np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1).sum())


def _without_straight_points(points: Array) -> Array:
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    chord = after - before
    length = np.maximum(np.linalg.norm(chord, axis=1), 1e-300)
    offset = points - before
    away = np.abs(chord[:, 0] * offset[:, 1] - chord[:, 1] * offset[:, 0]) / length
    return np.asarray(points[away > STRAIGHT])
