"""A friction coefficient that differs from place to place."""

import numpy as np
import pytest

from fingerdesign.contact.laws import OPEN, SLIP, STICK
from fingerdesign.contact.measures import measure
from fingerdesign.contact.problem import Motion
from fingerdesign.shapes.friction import FrictionLaw
from tests.support.reduced import followed

PATH = [Motion(0.02, 0.0), Motion(0.02, 0.004), Motion(0.02, 0.008), Motion(0.02, 0.03)]


LAWS = [0.5, FrictionLaw(0.2, strength=0.1, cap=0.5), FrictionLaw(0.4, exponent=0.3)]


@pytest.mark.parametrize("law", LAWS, ids=str)
@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("name", ["strip", "patch"])
def test_each_node_keeps_to_its_own_friction(name, compiled, law, request):
    if not compiled:
        request.getfixturevalue("numpy_alone")
    problem = request.getfixturevalue(name).with_friction(law)
    share = np.random.default_rng(2).uniform(0.8, 1.2, problem.shape[0])
    statuses = set()
    for increment in followed(problem.patchy(share), PATH):
        normal = np.einsum("ma,ma->m", increment.force, problem.frames[:, 0])
        tangential = np.einsum("ma,mka->mk", increment.force, problem.frames[:, 1:])
        size = np.linalg.norm(tangential, axis=1)
        bound = share * problem.law.bound(normal, problem.model.areas)
        assert (size <= bound + 1e-9 * normal.max()).all()
        sliding = increment.status == SLIP
        np.testing.assert_allclose(size[sliding], bound[sliding], atol=1e-9 * normal.max())
        motion = problem.compliance @ np.column_stack([normal, tangential]).ravel()
        gap = (
            motion.reshape(problem.shape)[:, 0] + problem.offset(increment.state.motion, 0.0)[:, 0]
        )
        assert np.abs(gap[increment.status != OPEN]).max() < 1e-9
        statuses |= set(increment.status)
    assert statuses >= {SLIP, STICK}


@pytest.mark.parametrize("name", ["strip", "patch"])
def test_it_slips_as_a_whole_at_its_slip_ratio(name, request):
    problem = request.getfixturevalue(name)
    problem = problem.patchy(np.random.default_rng(3).uniform(0.8, 1.2, problem.shape[0]))
    *_, last = followed(problem, [*PATH, Motion(0.02, 0.3)])
    found = measure(problem, last)
    assert found.stick_ratio == 0.0
    ratio = problem.slip_ratio(last.multiplier[:, 0])
    assert found.tangential_force / found.normal_force == pytest.approx(ratio, rel=1e-6)
    assert ratio != pytest.approx(problem.friction_coefficient, rel=1e-3)
    assert problem.slip_ratio(np.zeros(problem.shape[0])) is None


@pytest.mark.parametrize("name", ["strip", "patch"])
def test_the_same_share_everywhere_is_another_coefficient(name, request):
    problem = request.getfixturevalue(name)
    everywhere = problem.patchy(np.full(problem.shape[0], 0.6))
    other = problem.with_friction(0.6 * problem.friction_coefficient)
    for one, two in zip(followed(everywhere, PATH), followed(other, PATH), strict=True):
        np.testing.assert_allclose(one.force, two.force, atol=1e-8 * np.abs(two.force).max())
        first, second = measure(everywhere, one), measure(other, two)
        assert first.stick_ratio == pytest.approx(second.stick_ratio, abs=1e-6)
        assert first.slip_distance == pytest.approx(second.slip_distance, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("kind", [int, np.float32])
def test_shares_of_any_kind_of_number_are_the_same(strip, kind):
    problem = strip.with_friction(LAWS[1])
    given = np.ones(strip.shape[0], dtype=kind)
    one, two = (list(followed(each, PATH)) for each in (problem.patchy(given), problem))
    np.testing.assert_allclose(one[-1].force, two[-1].force, atol=1e-12)
    half = problem.patchy(0.5 * given), strip.patchy(0.5 * given)
    assert half[1].mean_friction(np.ones(len(given))) == pytest.approx(0.25)
    assert half[0].mean_friction(np.ones(len(given))) < problem.mean_friction(np.ones(len(given)))


def test_shares_are_positive_and_multiply(strip):
    share = np.random.default_rng(2).uniform(0.8, 1.2, strip.shape[0])
    for given in (0.0 * share, np.nan * share):
        with pytest.raises(ValueError, match="finite and > 0"):
            strip.patchy(given)
    twice, once = strip.patchy(share).patchy(0.5 * share), strip.patchy(0.5 * share**2)
    np.testing.assert_allclose(twice.friction_share, once.friction_share, rtol=1e-14)
