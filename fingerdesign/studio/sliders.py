"""The sliders: which keys of a design can be moved, how far, and what the object does."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from fingerdesign.checks.scene import MOST_MOTION
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height

_STEPS = 60  # of a slider, before rounding
_REACH = 0.05  # of the finger's height: approach and shear at least
_FRICTION = (0.05, 1.2)


@dataclass(frozen=True)
class Slider:
    """One number that can be moved. ``key`` is dotted for a design's key, plain for the object's.

    value: where it starts.
    """

    key: str
    label: str
    unit: str
    low: float
    high: float
    step: float
    value: float

    @property
    def of_design(self) -> bool:
        """True for a key of the finger, which is then condensed again."""
        return "." in self.key

    def data(self) -> dict[str, Any]:
        """For the page."""
        return asdict(self)


@dataclass(frozen=True)
class Press:
    """Motion of the object: pressed by ``approach`` (mm), then drawn by ``shear`` (mm)."""

    approach: float
    shear: float
    friction: float

    @classmethod
    def of(cls, values: dict[str, Any]) -> Press:
        """The sliders' part that is the object's."""
        return cls(*(float(values[key]) for key in ("approach", "shear", "friction")))


def sliders_of(design: Design) -> tuple[Slider, ...]:
    """The object's three, and the design's keys that it has and that lengths can be moved of."""
    crest = float(crest_height(design.body))
    most = min(max(design.grip.max_approach_mm, _REACH * crest), MOST_MOTION * crest)
    step = _round_step(most / _STEPS)
    most = round(step * round(most / step), 9)
    first, half = (round(step * round(most / part / step), 9) for part in (4, 8))
    found = [
        Slider("approach", "approach", "mm", 0.0, most, step, first),
        Slider("shear", "shear", "mm", 0.0, most, step, half),
        Slider("friction", "friction", "", *_FRICTION, 0.01, 0.5),
    ]
    return (*found, *_of_body(design), *_of_plates(design))


def _of_body(design: Design) -> list[Slider]:
    body, found = design.body, list[Slider]()
    if body.step is None:
        names = [("width_mm", "width"), ("base_height_mm", "base height")]
        if body.shape == "arc":
            names.append(("arc_radius_mm", "arc radius"))
        for name, label in names:
            value = getattr(body, name)
            if value:
                found.append(_around(f"body.{name}", label, "mm", float(value)))
    own = design.materials.get(body.material)
    if own is not None and "." not in body.material:  # a dotted key would lead elsewhere
        key = f"materials.{body.material}.youngs_modulus_MPa"
        found.append(_around(key, "modulus of the body", "MPa", own.youngs_modulus_MPa))
    return found


def _of_plates(design: Design) -> list[Slider]:
    plates = design.plates
    if not plates.count or plates.placement is not None or plates.model == "none":
        return []
    names = (("length_mm", "plate length"), ("pitch_mm", "plate pitch"), ("cover_mm", "cover"))
    found = [
        _around(f"plates.{name}", label, "mm", float(getattr(plates, name)))
        for name, label in names
    ]
    angle = Slider("plates.angle_deg", "plate angle", "°", -90.0, 90.0, 1.0, plates.angle_deg)
    return [angle, *found]


def _around(key: str, label: str, unit: str, value: float) -> Slider:
    """From half of a value to one and a half times it; the value itself lies on a step."""
    step = _round_step(value / _STEPS)
    down = math.floor(0.5 * value / step)
    digits = 9
    low, high = round(value - down * step, digits), round(value + down * step, digits)
    return Slider(key, label, unit, low, high, step, value)


def _round_step(rough: float) -> float:
    """1, 2 or 5 times a power of ten, at most ``rough``.

    >>> _round_step(0.0068), _round_step(0.37), _round_step(2.0)
    (0.005, 0.2, 2.0)
    """
    power = math.floor(math.log10(rough) + 1e-9)
    share = rough / 10.0**power
    first = max(each for each in (1, 2, 5) if each <= share + 1e-9)
    return round(first * 10.0**power, max(0, -power))
