"""Grips on a closed-form finger: endings, verdicts, and the plant's truth; no mesh, no CAD."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.problem import contact_problem
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.episode import judged_warnings, run_episode, run_episodes
from fingerdesign.control.plants.plant import (
    CondensedPlant,
    Truth,
    is_lifted,
    minimum_stick_ratio,
    press,
    safety_margin,
)
from fingerdesign.control.plants.rig import Rig
from fingerdesign.control.roster import Command
from fingerdesign.control.signals import Sample
from fingerdesign.design.grip import weight_per_finger
from fingerdesign.errors import SolverError
from fingerdesign.sensing.train.paths import RandomGripPath
from fingerdesign.shapes.objects import Plane, touching

BOUNDS = Bounds(preload=0.04, approach_step=0.01, max_approach=0.3, max_steps=40)
MASS = 500.0


class Always:
    """A controller that repeats one command."""

    name = "always"

    def __init__(self, dx, dy):
        self.dx, self.dy = dx, dy

    def start(self, calibration, sample):
        pass

    def command(self, sample):
        return Command(self.dx, self.dy, False)


def grip(half_plane, bench, controller, bounds=BOUNDS, friction=0.5, mass=MASS):
    plant = CondensedPlant(half_plane.with_friction(friction), "both")
    return run_episode(plant, controller, bench, bounds, friction, mass)


def test_a_lift_ends_at_the_first_step_over_the_weight(half_plane, bench):
    episode = grip(half_plane, bench, Always(0.004, 0.01))
    trace, result = episode.trace, episode.result
    assert episode.result.outcome == "lifted"
    assert trace.lift_step == len(trace.dx) - 1
    over = trace.tangential_force > 0.5 * MASS * 1e-3 * 9.80665
    assert over.tolist() == [False] * (len(over) - 1) + [True]
    margin = result.final_normal_force_N / (result.final_tangential_force_N / 0.5)
    assert result.safety_margin == pytest.approx(margin, rel=1e-12)
    assert result.steps == (trace.dx > 0).sum()


class Scripted:
    """A plant whose truths are as written, whatever its moves."""

    def __init__(self, truths):
        self.truths, self.moves = truths, []

    def move(self, dx, dy):
        if len(self.moves) == len(self.truths):
            raise SolverError("no more truths")
        self.moves.append((dx, dy))
        return Sample(np.zeros(11), self.truth().normal_force, 0.0)

    def truth(self):
        return self.truths[len(self.moves) - 1]


class Sure(Always):
    def command(self, sample):
        return Command(self.dx, self.dy, False, unsure=False, warns=False)


PRESS = [
    Truth(0.01 * k, 0.0, normal, 0.1, 0.1, 0.0, False, 0.5, lifted=False)
    for k, normal in enumerate((1.0, 2.0, 9.0, 4.0), 1)
]
HANGS = Truth(0.06, 0.0, 8.0, 2.0, 0.6, 0.0, False, 0.4, lifted=True, rotation=-3.0)


def test_a_grip_counts_its_steps_from_the_preload_and_judges_what_was_true_at_the_lift(
    bench, design
):
    last = replace(HANGS, normal_force=7.0, slip_ratio=0.3, stick_ratio=0.5)
    supported = replace(PRESS[-1], approach=0.05, stick_ratio=0.8)
    plant = Scripted([*PRESS, supported, HANGS, last, last, last])
    bounds = replace(BOUNDS, max_approach=0.06, max_steps=2)
    episode = run_episode(plant, Sure(0.001, 0.01), bench, bounds, 0.5, MASS, after_lift=3)
    result = episode.result
    # The arm raises what hangs by 0.03 mm a step; a hand at the end of its stage closes no more.
    assert np.array(plant.moves[4:6]) == pytest.approx(np.array([[0.001, 0.01]] * 2))
    assert np.array(plant.moves[6:]) == pytest.approx(np.array([[0.031, 0.0]] * 3), abs=1e-12)
    assert (result.outcome, result.steps, result.steps_to_lift) == ("lifted", 5, 2)
    assert (result.peak_normal_force_N, result.final_normal_force_N) == (9.0, 7.0)  # of the press
    assert (result.slip_ratio, result.safety_margin) == (0.4, 0.4 * 8.0 / 2.0)
    assert (result.minimum_stick_ratio, result.rotation_deg) == (0.5, -3.0)
    # A controller knows nothing while the hand presses to the preload.
    assert episode.trace.unsure.tolist() == [True] * 4 + [False] * 5
    assert (episode.trace.lift_step, result.unsure) == (5, False)
    assert judged_warnings(episode, design.grip).samples == 5


@pytest.mark.parametrize(("most", "unsure"), [(None, True), (12.0, False)])
def test_what_crushes_counts_by_the_most_that_pulls_to_the_end(bench, most, unsure):
    """9 N in the press are over three times m g / 2 over the slip ratio, not over that of 12 N."""
    bounds = replace(BOUNDS, max_approach=0.06, max_steps=2)
    given = bench, bounds, 0.5, 200.0, 3, most
    plant = Scripted([*PRESS, *[replace(HANGS, approach=0.05, tangential_force=1.0)] * 5])
    result = run_episode(plant, Sure(0.001, 0.01), *given).result
    assert (result.outcome, result.crushed, result.unsure) == ("lifted", unsure, unsure)


def test_a_press_that_fails_has_no_step_and_a_slide_without_end_is_complete_slip(bench):
    failed = run_episode(Scripted(PRESS[:2]), Sure(0.0, 0.01), bench, BOUNDS, 0.5, MASS).result
    assert (failed.outcome, failed.steps, failed.steps_to_lift) == ("failed", 0, 0)
    assert (failed.minimum_stick_ratio, failed.final_normal_force_N) == (None, 2.0)
    slides = replace(HANGS, sliding=True, complete_slip=True)
    plant = Scripted([*PRESS, replace(HANGS, sliding=False), *[slides] * 20])
    bounds = replace(BOUNDS, max_steps=4)
    result = run_episode(plant, Sure(0.0, 0.0), bench, bounds, 0.5, MASS, after_lift=3).result
    # It is waited for as long as a lift may take, after the steps for which it is held on.
    assert (result.outcome, result.steps) == ("complete slip", 1 + 3 + 4)
    plant = Scripted([*PRESS, replace(slides, lifted=False)])  # on its support nothing is caught
    result = run_episode(plant, Sure(0.0, 0.0), bench, bounds, 0.5, MASS, after_lift=3).result
    assert (result.outcome, result.steps) == ("complete slip", 1)


def test_complete_slip_ends_the_grip_without_a_margin(half_plane, bench):
    episode = grip(half_plane, bench, Always(0.03, 0.001), friction=0.2)
    result = episode.result
    assert (episode.result.outcome, result.gross_slip, result.lifted) == (
        "complete slip",
        True,
        False,
    )
    assert result.safety_margin is None
    assert result.final_tangential_force_N == pytest.approx(0.2 * result.final_normal_force_N)
    assert result.slip_distance_mm > 0.0
    assert result.minimum_stick_ratio < 0.01


def test_sliding_is_not_lifting_and_steps_without_tangential_force_do_not_count():
    assert not is_lifted(Truth(0.1, 0.1, 20.0, 6.0, 0.0, 0.01, complete_slip=True), 500.0)
    assert is_lifted(Truth(0.1, 0.1, 20.0, 6.0, 0.4, 0.0, complete_slip=False), 500.0)
    path = [
        Truth(0.1, 0.1 * k, 1.0, 0.1 * k, stick, 0.0, False)
        for k, stick in enumerate((0.2, 0.7, 0.5))
    ]
    assert minimum_stick_ratio(path) == 0.5
    assert minimum_stick_ratio(path[:1]) is None
    assert safety_margin(path[0], 0.3) is None


@pytest.mark.parametrize("lean", [0.035, -0.035])
def test_an_object_that_leans_is_judged_by_the_ratio_at_which_it_slips(half_plane, bench, lean):
    """At slip margin and utilisation are one, where the coefficient alone would say 17 % else."""
    plane = Plane(0.0, (np.sin(lean), -np.cos(lean), 0.0))
    points = half_plane.model.points
    met = touching(plane, lambda x, z: np.interp(x, *points.T), points[-1, 0], 1.0)[0]
    leaning = contact_problem(half_plane.model, met, 0.2)
    plant = CondensedPlant(leaning, "both")
    for _ in press(plant, 0.05, 0.01):
        pass
    while not plant.truth().complete_slip:
        plant.move(0.002, 0.0)
    truth = plant.truth()
    assert truth.slip_ratio == pytest.approx(np.tan(np.arctan(0.2) + lean))
    assert safety_margin(truth, 0.2) == pytest.approx(1.0, abs=1e-3)
    (utilisation,) = RandomGripPath(0.2, (), (truth,)).friction_utilisation
    assert utilisation == pytest.approx(1.0, abs=1e-3)
    result = grip(leaning, bench, Always(0.0, 0.01)).result
    ratio = np.tan(np.arctan(result.friction_coefficient) + lean)
    assert result.least_force_N == pytest.approx(weight_per_finger(MASS) / ratio)


def test_stage_travel_and_steps_end_it_unlifted_and_a_zone_too_narrow_is_an_error(
    half_plane, bench
):
    travel = grip(half_plane, bench, Always(0.0, 0.01))
    assert travel.result.outcome == "stage travel"
    assert travel.trace.approach[-1] == pytest.approx(BOUNDS.max_approach)
    assert travel.result.safety_margin is None
    steps = grip(half_plane, bench, Always(0.0, 0.01), Bounds(0.04, 0.01, 0.3, max_steps=3))
    assert (steps.result.outcome, steps.result.steps) == ("steps", 3)
    with pytest.raises(ZoneExhausted):  # for whoever made the model
        grip(half_plane, bench, Always(0.0, 0.05), Bounds(0.04, 0.05, 5.0, 40))


def test_a_solver_error_is_a_failed_grip_with_its_sentence(half_plane, bench):
    class Broken(CondensedPlant):
        def move(self, dx, dy):
            if self.truth().approach > 0.1:
                raise SolverError("no accepted answer at approach 0.11")
            return super().move(dx, dy)

    episode = run_episode(Broken(half_plane, "both"), Always(0.001, 0.01), bench, BOUNDS, 0.5, MASS)
    assert episode.result.outcome == "failed"
    assert episode.result.ending == "no accepted answer at approach 0.11"
    assert not episode.result.lifted
    assert not episode.result.gross_slip
    assert episode.result.safety_margin is None
    assert episode.trace.approach.max() <= 0.111

    class Dead(CondensedPlant):
        def move(self, dx, dy):
            raise SolverError("nothing converged")

    episode = run_episode(Dead(half_plane, "both"), Always(0, 0), bench, BOUNDS, 0.5, MASS)
    assert (episode.result.outcome, len(episode.trace.dx)) == ("failed", 0)
    assert episode.result.minimum_stick_ratio is None


def test_calibration_refuses_what_cannot_feel(half_plane):
    def make():
        return CondensedPlant(half_plane, "both")

    with pytest.raises(SolverError, match="at least 2 gages"):
        calibrate(make, np.zeros(1), BOUNDS)

    class Floating(CondensedPlant):
        def move(self, dx, dy):
            return super().move(dx, 0.0)

    with pytest.raises(SolverError, match="does not rise"):
        calibrate(lambda: Floating(half_plane, "both"), np.zeros(11), BOUNDS)


def test_the_rule_on_the_half_plane(half_plane, design):
    """Nothing was tuned on this finger: no complete slip, and without the rule there is."""
    for episode in run_episodes(Rig.of(half_plane, design), (0.2, 0.3, 0.5, 0.8), MASS):
        result, trace = episode.result, episode.trace
        assert (result.lifted, result.gross_slip) == (True, False), episode.result.ending
        assert 1.0 < result.safety_margin < 3.5
        assert np.isfinite(trace.gage_area_mm[-1])
        assert trace.without_rule is not None
        assert not trace.without_rule.hold.any()
        if result.friction_coefficient <= 0.3:
            assert result.holds >= 1
            assert result.slips_without_rule is True


def test_the_plant_feels_what_the_model_says(half_plane):
    plant = CondensedPlant(half_plane, "upper")
    *_, sample = press(plant, 0.05, 0.02)
    assert plant.truth().approach == pytest.approx(0.05)
    assert isinstance(sample, Sample)
    assert sample.normal_force == plant.truth().normal_force > 0.0
    assert sample.tangential_force == pytest.approx(0.0, abs=1e-9)
    # Pure pressing on a symmetric finger: gages at +-45 degrees mirror each other in sign.
    assert sample.readings == pytest.approx(-sample.readings[::-1], abs=1e-6)
    repeated = CondensedPlant(half_plane, "upper")
    *_, again = press(repeated, 0.05, 0.02)
    assert np.array_equal(again.readings, sample.readings)
