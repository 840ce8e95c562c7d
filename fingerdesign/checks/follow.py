"""Defaults that follow finger and object: how far, how fast and how hard a lift moves.

With w = m g / 2 the weight that a finger carries and mu the least friction of the grips, a hand
that keeps twice the least force presses with F = 2 w / mu. ``approach_for`` forecasts how deep
that is; the forces are parts of w. Moves are parts of that depth in plane strain, where a domed
finger is stiffer than it is: they are small enough for both. At 500 g on a rubber of 5 MPa all are
near the defaults of ``[grip]``. Of a range of masses the heaviest, with the most that pulls at it
until the end, sets the travel; the lightest sets steps and forces, which else would exceed all that
it may be held with.
"""

import math
from collections.abc import Callable
from typing import Any

from fingerdesign.design.grip import Grip, weight_per_finger
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.zone import approach_for, contact_reach

_MARGIN = 2.0  # The paper's rule holds at most this times the least force.
_TRAVEL = 1.5  # A hanging object drags the contact; relaxed rubber is pressed deeper.
MOST_TRAVEL = 0.25  # Of the finger's height; beyond it small strains are no model.
# A mean distance from the middle over its root mean square is 0.87 of a line, 0.94 of a square.
_ROUNDS, _MEAN = 4, 0.9
_FUNDAMENTAL = 4.0 / 3.0, 0.5  # The fundamental case presses with 4/3 w at this friction.


def lift_approach(design: Design, friction: float, margin: float, mass_g: float) -> float:
    """Forecast the approach, mm, at which an object is held with ``margin``."""
    force = lift_force(design, friction, margin, mass_g)
    return approach_for(design, SceneObject(), force)


def lift_force(design: Design, friction: float, margin: float, mass_g: float) -> float:
    """Forecast F_n, N, that holds an object with ``margin``, also one off the middle.

    A contact whose points are r from its middle, in the mean, carries the moment mu F_n r; at a
    distance c it carries 1 / sqrt(1 + (c / r)^2) of the force that it carries in the middle. r
    grows with the force, so it is found in a few rounds. On film_tees, 3 to 20 mm off, the force is
    10 % less to 20 % more than the model's.
    """
    centred = force = margin * weight_per_finger(mass_g) / friction
    if off := design.grip.off_centre_mm:
        for _ in range(_ROUNDS):
            approach = approach_for(design, SceneObject(), force)
            force = centred * math.hypot(1.0, off / _contact_radius(design, approach))
    return force


def _contact_radius(design: Design, approach: float) -> float:
    """Mean distance from the middle, mm: of an even line with Hertz's pressure across it, or of
    Hertz's ellipse."""
    body = design.body
    across, along = contact_reach(design, SceneObject(), approach)
    across = min(across, 0.5 * body.width_mm)
    square = (across**2 + min(along, 0.5 * body.depth_mm) ** 2) / 5.0
    if body.straight:
        square = body.depth_mm**2 / 12.0 + across**2 / 4.0
    return _MEAN * math.sqrt(square)


def _section(design: Design) -> Design:
    """Return the finger as plane strain draws it: straight along z."""
    if design.body.straight or design.body.shape == "step":
        return design
    changed = {"shape": "arc", "dome_radius_mm": None}
    return design.model_copy(update={"body": design.body.model_copy(update=changed)})


def grip_values(design: Design) -> dict[str, Any]:
    """Return the values of keys that follow the finger; once given, other materials do not move
    them."""
    values = {f"grip.{key}": getattr(design.grip, key) for key in Grip.FOLLOWING}
    return {key: value for key, value in values.items() if value is not None}


def followed(design: Design) -> Design:
    """Return the design with every key of ``Grip.FOLLOWING`` that was not given set to what
    follows; the body must be sound. ``model_fields_set`` stays: with_values finds them again."""
    grip = design.grip
    missing = set(Grip.FOLLOWING) - grip.model_fields_set
    if grip.defaults == "fixed" or not missing:
        return design
    light, heavy, pulled = grip.lightest_g, grip.heaviest_g, grip.pulled_g(grip.heaviest_g)
    weight = weight_per_finger(light)
    values: dict[str, Any] = {key: getattr(grip, key) for key in grip.model_fields_set}

    def follow(key: str, value: Callable[[], float], most: float) -> None:
        if key in missing:
            values[key] = float(f"{min(value(), most):.3g}")

    def travel(drawn: Design, mass_g: float) -> float:
        needed = lift_approach(drawn, min(grip.friction_coefficients), _MARGIN, mass_g)
        most = min(MOST_TRAVEL * float(crest_height(design.body)), design.body.base_height_mm)
        return min(_TRAVEL * needed, most)

    share, friction = _FUNDAMENTAL
    follow("max_approach_mm", lambda: travel(design, pulled), 50.0)
    most = values["max_approach_mm"]
    drawn = most
    if light < pulled or not design.body.straight:
        drawn = min(most, travel(_section(design), light))
    follow("preload_mm", lambda: 0.05 * drawn, 50.0)
    follow("approach_step_mm", lambda: drawn / 150.0, 5.0)
    follow("shear_step_mm", lambda: 7.5 * values["approach_step_mm"], 5.0)
    follow("curve_per_N", lambda: 0.245 / weight, 1e3)
    follow("force_floor_N", lambda: 0.04 * weight, 1e3)
    follow("hold_force_N", lambda: 0.2 * weight, 1e3)
    follow("fundamental_approach_mm", lambda: lift_approach(design, friction, share, heavy), most)
    if "max_steps" in missing:
        moves = most / values["approach_step_mm"]
        values["max_steps"] = int(min(max(4.0 * moves / 3.0, 200.0), 1e5))
    resolved = grip.model_copy(update={key: values[key] for key in missing})
    resolved.model_fields_set.difference_update(missing)
    return design.model_copy(update={"grip": resolved})
