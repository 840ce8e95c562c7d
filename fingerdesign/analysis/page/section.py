"""A finger's section as shapes in mm, and the one drawing of it: as SVG for pages, by matplotlib.

The section is at z = 0 (x, y) or, along z, at x = 0 (z, y). Only the design is read, so that the
drawing is there at once.
"""

import html
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.laws import OPEN, STICK
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.bodies import surface_height as height_over
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.row_keys import PlateRow
from fingerdesign.layout.rows import plate_frames
from fingerdesign.report import style

_FINE = 241  # Points of an outline.
_WIDTH = 560.0  # Of an SVG, in its own units.
_GAGE_LIFT = 0.0025  # Of the drawing's width: half of a gage's line, which lies on its plate.
_ROOM = 0.16  # Of the finger's size: between it and a dimension line.
_LETTER = 6.5  # Width of a letter in the page, in units of its view.

_TITLE: dict[str, Any] = {"fontsize": 9.0, "fontweight": "bold"}  # As of every other figure.

# The look of a shape is a class of the style sheet in SVG, and these values in matplotlib.
_LOOKS: dict[str, dict[str, Any]] = {
    "body": {"facecolor": style.OPEN_COLOUR, "edgecolor": style.INK, "lw": 1.0},
    "core": {"facecolor": "#b9bdc2", "edgecolor": style.INK, "lw": 0.7},
    "base": {"color": style.INK, "lw": 2.2},
    "plate": {"facecolor": style.BRONZE, "edgecolor": style.BRONZE, "lw": 0.5},
    "other": {"facecolor": "#b9bdc2", "edgecolor": "none"},
    "gage": {"color": style.PURPLE, "lw": 1.5, "solid_capstyle": "butt"},
    "thin": {"color": style.MUTED, "lw": 0.6},
}


@dataclass(frozen=True)
class Shape:
    """A line, or an area where ``closed``, through points (n, 2), mm; its text is at their middle.

    look: "body", "core", "base", "plate", "other", "gage", "thin", "arrow", "text", "title",
    "object", "stick" or "slip". plate: of a gage, its index.
    """

    look: str
    points: Array
    closed: bool = False
    text: str = ""
    plate: int = -1

    @property
    def turn_deg(self) -> float:
        """The angle of the text: along the line, readable from below or from the right."""
        if len(self.points) < 2:
            return 0.0
        turn = float(np.degrees(np.arctan2(*(self.points[-1] - self.points[0])[::-1])))
        return turn - 180.0 if turn > 90.0 else turn


@dataclass(frozen=True)
class Touch:
    """A contact to be drawn on the surface: places x (m,), mm, their status, and the forces, N."""

    x: Array
    status: IntArray
    normal_N: float
    tangential_N: float


def _polygon(*points: tuple[float, float]) -> Array:
    return np.array(points, dtype=float)


def section_shapes(design: Design, along: str = "x") -> Iterator[Shape]:
    """Body, core, plates and gages in the plane of ``along`` and y."""
    body = design.body
    half = 0.5 * (body.width_mm if along == "x" else body.depth_mm)
    place = half * np.sin(np.linspace(-0.5, 0.5, _FINE) * np.pi)
    zero = np.zeros_like(place)
    height = np.asarray(height_over(body, *((place, zero) if along == "x" else (zero, place))))
    known = np.isfinite(height)
    place, height = place[known], height[known]
    ends = place[[0, -1]]
    outline = np.column_stack([[ends[0], *place, ends[1]], [0.0, *height, 0.0]])
    yield Shape("body", outline, closed=True)
    if (core := body.core) is not None:
        reach = 0.5 * (core.width_mm if along == "x" else core.depth_mm or body.depth_mm)
        low, high = core.bottom_mm, core.bottom_mm + core.height_mm
        box = _polygon((-reach, low), (reach, low), (reach, high), (-reach, high))
        yield Shape("core", box, closed=True)
    yield Shape("base", _polygon((-half, 0.0), (half, 0.0)))
    frames = plate_frames(design)
    for frame in frames:
        shape = frame.outline()
        if frame.along != along:
            low, high = shape[:, 1].min(), shape[:, 1].max()
            corners = ((frame.low, low), (frame.high, low), (frame.high, high), (frame.low, high))
            shape = _polygon(*corners)
        yield Shape("plate", shape, closed=True)
    for frame in frames:
        if frame.along == along:
            yield from gage_shapes(design, frame, 2.0 * half)
        elif along == "z":  # seen from the side, all gages of a row lie behind each other
            middle, reach = design.gages.z_mm, 0.5 * design.gages.width_mm
            yield Shape("gage", _polygon((middle - reach, frame.y), (middle + reach, frame.y)))


def gage_shapes(design: Design, frame: PlateFrame, wide: float) -> Iterator[Shape]:
    """The gages of a plate, on its faces; ``wide``: of what is drawn, mm."""
    along = np.linspace(-0.5, 0.5, 9) * design.gages.length_mm
    lift = 0.5 * frame.thickness + _GAGE_LIFT * wide
    for side in design.gages.sides:
        yield Shape("gage", frame.from_local(along, side * lift), plate=frame.index)


def dimension_shapes(design: Design, along: str = "x") -> Iterator[Shape]:
    """Dimension lines of the body around its section."""
    body, crest = design.body, float(crest_height(design.body))
    half = 0.5 * (body.width_mm if along == "x" else body.depth_mm)
    off = _ROOM * max(half, crest)
    names = {"x": "diameter" if body.shape == "revolved" else "width", "z": "depth"}
    across = f"{names[along]} {2.0 * half:g}"
    yield from measured((-half, 0.0), (half, 0.0), (0.0, -1.3 * off), across)
    if along == "z":
        if body.shape == "dome" and body.dome_radius_mm is not None:
            words = f"R {body.dome_radius_mm:g} in z"
            yield Shape("text", _polygon((0.0, crest + 0.6 * off)), text=words)
        return
    yield from measured((half, 0.0), (half, crest), (1.2 * off, 0.0), f"crest {crest:.4g}")
    if body.kind.closed_form:
        base = body.base_height_mm
        yield from measured((-half, 0.0), (-half, base), (-1.2 * off, 0.0), f"base {base:g}")
        radius = body.kind.top_radius(body)
        if np.isfinite(radius):
            at = np.array([-0.62 * half, float(height_over(body, -0.62 * half))])
            out = at + np.array([-0.4, 1.0]) * 0.9 * off
            yield Shape("thin", np.array([out, at]))
            yield Shape("text", _polygon((out[0], out[1] + 0.25 * off)), text=f"R {radius:g}")


def measured(
    start: Sequence[float] | Array, end: Sequence[float] | Array, shift: Sequence[float], text: str
) -> Iterator[Shape]:
    """A dimension line next to what it measures, ``shift`` away, with its extension lines."""
    ends = np.array([start, end], dtype=float)
    for point in ends:
        yield Shape("thin", np.array([point, point + shift]))
    yield Shape("arrow", ends + shift, text=text)


def contact_shapes(design: Design, touch: Touch) -> Iterator[Shape]:
    """The object above the finger, and the surface that sticks and slips."""
    x = touch.x
    edges = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
    for low, high, status in zip(edges[:-1], edges[1:], touch.status, strict=True):
        if status != OPEN:
            place = np.linspace(low, high, 3)
            line = np.column_stack([place, height_over(design.body, place)])
            yield Shape("stick" if status == STICK else "slip", line)
    crest, half = float(crest_height(design.body)), 0.5 * design.body.width_mm
    y = crest + 0.06 * half
    yield Shape("object", _polygon((-0.84 * half, y), (0.84 * half, y)))
    words = f"{touch.normal_N:.3g} N down, {touch.tangential_N:.3g} N across"
    yield Shape("text", _polygon((0.0, y + 0.09 * half)), text=words)


def enlarged_shapes(design: Design, row: PlateRow) -> Iterator[Shape]:
    """The row's middle plate with its neighbours: length, angle, cover and pitch."""
    frames = sorted(row.frames, key=lambda frame: frame.place)
    number = max((len(frames) - 1) // 2, 0)
    plate = frames[number]
    following = frames[number + 1] if number + 1 < len(frames) else None
    pitch = 0.0 if following is None else float(np.hypot(*(following.centre - plate.centre)))
    steep = abs(np.sin(np.radians(plate.angle_deg)))
    reach = 0.5 * plate.length * steep
    half = max(1.25 * pitch, pitch + 0.6 * plate.length, 1.4 * plate.length)
    places = np.linspace(plate.place - half, plate.place + half, _FINE)
    across = np.full_like(places, plate.middle)
    given = (places, across) if plate.along == "x" else (across, places)
    line = np.asarray(height_over(design.body, *given))
    top = float(np.interp(plate.place, places, line))
    cover = top - plate.y
    unit = 0.11 * max(0.6 * half, cover + reach)
    low = plate.y - reach - 3.4 * unit
    known = np.isfinite(line)
    surface = np.column_stack([places[known], line[known]])
    ends = surface[[-1, 0], 0]
    yield Shape("body", np.vstack([surface, np.column_stack([ends, [low, low]])]), closed=True)
    inside = np.array([[places[0], low], [places[-1], np.inf]])
    for shape in (frame.outline() for frame in frames if frame is not plate):
        if (shape > inside[0]).all() and (shape < inside[1]).all():
            yield Shape("other", shape, closed=True)
    yield Shape("plate", plate.outline(), closed=True)
    yield from gage_shapes(design, plate, 2.0 * half)
    yield from _angle_shapes(plate, unit)
    tips = plate.from_local(np.array([-0.5, 0.5]) * plate.length, 0.0)
    away = plate.normal if plate.normal[1] >= 0.0 else -plate.normal
    yield from measured(tips[0], tips[1], 1.25 * unit * away, f"{plate.length:g}")
    right = 0.5 * plate.length * np.sqrt(1.0 - steep**2) + 0.8 * unit
    yield from measured(plate.centre, (plate.place, top), (right, 0.0), f"cover {cover:.3g}")
    if following is not None:
        end = (following.place, plate.centre[1])
        text = f"pitch {pitch if row.placed else row.table.pitch_mm:.3g}"
        yield from measured(plate.centre, end, (0.0, low + 1.2 * unit - plate.centre[1]), text)


def _angle_shapes(plate: PlateFrame, unit: float) -> Iterator[Shape]:
    """Between the row's direction and the plate, at its lower end."""
    if abs(plate.angle_deg) < 1.0:
        return
    turn = np.radians(np.linspace(0.0, plate.angle_deg, 25))
    corner = plate.from_local(-0.5 * plate.length, 0.0)[0]
    size = min(2.4 * unit, 0.7 * plate.length)
    yield Shape("thin", np.array([corner, corner + np.array([1.25 * size, 0.0])]))
    yield Shape("thin", corner + size * np.column_stack([np.cos(turn), np.sin(turn)]))
    out = corner + size * np.array([1.6, 0.12 * np.sign(plate.angle_deg)])
    yield Shape("text", out[None], text=f"{plate.angle_deg:g}°")


def section_svg(
    design: Design, words: str, touch: Touch | None = None, picked: int | None = None
) -> str:
    """The dimensioned section as one <svg>; ``words``: its text alternative.

    picked: the plate whose gage is emphasised. Gages carry data-gage, their plate's index.
    """
    shapes = [*section_shapes(design), *dimension_shapes(design)]
    if touch is not None:
        shapes += contact_shapes(design, touch)
    every = np.concatenate([each.points for each in shapes])
    low, high = every.min(axis=0), every.max(axis=0)
    margin = 0.05 * float(high[0] - low[0])
    scale = _WIDTH / (float(high[0] - low[0]) + 2.0 * margin)
    tall = (float(high[1] - low[1]) + 2.0 * margin) * scale

    def placed(points: Array) -> Array:
        x, y = points.T
        return np.column_stack([x - low[0] + margin, high[1] + margin - y]) * scale

    def path(points: Array, closed: bool) -> str:
        line = " L".join(f"{x:.1f} {y:.1f}" for x, y in placed(points))
        return f"M{line}{' Z' if closed else ''}"

    def element(shape: Shape) -> Iterator[str]:
        if shape.look != "text":
            line = f'd="{path(shape.points, shape.closed)}"'
            if shape.plate >= 0:
                own = " picked" if shape.plate == picked else ""
                title = f"gage of plate {shape.plate}"
                yield f'<g class="gage{own}" data-gage="{shape.plate}"><title>{title}</title>'
                yield f'<path class="target" {line}/><path {line}/></g>'
            else:
                yield f'<path class="{shape.look}" {line}/>'
        if shape.text:
            x, y = placed(0.5 * (shape.points[:1] + shape.points[-1:]))[0]
            at = f'transform="translate({x:.1f} {y:.1f}) rotate({-shape.turn_deg:.0f})"'
            if shape.look == "arrow":  # Letters hide the line behind them, a blank does not.
                wide = _LETTER * len(shape.text)
                yield f'<rect {at} x="{-0.5 * wide:.0f}" y="-6" width="{wide:.0f}" height="12"/>'
            yield f'<text {at} dy="0.35em">{html.escape(shape.text)}</text>'

    inside = "".join(part for shape in shapes for part in element(shape))
    name = html.escape(words, quote=True)
    view = f'class="section" viewBox="0 0 {_WIDTH:.0f} {tall:.0f}"'
    return f'<svg {view} role="img" aria-label="{name}">{inside}</svg>'


def draw_shapes(axes: style.Axes, shapes: Sequence[Shape]) -> None:
    """Draw shapes with equal scales, without ticks."""
    label: dict[str, Any] = {"ha": "center", "va": "center", "rotation_mode": "anchor"}
    label["bbox"] = {"facecolor": style.PAPER, "edgecolor": "none", "pad": 0.8, "alpha": 0.9}
    arrow = {"arrowstyle": "<->", "color": style.MUTED, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    for shape in shapes:
        if shape.closed:
            axes.fill(*shape.points.T, **_LOOKS[shape.look])
        elif shape.look == "arrow":
            axes.annotate("", tuple(shape.points[1]), tuple(shape.points[0]), arrowprops=arrow)
        elif shape.look not in ("text", "title"):
            axes.plot(*shape.points.T, **_LOOKS[shape.look])
        if shape.text:
            x, y = 0.5 * (shape.points[0] + shape.points[-1])
            font = _TITLE if shape.look == "title" else {"fontsize": 8.5}
            axes.text(x, y, shape.text, zorder=9, rotation=shape.turn_deg, **font, **label)
    every = np.concatenate([each.points for each in shapes])
    low, high = every.min(axis=0), every.max(axis=0)
    margin = 0.05 * float((high - low).max())
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal", anchor="C")
    axes.set_axis_off()
