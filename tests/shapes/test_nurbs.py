"""NURBS surfaces: sums of SciPy's bases, a cylinder and a closed tube against closed forms."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from fingerdesign.shapes.nurbs import Nurbs

HALF = np.sqrt(0.5)


def quarter_cylinder():
    """x^2 + y^2 = 100, x, y >= 0, 0 <= z <= 20; outside: away from the axis."""
    flat = np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) * 10.0
    poles = np.array([[[*xy, 20.0 * z] for z in (0, 1)] for xy in flat])
    weights = np.array([[1.0, 1.0], [HALF, HALF], [1.0, 1.0]])
    knots = np.array([0.0, 0, 0, 1, 1, 1]), np.array([0.0, 0, 1, 1])
    return Nurbs((2, 1), *knots, poles, weights, (0.0, 1.0, 0.0, 1.0))


def closed_tube():
    """The whole circle of radius 10 in four quarters, z from 0 to 5."""
    ring = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    poles = np.array([[[10.0 * x, 10.0 * y, 5.0 * z] for z in (0, 1)] for x, y in ring])
    weights = np.tile(np.array([HALF if k % 2 else 1.0 for k in range(9)])[:, None], (1, 2))
    knots = np.array([0.0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]), np.array([0.0, 0, 1, 1])
    return Nurbs((2, 1), *knots, poles, weights, (0.0, 4.0, 0.0, 1.0), (True, False))


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_points_and_derivatives_are_the_rational_sums_of_the_bases(degree):
    rng = np.random.default_rng(0)
    knots = np.array([0.0] * (degree + 1) + [0.3, 0.5, 0.8] + [1.0] * (degree + 1))
    count = len(knots) - degree - 1
    poles, weights = rng.normal(size=(count, count, 3)), rng.uniform(0.5, 2.0, (count, count))
    surface = Nurbs((degree, degree), knots, knots, poles, weights, (0.0, 1.0, 0.0, 1.0))
    u, v = rng.uniform(0.0, 1.0, (2, 40))

    def basis(t, order):
        each = [BSpline(knots, np.eye(count)[k], degree)(t, nu=order) for k in range(count)]
        return np.column_stack(each)

    def sums(by_u, by_v, values):
        return np.einsum("ni,nj,ij...->n...", basis(u, by_u), basis(v, by_v), values)

    point, su, sv, suu, *_ = surface.derivatives(u, v)
    weight = sums(0, 0, weights)[:, None]
    weighted = weights[..., None] * poles
    np.testing.assert_allclose(point, sums(0, 0, weighted) / weight, atol=1e-12)
    np.testing.assert_allclose(surface.at(u, v), point, atol=1e-12)
    for found, order in ((su, (1, 0)), (sv, (0, 1))):
        wanted = (sums(*order, weighted) - sums(*order, weights)[:, None] * point) / weight
        np.testing.assert_allclose(found, wanted, atol=1e-8)
    wanted = sums(2, 0, weighted) - 2.0 * sums(1, 0, weights)[:, None] * su
    wanted = (wanted - sums(2, 0, weights)[:, None] * point) / weight if degree > 1 else suu
    np.testing.assert_allclose(suu, wanted, atol=1e-7)


def test_derivatives_of_a_rational_surface_by_differences():
    surface, step = quarter_cylinder(), 1e-5
    u, v = np.random.default_rng(1).uniform(0.1, 0.9, (2, 30))
    _, su, _, suu, suv, _ = surface.derivatives(u, v)
    ahead, back = surface.derivatives(u + step, v), surface.derivatives(u - step, v)
    np.testing.assert_allclose((ahead[0] - back[0]) / (2 * step), su, atol=1e-7)
    np.testing.assert_allclose((ahead[1] - back[1]) / (2 * step), suu, atol=1e-6)
    np.testing.assert_allclose((ahead[2] - back[2]) / (2 * step), suv, atol=1e-6)


def test_distance_normal_and_height_of_a_cylinder():
    surface, rng = quarter_cylinder(), np.random.default_rng(2)
    angle, radius, z = (
        rng.uniform(0, np.pi / 2, 500),
        rng.uniform(6, 14, 500),
        rng.uniform(0, 20, 500),
    )
    radial = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(500)])
    points = radius[:, None] * radial + z[:, None] * [0.0, 0.0, 1.0]
    np.testing.assert_allclose(surface.distance(points), radius - 10.0, atol=1e-12)
    np.testing.assert_allclose(surface.normal(points), radial, atol=1e-12)
    x = rng.uniform(0, 9.99, 200)
    found = surface.heights(x, z[:200])
    np.testing.assert_allclose(np.nanmax(found, axis=0), np.sqrt(100 - x**2), atol=1e-11)


def test_a_closed_surface_is_followed_across_its_seam():
    tube, angle = closed_tube(), np.array([-1e-3, -1e-9, 0.0, 1e-9, 1e-3, 2.0, 4.0])
    points = np.column_stack([9.0 * np.cos(angle), 9.0 * np.sin(angle), np.full(7, 2.0)])
    np.testing.assert_allclose(np.abs(tube.distance(points)), 1.0, atol=1e-12)


def test_beyond_its_border_a_surface_goes_on():
    surface = quarter_cylinder()
    angle = np.array([-0.01, np.pi / 2 + 0.01])
    points = np.column_stack([11.0 * np.cos(angle), 11.0 * np.sin(angle), np.full(2, 20.1)])
    np.testing.assert_allclose(surface.distance(points), 1.0, atol=1e-9)
