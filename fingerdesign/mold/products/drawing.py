"""DXF drawings of sheets to cut: layers CUT, HOLES, GAGES, BEND and TEXT; written and read back.

Importing this module is light; ezdxf loads when a file is written. Lengths in mm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.errors import GeometryError

# layer -> AutoCAD colour number (7: black on white): each also differs by its name
LAYERS = {"CUT": 7, "HOLES": 1, "GAGES": 5, "BEND": 3, "TEXT": 8}
CLOSED = ("CUT", "HOLES", "GAGES")
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
    def area(self) -> float:
        """Of the metal that is left, mm^2."""
        cut_out = sum(polygon_area(polygon) for polygon in self.openings)
        round_ones = sum(np.pi * radius**2 for *_, radius in self.circles)
        return polygon_area(self.outline) - cut_out - float(round_ones)


def polygon_area(points: Array) -> float:
    """Area of a simple polygon (n, 2), above 0 whichever way it runs.

    >>> polygon_area(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]))
    2.0
    """
    x, y = points.T
    return abs(float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))))


def write_dxf(sheets: Sequence[Sheet], path: Path) -> None:
    """Draw sheets from left to right in millimetres, and hold the file against them.

    GeometryError where it can't be written, is faulty by ezdxf's audit, holds an outline that is
    not closed, or areas other than the sheets'.
    """
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
        back = ezdxf.filemanagement.readfile(path)
    except (OSError, ezdxf.DXFError) as error:
        raise GeometryError(f"{path.name} could not be written: {error}") from error
    _compare(path.name, back, sheets)


def _draw(space: Any, sheet: Sheet, shift: Array) -> None:
    def closed(points: Array, layer: str) -> None:
        moved = (points + shift).tolist()
        space.add_lwpolyline(moved, close=True, dxfattribs={"layer": layer})

    closed(sheet.outline, "CUT")
    for polygon in sheet.openings:
        closed(polygon, "HOLES")
    for x, y, radius in sheet.circles:
        centre = (x + float(shift[0]), y + float(shift[1]))
        space.add_circle(centre, radius, dxfattribs={"layer": "HOLES"})
    for polygon in sheet.gages:
        closed(polygon, "GAGES")
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


def _compare(name: str, document: Any, sheets: Sequence[Sheet]) -> None:
    found = document.audit()
    if found.has_errors:
        first = found.errors[0].message
        raise GeometryError(f"{name} is faulty: {len(found.errors)} errors, the first: {first}")
    if document.header["$INSUNITS"] != MILLIMETRES:
        raise GeometryError(f"{name}: its unit is not the millimetre")
    areas: dict[str, list[float]] = {layer: [] for layer in CLOSED}
    for line in document.modelspace().query("LWPOLYLINE"):
        if not line.closed:
            raise GeometryError(f"{name}: an outline on layer {line.dxf.layer} is not closed")
        points = np.array(list(line.get_points("xy")), dtype=float)
        areas[line.dxf.layer].append(polygon_area(points))
    for circle in document.modelspace().query("CIRCLE"):
        areas[circle.dxf.layer].append(float(np.pi * circle.dxf.radius**2))
    wanted = {
        "CUT": [polygon_area(each.outline) for each in sheets],
        "HOLES": [
            area
            for each in sheets
            for area in (
                *(polygon_area(p) for p in each.openings),
                *(float(np.pi * r**2) for *_, r in each.circles),
            )
        ],
        "GAGES": [polygon_area(p) for each in sheets for p in each.gages],
    }
    for layer in CLOSED:
        held, given = sorted(areas[layer]), sorted(wanted[layer])
        if len(held) != len(given) or not np.allclose(held, given, rtol=1e-9, atol=1e-9):
            raise GeometryError(f"{name}: areas on layer {layer} are not those that were given")
