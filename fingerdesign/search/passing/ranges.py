"""Ranges of the keys that a search for a passing finger changes, and its first trials.

First trials come from shipped fingers that pass; later ones are near to the best.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from fingerdesign.checks.load import load_design
from fingerdesign.design.schema import Design
from fingerdesign.design.stock import sheets_of
from fingerdesign.search.passing.freedom import Freedom
from fingerdesign.search.study.values import Choice, Parameter, Range, split_share, value_of

PASSING = ("feeler", "film_tees")  # Shipped fingers that pass: the first trials are like them.
_THINNEST, _THICKEST = 0.025, 0.125  # mm; thinner film cannot be placed, thicker one is too stiff.
# Ranges around what passed in a random search of forty fingers: flat, with short shallow plates.
# The third number is the step: nobody draws thousandths of a millimetre.
_RANGES: dict[str, tuple[float, float, float]] = {
    "plates.pitch_mm": (0.4, 1.2, 0.01),
    "plates.length_mm": (0.3, 0.9, 0.01),
    "plates.cover_mm": (0.25, 0.8, 0.01),
    "plates.angle_deg": (35.0, 55.0, 1.0),
}
_COUNTS = (7, 15)
_ARC = (0.6, 5.0)  # Radius over width: a half circle, and nearly flat.
_ROUND = ("arc", "dome", "revolved")  # Shapes with a radius.
_HEIGHT = (0.6, 1.25)  # Times the design's own; down to that of a similar finger that passes.
_DEPTH = 0.4  # Of the width. Deep fingers follow less well: film_tees 0.97, 22 mm deep 0.70.
# What becomes smaller with the body, and with which of its measures.
_FOLLOWING = (
    ("plates.span_mm", "body.depth_mm"),
    ("body.core.depth_mm", "body.depth_mm"),
    ("body.core.height_mm", "body.base_height_mm"),
)
_FLAT_DOME = 10.0  # Radius along z over depth: plates lie as in an arc, which can be swept.
_FREED = (0.7, 1.4)  # A key that the user frees varies between these times its own value.
GAGE_SHARE = 0.6  # Length of a gage over that of its plate; the ends of a plate carry no strain.
# Lengths of a finger that is similar to one that passes.
_LENGTHS = (
    *("body.base_height_mm", "body.depth_mm"),
    *("plates.pitch_mm", "plates.length_mm", "plates.cover_mm", "plates.thickness_mm"),
)


def parameters_of(design: Design, freedom: Freedom) -> Iterator[tuple[str, Parameter]]:
    """Each key with its range, wide enough for the design's own value."""
    body = {key: each for key, each in _of_body(design) if freedom.allows(key)}
    yield from body.items()
    for key, parameter in _of_plates(design):
        if freedom.allows(key):
            yield key, parameter
    if freedom.allows("gages.length_mm") and freedom.allows("plates.length_mm"):
        yield "gages.length_mm / plates.length_mm", (GAGE_SHARE,)
    for part, whole in _FOLLOWING:
        share = _value(design, f"{part} / {whole}")
        if share is not None and whole in body and freedom.allows(part):
            yield f"{part} / {whole}", (float(f"{share:.3g}"),)
    for key in freedom.free:
        value = value_of(design, key)
        if value:
            ends = sorted((_FREED[0] * value, _FREED[1] * value))
            low, high = (round(each) if isinstance(value, int) else each for each in ends)
            yield key, Range(low=low, high=high if high > low else low + 1)


def _of_body(design: Design) -> Iterator[tuple[str, Parameter]]:
    """The section's radius and height; the shape itself stays."""
    body = design.body
    if body.shape in _ROUND and body.arc_radius_mm is not None:
        yield "body.arc_radius_mm", _stepped(body.width_mm, _ARC, body.arc_radius_mm, 0.5)
    if body.shape in (*_ROUND, "block"):
        height = body.base_height_mm
        passing = [load_design(name).body for name in PASSING]
        similar = min(each.base_height_mm / each.width_mm for each in passing)
        low = min(_HEIGHT[0], similar * body.width_mm / height)
        yield "body.base_height_mm", _stepped(height, (low, _HEIGHT[1]), height, 0.1)
    shallow = math.floor((body.depth_mm - _DEPTH * body.width_mm) / 0.1)
    if body.shape in ("arc", "dome", "block") and shallow > 0:
        low = body.depth_mm - 0.1 * shallow
        yield "body.depth_mm", Range(low=round(low, 6), high=body.depth_mm, step=0.1)


def _of_plates(design: Design) -> Iterator[tuple[str, Parameter]]:
    """The row's measures, and the thicknesses that sheets of its material are sold in."""
    if design.plates.placement is None:
        for key, (low, high, step) in _RANGES.items():
            yield key, Range(low=low, high=high, step=step)
        yield "plates.count", Range(low=_COUNTS[0], high=_COUNTS[1])
    sheets = sheets_of(design.plates.material)
    sold = [each for each in sheets if _THINNEST <= each <= _THICKEST]
    if len(sold) > 1:
        yield "plates.thickness_mm", tuple(sold)


def _stepped(size: float, factors: tuple[float, float], own: float, step: float) -> Range:
    """From one factor times the size to the other, and at least to the design's own value."""
    low = max(step, math.floor(factors[0] * size / step) * step)
    high = math.ceil(max(factors[1] * size, own) / step) * step
    return Range(low=round(low, 6), high=round(high, 6), step=step)


def own_values(design: Design, parameters: Mapping[str, Parameter]) -> dict[str, Choice]:
    """The design's own values, brought into the ranges."""
    return {key: inside(each, _value(design, key)) for key, each in parameters.items()}


def _like(
    known: Design, design: Design, parameters: Mapping[str, Parameter], similar: tuple[str, ...]
) -> dict[str, Choice]:
    """A finger that passes, at the design's own size.

    similar: tables whose lengths are in proportion to the width. The fundamental case presses every
    finger equally far, so that the contact is in proportion too where the radius goes with the
    square. The worst rank correlations of five fingers in proportion, 10 to 16 mm wide, are 0.92 to
    0.97; as deep as their designs, 8 to 14 mm, 0.46 to 0.86. Plates as they are can be cast; on 15
    mm they have 0.95 and 0.88, on 10 mm at most 0.65. Else height and depth stay, which suits some
    fingers with a core: the random finger 5 has 0.75, and -0.22 with the similar height.
    """
    values = own_values(known, parameters)
    size = design.body.width_mm / known.body.width_mm
    powers = dict.fromkeys(_LENGTHS, 1) | {"body.arc_radius_mm": 2}
    for key in parameters.keys() & powers.keys():
        if key.startswith(similar):
            own = float(_value(known, key))
            values[key] = inside(parameters[key], size ** powers[key] * own)
    if not similar:
        for key in parameters.keys() & {"body.base_height_mm", "body.depth_mm"}:
            values[key] = _value(design, key)
        flat = flat_of(design, known)
        values |= {key: inside(parameters[key], flat[key]) for key in flat if key in parameters}
    if "plates.count" in parameters:
        pitch = float(values.get("plates.pitch_mm", design.plates.pitch_mm))
        room = int(0.9 * design.body.width_mm / pitch)
        values["plates.count"] = inside(parameters["plates.count"], min(known.plates.count, room))
    return values


def _value(design: Design, key: str) -> Any:
    part, whole = split_share(key)
    if not whole:
        return value_of(design, part)
    own = value_of(design, part)
    return None if own is None else own / value_of(design, whole)


def inside(parameter: Parameter, value: Any) -> Choice:
    """The value, or the nearest that the parameter can take."""
    if isinstance(parameter, Range):
        low, high = parameter.low, parameter.high
        found = min(max(low if value is None else value, low), high)
        if parameter.whole:
            return round(found)
        if parameter.step is not None:
            found = low + parameter.step * round((found - low) / parameter.step)
        return float(f"{found:.12g}")
    if value in parameter:
        return value  # type: ignore[no-any-return]
    numbers = [each for each in parameter if isinstance(each, int | float)]
    if numbers and isinstance(value, int | float):
        return min(numbers, key=lambda each: abs(each - value))
    return parameter[0]


def moved(
    parameter: Parameter, value: Choice, spread: float, chance: np.random.Generator
) -> Choice:
    """The value moved by ``spread`` of its range as standard deviation; a choice by one place."""
    if isinstance(parameter, Range):
        width = float(parameter.high) - float(parameter.low)
        least = 1.0 if parameter.whole else parameter.step or 0.0
        move = float(chance.normal()) * max(spread * width, least)
        return inside(parameter, float(value) + move)
    place = parameter.index(value) + int(chance.choice((-1, 1)))
    return parameter[min(max(place, 0), len(parameter) - 1)]


def starts_of(base: Design, parameters: Mapping[str, Parameter]) -> Iterator[dict[str, Choice]]:
    """First trials: the design's own values, then those of shipped fingers that pass."""
    yield own_values(base, parameters)
    for similar in (("body.",), ("body.", "plates."), ()):
        for name in PASSING:
            yield _like(load_design(name), base, parameters, similar)


def flat_of(design: Design, known: Design) -> dict[str, object]:
    """The known finger's radius at the design's own size; a dome as flat along z as it may be."""
    body, found = design.body, dict[str, object]()
    if body.shape in _ROUND and body.arc_radius_mm is not None:
        size = body.width_mm / known.body.width_mm
        found["body.arc_radius_mm"] = size * (known.body.arc_radius_mm or 0.0)
    if body.shape == "dome" and body.dome_radius_mm is not None:
        found["body.dome_radius_mm"] = max(_FLAT_DOME * body.depth_mm, body.dome_radius_mm)
    return found
