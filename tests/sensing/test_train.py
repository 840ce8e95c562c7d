"""Training: seeded random grip paths, their samples, errors below those of a guess, the cache."""

import _thread
import contextlib
import signal
import threading
from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.control.calibration import Bounds
from fingerdesign.control.estimator import GripEstimator, outputs_of
from fingerdesign.control.features import feature_count
from fingerdesign.design.grip import Grip
from fingerdesign.errors import SolverError
from fingerdesign.sensing.model import seconds_of_many
from fingerdesign.sensing.train import estimator as estimator_module
from fingerdesign.sensing.train import network
from fingerdesign.sensing.train import policy as policy_module
from fingerdesign.sensing.train import result as training
from fingerdesign.sensing.train.estimator import BANDS, NOISES, train_estimator
from fingerdesign.sensing.train.paths import FRICTIONS, Settings, random_grip_paths
from fingerdesign.sensing.train.policy import policy_grips
from fingerdesign.sensing.train.samples import _noisy, finger_curves, sample, sample_grips

BOUNDS = Bounds(preload=0.01, approach_step=0.004, max_approach=0.12, max_steps=0)
COARSE = {"plates.count": 3, "mesh.section.contact_size_mm": 0.4}
SETTINGS = Settings(face="upper", bounds=BOUNDS, grips=60, replicates=1, seed=1)


@contextlib.contextmanager
def epochs(count):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(network, "_SCHEDULE", ((2e-3, count),))
        yield


@pytest.fixture(scope="module", autouse=True)
def short_schedule():
    """Train two epochs where the errors do not matter."""
    with epochs(2):
        yield


@pytest.fixture(scope="module")
def problem(half_plane):
    model = half_plane.model.with_gages((2, 5, 8))
    return replace(half_plane, model=model)


@pytest.fixture(scope="module")
def grips(problem):
    return random_grip_paths(problem, SETTINGS)


def test_random_grip_paths_are_those_of_their_seed_and_meet_all_states(problem, grips):
    few = random_grip_paths(problem, replace(SETTINGS, grips=3))
    for again, before in zip(few, grips[:3], strict=True):
        assert again.friction_coefficient == before.friction_coefficient
        assert again.truths == before.truths
    other = random_grip_paths(problem, replace(SETTINGS, grips=1, seed=2))
    assert other[0].friction_coefficient != grips[0].friction_coefficient
    frictions = [each.friction_coefficient for each in grips]
    assert FRICTIONS[0] <= min(frictions) < 0.25 < 0.6 < max(frictions) <= FRICTIONS[1]
    used = np.concatenate([each.friction_utilisation for each in grips])
    assert used.min() < 0.3
    assert 0.9 < used.max() <= 1.0 + 1e-6
    stick = [t.stick_ratio for each in grips for t in each.truths if t.stick_ratio is not None]
    assert min(stick) < 0.2
    assert max(stick) > 0.9


def test_what_is_sampled_has_the_noise_that_was_requested(problem, grips):
    curves = finger_curves(problem, "upper", BOUNDS)
    quiet, truths = sample(grips[0], curves, SETTINGS, np.random.default_rng(0), 0.0)
    loud, same = sample(grips[0], curves, SETTINGS, np.random.default_rng(0), 10.0)
    assert quiet.shape == (len(truths), feature_count(3))
    assert np.array_equal(truths, same)
    assert np.abs(loud[:, :3] - quiet[:, :3]).mean() > 0.0


def test_each_force_has_noise_of_its_own(grips):
    """Of 2000 samples of one moment, none of the noises goes with another."""
    moment, rng = grips[0].moments[-1], np.random.default_rng(0)
    settings = replace(SETTINGS, force_noise=0.1)
    noisy = [_noisy(moment, 0.5, np.ones(3), settings, rng).sample for _ in range(2000)]
    forces = np.array([[each.normal_force, each.tangential_force] for each in noisy])
    parts = np.column_stack([forces, [each.readings for each in noisy]])
    true = moment.sample
    assert parts[:, :2].mean(axis=0) == pytest.approx(
        [true.normal_force, true.tangential_force], abs=0.01
    )
    assert parts.std(axis=0) == pytest.approx([0.1, 0.1, 0.5, 0.5, 0.5], rel=0.1)
    assert np.abs(np.corrcoef(parts.T) - np.eye(5)).max() < 0.1


@pytest.mark.slow
def test_samples_are_the_same_in_any_number_of_processes(problem, grips):
    curves = finger_curves(problem, "upper", BOUNDS)
    twice = replace(SETTINGS, replicates=2)
    alone, shared = (sample_grips(grips, curves, twice, (0.5, 1.0), each) for each in (1, 2))
    for one, other in zip(alone, shared, strict=True):
        assert np.array_equal(one, other, equal_nan=True)
    some = sample_grips(grips[:2], curves, twice, (0.5, 1.0))[0]
    assert np.array_equal(some, alone[0][: len(some)], equal_nan=True)  # whatever others there are
    half = len(some) // 2
    assert not np.array_equal(some[:half], some[half:], equal_nan=True)


@pytest.mark.slow
def test_samples_of_smooth_objects_weigh_more(problem, grips):
    curves = finger_curves(problem, "upper", BOUNDS)
    inputs, _, weights = sample_grips(grips[:2], curves, SETTINGS, (0.5, 1.0))
    own = [1.0 / each.friction_coefficient for each in grips[:2]]
    assert len(weights) == len(inputs)
    assert list(dict.fromkeys(weights)) == pytest.approx(own)
    # Where samples with the same features disagree, the network takes their weighted mean.
    rows, weights = np.zeros((1200, 4), dtype=np.float32), np.tile([1.0, 1.0, 6.0], 400)
    truths = np.tile([[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]], (400, 1))
    with network.without_convergence_warnings():
        layers = network.train_layers(rows, truths, [(1e-3, 200)], 0, weights)
    assert outputs_of(layers, rows[:1])[0] == pytest.approx([0.25, 0.75], abs=0.03)


def test_errors_are_predicted_by_networks_of_the_other_half(calls_of):
    """One of the same grips knows them: its errors would be too small."""
    calls, chance = calls_of(network, "train_layers"), np.random.default_rng(0)
    inputs, truths = chance.standard_normal((40, 3)), chance.uniform(0.0, 1.0, (40, 2))
    network.fit_band(inputs, truths, np.ones(40), 1.0, 0)
    for (given, _), tested in zip(calls, (slice(0, 20), slice(20, None)), strict=False):
        assert given[1] == pytest.approx(np.delete(truths, tested, axis=0))
    assert len(calls) == 3


def test_an_estimator_beats_a_guess_and_its_file_gives_the_same(problem, grips):
    with epochs(25):
        bands = ((0.25, 15.0),)
        result = train_estimator(problem, "key", SETTINGS, grips=grips, bands=bands)
    used = np.concatenate([each.friction_utilisation for each in grips])
    assert result.noises_microstrain == NOISES
    assert result.friction_utilisation_errors[0] < 0.7 * used.std()
    predicted, std = result.estimator.bands[0].spread.T
    assert (std > 0.0).all()
    assert (np.diff(predicted) >= 0.0).all()
    # It knows where it errs. Nine held-out grips of four seeds have 1.15 to 1.45 (without weights
    # 1.2 to 1.7): the samples of smooth objects alone decide more of the training.
    assert std[-3:].mean() > 1.1 * std[:3].mean()
    again = GripEstimator.from_json(result.estimator.to_json())
    history = grips[0].moments[:20]
    assert again.estimate(history).friction_utilisation == pytest.approx(
        result.estimator.estimate(history).friction_utilisation, abs=1e-3
    )


def test_the_grips_of_a_policy_depend_on_their_seed_and_are_true(problem, grips, calls_of):
    policy = train_estimator(problem, "pilot", SETTINGS, grips=grips, bands=BANDS[:1]).estimator
    assert len(policy.bands) == 1
    grip = Grip(preload_mm=0.01, max_approach_mm=0.12, max_steps=40)

    def own(seed):
        return policy_grips(problem, [problem] * 2, "upper", grip, policy, seed)

    episodes = calls_of(policy_module, "run_episode")
    first = own(0)
    delays = [(plant._hardware.delay_samples, known.delay) for (plant, _, known, *_), _ in episodes]
    assert all(had == known for had, known in delays)
    assert len({had for had, _ in delays}) > 1
    assert [each.truths for each in own(0)] == [each.truths for each in first]
    assert own(1)[0].friction_coefficient != first[0].friction_coefficient
    for each in first:
        assert max(each.friction_utilisation) <= 1.0 + 1e-6
        pulled = sum(moment.dx for moment in each.moments if not moment.sample.lifted)
        assert pulled > 0.0


@pytest.mark.slow
def test_errors_are_of_other_fingers_where_there_are_some(problem, grips):
    """Sixty grips, of one finger or of so many; the first nine are held out."""
    curves = finger_curves(problem, "upper", BOUNDS)
    curves = [copy(curves) for _ in range(20)]  # Fingers are told apart by their own.
    # Each finger has so many grips; one with training grips is no test finger.
    for each, fingers, judged in ((60, 0, 9), (3, 3, 9), (4, 2, 8), (20, 0, 9)):
        made = [replace(grip, curves=curves[k // each]) for k, grip in enumerate(grips)]
        made = grips if each == 60 else made
        found = train_estimator(problem, "key", SETTINGS, grips=made, bands=BANDS[:1])
        assert (found.judged_fingers, found.judged_grips) == (fingers, judged)


def test_too_few_grips_are_refused(problem, grips):
    with pytest.raises(SolverError, match="more grips"):
        train_estimator(problem, "key", SETTINGS, grips=grips[:4])


def interrupted_after(fingers):
    """A report that ends a training when so many fingers are ready."""
    seen = []

    def report(message):
        seen.extend([message] if message.startswith("grips:") else [])
        if len(seen) == fingers:
            raise KeyboardInterrupt

    return report


@pytest.mark.slow
def test_an_interrupted_training_goes_on_and_is_that_of_any_workers(cache_in, calls_of, tmp_path):
    keys = {"training_fingers": 4, "training_grips": 50}
    values = {f"grip.regulator.{key}": value for key, value in keys.items()}
    design = with_values(load_design("sensitive"), values | COARSE | {"grip.max_steps": 40})
    with epochs(8):
        cache_in(tmp_path / "2")
        fits = calls_of(estimator_module, "fit_band")
        two = training.training_result_for(design, workers=2)
        assert [given[-1] for given, _ in fits] == [1, 4, 4]  # samples of a grip: the pilot has one
        cache_in(tmp_path / "1")
        with pytest.raises(KeyboardInterrupt, match="finished fingers are stored"):
            training.training_result_for(design, interrupted_after(1))
        stored = (tmp_path / "1/trained fingers").glob("*.npz")
        made = {path: path.stat().st_ino for path in stored}
        assert 0 < len(made) < 4
        with pytest.raises(KeyboardInterrupt):
            training.training_result_for(design, interrupted_after(3))
        assert {path: path.stat().st_ino for path in made} == made
        one = training.training_result_for(design)
    assert not list(tmp_path.glob("*/trained fingers/*.npz"))
    assert one.estimator.to_json() == two.estimator.to_json()
    assert len(one.estimator.bands) == 2
    assert one.friction_utilisation_errors[0] < 0.35


@pytest.mark.slow
def test_training_is_cached_and_repeated_for_a_broken_file(problem, own_cache, tmp_path):
    keys = {"grip.regulator.training_fingers": 1, "grip.regulator.training_grips": 50}
    keys |= {"grip.max_approach_mm": 0.12, "grip.preload_mm": 0.01}
    design = with_values(load_design("sensitive"), keys | COARSE)

    def stored():
        return {path: path.stat().st_mtime_ns for path in (tmp_path / "training").glob("*.txt")}

    first = training.training_result_for(design)
    ((path, made),) = stored().items()
    assert training.training_result_for(design).stick_errors == first.stick_errors
    # Controllers' parameters need no other training; another finger does.
    training.training_result_for(with_values(design, {"grip.regulator.target": 0.7}))
    assert stored() == {path: made}
    with pytest.raises(KeyboardInterrupt):
        training.training_result_for(with_values(design, {"plates.count": 4}), interrupted_after(1))
    path.write_text(path.read_text()[:1000])
    again = training.training_result_for(design)
    assert again.stick_errors == first.stick_errors
    assert len(path.read_text()) > 1000


def test_a_finger_of_a_training_is_forecast_by_its_layers():
    both, one = (
        with_values(load_design("film_tees"), {"gages.face": face}) for face in ("both", "upper")
    )
    three, four = (seconds_of_many(each, "3d") for each in (both, one))
    assert 1.3 < four / three < 2.5
    assert three > 3.0 * seconds_of_many(both, "plane-strain")


def test_what_is_in_the_cache_does_not_change_the_forecast(calls_of, own_cache):
    """Timed, a half finger from the cache made a forecast of 78 minutes for a training of 7."""
    design = with_values(load_design("film_tees"), COARSE)
    calls = calls_of(training, "training_seconds")

    def ends(message):
        if message.startswith("training on"):
            raise KeyboardInterrupt

    for _ in range(2):  # from nothing, then with the model in the cache
        with pytest.raises(KeyboardInterrupt):
            training.training_result_for(design, ends)
    assert [given[2] for given, _ in calls] == 2 * [seconds_of_many(design, "plane-strain")]


def test_an_interruption_ends_a_training():
    """To scikit-learn it is a warning: the network would go on half trained."""
    rows = np.random.default_rng(0).normal(size=(4000, 20)).astype(np.float32)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # Some shells ignore it.
    threading.Timer(0.5, _thread.interrupt_main).start()
    try:
        with pytest.raises(KeyboardInterrupt), network.without_convergence_warnings():
            network.train_layers(rows, rows[:, :2], [(1e-3, 3000)], 0)
    finally:
        signal.signal(signal.SIGINT, before)
