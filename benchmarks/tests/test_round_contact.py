"""Hertz and Cattaneo-Mindlin, line and point: numbers on a fine mesh, orders over several.

Expected orders, for quantities of a solution whose pressure ends like a square root: 1 for pressure
and traction in L2 (what piecewise linear functions can do at such an end), 2 for the peak pressure
(away from it, where the solution is smooth); the border lies within a fixed part of a facet: 1.
"""

import numpy as np
import pytest
from fingerdesign_bench.accuracy.verification_contact import (
    approach_errors,
    ball_on_plane,
    line_contact,
    peak_errors,
    point_contact,
    pressure_error,
    stick_errors,
    traction_error,
    width_errors,
)

SIZES = (0.1, 0.07, 0.05, 0.035, 0.025)


@pytest.fixture(scope="module")
def meshes():
    return [line_contact(size) for size in SIZES]


@pytest.fixture(scope="module")
def fine():
    return line_contact(0.0175)


def order(errors, sizes=SIZES):
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_hertz(fine):
    assert np.abs(peak_errors(fine)).max() < 5e-4
    assert np.abs(width_errors(fine)).max() < 1e-2
    assert max(pressure_error(fine, step) for step in fine.pressed) < 1e-2


def test_stick_width_and_traction_loading_and_reversed(fine):
    for steps, off in ((fine.sheared, 2e-2), (fine.returned, 4e-2)):
        assert np.abs(stick_errors(fine, steps)).max() < 1e-2
        assert max(traction_error(fine, step) for step in steps) < off


def test_the_shear_turned_round(fine):
    """Back at no force the traction is not gone: slipped rings pull against the middle."""
    step = fine.returned[0]
    model = fine.problem.model
    traction = step.increment.force[:, 0] / model.areas
    limit = fine.problem.friction_coefficient * step.measures.peak_pressure
    assert abs(step.measures.tangential_force) < 1e-6 * step.measures.normal_force
    assert traction.max() > 0.2 * limit
    assert traction.min() < -0.2 * limit


@pytest.mark.parametrize(
    ("least", "errors"),
    [
        (0.8, lambda m: [pressure_error(m, step) for step in m.pressed]),
        (1.6, peak_errors),
        (0.8, lambda m: [traction_error(m, step) for step in m.sheared]),
        (0.8, lambda m: [traction_error(m, step) for step in m.returned]),
        (0.7, width_errors),
        (0.7, lambda m: stick_errors(m, m.sheared)),
    ],
    ids=["pressure", "peak", "traction", "traction returned", "width", "stick"],
)
def test_orders(meshes, least, errors):
    assert order([rms(errors(mesh)) for mesh in meshes]) > least


def test_quadratic_displacements_alone_lock_a_little():
    """At nu = 0.4999 the mixed element's peak pressure is several times nearer to Hertz."""
    locked = line_contact(0.05, element="P2")
    assert rms(peak_errors(locked)) > 5.0 * rms(peak_errors(line_contact(0.05)))


POINT_SIZES = (0.2, 0.14, 0.1)


@pytest.fixture(scope="module")
def balls():
    return [point_contact(size) for size in POINT_SIZES]


def test_a_coarse_mesh():
    """Seven rings of facets to the contact's edge, eight steps in half a turn."""
    case = point_contact(0.14, growth=2.0, steps=6)
    assert np.abs(peak_errors(case)).max() < 1.5e-2
    assert np.abs(approach_errors(case)).max() < 1.5e-2
    assert np.abs(width_errors(case)).max() < 2e-2
    assert np.abs(stick_errors(case, case.sheared)).max() < 3e-2
    assert np.abs(stick_errors(case, case.returned)).max() < 3e-2


@pytest.mark.slow
def test_hertz_of_a_ball_and_its_orders(balls):
    fine = balls[-1]
    assert np.abs(approach_errors(fine)).max() < 5e-3
    assert np.abs(peak_errors(fine)).max() < 5e-3
    assert np.abs(width_errors(fine)).max() < 1e-2
    for least, errors in (
        (0.8, [rms([pressure_error(m, s) for s in m.pressed]) for m in balls]),
        (0.8, [rms([traction_error(m, s) for s in m.sheared]) for m in balls]),
        (1.6, [rms(peak_errors(mesh)) for mesh in balls]),
        (0.7, [rms(width_errors(mesh)) for mesh in balls]),
    ):
        assert order(errors, POINT_SIZES) > least


@pytest.mark.slow
def test_stick_radius_loading_and_reversed():
    fine = point_contact(0.07)
    assert np.abs(stick_errors(fine, fine.sheared)).max() < 1e-2
    assert np.abs(stick_errors(fine, fine.returned)).max() < 1e-2


@pytest.mark.slow
def test_an_elastic_ball_under_a_plane():
    """The curved body is the elastic one: gaps from the exact ball, facets that are curved."""
    case = ball_on_plane(0.14, steps=6)
    assert np.abs(peak_errors(case)).max() < 1.5e-2
    assert np.abs(width_errors(case)).max() < 2e-2
    assert np.abs(stick_errors(case, case.sheared)).max() < 3e-2
