"""The drawings of a mold: plates.dxf, and a DXF for each comb or jig that is cut from sheet."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.mold.casting_bench import numbers_text
from fingerdesign.mold.drawing import Sheet, write_dxf
from fingerdesign.mold.flat_pattern import FlatPattern
from fingerdesign.mold.outlines import sheet_outline
from fingerdesign.mold.part import MoldMeshes, PartMesh, comb_names
from fingerdesign.mold.plan import MoldPlan, Side

PLATES_FILE = "plates.dxf"


def write_drawings(
    plan: MoldPlan, meshes: MoldMeshes, patterns: Sequence[FlatPattern], folder: Path
) -> tuple[str, ...]:
    """All drawings into a folder; their names. GeometryError where one is not what was cut."""
    names = []
    if patterns:
        write_dxf([plate_sheet(pattern) for pattern in patterns], folder / PLATES_FILE)
        names.append(PLATES_FILE)
    made = {part.name: part for part in meshes.parts}
    for side in plan.sides:
        for name in comb_names(side.side, side.holding):
            part = made[name]
            if part.made == "sheet":
                write_dxf([comb_sheet(part, side.side)], folder / f"{name}.dxf")
                names.append(f"{name}.dxf")
    return tuple(names)


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


def comb_sheet(part: PartMesh, side: Side) -> Sheet:
    """A comb or jig as cut, from its triangles."""
    found = sheet_outline(part, side)
    axis = 2 if side.endswith("z") else 0
    thick = float(np.ptp(part.vertices[:, axis]))
    seen = "x to the right, seen from +z" if axis == 2 else "z to the right, seen from -x"
    cut = f"{len(found.openings)} openings, {len(found.circles)} round holes"
    text = (f"{part.name}: 1 of {thick:g} mm sheet, {cut}", f"{seen}, y up")
    return Sheet(part.name, found.around, found.openings, found.circles, text=text)
