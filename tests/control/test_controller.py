"""The rule alone: what it is given, its curve, when it holds, and that it can be replayed."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.control.calibration import Calibration
from fingerdesign.control.controllers.flow_chart import PaperController
from fingerdesign.control.episode import run_episodes
from fingerdesign.control.plants.rig import Rig
from fingerdesign.control.signals import NormalCalibration, Sample, gage_area, response
from fingerdesign.design.grip import Grip

SETTINGS = Grip(
    approach_step_mm=0.01,
    shear_step_mm=0.05,
    curve_per_N=0.1,
    threshold_share=0.5,
    force_floor_N=0.02,
    dead_band_mm=0.1,
    hold_force_N=0.9,  # two moves of the spring below
)
GAGE_X = np.linspace(-2.0, 2.0, 5)
_NORMAL = NormalCalibration(np.array([0.0, 10.0]), np.zeros((2, 5)))
BENCH = Calibration(
    GAGE_X,
    _NORMAL,
    np.array([0.4, 0.8, 1.0, 0.8, 0.4]),
    tangential_stiffness=10.0,
    sticking=_NORMAL,
    stiffness=np.full(2, 10.0),
    approach=np.array([0.0, 0.2]),
)


class Spring:
    """A plant of two springs whose gages respond to F_t by ``response(F_n)``, microstrain/N."""

    def __init__(self, response, normal=50.0, tangential=12.0):
        self.response, self.normal, self.tangential = response, normal, tangential
        self.sample = Sample(np.zeros(5), 1.0, 0.0)

    def move(self, command):
        force = self.sample.normal_force + self.normal * command.dy
        rise = self.tangential * command.dx
        readings = self.sample.readings + self.response(force) * rise
        self.sample = Sample(readings, force, self.sample.tangential_force + rise)
        return self.sample


def drive(plant, controller, steps):
    controller.start(BENCH, plant.sample)
    commands, samples = [], [plant.sample]
    for _ in range(steps):
        commands.append(controller.command(samples[-1]))
        samples.append(plant.move(commands[-1]))
    return commands, samples


def full_stick(force):
    return BENCH.full_stick


def shrinking_from(threshold):
    """Gages at the sides fall silent as F_n passes ``threshold``."""

    def response(force):
        side = float(np.clip(1.0 - (force - threshold), 0.0, 1.0))
        return BENCH.full_stick * np.array([side, side, 1.0, side, side])

    return response


def test_without_shrinking_the_path_is_a_parabola_until_the_shear_step_caps_it():
    commands, samples = drive(Spring(full_stick), PaperController(SETTINGS), 60)
    assert not any(command.hold for command in commands)
    rise = np.array([sample.normal_force for sample in samples[2:13]]) - 1.0
    tangential = np.array([sample.tangential_force for sample in samples[2:13]])
    # The first dF_n is not known yet, and the stiffness is learnt (10 assumed, 12 true).
    assert tangential[3:] == pytest.approx(SETTINGS.curve_per_N * rise[3:] ** 2, rel=1e-6)
    assert max(command.dx for command in commands) == SETTINGS.shear_step_mm
    assert all(command.dy == SETTINGS.approach_step_mm for command in commands)
    for command, sample in zip(commands, samples[:-1], strict=True):
        assert (command.area is None) == (sample.tangential_force < SETTINGS.force_floor_N)


def test_shrinking_area_holds_and_the_curve_restarts_at_the_end_of_the_hold():
    commands, samples = drive(Spring(shrinking_from(3.0)), PaperController(SETTINGS), 18)
    holds = [k for k, command in enumerate(commands) if command.hold]
    first = holds[0]
    assert holds[:2] == [first, first + 1]
    assert not commands[first + 2].hold
    assert all(commands[k].dx == 0.0 for k in holds)
    assert samples[first].normal_force > 3.0
    # The hold is over after the second still move; from there F_t is quadratic again.
    origin, later = samples[first + 2], samples[first + 5]
    assert later.tangential_force - origin.tangential_force == pytest.approx(
        SETTINGS.curve_per_N * (later.normal_force - origin.normal_force) ** 2, rel=1e-6
    )


def test_a_fall_within_the_dead_band_is_not_a_shrinking():
    wide = SETTINGS.model_copy(update={"dead_band_mm": 5.0})
    commands, _ = drive(Spring(shrinking_from(3.0)), PaperController(wide), 18)
    assert not any(command.hold for command in commands)
    areas = [command.area for command in commands if command.area is not None]
    assert max(areas) - areas[-1] > SETTINGS.dead_band_mm


def commanded(*forces, start=(1.0, 0.0)):
    """Commands on samples of these forces (F_n, F_t) whose gages read nothing."""
    controller = PaperController(SETTINGS)
    controller.start(BENCH, Sample(np.zeros(5), *start))
    return [controller.command(Sample(np.zeros(5), *each)) for each in forces]


def test_the_curve_is_aimed_at_the_force_expected_next_and_never_at_a_smaller_one():
    first, falls = commanded((1.5, 0.0), (1.4, 0.0))
    assert first.dx == pytest.approx(0.1 * (1.5 + 0.5 - 1.0) ** 2 / 10.0)
    assert falls.dx == pytest.approx(0.1 * (1.4 - 1.0) ** 2 / 10.0)


def test_a_tiny_pull_does_not_teach_the_stiffness_and_a_fall_of_the_pull_shows_an_area():
    tiny, then = commanded((1.05, 0.0), (1.5, 0.05))  # 0.1 micrometres; 0.05 N by the press
    assert 0.0 < tiny.dx < 0.001
    assert then.dx == pytest.approx((0.1 * (1.5 + 0.45 - 1.0) ** 2 - 0.05) / 10.0)
    assert [each.area for each in commanded((1.0, 0.49), (1.0, 0.3), start=(1.0, 0.5))] == [None, 0]


@pytest.mark.parametrize(("rule", "warns"), [(True, False), (False, None)])
def test_a_rule_that_is_on_says_that_a_lifted_object_is_not_warned_of(rule, warns):
    controller = PaperController(SETTINGS, rule=rule)
    controller.start(BENCH, Sample(np.zeros(5), 1.0, 0.0))
    command = controller.command(Sample(np.zeros(5), 1.0, 0.5, lifted=True))
    assert (command.dx, command.dy, command.hold, command.warns) == (0.0, 0.0, False, warns)


def test_gages_out_of_order_change_nothing():
    order = np.array([3, 0, 4, 2, 1])

    def shuffled(force):
        return shrinking_from(3.0)(force)[order]

    mixed = replace(BENCH, gage_x=GAGE_X[order], full_stick=BENCH.full_stick[order])
    plain, _ = drive(Spring(shrinking_from(3.0)), PaperController(SETTINGS), 18)
    plant, controller = Spring(shuffled), PaperController(SETTINGS)
    controller.start(mixed, plant.sample)
    for expected in plain:
        command = controller.command(plant.sample)
        assert command == expected
        plant.move(command)


def test_gages_of_a_row_along_z_change_nothing():
    def with_others(force):
        return np.append(shrinking_from(3.0)(force), [0.0, 0.0])

    none = np.array([np.nan, np.nan])
    more = replace(
        BENCH,
        gage_x=np.append(GAGE_X, none),
        full_stick=np.append(BENCH.full_stick, [0.0, 0.0]),
        normal=NormalCalibration(np.array([0.0, 10.0]), np.zeros((2, 7))),
    )
    plain, _ = drive(Spring(shrinking_from(3.0)), PaperController(SETTINGS), 18)
    plant, controller = Spring(with_others), PaperController(SETTINGS)
    plant.sample = Sample(np.zeros(7), 1.0, 0.0)
    controller.start(more, plant.sample)
    for expected in plain:
        command = controller.command(plant.sample)
        assert command == expected
        plant.move(command)


def test_replayed_arrays_give_the_same_commands(half_plane, design):
    """The trace's plain arrays are all that the controller had."""
    episode = run_episodes(Rig.of(half_plane, design), [0.3], 500.0)[0]
    trace, grip = episode.trace, design.grip
    assert episode.result.holds > 0
    calibration = Rig(half_plane, "both", grip).calibration()
    felt = [
        Sample(readings, normal, tangential)
        for readings, normal, tangential in zip(
            trace.gage_readings, trace.normal_force, trace.tangential_force, strict=True
        )
    ]
    start = len(trace.dx) - episode.result.steps  # before it: the preload's moves
    controller = PaperController(grip)
    controller.start(calibration, felt[start - 1])
    replayed = [controller.command(sample) for sample in felt[start - 1 : -1]]
    assert [c.dx for c in replayed] == trace.dx[start:].tolist()
    assert [c.dy for c in replayed] == trace.dy[start:].tolist()
    assert [c.hold for c in replayed] == trace.hold[start:].tolist()


def test_the_floor_is_of_the_changes_size_whichever_way_it_goes():
    """A pull that falls by more than the floor is as good for A as one that rises."""
    responses = np.array([0.0, 2.0, 2.0, 2.0, 0.0])
    for change, area in ((0.5, 3.0), (-0.5, 3.0), (0.01, 7.0), (-0.01, 7.0)):
        assert gage_area(GAGE_X, responses, 1.0, 7.0, change, 0.02) == area
    still = Sample(responses, 1.0, 0.5)
    assert np.isnan(response(still, replace(still, readings=2.0 * responses))).all()
