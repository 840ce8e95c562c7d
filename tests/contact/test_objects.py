"""Objects: distances and normals in closed form, first touch, and what they do to a finger."""

import numpy as np
import pytest

from fingerdesign.contact.problem import Motion, local_frames
from fingerdesign.design.scene import SceneObject
from fingerdesign.shapes.objects import Cylinder, Plane, Sphere, touching

RNG = np.random.default_rng(3)
POINTS = RNG.uniform(-1.0, 1.0, (40, 3))
SLOPE = (np.sin(0.2), -np.cos(0.2), 0.0)
AXIS = (np.cos(0.1) * np.cos(0.4), np.sin(0.1), -np.cos(0.1) * np.sin(0.4))
OBJECTS = [
    Plane(2.0),
    Plane(2.0, SLOPE),
    Cylinder(4.0, 1.5),
    Cylinder(4.0, 1.5, AXIS),
    Sphere(4.0, 1.5),
]


@pytest.mark.parametrize("rigid", OBJECTS, ids=str)
def test_the_normal_is_the_gradient_of_the_distance(rigid):
    step = 1e-6
    numeric = np.column_stack(
        [
            (rigid.distance(POINTS + step * e) - rigid.distance(POINTS - step * e)) / (2 * step)
            for e in np.eye(3)
        ]
    )
    normal = rigid.normal(POINTS)
    # The object's outward normal, toward the finger: the distance grows along it.
    assert np.abs(numeric - normal).max() < 1e-8
    assert np.abs(np.linalg.norm(normal, axis=1) - 1.0).max() < 1e-12


@pytest.mark.parametrize("rigid", OBJECTS, ids=str)
def test_the_underside_is_where_the_distance_is_zero(rigid):
    x, z = POINTS[:, 0], POINTS[:, 2]
    y = rigid.underside(x, z)
    assert np.isfinite(y).all()
    assert np.abs(rigid.distance(np.column_stack([x, y, z]))).max() < 1e-12


def test_nothing_is_under_a_point_outside_the_object():
    assert np.isinf(Sphere(4.0, 1.5).underside(np.array([2.0]), np.array([0.0]))).all()
    assert np.isinf(Cylinder(4.0, 1.5).underside(np.array([2.0]), np.array([9.0]))).all()


def arc(x, z):
    return np.sqrt(400.0 - x**2) - 20.0


def test_a_tilted_plane_first_touches_an_arc_where_their_normals_agree():
    placed, point = touching(Plane(0.0, SLOPE), arc, 10.0, 5.0)
    assert point[0] == pytest.approx(-20.0 * np.sin(0.2), abs=1e-4)
    x = np.linspace(-10.0, 10.0, 4001)
    surface = np.column_stack([x, arc(x, 0.0)])
    assert -1e-12 < placed.distance(surface).min() < 2e-7


@pytest.mark.parametrize("rigid", [Cylinder(0.0, 3.0), Sphere(0.0, 3.0), Plane(0.0)], ids=str)
def test_round_objects_first_touch_the_crest(rigid):
    placed, point = touching(rigid, arc, 10.0, 5.0)
    assert np.abs(point).max() < 1e-9
    assert placed.distance(np.zeros((1, 3)))[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("keys", [{}, {"shape": "cylinder", "radius_mm": 3.0, "axis": "x"}])
@pytest.mark.parametrize("tilt", [-12.0, 7.0])
def test_a_tilted_object_faces_the_finger_at_its_tilt(keys, tilt):
    """Anticlockwise seen from +z: the lower face falls toward -x, for a plane as for a cylinder."""
    made = SceneObject(**keys, tilt_deg=tilt).made()
    x = np.array([-2.0, 0.0, 3.0])
    rise = np.diff(made.underside(x, np.zeros(3))) / np.diff(x)
    assert rise == pytest.approx(np.tan(np.radians(tilt)))


def test_a_plane_sloping_along_a_straight_finger_touches_its_end():
    _, point = touching(Plane(0.0, (0.0, -np.cos(0.1), np.sin(0.1))), arc, 10.0, 5.0)
    assert abs(point[2]) == pytest.approx(5.0)


def test_frames_are_right_and_orthonormal():
    for rigid in OBJECTS:
        frames = local_frames(rigid.normal(POINTS))
        products = np.einsum("mab,mcb->mac", frames, frames)
        assert np.abs(products - np.eye(3)).max() < 1e-12
        assert (frames[:, 2, 2] > 0).all()


def test_a_motion_on_its_way():
    way = Motion(0.1, 0.0).toward(Motion(0.2, 0.4, 0.2, 1.0), 0.5)
    assert way == Motion(pytest.approx(0.15), 0.2, 0.1, 0.5)
