"""Closed forms of planes, cones, spheres and tori against their definitions."""

import numpy as np
import pytest

from fingerdesign.shapes.quadrics import Cone, Plane, Sphere, Torus, fall, roots

AXIS = np.array([2.0, -1.0, 2.0]) / 3.0
CENTRE = np.array([0.3, 1.2, -0.7])
SHAPES = {
    "plane": Plane(AXIS, 0.4),
    "sphere": Sphere(CENTRE, 2.0),
    "cylinder": Cone(CENTRE, AXIS, 1.5),
    "cone": Cone(CENTRE, AXIS, 1.5, 0.2),
    "torus": Torus(CENTRE, AXIS, 5.0, 1.0),
}


@pytest.mark.parametrize("kind", SHAPES)
def test_the_normal_is_the_gradient_of_the_distance(kind):
    shape = SHAPES[kind]
    points = np.random.default_rng(1).uniform(-4, 4, (200, 3))
    normal = shape.normal(points)
    for axis in range(3):
        shift = 1e-6 * np.eye(3)[axis]
        slope = (shape.distance(points + shift) - shape.distance(points - shift)) / 2e-6
        np.testing.assert_allclose(normal[:, axis], slope, atol=2e-7)


@pytest.mark.parametrize("kind", SHAPES)
def test_heights_lie_on_the_shape_and_none_is_missed(kind):
    shape = SHAPES[kind]
    points = np.random.default_rng(2).uniform(-3, 3, (300, 3))
    feet = points - shape.distance(points)[:, None] * shape.normal(points)
    found = shape.heights(feet[:, 0], feet[:, 2])
    for row in found:
        known = np.isfinite(row)
        on = np.column_stack([feet[:, 0], row, feet[:, 2]])[known]
        np.testing.assert_allclose(shape.distance(on), 0.0, atol=1e-10)
    if kind != "torus":  # which tells two of up to four
        nearest = np.nanmin(np.abs(found - feet[:, 1]), axis=0)
        np.testing.assert_allclose(nearest, 0.0, atol=1e-7)


def test_a_torus_from_above_and_beside_it():
    ring = Torus(np.zeros(3), np.array([0.0, 1.0, 0.0]), 5.0, 1.0)
    x = np.array([5.0, 5.6, 4.4, 0.0, 6.5])
    top = ring.heights(x, np.zeros(5))[0]
    np.testing.assert_allclose(top[:3], [1.0, 0.8, 0.8], atol=1e-12)
    assert np.isnan(top[3:]).all()


def test_the_inner_part_of_a_spindle():
    """A crest rounder along z (12) than along x (20): the circle's centre lies beyond the axis."""
    lemon = Torus(np.zeros(3), np.array([1.0, 0.0, 0.0]), -8.0, 20.0)
    on = np.array([[0.0, 12.0, 0.0], [3.0, np.sqrt(400.0 - 9.0) - 8.0, 0.0]])
    np.testing.assert_allclose(lemon.distance(on), 0.0, atol=1e-12)
    np.testing.assert_allclose(lemon.distance(np.array([[0.0, 12.001, 0.0]])), 1e-3, atol=1e-12)
    np.testing.assert_allclose(lemon.normal(on)[0], [0.0, 1.0, 0.0], atol=1e-15)


def test_roots_touch_miss_and_do_not_cancel():
    found = roots(np.ones(3), np.array([0.0, 0.0, -1e8]), np.array([0.0, 1.0, 1.0]), 1.0)
    assert found[:, 0].tolist() == [0.0, 0.0]
    assert np.isnan(found[:, 1]).all()
    np.testing.assert_allclose(sorted(found[:, 2]), [5e-9, 2e8], rtol=1e-12)


def test_a_line_beside_the_shape_has_no_height():
    assert np.isnan(fall(Sphere(np.zeros(3), 1.0), np.array([[1.1, 3.0, 0.0]]))).all()
