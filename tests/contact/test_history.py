"""Friction that is larger at rest than in motion, from increment to increment."""

from itertools import pairwise

import numpy as np
import pytest

from fingerdesign.contact.history import FrictionHistory
from fingerdesign.contact.increment import ACCEPT, TRACKED, solve_increment
from fingerdesign.contact.laws import OPEN, SLIP, STICK
from fingerdesign.contact.measures import measure
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import followed, reduced_model

PRESSED = Motion(0.02, 0.0)
SHEARED = [PRESSED, *(Motion(0.02, shear) for shear in np.linspace(0.0, 0.02, 27)[1:])]
THERE_AND_BACK = [*SHEARED, *SHEARED[-2::-1], PRESSED]


def path_of(problem, kinetic_share, motions):
    """Each increment with the problem that it was solved on."""
    history, found = FrictionHistory(problem, kinetic_share), []
    for motion in motions:
        now = history.problem
        increment = solve_increment(now, history.state, motion, history.workspace)
        assert increment.certificate.laws <= ACCEPT
        history.accept(increment)
        found.append((now, increment))
    return found, history


def use_of(problem, increment):
    """F_t / mu F_n of the static coefficient."""
    found = measure(problem, increment)
    return found.tangential_force / (problem.friction_coefficient * found.normal_force)


@pytest.mark.parametrize("name", ["strip", "patch"])
def test_one_friction_is_as_without_a_history(name, request):
    problem = request.getfixturevalue(name)
    found, _ = path_of(problem, 1.0, THERE_AND_BACK)
    for (now, one), two in zip(found, followed(problem, THERE_AND_BACK), strict=True):
        assert now is problem
        np.testing.assert_array_equal(one.force, two.force)
        np.testing.assert_array_equal(one.state.slip, two.state.slip)


@pytest.mark.parametrize("patchy", [False, True])
@pytest.mark.parametrize("name", ["strip", "patch"])
def test_a_node_meets_the_friction_of_what_it_did_in_the_increment_before(name, patchy, request):
    problem = request.getfixturevalue(name)
    own = np.ones(problem.shape[0])
    if patchy:
        own = np.random.default_rng(2).uniform(0.8, 1.2, len(own))
        problem = problem.patchy(own)
    found, _ = path_of(problem, 0.85, THERE_AND_BACK)
    slid, met = np.zeros(len(own), dtype=bool), set()
    for now, increment in found:
        true_normals = now.frames[:, 0]
        normal = np.einsum("ma,ma->m", increment.force, true_normals)
        across = increment.force - normal[:, None] * true_normals
        size = np.linalg.norm(across, axis=1)
        bound = 0.5 * own * np.where(slid, 0.85, 1.0) * normal
        near = 1e-8 * normal.max()
        assert (size <= bound + near).all()
        slides = increment.status == SLIP
        np.testing.assert_allclose(size[slides], bound[slides], atol=near)
        met |= set(zip(slid.tolist(), slides.tolist(), strict=True))
        length = np.linalg.norm(increment.slip_increment, axis=1)
        slid = slides & (length > 1e-9 * problem.self_compliance * increment.multiplier[:, 0])
    assert len(met) == 4  # each of both frictions stuck, and slid


@pytest.mark.parametrize("patchy", [False, True])
def test_complete_slip_falls_to_the_kinetic_friction_and_rest_heals(strip, patchy):
    problem = strip
    if patchy:
        problem = strip.patchy(np.random.default_rng(2).uniform(0.8, 1.2, strip.shape[0]))
    onward = [Motion(0.02, 0.03), Motion(0.02, 0.04)]
    still = [onward[-1], onward[-1]]
    again = [Motion(0.02, 0.04 + more) for more in (0.0004, 0.02, 0.04)]
    found, history = path_of(problem, 0.8, [*SHEARED, *onward, *still, *again])
    uses = [use_of(*each) for each in found]
    slides = path_of(problem, 1.0, [*SHEARED, *onward])[0][-1]
    least = 0.8 * use_of(*slides)
    assert slides[1].status.max() == SLIP
    assert uses[len(SHEARED) :][:4] == pytest.approx([least] * 4, rel=1e-7)
    assert max(uses[: len(SHEARED)]) > least + 0.02  # the edge slides first: not all of the drop
    assert uses[-3] > least + 0.02  # it sticks again, at first
    assert uses[-1] == pytest.approx(least, rel=1e-7)
    assert history.settled


@pytest.mark.parametrize("compiled", [True, False])
def test_what_is_pulled_back_by_a_hair_sticks(compiled, request):
    """Half a thousandth below its limit a node is on it no more, though it slid before."""
    if not compiled:
        request.getfixturevalue("numpy_alone")
    points = np.column_stack([np.linspace(-1.0, 1.0, 5), np.zeros(5)])
    areas = {"facet_areas": np.full(4, 0.5), "areas": np.full(5, 0.4)}
    model = reduced_model(points, 0.1 * np.eye(10), rim=np.zeros(5, dtype=bool), **areas)
    problem = contact_problem(model, Plane(0.0), 0.5)
    path = [Motion(0.02, 0.0), Motion(0.02, 0.0101), Motion(0.02, 0.0101 - 5e-6)]
    *_, slid, back = followed(problem, path)
    assert set(slid.status) == {SLIP}
    assert (slid.state.sliding > 0.0).all()
    assert back.force[:, 0] == pytest.approx(slid.force[:, 0] * (1.0 - 5e-4), rel=1e-9)
    assert set(back.status) == {STICK}
    assert not back.state.sliding.any()


def test_what_slides_all_at_once_drops_by_the_whole_difference():
    """Equal springs side by side: at the static limit, then at the kinetic one."""
    points = np.column_stack([np.linspace(-1.0, 1.0, 5), np.zeros(5)])
    areas = {"facet_areas": np.full(4, 0.5), "areas": np.full(5, 0.4)}
    model = reduced_model(points, 0.1 * np.eye(10), rim=np.zeros(5, dtype=bool), **areas)
    problem = contact_problem(model, Plane(0.0), 0.5)
    motions = [PRESSED, *(Motion(0.02, shear) for shear in (0.006, 0.0101, 0.0102, 0.0103))]
    found, _ = path_of(problem, 0.9, motions)
    uses = [use_of(*each) for each in found]
    assert uses == pytest.approx([0.0, 0.6, 1.0, 0.9, 0.9], abs=1e-9)


def test_the_way_a_node_slid_is_the_sum_of_its_slips_whatever_its_friction_became(strip):
    motions = [*SHEARED, *(Motion(0.02, shear) for shear in (0.03, 0.04, 0.0396, 0.05))]
    found, _ = path_of(strip, 0.8, motions)
    way, shares = np.zeros(strip.shape[0]), set()
    for now, increment in found:
        share = np.ones(len(way)) if now.friction_share is None else now.friction_share
        shares |= set(share.round(9).tolist())
        slid = increment.status == SLIP
        way += slid * np.linalg.norm(increment.slip_increment, axis=1)
        way *= increment.status != OPEN
        np.testing.assert_allclose(increment.state.travelled, way, atol=1e-12)
    assert shares == {0.8, 1.0}


def test_a_node_slips_on_its_limit_alone(strip):
    """A little motion back takes nodes off their limit by less than a thousandth of the largest."""
    back = [Motion(0.02, SHEARED[-1].shear - step) for step in (1e-7, 3e-7, 1e-6)]
    found, _ = path_of(strip, 1.0, [*SHEARED, *back])
    below = 0
    for _, increment in found[len(SHEARED) :]:
        normal, across = increment.multiplier[:, 0], np.abs(increment.multiplier[:, 1])
        short = 0.5 * normal - across > 1e-8 * normal.max()
        below += int(((0.5 * normal - across)[short] < 1e-3 * normal.max()).sum())
        assert not (short & (increment.status == SLIP)).any()
    assert below > 3


@pytest.mark.parametrize("name", ["strip", "patch"])
def test_with_a_kinetic_drop_less_sticks_at_the_same_force(name, request):
    problem = request.getfixturevalue(name)

    def curve(share):
        found, _ = path_of(problem, share, SHEARED)
        uses = np.array([use_of(*each) for each in found])
        ratios = np.array([measure(*each).stick_ratio for each in found])
        rising = slice(0, int(uses.argmax()) + 1)
        return uses[rising], ratios[rising]

    static, plain = curve(1.0)
    for share in (0.95, 0.9, 0.8):
        uses, ratios = curve(share)
        assert (ratios <= np.interp(uses, static, plain) + 1e-9).all()
        assert (ratios < np.interp(uses, static, plain) - 1e-3).any()
        if name == "strip":  # Cattaneo's, of a cylinder, with the kinetic coefficient alone
            least = np.sqrt(np.clip(1.0 - uses / share, 0.0, None))
            assert (ratios[1:] > least[1:] - 0.03).all()


def test_friction_is_strengthened_from_the_first_each_time(strip):
    history = FrictionHistory(strip)
    first = strip.friction_coefficient
    for factor in (1.2, 1.3, 1.0):
        history.strengthen(factor)
        assert history.problem.friction_coefficient == pytest.approx(factor * first)
        history.accept(solve_increment(history.problem, history.state, PRESSED, history.workspace))


def test_a_displaced_surface_keeps_the_friction_of_what_slid(strip):
    _, history = path_of(strip, 0.8, SHEARED)
    shares = history.problem.friction_share
    lag = np.random.default_rng(3).standard_normal(history.problem.modes[4].shape)
    history.displace(lag)
    np.testing.assert_array_equal(history.problem.modes[4], lag)
    assert history.problem.friction_share is shares
    assert set(shares) == {0.8, 1.0}


def test_shares_out_of_bounds_are_refused(strip):
    for share in (0.0, 1.1, np.nan):
        with pytest.raises(ValueError, match="over 0 and at most 1"):
            FrictionHistory(strip, share)


@pytest.mark.parametrize("name", ["strip", "patch"])
def test_nodes_that_change_their_friction_are_followed_on(name, request):
    """The compliance is the same, so neither its inverse nor the last increment is lost."""
    problem = request.getfixturevalue(name)
    found, _ = path_of(problem, 0.85, SHEARED)
    shares = [now.friction_share for now, _ in found]
    changes = [one is not two for one, two in pairwise(shares)]
    assert sum(changes) > 5
    assert all(now.compliance is problem.compliance for now, _ in found)
    assert {increment.method for _, increment in found[2:]} == {TRACKED}
