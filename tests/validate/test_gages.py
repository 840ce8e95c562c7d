"""Information of gages: columns, ranking, dead gages, the least error, record and command."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fingerdesign_cli.main import main
from fingerdesign_cli.validate import _show_gages

from fingerdesign import parse_design
from fingerdesign.control.calibration import Bounds
from fingerdesign.control.features import LEAST_FORCE, FingerCurves, Moment, feature_count, features
from fingerdesign.control.signals import Sample
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.records.base import ResultError
from fingerdesign.sensing import model as grip_model
from fingerdesign.sensing.train.paths import Settings, random_grip_paths
from fingerdesign.sensing.train.samples import finger_curves
from fingerdesign.validate.gages import learners
from fingerdesign.validate.gages.learners import (
    QuickLearner,
    Samples,
    errors_of,
    gage_columns,
    sample_all,
)
from fingerdesign.validate.gages.ranking import eliminate, floors, layouts
from fingerdesign.validate.gages.record import FOLDER, write_observability
from fingerdesign.validate.gages.study import observe_grips, refuse
from tests.support.pages import run_python

GAGES = 5
BOUNDS = Bounds(preload=0.01, approach_step=0.004, max_approach=0.15, max_steps=0)
SETTINGS = Settings(face="upper", bounds=BOUNDS, grips=24, seed=3)


@pytest.fixture(scope="module", autouse=True)
def short_training():
    """Networks that have learnt a little: how well is not the question."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(learners, "_SCHEDULE", ((2e-3, 4),))
        yield


@pytest.fixture(scope="module")
def problem(half_plane):
    model = half_plane.model.with_gages((1, 3, 5, 7, 9))
    return replace(half_plane, model=model)


@pytest.fixture(scope="module")
def grips(problem):
    return random_grip_paths(problem, SETTINGS)


@pytest.fixture(scope="module")
def found(problem, grips):
    return observe_grips(problem, SETTINGS, grips, 0.5)


def silent_problem(problem, factor):
    model = replace(problem.model, gage_readout=factor * problem.model.gage_readout)
    return replace(problem, model=model)


@pytest.mark.parametrize("gage", range(GAGES))
def test_a_gage_makes_its_own_columns_and_no_others(gage):
    rng = np.random.default_rng(gage)
    forces = np.array([0.0, 50.0])
    pressed, sticking = rng.normal(size=(2, 2, GAGES))
    curves = FingerCurves(forces, pressed, sticking, 0.01 * forces, np.full(2, 10.0), np.zeros(2))

    def reported(push):
        moments = []
        for k in range(15):
            readings = np.sin(np.arange(GAGES) + k)
            readings[gage] += push * (k + 1)
            moments.append(Moment(Sample(readings, 1.0 + 0.1 * k, 0.3 + 0.02 * k), 0.01, 0.002))
        return features(moments, curves, 0.5)

    moved = np.flatnonzero(reported(0.0) != reported(1.0))
    assert moved.tolist() == gage_columns(gage, GAGES).tolist()


def test_a_dead_gage_is_one_that_reads_nothing(problem, grips, monkeypatch):
    monkeypatch.setattr("fingerdesign.sensing.train.samples.GAIN_STD", 0.0)
    curves = finger_curves(problem, "upper", BOUNDS)
    sampled = sample_all(grips[:4], curves, SETTINGS, 0.5, silent=True)
    dead = sampled.with_dead(2)
    moved = np.flatnonzero((dead != sampled.inputs).any(axis=0))
    assert moved.tolist() == gage_columns(2, GAGES).tolist()
    # What is reported of it now is what F_n alone would cause in this rig's gages, taken out of 0.
    mute = tuple(
        replace(m, sample=replace(m.sample, readings=np.zeros(GAGES))) for m in grips[0].moments
    )
    quiet = replace(SETTINGS, force_noise=0.0)
    clean = sample_all(grips[:1], curves, quiet, 0.0, silent=True)
    first = next(  # The first moment with a sample: before it the force is too small.
        k
        for k, truth in enumerate(grips[0].truths)
        if k and truth.stick_ratio is not None and truth.normal_force >= 2.0 * LEAST_FORCE
    )
    expected = features(mute[: first + 1], curves, 0.0)
    assert np.array_equal(clean.silent[0], expected, equal_nan=True)  # 0 over no noise is nothing.


def made_up(informative, rows=3000):
    """Rows whose truth is in one gage's present reading alone."""
    rng = np.random.default_rng(0)
    truths = rng.uniform(0.1, 0.9, (rows, 2))
    inputs = rng.standard_normal((rows, feature_count(GAGES)))
    inputs[:, informative] = truths.mean(axis=1)
    return Samples(inputs, None, truths, np.arange(rows) // 30, rows // 30, GAGES)


@pytest.mark.parametrize("informative", [0, 3])
def test_the_gage_that_reports_is_removed_last(informative):
    from concurrent.futures import ThreadPoolExecutor

    sampled = made_up(informative)
    with ThreadPoolExecutor(1) as pool:
        own = eliminate(QuickLearner(sampled, 0), GAGES, pool, lambda message: None)
    assert own.order[-1] == informative
    assert own.counts[1] == (informative,)
    worst = max(range(GAGES), key=lambda k: own.without[k].both)
    assert worst == informative
    assert own.sets[(informative,)].both < 0.9 * own.sets[()].both


def test_training_choosing_and_testing_share_no_grip():
    sampled = made_up(0)
    parts = [set(sampled.grip[rows]) for rows in (sampled.tested, sampled.chosen_by)]
    parts.append(set(sampled.grip[~sampled.tested & ~sampled.chosen_by]))
    assert [len(part) for part in parts] == [15, 15, 70]
    assert len(set.union(*parts)) == sampled.grips


def test_the_standard_error_is_that_of_repeated_draws():
    rng = np.random.default_rng(1)

    def draw():
        off = np.repeat(rng.normal(0.0, 0.1, 60), 20)  # one error a grip
        grip = np.repeat(np.arange(60), 20)
        truths = np.full((len(off), 2), 0.5)
        return errors_of(truths + off[:, None], truths, grip)

    drawn = [draw() for _ in range(300)]
    assert np.mean([each.stick_std for each in drawn]) == pytest.approx(
        np.std([each.stick for each in drawn]), rel=0.15
    )


def test_layouts_place_gages_by_x():
    x = np.array([3.0, -3.0, 0.0, 1.0, -1.0])
    named = {name: sorted(x[list(chosen)]) for name, chosen in layouts(x, 3).items()}
    assert named == {"spread": [-3, 0, 3], "middle": [-1, 0, 1], "ends": [-3, -1, 3]}


def test_the_least_error_grows_with_noise_and_falls_with_response(problem):
    (one,) = floors(problem, "upper", (2.0,), 0.5)
    (louder,) = floors(silent_problem(problem, 4.0), "upper", (2.0,), 0.5)
    (noisy,) = floors(problem, "upper", (2.0,), 1.0)
    assert noisy.one_sample_stick_error == pytest.approx(2.0 * one.one_sample_stick_error)
    assert louder.one_sample_stick_error == pytest.approx(one.one_sample_stick_error / 4.0)
    assert one.window_stick_error < one.one_sample_stick_error
    with pytest.raises(SolverError, match="no gage responds"):
        floors(silent_problem(problem, 0.0), "upper", (2.0,), 0.5)


def test_a_study_judges_all_few_and_none(found):
    assert [len(each.chosen) for each in found.confirmed] == [5, 4, 3, 2, 0]
    assert [len(each.chosen) for each in found.counts] == [5, 4, 3, 2, 1, 0]
    assert sorted(each.rank for each in found.gages) == [1, 2, 3, 4, 5]
    assert [each.x_mm for each in found.gages] == [-4.0, -2.0, 0.0, 2.0, 4.0]
    assert all(0.0 < (each.stick_error or 0.0) < 1.0 for each in found.confirmed)
    assert found.dead.unnoticed_stick_error == pytest.approx(
        found.stick_error + max(each.unnoticed_stick_cost for each in found.gages)
    )
    noises = [each.noise_microstrain for each in found.noises]
    assert noises[0] == 0.0
    assert 0.5 in noises
    assert f"{found.stick_error:.3f}" in found.advice


@pytest.mark.slow
def test_a_study_repeats_whatever_the_threads(problem, grips, found):
    again = observe_grips(problem, SETTINGS, grips, 0.5, workers=2)
    assert replace(again, seconds=0.0) == replace(found, seconds=0.0)


@pytest.mark.parametrize(
    ("quick", "error", "std", "sentences"),
    [
        ((0.01, 0.1, 0.3), 0.19, 0.001, ("0.02 microstrain, or plates with 25 times",)),
        ((0.9, 0.1, 0.9), 0.19, 0.001, ("Even without noise",)),
        ((0.01, 0.001, 0.9), 0.19, 0.001, ("Only without any noise", "Cramér and Rao")),
        ((0.095, 0.001, 0.1), 0.08, 0.001, ("train on more grips",)),
        ((0.05, 0.001, 0.1), 0.08, 0.001, ("50 % lower", "reference finger is 0.05")),
        ((0.05, 0.001, 0.1), 0.04, 0.001, ("At 0.5 microstrain 1 of 5 gages suffice",)),
        ((0.05, 0.001, 0.1), 0.04, 0.005, ("24 grips are too few", "1 of 5 gages seem enough")),
    ],
)
def test_advice_names_what_limits_a_finger(found, quick, error, std, sentences):
    """quick: the learner's error below a noise, that noise, its error from there on."""
    low, edge, high = quick
    noises = [
        replace(each, quick_stick_error=low if each.noise_microstrain < edge else high)
        for each in found.noises
    ]
    counts = [
        replace(each, stick_error=error if each.chosen else 0.2, stick_std=std)
        for each in found.counts
    ]
    advice = replace(found, noises=tuple(noises), counts=tuple(counts)).advice
    assert all(words in advice for words in sentences)
    assert ("target" in advice) == (error == 0.08)


def test_gages_that_do_not_help_without_noise_are_not_blamed_on_their_response(found):
    noises = [replace(each, quick_stick_error=0.12) for each in found.noises]
    counts = [replace(each, stick_error=0.11, quick_stick_error=0.13) for each in found.counts]
    advice = replace(found, noises=tuple(noises), counts=tuple(counts)).advice
    assert "These gages hardly help at 0.5 microstrain" in advice
    assert "0.120, without gages 0.130; learn from more grips" in advice
    assert "too small" not in advice


def test_a_layout_that_ranks_did_not_choose_is_named(found, capsys):
    chosen = (0, 2, 4)
    counts = [
        replace(each, chosen=chosen if len(each.chosen) == 3 else each.chosen, stick_error=error)
        for each, error in zip(found.counts, (0.04, 0.04, 0.04, 0.05, None, 0.2), strict=True)
    ]
    tried = [replace(each, chosen=(0, 2, 3)) for each in found.layouts if each.layout == "searched"]
    placed = (*tried, replace(found.layouts[0], layout="spread", chosen=chosen))
    own = replace(found, design="small", counts=tuple(counts), layouts=placed)
    assert 'x = -4, 0, 4 mm, layout "spread", not by rank: the stick ratio' in own.advice
    _show_gages(own, Path("out"))
    shown = capsys.readouterr().out
    assert "(spread)" in shown
    assert max(map(len, shown.splitlines())) <= 80


def test_the_record_is_whole_and_nothing_else_is_replaced(found, tmp_path):
    # The array leaves out what reads nothing: plates have other numbers than its gages.
    gages = tuple(replace(each, plate=each.plate + 3) for each in found.gages)
    named = replace(found, design="half-plane", digest="0", gages=gages)
    target = tmp_path / "half-plane"
    for _ in range(2):  # an older one is replaced
        with FOLDER.written(target) as folder:
            write_observability(named, folder)
    assert sorted(path.name for path in target.iterdir()) == sorted(FOLDER.products)
    record = json.loads((target / "observability.json").read_text())
    assert record["schema_version"] == 1
    assert record["stick_error"] == found.stick_error
    assert [row["count"] for row in record["counts"]] == [5, 4, 3, 2, 1, 0]
    assert sorted(record["counts"][0]["plates"]) == [3, 4, 5, 6, 7]
    rows = list(csv.DictReader((target / "gages.csv").read_text().splitlines()))
    assert [float(row["x_mm"]) for row in rows] == [-4.0, -2.0, 0.0, 2.0, 4.0]
    counts = list(csv.DictReader((target / "counts.csv").read_text().splitlines()))
    assert counts[-2]["stick_error"] == ""  # one gage: no network was trained
    (target / "notes.txt").write_text("mine")
    with pytest.raises(ResultError, match=r"notes\.txt"), FOLDER.written(target):
        pass


@pytest.fixture
def quick_model(problem, monkeypatch):
    """Take the closed-form finger for the model of any design."""
    monkeypatch.setattr(grip_model, "grip_problem", lambda *given, **more: problem)


DESIGN = """
[design]
name = "small"
[plates]
count = 5
[grip]
defaults = "fixed"
max_approach_mm = 0.15
"""


@pytest.mark.slow
@pytest.mark.usefixtures("quick_model")
def test_the_command_writes_a_record(tmp_path, capsys):
    path = tmp_path / "small.toml"
    path.write_text(DESIGN)
    options = ["--grips", "20", "--workers", "1", "--noise", "2"]
    assert main(["validate", str(path), "--gages", "--out", str(tmp_path / "out"), *options]) == 0
    reported = capsys.readouterr().out
    record = json.loads((tmp_path / "out/small/observability.json").read_text())
    assert record["advice"] in " ".join(reported.split())
    assert not re.search(r"\de-\d", reported)
    assert (record["design"], record["noise_microstrain"], record["grips"]) == ("small", 2.0, 20)
    assert [gage["plate"] for gage in record["gages"]] == [0, 1, 2, 3, 4]


def test_bad_input_is_refused_before_work(tmp_path, capsys):
    path = tmp_path / "one.toml"
    path.write_text(DESIGN.replace("count = 5", "count = 1"))
    options = ["--noise", "-1", "--grips", "3"]
    assert main(["validate", str(path), "--gages", "--out", str(tmp_path / "out"), *options]) == 2
    reported = capsys.readouterr().err.splitlines()
    keys = [line.split(" = ")[0].split(": ")[-1] for line in reported]
    assert keys == ["gages in the array along x", "noise", "grips"]
    assert not (tmp_path / "out").exists()
    design = parse_design(DESIGN)
    refuse(design, 0.5, 100_000)
    for noise, grips, key in ((float("nan"), 20, "noise"), (0.5, 100_000_000, "grips")):
        with pytest.raises(DesignError, match=f": {key} = "):
            refuse(design, noise, grips)


@pytest.mark.usefixtures("quick_model")
@pytest.mark.slow
def test_the_pages_python_runs(capsys):
    run_python("explanation/gages.md")
    first = capsys.readouterr().out.splitlines()[0].split()
    assert all(0.0 < float(word) < 1.0 for word in first)
