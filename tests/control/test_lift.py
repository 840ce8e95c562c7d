"""An object lifted off its support by two fingers: weight, hanging, tugs, drops."""

import numpy as np
import pytest

from fingerdesign.contact.gross_slip import coefficient_under
from fingerdesign.control.plants.lift import Disturbance, LiftPlant, Relaxation, Timed
from fingerdesign.control.plants.plant import CondensedPlant, is_lifted, press
from fingerdesign.design.grip import GRAVITY, Grip, HardwareTable, WeightChange
from fingerdesign.shapes.friction import FrictionLaw

MASS = 200.0

HALF = 0.5e-3 * GRAVITY * MASS


def raised(plant):
    """Press, then raise the hand until the object hangs."""
    list(press(plant, 0.12, 0.02))
    for _ in range(200):
        plant.move(0.005, 0.0)
        if plant.truth().lifted:
            return plant
    raise AssertionError("never lifted")


def test_standing_the_support_carries_the_rest_and_the_finger_feels_as_on_a_stage(half_plane):
    plant, stage = LiftPlant(half_plane, "upper", MASS), CondensedPlant(half_plane, "upper")
    for dx, dy in [(0.0, 0.03), (0.0, 0.03), (0.004, 0.01), (0.004, 0.01)]:
        felt, there = plant.move(dx, dy), stage.move(dx, dy)
        assert np.array_equal(felt.readings, there.readings)
        assert felt.normal_force == there.normal_force
        assert plant.truth().tangential_force < HALF
        assert (plant.truth().lifted, plant.truth().rise, felt.lifted) == (False, 0.0, False)


def test_hanging_both_fingers_carry_the_weight_whatever_the_hand_does(half_plane):
    plant = raised(LiftPlant(half_plane, "upper", MASS))
    for dx, dy in [(0.0, 0.0), (0.01, 0.0), (0.0, 0.02), (0.5, -0.01), (-0.02, 0.004)]:
        before = plant.truth()
        sample = plant.move(dx, dy)
        now = plant.truth()
        assert 2.0 * now.tangential_force == pytest.approx(1e-3 * GRAVITY * MASS, rel=1e-6)
        assert now.rise - before.rise == pytest.approx(dx - (now.shear - before.shear), abs=1e-12)
        assert (now.lifted, sample.lifted, now.complete_slip) == (True, True, False)
        assert is_lifted(now, MASS)
        assert now.approach - before.approach == pytest.approx(dy)
        assert dy <= 0.0 or now.normal_force > before.normal_force


def test_held_still_the_grip_weakens_and_the_weight_is_carried_on(half_plane):
    plant = raised(LiftPlant(half_plane, "upper", MASS, timed=Timed(Relaxation(0.3, 100.0))))
    plant.move(0.2, 0.0)  # clear of the support, which its creep would bring back
    before = plant.truth()
    samples = [plant.move(0.0, 0.0) for _ in range(300)]
    now = plant.truth()
    assert all(each.tangential_force == pytest.approx(HALF, rel=1e-6) for each in samples)
    assert (np.diff([each.normal_force for each in samples]) < 0.0).all()
    assert now.normal_force < 0.95 * before.normal_force
    assert now.approach == before.approach
    assert now.shear > before.shear  # it creeps down
    assert now.rise < before.rise
    assert now.lifted


def test_friction_that_falls_with_the_pressure_is_larger_on_rubber_that_has_relaxed(half_plane):
    """Of forces R f it carries R^-n times as large a share."""
    law, relaxing = FrictionLaw(0.3, exponent=0.5, reference=0.05), Relaxation(0.2, 100.0)
    ratios = []
    for each in (None, relaxing):
        problem = half_plane.with_friction(law)
        plant = LiftPlant(problem, "upper", 1e4, timed=Timed(each))
        assert plant.truth().slip_ratio == coefficient_under(problem, 50.0 * HALF)
        plant.move(0.0, 0.1)
        for _ in range(40):
            plant.move(0.01, 0.0)
        now = plant.truth()
        assert now.complete_slip
        ratios.append(now.tangential_force / now.normal_force)
    assert ratios[1] / ratios[0] == pytest.approx(relaxing.left(41) ** -0.5, rel=2e-3)
    with pytest.raises(ValueError, match="do not scale"):
        LiftPlant(
            half_plane.with_friction(FrictionLaw(0.0, 0.1)), "upper", MASS, timed=Timed(relaxing)
        )


def test_a_relaxed_stand_has_less_of_the_same_forces(half_plane):
    fresh, soft = (
        LiftPlant(half_plane, "upper", MASS, timed=Timed(each))
        for each in (None, Relaxation(0.2, 100.0))
    )
    for k, move in enumerate([(0.0, 0.05), (0.004, 0.01), (0.004, 0.0)], start=1):
        full, less = fresh.move(*move), soft.move(*move)
        left = Relaxation(0.2, 100.0).left(k)
        assert less.normal_force == pytest.approx(left * full.normal_force)
        assert less.tangential_force == pytest.approx(left * full.tangential_force)
        assert less.readings == pytest.approx(full.readings)


@pytest.mark.parametrize("like", [True, False])
def test_a_tug_beyond_friction_drops_the_object_onto_its_support(half_plane, softer, like):
    opposite = None if like else softer
    plant = raised(LiftPlant(half_plane, "upper", MASS, opposite, [Disturbance(1, 50.0)]))
    plant.move(0.3, 0.0)
    now = plant.truth()
    assert (now.lifted, now.complete_slip, now.rise) == (False, True, 0.0)
    assert not is_lifted(now, MASS)
    assert now.slip_distance > 0.25  # all the way back to the support
    if like:  # both carry what friction allows them, 0.5 per N of F_n
        assert now.normal_force == pytest.approx(2.0 * now.tangential_force, rel=1e-6)
        plant.move(0.01, 0.0)
        assert plant.truth().lifted  # without the tug it can be raised anew


def test_a_tug_is_carried_up_to_what_friction_holds(half_plane):
    plant = raised(LiftPlant(half_plane, "upper", MASS))
    spare = 0.98 * (0.5 * plant.truth().normal_force - HALF) * 2.0
    for share, carried in ((1.0, True), (1.1, False)):
        tugs = [Disturbance(1, share * spare)]
        other = raised(LiftPlant(half_plane, "upper", MASS, disturbances=tugs))
        other.move(0.1, 0.0)
        assert (other.truth().lifted, other.truth().complete_slip) == (carried, not carried)


def test_slip_takes_energy_and_gives_none(half_plane):
    """Tugs down and up, again and again: a closed loop of F_t against shear, run the lossy way."""
    cycle = [0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0]
    tugs = [Disturbance(k, force) for k, force in enumerate(3 * cycle, 2)]
    plant = raised(LiftPlant(half_plane, "upper", MASS, disturbances=tugs))
    plant.move(0.2, 0.0)
    path = []
    for _ in 3 * cycle:
        plant.move(0.0, 0.0)
        assert plant.truth().lifted
        path.append((plant.truth().shear, plant.truth().tangential_force))
    shear, force = np.array([path[7], *path[8:16]]).T
    assert force[0] == pytest.approx(force[-1], rel=1e-8)
    assert shear[0] == pytest.approx(shear[-1], abs=1e-6)
    loss = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(shear))
    assert loss > 1e-4 * np.ptp(force) * np.ptp(shear)


def test_an_equal_finger_opposite_is_the_mirror_image(half_plane):
    """Two equal problems, solved apart, find half of everything each."""
    tugs = [Disturbance(2, 0.5, 3)]
    mirror = LiftPlant(half_plane, "upper", MASS, disturbances=tugs)
    apart = LiftPlant(half_plane, "upper", MASS, half_plane, tugs)
    for dx, dy in [(0.0, 0.04)] * 3 + [(0.006, 0.002)] * 14 + [(0.002, 0.001)] * 5:
        one, two = mirror.move(dx, dy), apart.move(dx, dy)
        assert two.readings == pytest.approx(one.readings, rel=1e-6, abs=1e-6)
        assert two.normal_force == pytest.approx(one.normal_force, rel=1e-8)
        assert apart.truth().shear == pytest.approx(mirror.truth().shear, abs=1e-8)
        assert apart.truth().lifted == mirror.truth().lifted
    assert mirror.truth().lifted


def test_unlike_fingers_press_alike_and_carry_the_weight_between_them(half_plane, softer):
    plant = raised(LiftPlant(half_plane, "upper", MASS, softer))
    like = raised(LiftPlant(half_plane, "upper", MASS))
    for _ in range(3):
        plant.move(0.0, 0.004)
        like.move(0.0, 0.004)
    now = plant.truth()
    # The softer one yields more: the object drifts toward it, off the stiffer finger.
    assert now.approach < like.truth().approach
    held = plant.held
    pressed, against = (
        -problem.model.total_force(each.force)[1]
        for problem, each in ((half_plane, held.increment), (softer, held.other))
    )
    assert pressed == pytest.approx(against, rel=1e-8)
    assert held.carried == pytest.approx(1e-3 * GRAVITY * MASS, rel=1e-6)
    assert now.tangential_force > HALF  # the stiffer one carries more
    assert held.increment.motion.approach + held.other.motion.approach == pytest.approx(0.264)


def test_what_cannot_be_is_refused(half_plane):
    for mass in (0.0, -5.0, float("nan")):
        with pytest.raises(ValueError, match="mass"):
            LiftPlant(half_plane, "upper", mass)
    lighter = WeightChange(step_after_lift=5, object_mass_g=100.0)
    for disturbances in ([Disturbance(1, -3.0)], [Disturbance(1, -1.5, 10), lighter]):
        with pytest.raises(ValueError, match="out of the fingers"):
            LiftPlant(half_plane, "upper", MASS, disturbances=disturbances)
    with pytest.raises(ValueError, match="step_after_lift"):
        Disturbance(0, 1.0)
    with pytest.raises(ValueError, match="mass"):
        WeightChange(step_after_lift=1, object_mass_g=0.0)


def test_in_three_dimensions_too(bump):
    """A bump on springs: lifted at its weight, held, dropped by a tug that friction can't carry."""
    mass = 5.0
    plant = LiftPlant(bump, "both", mass, disturbances=[Disturbance(20, 0.5)])
    for _ in range(8):
        plant.move(0.0, 0.002)
    while not plant.truth().lifted:
        plant.move(0.0004, 0.0)
    for _ in range(19):
        plant.move(0.002, 0.0001)
        assert plant.truth().tangential_force == pytest.approx(0.5e-3 * GRAVITY * mass, rel=1e-6)
    plant.move(0.002, 0.0)
    assert (plant.truth().lifted, plant.truth().complete_slip) == (False, True)


def hanging(problem):
    plant = LiftPlant(problem, "upper", 60.0, disturbances=[Disturbance(40, 0.1, 3)])
    for move in [(0.0, 0.02)] * 5 + [(0.01, 0.0)] * 30:
        plant.move(*move)
    return plant


def test_a_hand_that_only_raises_changes_the_height_alone(half_plane):
    """Nothing is solved, and the answer is that of solving."""
    still, solved = hanging(half_plane), hanging(half_plane)
    for _ in range(3):
        before = still.truth()
        sample = still.move(0.02, 0.0)
        other = solved.move(0.02, 1e-13)  # not quite nothing: solved anew
        assert still.truth().rise == pytest.approx(before.rise + 0.02)
        assert sample.readings == pytest.approx(other.readings, abs=1e-6)
        reported, anew = still.truth(), solved.truth()
        assert reported.normal_force == pytest.approx(anew.normal_force, rel=1e-9)
        assert reported.stick_ratio == pytest.approx(anew.stick_ratio, abs=1e-6)
        assert reported.rise == pytest.approx(anew.rise, abs=1e-6)


def test_a_tug_and_a_landing_are_still_felt(half_plane):
    plant = hanging(half_plane)
    forces = np.array([plant.move(0.01, 0.0).tangential_force for _ in range(30)])
    assert np.ptp(forces) == pytest.approx(0.05, abs=1e-6)  # half of the tug each
    assert plant.move(-plant.truth().rise - 0.01, 0.0).lifted is False


@pytest.mark.parametrize("like", [True, False])
@pytest.mark.parametrize(
    ("use", "share", "carried"), [(0.7, 0.8, True), (0.9, 1.0, True), (0.9, 0.8, False)]
)
def test_what_static_friction_alone_would_carry_slides_away(half_plane, like, use, share, carried):
    """Held still, nodes that begin to slide weaken from step to step, until the object drops."""
    opposite = None if like else half_plane

    def plant_of(*tugs):
        return raised(LiftPlant(half_plane, "upper", MASS, opposite, tugs, kinetic_share=share))

    extra = 2.0 * (use * 0.5 * plant_of().truth().normal_force - HALF)
    plant = plant_of(Disturbance(2, extra, 100))
    plant.move(0.2, 0.0)
    plant.move(0.0, 0.0)
    assert plant.truth().lifted  # at first by static friction
    assert plant.truth().tangential_force == pytest.approx(HALF + 0.5 * extra, rel=1e-6)
    for _ in range(20):
        plant.move(0.0, 0.0)
    now = plant.truth()
    assert now.lifted is carried
    if not carried:  # onto its support, where it slid: mu_k F_n at the most
        assert now.rise == 0.0
        assert now.tangential_force <= share * 0.5 * now.normal_force * (1.0 + 1e-6)


def test_rubber_relaxes_evenly_in_the_logarithm_of_time_to_its_share_in_a_minute():
    relaxing = Relaxation(0.1, 100.0)
    assert relaxing.left(0) == 1.0
    assert relaxing.left(6000) == pytest.approx(0.9)
    assert relaxing.left(600) - relaxing.left(6000) == pytest.approx(0.1 / np.log10(601), rel=0.01)
    hardware = HardwareTable(sample_rate_Hz=50.0)
    grip = Grip(relaxation_per_minute=0.1).model_copy(update={"hardware": hardware})
    assert Timed.of(grip).relaxation.left(3000) == pytest.approx(0.9)  # a minute
    assert Timed.of(Grip()).relaxation is None


def test_a_tug_is_felt_while_it_lasts_and_soon_after_the_lift_sets_the_object_down(half_plane):
    tug = Disturbance(step_after_lift=3, extra_force_N=0.6, duration_steps=2)
    plant = raised(LiftPlant(half_plane, "upper", MASS, disturbances=[tug]))
    plant.move(0.1, 0.0)
    felt = [2.0 * (plant.move(0.0, 0.0).tangential_force - HALF) for _ in range(5)]
    assert felt == pytest.approx([0.0, 0.6, 0.6, 0.0, 0.0], abs=1e-7)
    assert plant.truth().lifted
    plant = raised(LiftPlant(half_plane, "upper", MASS, disturbances=[Disturbance(1, 0.6)]))
    plant.move(0.0, 0.0)
    assert (plant.truth().lifted, plant.truth().complete_slip) == (False, False)
    assert plant.truth().tangential_force < HALF + 0.3
