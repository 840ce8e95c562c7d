"""Rows of plates: from pitch, cover and the surface that they follow to a frame for each plate."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.layout import Hole, PlateFrame, surface_height

if TYPE_CHECKING:
    from fingerdesign.design.body_table import Body
    from fingerdesign.design.plate_table import Plates
    from fingerdesign.design.step_facts import StepFacts


_STEPS = 2000  # of the surface line along which a row is paced out


def row_frames(body: Body, row: Plates, first: int) -> list[PlateFrame]:
    """The frames of one row, from - to +, numbered from ``first``.

    Coordinates are NaN where a plate lies beyond the surface: the checks refuse it, with its key.
    """
    full = body.depth_mm if row.along == "x" else body.width_mm
    span = row.span_mm if row.span_mm is not None else full
    paces = row.offset_mm + (np.arange(row.count) - 0.5 * (row.count - 1)) * row.pitch_mm
    frames = []
    for k, pace in enumerate(paces):
        middle = row.span_offset_mm + 0.5 * row.stagger_mm * (-1.0 if k % 2 else 1.0)
        place, y, turn, bend = _placed(body, row, float(pace), middle)
        frames.append(
            PlateFrame(
                first + k,
                place,
                y,
                row.angle_deg + turn,
                row.length_mm,
                row.thickness_mm,
                middle - 0.5 * span,
                middle + 0.5 * span,
                row.along,
                bend,
                holes_of(row, middle, span),
            )
        )
    return frames


def holes_of(plates: Plates, middle: float, span: float) -> tuple[Hole, ...]:
    """A plate's perforation: holes on its middle line, ``hole_pitch_mm`` apart, none at the middle.

    As many as leave a hole's diameter of metal to the span's ends.
    """
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
            return surface_height(body, place, _section_at(body, middle))
        return surface_height(body, middle, place)


def _section_at(body: Body, middle: float) -> float:
    """z of the section whose surface a row along x keeps its cover from: the crest's."""
    return 0.0 if body.shape != "step" else middle


def _placed(
    body: Body, row: Plates, pace: float, middle: float
) -> tuple[float, float, float, float | None]:
    """Centre in the section plane, the turn of its angle (degrees), and its bend radius."""
    if row.follow == "level":
        return (
            pace,
            float(_height(body, row, np.array([pace]), middle)[0]) - row.cover_mm,
            0.0,
            None,
        )
    place, y, slope, curvature = _paced_out(body, row, pace, middle)
    turn = np.arctan(slope)
    x = place + row.cover_mm * np.sin(turn)
    y = y - row.cover_mm * np.cos(turn)
    bend = None
    if row.follow == "bent" and curvature > 1e-6:
        bend = float(1.0 / curvature - row.cover_mm)
    return float(x), float(y), float(np.degrees(turn)), bend


def _paced_out(
    body: Body, row: Plates, pace: float, middle: float
) -> tuple[float, float, float, float]:
    """Where the surface line is ``pace`` mm long from the crest: place, height, slope, curvature.

    Exact on the crest's own arc or flat, by many chords beyond it and on a step body.
    """
    radius = _arc_radius(body, row, middle)
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
        from fingerdesign.design.step_facts import step_facts

        return _step_line(step_facts(body.step), row.along, middle, half)
    line = np.linspace(-half, half, _STEPS + 1)
    heights = _height(body, row, line, middle)
    known = np.isfinite(heights)
    return line[known], heights[known]


@lru_cache(maxsize=128)
def _step_line(facts: StepFacts, along: str, middle: float, half: float) -> tuple[Array, Array]:
    """That of a STEP body, which takes 30 ms; every plate of a row asks for it."""
    line = np.linspace(-half, half, _STEPS + 1)
    heights = facts.height(line, middle) if along == "x" else facts.height(middle, line)
    known = np.isfinite(heights)
    line, heights = line[known], heights[known]
    line.flags.writeable = heights.flags.writeable = False
    return line, heights


def _arc_radius(body: Body, row: Plates, middle: float) -> float | None:
    """Radius of the surface line under a row where it is one arc; infinite: flat; None: neither."""
    if body.shape == "block":
        return np.inf
    if body.shape == "step":
        return None
    if row.along == "x":
        return float(body.arc_radius_mm)  # rows along x are drawn in the crest's section
    if body.shape == "arc":
        return np.inf
    if body.shape == "dome" and body.dome_radius_mm is not None:
        crest = float(surface_height(body, middle)) - float(surface_height(body, 0.0))
        return float(body.dome_radius_mm) + crest
    if middle == 0.0:
        return float(body.arc_radius_mm)
    height = float(surface_height(body, middle)) - float(surface_height(body, 0.0))
    return float(body.arc_radius_mm) + height
