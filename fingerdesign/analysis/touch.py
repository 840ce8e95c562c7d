"""From a scene's words to the contact layer's: the object at first touch, the path's targets."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.problem import Motion
from fingerdesign.layout.surface import surface_of
from fingerdesign.shapes.objects import Cylinder, Plane, RigidObject, Sphere, touching

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene, SceneObject, ScenePath
    from fingerdesign.design.schema import Body


def object_at_touch(rigid: SceneObject, body: Body) -> RigidObject:
    """The scene's object where it first touches the undeformed finger, let down along y."""
    made = _made(rigid)
    if isinstance(made, Plane) and made.direction == (0.0, -1.0, 0.0) and body.step is None:
        return made.at_height(surface_of(body).crest)
    return _let_down(made, body)[0]


def touch_point(rigid: SceneObject, body: Body) -> tuple[float, float]:
    """Where (x, z) mm the object first touches the undeformed finger."""
    point = _let_down(_made(rigid), body)[1]
    return float(point[0]), float(point[2])


def _let_down(made: RigidObject, body: Body) -> tuple[RigidObject, Array]:
    """The object where it first touches, and the point (3,) where it does."""
    surface = surface_of(body)

    def height(x: Array, z: Array) -> Array:
        found = np.asarray(surface.height(x, z))
        return np.where(np.isfinite(found), found, -np.inf)  # no surface there: nothing to touch

    return touching(made, height, 0.5 * body.width_mm, 0.5 * body.depth_mm)


def targets(path: ScenePath) -> list[Motion | Forces]:
    """One target a row: motions in mm and degrees, or forces in N."""
    if path.control == "force":
        return [Forces(row[0], row[1]) for row in path.rows]
    return [Motion(*row) for row in path.rows]


def steps_sideways(scene: Scene) -> bool:
    """Whether anything in the scene leaves the plane of the section z = 0."""
    return not (scene.object.plane_in_z and scene.path.mirrors_in_z)


def _made(rigid: SceneObject) -> RigidObject:
    tilt, turn = math.radians(rigid.tilt_deg), math.radians(rigid.turn_deg)
    if rigid.shape == "plane":
        return Plane(0.0, _turned(np.array([math.sin(tilt), -math.cos(tilt), 0.0]), turn))
    radius = float(rigid.radius_mm or 0.0)
    if rigid.shape == "sphere":
        return Sphere(0.0, radius)
    along_x = np.array([math.cos(tilt), math.sin(tilt), 0.0])
    axis = along_x if rigid.axis == "x" else np.array([0.0, 0.0, 1.0])
    return Cylinder(0.0, radius, _turned(axis, turn))


def _turned(
    vector: np.ndarray[tuple[int], np.dtype[np.float64]], turn: float
) -> tuple[float, float, float]:
    """``vector`` turned about +y."""
    x, y, z = (float(value) for value in vector)
    if turn == 0.0:
        return x, y, z
    return x * math.cos(turn) + z * math.sin(turn), y, -x * math.sin(turn) + z * math.cos(turn)
