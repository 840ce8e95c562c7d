"""The first guess: contact from the normal forces alone."""

import numpy as np
import pytest

from fingerdesign.contact.increment import ContactState, pressed, solve_increment
from fingerdesign.contact.problem import Motion


@pytest.mark.parametrize("which", ["strip", "patch"])
def test_without_friction_the_guess_is_the_answer(which, request):
    problem = request.getfixturevalue(which).with_friction(0.0)
    deep = Motion(0.05 if which == "strip" else 0.01, 0.0)
    state = ContactState.untouched(problem)
    offset = problem.offset(deep, state.slip)
    guess = pressed(problem.compliance, offset, state.multiplier, 0.0)
    answer = solve_increment(problem, state, deep).multiplier
    # Normal and tangential do not couple on these half-spaces.
    assert np.abs(guess - answer)[:, 0].max() < 1e-9 * answer.max()
    assert not guess[:, 1:].any()


def test_a_guess_is_admissible_whatever_it_is_made_from(patch):
    rng = np.random.default_rng(1)
    offset = patch.offset(Motion(0.01, 0.002), np.zeros((patch.model.nodes, 2)))
    wild = rng.normal(size=offset.shape)
    guess = pressed(patch.compliance, offset, wild, 0.5)
    assert (guess[:, 0] >= 0.0).all()
    assert (np.linalg.norm(guess[:, 1:], axis=1) <= 0.5 * guess[:, 0] + 1e-15).all()


def test_nothing_touches_apart(strip):
    offset = strip.offset(Motion(-0.1, 0.0), np.zeros((strip.model.nodes, 1)))
    assert not pressed(strip.compliance, offset, np.zeros(offset.shape), 0.5).any()
