"""Two elastic bodies, and bodies that contact alone holds, against theory and published results."""

from dataclasses import replace

import numpy as np
import pytest
from fingerdesign_bench.accuracy import analytic
from fingerdesign_bench.accuracy import verification_bodies as bodies
from fingerdesign_bench.accuracy.facing import facing_compliance

from fingerdesign.contact.force_control import Forces, NoEquilibrium
from fingerdesign.contact.path import follow
from fingerdesign.errors import SolverError
from fingerdesign.fem.reduction import body_model
from tests.support.boxes import block


def test_either_body_may_be_the_finger():
    """A soft and a stiff cylinder exchanged: the same contact, on two different meshes."""
    one, other = (bodies.equal_cylinders(0.04, *pair) for pair in ((200.0, 50.0), (50.0, 200.0)))
    for a, b in zip(one.steps, other.steps, strict=True):
        assert a.measures.peak_pressure == pytest.approx(b.measures.peak_pressure, rel=5e-3)
        assert a.measures.stick_area == pytest.approx(b.measures.stick_area, rel=2e-2)


def test_nafems_roller():
    solved = bodies.nafems_roller(0.15)
    measures = solved.steps[-1].measures
    assert 0.5 * measures.contact_width == pytest.approx(6.215, rel=1e-2)
    assert measures.peak_pressure == pytest.approx(3585.0, rel=5e-3)


def test_nafems_roller_with_friction():
    """The block's settlement and the stress of another code: 2.2 and 3.4 % from ours.

    Its stress is extrapolated from the volume, and whether it moves the mesh along is not stated;
    ours rests on Hertz's 3585 MPa without friction, which friction between different bodies raises.
    """
    solved = bodies.nafems_roller(0.15, 0.1)
    assert solved.displacement([0.0, 0.0])[1] == pytest.approx(-1.30264, rel=3e-2)
    assert solved.steps[-1].measures.peak_pressure == pytest.approx(3542.7, rel=4e-2)


def test_pressed_plate():
    """SSNV128: the sliding foot of a plate."""
    solved = bodies.pressed_plate()
    known = {0.0: 2.86e-2, 1.25: 2.72e-2, 5.0: 2.28e-2, 7.5: 1.98e-2, 11.25: 1.50e-2}
    for x, moved in known.items():
        assert solved.displacement([x, 0.0])[0] == pytest.approx(moved, rel=3e-2)
    # The support of a body held by contact carries nothing.
    force = solved.steps[-1].increment.force
    reaction = solved.body.reaction @ force.reshape(-1) - solved.loads.reshape(-1, 2).sum(axis=0)
    assert abs(reaction[1]) < 1e-6 * 2000.0


def test_bonded_layer_nears_the_thin_limit():
    errors = []
    for half_width in (10.0, 20.0, 40.0):
        solved = bodies.bonded_layer(half_width)
        force, peak, _ = analytic.bonded_incompressible_layer(half_width, 1e6, 1.0, 1.0)
        measures = solved.steps[-1].measures
        errors.append([measures.normal_force / force - 1.0, measures.peak_pressure / peak - 1.0])
    assert np.abs(errors[-1]).max() < 1e-2
    assert np.polyfit(np.log([10, 20, 40]), np.log(np.max(np.abs(errors), axis=1)), 1)[0] < -1.0


def test_no_force_holds_the_wedge_beyond_its_limit():
    problem = bodies.wedge().problem
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
    with pytest.raises(SolverError, match="face no contact facet"):
        facing_compliance(
            raised(block((4, 4), (2.0, 2.0), 0.0), 2.0), body_model(block((6, 4), (3.0, 2.0), 2.0))
        )
