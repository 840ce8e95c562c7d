"""The carried inverse against one made anew, whatever nodes came and went."""

import numpy as np
import pytest

from fingerdesign.contact.increment import ContactState, Workspace, solve_increment
from fingerdesign.contact.newton import ActiveInverse, dofs_of, inverse_of
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import reduced_model


def compliance_of(nodes, dim, seed=0):
    root = np.random.default_rng(seed).normal(size=(nodes * dim, nodes * dim))
    return root @ root.T / nodes + 0.2 * np.eye(nodes * dim)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("goal", [[0, 1, 2, 3, 4], [1, 2, 3, 9], [5, 6, 7], [0, 1, 2, 3, 4, 8]])
def test_moved_inverse_equals_a_new_one(dim, goal):
    compliance = compliance_of(12, dim)
    inverse = ActiveInverse.of(compliance, np.arange(5), dim)
    for nodes in (np.array([0, 1, 2, 3]), np.array([0, 2, 3, 4, 6]), np.array(goal)):
        inverse = inverse.moved_to(compliance, nodes, dim)
        assert set(inverse.nodes.tolist()) == set(nodes.tolist())
        dofs = dofs_of(inverse.nodes, dim)
        product = inverse.inverse @ compliance[np.ix_(dofs, dofs)]
        assert np.abs(product - np.eye(len(dofs))).max() < 1e-8


def test_a_workspace_changes_no_answer():
    """A path with a workspace gives the forces of one without, to rounding."""
    nodes, dim = 20, 3
    points = np.random.default_rng(1).uniform(-1, 1, (nodes, dim))
    points[:, 1] = -0.3 * (points[:, 0] ** 2 + points[:, 2] ** 2)
    model = reduced_model(points, compliance_of(nodes, dim, 2))
    problem = contact_problem(model, Plane(0.0), 0.4)
    workspace, one, other = Workspace(), *[ContactState.untouched(problem)] * 2
    for motion in [Motion(0.05 * k, 0.0) for k in range(1, 6)] + [
        Motion(0.25 - 0.02 * k, 0.04 * k) for k in range(1, 9)
    ]:
        carried = solve_increment(problem, one, motion, workspace)
        fresh = solve_increment(problem, other, motion)
        scale = np.abs(fresh.multiplier).max()
        assert np.abs(carried.multiplier - fresh.multiplier).max() <= 1e-8 * scale
        one, other = carried.state, fresh.state


@pytest.mark.parametrize("n", [1, 7, 100, 101, 350])
def test_the_inverse_by_halves(n):
    root = np.random.default_rng(n).normal(size=(n, n))
    matrix = root @ root.T + np.eye(n)
    inverse = inverse_of(matrix)
    assert np.abs(inverse @ matrix - np.eye(n)).max() < 1e-8
    assert np.abs(inverse - inverse.T).max() < 1e-12
