"""Two elastic bodies, bodies that contact alone holds, and the product's own section."""

import json
from dataclasses import replace

import numpy as np
import pytest
from fingerdesign_bench.accuracy import analytic
from fingerdesign_bench.accuracy.facing import facing_compliance
from fingerdesign_bench.known import bodies

from fingerdesign import parse_design
from fingerdesign.contact.force_control import Forces, NoEquilibrium
from fingerdesign.contact.measures import limits
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.errors import SolverError
from fingerdesign.fem.model import build_model
from fingerdesign.fem.reduction import body_model
from fingerdesign.layout.bodies import crest_height
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.records.base import DATA
from fingerdesign.shapes.objects import Plane
from tests.support.boxes import block

SHEARS = [0.004 * k for k in range(1, 8)]


def test_either_body_may_be_the_finger():
    """A soft and a stiff cylinder exchanged: the same contact, on two different meshes."""
    one, other = (bodies.equal_cylinders(0.04, *pair) for pair in ((200.0, 50.0), (50.0, 200.0)))
    for a, b in zip(one.steps, other.steps, strict=True):
        assert a.measures.peak_pressure == pytest.approx(b.measures.peak_pressure, rel=5e-3)
        assert a.measures.stick_area == pytest.approx(b.measures.stick_area, rel=2e-2)


def test_the_support_of_a_body_that_contact_holds_carries_nothing():
    solved = bodies.pressed_plate()
    force = solved.steps[-1].increment.force
    reaction = solved.body.reaction @ force.reshape(-1) - solved.loads.reshape(-1, 2).sum(axis=0)
    assert abs(reaction[1]) < 1e-6 * 2000.0


def test_no_force_holds_the_wedge_beyond_its_limit():
    problem = bodies.pushed_block().problem
    limit = analytic.sliding_wedge(0.1, 0.3)
    normal = 0.05
    start = [Forces(normal), Forces(normal, 0.9 * limit * normal)]
    *_, held = follow(problem, [*start, Forces(normal, 0.999 * limit * normal)])
    assert held.measures.tangential_force == pytest.approx(0.999 * limit * normal)
    with pytest.raises(NoEquilibrium):
        list(follow(problem, [*start, Forces(normal, 1.001 * limit * normal)]))


def raised(body, height):
    mesh = body.mesh
    points = mesh.points + height * np.eye(mesh.dimension)[1]
    return replace(body, mesh=replace(mesh, points=points))


@pytest.mark.parametrize("shape", [((6, 4), (3.0, 2.0)), ((4, 3, 2), (3.0, 2.0, 1.0))])
def test_a_body_facing_its_mirror_image(shape):
    """On the same contact mesh the object's compliance is that of the body itself, mirrored."""
    finger, upper = body_model(block(*shape, 2.0)), raised(block(*shape, 0.0), 2.3)
    got, own = facing_compliance(upper, finger), body_model(upper)
    order = [
        int(np.flatnonzero(np.abs(own.points[:, ::2] - p[::2]).max(axis=1) < 1e-9)[0])
        for p in finger.points
    ]
    dim = finger.dimension
    pick = (np.array(order)[:, None] * dim + np.arange(dim)).ravel()
    expected = own.compliance[np.ix_(pick, pick)]
    assert np.abs(got - expected).max() < 1e-10 * np.abs(expected).max()
    narrow = raised(block((4, 4), (2.0, 2.0), 0.0), 2.0)
    with pytest.raises(SolverError, match="face no contact facet"):
        facing_compliance(narrow, body_model(block((6, 4), (3.0, 2.0), 2.0)))


def test_limits_of_contact_and_stick_that_two_other_codes_agree_on():
    design = parse_design(bodies.HOMOGENEOUS.format(depth=1.0))
    problem, steps = bodies.two_codes_path(design, "plane-strain")
    tables = json.loads((DATA / "two_codes.json").read_text("utf-8"))
    for which, name in enumerate(("contact_limits_mm", "stick_limits_mm")):
        for number, known in tables[name].items():
            found = limits(problem, steps[int(number) - 1].increment)[which]
            assert np.abs(found - np.array(known)).max() < 0.15


def test_hertz_and_cattaneo_mindlin_on_the_products_own_section():
    """Contact half-width about 1.1 mm on a body 60 mm deep and 120 mm wide."""
    design = parse_design(bodies.RAMP)
    model = build_model(design, mesh_section(design, 1.7), 1.7).reduced
    problem = contact_problem(model, Plane(crest_height(design.body)), 0.5)
    path = [Motion(0.03 * k / 4, 0.0) for k in range(1, 5)]
    path += [Motion(0.03, shear) for shear in SHEARS]
    pressed, *sheared = list(follow(problem, path))[3:]
    measures, modulus = pressed.measures, analytic.plane_strain_modulus(4.96, 0.4999)
    exact, x = analytic.hertz_line(measures.normal_force, 100.0, modulus), model.points[:, 0]
    assert measures.peak_pressure == pytest.approx(exact.peak_pressure, rel=5e-3)
    assert measures.contact_width == pytest.approx(2 * exact.half_width, rel=1e-2)
    off = np.abs(pressed.increment.multiplier[:, 0] / model.areas - exact.pressure(x))
    assert off[np.abs(x) < 0.9 * exact.half_width].max() < 1e-2 * exact.peak_pressure
    for m in (step.measures for step in sheared):
        share = analytic.cattaneo_mindlin_line(m.tangential_force, m.normal_force, 0.5)
        assert m.stick_width / m.contact_width == pytest.approx(share, rel=1.2e-2)
