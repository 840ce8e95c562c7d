"""The response of the forces to a change of motion, against a difference of two solutions."""

import numpy as np
import pytest

from fingerdesign.contact.increment import ContactState, solve_increment
from fingerdesign.contact.path import follow, force_response
from fingerdesign.contact.problem import Motion

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
