"""The contact surface in closed form: projection, normal, distance."""

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.layout.surface import ContactSurface

BODIES = {
    "arc": "",
    "dome": 'body.shape = "dome"\nbody.dome_radius_mm = 12.0\nplates.count = 0',
    "dome flatter in z than in x": (
        'body.shape = "dome"\nbody.dome_radius_mm = 60.0\nplates.count = 0'
    ),
}


@pytest.fixture(params=BODIES)
def near(request):
    """A surface and points near to it."""
    body = parse_design(f'design.name = "t"\n{BODIES[request.param]}').body
    surface, rng = ContactSurface.of(body), np.random.default_rng(5)
    x, z = rng.uniform(-8, 8, 200), rng.uniform(-4.5, 4.5, 200)
    y = surface.height(x, z) + rng.uniform(-1.5, 1.5, 200)
    return surface, np.column_stack([x, y, z])


def test_projection_is_the_nearest_point_of_the_surface(near):
    surface, points = near
    feet = surface.project(points)
    np.testing.assert_allclose(surface.height(feet[:, 0], feet[:, 2]), feet[:, 1], atol=1e-12)
    np.testing.assert_allclose(
        np.linalg.norm(points - feet, axis=1), np.abs(surface.distance(points)), atol=1e-12
    )
    rng = np.random.default_rng(6)
    for _ in range(50):  # no nearby surface point is nearer
        x = feet[:, 0] + rng.normal(0, 0.05, len(feet))
        z = feet[:, 2] + rng.normal(0, 0.05, len(feet))
        other = np.column_stack([x, surface.height(x, z), z])
        away = np.linalg.norm(points - other, axis=1)
        assert np.all(away >= np.abs(surface.distance(points)) - 1e-12)


def test_normal_is_the_gradient_of_the_distance_and_points_outward(near):
    surface, points = near
    normal = surface.normal(points)
    step = 1e-5
    for axis in range(3):
        shift = np.eye(3)[axis] * step
        slope = (surface.distance(points + shift) - surface.distance(points - shift)) / (2 * step)
        np.testing.assert_allclose(normal[:, axis], slope, atol=1e-8)
    assert np.all(surface.distance(points + 0.1 * normal) > surface.distance(points))
    flat = points * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(surface.distance(flat[:, :2]), surface.distance(flat))
    np.testing.assert_allclose(surface.project(flat[:, :2]), surface.project(flat)[:, :2])


def test_what_lies_below_the_surface_is_enclosed_though_outside_its_circle():
    body = parse_design('design.name="t"\nbody.arc_radius_mm=10.0\nplates.count=0').body
    surface = ContactSurface.of(body)
    points = np.array([[9.5, 1.0, 0.0], [0.0, 19.9, 0.0], [0.0, 20.1, 0.0], [8.0, 16.1, 0.0]])
    assert surface.encloses(points).tolist() == [True, True, False, False]
    assert surface.distance(points)[0] > 0.0
    assert surface.lowest == pytest.approx(10.0)


def test_curvatures_at_the_crest(near):
    surface, _ = near
    step = 1e-3
    drop_x = surface.crest - float(surface.height(step, 0.0))
    drop_z = surface.crest - float(surface.height(0.0, step))
    np.testing.assert_allclose(
        [2 * drop_x / step**2, 2 * drop_z / step**2], surface.curvatures, rtol=1e-5
    )
