"""An object off the middle of a contact: its moment, its turn, what friction carries of it."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.contact.gross_slip import coefficient_under
from fingerdesign.contact.increment import Workspace, solve_increment
from fingerdesign.contact.measures import measure
from fingerdesign.contact.problem import ContactState, contact_problem
from fingerdesign.contact.turning import carried_turning, turn_radius, turning
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import bump

MU, CENTRE, DEPTH, WEIGHT = 0.5, 1.2, 0.01, 0.004


def posed(nodes=21, friction=MU):
    return contact_problem(bump(nodes), Plane(0.0), friction)


def sheared(problem, shears, depth=DEPTH):
    """Yield the increments of a press and of shears of the centre, mm, from touch on."""
    state, workspace = ContactState.untouched(problem), Workspace()
    for shear in (0.0, *shears):
        motion = replace(state.motion, approach=depth, shear=float(shear))
        found = solve_increment(problem, state, motion, workspace)
        yield found
        state = found.state


@pytest.fixture(scope="module")
def slide():
    """The problem, its turned one, and a slide of it to the end."""
    problem = posed()
    turned = turning(problem, CENTRE, WEIGHT)
    return turned, list(sheared(turned, np.linspace(0.0, 0.4, 81)[1:]))


def test_the_moment_is_that_of_the_force_at_its_centre(slide):
    problem, found = slide
    for increment in found[1:]:
        measured = measure(problem, increment)
        assert measured.twist_moment == pytest.approx(CENTRE * measured.tangential_force, rel=2e-3)
        assert abs(measured.force_z) < 1e-3 * measured.tangential_force


def test_the_turn_radius_tells_what_is_left_of_the_stiffness_at_any_arm():
    """Of a sticking contact: the object turns about its centre as a rigid body on two springs."""
    problem = posed(friction=10.0)
    radius = turn_radius(problem, DEPTH)
    pulled = []
    for arm in (0.0, 0.2, -0.2, 0.6):
        turned = turning(problem, arm, WEIGHT)
        *_, found = sheared(turned, [1e-4])
        pulled.append(measure(turned, found).tangential_force)
    left = np.array(pulled) / pulled[0]
    expected = [1.0 / (1.0 + (arm / radius) ** 2) for arm in (0.0, 0.2, -0.2, 0.6)]
    assert left == pytest.approx(expected, rel=0.02)


def test_a_slide_ends_at_what_limit_analysis_says(slide):
    """Nodes' normal forces are not changed by a shear here, so that the answer is exact."""
    problem, found = slide
    normal, most = carried_turning(problem, found[0].multiplier[:, 0])
    forces = [measure(problem, each) for each in found]
    assert forces[-1].normal_force == pytest.approx(normal, rel=1e-9)
    assert forces[-1].tangential_force == pytest.approx(most, rel=1e-3)
    assert max(each.tangential_force for each in forces) <= most * (1.0 + 1e-3)
    # The contact is within 0.45 mm of the middle, the centre 1.2 mm away: mostly it turns.
    assert most < 0.4 * MU * normal


def test_the_turn_is_to_the_weight_and_mirrors(slide):
    """A weight at z > 0 pulls that side toward +x: about +y, z turns to x. At -z all mirrors."""
    problem, found = slide
    turns = [each.state.motion.twist_deg for each in found]
    assert (np.diff(turns) > 0.0).all()
    other = turning(posed(), -CENTRE, WEIGHT)
    mirrored = list(sheared(other, np.linspace(0.0, 0.4, 81)[1:21]))
    assert mirrored[-1].state.motion.twist_deg == pytest.approx(-turns[20], rel=1e-6)
    force, against = (measure(problem, each).tangential_force for each in (found[20], mirrored[-1]))
    assert force == pytest.approx(against, rel=1e-6)


def test_steps_of_half_the_length_turn_it_as_far(slide):
    _, found = slide
    finer = list(sheared(turning(posed(), CENTRE, WEIGHT), np.linspace(0.0, 0.2, 81)[1:]))
    there, here = found[40].state.motion, finer[-1].state.motion
    assert here.twist_deg == pytest.approx(there.twist_deg, rel=0.01)


def test_a_centre_in_the_middle_changes_nothing():
    shears = np.linspace(0.0, 0.004, 9)[1:]
    problem = posed()
    for own, bare in zip(
        sheared(turning(problem, 0.0, WEIGHT), shears), sheared(problem, shears), strict=True
    ):
        assert own.multiplier == pytest.approx(bare.multiplier, abs=1e-4 * bare.multiplier.max())
        assert abs(own.state.motion.twist_deg) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pressure", "moment"),
    [
        # Integrals of mu p r over a circle of radius a, of the normal force N: in mu N a.
        ("even", 2.0 / 3.0),
        ("hertz", 3.0 * np.pi / 16.0),  # Lubkin 1951
    ],
)
def test_moment_of_a_circle_that_turns_as_a_whole(pressure, moment):
    problem = posed(41)
    radius = 0.8
    distance = np.hypot(*problem.model.points[:, [0, 2]].T)
    inside = distance < radius
    forces = np.where(inside, 1.0, 0.0)
    if pressure == "hertz":
        forces = np.sqrt(np.maximum(1.0 - (distance / radius) ** 2, 0.0))
    far = 1e4  # mm: no force to speak of, but its moment
    _, carried = carried_turning(turning(problem, far, WEIGHT), forces)
    assert carried * far == pytest.approx(moment * MU * forces.sum() * radius, rel=0.01)


@pytest.mark.parametrize("centre", [0.0, 0.2, 1.0, 2.5])
def test_two_points_turn_about_the_farther(centre):
    """Points at z = +-b under N each: moments about the farther give F (c + b) = mu N 2 b."""
    problem = posed()
    x, z = problem.model.points[:, 0], problem.model.points[:, 2]
    forces = np.where((np.abs(x) < 1e-9) & np.isclose(np.abs(z), 0.5), 2.0, 0.0)
    _, carried = carried_turning(turning(problem, centre, WEIGHT), forces)
    assert carried == pytest.approx(MU * 2.0 * 1.0 / (centre + 0.5), rel=1e-6)


def test_least_force_holds_and_less_does_not():
    problem = turning(posed(), CENTRE, WEIGHT)
    least = WEIGHT / coefficient_under(problem, WEIGHT)
    for share, holds in ((1.03, True), (0.97, False)):
        depth = DEPTH * (share * least / _pressed(problem)) ** (2.0 / 3.0)
        last = list(sheared(problem, np.linspace(0.0, 0.6, 121)[1:], depth))[-1]
        assert (measure(problem, last).tangential_force >= WEIGHT) == holds


def _pressed(problem):
    return measure(problem, next(sheared(problem, ()))).normal_force


@pytest.mark.parametrize("lean", [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
def test_the_limit_on_a_plane_that_leans(lean):
    """By degrees about z and x. The slide shifts the normal forces, so its last ones are taken."""
    direction = np.array([np.sin(np.deg2rad(lean[0])), -1.0, np.sin(np.deg2rad(lean[1]))])
    plane = Plane(0.0, tuple(direction / np.linalg.norm(direction)))
    problem = turning(contact_problem(bump(21), plane, MU), CENTRE, WEIGHT)
    last = list(sheared(problem, np.linspace(0.0, 0.6, 61)[1:]))[-1]
    normal, most = carried_turning(problem, last.multiplier[:, 0])
    found = measure(problem, last)
    assert (found.normal_force, found.tangential_force) == pytest.approx((normal, most), rel=1e-3)


def test_half_a_finger_and_a_section_do_not_turn():
    problem = posed(5)
    half = replace(problem, model=replace(problem.model, symmetry_factor=2))
    with pytest.raises(ValueError, match="whole finger"):
        turning(half, 1.0, 1.0)
