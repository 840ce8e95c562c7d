"""The Gymnasium environment: its checker, seeds, endings and rewards, what fails, the docs."""

from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign.checks.load import with_values
from fingerdesign.control.estimator import Estimated
from fingerdesign.control.plants.lift import LiftPlant
from fingerdesign.control.plants.plant import press
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.trials import environment as module
from fingerdesign.trials.environment import STEP_COST, GripEnvironment
from tests.support.pages import blocks, run_python
from tests.support.session import never_called


def test_without_gymnasium_the_install_command_is_printed(not_installed, design, half_plane):
    not_installed("gymnasium")
    with pytest.raises(ImportError, match=r'pip install "fingerdesign\[gym\]"'):
        GripEnvironment(design, problem=half_plane)


@pytest.fixture(scope="module")
def gymnasium():
    return pytest.importorskip(
        "gymnasium", reason="gymnasium is missing: pip install 'fingerdesign[gym]'"
    )


@pytest.fixture
def made(gymnasium, design, half_plane):
    """An environment of the closed-form finger; mu = 0.5, 200 g, no noise, unless given."""

    def make(values=None, **given):
        given = {"frictions": (0.5, 0.5), "masses_g": (200.0, 200.0)} | given
        given = {"noise_microstrain": 0.0} | given
        values = {"grip.plant": "lift"} | (values or {})
        return GripEnvironment(with_values(design, values), problem=half_plane, **given)

    return make


def until_the_end(environment, action, seed=0):
    """Every step's answer, the action the same."""
    environment.reset(seed=seed)
    steps = [environment.step(action)]
    while not (steps[-1][2] or steps[-1][3]):
        steps.append(environment.step(action))
    return steps


GENTLE = (0.05, 0.4)


def test_gymnasiums_checker_passes(made):
    from gymnasium.utils.env_checker import check_env

    environment = made(frictions=(0.2, 0.8), noise_microstrain=0.5)
    check_env(environment, skip_render_check=True)
    assert environment.observation_space.low[-3:].tolist() == [0.0, -1.0, 0.0]


def test_estimates_are_the_estimators_of_samples_and_the_moves_that_they_answer(made, monkeypatch):
    """Two samples of delay: the first two samples answer no move."""
    seen, levels = [], []

    class Reports:
        gages = 11

        def at_noise(self, noise):
            levels.append(noise)
            return self

        def estimate(self, history):
            seen.append([(each.dx, each.dy) for each in history])
            return Estimated(0.5, 0.25, 0.125)

    monkeypatch.setattr(module, "estimator_faults", lambda *_: [])
    own = made({"grip.hardware.delay_samples": 2}, estimates=Reports(), noise_microstrain=0.25)
    assert (levels, own.observation_space.low[-3:].tolist()) == ([0.25], [0.0] * 3)
    first, _ = own.reset(seed=0)
    assert first[-3:].tolist() == [0.5, 0.25, 0.125]
    assert own.observation_space.contains(first)
    pressed = len(seen)
    for action in ((0.1, 0.5), (0.05, 0.0)):
        own.step(action)
    found, *_ = own.step((0.0, 0.0))
    assert found.shape == (11 + 8,)
    (history,) = seen[-1:]
    assert len(history) == pressed + 3
    assert history[:2] == [(0.0, 0.0)] * 2
    sheared, closed = 0.1 * own._grip.shear_step_mm, 0.5 * own._bounds.approach_step
    assert history[-1] == pytest.approx((sheared, closed))
    assert sum(dy for _, dy in history[:-1]) == pytest.approx(own._bounds.preload)


def test_a_training_is_announced_before_it_begins(made):
    """It takes half an hour, and a notebook shows nothing meanwhile."""
    with (
        pytest.warns(UserWarning, match="no estimator ships for half-plane in plane-strain, with"),
        pytest.raises(pytest.fail.Exception, match="work was begun"),
        never_called(module, "estimator_of"),
    ):
        made(estimates=True)


def test_an_estimator_of_another_finger_is_refused(made):
    with pytest.raises(DesignError, match="estimator = one"):
        made(estimates=SimpleNamespace(gages=11, design="f" * 64))


def test_a_seed_is_an_episode(made):
    environment = made(frictions=(0.2, 0.8), masses_g=(100.0, 1000.0), noise_microstrain=0.5)
    first, again = (until_the_end(environment, GENTLE, seed=7) for _ in range(2))
    assert [step[1:] for step in first] == [step[1:] for step in again]
    assert all(np.array_equal(a[0], b[0]) for a, b in zip(first, again, strict=True))
    infos = [environment.reset(seed=seed)[1] for seed in range(200)]
    frictions = [info["friction_coefficient"] for info in infos]
    masses = [info["object_mass_g"] for info in infos]
    assert 0.2 <= min(frictions) < 0.23 < 0.77 < max(frictions) <= 0.8
    assert 100.0 <= min(masses) < 120.0 < 850.0 < max(masses) <= 1000.0
    assert np.median(masses) == pytest.approx(1000.0**0.5 * 10.0, rel=0.15)


def test_it_feels_what_the_plant_feels_and_is_rewarded_by_the_margin(made, half_plane, design):
    steps = until_the_end(made({"grip.hold_steps": 3}), GENTLE)
    plant = LiftPlant(half_plane, "both", 200.0)
    list(press(plant, design.grip.preload_mm, design.grip.approach_step_mm))
    ways = np.array(GENTLE) * [design.grip.shear_step_mm, design.grip.approach_step_mm]
    for observation, _, _, _, info in steps:
        felt = plant.move(*ways)
        forces = [felt.normal_force, felt.tangential_force]
        assert observation == pytest.approx([*felt.readings, *forces, *GENTLE, float(felt.lifted)])
        judged = info["stick_ratio"], info["rise_mm"]
        assert judged == pytest.approx((plant.truth().stick_ratio, plant.truth().rise), rel=1e-9)
    _, reward, terminated, truncated, info = steps[-1]
    assert (info["ending"], terminated, truncated) == ("lifted", True, False)
    assert [step[0][-1] for step in steps[-5:]] == [0.0, 1.0, 1.0, 1.0, 1.0]
    margin = 0.5 * felt.normal_force / felt.tangential_force
    assert info["safety_margin"] == pytest.approx(margin)
    assert reward == pytest.approx(1.0 - 0.5 * (margin - 1.0) - STEP_COST)
    assert {step[1] for step in steps[:-1]} == {-STEP_COST}
    assert not any("ending" in step[4] for step in steps[:-1])


@pytest.mark.parametrize(
    ("action", "values", "given", "ending", "truncated"),
    [
        ((1.0, 0.0), {}, {}, "complete slip", False),
        ((0.0, 1.0), {}, {}, "crushed", False),
        ((0.0, 1.0), {}, {"masses_g": (9e3, 9e3)}, "stage travel", False),
        ((0.0, 0.0), {"grip.max_steps": 5, "grip.hold_steps": 2}, {}, "steps", True),
    ],
)
def test_endings(made, action, values, given, ending, truncated):
    environment = made(values, **given)
    steps = until_the_end(environment, action)
    assert len(until_the_end(environment, action)) == len(steps)  # counted anew
    _, reward, terminated, cut, info = steps[-1]
    assert (info["ending"], terminated, cut) == (ending, not truncated, truncated)
    assert reward == -STEP_COST - (not truncated)
    assert ending != "steps" or len(steps) == 7
    assert ending != "stage travel" or steps[-1][0][-2] < 1.0  # the stage went what was left


def test_a_hand_at_the_end_of_its_stage_goes_on_holding_and_may_let_go(made):
    short = {"grip.hold_steps": 10, "grip.max_approach_mm": 0.12}
    *_, (observation, _, terminated, _, info) = until_the_end(made(short), GENTLE)
    assert (info["ending"], terminated) == ("lifted", True)
    assert observation[-2] == pytest.approx(0.0, abs=1e-6)
    environment = made({"grip.hold_steps": 50})
    environment.reset(seed=0)
    while not environment.step(GENTLE)[0][-1]:
        pass
    for _ in range(50):
        _, reward, terminated, _, info = environment.step((1.0, -1.0))
        if terminated:
            break
    assert (info["ending"], reward) == ("complete slip", -1.0 - STEP_COST)
    # The stage does not open beyond touch.
    environment.reset(seed=0)
    moves = [environment.step((0.0, -7.0))[0][-2] for _ in range(6)]
    assert moves == pytest.approx([-1.0, -1.0, -1.0, 0.0, 0.0, 0.0], abs=1e-6)
    observation, *_, info = environment.step((0.0, 0.5))
    assert observation[-5] > 0.0
    assert "safety_margin" not in info  # nothing pulls


def test_what_the_solver_cannot_answer_ends_the_episode_with_its_sentence(made, monkeypatch):
    from gymnasium.error import ResetNeeded

    environment, other = made(), made()
    with pytest.raises(ResetNeeded):
        environment.step(GENTLE)
    environment.reset(seed=0), other.reset(seed=0)
    before, *_ = environment.step(GENTLE)

    def fail(*_):
        raise SolverError("no accepted answer")

    with monkeypatch.context() as patched:
        patched.setattr(LiftPlant, "move", fail)
        observation, reward, terminated, truncated, info = environment.step(GENTLE)
        with pytest.raises(SolverError):
            other.reset(seed=0)
    with pytest.raises(ResetNeeded):  # the episode before it is over, too
        other.step(GENTLE)
    assert (reward, terminated, truncated) == (-STEP_COST, False, True)
    assert (info["ending"], info["reason"]) == ("failed", "no accepted answer")
    assert "stick_ratio" not in info
    assert np.array_equal(observation, before)
    with pytest.raises(ResetNeeded):
        environment.step(GENTLE)
    assert environment.reset(seed=0)[1]["stick_ratio"] > 0.5


def test_hardware_and_tugs_count(made):
    def last(**values):
        named = {f"grip.{key.replace('__', '.')}": value for key, value in values.items()}
        return until_the_end(made({"grip.hold_steps": 3} | named), GENTLE)[-1]

    plain = last()
    assert not last(hardware__dead_gages=[4])[0][4]
    assert plain[0][4]
    tug = {"step_after_lift": 2, "extra_force_N": 30.0}
    assert last(tugs=[tug])[4]["ending"] == "complete slip"


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"frictions": (0.0, 0.5)}, "frictions"),
        ({"frictions": (0.5, 0.2)}, "frictions"),
        ({"masses_g": (100.0,)}, "masses_g"),
        ({"masses_g": (100.0, float("nan"))}, "masses_g"),
        ({"noise_microstrain": -1.0}, "noise_microstrain"),
        ({"values": {"plates.count": 9}}, "problem"),
    ],
)
def test_wrong_input_is_refused_by_name(made, given, named):
    with pytest.raises(DesignError) as refused:
        made(**given)
    assert [fault.key for fault in refused.value.faults] == [named]


def test_options_of_a_reset_take_the_place_of_what_is_drawn(made):
    environment = made(frictions=(0.2, 0.8), masses_g=(100.0, 300.0))
    drawn = environment.reset(seed=2)[1]
    own = environment.reset(seed=2, options={"object_mass_g": 250.0})[1]
    assert own["object_mass_g"] == 250.0
    assert own["friction_coefficient"] == drawn["friction_coefficient"]
    with pytest.raises(ValueError, match="options: mass is unknown"):
        environment.reset(options={"mass": 250.0})
    with pytest.raises(DesignError, match="frictions"):
        environment.reset(options={"friction_coefficient": 0.0})


def test_noise_is_in_the_gages_alone_and_what_cannot_be_is_refused(made):
    quiet, loud = (made(noise_microstrain=noise).reset(seed=3)[0] for noise in (0.0, 0.5))
    assert 0.2 < np.std(loud[:11] - quiet[:11]) < 1.0
    assert np.array_equal(loud[11:], quiet[11:])
    tug = {"step_after_lift": 1, "extra_force_N": -3.0}  # of 0.1 kg, not of the design's 0.5 kg
    with pytest.raises(ValueError, match="lifts the object out"):
        made({"grip.tugs": [tug], "grip.hold_steps": 3}, masses_g=(100.0, 1000.0))
    environment = made()
    environment.reset(seed=0)
    with pytest.raises(ValueError, match="finite"):
        environment.step((float("nan"), 0.0))
    with pytest.raises(ValueError, match="two numbers"):
        environment.step([0.1])


def test_hands_of_the_docs_lift(gymnasium, capsys):
    page = "explanation/plants.md"
    run_python(page, next(k for k, each in enumerate(blocks(page)) if "gymnasium" in each))
    shape, lifted = capsys.readouterr().out.rsplit(maxsplit=1)
    assert shape == "(4, 20)"
    assert int(lifted) >= 4


def test_lifts_are_of_the_designs_own_face_other_finger_and_noise(made, softer, calls_of):
    lifts, hardware = calls_of(LiftPlant, "of"), calls_of(module, "ImperfectPlant")
    values = {"gages.face": "upper", "grip.hardware.gage_noise_microvolt_per_V": 9.0}
    environment = made(values, noise_microstrain=0.25)
    environment._opposite = softer
    environment.reset(options={"friction_coefficient": 0.3, "object_mass_g": 150.0})
    assert lifts[-1][0][2:] == ("upper", 0.3, 150.0, softer)
    noise = hardware[-1][0][1]
    assert (noise.gage_noise_microstrain, noise.gage_noise_microvolt_per_V) == (0.25, 0.0)
