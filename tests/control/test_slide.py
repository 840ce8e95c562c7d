"""An object with inertia: free fall, sliding, caught or dropped; what holds is as without."""

import numpy as np
import pytest

from fingerdesign.control.plants.lift import Disturbance, LiftPlant, Timed
from fingerdesign.control.plants.plant import press
from fingerdesign.control.plants.slide import Inertia, frequency, slide
from fingerdesign.design.grip import GRAVITY, WeightChange

MASS = 200.0
RATE = 1000.0
WEIGHT = 1e-3 * GRAVITY * MASS


def hanging(problem, disturbances=(), opposite=None, drop=50.0, kinetic=1.0):
    """Held so that friction carries 1.3 times the weight, and raised clear of the support."""
    timed = Timed(inertia=Inertia(RATE, drop))
    plant = LiftPlant(problem, "upper", MASS, opposite, disturbances, timed, kinetic)
    low, high = 0.0, 0.2
    for _ in range(40):  # how far to close
        middle = 0.5 * (low + high)
        trial = LiftPlant(problem, "upper", MASS, opposite)
        list(press(trial, middle, 0.02))
        low, high = (middle, high) if friction(trial) < 1.3 * WEIGHT else (low, middle)
    list(press(plant, high, 0.02))
    while not plant.truth().lifted:
        plant.move(0.001, 0.0)
    return raise_clear(plant, 0.5)


def raise_clear(plant, height):
    """Up by ``height`` mm and more, speeding up and slowing down by 0.5 m/s^2; then at rest."""
    step = 0.5e3 / RATE**2
    moves = int(np.sqrt(height / step)) + 1
    for move in [*range(moves), *range(moves, -1, -1)]:
        plant.move(step * move, 0.0)
    plant.move(0.0, 0.0)
    return plant


def friction(plant):
    return 2.0 * 0.5 * plant.truth().normal_force


@pytest.mark.parametrize(
    ("speed", "first", "last"), [(5.0, -900.0, -300.0), (5.0, -200.0, -2000.0), (0.0, 50.0, -400.0)]
)
def test_the_motion_is_that_of_a_force_that_changes_evenly(speed, first, last):
    """Against small steps of the same equation."""
    whole, count = 0.02, 200_000
    time = (np.arange(count) + 0.5) * whole / count
    gained = np.cumsum(first + (last - first) * time / whole) * whole / count
    path = np.maximum(speed + gained, 0.0)
    ends = np.flatnonzero(speed + gained <= 0.0)
    stop = count if not len(ends) else int(ends[0])
    found = slide(speed, first, last, whole)
    assert found.way == pytest.approx(path[:stop].sum() * whole / count, rel=1e-4)
    assert (found.caught is None) == (not len(ends))
    if found.caught is not None:
        assert found.caught == pytest.approx(stop * whole / count, rel=1e-3)
    else:
        assert found.speed == pytest.approx(path[-1], rel=1e-4)


def test_what_is_held_waits_and_what_is_held_no_more_begins():
    assert slide(0.0, -1.0, -2.0, 0.01) == slide(-3.0, -1.0, -2.0, 0.01)
    assert slide(0.0, -1.0, -2.0, 0.01).caught == 0.0
    late = slide(0.0, -0.5, 0.5, 1.0)  # however little it takes
    assert (late.way, late.waited) == (pytest.approx(0.5**3 / 6.0), pytest.approx(0.5))
    brief = slide(0.0, 0.5, -0.5, 1.0)
    assert brief.way == pytest.approx(0.25 - 1.0 / 6.0)
    begun = slide(0.0, -100.0, 300.0, 0.04)
    assert (begun.caught, begun.waited) == (None, pytest.approx(0.01))
    assert begun.speed == pytest.approx(0.5 * 300.0 * 0.03)
    assert begun.way == pytest.approx(300.0 * 0.03**2 / 6.0)


def test_without_a_grip_it_falls_freely(half_plane):
    plant = raise_clear(hanging(half_plane), 20.0)
    plant.move(0.0, -1.0)  # wide open
    begun = plant.truth()
    assert begun.sliding
    assert begun.lifted
    for _ in range(20):
        plant.move(0.0, 0.0)
    now = plant.truth()
    # The first millisecond opens; what fell in it is known from its end on.
    speed = 1e3 * GRAVITY * 0.020
    assert now.slid - begun.slid == pytest.approx(speed * 0.010 + plant_speed(begun) * 0.020)
    assert (now.normal_force, now.tangential_force) == (0.0, 0.0)
    assert (now.caught, now.complete_slip) == (False, True)


def test_the_support_ends_a_fall(half_plane):
    """It has slid as far as it was high, not as far as it would have come by the step's end."""
    plant = raise_clear(hanging(half_plane), 2.0)
    plant.move(0.0, -1.0)  # wide open
    begun = plant.truth()
    while plant.truth().lifted:
        plant.move(0.0, 0.0)
    now = plant.truth()
    assert (now.caught, now.rise) == (False, 0.0)
    assert now.slid - begun.slid == pytest.approx(begun.rise, rel=1e-9)


def test_slides_of_a_lift_add_up(half_plane):
    """Each tug is caught; of half the time it makes a quarter of the way. The longest time of a
    catch is reported."""
    first, *others = (
        Disturbance(step_after_lift=step, extra_force_N=2.0, duration_steps=steps)
        for step, steps in ((500, 10), (700, 5), (800, 5))
    )
    found = []
    for tugs in ([first], [first, *others]):
        plant = raise_clear(hanging(half_plane, tugs), 5.0)
        for _ in range(1000):
            plant.move(0.0, 0.0)
        found.append(plant.truth())
    one, both = found
    assert (one.caught, both.caught) == (True, True)
    assert both.slid == pytest.approx(1.5 * one.slid, rel=1e-3)
    assert both.catch_time == pytest.approx(one.catch_time, rel=1e-3)


def plant_speed(begun):
    """mm/s after a step over which friction fell evenly from 1.3 of the weight to none."""
    wait = 0.3 / 1.3
    return 0.5 * GRAVITY * (1.0 - wait)  # m/s^2 times ms


@pytest.mark.parametrize(
    ("like", "kinetic"), [(True, 1.0), (False, 1.0), (True, 0.9), (False, 0.9)]
)
def test_a_tug_that_ends_lets_it_be_caught_after_v_squared_over_two_a(
    half_plane, softer, like, kinetic
):
    tug = Disturbance(step_after_lift=500, extra_force_N=2.0, duration_steps=10)
    opposite = None if like else softer
    plant = raise_clear(hanging(half_plane, [tug], opposite, kinetic=kinetic), 5.0)
    steps = 0
    while not plant.truth().sliding:
        capacity = plant.truth()
        plant.move(0.0, 0.0)
        steps += 1
        assert steps < 1000
    held = 2.0 * 0.5 * kinetic * capacity.normal_force  # by friction in motion
    while plant.truth().sliding:
        plant.move(0.0, 0.0)
    now = plant.truth()
    # Tugged for 10 ms, then slowed down by what friction has over the weight.
    mass = 1e-3 * MASS
    quicker, slower = (WEIGHT + 2.0 - held) / mass, (held - WEIGHT) / mass
    top = quicker * 0.010
    way = 1e3 * (top**2 / (2.0 * quicker) + top**2 / (2.0 * slower))
    assert (now.lifted, now.caught) == (True, True)
    assert now.slid == pytest.approx(way, rel=1e-3)
    assert now.catch_time == pytest.approx(0.010 + top / slower, rel=1e-3)
    plant.move(0.0, 0.0)
    assert plant.truth().complete_slip is False
    carried = plant.held.carried
    assert carried == pytest.approx(WEIGHT, rel=1e-6)


def test_a_weight_step_that_the_margin_covers_moves_nothing(half_plane):
    heavier = WeightChange(step_after_lift=300, object_mass_g=1.25 * MASS)
    plant = raise_clear(hanging(half_plane, [heavier]), 5.0)
    for _ in range(300):
        plant.move(0.0, 0.0)
        assert not plant.truth().complete_slip
    now = plant.truth()
    assert (now.slid, now.caught, now.catch_time, now.sliding) == (0.0, None, None, False)
    assert plant.held.carried == pytest.approx(1.25 * WEIGHT, rel=1e-6)


def test_a_hand_that_closes_catches_what_slides_and_one_that_does_not_drops_it(half_plane):
    heavier = WeightChange(step_after_lift=300, object_mass_g=1.5 * MASS)
    for closing, caught in ((0.002, True), (0.0, False)):
        plant = raise_clear(hanging(half_plane, [heavier], drop=3.0), 5.0)
        for _ in range(400):
            plant.move(0.0, closing if plant.truth().sliding else 0.0)
            if plant.truth().caught is not None and not plant.truth().sliding:
                break
        now = plant.truth()
        assert (now.caught, now.lifted) == (caught, caught)
        if caught:
            assert 0.0 < now.slid < 3.0
        else:
            assert now.slid > 3.0
            assert (now.rise, now.complete_slip) == (0.0, True)


def test_what_holds_is_what_it_is_without_inertia(half_plane):
    """Standing exactly; hanging but for the jolt of the lift, 0.05 m/s^2, and what it made slip."""
    still = LiftPlant(half_plane, "upper", MASS)
    moving = LiftPlant(half_plane, "upper", MASS, timed=Timed(inertia=Inertia(100.0, 5.0)))
    for dx, dy in [(0.0, 0.02)] * 8 + [(0.005, 0.0)] * 60:
        one, two = still.move(dx, dy), moving.move(dx, dy)
        assert two.normal_force == pytest.approx(one.normal_force, rel=1e-6)
        if not two.lifted:
            assert np.array_equal(two.readings, one.readings)
    assert moving.truth().lifted
    assert two.tangential_force == pytest.approx(one.tangential_force, rel=1e-9)
    assert two.readings == pytest.approx(one.readings, rel=0.01, abs=0.5)


def test_a_hand_that_speeds_up_pulls_harder(half_plane):
    plant = hanging(half_plane)
    step = 1.0 / RATE**2 * 1e3  # mm, a step more each step: 1 m/s^2
    for k in range(1, 6):
        plant.move(k * step, 0.0)
        assert plant.held.carried == pytest.approx(WEIGHT * (1.0 + 1.0 / GRAVITY), rel=1e-6)
    plant.move(5 * step, 0.0)
    assert plant.held.carried == pytest.approx(WEIGHT, rel=1e-6)


def test_a_hand_that_jerks_slides_along_the_object_until_that_has_its_speed(half_plane):
    """Up at once with 100 mm/s: friction's surplus makes the object as fast, v^2 / 2a of way."""
    plant = raise_clear(hanging(half_plane), 5.0)
    surplus = (friction(plant) - WEIGHT) / (1e-3 * MASS)
    for _ in range(100):
        plant.move(0.1, 0.0)
    now = plant.truth()
    assert now.caught
    assert now.slid == pytest.approx(1e3 * 0.1**2 / (2.0 * surplus), rel=1e-3)
    assert now.catch_time == pytest.approx(0.1 / surplus, rel=1e-3)


def test_it_swings_at_the_frequency_of_its_mass_on_the_fingers(half_plane):
    plant = hanging(half_plane)
    stiff = plant._fingers.stiffness()
    assert plant.truth().frequency == pytest.approx(frequency(stiff, MASS), rel=0.05)
    before = plant.held.shear
    tug = 1e-3
    shear = plant._fingers.hang(plant.truth().approach, WEIGHT - tug).shear
    assert tug / (before - shear) == pytest.approx(stiff, rel=0.02)  # turned back, all sticks
