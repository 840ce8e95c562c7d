"""The closed forms of a finger and its scene as functions of one parameter.

A key of the design (``materials.silicone.youngs_modulus_MPa``, ``body.width_mm``,
``plates.cover_mm``, ``gages.z_mm``), one of the scene's object (``object.radius_mm``), or a plate's
own place: ``placement[3].x_mm``, ``.y_mm``, ``.angle_deg``; ``placement.x_mm``: of all alike.
Rates of closed forms are five-point differences, good to some 1e-11: nothing is solved for.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

from fingerdesign.design.base import Table
from fingerdesign.design.faults import shown
from fingerdesign.design.keys import leaves
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames

PLACES = ("x_mm", "y_mm", "angle_deg")
_TABLES = ("body", "plates", "gages", "materials")
_OBJECT = ("friction_coefficient", "radius_mm", "tilt_deg")
# Steps of five-point differences: errors of (step / length)^4 and of rounding / step balance.
_STEP, _LEAST = 1e-3, 1.0
_WEIGHTS = {-2: 1.0 / 12.0, -1: -8.0 / 12.0, 1: 8.0 / 12.0, 2: -1.0 / 12.0}


class Variant(NamedTuple):
    """A finger at one value of the parameter."""

    design: Design
    scene: Scene
    frames: tuple[PlateFrame, ...]


@dataclass(frozen=True)
class Parameter:
    """A number that a design or its scene gives: ``at`` (a change of it) makes the Variant.

    kind: "placement", "object", or the design's table; step: of differences, in its unit.
    """

    name: str
    kind: str
    value: float
    step: float
    at: Callable[[float], Variant]

    def rate(self, of: Callable[[float], Any]) -> Any:
        """The derivative at 0 of a function of the change, by five points."""
        return sum(weight * value for weight, value in self._points(of))

    def rates(self, of: Callable[[float], list[Any]]) -> list[Any]:
        """The derivatives of several functions that are worked out together."""
        points = self._points(of)
        return [
            sum(weight * values[k] for weight, values in points) for k in range(len(points[0][1]))
        ]

    def _points(self, of: Callable[[float], Any]) -> list[tuple[float, Any]]:
        return [(weight / self.step, of(k * self.step)) for k, weight in _WEIGHTS.items()]


def differentiable(design: Design) -> Design:
    """The design with what derivatives are known for: solid plates and quadratic elements."""
    plates = design.plates.model_copy(update={"model": "solid"})
    mesh = design.mesh.model_copy(update={"element": "auto"})
    return design.model_copy(update={"plates": plates, "mesh": mesh})


def parameters_of(
    design: Design,
    scene: Scene,
    names: tuple[str, ...],
    frames: tuple[PlateFrame, ...] | None = None,
) -> list[Parameter]:
    """Find the parameters by name. DesignError with a fault for each that is none.

    frames: the plates that are in the model, of which places are wanted; None: all.
    """
    shown = plate_frames(design) if frames is None else frames
    found, faults = [], list[Fault]()
    for name in names:
        try:
            found.append(_parameter(design, scene, shown, name))
        except DesignError as error:
            faults += error.faults
    if faults:
        raise DesignError(faults)
    return found


def _parameter(
    design: Design, scene: Scene, frames: tuple[PlateFrame, ...], name: str
) -> Parameter:
    place = re.fullmatch(r"placement(?:\[(\d{1,6})\])?\.(\w+)", name)
    if place is not None and place[2] in PLACES:
        here = Variant(design, scene, frames)
        return _placement(here, name, place[1], PLACES.index(place[2]))
    table, _, key = name.partition(".")
    if table == "object" and key in _OBJECT:
        value = getattr(scene.object, key)
        if value is not None:
            return _of_object(design, scene, name, key, float(value))
    if table in _TABLES:
        values = dict(leaves(design.model_dump(mode="json")))
        if isinstance(values.get(name), float):
            return _of_design(design, scene, name, float(values[name]))
    bound = "a number of body, plates, gages, materials or object, or placement[k].x_mm"
    raise DesignError([Fault("parameters", shown(name), bound, "write the key as in the file")])


def _placement(here: Variant, name: str, one: str | None, axis: int) -> Parameter:
    frames = here.frames
    if not frames or (one is not None and int(one) >= len(frames)):
        bound = f"one of {len(frames)} plates, numbered from 0"
        raise DesignError([Fault("parameters", shown(name), bound, "name a plate that is there")])

    @cache
    def at(change: float) -> Variant:
        own = [k == int(one) if one is not None else True for k in range(len(frames))]
        names = ("place", "y", "angle_deg")
        moved = []
        for frame, mine in zip(frames, own, strict=True):
            there: dict[str, Any] = {names[axis]: getattr(frame, names[axis]) + change * mine}
            moved.append(replace(frame, **there))
        return here._replace(frames=tuple(moved))

    first = frames[int(one or 0)]
    value = (first.place, first.y, first.angle_deg)[axis]
    return Parameter(name, "placement", value, 0.05 if axis == 2 else _STEP, at)


def _of_object(design: Design, scene: Scene, name: str, key: str, value: float) -> Parameter:
    frames = plate_frames(design)

    @cache
    def at(change: float) -> Variant:
        rigid: Table = scene.object.model_copy(update={key: value + change})
        return Variant(design, scene.model_copy(update={"object": rigid}), frames)

    step = 0.05 if key == "tilt_deg" else _STEP * max(abs(value), _LEAST)
    return Parameter(name, "object", value, step, at)


def _of_design(design: Design, scene: Scene, name: str, value: float) -> Parameter:
    full = name == "body.depth_mm" and design.plates.span_mm == design.body.depth_mm

    @cache
    def at(change: float) -> Variant:
        varied = _with(design, name, value + change)
        if full:  # plates that reach from end to end do so in a deeper finger
            varied = _with(varied, "plates.span_mm", value + change)
        return Variant(varied, scene, plate_frames(varied))

    step = 0.05 if name.endswith("_deg") else _STEP * max(abs(value), 0.05)
    return Parameter(name, name.partition(".")[0], value, step, at)


def _with(table: Any, name: str, value: float) -> Any:
    """A copy of a table (or of tables by name) with a dotted key set: what the checks of a file
    refuse by a hair is no fault of a difference."""
    first, _, rest = name.partition(".")
    own = table[first] if isinstance(table, dict) else getattr(table, first)
    new = _with(own, rest, value) if rest else value
    return (
        {**table, first: new} if isinstance(table, dict) else table.model_copy(update={first: new})
    )
