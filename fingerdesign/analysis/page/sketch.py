"""A dimensioned drawing of a design: its section, its side, one plate enlarged, and the facts that
no dimension line shows. Lengths in mm, angles in degrees."""

from dataclasses import replace

import numpy as np

from fingerdesign.analysis.page.section import (
    Shape,
    dimension_shapes,
    draw_shapes,
    enlarged_shapes,
    section_shapes,
)
from fingerdesign.design.plates import Plates
from fingerdesign.design.schema import Design
from fingerdesign.layout.row_keys import plate_rows
from fingerdesign.report import style


def draw_sketch(design: Design) -> style.Canvas:
    """The drawing. Call it, and save what it returns, inside ``style.house_style()``."""
    figure = style.canvas(9.0, 6.4)
    rows = plate_rows(design)
    grid = figure.add_gridspec(2, 2, height_ratios=(1.0, 1.0), width_ratios=(1.3, 1.0))
    figure.suptitle(f"{design.design.name}   (mm, degrees)", x=0.02, ha="left", fontsize=11)
    draw_shapes(figure.add_subplot(grid[0, :]), _views(design))
    if rows:
        axes, plate, gage = figure.add_subplot(grid[1, 0]), rows[0].frames[0], design.gages
        draw_shapes(axes, list(enlarged_shapes(design, rows[0])))
        size = f"{plate.thickness:g} thick, gages {gage.length_mm:g} long"
        axes.set_title(f"one plate enlarged ({plate.along}, y): {size}")
    words = figure.add_subplot(grid[1, 1])
    words.set_title("its parts")
    words.text(0.0, 0.97, "\n".join(facts(design)), va="top", fontsize=8.5, linespacing=1.5)
    words.set_axis_off()
    return figure


def _views(design: Design) -> list[Shape]:
    """Section and side next to each other, on one base line and in one scale, with titles."""
    views = [[*section_shapes(design, way), *dimension_shapes(design, way)] for way in ("x", "z")]
    boxes = [np.concatenate([shape.points for shape in view]) for view in views]
    top = max(float(box[:, 1].max()) for box in boxes)
    apart = np.ptp(np.concatenate(boxes)[:, 0])
    shift = np.array([boxes[0][:, 0].max() - boxes[1][:, 0].min() + 0.12 * apart, 0.0])
    moved = [replace(shape, points=shape.points + shift) for shape in views[1]]
    titles = [
        Shape("title", np.array([[place, top + 0.08 * apart]]), text=text)
        for place, text in ((0.0, "section at z = 0"), (shift[0], "side, at x = 0"))
    ]
    return [*views[0], *moved, *titles]


def _extras(table: Plates) -> list[str]:
    """A line for a row whose plates follow the surface, lie aside or have holes."""
    found = [] if table.follow == "level" else [f"{table.follow} with the surface"]
    if table.stagger_mm:
        found.append(f"every second one {table.stagger_mm:g} aside")
    if table.hole_diameter_mm is not None:
        found.append(f"holes {table.hole_diameter_mm:g} every {table.hole_pitch_mm:g}")
    return [f"    {', '.join(found)}"] if found else []


def facts(design: Design) -> list[str]:
    """The materials, counts and sizes that no dimension line shows, a line each."""
    body, modulus = design.body, design.materials[design.body.material].youngs_modulus_MPa
    found = [f"body: {body.shape}, {body.material.replace('_', ' ')}, {modulus:g} MPa"]
    if body.edge_radius_mm:
        found.append(f"edge: {body.edge} of {body.edge_radius_mm:g}")
    if body.core is not None:
        core = body.core
        depth = "all" if core.depth_mm is None else f"{core.depth_mm:g}"
        size = f"{core.width_mm:g} x {core.height_mm:g} x {depth}"
        found.append(f"core: {size}, {core.bottom_mm:g} above the base, {core.material}")
    for row in plate_rows(design):
        table = row.table
        plates = f"{len(row.frames)} plates along {table.along}: {table.material.replace('_', ' ')}"
        found.append(f"{plates}, {table.length_mm:g} x {table.thickness_mm:g}")
        spans = sorted({round(frame.span, 3) for frame in row.frames})
        shown = f"{spans[0]:g}" if len(spans) == 1 else f"{spans[0]:g} to {spans[-1]:g}"
        level = f"pitch {table.pitch_mm:g}, cover {table.cover_mm:g}"
        found.append(f"    span {shown}, {'placed one by one' if row.placed else level}")
        found += _extras(table)
    if plate_rows(design):
        gages = design.gages
        faces = "both faces" if gages.face == "both" else f"the {gages.face} face"
        size = f"{gages.length_mm:g} x {gages.width_mm:g}"
        found.append(f"gages: {size} at z = {gages.z_mm:g} of each plate, {faces}, {gages.grid}")
    if design.assumed:
        found.append(f"{len(design.assumed)} of its keys are assumed (see `assumed`)")
    return found
