"""Tuning: one procedure and budget for all, seeded, on grips of its own; record and command."""

import json
import re
from collections import Counter
from dataclasses import replace

import jsonschema
import pytest
from fingerdesign_cli.main import main

from fingerdesign import load_design
from fingerdesign.control.plants.remembered import Memory
from fingerdesign.errors import DesignError
from fingerdesign.records.base import json_schema
from fingerdesign.runtime.journal import Journal
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials import bench as trials_bench
from fingerdesign.trials.bench import tuned_grip
from fingerdesign.trials.grid import FRICTIONS, MASSES_G, Cell, ControlGrid, Perturbed
from fingerdesign.trials.stored import KIND, stored_grips
from fingerdesign.trials.study import StudyOptions, run_study
from fingerdesign.trials.tuning import (
    BUDGET,
    Candidate,
    Range,
    Round,
    Tuning,
    TuningSetting,
    bench_judge,
    default_values,
    ranges_of,
    trial_data,
    tune,
    tuned_text,
    tuning_cells,
    tuning_data,
)
from tests.support.grips import trial

SMALL = (Round(4, 0, 3), Round(2, 2, 5))
A = Range("grip.fixed_ratio.ratio", 0.05, 0.8)
B = Range("grip.fixed_ratio.pull_share", 0.003, 0.06)


def made_up(cell, success, peak):
    return trial(cell, lifted=success, gross_slip=not success, peak_ratio=peak).result


class Judge:
    """Grips succeed where mu is over the ratio, at the peak mu / ratio; it stores the rounds."""

    def __init__(self):
        self.rounds = []

    def __call__(self, batches, report):
        self.rounds.append(batches)
        return [[self.one(dict(cell.values), cell) for cell in batch] for batch in batches]

    def one(self, values, cell):
        ratio = values[A.key]
        return made_up(cell, cell.friction > ratio, cell.friction / ratio)


def tuned(judge, seed=0, budget=BUDGET):
    cells = tuning_cells("fixed_ratio", budget[-1].grips)
    default = {A.key: 0.06, B.key: 0.02}
    return tune("fixed_ratio", default, cells, judge, budget=budget, seed=seed)


def test_it_finds_the_best_of_a_known_task():
    """Success needs ratio < mu < 3 ratio: of frictions evenly in 0.2 to 0.8, best at 0.267."""
    found = tuned(Judge())
    assert found.best.values[A.key] == pytest.approx(0.8 / 3.0, abs=0.03)
    assert found.best.success > 0.85
    assert found.default.values == {A.key: 0.06, B.key: 0.02}
    assert found.best.order > found.default.order
    assert found.trials[0] == found.default
    # Later trials stay inside the box and near the best.
    for each_trial in found.trials:
        for each in (A, B):
            assert each.low <= each_trial.values[each.key] <= each.high
    last = [
        A.share(each_trial.values[A.key]) for each_trial in found.trials if each_trial.round == 2
    ]
    assert max(last) - min(last) <= 1.0 / 9.0 + 1e-3
    # The seed decides everything.
    assert tuned(Judge()) == found
    assert tuned(Judge(), seed=1).trials[1].values != found.trials[1].values


def test_ties_go_to_the_lower_peak():
    class Easy(Judge):
        def one(self, values, cell):
            return made_up(cell, True, 1.0 + values[B.key])

    found = tuned(Easy())
    assert found.best.success == 1.0
    assert found.best.values[B.key] < 0.0103
    assert found.best.mean_peak_ratio == pytest.approx(1.0 + found.best.values[B.key])


def test_a_trial_is_recorded_with_its_rates_and_the_reasons_why_others_failed():
    slipped = {"gross_slip": True, "outcome": "complete slip"}
    stays = {"lifted": False, "outcome": "stage travel"}
    outcomes = [trial(), trial(peak_ratio=2.0), trial(peak_ratio=4.0), trial(**slipped)]
    outcomes += [trial(**stays, peak_ratio=9.0), trial(**stays | slipped, peak_ratio=1.0)]
    made = Candidate({A.key: 0.3}, 1, tuple(each.result for each in outcomes))
    found = trial_data(made)
    assert (found["values"], found["round"], found["grips"]) == ({A.key: 0.3}, 1, 6)
    assert (found["success_rate"], found["held_rate"]) == (2 / 6, 3 / 6)
    assert found["mean_peak_ratio"] == pytest.approx((1.4 + 2.0) / 2)  # of those that succeed
    assert (found["dropped"], found["crushed"], found["not_lifted"]) == (2, 2, 2)
    grid, setting = ControlGrid(perturbed=Perturbed(("gains", "tilt"), 3, 2)), TuningSetting()
    tuning = Tuning((A,), BUDGET, (made, made), made, made)
    data = tuning_data({"fixed_ratio": tuning}, setting, grid, "d")
    assert data["controllers"]["fixed_ratio"]["grips"] == 12
    assert (data["fingers"], len(data["cells"])) == (96 // 2, 96)  # two objects a finger


def test_no_grip_is_made_twice_and_the_best_see_all():
    judge = Judge()
    found = tuned(judge)
    made = Counter(cell for batches in judge.rounds for batch in batches for cell in batch)
    assert max(made.values()) == 1
    assert sum(made.values()) == found.grips == 1808
    assert len(found.best.outcomes) == len(found.default.outcomes) == BUDGET[-1].grips
    assert len(judge.rounds) == len(BUDGET)


@pytest.mark.parametrize("name", CONTROLLERS.names())
def test_every_controller_has_the_same_budget(name, design):
    class Nothing(Judge):
        def one(self, values, cell):
            return made_up(cell, False, 1.0)

    default = default_values(design, name)
    assert list(default) == [each.key for each in ranges_of(name)]
    for each in ranges_of(name):
        assert each.low <= default[each.key] <= each.high
        tuned_grip(design.grip, {each.key: each.at(0.0)})
        tuned_grip(design.grip, {each.key: each.at(1.0)})
    found = tune(name, default, tuning_cells(name, 96), Nothing())
    assert found.grips == 1808
    assert (found.best.success, found.best.mean_peak_ratio) == (0.0, None)


def test_a_range_goes_both_ways():
    for each in (A, Range("grip.threshold_share", 0.1, 0.8, logarithmic=False)):
        assert (each.at(0.0), each.at(1.0)) == (each.low, each.high)
        assert each.share(each.at(0.3)) == pytest.approx(0.3, abs=1e-3)
        assert (each.share(1e-9), each.share(1e9)) == (0.0, 1.0)


def test_tuning_grips_are_not_those_of_the_grid():
    cells = tuning_cells("paper", 96)
    assert len({(cell.friction, cell.mass_g) for cell in cells}) == 96
    of_the_grid = {(friction, mass) for friction in FRICTIONS for mass in MASSES_G}
    assert not {(cell.friction, cell.mass_g) for cell in cells} & of_the_grid
    assert all(0.2 <= cell.friction <= 0.8 and 100.0 <= cell.mass_g <= 1000.0 for cell in cells)
    assert cells[:16] == tuning_cells("paper", 16)
    others = tuning_cells("reactive", 96, noises=(0.5, 2.0))
    assert [replace(cell, controller="paper", noise=0.5) for cell in others] == cells
    assert [cell.noise for cell in others[:3]] == [0.5, 2.0, 0.5]


def judged(bench, design, path, workers=1, report=lambda *_: None):
    """A small tuning of the fixed ratio on the bench, stored in a journal."""
    with Journal(path, KIND, "d") as journal:
        judge = bench_judge(bench, design, journal, workers)
        return tune(
            "fixed_ratio",
            default_values(design, "fixed_ratio"),
            tuning_cells("fixed_ratio", SMALL[-1].grips),
            judge,
            budget=SMALL,
            report=report,
        )


def stored_count(path):
    with Journal(path, KIND, "d") as journal:
        return len(stored_grips(journal))


def test_grips_take_the_values_that_are_tried_and_the_bench_stores_its_calibration(bench):
    cells = tuning_cells("fixed_ratio", 2)
    loose, tight = (
        bench.run_batch([replace(cell, values=((A.key, ratio),)) for cell in cells])
        for ratio in (0.6, 0.15)
    )
    assert all(a.peak_ratio < b.peak_ratio for a, b in zip(loose, tight, strict=True))
    stored = bench.calibration(0.0)
    for values, same in (({A.key: 0.3}, True), ({"grip.preload_mm": 0.05}, False)):
        other = bench.with_grip(tuned_grip(bench.grip, values))
        assert (other.calibration(0.0) is stored) == same


def test_unknown_controllers_and_too_few_grips_are_refused():
    with pytest.raises(DesignError, match="one of paper, fixed_force"):
        tune("magic", {}, tuning_cells("magic", 96), Judge())
    with pytest.raises(DesignError, match="at least 96"):
        tune("paper", {}, tuning_cells("paper", 95), Judge())


GRID = ControlGrid((0.4,), (150.0,), (0.5,), hold_s=0.05, tug=None)
TUNED = StudyOptions(tuning=TuningSetting(budget=SMALL))


@pytest.mark.slow
def test_a_tuned_study_has_the_best_values_and_its_trials_are_stored(coarse, tmp_path):
    path, names = tmp_path / "journal", ("fixed_ratio", "oracle_1.2")
    found = run_study(coarse, names, GRID, path, TUNED)
    tuning = found.data["tuning"]
    assert list(tuning["controllers"]) == ["fixed_ratio", "oracle_1.2"]
    own = tuning["controllers"]["fixed_ratio"]
    assert len(own["trials"]) == 4 + 2
    assert own["best"]["grips"] == len(tuning["cells"]) == 5
    ratio = own["best"]["values"][A.key]
    assert found.tuned.grip.fixed_ratio.ratio == ratio != coarse.grip.fixed_ratio.ratio
    # All trials and grips are in the journal: nothing is gripped again.
    before = path.read_bytes()
    again = run_study(coarse, names, GRID, path, TUNED)
    assert path.read_bytes() == before
    assert again.data["tuning"] == tuning
    assert again.trials == found.trials
    with pytest.raises(DesignError, match="of this design, setting"):
        run_study(coarse, names, replace(GRID, seed=1), path, TUNED)


@pytest.mark.slow
def test_the_command(coarse_file, tmp_path, monkeypatch, capsys):
    small = TuningSetting(budget=SMALL)
    monkeypatch.setattr("fingerdesign_cli.trials.TuningSetting", lambda *_: small)
    out = tmp_path / "out"
    command = ["study", str(coarse_file), "--out", str(out), "--tune", "--workers", "1"]
    chosen = ["--friction", "0.4", "--mass-g", "150", "--noise", "0.5", "--no-tug"]
    assert main([*command, *chosen, "--controller", "fixed_force"]) == 0
    assert "before %" in capsys.readouterr().out
    head = (out / "coarse/tuned.toml").read_text().splitlines()
    assert re.match(r"# fixed_force: success \d+ % \(before: \d+ %\), held \d+ %", head[2])
    record = json.loads((out / "coarse/control.json").read_text())
    jsonschema.validate(record, json_schema("control"))
    best = record["tuning"]["controllers"]["fixed_force"]["best"]
    force = best["values"]["grip.fixed_force.force_N"]
    assert load_design(out / "coarse/tuned.toml").grip.fixed_force.force_N == force
    assert "Tuned before the study" in (out / "coarse/control.html").read_text("utf-8")
    assert not list(out.glob("*.sqlite"))


@pytest.mark.slow
def test_a_real_tuning_improves_goes_on_and_has_other_noise_than_the_grid(bench, design, tmp_path):
    """The design's own 0.17 crushes what is rough."""
    found = judged(bench, design, tmp_path / "j")
    assert found.best.order > found.default.order

    def interrupt(message, fraction):
        if fraction > 0.6:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        judged(bench, design, tmp_path / "other", report=interrupt)
    assert 12 < stored_count(tmp_path / "other") < found.grips
    assert judged(bench, design, tmp_path / "other", workers=2) == found
    assert stored_count(tmp_path / "other") == found.grips
    noisy = Cell("paper", 0.5, 200.0, 5.0)
    with Journal(tmp_path / "own", KIND, "d") as journal:
        ((apart,),) = bench_judge(bench, design, journal, 1)([(noisy,)], lambda *_: None)
    assert apart != bench.run_cell(noisy, Memory())


@pytest.mark.slow
def test_a_study_of_perturbed_fingers_tunes_on_others_with_its_faults(coarse, tmp_path, calls_of):
    drawn = calls_of(trials_bench, "perturb")
    grid = ControlGrid.of_perturbed(Perturbed(("gains", "tilt"), plants=1, lifts=2))
    grid = replace(grid, hold_s=0.05)
    found = run_study(coarse, ("fixed_ratio",), grid, tmp_path / "journal", TUNED)
    tuning = found.data["tuning"]
    assert (tuning["fingers"], len(tuning["cells"])) == (3, 5)
    seeds = [(tuple(faults), seed) for (_, faults, seed), _ in drawn]
    judged = {(faults, grid.plant_seed(*faults, 0)) for faults in (("gains",), ("tilt",))}
    assert judged == set(seeds[-2:])
    assert {faults for faults, _ in seeds[:-2]} == {("gains",), ("tilt",)}
    assert not judged & set(seeds[:-2])
    assert "of 3 perturbed fingers" in tuned_text(found.tuned, tuning, 0)
    # Values that are tried count: trials of one finger differ.
    trials = tuning["controllers"]["fixed_ratio"]["trials"]
    assert len({each["mean_peak_ratio"] for each in trials if each["mean_peak_ratio"]}) > 1
