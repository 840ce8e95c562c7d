"""Increments followed from the one before: the answers of another solve, and none without one."""

import numpy as np
import pytest

from fingerdesign.contact.force_control import Forces, solve_forces
from fingerdesign.contact.increment import TRACKED, ContactState, Workspace, solve_increment
from fingerdesign.contact.laws import SLIP
from fingerdesign.contact.problem import Motion
from fingerdesign.contact.solver.tracking import Tracker
from tests.support.reduced import followed


class ByNumpy(Workspace):
    """A workspace whose increments are followed by numpy alone."""

    of = Tracker

    def tracker(self, problem):
        friction = problem.friction
        if self._tracker is None or self._tracker.friction != friction:
            self._tracker = self.of(problem.compliance, problem.self_compliance, friction)
        return self._tracker


@pytest.fixture(params=[ByNumpy, Workspace], ids=["numpy", "compiled"])
def made(request):
    """A workspace's class: by numpy and, where there is a compiler, by the kernel."""
    return request.param


def walk(steps, seed=0):
    """Press, then small moves to and fro along x and z, deeper and back."""
    rng = np.random.default_rng(seed)
    way = rng.normal(size=(steps, 3)) * [2e-4, 6e-4, 3e-4] + np.array([2e-4, 4e-4, 0.0])
    places = np.cumsum(way, axis=0) + np.array([0.02, 0.0, 0.0])
    return [Motion(0.02, 0.0), *(Motion(*map(float, place)) for place in places)]


def pairs(problem, motions, workspace, follows):
    """The increments one from the other, and each solved again from the same states."""
    state = ContactState.untouched(problem)
    for tracked in followed(problem, motions, workspace):
        yield tracked, solve_increment(problem, state, tracked.motion)
        state = tracked.state
        follows.append(tracked.method == TRACKED)


@pytest.mark.parametrize("friction", [0.0, 0.2, 0.7])
@pytest.mark.parametrize("shape", ["strip", "patch"])
def test_tracked_increments_are_those_solved_again(shape, friction, made, request):
    problem = request.getfixturevalue(shape).with_friction(friction)
    follows, seen = [], []
    for tracked, again in pairs(problem, walk(40), made(), follows):
        scale = again.multiplier.max()
        np.testing.assert_allclose(
            tracked.multiplier, again.multiplier, rtol=0.0, atol=1e-8 * scale
        )
        length = scale * problem.typical_compliance
        np.testing.assert_allclose(tracked.gap, again.gap, rtol=0.0, atol=1e-8 * length)
        np.testing.assert_array_equal(tracked.status, again.status)
        sliding = tracked.state.sliding  # of all that slips, though the limit be met to 1e-10 only
        np.testing.assert_allclose(sliding, again.state.sliding, rtol=0.0, atol=1e-7 * length)
        assert (sliding[tracked.status == SLIP] > 0.0).all()
        seen.append(tracked.status)
    assert np.mean(follows) > 0.9
    if (shape, friction) == ("patch", 0.2):  # nodes close, slip, stick again and open on the way
        changes = np.diff(np.array(seen), axis=0) != 0
        assert np.count_nonzero(changes.any(axis=1)) > 20
        assert {0, 1, 2} <= set(np.unique(seen).tolist())


def test_trials_from_one_state_follow_each_other(patch, made):
    """A search for forces tries many motions from one history; its answer is the same."""
    problem = patch.with_friction(0.4)
    state, workspace = ContactState.untouched(problem), made()
    pressed = solve_increment(problem, state, Motion(0.02, 0.0), workspace)
    normal = float(pressed.multiplier[:, 0].sum())
    goal = Forces(1.2 * normal, 0.2 * normal)
    tracked = solve_forces(problem, pressed.state, goal, workspace)
    again = solve_forces(problem, pressed.state, goal)
    assert tracked.motion.approach == pytest.approx(again.motion.approach, rel=1e-6)
    assert tracked.motion.shear == pytest.approx(again.motion.shear, rel=1e-6)


def test_an_unknown_state_is_not_followed(patch, made):
    """From a state that is not the last one's there is nothing to follow."""
    workspace = made()
    first, *_ = followed(patch, walk(3))
    solve_increment(patch, ContactState.untouched(patch), Motion(0.03, 0.0), workspace)
    assert solve_increment(patch, first.state, Motion(0.021, 0.0), workspace).method != TRACKED


def test_what_is_far_is_solved_again(patch, made):
    """Ten times deeper at once, or off and on again: the answer stands, however it was found."""
    rows = [Motion(0.005, 0.0), Motion(0.03, 0.02), Motion(-0.01, 0.02), Motion(0.02, 0.0)]
    found = followed(patch, rows, made())
    assert [bool(each.multiplier.any()) for each in found] == [True, True, False, True]


class Wrong(Tracker):
    """A tracker in whose answers closed nodes overlap the object."""

    def solve(self, *arguments):
        found = super().solve(*arguments)
        if found is not None:
            found.motion[:, 0] -= 1e-6 * np.abs(found.motion).max()
        return found


class ByWrong(ByNumpy):
    of = Wrong


def test_a_wrong_answer_is_refused_by_the_certificate(patch):
    follows = []
    for tracked, again in pairs(patch, walk(5), ByWrong(), follows):
        scale = again.multiplier.max()
        np.testing.assert_allclose(
            tracked.multiplier, again.multiplier, rtol=0.0, atol=1e-8 * scale
        )
    assert not any(follows)
