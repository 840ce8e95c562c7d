"""Tractions recovered along the middle of the contact."""

import numpy as np
import pytest

from fingerdesign.contact.recovery import middle_weights


@pytest.fixture(params=[True, False], ids=["half", "whole"])
def patch(request):
    """Scattered nodes (m, 3), their areas, those near z = 0 by rising x, and whether it is half."""
    rng = np.random.default_rng(3)
    x, z = np.meshgrid(np.linspace(-3.0, 3.0, 31), np.linspace(0.0, 3.0, 16))
    x, z = x.ravel(), z.ravel()
    inside = z > 0
    x = x + rng.uniform(-0.08, 0.08, x.size)
    z = z + inside * rng.uniform(-0.08, 0.08, x.size)
    if not request.param:
        x, z = np.r_[x, x[inside]], np.r_[z, -z[inside]]
    points = np.column_stack([x, 0.0 * x, z])
    middle = np.flatnonzero(points[:, 2] == 0.0)
    line = middle[np.argsort(points[middle, 0])]
    return points, rng.uniform(0.02, 0.06, len(points)), line, request.param


def test_a_parabola_along_x_comes_out_exactly(patch):
    points, areas, line, half = patch
    places = np.linspace(-2.9, 2.9, 57)
    given = 1.0 - 0.3 * points[:, 0] + 0.2 * points[:, 0] ** 2
    weights = middle_weights(points, areas, line, places, half)
    np.testing.assert_allclose(weights @ given, 1.0 - 0.3 * places + 0.2 * places**2, atol=1e-10)


def test_scatter_is_averaged_out(patch):
    points, areas, line, half = patch
    given = 1.0 + 0.1 * np.random.default_rng(5).standard_normal(len(points))
    recovered = middle_weights(points, areas, line, np.linspace(-2.0, 2.0, 41), half) @ given
    assert np.std(recovered) < 0.5 * np.std(given[line])


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_nodes_still_have_a_mean(count):
    points = np.column_stack([np.arange(count), np.zeros(count), np.zeros(count)]).astype(float)
    weights = middle_weights(points, np.ones(count), np.arange(count), np.array([0.0]), half=True)
    assert weights @ np.full(count, 2.0) == pytest.approx(2.0)
