"""Hertz and Cattaneo-Mindlin for a sphere, on round blocks 1000 contact radii deep."""

import numpy as np
import pytest
from fingerdesign_bench.accuracy.verification_contact import (
    approach_errors,
    ball_on_plane,
    peak_errors,
    point_contact,
    pressure_error,
    stick_errors,
    traction_error,
    width_errors,
)

SIZES = (0.2, 0.14, 0.1)


@pytest.fixture(scope="module")
def meshes():
    return [point_contact(size) for size in SIZES]


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def order(errors):
    return np.polyfit(np.log(SIZES), np.log(errors), 1)[0]


def test_a_coarse_mesh():
    """Seven rings of facets to the contact's edge, eight steps in half a turn."""
    case = point_contact(0.14, growth=2.0, steps=6)
    assert np.abs(peak_errors(case)).max() < 1.5e-2
    assert np.abs(approach_errors(case)).max() < 1.5e-2
    assert np.abs(width_errors(case)).max() < 2e-2
    assert np.abs(stick_errors(case, case.sheared)).max() < 3e-2
    assert np.abs(stick_errors(case, case.returned)).max() < 3e-2


@pytest.mark.slow
def test_hertz(meshes):
    fine = meshes[-1]
    assert np.abs(approach_errors(fine)).max() < 5e-3
    assert np.abs(peak_errors(fine)).max() < 5e-3
    assert np.abs(width_errors(fine)).max() < 1e-2


@pytest.mark.slow
def test_orders(meshes):
    assert order([rms([pressure_error(m, s) for s in m.pressed]) for m in meshes]) > 0.8
    assert order([rms([traction_error(m, s) for s in m.sheared]) for m in meshes]) > 0.8
    assert order([rms(peak_errors(mesh)) for mesh in meshes]) > 1.6
    assert order([rms(width_errors(mesh)) for mesh in meshes]) > 0.7


@pytest.mark.slow
def test_stick_radius_loading_and_reversed():
    fine = point_contact(0.07)
    assert np.abs(stick_errors(fine, fine.sheared)).max() < 1e-2
    assert np.abs(stick_errors(fine, fine.returned)).max() < 1e-2


def test_an_elastic_ball_under_a_plane():
    """The curved body is the elastic one: gaps from the exact ball, facets that are curved."""
    case = ball_on_plane(0.14, steps=6)
    assert np.abs(peak_errors(case)).max() < 1.5e-2
    assert np.abs(width_errors(case)).max() < 2e-2
    assert np.abs(stick_errors(case, case.sheared)).max() < 3e-2
