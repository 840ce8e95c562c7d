"""DXF drawings of what is cut from sheet: flat patterns of the plates, and combs.

Layers of the drawings are CUT, HOLES, GAGES, BEND and TEXT; ezdxf loads when a file is written.
Lengths in mm.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.errors import GeometryError
from fingerdesign.mold.part import PartMesh, axis_name
from fingerdesign.mold.plan.mount import SIDE_MM, STOP_SCREW_MM, flange_holes, rail_profile
from fingerdesign.mold.plan.patterns import FlatPattern
from fingerdesign.mold.plan.pieces import SIDES, Side, direction
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.products.casting import Casting
from fingerdesign.mold.products.three_mf import in_rows
from fingerdesign.mold.solids import section_loops, solid_of

# layer -> AutoCAD colour number (7: black on white): each also differs by its name
LAYERS = {"CUT": 7, "HOLES": 1, "GAGES": 5, "BEND": 3, "TEXT": 8}
LINE = 1.6  # of a text's height, from line to line
MILLIMETRES = 4  # $INSUNITS
MICRON = 3  # decimals
ROUND = 12  # corners of a polygon that may stand for a circle
ROUNDING_MM = 2e-5  # of a corner off its circle: twice single precision's step within 100 mm
UNDER_MM = 1e-6  # a sheet's outer face, where its section is drawn
PLATES_FILE, MOUNT_FILE = "plates.dxf", "mount.dxf"


@dataclass(frozen=True)
class Sheet:
    """One flat piece: closed polygons (n, 2), round holes, gages, fold lines and text.

    outline  what is cut around; openings: polygons cut out of it; circles: (x, y, radius)
    gage     polygon that shows where gages are bonded; bends: (2, 2) lines, start and end
    text     lines written below it; they name the piece, its count, thickness and material
    """

    name: str
    outline: Array
    openings: tuple[Array, ...] = ()
    circles: tuple[tuple[float, float, float], ...] = ()
    gage: Array | None = None
    bends: tuple[Array, ...] = ()
    text: tuple[str, ...] = ()


def polygon_area(points: Array) -> float:
    """Area of a simple polygon (n, 2), above 0 whichever way it runs.

    >>> polygon_area(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]))
    2.0
    """
    x, y = points.T
    return abs(float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))))


def write_dxf(sheets: Sequence[Sheet], path: Path) -> None:
    """Draw sheets in rows, in millimetres; GeometryError where that can't be written."""
    import ezdxf

    document = ezdxf.new("R2010", units=MILLIMETRES)
    for layer, colour in LAYERS.items():
        document.layers.add(layer, color=colour)
    space = document.modelspace()
    for sheet, (x, y) in zip(sheets, in_rows([_room(sheet) for sheet in sheets]), strict=True):
        below = LINE * _text_height(sheet) * len(sheet.text)
        _draw(space, sheet, np.array([x, y + below]) - sheet.outline.min(axis=0))
    try:
        document.saveas(path)
    except (OSError, ezdxf.DXFError) as error:
        raise GeometryError(f"{path.name} could not be written: {error}") from error


def _room(sheet: Sheet) -> tuple[float, float]:
    """Width and depth of a sheet with what is written below it."""
    (wide, deep), height = np.ptp(sheet.outline, axis=0).tolist(), _text_height(sheet)
    letters = max((len(line) for line in sheet.text), default=0)
    return max(wide, 0.9 * height * letters), deep + LINE * height * len(sheet.text)


def _draw(space: Any, sheet: Sheet, shift: Array) -> None:
    polygons = [("CUT", sheet.outline), *(("HOLES", each) for each in sheet.openings)]
    polygons += [] if sheet.gage is None else [("GAGES", sheet.gage)]
    for layer, polygon in polygons:
        moved = (polygon + shift).tolist()
        space.add_lwpolyline(moved, close=True, dxfattribs={"layer": layer})
    for x, y, radius in sheet.circles:
        centre = (x + float(shift[0]), y + float(shift[1]))
        space.add_circle(centre, radius, dxfattribs={"layer": "HOLES"})
    for start, end in sheet.bends:
        space.add_line((start + shift).tolist(), (end + shift).tolist(), {"layer": "BEND"})
    height, (left, low) = _text_height(sheet), (sheet.outline.min(axis=0) + shift).tolist()
    for number, line in enumerate(sheet.text, start=1):
        place = (left, low - LINE * height * number)
        space.add_text(line, height=height, dxfattribs={"layer": "TEXT"}).set_placement(place)


def _text_height(sheet: Sheet) -> float:
    extent = float(np.ptp(sheet.outline, axis=0).max())
    return min(max(0.03 * extent, 0.4), 1.5)


def comb_sheet(part: PartMesh, side: Side) -> Sheet:
    """A comb as cut: the section of its triangles just under its outer face.

    Drawn as (x, y) for the sides +z and -z (seen from +z), as (z, y) for +x and -x (seen from -x).
    GeometryError where there is none, or where outline times thickness is not the sheet's volume.
    """
    out = part.vertices @ direction(side)
    solid = solid_of(part.vertices, part.triangles)
    loops = section_loops(solid, side, float(out.max()) - UNDER_MM)
    loops = sorted(loops, key=polygon_area, reverse=True)
    if not loops:
        raise GeometryError(f"{part.name} has no flat face across {side}")
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
    if apart.max() >= ROUNDING_MM:
        return None
    return round(float(x), MICRON) + 0.0, round(float(y), MICRON) + 0.0, round(radius, MICRON)


def write_drawings(casting: Casting, folder: Path) -> None:
    """Write all drawings into a folder: each kind of plate, each comb, and by material and
    thickness all that is cut (nested_*.dxf, the coupon's plates and combs too). GeometryError where
    one is not what was cut."""
    patterns, meshes = casting.patterns, casting.meshes
    if patterns:
        write_dxf([plate_sheet(pattern) for pattern in patterns], folder / PLATES_FILE)
    nested, trial = defaultdict[str, list[Sheet]](list), {frame.index for frame in casting.trial}
    for pattern in patterns:
        alike = replace(plate_sheet(pattern), text=(pattern.name,))
        count = pattern.count + len(trial.intersection(pattern.plates))
        nested[f"{pattern.material}_{pattern.thickness:g}mm"] += [alike] * count
    for comb in (*meshes.parts, *meshes.coupon):
        if comb.made == "sheet" and comb.draw:
            side = next(each for each in SIDES if axis_name(comb.draw) == each)
            sheet = comb_sheet(comb, side)
            write_dxf([sheet], folder / f"{comb.name}.dxf")
            name = f"combs_{np.ptp(comb.vertices @ direction(side)):.3g}mm"
            nested[name].append(replace(sheet, text=(comb.name,)))
    for name, sheets in nested.items():
        write_dxf(sheets, folder / f"nested_{name}.dxf")
    if casting.plan.groove is not None:
        write_dxf(mount_sheets(casting.plan), folder / MOUNT_FILE)


def mount_sheets(plan: MoldPlan) -> list[Sheet]:
    """The interface of the finger to a hand: the base plate's profile, and the receiver's back."""
    assert plan.groove is not None
    (depth, low, high), play = plan.groove, plan.limits.clearance_mm
    rail = (
        f"base plate across z: {2.0 * plan.mount_x:.2f} wide, {plan.base:g} thick",
        f"grooves {depth:.2f} deep, {high - low:.2f} high, {low + plan.base:.2f} from the back",
        f"receiver: {play:g} larger all round; slides along z over {2.0 * plan.mount_z:.2f}",
    )
    x, z = plan.mount_x + play + SIDE_MM, plan.mount_z + play + SIDE_MM
    back = np.array([[-x, -z], [x, -z], [x, z], [-x, z]])
    kind = {"inserts": "two heat-set inserts M3", "iso9409": "ISO 9409-1-50-4-M6, disc of 63"}
    circles = tuple((x, z, 0.5 * wide) for x, z, wide in flange_holes(plan))
    text = (
        *("receiver's back, x to the right, z up", kind[plan.design.mold.mount]),
        "the small hole is tapped M3",
    )
    screw = (0.0, -0.5 * plan.mount_z, 0.5 * STOP_SCREW_MM)
    profile = Sheet("base_plate", rail_profile(plan), text=rail)
    return [profile, Sheet("mount", back, circles=(*circles, screw), text=text)]


def plate_sheet(pattern: FlatPattern) -> Sheet:
    """A plate as cut: its legs, its holes, its gages' places, and where it is bent."""
    material = pattern.material.replace("_", " ")
    text = [
        f"{pattern.name}: {pattern.count} of {pattern.thickness:g} mm {material}",
        f"plates {numbers_text(pattern.plates)}, {pattern.seen} face shown",
        f"gages on {' and '.join(pattern.faces)} face",
    ]
    bends: tuple[Array, ...] = ()
    if pattern.bend_radius is not None:
        _, w = pattern.outline.T
        bends = (np.array([[0.0, w.min()], [0.0, w.max()]]),)
        text.append(f"bend the whole width to R {pattern.bend_radius:.3f} of the middle")
    return Sheet(
        pattern.name,
        pattern.outline,
        circles=tuple((round(x, 3), round(y, 3), round(r, 3)) for x, y, r in pattern.holes),
        gage=pattern.gage,
        bends=bends,
        text=tuple(text),
    )


def numbers_text(plates: Iterable[int]) -> str:
    """Whole numbers, runs shortened.

    >>> numbers_text([8, 0, 1, 2, 5, 7])
    '0-2, 5, 7-8'
    """
    runs = groupby(enumerate(sorted(plates)), lambda each: each[1] - each[0])
    ends = ([plate for _, plate in run] for _, run in runs)
    return ", ".join(str(r[0]) if len(r) == 1 else f"{r[0]}-{r[-1]}" for r in ends)
