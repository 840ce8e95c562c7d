"""The rivals: where their forces end, what they react to, and that none of them reads a gage."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.checks.load import with_values
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.episode import run_episode
from fingerdesign.control.plants.lift import Disturbance, LiftPlant
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.roster import make_controller as controller
from fingerdesign.control.signals import NormalCalibration, Sample
from fingerdesign.errors import DesignError
from fingerdesign.runtime.registry import CONTROLLERS

GRAVITY = 9.80665e-3
LATE = {"reactive.first_force_N": 0.5, "reactive.slip_share": 0.3}
BASE = {
    "grip.preload_mm": 0.02,
    "grip.approach_step_mm": 0.008,
    "grip.max_approach_mm": 0.3,
    "grip.reactive.force_floor_N": 0.01,
}


@pytest.fixture(scope="module")
def grip(design):
    return with_values(design, BASE).grip


@pytest.fixture(scope="module")
def bench(half_plane, grip):
    return calibrate(
        lambda: CondensedPlant(half_plane, "both"), half_plane.model.gage_x, Bounds.of(grip)
    )


@pytest.fixture
def lift(half_plane, grip, bench):
    """Lift an object by a named controller: on its support, or without one."""

    def run(name, friction, mass_g, values=None, after_lift=0, hangs=True, disturbances=()):
        table = with_grip(grip, values or {})
        problem = half_plane.with_friction(friction)
        plant = (
            LiftPlant(problem, "both", mass_g, disturbances=disturbances)
            if hangs
            else CondensedPlant(problem, "both")
        )
        hand = controller(name, table, friction=friction, mass_g=mass_g)
        bounds = Bounds(table.preload_mm, table.approach_step_mm, table.max_approach_mm, 300)
        return run_episode(plant, hand, bench, bounds, friction, mass_g, after_lift)

    return run


def with_grip(grip, values):
    """A copy with dotted keys set."""
    for key, value in values.items():
        table, _, name = key.rpartition(".")
        inner = getattr(grip, table) if table else grip
        changed = inner.model_copy(update={name: value})
        grip = grip.model_copy(update={table: changed}) if table else changed
    return grip


@pytest.mark.parametrize("hangs", [True, False])
@pytest.mark.parametrize(("friction", "mass_g"), [(0.2, 150.0), (0.5, 60.0), (0.8, 500.0)])
@pytest.mark.parametrize("margin", [1.2, 1.5])
def test_an_oracle_lifts_at_its_margin(lift, margin, friction, mass_g, hangs):
    result = lift(f"oracle_{margin}", friction, mass_g, hangs=hangs).result
    assert (result.lifted, result.gross_slip) == (True, False)
    # 2 % below: the hand pulls from 0.98 of its force on; without a support F_t overshoots a bit.
    assert 0.96 * margin < result.safety_margin <= 1.01 * margin
    least = 0.5 * GRAVITY * mass_g / friction
    assert result.peak_normal_force_N <= 1.01 * margin * least


@pytest.mark.parametrize(("friction", "mass_g"), [(0.3, 300.0), (0.8, 100.0)])
def test_fixed_force_ends_at_its_force(lift, friction, mass_g):
    episode = lift("fixed_force", friction, mass_g, {"fixed_force.force_N": 6.0}, after_lift=5)
    assert episode.result.lifted
    assert episode.result.final_normal_force_N == pytest.approx(6.0, rel=0.02)
    trace = episode.trace
    assert (trace.tangential_force[trace.normal_force < 0.97 * 6.0] < 0.02).all()


@pytest.mark.parametrize(
    ("name", "friction", "mass_g", "values"),
    [
        ("fixed_force", 0.3, 500.0, {"fixed_force.force_N": 6.0}),
        ("fixed_ratio", 0.2, 300.0, {"fixed_ratio.ratio": 0.25}),
        ("reactive", 0.4, 150.0, LATE),
    ],
)
def test_too_little_force_or_too_late_slips(lift, name, friction, mass_g, values):
    episode = lift(name, friction, mass_g, values)
    assert (episode.result.outcome, episode.result.lifted) == ("complete slip", False)
    assert episode.result.gross_slip


def test_the_reactive_hand_grips_by_what_it_presses_with_and_keeps_what_it_lifted_with(grip, bench):
    """On a bench of 100 N over its 0.3 mm the preload of 0.02 mm is 6.67 N; half of what is missing
    is closed in one step."""
    count = len(bench.gage_x)
    linear = NormalCalibration(np.array([0.0, 100.0]), np.zeros((2, count)))
    calibration = replace(bench, normal=linear, tangential_stiffness=10.0)

    def answers(*forces, lifted=(False, True)):
        hand = controller("reactive", with_grip(grip, {"reactive.step_up": 1.2}))
        every = [Sample(np.zeros(count), *f, up) for f, up in zip(forces, lifted, strict=True)]
        hand.start(calibration, Sample(np.zeros(count), 1.0, 0.0))
        return [hand.command(each) for each in every]

    slips = answers((9.0, 0.0), (9.0, 0.0), (9.0, 0.4), lifted=(False, False, True))
    assert slips[0].dx == pytest.approx(0.007 * 9.0 / 10.0)
    # It pulls and F_t does not rise: 1.2 times the 9 N that it presses with, not the 6.67 N.
    assert slips[1].dy == pytest.approx(0.5 * 0.003 * (1.2 * 9.0 - 9.0))
    assert [each.warns for each in slips] == [False, True, False]
    assert slips[1].hold
    for pressed, target in ((8.0, 8.0), (6.0, 20.0 / 3.0)):  # at the lift, and no less
        lift, tugged = answers((pressed, 1.0), (pressed, 1.2), lifted=(True, True))
        assert lift.dy == pytest.approx(0.5 * 0.003 * (target - pressed), abs=1e-12)
        assert tugged.dy == pytest.approx(0.5 * 0.003 * (1.2 * target - pressed))
    hand = controller("fixed_force", with_grip(grip, {"fixed_force.force_N": 6.0}))
    hand.start(calibration, Sample(np.zeros(count), 1.0, 0.0))
    opens = [hand.command(Sample(np.zeros(count), force, 0.0)).dy for force in (8.0, 30.0)]
    assert opens == pytest.approx([-0.5 * 0.003 * 2.0, -0.008])  # by a step at the most


@pytest.mark.parametrize("mass_g", [100.0, 300.0])
def test_fixed_ratio_keeps_its_ratio_whatever_the_weight(lift, mass_g):
    friction, ratio = 0.4, 0.2
    episode = lift("fixed_ratio", friction, mass_g, {"fixed_ratio.ratio": ratio}, after_lift=5)
    assert episode.result.lifted
    assert episode.result.safety_margin == pytest.approx(friction / ratio, rel=0.08)
    on = episode.trace.tangential_force > 0.5 * GRAVITY * mass_g * 0.5
    used = episode.trace.tangential_force[on] / episode.trace.normal_force[on]
    assert np.allclose(used, ratio, rtol=0.08)


def test_the_reactive_hand_grips_harder_at_each_sign_of_slip(lift):
    values = {"reactive.first_force_N": 0.5, "reactive.slip_share": 0.93, "reactive.step_up": 1.4}
    episode = lift("reactive", 0.4, 150.0, values)
    result, trace = episode.result, episode.trace
    assert (result.lifted, result.gross_slip) == (True, False)
    assert result.holds >= 3
    assert trace.normal_force[0] < 0.5
    first = int(np.flatnonzero(trace.hold)[0])
    before, after = trace.normal_force[first - 1], trace.normal_force[first:]
    waited = int(np.flatnonzero(~trace.hold[first:])[0])
    assert after[waited - 1] == pytest.approx(1.4 * before, rel=0.03)
    assert trace.dx[trace.hold].max() == 0.0
    # It does react to slip: not before much of the friction was in use.
    used = trace.tangential_force[first - 1] / trace.limit[first - 1]
    assert 0.4 < used < 1.0


@pytest.mark.parametrize("name", ["fixed_ratio", "reactive", "oracle_1.2"])
def test_a_tug_is_answered_by_a_harder_grip(lift, name):
    values = {"reactive.first_force_N": 4.0, "fixed_ratio.ratio": 0.25}
    tug = Disturbance(step_after_lift=10, extra_force_N=0.3, duration_steps=30)
    episode = lift(name, 0.4, 200.0, values, after_lift=25, disturbances=(tug,))
    trace = episode.trace
    at = trace.lift_step + 10
    assert (episode.result.lifted, episode.result.gross_slip) == (True, False)
    assert trace.tangential_force[at] > trace.tangential_force[at - 1] + 0.1
    ratio = trace.tangential_force[-1] / trace.tangential_force[at - 1]
    assert trace.normal_force[-1] / trace.normal_force[at - 1] == pytest.approx(ratio, rel=0.05)


@pytest.mark.parametrize("carried", [0.3, 3.0])
def test_a_tug_is_a_twentieth_more_than_at_the_lift(bench, grip, carried):
    hand = controller("reactive", with_grip(grip, {"reactive.first_force_N": 4.0}))

    def lifted(normal, share):
        return replace(felt(normal, share * carried, 0.0), lifted=True)

    hand.start(bench, felt(0.5, 0.0, 0.0))
    hand.command(lifted(4.0, 1.0))
    assert hand.command(lifted(4.0, 1.02)).dy == pytest.approx(0.0, abs=1e-12)
    assert hand.command(lifted(4.0, 1.1)).dy > 0.0


NAMES = CONTROLLERS.names()


@pytest.mark.parametrize("name", [name for name in NAMES if name != "regulator"])
def test_a_lifted_object_is_not_pulled_any_more(lift, name):
    values = {"fixed_force.force_N": 6.0, "reactive.first_force_N": 6.0}
    episode = lift(name, 0.5, 150.0, values, after_lift=10)
    trace, at = episode.trace, episode.trace.lift_step
    assert (episode.result.lifted, episode.result.gross_slip) == (True, False)
    assert len(trace.dx) == at + 11
    assert (trace.dx[at + 1 :] == 0.0).all()
    assert trace.normal_force[-1] == pytest.approx(trace.normal_force[at], rel=0.1)


@pytest.mark.parametrize("name", ["fixed_force", "fixed_ratio", "reactive", "oracle_1.5"])
def test_rivals_do_not_read_gages(bench, grip, name):
    def moves(scale):
        hand = controller(name, grip, friction=0.3, mass_g=300.0)
        hand.start(bench, felt(0.5, 0.0, scale))
        forces = [(0.5, 0.0), (0.6, 0.0), (0.7, 0.05), (15.0, 0.3), (15.0, 0.31), (15.0, 0.31)]
        return [hand.command(felt(*pair, scale)) for pair in forces]

    assert moves(0.0) == moves(1e4)


def felt(normal, tangential, scale):
    return Sample(scale * np.arange(11.0), normal, tangential)


@pytest.mark.parametrize("name", ["fixed_ratio", "reactive"])
def test_a_sample_that_comes_late_does_not_loosen_the_preload(bench, grip, name):
    """Given of an untouched finger at the start, it does not open towards it."""
    hand = controller(name, with_grip(grip, {"reactive.first_force_N": 0.01}))
    hand.start(bench, felt(0.0, 0.0, 0.0))
    share = grip.preload_mm / grip.max_approach_mm
    forces = bench.normal.normal_force
    preload = float(np.interp(share, np.linspace(0.0, 1.0, len(forces)), forces))
    assert hand.command(felt(preload, 0.0, 0.0)).dy == pytest.approx(0.0, abs=1e-9)
    assert hand.command(felt(0.5 * preload, 0.0, 0.0)).dy > 0.0


def test_no_move_is_larger_than_the_hand_can_do_and_a_start_forgets_the_last_grip(bench, grip):
    forces = np.random.default_rng(3).uniform([-1.0, -5.0], [60.0, 20.0], (100, 2))
    for name in ("fixed_force", "fixed_ratio", "reactive", "oracle_1.5"):
        hand, runs = controller(name, grip, friction=0.3, mass_g=300.0), []
        for _ in range(2):
            hand.start(bench, felt(0.5, 0.0, 0.0))
            runs.append([hand.command(felt(*pair, 0.0)) for pair in forces])
        assert runs[0] == runs[1]
        for command in runs[0]:
            assert abs(command.dy) <= grip.approach_step_mm
            assert 0.0 <= command.dx <= grip.shear_step_mm


def test_too_little_knowledge_and_unknown_names_are_refused(grip):
    with pytest.raises(ValueError, match=r"oracle_1\.2 must be given"):
        controller("oracle_1.2", grip, friction=0.5)
    with pytest.raises(DesignError, match="estimator"):
        controller("regulator", grip)
    with pytest.raises(DesignError, match="one of paper, fixed_force"):
        controller("magic", grip)
