"""Hertz and Cattaneo-Mindlin in line contact, where they are exact: a deep body, nu near 0.5."""

import doctest

import numpy as np
import pytest
from fingerdesign_bench.accuracy import analytic
from fingerdesign_bench.accuracy.analytic import (
    cattaneo_mindlin_line,
    hertz_line,
    plane_strain_modulus,
)

from fingerdesign import parse_design
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.fem.model import build_model
from fingerdesign.layout.frames import crest_height
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.shapes.objects import Plane

NU, FRICTION, RADIUS, APPROACH = 0.4999, 0.5, 100.0, 0.03
SHEARS = [0.004 * k for k in range(1, 8)]


def solve(size):
    """Contact half-width about 1.1 mm on a body 60 mm deep and 120 mm wide."""
    design = parse_design(
        f"""
        design.name = "deep"
        body.width_mm = 120.0
        body.base_height_mm = 60.0
        body.arc_radius_mm = {RADIUS}
        body.depth_mm = 1.0
        plates.count = 0
        materials.silicone.poissons_ratio = {NU}
        mesh.section.contact_size_mm = {size}
        mesh.section.far_size_mm = 6.0
        """
    )
    model = build_model(design, mesh_section(design, 1.7), 1.7).reduced
    problem = contact_problem(model, Plane(crest_height(design.body)), FRICTION)
    path = [Motion(APPROACH * k / 4, 0.0) for k in range(1, 5)]
    path += [Motion(APPROACH, shear) for shear in SHEARS]
    return problem, list(follow(problem, path))[3:]


@pytest.fixture(scope="module")
def fine():
    return solve(0.025)


def hertz(measures):
    return hertz_line(measures.normal_force, RADIUS, plane_strain_modulus(4.96, NU))


def test_hertz_width_and_pressure(fine):
    pressed = fine[1][0].measures
    exact = hertz(pressed)
    assert pressed.peak_pressure == pytest.approx(exact.peak_pressure, rel=5e-3)
    assert pressed.contact_width == pytest.approx(2 * exact.half_width, rel=1e-2)


def test_hertz_pressure_along_the_contact(fine):
    problem, (pressed, *_) = fine
    exact = hertz(pressed.measures)
    got = pressed.increment.multiplier[:, 0] / problem.model.areas
    wanted = exact.pressure(problem.model.points[:, 0])
    inner = np.abs(problem.model.points[:, 0]) < 0.9 * exact.half_width
    assert np.abs(got - wanted)[inner].max() < 1e-2 * exact.peak_pressure


def test_stick_width_under_shear(fine):
    for step in fine[1][1:]:
        m = step.measures
        share = m.tangential_force / (FRICTION * m.normal_force)
        assert 0.1 < share < 0.95
        exact = cattaneo_mindlin_line(m.tangential_force, m.normal_force, FRICTION)
        assert m.stick_width / m.contact_width == pytest.approx(exact, rel=1.2e-2)


def test_the_error_falls_with_the_mesh():
    """Worst pressure error over the contact's inner part, three meshes: order one at least."""
    sizes, errors = (0.2, 0.1, 0.05), []
    for size in sizes:
        problem, (pressed, *_) = solve(size)
        exact = hertz(pressed.measures)
        got = pressed.increment.multiplier[:, 0] / problem.model.areas
        x = problem.model.points[:, 0]
        inner = np.abs(x) < 0.8 * exact.half_width
        errors.append(np.abs(got - exact.pressure(x))[inner].max() / exact.peak_pressure)
    assert np.polyfit(np.log(sizes), np.log(errors), 1)[0] > 1.0


def test_closed_forms_as_their_examples_say():
    assert doctest.testmod(analytic).failed == 0
