"""Friction bounds that depend on the pressure: laws, solvers, and answers known in closed form."""

import numpy as np
import pytest

from fingerdesign.contact.force_control import Forces, NoEquilibrium, solve_forces
from fingerdesign.contact.friction import Coulomb
from fingerdesign.contact.gross_slip import coefficient_under, meeting, sliding
from fingerdesign.contact.increment import Workspace, solve_increment
from fingerdesign.contact.measures import measure
from fingerdesign.contact.problem import ContactState, Motion, contact_problem
from fingerdesign.contact.solver import kernel
from fingerdesign.contact.solver.attempts import Task, solve_task
from fingerdesign.contact.tangent import stiffness
from fingerdesign.contact.uniqueness import other_solutions
from fingerdesign.shapes.friction import STEEPEST, FrictionLaw
from fingerdesign.shapes.objects import Cylinder, Plane
from tests.contact.conftest import SCALED
from tests.support.half_space import half_plane, quarter_sphere
from tests.support.reduced import followed, reduced_model

# Of a mean pressure of about one where random problems press.
LAWS = {
    "capped": FrictionLaw(0.3, 0.1, cap=0.35),
    "shear strength": FrictionLaw(0.0, 0.3),
    "power": FrictionLaw(0.4, exponent=1.0 / 3.0, reference=1.0),
}
GRIP = [
    *(Motion(0.003 * k, 0.0) for k in range(1, 8)),
    *(Motion(0.021, 0.004 * k) for k in range(1, 6)),
    *(Motion(0.021, 0.02 - 0.006 * k) for k in range(1, 7)),
    Motion(0.012, -0.016),
    Motion(-0.001, -0.016),
]


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_bound_is_continuous_concave_and_its_slope_is_its_derivative(law):
    pressure = np.geomspace(1e-7, 10.0, 4001)
    bound, slope = law.bound(pressure), law.slope(pressure)
    assert law.bound(np.zeros(1)) == 0.0
    assert (bound <= STEEPEST * pressure * (1.0 + 1e-12)).all()
    assert (np.diff(bound) >= -1e-15).all()
    assert (np.diff(slope) <= 1e-12).all()
    middle = np.sqrt(pressure[1:] * pressure[:-1])
    chord = np.diff(bound) / np.diff(pressure)
    corner = slope[:-1] - slope[1:] > 0.02 * slope[:-1]
    assert corner.sum() <= 2
    np.testing.assert_allclose(chord[~corner], law.slope(middle)[~corner], rtol=1e-4, atol=1e-9)
    areas = np.array([0.5, 2.0, 3.0])
    normal = np.array([0.1, 1.0, 4.0])
    np.testing.assert_allclose(law.bound(normal, areas), areas * law.bound(normal / areas))
    np.testing.assert_allclose(law.slope(normal, areas), law.slope(normal / areas))


def test_laws_without_their_own_numbers_are_coulombs_to_the_last_digit():
    normal = np.random.default_rng(0).uniform(0.0, 3.0, 50)
    for law in (FrictionLaw(0.37), FrictionLaw(0.37, exponent=0.0, reference=0.2)):
        assert law.is_coulomb
        assert np.array_equal(law.bound(normal, 0.7), 0.37 * normal)


@pytest.mark.parametrize(
    "given",
    [
        {"coefficient": -0.1},
        {"coefficient": np.nan},
        {"coefficient": 0.3, "strength": -1.0},
        {"coefficient": 0.3, "strength": np.inf},
        {"coefficient": 0.3, "cap": 0.0},
        {"coefficient": 0.3, "cap": np.nan},
        {"coefficient": 0.3, "exponent": 1.0},
        {"coefficient": 0.3, "exponent": 0.5, "reference": 0.0},
        {"coefficient": 2.0 * STEEPEST, "strength": 0.1},
    ],
)
def test_numbers_that_cannot_be_are_refused(given):
    with pytest.raises(ValueError, match="coefficient"):
        FrictionLaw(**given)


def random_finger(seed, dim, nodes=12):
    """A random positive definite compliance, pressed at about one MPa; areas of all sizes."""
    rng = np.random.default_rng([42, seed])
    root = rng.normal(size=(nodes * dim, nodes * dim))
    areas = rng.uniform(0.2, 2.0, nodes)
    points = np.zeros((nodes, dim))
    points[:, 0], points[:, 1] = np.arange(nodes), -0.3 * rng.uniform(size=nodes)
    compliance = root @ root.T / (nodes * dim) + 0.2 * np.eye(nodes * dim)
    return reduced_model(points, compliance, areas=areas)


def forces_of_slip(problem, approach):
    """(F_n, F_t) N of the whole finger as all slides."""
    force = problem.model.total_force(sliding(problem, approach).force)
    return -force[1], force[0]


def violation(problem, increment):
    """The worst of Signorini's and the friction law's violations, of force and length scales."""
    law, areas = problem.law, problem.model.areas
    normal, drag = increment.multiplier[:, 0], increment.multiplier[:, 1:]
    slip = increment.slip_increment
    force = normal.max()
    length = force * problem.typical_compliance
    bound = areas * np.minimum(
        np.minimum(STEEPEST * normal / areas, law.cap),
        law.strength
        + law.coefficient * law.reference**law.exponent * (normal / areas) ** (1.0 - law.exponent),
    )
    power = np.sum(drag * slip, axis=1) + bound * np.linalg.norm(slip, axis=1)
    return max(
        -normal.min() / force,
        -increment.gap.min() / length,
        np.abs(normal * increment.gap).max() / (force * length),
        (np.linalg.norm(drag, axis=1) - bound).max() / force,
        np.abs(power).max() / (force * length),
    )


@pytest.mark.parametrize("seeds", [range(8), pytest.param(range(8, 25), marks=pytest.mark.slow)])
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_laws_hold_on_random_compliances(law, dim, seeds):
    for seed in seeds:
        problem = contact_problem(random_finger(seed, dim), Plane(0.0), law)
        rows = [Motion(1.0, 0.0), Motion(1.0, 0.7), Motion(1.3, -1.0), Motion(0.7, 2.0)]
        for increment in followed(problem, rows):
            assert violation(problem, increment) < 1e-8
            assert increment.certificate.laws < 1e-8


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_the_attempts_by_coulombs_law_lead_to_an_answer(law, dim):
    """With Newton from guess and last forces taken away, what comes next still solves."""
    solved = 0
    for seed in range(10):
        model = random_finger(seed, dim)
        problem = contact_problem(model, Plane(0.0), law)
        start = ContactState.untouched(problem)
        offset = problem.offset(Motion(1.0, 0.8), start.slip)
        none = np.zeros_like(offset)

        class Stalling(Task):
            """Newton does not converge but from an answer of Coulomb's law."""

            def newton(self, first, factor=0.05, most=40):
                found = super().newton(first, factor, most)
                from_nothing = not (isinstance(self.friction, Coulomb) or first.any())
                return found if not from_nothing else type(found)(first, 1.0, 1, False)

            def warm(self):
                return self.newton(self.guess * 0.0)

        result, name = solve_task(
            Stalling(problem.compliance, offset, offset, problem.friction, none, none)
        )
        assert result.converged
        solved += name == "coulomb, newton"
    assert solved == 10


@pytest.mark.parametrize("shape", ["strip", "patch"])
@pytest.mark.parametrize("law", SCALED.values(), ids=SCALED)
def test_the_kernel_follows_as_numpy_does(shape, law, request):
    if kernel.kernel() is None:
        pytest.skip("no C compiler on this machine")
    problem = request.getfixturevalue(shape).with_friction(law)
    mine = list(followed(problem, GRIP))
    request.getfixturevalue("numpy_alone")
    for one, other in zip(mine, followed(problem, GRIP), strict=True):
        scale = max(float(np.abs(other.multiplier).max()), 1e-12)
        # Newton ends at residuals of 1e-10 of the largest force, in both.
        np.testing.assert_allclose(one.multiplier, other.multiplier, atol=1e-9 * scale, rtol=0.0)
        assert np.array_equal(one.status, other.status)


@pytest.mark.parametrize("law", SCALED.values(), ids=SCALED)
def test_tracked_increments_are_those_solved_again(law, patch):
    problem = patch.with_friction(law)
    again = followed(problem, GRIP, Workspace(follows=False))
    for one, other in zip(followed(problem, GRIP), again, strict=True):
        scale = max(float(np.abs(other.multiplier).max()), 1e-12)
        assert np.abs(one.multiplier - other.multiplier).max() <= 1e-8 * scale


@pytest.mark.parametrize("shape", ["strip", "patch"])
@pytest.mark.parametrize("law", SCALED.values(), ids=SCALED)
def test_the_tangent_is_the_derivative_of_the_forces(shape, law, request):
    problem = request.getfixturevalue(shape).with_friction(law)
    *_, before, last = followed(problem, GRIP[:10])
    ways = np.eye(2) * 1e-7
    known = stiffness(problem, last)

    def forces(approach, shear):
        there = Motion(last.motion.approach + approach, last.motion.shear + shear)
        found = solve_increment(problem, before.state, there)
        total = problem.model.total_force(found.force)
        return np.array([-total[1], total[0]])

    found = np.array([(forces(*way) - forces(*-way)) / 2e-7 for way in ways]).T
    assert np.abs(known - found).max() < 1e-4 * np.abs(found).max()


@pytest.mark.parametrize("law", SCALED.values(), ids=SCALED)
def test_force_control_meets_its_forces_and_names_what_the_law_carries(law, strip):
    problem = strip.with_friction(law)
    start, held = ContactState.untouched(problem), Workspace()
    pressed = solve_forces(problem, start, Forces(0.04, 0.0), held)
    normal, most = forces_of_slip(problem, pressed.motion.approach)
    assert normal == pytest.approx(0.04, rel=1e-6)  # this half-plane uncouples
    pulled = solve_forces(problem, pressed.state, Forces(0.04, 0.9 * most), held)
    assert problem.model.total_force(pulled.force)[0] == pytest.approx(0.9 * most, abs=1e-10)
    with pytest.raises(NoEquilibrium, match=f"carries {most:.4g} N"):
        solve_forces(problem, pulled.state, Forces(0.04, 1.1 * most), held)


def test_friction_of_a_law_has_no_coefficient(strip):
    with pytest.raises(Exception, match="Coulomb"):
        _ = strip.with_friction(SCALED["power"]).friction_coefficient


RADIUS = 50.0


@pytest.fixture(scope="module")
def cylinder():
    """A cylinder on 400 cells; the contact is 316 of them wide."""
    return contact_problem(half_plane(1.0, 400, RADIUS), Plane(0.0), 0.0)


def test_stick_in_the_plane_at_constant_shear_strength(cylinder):
    """c / a = sqrt(1 - (Q / 2 a tau0)^2), and q of the stick region in closed form.

    A rigid shear of a strip |x| < b needs q_b = 1 / (pi sqrt(b^2 - x^2)) per unit of force and
    moves all of it alike. So q = integral over b from c to a of w(b) / sqrt(b^2 - x^2) moves
    |x| < c alike; that it is tau0 at c < |x| < a is Abel's equation, which w = (2 tau0 / pi)
    b / sqrt(a^2 - b^2) solves. Then for |x| < c

        q = (2 tau0 / pi) arctan sqrt((a^2 - c^2) / (c^2 - x^2)),
        Q = pi times the integral of w from c to a = 2 tau0 sqrt(a^2 - c^2).

    A cell is 1/158 of a, and a border may be off by one. Rows beyond 0.95 of complete slip are left
    out: there an error of Q counts over three times in c (at 0.967 the row is off by 0.0101).
    """
    approach = 0.03
    free = solve_increment(cylinder, ContactState.untouched(cylinder), Motion(approach, 0.0))
    force = free.multiplier[:, 0].sum()
    half = np.sqrt(4.0 * force * RADIUS / np.pi)
    strength = 0.3 * 2.0 * force / (np.pi * half)
    problem = cylinder.with_friction(FrictionLaw(0.0, strength))
    rows = [Motion(approach, 0.0), *(Motion(approach, 0.0015 * k) for k in range(1, 12))]
    x, h = problem.model.points[:, 0], problem.model.areas[0]
    checked = 0
    for increment in followed(problem, rows):
        found = measure(problem, increment)
        share = found.tangential_force / (2.0 * half * strength)
        if not 0.2 < share < 0.95:
            continue
        checked += 1
        stick = np.sqrt(1.0 - share**2)
        assert found.contact_width == pytest.approx(2.0 * half, abs=2.0 * h)
        assert found.stick_ratio == pytest.approx(stick, abs=0.01)
        inner = np.abs(x) < stick * half - 2.0 * h
        inside = (stick * half) ** 2 - x[inner] ** 2
        known = 2.0 * strength / np.pi * np.arctan(np.sqrt(half**2 * share**2 / inside))
        drag = np.abs(increment.force[inner, 0]) / h
        assert np.abs(drag - known).max() < 0.02 * strength
    assert checked >= 4


@pytest.fixture(scope="module")
def sphere():
    """A sphere on a quarter of 30 x 30 cells."""
    return contact_problem(quarter_sphere(1.0, 30, RADIUS), Plane(0.0), 0.0)


def slipping(problem, half_widths):
    """Forces (loads, 2) of complete slip at approaches a^2 / R of Hertz."""
    return np.array([forces_of_slip(problem, a**2 / RADIUS) for a in half_widths])


def exponent(forces):
    """Of the ratio F_t / F_n in the load F_n."""
    normal, tangential = forces.T
    return np.polyfit(np.log(normal), np.log(tangential / normal), 1)[0]


HALF_WIDTHS = np.linspace(0.40, 0.93, 12)
MIDDLE = 2.0 * 0.65 / (np.pi * RADIUS)  # Hertz's peak pressure at a = 0.65, E* = 1


@pytest.mark.slow
def test_a_sphere_at_constant_shear_strength_slips_at_a_ratio_of_load_to_the_minus_third(sphere):
    """F_t = tau0 pi a^2 with a^3 = 3 F_n R / 4 E*: F_t / F_n goes with F_n^(-1/3)."""
    strength = 0.2 * MIDDLE
    forces = slipping(sphere.with_friction(FrictionLaw(0.0, strength)), HALF_WIDTHS)
    assert exponent(forces) == pytest.approx(-1.0 / 3.0, abs=0.005)
    area = 0.25 * np.pi * np.cbrt(3.0 * forces[:, 0] * RADIUS) ** 2  # a^3 = 3 (4 F_n) R / 4
    np.testing.assert_allclose(forces[:, 1] / (strength * area), 1.0, atol=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("power", [0.3, 0.6])
def test_a_sphere_with_a_power_law_slips_at_a_ratio_of_load_to_a_third_of_its_exponent(
    sphere, power
):
    """With p = pm sqrt(1 - r^2 / a^2): F_t / F_n = 3 / (3 - n) mu (p0 / pm)^n, pm ~ F_n^(1/3)."""
    law = FrictionLaw(0.3, exponent=power, reference=MIDDLE)
    forces = slipping(sphere.with_friction(law), HALF_WIDTHS)
    assert exponent(forces) == pytest.approx(-power / 3.0, abs=0.005)
    peak = 2.0 / (np.pi * RADIUS) * np.cbrt(3.0 * forces[:, 0] * RADIUS)
    known = 3.0 / (3.0 - power) * 0.3 * (MIDDLE / peak) ** power
    np.testing.assert_allclose(forces[:, 1] / forces[:, 0], known, rtol=0.01)


def test_a_flat_end_slips_at_the_power_laws_own_exponent():
    """Alike springs are pressed alike: F_t / F_n = mu (p / p0)^-n exactly."""
    points = np.column_stack([np.arange(5.0), np.zeros(5)])
    model = reduced_model(points, np.eye(10), areas=np.full(5, 2.0))
    problem = contact_problem(model, Plane(0.0), FrictionLaw(0.3, exponent=0.31, reference=0.1))
    for approach in (0.1, 1.0):
        normal, tangential = forces_of_slip(problem, approach)
        known = 0.3 * (normal / 10.0 / 0.1) ** -0.31
        assert tangential / normal == pytest.approx(known, rel=1e-9)
        assert coefficient_under(problem, tangential) == pytest.approx(known, rel=1e-6)


@pytest.mark.parametrize("lean", [-0.1, 0.1])
def test_a_leaning_flat_end_slips_at_its_friction_and_its_lean(lean):
    """On each spring N presses and mu N drags along the plane, mu = 0.3 (p / p0)^-n: exact."""
    along = np.array([np.cos(lean), np.sin(lean)])
    model = reduced_model(np.outer(np.arange(5.0), along), np.eye(10), areas=np.full(5, 2.0))
    plane = Plane(0.0, direction=(np.sin(lean), -np.cos(lean), 0.0))
    problem = contact_problem(model, plane, FrictionLaw(0.3, exponent=0.31, reference=0.1))
    for pressure in (0.05, 0.5):
        friction = np.arctan(0.3 * (pressure / 0.1) ** -0.31)
        weight = 5 * 2.0 * pressure * np.sin(friction + lean) / np.cos(friction)
        known = np.tan(friction + lean)
        assert coefficient_under(problem, weight) == pytest.approx(known, rel=1e-6)


def test_a_round_object_slips_as_a_drag_in_small_steps_finds_it(patch):
    """By presses; the drag moves the contact, and with it the ratio by some hundredths."""
    law = FrictionLaw(0.3, exponent=0.5, reference=0.1)
    problem = contact_problem(patch.model, Cylinder(60.0, radius=60.0), law)
    ratio = coefficient_under(problem, 0.03)
    workspace, state, approach = Workspace(), ContactState.untouched(problem), 0.0
    while True:
        found = solve_increment(problem, state, Motion(approach, 0.0), workspace)
        _, pulled = problem.carried_sliding(found.multiplier[:, 0])
        if pulled >= 0.03:
            break
        state, approach = found.state, approach + 0.001
    while not (found.state.sliding[found.multiplier[:, 0] > 0.0] > 0.0).all():
        motion = Motion(approach, found.motion.shear + 0.001)
        found = solve_increment(problem, found.state, motion, workspace)
    force = problem.model.total_force(found.force)
    assert ratio == pytest.approx(float(force[0] / -force[1]), rel=0.05)


def test_a_law_meets_a_coefficient_at_a_force(patch):
    """Exactly under a flat end, whose friction goes with (F_n / F)^-n from there."""
    points = np.column_stack([np.arange(5.0), np.zeros(5)])
    flat = contact_problem(
        reduced_model(points, np.eye(10), areas=np.full(5, 2.0)),
        Plane(0.0),
        FrictionLaw(0.9, exponent=0.31),
    )
    problem = meeting(flat, 0.3, 4.0)
    assert (problem.law.coefficient, problem.law.exponent) == (0.3, 0.31)
    for approach in (0.1, 0.8, 2.0):
        normal, tangential = forces_of_slip(problem, approach)
        assert tangential / normal == pytest.approx(0.3 * (normal / 4.0) ** -0.31, rel=1e-6)
    assert meeting(patch, 0.3, 2.0).law == FrictionLaw(0.3)


@pytest.mark.parametrize(("coefficient", "others"), [(0.3, 0), (2.0, 2)])
def test_a_wedged_node_has_other_answers_under_a_law_too(coefficient, others):
    """C = [[1, k], [k, 1]], k = 0.9: several answers where the slope of the bound is over 1 / k."""
    compliance = np.array([[1.0, -0.9], [-0.9, 1.0]])
    model = reduced_model(np.zeros((1, 2)), compliance, facets=np.zeros((0, 2), dtype=int))
    problem = contact_problem(model, Plane(0.0), FrictionLaw(coefficient, cap=50.0))
    start, motion = ContactState.untouched(problem), Motion(-0.05, -0.1)
    found = other_solutions(problem, start, motion)
    assert len(found) == others
    assert all(each.certificate.laws < 1e-8 for each in found)
