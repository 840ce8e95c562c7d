"""Rubber with a memory: decay, ramps, a growing contact, creep, and whose friction it is."""

import numpy as np
import pytest

from fingerdesign.contact.memory import Rubber
from fingerdesign.control.plants.lift import Disturbance, LiftPlant, Timed
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.plants.slide import Inertia
from fingerdesign.design.grip import GRAVITY

RATE = 100.0
SHARES, TIMES = (0.2, 0.1), (0.05, 0.6)
RUBBER = Rubber(SHARES, TIMES, 1.0 / RATE)
MASS = 200.0
WEIGHT = 1e-3 * GRAVITY * MASS


def left(seconds):
    """R(t)."""
    time = np.asarray(seconds, dtype=float)
    return 1.0 - sum(g * -np.expm1(-time / t) for g, t in zip(SHARES, TIMES, strict=True))


def gathered(seconds):
    """The integral of R from 0 to t, s."""
    time = np.asarray(seconds, dtype=float)
    terms = zip(SHARES, TIMES, strict=True)
    return time - sum(g * (time + t * np.expm1(-time / t)) for g, t in terms)


def standing(problem, rubber=RUBBER, opposite=None):
    """On a support that carries it all: a weight that no finger would lift."""
    return LiftPlant(problem, "upper", 1e4, opposite, timed=Timed(rubber=rubber))


@pytest.fixture(scope="module")
def sticky(half_plane):
    return half_plane.with_friction(50.0)


@pytest.mark.slow
def test_a_press_held_decays_by_the_series(half_plane):
    """Pressed within a move that is a hundredth of the shortest time; exactly after a ramp."""
    quick = Rubber(SHARES, TIMES, 5e-4)
    plant, elastic = standing(half_plane, quick), CondensedPlant(half_plane, "upper")
    first = plant.move(0.0, 0.05).normal_force
    whole = elastic.move(0.0, 0.05).normal_force
    forces = np.array([first, *(plant.move(0.0, 0.0).normal_force for _ in range(2000))])
    time = 5e-4 * np.arange(1, 2002)
    over_ramp = (gathered(time) - gathered(time - 5e-4)) / 5e-4
    # The force rises as the closing: evenly in the move, as far as its answer tells.
    assert forces == pytest.approx(whole * over_ramp, rel=1e-9)
    assert forces[400] == pytest.approx(whole * left(0.2), rel=2e-3)
    assert quick.left(0.2) == pytest.approx(float(left(0.2)))


def test_a_ramp_gives_the_integral_of_the_series(sticky):
    """All sticks, so that F_t rises evenly with the shear."""
    plant, elastic = standing(sticky), CondensedPlant(sticky, "upper")
    for each in (plant, elastic):
        each.move(0.0, 0.1)
    stiff = elastic.move(0.001, 0.0).tangential_force / 0.001
    forces = [plant.move(0.001, 0.0).tangential_force for _ in range(60)]
    time = np.arange(1, 61) / RATE
    assert forces == pytest.approx(stiff * 0.001 * RATE * gathered(time), rel=1e-7)


@pytest.mark.parametrize("like", [True, False])
def test_a_growing_contact_is_lee_and_radoks(half_plane, softer, like):
    """F(t) = integral R(t - s) dF_e(s) over the elastic answer at the same closing."""
    frictionless = [each.with_friction(0.0) for each in (half_plane, softer)]
    opposite = None if like else frictionless[1]
    plant = standing(frictionless[0], opposite=opposite)
    elastic = standing(frictionless[0], rubber=None, opposite=opposite)
    closings = 0.1 * (np.arange(1, 41) / 40.0) ** 2  # ever faster
    moves = np.diff(closings, prepend=0.0)
    forces = [plant.move(0.0, dy).normal_force for dy in moves]
    fresh = np.array([elastic.move(0.0, dy).normal_force for dy in moves])
    grown = np.diff(fresh, prepend=0.0)
    for k in (4, 19, 39):
        ages = (k + 1 - np.arange(k + 1)) / RATE
        shares = (gathered(ages) - gathered(ages - 1.0 / RATE)) * RATE
        assert forces[k] == pytest.approx(shares @ grown[: k + 1], rel=1e-7)


def test_finer_steps_come_to_the_convolution_of_the_path_itself(half_plane):
    """Closing at a constant speed, the force of a growing contact bends upward."""
    problem = half_plane.with_friction(0.0)

    def pressed(rate):
        plant = standing(problem, Rubber(SHARES, TIMES, 1.0 / rate))
        moves = round(0.2 * rate)
        for _ in range(moves):
            sample = plant.move(0.0, 0.1 / moves)
        return sample.normal_force

    coarse, middle, fine = (pressed(rate) for rate in (50.0, 100.0, 800.0))
    assert abs(middle - fine) < 0.3 * abs(coarse - fine)
    assert middle == pytest.approx(fine, rel=1e-3)


def test_where_it_is_let_go_the_dent_stays_for_a_while(half_plane):
    plant = standing(half_plane)
    plant.move(0.0, 0.1)
    for _ in range(200):
        plant.move(0.0, 0.0)
    sample = plant.move(0.0, -0.09)
    elastic = CondensedPlant(half_plane, "upper")
    assert sample.normal_force < 0.5 * elastic.move(0.0, 0.01).normal_force
    for _ in range(400):
        sample = plant.move(0.0, 0.0)
    back = elastic.truth().normal_force * float(left(1e6))
    assert sample.normal_force == pytest.approx(back, rel=0.02)


@pytest.mark.slow
def test_a_weight_that_hangs_creeps_as_such_rubber_does(sticky):
    """One time constant: J = (1 - g exp(-(1 - g) t / T)) / (1 - g), all sticking."""
    share, time = 0.25, 0.3
    own = Rubber((share,), (time,), 1.0 / RATE)
    plant = LiftPlant(sticky, "upper", MASS, timed=Timed(rubber=own))
    plant.move(0.0, 0.15)
    for _ in range(1000):  # what the press leaves is over
        plant.move(0.0, 0.0)
    plant.move(0.5, 0.0)
    assert plant.truth().lifted
    stuck = [plant.truth().shear]
    for _ in range(100):
        sample = plant.move(0.0, 0.0)
        assert 2.0 * sample.tangential_force == pytest.approx(WEIGHT, rel=1e-6)
        stuck.append(plant.truth().shear)
    passed = np.arange(101) / RATE + 0.5 / RATE  # in the middle of the move it came to hang
    creep = (1.0 - share * np.exp(-(1.0 - share) * passed / time)) / (1.0 - share)
    ways = np.array(stuck) / stuck[-1]
    assert ways == pytest.approx(creep / creep[-1], rel=3e-3)


def test_sliding_friction_is_that_of_the_forces_there_are(half_plane):
    """Not of fresh ones: pressed long ago, sheared now."""
    plant = standing(half_plane)
    plant.move(0.0, 0.1)
    for _ in range(300):
        plant.move(0.0, 0.0)
    for _ in range(5):
        sample = plant.move(0.1, 0.0)
    assert plant.truth().complete_slip
    assert sample.tangential_force == pytest.approx(0.5 * sample.normal_force, rel=1e-8)


def test_readings_follow_the_force(sticky):
    """Plates do not relax: what strains them is what they carry."""
    plant, elastic = standing(sticky), CondensedPlant(sticky, "upper")
    whole = elastic.move(0.0, 0.1)
    plant.move(0.0, 0.1)
    for _ in range(50):
        sample = plant.move(0.0, 0.0)
    share = sample.normal_force / whole.normal_force
    assert share < 0.8
    assert sample.readings == pytest.approx(share * whole.readings, rel=1e-7, abs=1e-9)


def test_a_grip_that_relaxes_lets_go_in_time_and_the_object_falls(half_plane):
    tugs = [Disturbance(5, 0.0)]
    timed = Timed(rubber=Rubber((0.5,), (0.5,), 1.0 / RATE), inertia=Inertia(RATE, 5.0))
    plant = LiftPlant(half_plane, "upper", MASS, disturbances=tugs, timed=timed)
    for _ in range(8):
        plant.move(0.0, 0.015)
    while not plant.truth().lifted:
        plant.move(0.005, 0.0)
    for k in range(40):
        plant.move(0.01 + 0.001 * k, 0.0)
    steps = 0
    while plant.truth().lifted:
        plant.move(0.05, 0.0)
        steps += 1
        assert steps < 1000
    now = plant.truth()
    assert (now.caught, now.complete_slip) == (False, True)
    assert now.slid > 5.0
    assert now.normal_force < WEIGHT


NO_RUBBER = [((0.5, 0.5), (1.0, 2.0)), ((0.1,), (0.0,)), ((-0.1,), (1.0,)), ((0.1,), ())]


@pytest.mark.parametrize(("shares", "times"), NO_RUBBER)
def test_rubber_that_cannot_be_is_refused(shares, times):
    with pytest.raises(ValueError, match="shares"):
        Rubber(shares, times, 0.01)
