"""What is tried when Newton stalls, the inverse that it carries along, and how many answers are."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign.contact.friction import Coulomb
from fingerdesign.contact.increment import ContactState, solve_increment
from fingerdesign.contact.laws import natural_residual
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.contact.solver import attempts as strategy
from fingerdesign.contact.solver import pivots
from fingerdesign.contact.solver.active_inverse import (
    ActiveInverse,
    ScratchBuffers,
    dofs_of,
    inverse_of,
)
from fingerdesign.contact.solver.attempts import Task, solve_task
from fingerdesign.contact.solver.gauss_seidel import gauss_seidel
from fingerdesign.contact.solver.newton import NewtonResult
from fingerdesign.contact.solver.pivots import friction_pivots
from fingerdesign.contact.uniqueness import _differ, other_solutions
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import reduced_model


def random_problem(m, dim, seed):
    """A random positive definite compliance and offset; some nodes pressed, some free."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(m * dim, m * dim))
    compliance = root @ root.T / m + 0.2 * np.eye(m * dim)
    offset = rng.normal(size=(m, dim))
    offset[0, 0] = -1.0
    return compliance, offset


def worst(compliance, offset, friction, force):
    motion = (compliance @ force.ravel()).reshape(force.shape) + offset
    residual = natural_residual(
        force, motion, np.diag(compliance)[:: force.shape[1]], Coulomb(friction)
    )
    return np.abs(residual).max() / np.abs(force).max()


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.5, 1.0, 2.0, 5.0, 50.0])
def test_pivots_always_find_an_answer(friction):
    """An answer exists for every friction coefficient, and the path leads to one."""
    for seed in range(40):
        compliance, offset = random_problem(10, 2, seed)
        found = friction_pivots(compliance, offset, Coulomb(friction))
        assert found.converged
        assert worst(compliance, offset, friction, found.multiplier) < 1e-9


def test_pivots_on_ties():
    """A mirrored problem, at whose start several nodes are in the same place at once."""
    m = 9
    x = np.linspace(-1.0, 1.0, m)
    compliance = np.kron(np.exp(-np.abs(x[:, None] - x[None, :])), np.eye(2))
    for offset in (np.full((m, 2), -1.0), np.column_stack([x**2 - 0.5, np.zeros(m)])):
        found = friction_pivots(compliance, offset, Coulomb(1.0))
        assert found.converged
        assert worst(compliance, offset, 1.0, found.multiplier) < 1e-9


@pytest.mark.parametrize("waiting", [1, 2, 7])
def test_exchanges_that_wait_change_no_answer(monkeypatch, waiting):
    """With one waiting exchange each is made at once; others end in the middle of a path."""
    problems = [
        (*random_problem(12, 2, seed), Coulomb(10.0 ** (0.1 * seed - 1.0))) for seed in range(20)
    ]
    found = [friction_pivots(*each) for each in problems]
    monkeypatch.setattr(pivots, "_WAITING", waiting)
    for one, each in zip(found, problems, strict=True):
        other = friction_pivots(*each)
        assert one.iterations == other.iterations
        np.testing.assert_allclose(one.multiplier, other.multiplier, rtol=0.0, atol=1e-12)


def test_pivots_that_run_out_say_so_and_nothing_touched_needs_no_force():
    compliance, offset = random_problem(10, 2, 1)
    found = friction_pivots(compliance, offset, Coulomb(0.5), limit=3)
    assert not found.converged
    assert not found.multiplier.any()
    offset[:, 0] = np.abs(offset[:, 0]) + 0.1
    found = friction_pivots(compliance, offset, Coulomb(1.0))
    assert found.converged
    assert not found.multiplier.any()


@dataclass(frozen=True)
class Stalling(Task):
    """A task on which Newton fails from the guess and from the last forces, by either factor."""

    calls: list[float] = field(default_factory=list)

    def newton(self, start, factor=0.05, most=40):
        self.calls.append(factor)
        if len(self.calls) <= 2:
            return NewtonResult(start, 1.0, 1, False)
        return super().newton(start, factor, most)

    def warm(self):
        return NewtonResult(self.guess, 1.0, 1, False)


@pytest.mark.parametrize("dim", [2, 3])
def test_every_way_leads_to_an_answer(dim):
    """With Newton from the guess and the last forces taken away, what comes next still solves."""
    for seed in range(10):
        compliance, offset = random_problem(8, dim, seed)
        task = Stalling(
            compliance, offset, np.ones((8, dim)), Coulomb(0.6), *2 * [np.zeros((8, dim))]
        )
        result, name = solve_task(task)
        assert result.converged
        assert name == ("pivots" if dim == 2 else "newton, walked")
        assert worst(compliance, offset, 0.6, result.multiplier) < 1e-9


@pytest.mark.parametrize("name", ["_raise_friction", "_sweep"])
def test_last_ways_alone(name):
    way = getattr(strategy, name)
    for seed in range(10):
        compliance, offset = random_problem(8, 3, seed)
        start = np.zeros((8, 3))
        task = Task(compliance, offset, np.ones((8, 3)), Coulomb(0.5), start, start)
        result = way(task, start) if name == "_raise_friction" else way(task, 300, start)
        assert result.converged
        assert worst(compliance, offset, 0.5, result.multiplier) < 1e-9


def test_gauss_seidel_stops_at_its_limits():
    """Neither sweeps nor seconds are exceeded, and an unfinished answer is not called one."""
    compliance, offset = random_problem(10, 3, 4)
    start = np.zeros((10, 3))
    few = gauss_seidel(compliance, offset, Coulomb(0.5), start, sweeps=3, tolerance=1e-14)
    assert (few.iterations, few.converged) == (3, False)
    short = gauss_seidel(
        compliance, offset, Coulomb(0.5), start, 10**6, tolerance=0.0, time_limit=0.05
    )
    assert not short.converged
    assert short.iterations < 10**6
    full = gauss_seidel(compliance, offset, Coulomb(0.5), start, 5000, tolerance=1e-11)
    assert full.converged
    assert worst(compliance, offset, 0.5, full.multiplier) < 1e-10


@pytest.mark.parametrize("block", [[[1.0, -3.0], [-3.0, 1.0]], [[-1.0, 0.0], [0.0, 1.0]]])
def test_gauss_seidel_ends_where_the_compliance_is_not_positive_definite(block):
    """As of a body that gives way under its contact forces: no overflow, no answer."""
    offset = np.array([[-1.0, 0.0], [-2.0, 0.0]])
    compliance = np.kron(block, np.eye(2))
    found = gauss_seidel(compliance, offset, Coulomb(0.5), np.ones((2, 2)), 5000)
    assert not found.converged
    assert found.iterations < 100
    assert np.isfinite(found.multiplier).all()


def compliance_of(nodes, dim, seed=0):
    root = np.random.default_rng(seed).normal(size=(nodes * dim, nodes * dim))
    return root @ root.T / nodes + 0.2 * np.eye(nodes * dim)


@pytest.mark.parametrize("room", [np.empty, ScratchBuffers(36, 2)])
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("goal", [[0, 1, 2, 3, 4], [1, 2, 3, 9], [5, 6, 7], [0, 1, 2, 3, 4, 8]])
def test_moved_inverse_equals_a_new_one(dim, goal, room):
    compliance = compliance_of(12, dim)
    inverse = ActiveInverse.of(compliance, np.arange(5), dim)
    for nodes in (np.array([0, 1, 2, 3]), np.array([0, 2, 3, 4, 6]), np.array(goal)):
        inverse = inverse.moved_to(compliance, nodes, dim, room)
        assert set(inverse.nodes.tolist()) == set(nodes.tolist())
        dofs = dofs_of(inverse.nodes, dim)
        product = inverse.inverse @ compliance[np.ix_(dofs, dofs)]
        assert np.abs(product - np.eye(len(dofs))).max() < 1e-8


def test_an_inverse_may_be_left_by_all_its_nodes():
    inverse = ActiveInverse.of(np.eye(6) + 0.1, np.arange(3), 2)
    none = inverse.restricted(np.zeros(3, dtype=bool), 2)
    assert none.nodes.size == 0
    assert none.inverse.shape == (0, 0)


def test_an_inverse_carried_far_stays_at_rounding():
    """Bordered seventeen times; where that is not symmetric to the last digit, none is left."""
    x, y = np.meshgrid(np.arange(12.0), np.arange(12.0))
    place = (x + 1j * y).reshape(-1) - 5.5 - 5.5j
    place = place[np.argsort(np.abs(place), kind="stable")]
    compliance = -np.log(np.abs(place[:, None] - place) / 40.0 + 0.008)
    inverse, room = ActiveInverse.of(compliance, np.arange(10), 1), ScratchBuffers(144, 2)
    for count in range(14, 145, 8):
        inverse = inverse.moved_to(compliance, np.arange(count), 1, room)
    product = inverse.inverse @ compliance[:count, :count]
    assert np.abs(product - np.eye(count)).max() < 1e-12


@pytest.mark.parametrize("n", [1, 7, 100, 101, 350])
def test_the_inverse_by_halves(n):
    root = np.random.default_rng(n).normal(size=(n, n))
    matrix = root @ root.T + np.eye(n)
    inverse = inverse_of(matrix)
    assert np.abs(inverse @ matrix - np.eye(n)).max() < 1e-8
    assert np.abs(inverse - inverse.T).max() < 1e-12


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


@pytest.mark.parametrize(("friction", "others"), [(0.3, 0), (1.0, 0), (2.0, 2)])
def test_a_wedged_node_has_another_answer(friction, others):
    """Drawn off by a little and sheared: open is lawful; wedged too where mu k > 1."""
    problem = one_node(friction)
    state = ContactState.untouched(problem)
    motion = Motion(-0.1, 0.2)
    known = solve_increment(problem, state, motion)
    found = other_solutions(problem, state, motion, known)
    assert len(found) == others
    for other in found:
        assert other.certificate.laws < 1e-8
        assert np.abs(other.multiplier - known.multiplier).max() > 1e-3
    # Sheared the other way there is nothing to wedge against.
    assert not other_solutions(problem, state, Motion(-0.1, -0.2))


def test_answers_differ_by_a_part_of_their_larger_force():
    known = SimpleNamespace(multiplier=np.array([[1000.0, 0.0], [2.0, 1.0]]))
    for change, other in ((0.009, False), (0.011, True), (-0.011, True)):
        moved = SimpleNamespace(multiplier=known.multiplier + np.diag([0.0, change]))
        assert _differ(known, moved) == _differ(moved, known) == other
