"""A dimensioned drawing of a design: its section, its side, one plate enlarged; nothing is computed
that a design does not say, so it is there in a second.

Lengths in mm, angles in degrees. The section is the one at z = 0 (x, y), the side at x = 0 (z, y).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame, PlateRow, crest_height, plate_rows
from fingerdesign.layout.frames import surface_height as height_over
from fingerdesign.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

_Point = Sequence[float] | Array
_FINE = 241  # points of an outline
_RUBBER, _OTHERS = style.OPEN_COLOUR, "#b9bdc2"


def draw_sketch(design: Design) -> Canvas:
    """The drawing. Call it, and save what it returns, inside ``style.house_style()``."""
    figure = style.canvas(9.0, 6.4)
    rows = plate_rows(design)
    grid = figure.add_gridspec(2, 2, height_ratios=(1.0, 1.0), width_ratios=(1.3, 1.0))
    section, side = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
    enlarged, words = figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1])
    figure.suptitle(f"{design.design.name}   (mm, degrees)", x=0.02, ha="left", fontsize=11)
    _view(section, design, rows, "x")
    _view(side, design, rows, "z")
    _size_section(section, design)
    _size_side(side, design)
    if rows:
        _enlarge(enlarged, design, rows[0])
    words.set_title("what it is made of")
    words.text(0.0, 0.97, "\n".join(facts(design)), va="top", fontsize=8.5, linespacing=1.5)
    words.set_xlim(0.0, 1.0)
    words.set_ylim(0.0, 1.0)
    for axes in figure.axes:
        axes.set_axis_off()
    return figure


def facts(design: Design) -> list[str]:
    """What no dimension line shows, a line each."""
    body, found = design.body, []
    found.append(f"body: {body.shape}, {body.material.replace('_', ' ')}, {_modulus(design)} MPa")
    if body.edge_radius_mm:
        found.append(f"edge: {body.edge} of {body.edge_radius_mm:g}")
    if body.core is not None:
        core = body.core
        depth = "all" if core.depth_mm is None else f"{core.depth_mm:g}"
        size = f"{core.width_mm:g} x {core.height_mm:g} x {depth}"
        found.append(f"core: {size}, {core.bottom_mm:g} above the base, {core.material}")
    for row in plate_rows(design):
        table = row.table
        found.append(
            f"{len(row.frames)} plates along {table.along}: {table.material.replace('_', ' ')}, "
            f"{table.length_mm:g} x {table.thickness_mm:g}"
        )
        spans = sorted({round(frame.span, 3) for frame in row.frames})
        shown = f"{spans[0]:g}" if len(spans) == 1 else f"{spans[0]:g} to {spans[-1]:g}"
        placed = "placed one by one" if row.placed else f"pitch {table.pitch_mm:g}"
        placed += "" if row.placed else f", cover {table.cover_mm:g}"
        found.append(f"    span {shown}, {placed}")
    if plate_rows(design):
        gages = design.gages
        faces = "both faces" if gages.face == "both" else f"the {gages.face} face"
        size = f"{gages.length_mm:g} x {gages.width_mm:g}"
        found.append(f"gages: {size} at z = {gages.z_mm:g} of each plate, {faces}, {gages.grid}")
    if design.assumed:
        found.append(f"{len(design.assumed)} of its keys are assumed (see `assumed`)")
    return found


def _modulus(design: Design) -> str:
    return f"{design.materials[design.body.material].youngs_modulus_MPa:g}"


def _view(axes: Axes, design: Design, rows: Sequence[PlateRow], along: str) -> None:
    """The body and its plates in the plane of ``along`` and y."""
    body = design.body
    half = 0.5 * (body.width_mm if along == "x" else body.depth_mm)
    place = np.linspace(-half, half, _FINE)
    zero = np.zeros_like(place)
    height = height_over(body, *((place, zero) if along == "x" else (zero, place)))
    kept = np.isfinite(height)
    place, height = place[kept], height[kept]
    outline_x = np.concatenate([place[:1], place, place[-1:]])
    outline_y = np.concatenate([[0.0], height, [0.0]])
    axes.fill(outline_x, outline_y, facecolor=_RUBBER, edgecolor=style.INK, lw=1.0)
    if (core := body.core) is not None:
        reach = core.width_mm if along == "x" else core.depth_mm or body.depth_mm
        box = np.array([-1, 1, 1, -1]) * 0.5 * reach
        low, high = core.bottom_mm, core.bottom_mm + core.height_mm
        axes.fill(box, [low, low, high, high], facecolor=_OTHERS, edgecolor=style.INK, lw=0.7)
    axes.plot([-1.08 * half, 1.08 * half], [0.0, 0.0], color=style.INK, lw=2.2)
    for number, x in enumerate(np.linspace(-half, half, 17)):
        if number:
            axes.plot([x, x - 0.05 * half], [0.0, -0.05 * half], color=style.MUTED, lw=0.6)
    for frame in (frame for row in rows for frame in row.frames):
        if frame.along == along:
            shape = frame.outline()
        else:
            low, high = frame.outline()[:, 1].min(), frame.outline()[:, 1].max()
            ends = [frame.low, frame.high, frame.high, frame.low]
            shape = np.column_stack([ends, [low, low, high, high]])
        axes.fill(*shape.T, facecolor=style.BLUE, edgecolor=style.BLUE, lw=0.5, alpha=0.75)
        if frame.along == along:
            _gages(axes, design, frame, 1.6)
    axes.set_title("section at z = 0" if along == "x" else "side, at x = 0")
    axes.set_aspect("equal", anchor="C")


def _gages(axes: Axes, design: Design, frame: PlateFrame, width: float) -> None:
    along = np.linspace(-0.5, 0.5, 9) * design.gages.length_mm
    for side in design.gages.sides:
        line = frame.from_local(along, side * 0.5 * frame.thickness)
        axes.plot(*line.T, color=style.VERMILION, lw=width, solid_capstyle="butt")


def _line(axes: Axes, start: _Point, end: _Point, text: str, *, shift: _Point) -> None:
    """A dimension line beside what it measures, ``shift`` away from it, with its text on it."""
    first, last = (np.asarray(each, dtype=float) + shift for each in (start, end))
    for at, moved in ((start, first), (end, last)):
        axes.plot(*zip(at, moved, strict=True), color=style.MUTED, lw=0.5)
    arrow = {"arrowstyle": "<->", "color": style.MUTED, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", tuple(last), tuple(first), arrowprops=arrow)
    turn = float(np.degrees(np.arctan2(*(last - first)[::-1])))
    turn = turn - 180.0 if turn > 90.0 else turn
    if text:
        _label(axes, 0.5 * (first + last), text, rotation=turn)


def _label(axes: Axes, at: Array, text: str, **more: Any) -> None:
    box = {"facecolor": style.PAPER, "edgecolor": "none", "pad": 0.8, "alpha": 0.9}
    middle: dict[str, Any] = {"ha": "center", "va": "center", "rotation_mode": "anchor"}
    axes.text(float(at[0]), float(at[1]), text, fontsize=8.5, bbox=box, zorder=9, **middle | more)


def _size_section(axes: Axes, design: Design) -> None:
    body, crest = design.body, crest_height(design.body)
    half = 0.5 * body.width_mm
    far = 0.16 * max(half, crest)
    name = "diameter" if body.shape == "revolved" else "width"
    _line(axes, (-half, 0.0), (half, 0.0), f"{name} {body.width_mm:g}", shift=(0.0, -1.3 * far))
    _line(axes, (half, 0.0), (half, crest), f"crest {crest:.4g}", shift=(1.2 * far, 0.0))
    if body.kind.closed_form:
        base = body.base_height_mm
        _line(axes, (-half, 0.0), (-half, base), f"base {base:g}", shift=(-1.2 * far, 0.0))
        radius = body.kind.top_radius(body)
        if np.isfinite(radius):
            x = -0.62 * half
            at = np.array([x, float(height_over(body, x))])
            out = at + np.array([-0.4, 1.0]) * 0.9 * far
            arrow = {"arrowstyle": "->", "color": style.MUTED, "lw": 0.8, "shrinkB": 0}
            axes.annotate("", tuple(at), tuple(out), arrowprops=arrow)
            _label(axes, out, f"R {radius:g}", ha="right", va="bottom")
    _room(axes, half + 2.0 * far, -2.0 * far, crest + 1.3 * far)


def _size_side(axes: Axes, design: Design) -> None:
    body, crest = design.body, crest_height(design.body)
    half = 0.5 * body.depth_mm
    far = 0.16 * max(half, crest)
    _line(axes, (-half, 0.0), (half, 0.0), f"depth {body.depth_mm:g}", shift=(0.0, -1.3 * far))
    dome = body.dome_radius_mm
    if body.shape == "dome" and dome is not None:
        _label(axes, np.array([0.0, crest + 0.6 * far]), f"R {dome:g} in z")
    _room(axes, half + 2.0 * far, -2.0 * far, crest + 1.3 * far)


def _room(axes: Axes, half: float, low: float, high: float) -> None:
    axes.set_xlim(-half, half)
    axes.set_ylim(low, high)


def _enlarge(axes: Axes, design: Design, row: PlateRow) -> None:
    """The row's middle plate with its neighbours, and what is measured on it."""
    frames = sorted(row.frames, key=lambda frame: frame.place)
    number = max((len(frames) - 1) // 2, 0)
    plate = frames[number]
    others = [frame for frame in frames if frame is not plate]
    beside = frames[number + 1] if number + 1 < len(frames) else None
    centre, length = plate.centre, plate.length
    pitch = 0.0 if beside is None else float(np.hypot(*(beside.centre - centre)))
    steep = abs(np.sin(np.radians(plate.angle_deg)))
    reach = 0.5 * length * steep
    surface = _surface(design, plate, np.array([plate.place]))[0]
    cover = float(surface - plate.y)
    half = 0.5 * length + max(1.35 * pitch, 0.55 * length)
    unit = 0.11 * max(half, cover + reach)
    at = np.linspace(plate.place - 1.7 * half, plate.place + 1.7 * half, _FINE)
    line = _surface(design, plate, at)
    low = plate.y - reach - 3.4 * unit
    kept = np.isfinite(line)
    axes.fill_between(at[kept], low, line[kept], color=_RUBBER, lw=0.0)
    axes.plot(at[kept], line[kept], color=style.INK, lw=1.0)
    for frame in others:
        axes.fill(*frame.outline().T, facecolor=_OTHERS, edgecolor="none")
    axes.fill(*plate.outline().T, facecolor=style.BLUE, edgecolor=style.BLUE, lw=0.4)
    _gages(axes, design, plate, 2.6)
    _angle(axes, plate, unit)
    ends = plate.from_local(np.array([-0.5, 0.5]) * length, 0.0)
    away = plate.normal if plate.normal[1] >= 0.0 else -plate.normal
    _line(axes, ends[0], ends[1], f"{length:g}", shift=1.25 * unit * away)
    right = 0.5 * length * np.sqrt(1.0 - steep**2) + 0.8 * unit
    top = np.array([plate.place, surface])
    _line(axes, centre, top, "", shift=(right, 0.0))
    said = centre + np.array([right + 0.3 * unit, 0.6 * cover])
    _label(axes, said, f"cover {cover:.3g}", ha="left")
    if beside is not None:
        y = low + 1.2 * unit
        starts = (centre, np.array([beside.place, centre[1]]))
        words = f"{pitch if row.placed else row.table.pitch_mm:.3g}"
        _line(axes, *starts, f"pitch {words}", shift=(0.0, y - centre[1]))
    plane, gage = f"({plate.along}, y)", design.gages.length_mm
    words = f"plate {plate.index} enlarged {plane}: {plate.thickness:g} thick, gages {gage:g} long"
    axes.set_title(words)
    axes.set_xlim(plate.place - 1.7 * half, plate.place + 1.7 * half)
    axes.set_ylim(low, max(surface, float(np.nanmax(line))) + 0.8 * unit)
    axes.set_aspect("equal", anchor="W")


def _surface(design: Design, plate: PlateFrame, place: Array) -> Array:
    """Height of the surface over places in the plane of a plate."""
    across = np.full_like(place, plate.middle)
    given = (place, across) if plate.along == "x" else (across, place)
    return np.asarray(height_over(design.body, *given))


def _angle(axes: Axes, plate: PlateFrame, unit: float) -> None:
    """Between the row's direction and the plate, at its lower end."""
    if abs(plate.angle_deg) < 1.0:
        return
    turn = np.radians(np.linspace(0.0, plate.angle_deg, 25))
    corner = plate.from_local(-0.5 * plate.length, 0.0)[0]
    size = min(2.4 * unit, 0.7 * plate.length)
    axes.plot(corner[0] + np.array([0.0, 1.25 * size]), [corner[1]] * 2, color=style.MUTED, lw=0.6)
    arc = corner + size * np.column_stack([np.cos(turn), np.sin(turn)])
    axes.plot(*arc.T, color=style.MUTED, lw=0.8)
    out = corner + size * np.array([1.3, 0.12 * np.sign(plate.angle_deg)])
    _label(axes, out, f"{plate.angle_deg:g}°", ha="left")
