"""Several answers where friction is large, one where it is small."""

import numpy as np
import pytest

from fingerdesign.contact.increment import ContactState, solve_increment
from fingerdesign.contact.laws import OPEN, SLIP
from fingerdesign.contact.newton import ActiveInverse, classify, slip_system
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.contact.uniqueness import other_solutions
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import reduced_model

COUPLING = 0.9  # tangential motion per normal force over the normal motion: friction can wedge


def one_node(friction):
    """A node that drags sideways as it is pressed: Klarbring's example of several answers.

    C = [[1, k], [k, 1]], global axes; with mu k > 1 a jammed state and an open one are both lawful.
    """
    points = np.zeros((2, 2))
    points[1] = 10.0, -50.0  # out of reach
    compliance = np.eye(4)
    compliance[0, 1] = compliance[1, 0] = COUPLING
    return contact_problem(reduced_model(points, compliance), Plane(0.0), friction)


def solution_index(problem, increment):
    """Sign (1, -1) of the determinant of the laws linearised at an answer; 0 where singular.

    -1 proves that there are at least two more answers; 1 proves nothing. Signs at an answer where
    a node is just about to change its status are one-sided and may mislead.
    """
    dim = problem.shape[1]
    motion = np.column_stack([increment.gap, increment.slip_increment])
    rho = (0.05 / problem.self_compliance)[:, None]
    friction = problem.friction_coefficient
    status, trial = classify(increment.multiplier, motion, rho, friction)
    closed = np.flatnonzero(status != OPEN)
    if not len(closed):
        return 1
    inverse = ActiveInverse.of(problem.compliance, closed, dim)
    sliding = np.flatnonzero(status[inverse.nodes] == SLIP)
    if not len(sliding):
        return 1
    # The closed nodes' compliance is positive definite: the sign is that of the slips' system.
    system = slip_system(friction, trial, rho, increment.multiplier, inverse, sliding)
    return int(np.linalg.slogdet(system.matrix)[0])


@pytest.mark.parametrize(("friction", "several"), [(0.3, False), (1.0, False), (2.0, True)])
def test_a_wedged_node_has_another_answer(friction, several):
    """Drawn off by a little and sheared: open is lawful; wedged too where mu k > 1."""
    problem = one_node(friction)
    state = ContactState.untouched(problem)
    motion = Motion(-0.1, 0.2)
    known = solve_increment(problem, state, motion)
    others = other_solutions(problem, state, motion, known)
    for other in others:
        assert other.certificate.laws < 1e-8
        assert np.abs(other.multiplier - known.multiplier).max() > 1e-3
    indices = [solution_index(problem, each) for each in (known, *others)]
    assert sorted(indices) == ([-1, 1, 1] if several else [1])
    # Sheared the other way there is nothing to wedge against.
    assert not other_solutions(problem, state, Motion(-0.1, -0.2))
