"""Hertz and Cattaneo-Mindlin in line contact: numbers on a fine mesh, orders over several.

Expected orders, for quantities of a solution whose pressure ends like a square root: 1 for pressure
and traction in L2 (what piecewise linear functions can do at such an end), 2 for the peak pressure
(away from it, where the solution is smooth); the border lies within a fixed part of a facet: 1.
"""

import numpy as np
import pytest
from fingerdesign_bench.accuracy.verification_contact import (
    line_contact,
    peak_errors,
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


def order(errors):
    return np.polyfit(np.log(SIZES), np.log(errors), 1)[0]


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_hertz(fine):
    assert np.abs(peak_errors(fine)).max() < 5e-4
    assert np.abs(width_errors(fine)).max() < 1e-2
    assert max(pressure_error(fine, step) for step in fine.pressed) < 1e-2


def test_stick_width_loading_and_reversed(fine):
    assert np.abs(stick_errors(fine, fine.sheared)).max() < 1e-2
    assert np.abs(stick_errors(fine, fine.returned)).max() < 1e-2


def test_traction_profile_loading_and_reversed(fine):
    assert max(traction_error(fine, step) for step in fine.sheared) < 2e-2
    assert max(traction_error(fine, step) for step in fine.returned) < 4e-2


def test_the_shear_turned_round(fine):
    """Back at no force the traction is not gone: slipped rings pull against the middle."""
    step = fine.returned[0]
    model = fine.problem.model
    traction = step.increment.force[:, 0] / model.areas
    limit = fine.problem.friction_coefficient * step.measures.peak_pressure
    assert abs(step.measures.tangential_force) < 1e-6 * step.measures.normal_force
    assert traction.max() > 0.2 * limit
    assert traction.min() < -0.2 * limit


def test_order_of_the_pressure(meshes):
    assert order([rms([pressure_error(m, s) for s in m.pressed]) for m in meshes]) > 0.8
    assert order([rms(peak_errors(mesh)) for mesh in meshes]) > 1.6


def test_order_of_the_traction(meshes):
    assert order([rms([traction_error(m, s) for s in m.sheared]) for m in meshes]) > 0.8
    assert order([rms([traction_error(m, s) for s in m.returned]) for m in meshes]) > 0.8


def test_order_of_the_borders(meshes):
    assert order([rms(width_errors(mesh)) for mesh in meshes]) > 0.7
    assert order([rms(stick_errors(mesh, mesh.sheared)) for mesh in meshes]) > 0.7


def test_quadratic_displacements_alone_lock_a_little():
    """At nu = 0.4999 the mixed element's peak pressure is several times nearer to Hertz."""
    locked = line_contact(0.05, element="P2")
    assert rms(peak_errors(locked)) > 5.0 * rms(peak_errors(line_contact(0.05)))
