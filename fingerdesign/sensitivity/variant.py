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
from operator import mul
from typing import Any, NamedTuple

from fingerdesign.design.faults import shown
from fingerdesign.design.keys import leaves
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames

PLACES = ("x_mm", "y_mm", "angle_deg")
PLACE = re.compile(rf"placement(?:\[(\d{{1,6}})\])?\.({'|'.join(PLACES)})")  # of a plate, or of all
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
        return self.rates(lambda change: [of(change)])[0]

    def rates(self, of: Callable[[float], list[Any]]) -> list[Any]:
        """The derivatives of several functions that are worked out together."""
        points = zip(*(of(k * self.step) for k in _WEIGHTS), strict=True)
        weights = [weight / self.step for weight in _WEIGHTS.values()]
        return [sum(map(mul, weights, values)) for values in points]


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
    here = Variant(design, scene, plate_frames(design) if frames is None else frames)
    found, faults = [], list[Fault]()
    for name in names:
        try:
            found.append(_parameter(here, name))
        except DesignError as error:
            faults += error.faults
    if faults:
        raise DesignError(faults)
    return found


def _parameter(here: Variant, name: str) -> Parameter:
    if (place := PLACE.fullmatch(name)) is not None:
        return _placement(here, name, place[1], PLACES.index(place[2]))
    table, _, key = name.partition(".")
    value = None
    if table == "object" and key in _OBJECT:
        value = getattr(here.scene.object, key)
    elif table in _TABLES:
        value = dict(leaves(here.design.model_dump(mode="json"))).get(name)
    if isinstance(value, float):
        return _of_key(here, name, value)
    bound = "a number of body, plates, gages, materials or object, or placement[k].x_mm"
    raise DesignError([Fault("parameters", shown(name), bound, "write the key as in the file")])


def _placement(here: Variant, name: str, one: str | None, axis: int) -> Parameter:
    frames = here.frames
    if not frames or (one is not None and int(one) >= len(frames)):
        bound = f"one of {len(frames)} plates, numbered from 0"
        raise DesignError([Fault("parameters", shown(name), bound, "name a plate that is there")])
    key = ("place", "y", "angle_deg")[axis]

    @cache
    def at(change: float) -> Variant:
        moved = list(frames)
        for k in range(len(frames)) if one is None else [int(one)]:
            there: dict[str, Any] = {key: getattr(frames[k], key) + change}
            moved[k] = replace(frames[k], **there)
        return here._replace(frames=tuple(moved))

    value = getattr(frames[int(one or 0)], key)
    return Parameter(name, "placement", value, 0.05 if axis == 2 else _STEP, at)


def _of_key(here: Variant, name: str, value: float) -> Parameter:
    table, design = name.partition(".")[0], here.design
    full = name == "body.depth_mm" and design.plates.span_mm == design.body.depth_mm

    @cache
    def at(change: float) -> Variant:
        if table == "object":
            return here._replace(scene=_with(here.scene, name, value + change))
        varied = _with(design, name, value + change)
        if full:  # plates that reach from end to end do so in a deeper finger
            varied = _with(varied, "plates.span_mm", value + change)
        return here._replace(design=varied, frames=plate_frames(varied))

    least = _LEAST if table == "object" else 0.05
    step = 0.05 if name.endswith("_deg") else _STEP * max(abs(value), least)
    return Parameter(name, table, value, step, at)


def _with(table: Any, name: str, value: float) -> Any:
    """A copy of a table (or of tables by name) with a dotted key set: what the checks of a file
    refuse by a hair is no fault of a difference."""
    first, _, rest = name.partition(".")
    own = table[first] if isinstance(table, dict) else getattr(table, first)
    new = _with(own, rest, value) if rest else value
    return (
        {**table, first: new} if isinstance(table, dict) else table.model_copy(update={first: new})
    )
