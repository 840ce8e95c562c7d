"""The estimator's file, its features, and the regulator's moves on what a fake estimator tells."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from fingerdesign.control.calibration import Calibration
from fingerdesign.control.completion import Relations
from fingerdesign.control.controllers.friction_belief import (
    _EXPONENT,
    _MOST_EXPONENT,
    _PRIOR,
    FrictionBelief,
)
from fingerdesign.control.controllers.regulator import Regulator, RegulatorTable
from fingerdesign.control.estimator import (
    OUTLIER,
    Band,
    Estimated,
    EstimatorError,
    GripEstimator,
    Layer,
)
from fingerdesign.control.features import (
    LAGS,
    FingerCurves,
    Moment,
    feature_count,
    feature_rows,
    features,
    readings_at,
)
from fingerdesign.control.roster import Object
from fingerdesign.control.signals import NormalCalibration, Sample
from fingerdesign.design.grip import Grip

GAGES = 3
FALLEN = 2.0**-_EXPONENT  # A friction by the prior alone, where the force has doubled.
CURVES = FingerCurves(
    np.array([0.0, 1.0, 2.0]),
    np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [2.0, 4.0, 6.0]]),
    np.full((3, GAGES), 10.0),
    np.array([0.0, 0.03, 0.06]),
    np.full(3, 10.0),
    np.array([3.0, 3.0, 5.0]),
)


def estimator(seed=0):
    rng = np.random.default_rng(seed)
    count = feature_count(GAGES)
    layers = (
        Layer(rng.standard_normal((count, 5)), rng.standard_normal(5)),
        Layer(rng.standard_normal((5, 3)), rng.standard_normal(3)),
    )
    spread = np.array([[0.5, 0.1], [1.0, 0.05]])
    numbers = np.zeros(count), np.ones(count), Relations.of_neighbours(GAGES), layers, spread
    band = Band(1.6, *numbers)
    return GripEstimator("digest", CURVES, 0.5, (band, replace(band, most_noise=15.0)))


def moment(normal=1.0, tangential=0.2, dx=0.01, dy=0.0, readings=None):
    values = np.array([1.0, 2.0, 3.0]) if readings is None else np.asarray(readings, dtype=float)
    return Moment(Sample(values, normal, tangential), dx, dy)


def test_a_file_brings_the_same_estimator_back_and_each_noise_has_its_network():
    before = estimator()
    after = GripEstimator.from_json(before.to_json())
    history = [moment(1.0, 0.1), moment(1.2, 0.3)]
    assert after.estimate(history).friction_utilisation == pytest.approx(
        before.estimate(history).friction_utilisation, abs=1e-3
    )  # 16-bit weights
    assert after.to_json() == before.to_json()
    bands = [before.at_noise(noise).band for noise in (1.0, 1.6, 2.0, 15.0, 100.0)]
    assert [before.bands.index(band) for band in bands] == [0, 0, 1, 1, 1]


def test_a_file_holds_16_bits_a_weight_and_one_of_full_weights_is_read_too():
    before = estimator()
    text = before.to_json()
    again = GripEstimator.from_json(text)
    for mine, other in zip(before.bands[0].layers, again.bands[0].layers, strict=True):
        most = np.abs(mine.weight).max(axis=0)
        assert (np.abs(other.weight - mine.weight).max(axis=0) <= 0.51 * most / 32767).all()
    record = json.loads(text)
    for band in record["bands"]:
        for data, layer in zip(band["layers"], before.bands[0].layers, strict=True):
            del data["weight_base64"], data["weight_scale"]
            data["weight"] = layer.weight.tolist()
    full = GripEstimator.from_json(json.dumps(record))
    assert np.array_equal(full.bands[0].layers[0].weight, before.bands[0].layers[0].weight)
    size = len(json.dumps(record["bands"][0]["layers"]))
    assert len(json.dumps(json.loads(text)["bands"][0]["layers"])) < 0.5 * size


@pytest.mark.parametrize("text", ["", "{}", "[]", "null", '{"format": "another"}', "[" * 200_000])
def test_what_is_no_estimator_is_refused(text):
    with pytest.raises(EstimatorError):
        GripEstimator.from_json(text)


@pytest.mark.parametrize(
    ("where", "value"),
    [
        (("noise_microstrain",), "x"),
        (("noise_microstrain",), -1.0),
        (("noise_microstrain",), float("nan")),
        (("noise_microstrain",), 10**400),
        (("design",), [1]),
        (("noise_microstrain",), 1e9),
        (("curves", "normal_force_N"), [0.0, 1.0, 1.0]),
        (("curves", "normal_force_N"), [-2.0, -1.0, 1.0]),
        (("curves", "approach_mm"), [3.0, 2.0, 1.0]),
        (("curves", "stiffness_N_per_mm"), [-1.0, 1.0, 1.0]),
        (("curves", "turn_radius_mm"), [-1.0, 1.0, 1.0]),
        (("curves", "sticking_microstrain_per_N"), [[1.0], [1.0], [1.0]]),
        (("bands",), []),
        (("bands", 0, "most_noise_microstrain"), 20.0),
        (("bands", 0, "spread"), []),
        (("bands", 0, "spread"), [1.0, 2.0]),
        (("bands", 1, "scale"), [0.0] * feature_count(GAGES)),
        (("bands", 1, "center"), [0.0]),
        (("bands", 1, "scale"), [1e-300] * feature_count(GAGES)),
        (("bands", 1, "layers", 0, "bias", 0), 1e300),
        (("bands", 1, "layers", 0, "weight_base64"), "AAAA"),
        (("bands", 1, "layers", 0, "weight_base64"), "no base 64!"),
        (("bands", 1, "layers", 0, "weight_scale", 0), float("nan")),
        (("bands", 1, "spread"), [[1.0, 1e300]]),
        (("curves", "approach_mm"), [0.0, 1.0, 1e300]),
        (("curves", "normal_force_N"), [0.0, 1e-300, 1.0]),
    ],
)
def test_an_invalid_estimator_is_refused(where, value):
    record = json.loads(estimator().to_json())
    place = record
    for key in where[:-1]:
        place = place[key]
    place[where[-1]] = value
    with pytest.raises(EstimatorError):
        GripEstimator.from_json(json.dumps(record))


def test_features_of_known_samples():
    """Pressed alone there is no signal; what slips nowhere reads one per newton; what slips is
    felt in the forces too: of 0.02 mm at 10 N/mm 0.1 N are missing, over 0.1 + 0.02 N."""
    for share in (1.0, 0.5):
        found = features([moment(share, 0.0, readings=share * np.arange(1, 4))], CURVES, 0.5)
        assert found[:GAGES] == pytest.approx(0.0)
    pulled = moment(1.0, 0.2, readings=[3.0, 4.0, 5.0])  # 10 microstrain/N times 0.2 N more
    change = features([moment(1.0, 0.0), pulled], CURVES, 0.5)[GAGES + 5 : 2 * GAGES + 5]
    assert change == pytest.approx(0.2 / 0.22)  # 0.02 N are added to every change of force
    for force, missing in ((0.2, 0.0), (0.1, -0.1 / 0.12)):
        found = features([moment(1.0, 0.0), moment(1.0, force, dx=0.02)], CURVES, 0.5)
        assert found[2 * GAGES + 5 + 3] == pytest.approx(missing, abs=1e-12)
        assert len(found) == feature_count(GAGES)


def test_features_of_a_change_are_of_all_the_way_and_of_the_stiffness_half_way():
    """There and back by 0.02 and 0.01 mm, 0.01 mm closer: 0.04 mm in all. F_n would rise by 1/3 N,
    and F_t by 0.01 mm times 12 N/mm, the stiffness at 7/6 N."""
    curves = replace(CURVES, stiffness=np.array([10.0, 10.0, 22.0]))
    history = [moment(1.0, 0.2), moment(1.0, 0.2, 0.02), moment(1.3, 0.1, -0.01, 0.01)]
    since = 2 * GAGES + 5 + GAGES + 7  # the forces' part of the second lag, which is of all
    size = 0.1 + 0.3 * 0.3 + 0.02
    forces = np.array([0.3, -0.1, 0.3 - 1 / 3, -0.1 - 0.12]) / size
    expected = [*forces, 0.25, np.log(0.04), np.log(size / 1.3)]
    found = features(history, curves, 0.5)
    for part in (since, since + 2 * (GAGES + 7)):  # Since the first pull too: there it begins.
        assert found[part : part + 7] == pytest.approx(expected)


def test_all_moments_at_once_have_the_features_of_each():
    """Of 40 moments: gages that die and answer again, a pull in between, a torque, a turn."""
    rng = np.random.default_rng(3)
    history = []
    for k in range(40):
        alive = (np.arange(GAGES) != 1) | (k <= 8) | (k >= 25)
        forces = rng.uniform(0.02, 2.0), rng.uniform(-0.1, 1.0)
        torque = None if k % 7 == 3 else rng.uniform(-1.0, 1.0)
        sample = Sample(60.0 * alive * rng.standard_normal(GAGES), *forces, k > 30, torque)
        dx = float(rng.choice([0.0, 0.01])) * (k > 5)
        history.append(Moment(sample, dx, rng.uniform(0.0, 0.01)))
    curves = replace(CURVES, pressed=30.0 * CURVES.pressed)
    rows = np.array([0, 3, 12, 20, 30, 39])
    found = feature_rows(history, curves, 0.5, rows)
    each = [features(history[: row + 1], curves, 0.5) for row in rows]
    np.testing.assert_allclose(found, each, rtol=1e-12, atol=1e-12)
    assert np.isnan(found[3]).any()
    assert not np.isnan(found[4]).any()
    none = feature_rows(history, curves, 0.5, rows[:0])  # as of a grip that never presses
    assert none.shape == (0, feature_count(GAGES))


def test_an_object_that_turns_gives_way_as_its_torque_shows():
    """At an arm of the turn radius half of the stiffness is left: a rise of 0.1 N for 0.02 mm at 10
    N/mm is then no slip. Without torque, or without a turn radius, it is."""
    weight = 0.1**2 / (0.1**2 + 0.02**2)  # of the arm that 0.1 N show
    part = 1.0 / (1.0 + weight**2)
    pulled = replace(moment(1.0, 0.1, dx=0.02).sample, torque=0.3)
    history = [moment(1.0, 0.0), Moment(pulled, 0.02, 0.0)]
    for curves, torque, left in (
        (CURVES, 0.3, part),
        (CURVES, -0.3, part),
        (CURVES, None, 1.0),
        (replace(CURVES, turn_radius=np.zeros(3)), 0.3, 1.0),
    ):
        own = [history[0], replace(history[1], sample=replace(pulled, torque=torque))]
        found = features(own, curves, 0.5)
        assert found[GAGES + 4] == pytest.approx(left)
        assert found[2 * GAGES + 5 + 3] == pytest.approx((0.1 - 0.2 * left) / 0.12)
    # On a rig the model's radius is taken at the rig's own depth.
    deep = replace(CURVES, approach=2.0 * CURVES.approach).turning_as(CURVES)
    assert deep.turn_radius == pytest.approx([3.0, 5.0, 5.0])


def test_features_are_of_the_touch_the_lags_and_the_way_since_the_pull():
    """What lies between the first pull and the longest lag counts by its way and its largest F_t /
    F_n alone."""
    history = [moment(1.0 + 0.01 * k, 0.01 * k, dx=0.01 * (k > 0)) for k in range(40)]
    recent = history[-max(LAGS) - 1 :]
    between = replace(history[20], dx=0.01 * (40 - len(recent) - 1))
    short = [history[0], between, *recent]
    assert features(short, CURVES, 0.5) == pytest.approx(features(history, CURVES, 0.5))
    leaning = replace(history[0].sample, readings=np.array([2.0, 1.0, 3.0]))
    changed = features(history, CURVES, 0.5) != features(
        [replace(history[0], sample=leaning), *history[1:]], CURVES, 0.5
    )
    assert changed[-GAGES:-1].all()
    assert not changed[: -2 * GAGES - 7].any()


def test_neighbours_stand_in_for_a_gage_that_falls_silent():
    """From its third sample on, unless a press would hardly strain it; what others say stays. The
    last gage, which is silent too, would hardly be strained."""
    strong = replace(CURVES, pressed=CURVES.pressed * [100.0, 100.0, 10.0])

    def spoken(silent):
        return [
            moment(1.0, 0.1 * k, readings=[110.0, *([3.0, 2.0] if k >= silent else [210.0, 35.0])])
            for k in range(5)
        ]

    whole, soon, found = (features(spoken(silent), strong, 0.5) for silent in (5, 3, 2))
    assert np.isfinite([whole, soon]).all()
    places = np.array(readings_at(GAGES))
    assert list(np.flatnonzero(np.isnan(found))) == list(places + 1)
    other = features(spoken(2), replace(strong, pressed=-strong.pressed), 0.5)
    assert list(np.flatnonzero(np.isnan(other))) == list(places + 1)  # pressed, it is compressed
    first = [at for at in range(len(found)) if at not in np.add.outer(places, (1, 2))]
    assert np.array_equal(found[first], whole[first])
    band = replace(
        estimator().band, center=np.arange(len(found)) / 10.0, scale=np.arange(len(found)) + 1.0
    )
    stated = np.clip((found - band.center) / band.scale, -OUTLIER, OUTLIER)

    def stood_in(gage, deviations):
        filled = found.copy()
        filled[places + gage] = (band.center + deviations * band.scale)[places + gage]
        return filled

    def shifted(gage):
        return np.roll(stated, -gage)  # of the next gage, at a gage's own place

    found = stood_in(1, 0.5 * (shifted(1) + shifted(-1)))
    for own in (found, np.where(np.isin(range(len(found)), places + 1), np.nan, found)):
        assert band.evaluate(own[None]) == pytest.approx(band.evaluate(found[None]))


def test_dead_gages_have_the_most_likely_features():
    """Rows of a known covariance: what is completed is their conditional mean, gage by gage and of
    several at once; a gage that depends on others alone is found nearly exactly."""
    rng, count = np.random.default_rng(1), feature_count(GAGES)
    mix = rng.standard_normal((count, count)) + 3.0 * np.eye(count)
    mix[:, 0] = mix[:, 3] - mix[:, 4]  # the first gage's reading
    rows = rng.standard_normal((40_000, count)) @ (mix / np.linalg.norm(mix, axis=0))
    some, places = rows[:5].copy(), np.array(readings_at(GAGES))
    rows[5:20_000, places] = np.nan  # rows with dead gages do not count
    relations = Relations.of(rows)
    covariance = np.cov(rows[20_000:].T) + 0.01 * np.eye(count)
    for gages in ((0,), (1,), (0, 2)):
        dead = np.add.outer(places, gages).ravel()
        gaps, others = some.copy(), np.setdiff1d(range(count), dead)
        gaps[:, dead] = np.nan
        known = np.linalg.solve(covariance[np.ix_(others, others)], some[:, others].T)
        expected = (covariance[np.ix_(dead, others)] @ known).T
        found = relations.completed(gaps)
        assert np.array_equal(found[:, others], some[:, others])
        assert found[:, dead] == pytest.approx(expected, abs=0.02)
        if gages == (0,):
            assert found[:, 0] == pytest.approx(some[:, 0], abs=0.1)
    again = Relations.from_record(relations.to_record())
    assert np.array_equal(again.matrix, relations.matrix)
    assert again.root == pytest.approx(relations.root, rel=1e-8)


def test_features_without_a_whole_row_are_completed_by_the_mean():
    rows = np.full((3, feature_count(GAGES)), np.nan)
    assert not Relations.of(rows).completed(rows).any()


def test_a_gage_that_is_dead_stays_so_until_it_answers():
    """Also where its curve crosses zero, so that a press alone would not show it."""
    force, pressed = CURVES.normal_force, CURVES.pressed.copy()
    pressed[:, 1] = np.interp(force, [0.0, 1.0, 2.0], [0.0, 200.0, 0.0])
    crossing = replace(CURVES, pressed=pressed)

    def dead(*readings, forces):
        pairs = zip(readings, forces, strict=True)
        history = [moment(force, 0.1, readings=[110.0, one, 100.0]) for one, force in pairs]
        return np.isnan(features(history, crossing, 0.5)).any()

    late = 1.0, 1.0, 1.0, 2.0
    assert dead(1.0, 1.0, 1.0, 1.0, forces=late)
    assert not dead(150.0, 1.0, 1.0, 1.0, forces=late)
    assert not dead(1.0, 1.0, 1.0, 150.0, forces=late)
    assert not dead(1.0, 1.0, 1.0, 1.0, forces=(2.0, 2.0, 2.0, 2.0))


def test_the_largest_ratio_of_forces_is_remembered():
    high, low = moment(1.0, 0.5), moment(1.0, 0.2)
    assert features([high, low], CURVES, 0.5)[GAGES + 3] == 0.5
    assert features([low], CURVES, 0.5)[GAGES + 3] == 0.2
    assert features([moment(1.0, -0.1)], CURVES, 0.5)[GAGES + 3] == 0.0


class Late:
    """A plant of two springs, felt ``delay`` samples late."""

    def __init__(self, delay):
        self.now = Sample(np.zeros(GAGES), 0.5, 0.0)
        self.late = [self.now] * delay

    def move(self, dx, dy):
        force = self.now.normal_force + 30.0 * dy, self.now.tangential_force + 10.0 * dx
        self.now = Sample(np.zeros(GAGES), *force)
        self.late.append(self.now)
        return self.late.pop(0)


def test_a_delay_that_the_bench_knows_changes_no_move():
    """Forces carried on by the moves on their way: the climb is the same, a delay later."""
    ratios, own, spread = [], RegulatorTable(), 0.02
    for delay in (0, 3):
        regulator, plant = at_start(Teller(0.5, spread=spread), delay), Late(delay)
        sample, moves = plant.now, []
        for _ in range(120):
            command = regulator.command(sample)
            moves.append((command.dx, command.dy))
            sample = plant.move(command.dx, command.dy)
        ratios.append(plant.now.tangential_force / plant.now.normal_force)
        assert moves[:delay] == [(0.0, 0.0)] * delay
    # What its weights add up to on a steady climb; it leans to the safe side by two deviations.
    weight = (own.target / spread) ** 2 / (1.0 - own.memory)
    leaning = 0.5 * (1.0 - 2.0 / np.sqrt(weight))
    # A friction that may fall is less where F_n has risen, at most doubled since the last probe.
    assert ratios[1] == pytest.approx(ratios[0], rel=0.01)
    assert FALLEN * leaning * own.target < min(ratios) < 1.01 * leaning * own.target


class Teller:
    """An estimator that tells what the test wants; least: of ``used``, whatever the forces."""

    def __init__(self, friction, stick=0.8, spread=0.02, least=0.0):
        self.friction, self.stick, self.spread, self.least = friction, stick, spread, least

    def estimate(self, history):
        now = history[-1].sample
        used = min(now.tangential_force / (self.friction * now.normal_force), 1.0)
        return Estimated(self.stick, max(used, self.least), self.spread)

    def on_rig(self, calibration):
        return self


def at_start(teller, delay=0):
    regulator = Regulator(Grip(), RegulatorTable(), Object(estimator=teller))
    normal = NormalCalibration(np.array([0.0, 1.0]), np.zeros((2, GAGES)))
    measured = normal, np.full(2, 10.0), np.array([0.0, 0.03])
    calibration = Calibration(np.arange(3.0), normal, np.ones(GAGES), 10.0, *measured, delay)
    regulator.start(calibration, Sample(np.zeros(GAGES), 0.5, 0.0))
    return regulator


def grip(teller, steps=60, lifted_at=None):
    """Forces of a finger that never slips, 10 N/mm in shear and 30 N/mm in pressing."""
    regulator, sample = at_start(teller), Sample(np.zeros(GAGES), 0.5, 0.0)
    path = []
    for k in range(steps):
        command = regulator.command(sample)
        lifted = lifted_at is not None and k >= lifted_at
        pull = sample.tangential_force + (0.0 if sample.lifted else 10.0 * command.dx)
        sample = Sample(np.zeros(GAGES), sample.normal_force + 30.0 * command.dy, pull, lifted)
        path.append((sample, command))
    return regulator, path


def test_it_probes_first_and_then_climbs_at_the_margin():
    regulator, path = grip(Teller(0.5))
    pulls = [k for k, (_, command) in enumerate(path) if command.dx > 0.0]
    assert path[pulls[0] - 1][0].normal_force >= RegulatorTable().probe_force_N
    assert all(command.dx == 0.0 and command.dy > 0.0 for _, command in path[: pulls[0]])
    assert path[pulls[0]][1].dy == 0.0
    assert regulator.friction == pytest.approx(0.5, rel=1e-6)
    last = path[-1][0]
    margin = 0.5 * last.normal_force / last.tangential_force
    assert 0.95 < margin * RegulatorTable().target < 1.05 / FALLEN
    assert [path[k][1].unsure for k in (0, -1)] == [True, False]
    assert all(command.unsure for _, command in grip(Teller(0.5, spread=0.3))[1])


class Learner(Teller):
    """Takes a friction of 1 for one of 0.5 before it has felt 3 N."""

    def estimate(self, history):
        self.friction = 0.5 if max(each.sample.normal_force for each in history) < 3.0 else 1.0
        return super().estimate(history)


def believed_after(forces, exponent):
    """A belief after probes at these forces, on a friction of 0.5 at 1 N that falls."""
    belief = FrictionBelief()
    for force in forces:
        belief.fade(0.0)
        belief.learn(0.5 * force**-exponent, force, 100.0, 0.9)
        belief.probe_ends()
    return belief


@pytest.mark.parametrize("exponent", [0.0, 0.2, 1.0 / 3.0])
def test_probes_at_two_forces_tell_how_the_friction_falls(exponent):
    """The least-squares slope of two points, joined with the prior."""
    single, double = (believed_after(each, exponent) for each in ([2.0], [2.0, 8.0]))
    assert single.exponent == pytest.approx(_EXPONENT)
    points = 0.5 * np.log(4.0) ** 2
    known = (_PRIOR * _EXPONENT + points * exponent) / (_PRIOR + points)
    assert double.exponent == pytest.approx(known, rel=1e-9)
    far = believed_after([1e-3, 1e3], exponent)
    assert far.exponent == pytest.approx(exponent, abs=2e-3)
    at = [far.at(each) for each in (1e3, 2e3)]
    assert at[0] == pytest.approx(0.5 * 1e3**-exponent, rel=1e-9)
    assert at[1] == pytest.approx(0.5 * 2e3**-exponent, rel=0.01)


def test_friction_without_any_sample_and_an_exponent_beyond_all_rubber():
    assert FrictionBelief().at(1.0) is None
    assert believed_after([1.0, 100.0], 0.8).exponent == _MOST_EXPONENT
    assert believed_after([1.0, 100.0], -0.8).exponent == 0.0


def test_a_belief_is_the_mean_of_its_samples_by_weight_and_leans_to_the_safe_side():
    belief = FrictionBelief()
    belief.learn(0.4, 1.0, 4.0, 0.9)
    belief.learn(0.6, 5.0, 12.0, 0.5)  # What was before counts half: weights of 2 and 12.
    mean, force = (2.0 * 0.4 + 12.0 * 0.6) / 14.0, (2.0 * 1.0 + 12.0 * 5.0) / 14.0
    assert (belief.weight, belief.mean) == (14.0, pytest.approx(mean))
    assert belief.at(force) == pytest.approx(mean)
    assert belief.surely(force) == pytest.approx(mean * (1.0 - 14.0**-0.5))
    faint = FrictionBelief()
    faint.learn(0.4, 1.0, 1.0, 0.9)
    assert faint.surely(1.0) == 0.5 * 0.4  # no less than half, however little is known


def test_a_step_of_the_climb_moves_the_belief_little_and_a_held_object_not_at_all():
    """Weights u^2 / s^2, of the climb a fifth; the past keeps 0.98 of its weight there, and so adds
    up to 50 such steps. One step with half of u says that mu is twice as large."""
    regulator, path = grip(Teller(0.5), steps=400)
    regulator.estimator.friction = 1.0
    regulator.command(path[-1][0])
    step = 0.25 / (0.98 * 50.0 + 0.25)
    assert (learnt := regulator.friction) - 0.5 == pytest.approx(0.5 * step, rel=0.05)
    regulator.command(replace(path[-1][0], lifted=True))
    assert regulator.friction == learnt


@pytest.mark.parametrize("delay", [0, 3])
def test_the_later_samples_come_the_more_slowly_it_pulls_in_a_probe(delay):
    """The first pull raises F_t by 0.03 F_n over the root of the moves on their way, at 10 N/mm."""
    regulator, sample = at_start(Teller(0.5), delay), Sample(np.zeros(GAGES), 2.0, 0.0)
    commands = [regulator.command(sample) for _ in range(delay + 1)]
    first = 0.03 * 2.0 / 10.0 / (1.0 + delay) ** 0.5
    assert [each.dx for each in commands] == pytest.approx([0.0] * delay + [first])


def test_it_probes_again_at_twice_the_force():
    """And ends at once where it finds what it knew."""
    found = []
    for teller in (Teller(0.5), Learner(0.5)):
        _, path = grip(teller, steps=100)
        alone = (one[0] for one, two in pairwise(path) if two[1].dy == 0.0 < two[1].dx)
        again = [each for each in alone if each.normal_force > 2.5]
        found.append(len(again))
    assert found[0] == 0
    assert found[1] > 2
    assert 3.0 < again[0].normal_force < 3.5
    assert again[-1].tangential_force / again[-1].normal_force > 0.5


@pytest.mark.parametrize("teller", [Teller(0.5, least=0.3), Teller(0.5, stick=0.1)])
def test_it_closes_without_pulling_where_hardly_anything_sticks_or_it_has_not_probed(teller):
    regulator, path = grip(teller, steps=12)
    assert all(command.dx == 0.0 and command.dy > 0.0 for _, command in path)
    assert path[-1][0].normal_force > 1.0
    assert regulator.friction is None


def test_a_lifted_object_is_held_and_a_tug_is_answered():
    regulator, path = grip(Teller(0.5), steps=40, lifted_at=30)
    held, command = path[-1]
    assert command.dx == 0.0
    tugged = Sample(held.readings, held.normal_force, 1.3 * held.tangential_force, True)
    answer = regulator.command(tugged)
    assert answer.dy > 0.0 == answer.dx
    # So is a small one, of an object that is held by far more than it needs.
    regulator, path = grip(Teller(0.5), steps=30)
    held = replace(path[-1][0], tangential_force=0.5 * path[-1][0].tangential_force, lifted=True)
    for tug, closes in ((1.0, False), (1.1, False), (1.15, True)):
        answer = regulator.command(replace(held, tangential_force=tug * held.tangential_force))
        assert (answer.dy > 0.0) == closes
    # Lifted before anything is known, it is held by force.
    regulator, sample = at_start(Teller(0.5)), Sample(np.zeros(GAGES), 1.0, 0.4, lifted=True)
    for _ in range(100):
        dy = regulator.command(sample).dy
        sample = replace(sample, normal_force=sample.normal_force + 30.0 * dy)
    assert 0.4 / sample.normal_force == pytest.approx(0.3 * RegulatorTable().most_held, rel=0.1)
    assert dy == 0.0


def test_on_a_rig_what_it_measured_is_taken_for_what_it_was_taught():
    """Gains of 2 on the gages: pressed alone, the finger feels as it did where it was taught."""
    normal = NormalCalibration(np.array([0.0, 0.5, 2.0]), 2.0 * CURVES.pressed[[0, 0, 2]])
    normal.readings[1] = CURVES.pressed_at(0.5) * 2.0
    sticking = NormalCalibration(np.array([0.5, 1.0]), np.full((2, GAGES), 10.0))
    measured = sticking, np.full(2, 10.0), np.array([0.0, 0.015, 0.06])
    calibration = Calibration(np.arange(3.0), normal, np.ones(GAGES), 10.0, *measured)
    rig = estimator().on_rig(calibration)
    pressed = [moment(0.5, 0.0, readings=[1.0, 2.0, 3.0]), moment(2.0, 0.0, readings=[4, 8, 12])]
    taught = [
        moment(0.5, 0.0, readings=CURVES.pressed_at(0.5)),
        moment(2.0, 0.0, readings=[2, 4, 6]),
    ]
    expected = features(taught, CURVES, 0.5)
    assert features(pressed, rig.curves, 0.5) == pytest.approx(expected, abs=1e-12)
    np.testing.assert_allclose(rig.curves.sticking_at(1.3), CURVES.sticking_at(1.3))


def test_a_noisy_force_cell_never_stops_the_closing():
    regulator, plant, rng = at_start(Teller(0.5)), Late(0), np.random.default_rng(0)
    sample = plant.now
    for _ in range(300):
        command = regulator.command(sample)
        true = plant.move(command.dx, command.dy)
        noise = 0.5 * rng.standard_normal(2)
        normal, pull = true.normal_force + noise[0], true.tangential_force + noise[1]
        sample = replace(true, normal_force=normal, tangential_force=pull)
    assert plant.now.normal_force > 5.0
