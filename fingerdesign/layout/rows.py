"""Rows of plates: from pitch, cover and the surface that they follow to a frame for each plate."""

from functools import lru_cache

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.body import Body, BodyKind
from fingerdesign.design.plates import PlateLayout, Plates, plate_layout
from fingerdesign.design.schema import Design
from fingerdesign.design.step import StepFacts, step_facts
from fingerdesign.layout.bodies import surface_height
from fingerdesign.layout.frames import Hole, PlateFrame

_STEPS = 2000  # Chords of the surface line along which the pitch of a row is measured.


def plate_frames(design: Design) -> tuple[PlateFrame, ...]:
    """The plates' frames: row by row, each from - to + (or in the order of ``placement``)."""
    plates, body = design.plates, design.body
    if plates.placement is not None:
        return _placed_frames(plates, body)
    layouts = tuple(row.layout for row in plates.all_rows)
    content = None if body.step is None else step_facts(body.step).digest
    return _frames_of_rows(plates, body, layouts, body.kind, content)


@lru_cache(maxsize=64)
def _frames_of_rows(
    plates: Plates,
    body: Body,
    layouts: tuple[PlateLayout, ...],
    kind: BodyKind,
    content: str | None,
) -> tuple[PlateFrame, ...]:
    """The frames, cached: the checks of one design need them seven times, a third of their time.

    layouts, kind, content (of a STEP file): what the names in the tables mean now.
    """
    found: list[PlateFrame] = []
    for row in plates.all_rows:
        found += row_frames(body, row, len(found))
    return tuple(found)


def _placed_frames(plates: Plates, body: Body) -> tuple[PlateFrame, ...]:
    """The frames of ``placement``."""
    assert plates.placement is not None
    span = plates.span_mm if plates.span_mm is not None else body.depth_mm
    frames = []
    for index, (x, y, angle, *more) in enumerate(plates.placement):
        middle = _middle(plates, index, float(more[0]) if more else plates.span_offset_mm)
        place = float(x), float(y), float(angle)
        frames.append(_frame(plates, index, place, None, middle, span))
    return tuple(frames)


def _middle(row: Plates, number: int, offset: float) -> float:
    """The middle of a plate's span, mm; every other one of a row is staggered."""
    return offset + 0.5 * row.stagger_mm * (-1.0 if number % 2 else 1.0)


def _frame(
    row: Plates,
    index: int,
    place: tuple[float, float, float],
    bend: float | None,
    middle: float,
    span: float,
) -> PlateFrame:
    """A row's plate at a place and angle in its section plane."""
    box = row.length_mm, row.thickness_mm, middle - 0.5 * span, middle + 0.5 * span
    return PlateFrame(index, *place, *box, row.along, bend, holes_of(row, middle, span))


def row_frames(body: Body, row: Plates, first: int) -> list[PlateFrame]:
    """The frames of one row, from - to +, numbered from ``first``.

    Coordinates are NaN where a plate lies beyond the surface: the checks refuse it, with its key.
    """
    full = body.depth_mm if row.along == "x" else body.width_mm
    span = row.span_mm if row.span_mm is not None else full
    paces = row.offset_mm + (np.arange(row.count) - 0.5 * (row.count - 1)) * row.pitch_mm
    frames = []
    for k, pace in enumerate(paces):
        middle = _middle(row, k, row.span_offset_mm)
        x, y, turn, bend = row.layout.placed(body, row, float(pace), middle)
        angle = -row.angle_deg if row.alternate and k % 2 else row.angle_deg
        frames.append(_frame(row, first + k, (x, y, angle + turn), bend, middle, span))
    return frames


def holes_of(plates: Plates, middle: float, span: float) -> tuple[Hole, ...]:
    """A plate's perforation: holes on its middle line, ``hole_pitch_mm`` apart, none at the middle.
    As many as leave a hole's diameter of metal to the span's ends."""
    if plates.hole_diameter_mm is None:
        return ()
    diameter, pitch = plates.hole_diameter_mm, plates.hole_pitch_mm
    count = int(np.floor(max(0.5 * span - 1.5 * diameter, 0.0) / pitch + 0.5 + 1e-9))
    places = (np.arange(count) + 0.5) * pitch
    places = places[places <= 0.5 * span - 1.5 * diameter + 1e-9]
    both = np.concatenate([-places[::-1], places])
    return tuple(Hole(0.0, float(middle + w), 0.5 * diameter) for w in both)


def _height(body: Body, row: Plates, place: Array, middle: float) -> Array:
    with np.errstate(invalid="ignore"):
        if row.along == "x":
            # The section whose surface a row has its cover from: the crest's.
            return surface_height(body, place, 0.0 if body.step is None else middle)
        return surface_height(body, middle, place)


@plate_layout("level", place=1)
class Level(PlateLayout):
    """Cover along y, pitch along the row's axis."""

    level = True

    def placed(
        self, body: Body, row: Plates, pace: float, middle: float
    ) -> tuple[float, float, float, float | None]:
        height = float(_height(body, row, np.array([pace]), middle)[0])
        return pace, height - row.cover_mm, 0.0, None


@plate_layout("turned", place=2)
class Turned(PlateLayout):
    """Cover along the surface's normal, pitch along the surface."""

    def placed(
        self, body: Body, row: Plates, pace: float, middle: float
    ) -> tuple[float, float, float, float | None]:
        place, y, slope, curvature = _point_at(body, row, pace, middle)
        turn = np.arctan(slope)
        x = place + row.cover_mm * np.sin(turn)
        y = y - row.cover_mm * np.cos(turn)
        bend = None
        if self.bends and curvature > 1e-6:
            bend = float(1.0 / curvature - row.cover_mm)
        return float(x), float(y), float(np.degrees(turn)), bend


@plate_layout("bent", place=3)
class Bent(Turned):
    """Turned, and bent to the surface's curve."""

    bends = True


def _point_at(
    body: Body, row: Plates, pace: float, middle: float
) -> tuple[float, float, float, float]:
    """Find the point ``pace`` mm along the surface from the crest: place, height, slope, curvature.
    Exact on the crest's own arc or flat, by many chords beyond it and on a step body."""
    radius = body.kind.row_radius(body, row.along, middle)
    if radius is not None:
        if not np.isfinite(radius):
            return pace, float(_height(body, row, np.zeros(1), middle)[0]), 0.0, 0.0
        angle = pace / radius
        if abs(angle) >= 0.5 * np.pi:
            return (np.nan,) * 4
        place = radius * np.sin(angle)
        crest = float(_height(body, row, np.zeros(1), middle)[0])
        return place, crest - radius * (1.0 - np.cos(angle)), -float(np.tan(angle)), 1.0 / radius
    half = 0.5 * (body.width_mm if row.along == "x" else body.depth_mm)
    line, heights = _surface_line(body, row, middle, half)
    if len(line) < 3:
        return (np.nan,) * 4
    paced = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(line), np.diff(heights)))])
    paced -= np.interp(0.0, line, paced)
    if not paced[0] <= pace <= paced[-1]:
        return (np.nan,) * 4
    place = float(np.interp(pace, paced, line))
    reach = 0.02 * half
    window = np.abs(line - place) <= reach + 2.0 * half / _STEPS
    c2, c1, c0 = np.polyfit(line[window] - place, heights[window], 2)
    return place, float(c0), float(c1), float(max(-2.0 * c2 / (1.0 + c1**2) ** 1.5, 0.0))


def _surface_line(body: Body, row: Plates, middle: float, half: float) -> tuple[Array, Array]:
    """Places and heights (n,) of the surface line over a row's middle, where there is a surface."""
    if body.step is not None:
        return _step_line(step_facts(body.step), row.along, middle, half)
    line = np.linspace(-half, half, _STEPS + 1)
    heights = _height(body, row, line, middle)
    known = np.isfinite(heights)
    return line[known], heights[known]


@lru_cache(maxsize=128)
def _step_line(facts: StepFacts, along: str, middle: float, half: float) -> tuple[Array, Array]:
    """The surface line of a STEP body, cached: it takes 30 ms, and every plate needs it."""
    line = np.linspace(-half, half, _STEPS + 1)
    heights = facts.height(line, middle) if along == "x" else facts.height(middle, line)
    known = np.isfinite(heights)
    line, heights = line[known], heights[known]
    line.flags.writeable = heights.flags.writeable = False
    return line, heights


def mirrors_in_z(design: Design) -> bool:
    """True if the finger is its own mirror image in z = 0, plate by plate."""
    step = design.body.step
    return (step is None or step.mirrors_in_z) and all(
        frame.mirrors_in_z for frame in plate_frames(design)
    )
