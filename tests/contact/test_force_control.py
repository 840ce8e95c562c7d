"""The motion that gives the forces, or the shear that does at a held approach; or why none."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from fingerdesign_bench.accuracy.analytic import cattaneo_mindlin_line

from fingerdesign.contact.balance import (
    Attempts,
    ForceSlope,
    OutOfReach,
    predicted_shear,
    rising_root,
    solve_shear,
)
from fingerdesign.contact.force_control import Forces, NoEquilibrium, _Search, solve_forces
from fingerdesign.contact.gross_slip import _start
from fingerdesign.contact.increment import ContactState, Workspace, ZoneExhausted, solve_increment
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.contact.tangent import force_response
from fingerdesign.errors import SolverError
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


@pytest.mark.parametrize(
    "solve",
    [
        lambda strip, state: solve_increment(strip, state, Motion(0.05, 0.02)),
        lambda strip, state: solve_forces(strip, state, Forces(1.0, 0.4)),
        lambda strip, state: solve_shear(strip, state, 0.06, 0.04),
    ],
)
def test_the_state_is_frozen(strip, solve):
    (step,) = follow(strip, [Forces(1.0, 0.2)])
    state = step.increment.state
    before = state.slip.copy()
    first, second = (solve(strip, state) for _ in "ab")
    assert first.motion == second.motion
    assert np.array_equal(first.multiplier, second.multiplier)
    assert np.array_equal(state.slip, before)


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
    words = "from {:.4g} to {:.4g} N".format(*sorted([0.05 * side * up, 0.05 * side * down]))
    for limit in (up, down):
        for share in (0.5, 0.99, 0.999):
            ratio = side * (0.5 * (up + down) + share * (limit - 0.5 * (up + down)))
            found = solve_forces(problem, state, Forces(0.05, 0.05 * ratio))
            assert whole(problem, found) == pytest.approx((0.05, 0.05 * ratio), abs=1e-9)
            toward_x = np.tan(np.arctan(friction) + side * slope)
            assert problem.slip_ratio(found.multiplier[:, 0]) == pytest.approx(toward_x)
        beyond = limit + 1e-3 * (limit - 0.5 * (up + down))
        with pytest.raises(NoEquilibrium, match=f"complete slip.*{words}"):
            solve_forces(problem, state, Forces(0.05, 0.05 * side * beyond))
    # At a held approach, too.
    held = pressed(problem, 0.05)
    wanted = side * 0.1 * whole(problem, held)[0]
    found = solve_shear(problem, held.state, 0.05, wanted)
    assert whole(problem, found)[1] == pytest.approx(wanted, rel=1e-7)


@pytest.mark.parametrize("normal", [0.0, -1.0, float("nan")])
def test_a_contact_only_presses(strip, normal):
    with pytest.raises(NoEquilibrium, match="only press"):
        solve_forces(strip, ContactState.untouched(strip), Forces(normal, 0.0))


def test_the_normal_force_alone_with_the_shear_held(strip):
    *_, step = follow(strip, [Forces(1.0), Forces(1.0, held=Motion(0.0, 0.02))])
    assert step.increment.motion.shear == 0.02
    assert step.measures.normal_force == pytest.approx(1.0)
    assert step.measures.tangential_force > 0.01


def test_a_contact_that_outgrows_its_zone_is_an_error(strip):
    state = ContactState.untouched(strip)
    for solve in (
        lambda: solve_increment(strip, state, Motion(3.0, 0.0)),
        lambda: solve_forces(strip, state, Forces(50.0, 0.0)),
        lambda: solve_shear(strip, pressed(strip, 0.05).state, 3.0, 0.1),
    ):
        with pytest.raises(ZoneExhausted, match="candidate zone"):
            solve()


def test_substeps_of_a_row_of_forces_end_at_the_row(strip):
    rows = [Forces(1.0, 0.0), Forces(1.0, 0.4)]
    one, cut = (list(follow(strip, rows, substeps=n))[-1].measures for n in (1, 4))
    assert cut.tangential_force == pytest.approx(0.4)
    assert cut.stick_ratio == pytest.approx(one.stick_ratio, abs=0.02)


def test_substeps_of_a_row_are_rows_of_their_own(strip):
    """Friction moves with each: the same forces, slip and travel as of so many rows."""
    rows = [Motion(0.05, 0.02), Motion(0.08, -0.03)]
    parts = [0.25, 0.5, 0.75, 1.0]
    start = [Motion(0.0, 0.0), *rows]
    cut = [a.toward(b, part) for a, b in pairwise(start) for part in parts]
    one = list(follow(strip, rows, substeps=4))[-1].increment.state
    other = list(follow(strip, cut))[-1].increment.state
    for name in ("multiplier", "slip", "travelled"):
        known = getattr(other, name)
        np.testing.assert_allclose(getattr(one, name), known, atol=1e-9 * np.abs(known).max())


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


# The shear that carries a force at a held approach.


def pressed(problem, approach):
    return solve_increment(problem, ContactState.untouched(problem), Motion(approach, 0.0))


@pytest.mark.parametrize("which", ["strip", "patch"])
def test_the_force_requested_for_is_carried_at_the_approach_held(which, request):
    problem, deep = request.getfixturevalue(which), 0.05 if which == "strip" else 0.01
    state = pressed(problem, deep).state
    normal, _ = whole(problem, pressed(problem, deep))
    for share in (0.0, 0.3, 0.9, 0.9999, -0.5, -0.9999) if which == "strip" else (0.6,):
        wanted = share * 0.5 * normal
        found = solve_shear(problem, state, deep, wanted)
        assert found.motion.approach == deep
        assert whole(problem, found)[1] == pytest.approx(wanted, abs=1e-8 * normal)
        again = solve_increment(problem, state, found.motion)
        assert np.abs(again.multiplier - found.multiplier).max() < 1e-9 * normal
    with pytest.raises(NoEquilibrium):
        solve_shear(problem, state, deep, 0.51 * normal)


@pytest.mark.parametrize("share", [1.001, 3.0, -1.001, -50.0])
def test_what_friction_cannot_carry_has_no_answer_and_it_says_what_it_can(strip, share):
    state = pressed(strip, 0.05).state
    normal, _ = whole(strip, pressed(strip, 0.05))
    for sign, solve in (
        (np.sign(share), lambda force: solve_shear(strip, state, 0.05, force)),
        (1.0, lambda force: solve_forces(strip, state, Forces(normal, force))),
    ):
        with pytest.raises(NoEquilibrium, match="complete slip") as caught:
            solve(share * 0.5 * normal)
        carried = float(str(caught.value).split("carries ")[1].split(" N")[0])
        assert carried == pytest.approx(sign * 0.5 * normal, rel=1e-3)


def test_untouched_or_off_there_is_nothing_to_carry_with(strip):
    state = ContactState.untouched(strip)
    apart = solve_increment(strip, state, Motion(-0.1, 0.0))
    assert not force_response(strip, apart, strip.modes[:2]).any()
    for before in (state, pressed(strip, 0.05).state):
        with pytest.raises(NoEquilibrium):
            solve_shear(strip, before, -0.1, 0.1)
    with pytest.raises(SolverError, match="finite"):
        solve_shear(strip, pressed(strip, 0.05).state, 0.05, float("nan"))


@pytest.mark.parametrize("start", [-5.0, -0.2, 0.0, 0.3, 40.0])
def test_it_matters_little_where_it_starts(strip, start):
    state = pressed(strip, 0.05).state
    near = solve_shear(strip, state, 0.05, 0.05)
    far = solve_shear(strip, state, 0.05, 0.05, start=start)
    assert far.motion.shear == pytest.approx(near.motion.shear, abs=1e-7)


def test_histories_at_random(strip):
    """Held, closed, opened, loaded and unloaded; each answer checked with its own motion."""
    rng = np.random.default_rng(5)
    for friction in (0.1, 0.5, 1.0, 3.0):
        problem = strip.with_friction(friction)
        state, approach = pressed(problem, 0.04).state, 0.04
        carried = 0
        for _ in range(25):
            approach = float(np.clip(approach + 0.01 * rng.standard_normal(), 0.01, 0.08))
            normal, _ = whole(problem, solve_increment(problem, state, Motion(approach, 0.0)))
            wanted = friction * normal * rng.uniform(-1.1, 1.1)
            try:
                found = solve_shear(problem, state, approach, wanted)
            except NoEquilibrium:
                continue
            carried += 1
            assert whole(problem, found)[1] == pytest.approx(wanted, abs=1e-8 * normal)
            assert found.certificate.laws < 1e-8
            state = found.state
        assert carried >= 15


class Counting(Workspace):
    """A workspace that counts the increments that were accepted."""

    def __init__(self):
        super().__init__()
        self.increments = 0

    def record(self, before, after):
        super().record(before, after)
        self.increments += 1


def test_a_small_step_on_costs_few_increments(strip):
    """As a hanging object requires: close a little, carry the same."""
    found = solve_shear(strip, pressed(strip, 0.05).state, 0.05, 0.04)
    workspace = Counting()
    for k in range(1, 21):
        approach = 0.05 + 0.0005 * k
        start = predicted_shear(strip, found, approach, 0.04)
        found = solve_shear(strip, found.state, approach, 0.04, workspace, start=start)
    assert 20 <= workspace.increments <= 4 * 20  # each answer is recorded once more


def test_a_root_is_found_where_the_tangent_reports_nothing():
    def stairs(x):  # flat, but for a steep rise at 0.3
        return ForceSlope(float(np.tanh(200.0 * (x - 0.3))), 0.0, 1.0)

    assert rising_root(stairs, 0.5, 0.0, 0.0, 0.01) == pytest.approx(0.3027, abs=1e-4)
    with pytest.raises(SolverError, match="no motion"):
        rising_root(stairs, 1.5, 0.0, 0.0, 0.01)
    with pytest.raises(OutOfReach):
        rising_root(lambda x: ForceSlope(1.0, 0.0, 1.0, limit=1), 1.5, 0.0, 0.0, 0.01)
    with pytest.raises(SolverError, match="no motion"):
        rising_root(lambda x: None, 1.5, 0.3, 0.0, 0.01)


def test_a_little_more_is_found_beyond_full_slip_where_it_is_known_to_be_there():
    """As in 3-D: all slides from 0.1 on, and the force still grows a little."""

    def creeping(x):
        value = x if x < 0.1 else 0.1 + 1e-3 * (x - 0.1)
        return ForceSlope(value, 1.0 if x < 0.1 else 1e-3, 1.0, int(x >= 0.1))

    assert rising_root(creeping, 0.1005, 0.0, 0.0, 2.0, most=5.0) == pytest.approx(0.6)
    with pytest.raises(OutOfReach):
        rising_root(creeping, 0.1005, 0.0, 0.0, 2.0)
    with pytest.raises(OutOfReach):  # downward nothing is known
        rising_root(lambda x: ForceSlope(-1.0, 0.0, 1.0, limit=-1), -1.5, 0.0, 0.0, 2.0, most=5.0)


def test_a_search_that_fails_without_slow_methods_is_repeated_with_them(strip, monkeypatch):
    """Near a jump between answers the fast methods may all fail."""
    efforts = []

    def unlucky(problem, state, motion, workspace, try_slow_methods):
        efforts.append(try_slow_methods)
        if not try_slow_methods:
            raise SolverError("no answer by the fast methods")
        return solve_increment(problem, state, motion, workspace, try_slow_methods)

    monkeypatch.setattr("fingerdesign.contact.force_control.solve_increment", unlucky)
    increment = solve_forces(strip, ContactState.untouched(strip), Forces(1.0, 0.3))
    assert whole(strip, increment) == pytest.approx((1.0, 0.3), abs=1e-8)
    assert False in efforts


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9, 0.999])
def test_the_stick_zone_is_cattaneos(strip, share):
    *_, step = follow(strip, [Forces(1.0, 0.0), Forces(1.0, share * 0.5)])
    m = step.measures
    assert m.tangential_force == pytest.approx(share * 0.5)
    assert m.stick_ratio > 0.0
    exact = cattaneo_mindlin_line(share * 0.5, 1.0, 0.5)
    # Of 40 facets; at 0.999 the stick zone is 0.032 wide, little more than one facet.
    least = 0.007 if share < 0.99 else 0.011
    assert m.stick_width / m.contact_width == pytest.approx(exact, abs=least)


@pytest.mark.parametrize("shear", [0.4, -0.4])
def test_what_slides_sticks_as_the_motion_turns_back(strip, shear):
    start = solve_increment(strip, pressed(strip, 0.05).state, Motion(0.05, shear))
    (response,) = force_response(strip, start, strip.modes[1:2], turning_back=True)
    back = -np.sign(shear) * STEP
    there = solve_increment(strip, start.state, Motion(0.05, shear + back))
    numeric = (there.multiplier - start.multiplier)[:, 1] / back
    assert np.abs(numeric).max() > 0.01
    assert response[:, 1] == pytest.approx(numeric, abs=1e-3 * np.abs(numeric).max())


def test_half_a_finger_takes_half_of_the_force(strip, calls_of):
    """First tries are those of a node's compliance under the force of the modelled half."""
    half = replace(strip, model=replace(strip.model, symmetry_factor=2))
    state, own = ContactState.untouched(strip), strip.self_compliance
    pulls = calls_of(_Search, "_pulled")
    for problem, most in ((half, 0.5 * own.max()), (strip, own.max())):
        search = _Search(problem, state, Forces(2.0, 0.3), Workspace(), False, 1e-9)
        assert search._overlap() == pytest.approx(0.2 * most * own.min() / own.max())
        assert Attempts(problem, state).softest == pytest.approx(most)
        assert _start(problem, 2.0) == pytest.approx((0.2 * most, 0.0, most))
        del pulls[:]
        search._by_shear()
        assert pulls[1][0][1] == pytest.approx(0.5 * most)
