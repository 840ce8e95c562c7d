"""The shear that carries a force at a held approach, and when there is none."""

import numpy as np
import pytest

from fingerdesign.contact import balance
from fingerdesign.contact.balance import (
    ForceSlope,
    OutOfReach,
    predicted_shear,
    rising_root,
    solve_shear,
)
from fingerdesign.contact.increment import ContactState, ZoneExhausted, solve_increment
from fingerdesign.contact.path import Forces, NoEquilibrium, solve_forces
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.errors import SolverError
from fingerdesign.shapes.objects import Plane, touching


def whole(problem, increment):
    force = problem.model.total_force(increment.force)
    return -force[1], force[0]


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


def test_on_a_flat_object_it_is_force_control_seen_from_the_other_side(strip):
    state = pressed(strip, 0.05).state
    found = solve_shear(strip, state, 0.055, 0.04)
    normal, _ = whole(strip, found)
    both = solve_forces(strip, state, Forces(normal, 0.04))
    assert both.motion.approach == pytest.approx(0.055, abs=1e-9)
    assert both.motion.shear == pytest.approx(found.motion.shear, abs=1e-9)


@pytest.mark.parametrize("share", [1.001, 2.0, -1.001, -50.0])
def test_what_friction_cannot_carry_has_no_answer_and_it_says_what_it_can(strip, share):
    state = pressed(strip, 0.05).state
    normal, _ = whole(strip, pressed(strip, 0.05))
    with pytest.raises(NoEquilibrium, match="complete slip") as caught:
        solve_shear(strip, state, 0.05, share * 0.5 * normal)
    carried = float(str(caught.value).split("carries ")[1].split(" N")[0])
    assert carried == pytest.approx(np.sign(share) * 0.5 * normal, rel=1e-3)


def test_untouched_or_off_there_is_nothing_to_carry_with(strip):
    with pytest.raises(NoEquilibrium):
        solve_shear(strip, ContactState.untouched(strip), -0.1, 0.1)
    with pytest.raises(NoEquilibrium):
        solve_shear(strip, pressed(strip, 0.05).state, -0.1, 0.1)
    with pytest.raises(SolverError, match="finite"):
        solve_shear(strip, pressed(strip, 0.05).state, 0.05, float("nan"))


def test_the_state_is_frozen(strip):
    state = pressed(strip, 0.05).state
    first, second = (solve_shear(strip, state, 0.06, 0.04) for _ in "ab")
    assert first.motion == second.motion
    assert np.array_equal(first.multiplier, second.multiplier)


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


def test_on_a_slope(strip):
    slope = np.arctan(0.1)
    plane = Plane(0.0, (np.sin(slope), -np.cos(slope), 0.0))
    crest = touching(plane, lambda x, z: -(x**2) / 40.0, 3.0, 1.0)[0]
    problem = contact_problem(strip.model, crest, 0.3)
    state = pressed(problem, 0.05).state
    normal, _ = whole(problem, pressed(problem, 0.05))
    found = solve_shear(problem, state, 0.05, 0.1 * normal)
    assert whole(problem, found)[1] == pytest.approx(0.1 * normal, abs=1e-8 * normal)


def test_a_contact_that_outgrows_its_zone_is_said_to(strip):
    with pytest.raises(ZoneExhausted):
        solve_shear(strip, pressed(strip, 0.05).state, 3.0, 0.1)


def test_a_small_step_on_costs_few_increments(strip, monkeypatch):
    """As a hanging object asks: close a little, carry the same."""
    calls = []
    inner = balance.solve_increment
    monkeypatch.setattr(balance, "solve_increment", lambda *a: calls.append(1) or inner(*a))
    state = pressed(strip, 0.05).state
    found = solve_shear(strip, state, 0.05, 0.04)
    calls.clear()
    for k in range(1, 21):
        approach = 0.05 + 0.0005 * k
        start = predicted_shear(strip, found, approach, 0.04)
        found = solve_shear(strip, found.state, approach, 0.04, start=start)
    assert len(calls) <= 3 * 20


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
