"""DXF drawings of what is cut from sheet: plates.dxf, and one for each comb or jig.

Layers CUT, HOLES, GAGES, BEND and TEXT. Importing this module is light; ezdxf loads when a file is
written. Lengths in mm.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import GeometryError
from fingerdesign.mold.part import MoldMeshes, PartMesh, comb_names, doubled_areas
from fingerdesign.mold.plan.plan import MoldPlan, Side, across, direction
from fingerdesign.mold.products.flat_pattern import FlatPattern
from fingerdesign.mold.products.notes import numbers_text

# layer -> AutoCAD colour number (7: black on white): each also differs by its name
LAYERS = {"CUT": 7, "HOLES": 1, "GAGES": 5, "BEND": 3, "TEXT": 8}
GAP_MM = 5.0  # between sheets of one drawing
MILLIMETRES = 4  # $INSUNITS


@dataclass(frozen=True)
class Sheet:
    """One flat piece: closed polygons (n, 2), round holes, gages, fold lines and what is said.

    outline  what is cut around; openings: polygons cut out of it; circles: (x, y, radius)
    gages    polygons that show where gages are bonded; bends: (2, 2) lines, start and end
    text     lines written below it; they name the piece, its count, thickness and material
    """

    name: str
    outline: Array
    openings: tuple[Array, ...] = ()
    circles: tuple[tuple[float, float, float], ...] = ()
    gages: tuple[Array, ...] = ()
    bends: tuple[Array, ...] = ()
    text: tuple[str, ...] = ()

    @property
    def polygons(self) -> Iterator[tuple[str, Array]]:
        """The closed polygons, each with its layer."""
        yield "CUT", self.outline
        yield from (("HOLES", polygon) for polygon in self.openings)
        yield from (("GAGES", polygon) for polygon in self.gages)


def polygon_area(points: Array) -> float:
    """Area of a simple polygon (n, 2), above 0 whichever way it runs.

    >>> polygon_area(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]))
    2.0
    """
    x, y = points.T
    return abs(float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))))


def write_dxf(sheets: Sequence[Sheet], path: Path) -> None:
    """Draw sheets from left to right in millimetres; GeometryError where that can't be written."""
    import ezdxf

    document = ezdxf.new("R2010", units=MILLIMETRES)
    for layer, colour in LAYERS.items():
        document.layers.add(layer, color=colour)
    space, left = document.modelspace(), 0.0
    for sheet in sheets:
        low, high = sheet.outline.min(axis=0), sheet.outline.max(axis=0)
        _draw(space, sheet, np.array([left, 0.0]) - low)
        letters = max((len(line) for line in sheet.text), default=0)
        left += max(float(high[0] - low[0]), 0.9 * _text_height(sheet) * letters) + GAP_MM
    try:
        document.saveas(path)
    except (OSError, ezdxf.DXFError) as error:
        raise GeometryError(f"{path.name} could not be written: {error}") from error


def _draw(space: Any, sheet: Sheet, shift: Array) -> None:
    for layer, polygon in sheet.polygons:
        moved = (polygon + shift).tolist()
        space.add_lwpolyline(moved, close=True, dxfattribs={"layer": layer})
    for x, y, radius in sheet.circles:
        centre = (x + float(shift[0]), y + float(shift[1]))
        space.add_circle(centre, radius, dxfattribs={"layer": "HOLES"})
    for start, end in sheet.bends:
        space.add_line((start + shift).tolist(), (end + shift).tolist(), {"layer": "BEND"})
    height = _text_height(sheet)
    low = sheet.outline.min(axis=0) + shift
    for number, line in enumerate(sheet.text, start=1):
        place = (float(low[0]), float(low[1]) - 1.6 * height * number)
        space.add_text(line, height=height, dxfattribs={"layer": "TEXT"}).set_placement(place)


def _text_height(sheet: Sheet) -> float:
    extent = float(np.ptp(sheet.outline, axis=0).max())
    return min(max(0.03 * extent, 0.4), 1.5)


MICRON = 3  # decimals
ROUND = 12  # corners of a polygon that may stand for a circle
STRAIGHT = 1e-7  # mm; a point this near the line between its neighbours adds nothing


def comb_sheet(part: PartMesh, side: Side) -> Sheet:
    """A comb or jig as cut, from the triangles of its flat face across a side's direction.

    Drawn as (x, y) for the sides +z and -z (seen from +z), as (z, y) for +x and -x (seen from -x).
    GeometryError where the flat face is not one piece, or where outline times thickness is not the
    sheet's volume.
    """
    normals = doubled_areas(part.vertices, part.triangles)
    out = part.vertices @ direction(side)
    facing = normals @ direction(side) > 0.999 * np.linalg.norm(normals, axis=1)
    facing &= np.abs(out[part.triangles] - out.max()).max(axis=1) < 1e-6
    if not facing.any():
        raise GeometryError(f"{part.name} has no flat face across {side}")
    flat = np.column_stack([part.vertices @ across(side), part.vertices[:, 1]])
    loops = [
        _without_straight_points(flat[loop])
        for loop in border_loops(part.triangles[facing], part.name)
    ]
    loops.sort(key=polygon_area, reverse=True)
    outline, openings = loops[0], tuple(loops[1:])
    area = polygon_area(outline) - sum(polygon_area(loop) for loop in openings)
    thickness = float(np.ptp(out))
    border = sum(np.linalg.norm(p - np.roll(p, 1, axis=0), axis=1).sum() for p in loops)
    # A chord cuts off that much at most; single precision moves both faces by half a step each.
    rounding = float(np.spacing(np.float32(np.abs(out).max()))) / thickness
    allowed = max(part.chord, 1e-6) * border + (rounding + 1e-6) * area
    if abs(area * thickness - part.volume) > allowed * thickness:
        raise GeometryError(
            f"{part.name}: its outline times its thickness is {area * thickness:.6g} mm^3, the "
            f"solid {part.volume:.6g} mm^3"
        )
    rounds = {k: circle for k, loop in enumerate(openings) if (circle := as_circle(loop))}
    polygons = tuple(loop for k, loop in enumerate(openings) if k not in rounds)
    upright = side.endswith("z")
    seen = "x to the right, seen from +z" if upright else "z to the right, seen from -x"
    cut = f"{len(polygons)} openings, {len(rounds)} round holes"
    text = (f"{part.name}: 1 of {thickness:g} mm sheet, {cut}", f"{seen}, y up")
    return Sheet(part.name, outline, polygons, tuple(rounds.values()), text=text)


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


def _without_straight_points(points: Array) -> Array:
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    chord = after - before
    length = np.maximum(np.linalg.norm(chord, axis=1), 1e-300)
    offset = points - before
    away = np.abs(chord[:, 0] * offset[:, 1] - chord[:, 1] * offset[:, 0]) / length
    return np.asarray(points[away > STRAIGHT])


PLATES_FILE = "plates.dxf"


def write_drawings(
    plan: MoldPlan, meshes: MoldMeshes, patterns: Sequence[FlatPattern], folder: Path
) -> None:
    """All drawings into a folder. GeometryError where one is not what was cut."""
    if patterns:
        write_dxf([plate_sheet(pattern) for pattern in patterns], folder / PLATES_FILE)
    for side in plan.sides:
        for name in comb_names(side.side, side.holding) if side.holding == "comb" else ():
            write_dxf([comb_sheet(meshes.part(name), side.side)], folder / f"{name}.dxf")


def plate_sheet(pattern: FlatPattern) -> Sheet:
    """A plate as cut: its legs, its holes, its gages' places, and where it is bent."""
    faces = sorted({gage.face for gage in pattern.gages}, reverse=True)
    marks = {np.round(gage.corners, 9).tobytes(): gage.corners for gage in pattern.gages}
    low, high = pattern.outline.min(axis=0), pattern.outline.max(axis=0)
    text = [
        f"{pattern.name}: {pattern.count} of {pattern.thickness:g} mm "
        f"{pattern.material.replace('_', ' ')}",
        f"plates {numbers_text(pattern.plates)}, {pattern.seen} face shown",
        f"gages on {' and '.join(faces)} face" if faces else "no gages",
    ]
    bends: tuple[Array, ...] = ()
    if pattern.bend_radius is not None:
        bends = (np.array([[0.0, low[1]], [0.0, high[1]]]),)
        text.append(f"bend the whole width to R {pattern.bend_radius:.3f} of the middle")
    return Sheet(
        pattern.name,
        pattern.outline,
        circles=tuple((round(x, 3), round(y, 3), round(r, 3)) for x, y, r in pattern.holes),
        gages=tuple(marks.values()),
        bends=bends,
        text=tuple(text),
    )
