"""Lifts of an object off the middle: it turns, slips sooner, and may turn too far."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.checks.follow import lift_force
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.contact.problem import contact_problem
from fingerdesign.contact.turning import turning
from fingerdesign.control.episode import run_episodes
from fingerdesign.control.plants.lift import LiftPlant, Relaxation, Timed
from fingerdesign.control.plants.plant import press, safety_margin
from fingerdesign.control.plants.rig import Rig
from fingerdesign.control.plants.slide import Inertia
from fingerdesign.design.grip import GRAVITY
from fingerdesign.errors import DesignError
from fingerdesign.sensing.train.paths import random_grip_path
from fingerdesign.sensing.train.result import settings_of
from fingerdesign.sensing.train.samples import finger_curves, sample, with_turn_radius
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import bump

MASS_G, OFF = 0.8, 1.2
HALF = 0.5e-3 * GRAVITY * MASS_G
OFF_CENTRE = {"grip.plant": "lift", "grip.off_centre_mm": 10.0}


def plant(off, mass_g=MASS_G, friction=0.5):
    problem = contact_problem(bump(21), Plane(0.0), friction)
    if off:
        problem = turning(problem, off, 0.5e-3 * GRAVITY * mass_g)
    return LiftPlant(problem, "upper", mass_g)


def raised(plant, depth, moves=80):
    """Press, then raise the hand until the object hangs or is lost."""
    list(press(plant, depth, 0.002))
    for _ in range(moves):
        plant.move(0.005, 0.0)
        if plant.truth().lifted or plant.truth().complete_slip:
            break
    return plant.truth()


def test_it_hangs_turned_and_the_force_that_holds_it_is_known():
    centred, off = (raised(plant(each), 0.016) for each in (0.0, OFF))
    assert centred.lifted
    assert off.lifted
    assert centred.rotation == 0.0
    assert off.rotation > 0.1
    for each in (centred, off):
        assert each.tangential_force == pytest.approx(HALF, rel=1e-6)
    # The ratio at which it slips is far below the friction coefficient.
    assert centred.slip_ratio == pytest.approx(0.5, rel=1e-6)
    assert off.slip_ratio < 0.25
    assert safety_margin(off, 0.5) < 0.5 * safety_margin(centred, 0.5)


def test_the_slip_ratio_is_of_the_lift_or_of_the_moment():
    """A small contact holds a moment worse than a large one, by a fraction of the friction."""
    problem = turning(contact_problem(bump(21), Plane(0.0), 0.5), OFF, HALF)
    ratios = {}
    for now in (False, True):
        held = LiftPlant(problem, "upper", MASS_G, ratio_of_now=now)
        held.move(0.0, 0.006)
        small = held.truth().slip_ratio
        held.move(0.0, 0.014)
        ratios[now] = small, held.truth().slip_ratio
    assert ratios[False][0] == ratios[False][1]
    assert ratios[True][0] < 0.8 * ratios[True][1]


def test_the_torque_is_that_of_the_pull_on_its_arm_also_as_the_rubber_relaxes():
    problem = turning(contact_problem(bump(11), Plane(0.0), 0.5), -OFF, HALF)
    timed = Timed(Relaxation(0.2, 1.0))
    lift = LiftPlant(problem, "upper", MASS_G, timed=timed, ratio_of_now=True)
    list(press(lift, 0.016, 0.008))
    felt = [lift.move(0.0005, 0.0) for _ in range(2)][-1]
    assert felt.torque == pytest.approx(-OFF * felt.tangential_force, rel=0.02)


def test_just_over_the_least_force_it_is_held_and_just_below_it_slips():
    start = plant(OFF)
    least = HALF / start.truth().slip_ratio
    list(press(start, 0.01, 0.002))
    known = start.truth().normal_force  # of a contact like Hertz's: F_n grows as depth^1.5
    for share, held in ((1.04, True), (0.96, False)):
        depth = 0.01 * (share * least / known) ** (2.0 / 3.0)
        found = raised(plant(OFF), depth)
        assert (found.lifted, found.complete_slip) == (held, not held)


@pytest.mark.slow
def test_an_object_that_no_contact_holds_is_refused_by_no_error():
    """Its ratio is that of the deepest contact in the zone; it slips, and is not lifted."""
    lift = plant(OFF, mass_g=20.0)
    known = lift.truth().slip_ratio
    assert 0.5 * plant(OFF).truth().slip_ratio < known < 0.5
    found = raised(lift, 0.016)
    assert found.complete_slip
    assert not found.lifted


def test_an_object_that_turns_has_no_inertia():
    problem = turning(contact_problem(bump(21), Plane(0.0), 0.5), OFF, HALF)
    with pytest.raises(ValueError, match="leave one of them out"):
        LiftPlant(problem, "upper", MASS_G, timed=Timed(inertia=Inertia(100.0, 10.0)))


def test_a_turn_over_ten_degrees_is_a_drop():
    """Of so large a friction that the rubber turns farther than that before it slips."""
    lift = plant(OFF, mass_g=100.0, friction=20.0)
    list(press(lift, 0.016, 0.002))
    turns = []
    while not lift.truth().complete_slip and len(turns) < 200:
        lift.move(0.005, 0.0)
        turns.append(lift.truth().rotation)
    assert turns[-2] < 10.0 < turns[-1] < 10.5
    assert lift.truth().stick_ratio == 0.0
    assert not lift.truth().lifted
    assert (np.diff(turns) > 0.0).all()


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"grip.inertia": True}, "grip.inertia"),
        ({"grip.opposite": "bare"}, "grip.opposite"),
        ({"grip.plant": "finger"}, "grip.off_centre_mm"),
        ({"grip.off_centre_mm": 300.0}, "grip.off_centre_mm"),
    ],
)
def test_what_an_object_that_turns_does_not_go_with(values, key):
    with pytest.raises(DesignError) as refused:
        with_values(load_design("sensitive"), OFF_CENTRE | values)
    assert [fault.key for fault in refused.value.faults] == [key]


def test_a_section_is_refused_before_work():
    from fingerdesign.analysis.case import Case, fundamental_scene
    from fingerdesign.analysis.forecast.forecast import impossible

    design = with_values(load_design("sensitive"), OFF_CENTRE)
    case = Case(design, None, "plane-strain")
    (fault,) = impossible(case, fundamental_scene())
    assert (fault.key, fault.remedy) == ("grip.off_centre_mm", "take --fidelity 3d")
    assert not Case(design, None, "3d").symmetric


def test_a_draw_off_the_middle_takes_a_whole_finger_in_3d():
    from fingerdesign.analysis.case import Case, fundamental_scene
    from fingerdesign.analysis.forecast.forecast import impossible
    from fingerdesign.sensing.perturb.finger import bench_grip, perturb, refuse_faults

    design = load_design("sensitive")
    drawn = [perturb(design, ["off_centre"], seed).design for seed in range(20)]
    offs = np.array([each.grip.off_centre_mm for each in drawn])
    assert (np.abs(offs) <= 10.0).all()
    assert offs.min() < -5.0
    assert offs.max() > 5.0
    bench = drawn[0].model_copy(update={"grip": bench_grip(drawn[0].grip)})
    case = Case(bench, None, "3d")
    assert (case.symmetric, impossible(case, fundamental_scene())) == (False, [])
    refuse_faults(design, ["off_centre"], "3d")
    with pytest.raises(DesignError, match="take --fidelity 3d"):
        refuse_faults(design, ["off_centre"])


def test_the_forecast_of_the_force_against_models():
    """F_n that just holds on film_tees, whole, in 3-D: (off mm, friction, g, N)."""
    for off, friction, mass_g, force in (
        (3.0, 0.5, 250.0, 4.05),
        (10.0, 0.3, 100.0, 6.16),
        (20.0, 0.5, 250.0, 15.6),
        (20.0, 0.8, 250.0, 10.3),
        (20.0, 0.2, 500.0, 63.2),
    ):
        own = {"grip.plant": "lift", "grip.off_centre_mm": off}
        design = with_values(load_design("film_tees"), own)
        # Chosen with these numbers seen: a forecast, and 20 % is what it is good for.
        assert lift_force(design, friction, 1.0, mass_g) == pytest.approx(force, rel=0.21)


@pytest.fixture(scope="module")
def coarse():
    """A design of a coarse finger, and its problem in 3-D, whole."""
    from fingerdesign.sensing.model import grip_problem

    mesh = {"mesh.layers": 1, "mesh.section.plate_size_mm": 0.6, "grip.max_approach_mm": 0.6}
    values = {"grip.controller": "oracle_1.2", "plates.count": 5} | mesh
    design = with_values(load_design("sensitive"), OFF_CENTRE | values)
    return design, grip_problem(with_values(design, {"mesh.contact_size_mm": 0.8}), "3d")


@pytest.mark.slow
def test_training_meets_objects_that_turn(coarse):
    """Their utilisation counts by the least force that friction carries of the turn, the torque is
    that of their arm, and the curves have the turn radius where the cell measures torque."""
    design, problem = coarse
    settings = replace(settings_of(design), torque_noise=1e-9)
    path = random_grip_path(turning(problem, 6.0, 1.0), settings, np.random.default_rng(1))
    ratios = np.array([each.slip_ratio for each in path.truths if each.slip_ratio])
    assert (ratios < 0.8 * path.friction_coefficient).all()
    assert 0.8 < max(path.friction_utilisation) < 1.02  # held, or just slipping
    samples = [each.sample for each in path.moments if each.sample.tangential_force > 0.1]
    arms = [each.torque / each.tangential_force for each in samples]
    assert arms == pytest.approx([6.0] * len(arms), rel=0.02)
    curves = finger_curves(problem, "both", settings.bounds)
    known = with_turn_radius(curves, problem, settings)
    without = with_turn_radius(curves, problem, replace(settings, torque_noise=None))
    assert (known.turn_radius > 1.0).all()
    assert not without.turn_radius.any()
    inputs, _ = sample(path, known, settings, np.random.default_rng(0), 0.5)
    force = samples[-1].normal_force
    expected = known.left_by_turn(force, 6.0)
    assert expected < 0.8
    assert inputs[-1, curves.pressed.shape[1] + 4] == pytest.approx(expected, rel=0.05)


def test_an_oracle_holds_an_object_off_the_middle_on_a_real_finger(coarse):
    """On a coarse one: its margin is 1.2 of the force that limit analysis gives, and it is held.
    `bench suite` has film_tees."""
    design, problem = coarse
    assert problem.model.symmetry_factor == 1
    (episode,) = run_episodes(Rig.of(problem, design), [0.8], 100.0)
    result = episode.result
    assert (result.lifted, result.gross_slip) == (True, False)
    assert result.safety_margin == pytest.approx(1.2, rel=0.03)
    assert 0.05 < abs(result.rotation_deg) < 10.0
    assert "turned by" in result.ending
    assert result.least_force_N > 2.0 * 0.5e-3 * GRAVITY * 100.0 / 0.8
