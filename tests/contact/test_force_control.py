"""Force control: the motion that gives the forces, or the reason why none does."""

from itertools import pairwise

import numpy as np
import pytest
from fingerdesign_bench.accuracy.analytic import cattaneo_mindlin_line

from fingerdesign.contact.increment import ContactState, ZoneExhausted, solve_increment
from fingerdesign.contact.path import Forces, NoEquilibrium, follow, force_response, solve_forces
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.shapes.objects import Plane, touching


def whole(problem, increment):
    force = problem.model.total_force(increment.force)
    return -force[1], force[0]


@pytest.mark.parametrize("path", [[(1, 0), (1, 0.2), (1, 0.45)], [(0.2, 0.05), (1, -0.4)]])
def test_the_forces_requested_for_come_out(strip, path):
    state = ContactState.untouched(strip)
    for normal, tangential in path:
        increment = solve_forces(strip, state, Forces(normal, tangential))
        assert whole(strip, increment) == pytest.approx((normal, tangential), abs=1e-8)
        # The motion found is the answer: prescribed, it gives the same increment.
        again = solve_increment(strip, state, increment.motion)
        assert np.abs(again.multiplier - increment.multiplier).max() < 1e-9
        state = increment.state


def test_the_state_is_frozen(strip):
    (step,) = follow(strip, [Forces(1.0, 0.2)])
    first, second = (solve_forces(strip, step.increment.state, Forces(1.0, 0.4)) for _ in "ab")
    assert first.motion == second.motion
    assert np.array_equal(first.multiplier, second.multiplier)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_the_stick_zone_is_cattaneos(strip, share):
    *_, step = follow(strip, [Forces(1.0, 0.0), Forces(1.0, share * 0.5)])
    m = step.measures
    exact = cattaneo_mindlin_line(share * 0.5, 1.0, 0.5)
    assert m.stick_width / m.contact_width == pytest.approx(exact, abs=0.03)


@pytest.mark.parametrize("share", [1.001, 3.0, -1.001])
def test_complete_slip_has_no_answer_and_says_so(strip, share):
    (step,) = follow(strip, [Forces(1.0, 0.0)])
    with pytest.raises(NoEquilibrium, match="complete slip") as caught:
        solve_forces(strip, step.increment.state, Forces(1.0, share * 0.5))
    assert "carries" in str(caught.value)


def test_just_below_complete_slip_there_is_one(strip):
    *_, step = follow(strip, [Forces(1.0, 0.0), Forces(1.0, 0.4995)])
    assert step.measures.tangential_force == pytest.approx(0.4995)
    assert 0.0 < step.measures.stick_ratio < 0.1


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("friction", [0.15, 0.3, 1.0])
def test_a_slope_holds_what_a_wedge_can(strip, friction, side):
    """From nothing in one increment: up to tan(atan(mu) + slope), and down to the reverse."""
    slope = np.arctan(0.1)
    plane = Plane(0.0, (side * np.sin(slope), -np.cos(slope), 0.0))
    crest = touching(plane, lambda x, z: -(x**2) / 40.0, 3.0, 1.0)[0]
    problem = contact_problem(strip.model, crest, friction)
    state = ContactState.untouched(problem)
    up, down = (np.tan(slope + sign * np.arctan(friction)) for sign in (1.0, -1.0))
    for limit in (up, down):
        for share in (0.5, 0.99, 0.999):
            ratio = side * (0.5 * (up + down) + share * (limit - 0.5 * (up + down)))
            found = solve_forces(problem, state, Forces(0.05, 0.05 * ratio))
            assert whole(problem, found) == pytest.approx((0.05, 0.05 * ratio), abs=1e-9)
        beyond = limit + 1e-3 * (limit - 0.5 * (up + down))
        with pytest.raises(NoEquilibrium, match="complete slip"):
            solve_forces(problem, state, Forces(0.05, 0.05 * side * beyond))


@pytest.mark.parametrize("normal", [0.0, -1.0, float("nan")])
def test_a_contact_only_presses(strip, normal):
    with pytest.raises(NoEquilibrium, match="only press"):
        solve_forces(strip, ContactState.untouched(strip), Forces(normal, 0.0))


def test_the_normal_force_alone_with_the_shear_held(strip):
    *_, step = follow(strip, [Forces(1.0), Forces(1.0, held=Motion(0.0, 0.02))])
    assert step.increment.motion.shear == 0.02
    assert step.measures.normal_force == pytest.approx(1.0)
    assert step.measures.tangential_force > 0.01


def test_a_contact_that_outgrows_its_zone_is_said_to(strip):
    with pytest.raises(ZoneExhausted):
        solve_forces(strip, ContactState.untouched(strip), Forces(50.0, 0.0))


def test_substeps_of_a_row_of_forces_end_at_the_row(strip):
    rows = [Forces(1.0, 0.0), Forces(1.0, 0.4)]
    one, cut = (list(follow(strip, rows, substeps=n))[-1].measures for n in (1, 4))
    assert cut.tangential_force == pytest.approx(0.4)
    assert cut.stick_ratio == pytest.approx(one.stick_ratio, abs=0.02)


def test_in_three_dimensions(patch):
    *_, step = follow(patch, [Forces(0.05, 0.0), Forces(0.05, 0.015)])
    m = step.measures
    assert (m.normal_force, m.tangential_force) == pytest.approx((0.05, 0.015))
    assert m.force_z == pytest.approx(0.0, abs=1e-9)
    assert m.twist_moment == pytest.approx(0.0, abs=1e-9)


def test_a_twist_slips_from_the_rim_inward_to_its_limit(patch):
    pressed = Motion(0.01, 0.0)
    turns = [Motion(0.01, 0.0, 0.0, angle) for angle in (0.2, 0.5, 1.0, 2.0, 20.0)]
    steps = list(follow(patch, [pressed, *turns]))
    ratios = [step.measures.stick_ratio for step in steps[1:]]
    assert all(later < sooner for sooner, later in pairwise(ratios))
    last = steps[-1]
    assert abs(last.measures.tangential_force) < 1e-9 * last.measures.normal_force
    radius = np.hypot(patch.model.points[:, 0], patch.model.points[:, 2])
    limit = 0.5 * float(radius @ last.increment.multiplier[:, 0])
    # +y takes z to x: the object drags the finger's points at +z toward +x.
    assert last.measures.twist_moment == pytest.approx(limit, rel=1e-3)


def test_shear_along_z_is_shear_along_x_turned(patch):
    along = [
        list(follow(patch, [Motion(0.01, 0.0), row]))[-1]
        for row in (Motion(0.01, 0.002), Motion(0.01, 0.0, 0.002))
    ]
    x, z = (step.measures for step in along)
    assert z.force_z == pytest.approx(x.tangential_force, rel=1e-9)
    assert z.stick_ratio == pytest.approx(x.stick_ratio, abs=5e-3)


STEP = 1e-7


@pytest.mark.parametrize("shear", [0.002, 0.01, 0.4])
@pytest.mark.parametrize("which", ["strip", "patch"])
def test_against_a_difference(which, shear, request):
    problem = request.getfixturevalue(which)
    deep = 0.05 if which == "strip" else 0.01
    shear *= 1.0 if which == "strip" else 0.1
    (pressed,) = follow(problem, [Motion(deep, 0.0)])
    state, motion = pressed.increment.state, Motion(deep, shear)
    here = solve_increment(problem, state, motion)
    response = force_response(problem, here, problem.modes[:2])
    for change, step in zip(response, np.eye(2) * STEP, strict=True):
        there = solve_increment(problem, state, Motion(deep + step[0], shear + step[1]))
        numeric = (there.multiplier - here.multiplier) / STEP
        scale = np.abs(response[0]).max()
        assert np.abs(numeric - change).max() < 1e-4 * scale


def test_nothing_answers_without_contact(strip):
    apart = solve_increment(strip, ContactState.untouched(strip), Motion(-0.1, 0.0))
    assert not force_response(strip, apart, strip.modes[:2]).any()
