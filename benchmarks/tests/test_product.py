"""The product's own road: tables that two other codes agree on, Hertz on its fingers."""

import doctest

import numpy as np
import pytest
from fingerdesign_bench.accuracy import analytic, reference
from fingerdesign_bench.accuracy.analytic import (
    cattaneo_mindlin_line,
    hertz_line,
    plane_strain_modulus,
)
from fingerdesign_bench.accuracy.verification_product import dome_errors
from fingerdesign_bench.check import two_codes

from fingerdesign import parse_design
from fingerdesign.contact.measures import limits
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.fem.model import build_model
from fingerdesign.layout.bodies import crest_height
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.shapes.objects import Plane


def test_limits_of_contact_and_stick_that_two_other_codes_agree_on():
    table = two_codes()
    text = reference.HOMOGENEOUS.format(depth=1.0, mesher="tetwild")
    solved = reference.solve_reference(parse_design(text), "plane-strain")
    for which, name in enumerate(("contact_limits_mm", "stick_limits_mm")):
        for number, known in table[name].items():
            found = limits(solved.problem, solved.steps[int(number) - 1].increment)[which]
            assert np.abs(found - np.array(known)).max() < 0.15


@pytest.mark.parametrize(
    "mesher", ["extrude", pytest.param("tetwild", marks=pytest.mark.slow)], ids=str
)
def test_forces_in_3d_that_two_other_codes_agree_on(mesher, own_cache):
    """Increments 4, 8, 12 and 16, the rows of the published comparison."""
    text = reference.HOMOGENEOUS.format(depth=10.0, mesher=mesher)
    solved = reference.solve_reference(parse_design(text), "3d")
    for row, step in zip(two_codes()["three_d_depth_10"][3::4], solved.steps[3::4], strict=True):
        assert step.measures.normal_force == pytest.approx(row["Fn"], rel=5e-3)
        if row["Ft"]:
            assert step.measures.tangential_force == pytest.approx(row["Ft"], rel=5e-3)


@pytest.mark.slow
def test_hertz_and_cattaneo_mindlin_on_a_dome(own_cache):
    errors = dome_errors()
    assert np.abs(errors.peak).max() < 1e-2
    assert np.abs(errors.width).max() < 4e-2  # 0.010 to 0.028 from mesh to mesh
    assert np.abs(errors.stick).max() < 4e-2


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


def pressure_off(solved, inside):
    """The worst error of the pressure over a share of the contact, of its peak."""
    problem, (pressed, *_) = solved
    exact, x = hertz(pressed.measures), problem.model.points[:, 0]
    got = pressed.increment.multiplier[:, 0] / problem.model.areas
    inner = np.abs(x) < inside * exact.half_width
    return np.abs(got - exact.pressure(x))[inner].max() / exact.peak_pressure


def test_hertz_width_and_pressure_and_stick_width_under_shear(fine):
    pressed, *sheared = (step.measures for step in fine[1])
    exact = hertz(pressed)
    assert pressed.peak_pressure == pytest.approx(exact.peak_pressure, rel=5e-3)
    assert pressed.contact_width == pytest.approx(2 * exact.half_width, rel=1e-2)
    assert pressure_off(fine, 0.9) < 1e-2
    for m in sheared:
        share = m.tangential_force / (FRICTION * m.normal_force)
        assert 0.1 < share < 0.95
        exact = cattaneo_mindlin_line(m.tangential_force, m.normal_force, FRICTION)
        assert m.stick_width / m.contact_width == pytest.approx(exact, rel=1.2e-2)


def test_the_error_falls_with_the_mesh():
    """Worst pressure error over the contact's inner part, three meshes: order one at least."""
    sizes = (0.2, 0.1, 0.05)
    errors = [pressure_off(solve(size), 0.8) for size in sizes]
    assert np.polyfit(np.log(sizes), np.log(errors), 1)[0] > 1.0


def test_closed_forms_as_their_examples_say():
    assert doctest.testmod(analytic).failed == 0
