"""The dimensioned section as SVG: outline, plates, gages, dimensions, object and contact.

Drawn in mm times a scale, y up; colours are the page's variables, so it follows its theme.
"""

from __future__ import annotations

import html
from collections.abc import Iterable

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.laws import OPEN, STICK
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame, crest_height, plate_frames, surface_height
from fingerdesign.report.page import paragraphs
from fingerdesign.studio.numbers import Numbers
from fingerdesign.studio.verdict import WORDS

WIDTH = 560.0  # of the drawing, in its own units
_LEFT, _RIGHT, _TOP, _BOTTOM = 74.0, 62.0, 46.0, 50.0
_POINTS = 161  # of the outline's upper side
_GAGE_LIFT = 2.6  # of the drawing's units: a gage lies beside its plate's face


class _Frame:
    """From mm to the drawing."""

    def __init__(self, width: float, crest: float) -> None:
        self.half = 0.5 * width
        self.scale = (WIDTH - _LEFT - _RIGHT) / width
        self.height = crest * self.scale + _TOP + _BOTTOM
        self.floor = crest * self.scale + _TOP

    def at(self, points: Array) -> Array:
        """Places of points (n, 2) mm."""
        x = _LEFT + (points[:, 0] + self.half) * self.scale
        return np.column_stack([x, self.floor - points[:, 1] * self.scale])

    def path(self, points: Array, closed: bool = False) -> str:
        """A path through points (n, 2) mm."""
        text = " L".join(f"{x:.1f} {y:.1f}" for x, y in self.at(points))
        return f"M{text}{' Z' if closed else ''}"


def sketch(design: Design, now: Numbers | None, picked: int | None = None) -> str:
    """The section z = 0 with its dimensions, the object over it and what the contact does.

    now: None before the first answer. picked: the plate whose gage is shown.
    """
    body, crest = design.body, float(crest_height(design.body))
    frame = _Frame(body.width_mm, crest)
    plates = [each for each in plate_frames(design) if each.along == "x"]
    values = {"name": design.design.name, "width": body.width_mm, "crest": crest}
    words = paragraphs(WORDS, "sketch", **values, plates=len(plates), now=now, dimension=2)[0]
    parts = [
        f'<svg class="sketch" viewBox="0 0 {WIDTH:.0f} {frame.height:.0f}" role="img" '
        f'aria-label="{html.escape(words, quote=True)}">',
        *_body(design, frame),
        *_plates(design, frame, plates, picked),
        *([] if now is None else _contact(design, frame, now)),
        *_dimensions(design, frame, crest, plates),
        "</svg>",
    ]
    return "".join(parts)


def _outline(design: Design) -> Array:
    """The upper side's points (n, 2), from left to right, mm."""
    half = 0.5 * design.body.width_mm
    x = half * np.sin(np.linspace(-0.5, 0.5, _POINTS) * np.pi)
    y = np.asarray(surface_height(design.body, x))
    known = np.isfinite(y)
    return np.column_stack([x[known], y[known]])


def _body(design: Design, frame: _Frame) -> Iterable[str]:
    top = _outline(design)
    half = 0.5 * design.body.width_mm
    whole = np.vstack([[-half, 0.0], top, [half, 0.0]])
    yield f'<path class="body" d="{frame.path(whole, closed=True)}"/>'
    core = design.body.core
    if core is not None:
        side, low, high = 0.5 * core.width_mm, core.bottom_mm, core.bottom_mm + core.height_mm
        box = np.array([[-side, low], [side, low], [side, high], [-side, high]])
        yield f'<path class="core" d="{frame.path(box, closed=True)}"/>'
    base = frame.at(np.array([[-half, 0.0], [half, 0.0]]))
    (x0, y), (x1, _) = base
    yield f'<path class="base" d="M{x0:.1f} {y:.1f} H{x1:.1f}"/>'


def _plates(
    design: Design, frame: _Frame, plates: list[PlateFrame], picked: int | None
) -> Iterable[str]:
    for plate in plates:
        yield f'<path class="plate" d="{frame.path(plate.outline(), closed=True)}"/>'
    half = 0.5 * design.gages.length_mm
    for plate in plates:
        lift = 0.5 * plate.thickness + _GAGE_LIFT / frame.scale
        s = np.linspace(-half, half, 5)
        lines = " ".join(
            frame.path(plate.from_local(s, side * lift)) for side in design.gages.sides
        )
        own = " picked" if plate.index == picked else ""
        name = f"gage of plate {plate.index}"
        yield (
            f'<g class="gage{own}" data-gage="{plate.index}"><title>{name}</title>'
            f'<path class="target" d="{lines}"/><path d="{lines}"/></g>'
        )


def _contact(design: Design, frame: _Frame, now: Numbers) -> Iterable[str]:
    """The object where it is, and the surface that sticks and slips, a little above it."""
    x, status = now.status_x, now.status
    edges = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
    for k, kind in enumerate(status):
        if kind != OPEN:
            ends = np.linspace(edges[k], edges[k + 1], 3)
            line = np.column_stack([ends, surface_height(design.body, ends)])
            name = "stick" if kind == STICK else "slip"
            yield f'<path class="{name}" d="{frame.path(line)}"/>'
    middle, y = _LEFT + frame.half * frame.scale, _TOP - 12.0
    reach = 0.42 * (WIDTH - _LEFT - _RIGHT)
    yield f'<path class="object" d="M{middle - reach:.1f} {y:.1f} H{middle + reach:.1f}"/>'
    normal, sideways = now.normal[-1], now.tangential[-1]
    words = f"{normal:.3g} N down, {sideways:.3g} N across"
    yield f'<text class="force" x="{middle:.1f}" y="{y - 10:.1f}">{words}</text>'


def _dimensions(
    design: Design, frame: _Frame, crest: float, plates: list[PlateFrame]
) -> Iterable[str]:
    half = 0.5 * design.body.width_mm
    ends = frame.at(np.array([[-half, 0.0], [half, 0.0]]))
    yield from _measured(ends[0], ends[1], (0.0, 24.0), f"{2 * half:g} mm")
    up = frame.at(np.array([[half, 0.0], [half, crest]]))
    yield from _measured(up[0], up[1], (20.0, 0.0), f"{crest:.3g}", upright=True)
    side = float(_outline(design)[0, 1])
    left = frame.at(np.array([[-half, 0.0], [-half, side]]))
    yield from _measured(left[0], left[1], (-20.0, 0.0), f"{side:.3g}", upright=True)
    if plates:
        last = plates[-1]
        top = float(surface_height(design.body, np.array([last.place]))[0])
        cover = frame.at(np.array([[last.place, last.y], [last.place, top]]))
        (x, y0), (_, y1) = cover
        yield f'<path class="dimension" d="M{x:.1f} {y0:.1f} V{y1:.1f}"/>'
        words = (
            f"{len(plates)} plates of {last.length:g} × {last.thickness:g} mm at "
            f"{last.angle_deg:g}°",
            f"pitch {design.plates.pitch_mm:g} mm, cover {top - last.y:.3g} mm",
        )
        middle = frame.at(np.array([[0.0, 0.45 * side]]))[0]
        for line, text in enumerate(words):
            place = f'x="{middle[0]:.1f}" y="{middle[1] + 18 * line:.1f}"'
            yield f'<text class="note" {place}>{text}</text>'


def _measured(
    start: Array, end: Array, aside: tuple[float, float], words: str, upright: bool = False
) -> Iterable[str]:
    """A dimension line beside two points, with its extension lines and its number."""
    a, b = start + np.array(aside), end + np.array(aside)
    for point, near in ((start, a), (end, b)):
        beyond = near + 4.0 * np.sign(near - point)
        yield (
            f'<path class="dimension" d="M{point[0]:.1f} {point[1]:.1f} '
            f'L{beyond[0]:.1f} {beyond[1]:.1f}"/>'
        )
    yield f'<path class="arrowed" d="M{a[0]:.1f} {a[1]:.1f} L{b[0]:.1f} {b[1]:.1f}"/>'
    x, y = 0.5 * (a + b)
    where = "start" if aside[0] > 0 else "end" if aside[0] < 0 else "middle"
    x, y = (x + np.sign(aside[0]) * 7.0, y + 4.0) if upright else (x, y + 16.0)
    yield f'<text class="size {where}" x="{x:.1f}" y="{y:.1f}">{words}</text>'
