"""The contact engine on seeded random compliances and small layers: laws, certificate, failures.

No CAD, mesh or finite elements here: numpy alone.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fingerdesign.contact.friction import Coulomb
from fingerdesign.contact.increment import ContactState, solve_increment
from fingerdesign.contact.laws import OPEN, SLIP, Certificate, certify
from fingerdesign.contact.measures import completely_slips
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.contact.solver.newton import newton
from fingerdesign.errors import SolverError
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import reduced_model


def random_model(m, dim, seed, contrast=1.0):
    """Random symmetric positive definite compliance under a parabolic crest at y = 0."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(m * dim, m * dim)) * contrast ** rng.uniform(-0.5, 0.5, m * dim)
    compliance = root @ root.T / m + 0.2 * np.eye(m * dim)
    points = np.zeros((m, dim))
    points[:, 0] = np.linspace(-1, 1, m)
    if dim == 3:
        points[:, 2] = rng.uniform(-0.5, 0.5, m)
    points[:, 1] = -0.3 * (points**2).sum(axis=1)
    return reduced_model(points, compliance)


def half_plane(m=41, width=2.0, radius=10.0):
    """Springs coupled by a smooth kernel: a stand-in for an elastic layer, decoupled n and t."""
    x = np.linspace(-width, width, m)
    kernel = np.exp(-np.abs(x[:, None] - x[None, :]) / 0.4) / m
    points = np.column_stack([x, -(x**2) / (2 * radius)])
    return reduced_model(points, np.kron(kernel, np.eye(2)))


def assert_laws(increment, friction):
    normal, gap = increment.multiplier[:, 0], increment.gap
    tangential, slip = increment.multiplier[:, 1:], increment.slip_increment
    scale = max(normal.max(), 1e-12)
    length = max(np.abs(gap).max(), np.abs(slip).max(), 0.1)
    assert normal.min() >= -1e-9 * scale
    assert gap.min() >= -1e-8 * length
    assert np.abs(normal * gap).max() <= 1e-8 * scale * length
    size = np.linalg.norm(tangential, axis=1)
    assert (size <= friction * np.maximum(normal, 0) + 1e-8 * scale).all()
    power = np.sum(tangential * slip, axis=1)
    assert power.max() <= 1e-8 * scale * length  # friction takes energy out
    moving = (np.linalg.norm(slip, axis=1) > 1e-6 * length) & (normal > 1e-6 * scale)
    full = friction * normal[moving] * np.linalg.norm(slip[moving], axis=1)
    assert np.allclose(power[moving], -full, rtol=1e-5, atol=1e-8 * scale * length)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    dim=st.sampled_from([2, 3]),
    friction=st.sampled_from([0.0, 0.05, 0.3, 0.6, 1.0]),
    shear=st.floats(-1.0, 1.0),
)
def test_laws_hold_on_random_compliances(seed, dim, friction, shear):
    model = random_model(8, dim, seed)
    problem = contact_problem(model, Plane(0.0), friction)
    state = ContactState.untouched(problem)
    for motion in (Motion(0.3, 0.0), Motion(0.4, shear), Motion(0.2, -shear), Motion(-0.1, 0.0)):
        increment = solve_increment(problem, state, motion)
        assert_laws(increment, friction)
        state = increment.state
    assert (increment.status == OPEN).all()  # drawn off beyond touch: nothing is left
    assert not increment.multiplier.any()


def test_what_cannot_be_solved_is_an_error_with_a_reason():
    """Nodes that no force pushes away: the last iterate is not returned as an answer."""
    model = half_plane()
    problem = contact_problem(replace(model, compliance=-model.compliance), Plane(0.0), 0.3)
    with pytest.raises(SolverError, match="no accepted answer at approach"):
        solve_increment(problem, ContactState.untouched(problem), Motion(0.05, 0.02))


def test_newton_counts_its_steps_from_one():
    offset, answer = np.array([[-1.0, 0.2]]), np.array([[1.0, -0.2]])  # it sticks
    assert newton(np.eye(2), offset, Coulomb(0.5), answer).iterations == 1
    assert (
        newton(np.eye(2), offset, Coulomb(0.5), np.zeros((1, 2)), max_iterations=1).iterations == 1
    )


def test_motions_and_frictions_that_cannot_be_are_refused():
    problem = contact_problem(half_plane(), Plane(0.0), 0.3)
    with pytest.raises(SolverError, match="not finite"):
        solve_increment(problem, ContactState.untouched(problem), Motion(np.nan, 0.0))
    for friction in (-0.1, np.nan, np.inf):
        with pytest.raises(ValueError, match="friction coefficient"):
            contact_problem(half_plane(), Plane(0.0), friction)


@pytest.mark.parametrize("shear", [0.012, 1.0])
def test_standing_still_changes_nothing(shear):
    """The same row again gives the same stick ratio, in partial and in complete slip."""
    problem = contact_problem(half_plane(81), Plane(0.0), 0.3)
    rows = [Motion(0.05, 0.0)] + [Motion(0.05, shear)] * 4
    steps = list(follow(problem, rows))
    first = steps[1].measures
    for step in steps[2:]:
        assert step.measures.stick_ratio == pytest.approx(first.stick_ratio, abs=1e-9)
        assert step.measures.slip_nodes == first.slip_nodes
        assert completely_slips(step.measures, 2) == completely_slips(first, 2)
        assert step.measures.slip_distance == pytest.approx(first.slip_distance, rel=1e-9)


def test_complete_slip_carries_mu_fn_and_the_slip_distance_is_the_least_over_the_contact():
    """0 as long as one node in contact sticks; once all slide, each more mm of shear adds one."""
    problem = contact_problem(half_plane(81), Plane(0.0), 0.3)
    steps = list(follow(problem, [Motion(0.05, shear) for shear in (0.0, 0.012, 1.0, 1.5)]))
    partial, late, later = [step.measures for step in steps[1:]]
    assert 0.0 < partial.stick_ratio < 1.0
    assert partial.slip_distance == 0.0
    assert late.tangential_force == pytest.approx(0.3 * late.normal_force, rel=1e-9)
    assert completely_slips(late, 2)
    assert (late.stick_ratio, late.stick_nodes) == (0.0, 0)
    assert set(steps[2].increment.status) == {OPEN, SLIP}
    assert 0.0 < late.slip_distance < 1.0
    assert later.slip_distance - late.slip_distance == pytest.approx(0.5, rel=1e-6)


FRICTION, COMPLIANCE = 0.5, 0.01
# A node that sticks, one that slips against its force, one that is open.
FORCES = np.array([[2.0, 0.4, 0.0], [4.0, -2.0, 0.0], [0.0, 0.0, 0.0]])  # N
MOTION = np.array([[0.0, 0.0, 0.0], [0.0, 0.03, 0.0], [0.02, 0.1, 0.0]])  # mm


def of(node, part, force=None, motion=None):
    """The certificate with one entry of the forces or of the motion changed."""
    forces, moved = FORCES.copy(), MOTION.copy()
    if force is not None:
        forces[node, part] = force
    if motion is not None:
        moved[node, part] = motion
    total = np.array([1.0, -6.0, 0.0])
    return certify(forces, moved, COMPLIANCE, Coulomb(FRICTION), -total, total)


def test_the_laws_hold_or_forces_do_not_balance_or_there_is_no_number():
    assert of(0, 0, force=2.0).laws < 1e-12
    found = certify(
        FORCES, MOTION, COMPLIANCE, Coulomb(FRICTION), np.zeros(3), np.array([0.0, -0.6, 0.0])
    )
    assert found.balance == pytest.approx(0.1)
    assert of(0, 0, force=np.nan) == Certificate(*4 * [np.inf])


@pytest.mark.parametrize(
    ("changed", "law", "violation"),
    [
        ({"node": 2, "part": 0, "force": -0.4}, "complementarity", 0.4 / 4.0),
        ({"node": 2, "part": 0, "motion": -0.01}, "complementarity", 0.01 / (4.0 * COMPLIANCE)),
        ({"node": 0, "part": 0, "motion": 0.01}, "complementarity", 0.01 / (4.0 * COMPLIANCE)),
        ({"node": 0, "part": 1, "force": 1.8}, "coulomb", 0.8 / 4.0),
        ({"node": 0, "part": 2, "motion": 0.08}, "dissipation", 1.0 / 4.0),  # slips below its bound
        ({"node": 1, "part": 1, "motion": -0.08}, "dissipation", 2 * 2.0 / 4.0),  # along its force
    ],
)
def test_each_part_sees_its_violation(changed, law, violation):
    found = of(**changed)
    assert getattr(found, law) == pytest.approx(violation)
    assert found.laws >= violation * (1.0 - 1e-12)


def test_unloading_and_reversal():
    """Reversed shear slips back from the edge; pulled off, nothing is left."""
    problem = contact_problem(half_plane(), Plane(0.0), 0.3)
    path = [(0.05, 0.0), (0.05, 0.02), (0.05, 0.0), (0.05, -0.02), (0.02, -0.02), (-0.01, 0.0)]
    steps = list(follow(problem, [Motion(a, b) for a, b in path]))
    ft = [s.measures.tangential_force for s in steps]
    assert ft[1] > 0 > ft[3]
    assert abs(ft[2]) < ft[1]  # hysteresis: not back to zero, but less
    assert steps[-1].measures.stick_ratio is None
    assert steps[-1].measures.normal_force == 0.0


def test_stick_area_falls_smoothly_under_shear():
    problem = contact_problem(half_plane(161), Plane(0.0), 0.3)
    motions = [Motion(0.05, 0.0)] + [Motion(0.05, s) for s in np.linspace(0.001, 0.03, 30)]
    ratios = [s.measures.stick_ratio for s in follow(problem, motions)]
    assert ratios[0] == pytest.approx(1.0)
    steps = -np.diff([ratio for ratio in ratios if ratio > 0.2])
    # Counting nodes would stand still and jump by a node's share, 1/50 here.
    assert len(steps) > 10
    assert steps.min() > 0.01
    assert steps.max() < 0.1
