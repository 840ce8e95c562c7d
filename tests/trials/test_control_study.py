"""A control study on a closed-form finger: grid, grips, journal, processes, record, command."""

import csv
import json
from dataclasses import asdict, fields, replace
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest
from fingerdesign_cli.main import main

from fingerdesign.checks.load import load_design
from fingerdesign.control.metrics import reaction_steps, unsure_at_the_end
from fingerdesign.control.plants.lift import LiftPlant
from fingerdesign.control.plants.remembered import Memory
from fingerdesign.design.grip import GRAVITY
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.records.base import ResultError, json_schema
from fingerdesign.records.statistics import share_of
from fingerdesign.runtime.journal import Journal
from fingerdesign.sensing.train.result import finger_key
from fingerdesign.trials import bench as bench_module
from fingerdesign.trials.bench import failed_grip, tuned_grip
from fingerdesign.trials.grid import (
    FRICTIONS,
    MASSES_G,
    Cell,
    ControlGrid,
    Perturbed,
    Tug,
    refuse,
    seed_of,
)
from fingerdesign.trials.record import COLUMNS
from fingerdesign.trials.stored import KIND, key_of, run_batches, stored_grips
from fingerdesign.trials.study import (
    StudyOptions,
    _study_digest,
    run_study,
    warnings_of,
)
from fingerdesign.trials.summary import Trial, summarise, unannounced, unsure
from fingerdesign.trials.tuning import TuningSetting
from tests.support.grips import grip
from tests.trials.conftest import GRID


@pytest.mark.parametrize("field", [each.name for each in fields(Cell)])
def test_each_field_of_a_cell_is_part_of_its_key(field):
    cell = Cell("paper", 0.5, 500.0, 0.5)
    value = getattr(cell, field)
    other = {str: "another", tuple: (("grip.x", 1.0),)}.get(type(value))
    changed = replace(cell, **{field: value + 1 if other is None else other})
    keys = {key_of(cell, "d" * 64), key_of(changed, "d" * 64), key_of(cell, "e" * 64)}
    assert len(keys) == 3


def all_trials(bench, path, names, **options):
    with Journal(path, KIND, "d") as journal:
        found = run_batches(bench, GRID.batches(names), journal, **{"workers": 1} | options)
    return [Trial(cell, 0, result) for cell, result in found.items()]


def test_a_tug_rises_evenly_stays_and_is_gone_at_once():
    pulls = Tug(share=0.3, rise_s=0.1, stay_s=0.3).pulls(200.0, 5, 100.0)
    force = np.zeros(60)
    for each in pulls:
        force[each.step_after_lift :][: each.duration_steps] += each.extra_force_N
    most = 0.3 * 0.2 * GRAVITY
    rise = most * np.arange(1, 11) / 10
    assert force == pytest.approx(np.concatenate([np.zeros(5), rise, [most] * 30, np.zeros(15)]))


def test_an_oracle_holds_its_margin_everywhere_at_any_noise(bench, tmp_path):
    found = all_trials(bench, tmp_path / "j", ["oracle_1.5"])
    reported = summarise([each for each in found if not each.cell.tug])
    assert reported.success.rate == 1.0
    assert reported.margin_at_lift.least == pytest.approx(1.5, abs=0.1)
    assert reported.margin_at_lift.most == pytest.approx(1.5, abs=0.1)
    tugged = summarise([each for each in found if each.cell.tug])
    assert tugged.held.rate == 1.0
    assert tugged.answered.count == tugged.answered.of == 4
    assert 1 <= tugged.reaction_steps.median <= 12


def test_what_does_not_measure_the_noise_is_solved_once_and_a_model_may_fail(bench, monkeypatch):
    moves = []

    class Counting(LiftPlant):
        def move(self, dx, dy):
            moves.append((dx, dy))
            if len(moves) > 1000:
                raise SolverError("no accepted answer")
            return super().move(dx, dy)

    monkeypatch.setattr("fingerdesign.trials.bench.LiftPlant", Counting)
    memory, quiet = Memory(), Cell("oracle_1.2", 0.5, 200.0, 0.0)
    first, count = bench.run_cell(quiet, memory), len(moves)
    assert bench.run_cell(replace(quiet, noise=5.0), memory) == first
    assert len(moves) == count > 10
    moves += [(0.0, 0.0)] * 1000
    found = bench.run_cell(quiet, Memory())
    assert (found.outcome, found.success, found.ending) == ("failed", False, "no accepted answer")
    json.dumps(asdict(found), allow_nan=False)


def test_a_tugged_grip_is_the_same_grip_until_the_tug(bench):
    cell = Cell("oracle_1.5", 0.5, 200.0, 1.0)
    memory, pulled = Memory(), replace(cell, tug=0.3)
    free, held = bench.episode(cell), bench.episode(pulled, memory)
    still, tugged = free.trace, held.trace
    # What pulls most is what the force is judged by, as in `grip`.
    assert held.result.holding_force_N == pytest.approx(1.3 * free.result.holding_force_N)
    steps = len(still.dx)
    assert still.lift_step == tugged.lift_step == steps - 1 - 5  # held for 0.05 s
    assert np.array_equal(tugged.gage_readings[:steps], still.gage_readings)
    assert len(tugged.dx) == steps + 10 + 10 + 10
    pull = tugged.tangential_force[steps:] / still.tangential_force[-1]
    assert pull[0] == pytest.approx(1.03, abs=1e-6)
    assert pull[9:20] == pytest.approx(1.3, abs=1e-6)
    assert pull[-1] == pytest.approx(1.0, abs=1e-6)

    answered = bench.run_cell(pulled, memory).reaction_steps
    least = 0.5 * bench.grip.approach_step_mm
    assert answered == reaction_steps(tugged, steps, least) is not None
    assert bench.run_cell(cell, memory).reaction_steps is None


def test_each_bench_is_calibrated_with_noise_of_its_own(bench):
    others = [replace(bench, grid=replace(GRID, seed=1))]
    others += [replace(bench, finger=finger) for finger in (("tilt", 0), ("tilt", 1))]
    found = [bench.calibration(0.0), bench.calibration(8.0), *(o.calibration(8.0) for o in others)]
    assert len({each.full_stick.tobytes() for each in found}) == 5


def test_the_settings_of_a_grip_and_its_cell_come_to_the_plant(bench):
    cell = Cell("fixed_ratio", 0.5, 200.0, 0.0)

    def run(other=bench, **values):
        grip = tuned_grip(bench.grip, {f"grip.{key}": value for key, value in values.items()})
        return other.with_grip(grip).episode(cell).trace.normal_force.tolist()

    plain = run()
    assert run(relaxation_per_minute=0.5) != plain
    assert run(**{"hardware.gage_noise_microvolt_per_V": 50.0}) == plain  # a cell sets it
    with pytest.raises(ValueError, match="in 3-D alone"):
        run(off_centre_mm=2.0)
    others = [replace(bench, opposite=bench.problem.with_friction(own)) for own in (0.5, 0.01)]
    assert run(others[0]) == run(others[1])


def test_grips_that_the_journal_lacks_are_run_and_the_work_is_counted(tmp_path):
    made, shares = [], []

    class Made:
        def run_batch(self, cells):
            made.extend(cells)
            return [failed_grip(each, "why") for each in cells]

    all_trials(Made(), tmp_path / "j", ["paper"])
    assert len(made) == 12
    found = all_trials(Made(), tmp_path / "j", ["paper", "x"], report=lambda _, s: shares.append(s))
    assert {each.controller for each in made[12:]} == {"x"}
    assert shares == [(12 + 3 * k) / 24 for k in range(1, 5)]
    for cell, own in ((each.cell, each.result) for each in found):
        facts = own.controller, own.friction_coefficient, own.object_mass_g, own.outcome
        assert facts == (cell.controller, cell.friction, cell.mass_g, "failed")


def test_all_that_decides_a_grip_but_its_cell_is_part_of_a_studys_digest(design):
    grid, drawn = ControlGrid(), ControlGrid.of_perturbed(Perturbed(("tilt",), 5, 2))
    grids = [grid, drawn, replace(drawn, perturbed=Perturbed(("tilt",), 5, 3))]
    grids += [replace(drawn, **each) for each in ({"frictions": (0.2,)}, {"masses_g": (9.0,)})]
    changes = [{"seed": 1}, {"hold_s": 0.3}, {"tug": None}, {"tug": Tug(0.4)}, {"tug_noise": 2.0}]
    grids += [replace(grid, **each) for each in changes]
    given = [(design, each, None, StudyOptions()) for each in grids]
    options = [{"fidelity": "3d"}, {"tuning": TuningSetting()}, {"tuning": TuningSetting((2.0,))}]
    given += [(design, grid, None, StudyOptions(**each)) for each in options]
    given += [(design, grid, SimpleNamespace(to_json=lambda: "trained"), StudyOptions())]
    assert len({_study_digest(*each) for each in given}) == len(given)
    same = replace(grid, frictions=(0.3,), noises=(1.0,)), None, StudyOptions(workers=9)
    assert _study_digest(design, *same) == _study_digest(*given[0])


@pytest.mark.parametrize(("key", "value"), [("lifted", "no"), ("steps", 1.5), ("new", 1)])
def test_a_journal_with_an_invalid_value_is_refused(tmp_path, key, value):
    with Journal(tmp_path / "j.sqlite", KIND, "d") as journal:
        journal.add({"a": [asdict(grip())]})
        assert stored_grips(journal) == {"a": [grip()]}
        journal.add({"b": [asdict(grip()) | {key: value}]})
        with pytest.raises(ResultError, match="not the grips of a control study"):
            stored_grips(journal)


OPTIONS = ["--friction", "0.4", "--friction", "0.6", "--mass-g", "150", "--mass-g", "300"]
OPTIONS += ["--noise", "0", "--noise", "0.5", "--workers", "1"]
OPTIONS += ["--controller", "paper", "--controller", "oracle_1.2"]


def test_a_damaged_journal_is_found_before_the_work(design, tmp_path):
    (tmp_path / "j").write_text("no journal")
    with pytest.raises(DesignError, match="must be a journal of a control study"):
        run_study(design, ["oracle_1.2"], GRID, tmp_path / "j", StudyOptions(report=pytest.fail))


@pytest.mark.slow
def test_the_command_writes_a_whole_folder(coarse_file, tmp_path, capsys, golden):
    out = tmp_path / "out"
    folder = out / "coarse"
    assert main(["study", str(coarse_file), "--out", str(out), *OPTIONS, "--json"]) == 0
    assert [path.name for path in out.iterdir()] == ["coarse"]  # and no journal
    names = [path.name for path in folder.iterdir() if not path.name.startswith("path_")]
    assert sorted(names) == ["control.html", "control.json", "control.png", "grips.csv"]
    assert len(list(folder.glob("path_*"))) == 4
    golden("control_study", folder)
    record = json.loads((folder / "control.json").read_text("utf-8"))
    assert record == json.loads(capsys.readouterr().out)
    jsonschema.validate(record, json_schema("control"))
    assert [each["controller"] for each in record["controllers"]] == ["paper", "oracle_1.2"]
    oracle = record["controllers"][1]
    assert oracle["told"] == "friction and weight"
    assert [row["grips"] for row in oracle["by_noise"]] == [4, 4]
    assert oracle["tugged"]["grips"] == 4
    rows = list(csv.DictReader((folder / "grips.csv").read_text("utf-8").splitlines()))
    assert list(rows[0]) == list(COLUMNS)
    assert len(rows) == record["grips"] == 2 * 4 * 3
    of = [(row["controller"], row["success"], float(row["tug_share"])) for row in rows]
    assert of.count(("oracle_1.2", "1", 0.0)) == oracle["whole_grid"]["success"]["count"]
    page = (folder / "control.html").read_text("utf-8")
    assert "<script" not in page
    assert "http:" not in page.replace("http://www.w3.org", "")
    assert "oracle 1.2" in page
    assert (folder / "control.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (["--controller", "papr"], "did you mean paper?"),
        (["--noise", "-1"], "--noise = -1.0"),
        (["--estimator", "none.json"], "none.json"),
    ],
)
def test_wrong_input_is_refused_before_any_work(coarse_file, tmp_path, capsys, wrong, words):
    assert main(["study", str(coarse_file), "--out", str(tmp_path / "out"), *wrong]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_an_estimator_of_another_finger_or_fidelity_is_refused(design, tmp_path):
    """Before any model is made: grip_problem is not replaced here."""

    def refused(trained, words, **more):
        estimator = SimpleNamespace(gages=11, design=trained)
        options = StudyOptions(estimator=estimator, **more)
        with pytest.raises(DesignError, match=words):
            run_study(design, ("paper",), GRID, tmp_path / "j", options)

    own = {each: finger_key(design, each) for each in ("plane-strain", "3d")}
    refused("f" * 64, "ffffffffffff: must be one")
    refused(own["3d"], "in 3d: must be one")
    refused(own["plane-strain"], "in plane-strain: must be one", fidelity="3d")


def test_a_batch_is_one_object_at_all_noises():
    grid = ControlGrid()
    assert (len(grid.frictions), len(grid.masses_g), grid.faults()) == (10, 10, [])
    cells = [cell for batch in grid.batches(["a", "b"]) for cell in batch]
    assert len(set(cells)) == len(cells) == 2 * grid.cells_of_one
    assert sum(cell.tug > 0.0 for cell in cells) == 2 * 100
    grid = ControlGrid.quick()
    batch = next(grid.batches(["paper"]))
    assert len({(cell.friction, cell.mass_g) for cell in batch}) == 1
    assert [cell.noise for cell in batch if not cell.tug] == list(grid.noises)
    assert [cell.noise for cell in batch if cell.tug] == [grid.tug_noise]
    assert replace(grid, tug=None).cells_of_one == 4 * 4 * 3


def test_seeds_are_of_the_conditions_and_the_same_for_all_controllers():
    cell = Cell("paper", 0.3, 200.0, 0.5)
    for same in ({"controller": "reactive"}, {"tug": 0.3}):
        assert seed_of(cell, 0) == seed_of(replace(cell, **same), 0)
    others = [{}, {"friction": 0.31}, {"mass_g": 201.0}, {"noise": 1.0}]
    seeds = {seed_of(replace(cell, **change), 0) for change in others}
    assert len(seeds | {seed_of(cell, 1)}) == 5


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"frictions": (0.0,)}, "--friction = 0.0: must be from 0.001 to 5"),
        ({"masses_g": (100.0, 1e-300)}, "--mass-g = 1e-300: must be from 0.001 to 100000"),
        ({"noises": (float("nan"),)}, "--noise = nan"),
        ({"noises": (0.5, 0.5)}, "given once"),
        ({"seed": -1}, "--seed = -1"),
        ({"noises": tuple(np.linspace(0.1, 9.0, 2000))}, "at most 100000 grips"),
    ],
)
def test_a_wrong_axis_is_refused_by_its_option(change, words):
    with pytest.raises(DesignError, match=words):
        refuse(replace(ControlGrid(), **change), ())


def test_a_controller_or_a_fault_given_twice_is_refused():
    twice = ControlGrid.of_perturbed(Perturbed(("dying+dying",), 1, 1))
    with pytest.raises(DesignError, match="each once, joined by"):
        refuse(twice, ())
    with pytest.raises(DesignError, match="--controller = paper: must be given once"):
        refuse(ControlGrid(), ("paper", "reactive", "paper"))


@pytest.mark.slow
def test_the_papers_rule_never_slips_wholly_without_noise(tmp_path):
    """Of 16 objects; measured: none of 100. One of 1000 g is not lifted within the travel."""
    grid = ControlGrid(FRICTIONS[::3], MASSES_G[::3], noises=(0.0,), tug=None)
    names = ("paper", "oracle_1.2")
    study = run_study(
        load_design("maeno2000"), names, grid, tmp_path / "j", StudyOptions(workers=2)
    )
    reported = study.summary("paper")
    assert (reported.grips, reported.dropped, reported.failed) == (16, 0, 0)
    assert reported.not_lifted <= 1
    assert study.summary("oracle_1.2").success.rate == 1.0


@pytest.mark.parametrize(
    ("dropped", "forces", "lift", "expected"),
    [
        (False, [1.0, 2.0, 2.5, 2.5], 2, False),  # at the lift it knew
        (False, [1.0, 4.0, 4.0, 4.0], 2, True),  # crushed, and it had reported that it was unsure
        (True, [1.0, 2.0, 2.0, 2.0], None, False),  # dropped in the end, unannounced
        (True, [1.0, 2.0, 2.0, 2.0], 1, False),  # after a lift of which it was unsure
        (False, [1.0, 3.0, 2.0, 2.0], 2, True),  # crushed by just so much
        (False, [1.0, 2.0, 2.0, 2.0], None, False),
    ],
)
def test_what_the_controller_reported_counts_where_it_went_wrong(dropped, forces, lift, expected):
    reported = np.array([True, True, False, False])
    trace = SimpleNamespace(unsure=reported, normal_force=np.array(forces), lift_step=lift)
    assert unsure_at_the_end(trace, dropped, 3.0) is expected
    assert unsure_at_the_end(SimpleNamespace(unsure=None), dropped, 3.0) is None


@pytest.mark.parametrize(
    ("torque_noise", "radius", "label", "warned"),
    [
        (0.05, 0.0, "all+off_centre", True),
        (0.05, 4.0, "off_centre", False),  # it knows how far objects give way
        (None, 0.0, "off_centre", False),  # a cell without torque has no remedy
        (0.05, 0.0, "all", False),
    ],
)
def test_an_estimator_that_cannot_tell_turning_from_slip_is_warned_of(
    torque_noise, radius, label, warned
):
    press = SimpleNamespace(normal=SimpleNamespace(normal_force=np.array([0.0, 100.0])))
    bench = SimpleNamespace(
        grid=ControlGrid.of_perturbed(Perturbed((label,))),
        calibration=lambda noise: press,
        bounds=SimpleNamespace(preload=1e-4, max_approach=1.0),
        grip=SimpleNamespace(hardware=SimpleNamespace(torque_noise_Nmm=torque_noise)),
        estimator=SimpleNamespace(
            curves=SimpleNamespace(turn_radius=np.full(3, radius)), adopted_from="feeler"
        ),
    )
    found = warnings_of(bench, ())
    assert any("turn radius" in words for words in found) is warned
    own = "the estimator is that of feeler, another finger; fingerdesign train makes this finger's"
    assert any(words.startswith(own) for words in found)


@pytest.mark.parametrize(
    ("forces", "preload", "warned"),
    [
        ([0.0, 2.0, 9.82], 0.5, []),
        ([0.0, 2.0, 9.79], 0.5, ["heaviest,"]),  # 400 g at 0.2 need 9.807 N
        ([0.0, 2.0, 10.0], 0.616, []),  # 3.856 N of the bench's press, in equal steps
        ([0.0, 2.0, 10.0], 0.62, ["lightest,"]),  # 3.92 N; crushed by 3.871 N
    ],
)
def test_a_grid_of_which_no_hand_can_lift_all_is_warned_of(forces, preload, warned):
    press = SimpleNamespace(normal=SimpleNamespace(normal_force=np.array(forces)))
    bench = SimpleNamespace(
        grid=ControlGrid((0.2, 0.38), (100.0, 400.0)),
        calibration=lambda noise: press,
        bounds=SimpleNamespace(preload=preload, max_approach=1.0),
        estimator=None,
    )
    found = warnings_of(bench, ())
    assert [words.split()[1] for words in found] == warned
    assert all("that key, or study " in words for words in found)


def test_unannounced_are_those_that_went_wrong_without_a_warning():
    slipped = {"gross_slip": True, "outcome": "complete slip"}
    grips = [
        grip(unsure=False),
        grip(unsure=True),
        grip(unsure=False, **slipped),
        grip(unsure=True, **slipped),
        grip(unsure=False, peak_ratio=4.0),
        grip(unsure=False, lifted=False, outcome="stage travel"),  # neither dropped nor crushed
    ]
    assert unannounced(grips) == 2
    assert unsure(grips) == share_of(1, 2)
    silent = [grip(**slipped)]
    assert (unannounced(silent), unsure(silent)) == (None, None)


@pytest.mark.slow
def test_processes_and_interruptions_change_nothing(bench, tmp_path):
    """The third batch is interrupted: the next run makes those that are left, and none again."""
    names, made = ["fixed_ratio", "oracle_1.2"], []

    class Counted:
        def run_batch(self, cells):
            made.append(tuple(cells))
            return bench.run_batch(cells)

    def interrupt(message, fraction):
        if len(made) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        all_trials(Counted(), tmp_path / "one", names, report=interrupt)
    one = all_trials(Counted(), tmp_path / "one", names)
    assert len(made) == len(set(made)) == len(list(GRID.batches(names)))
    two = all_trials(bench, tmp_path / "two", names, workers=2)
    assert {each.cell: each for each in one} == {each.cell: each for each in two}


def test_a_cell_is_lifted_by_all_that_the_bench_and_the_cell_say(bench, softer, calls_of):
    lifts, noises = calls_of(bench_module, "LiftPlant"), []
    noisy = bench.grip.hardware.model_copy(update={"gage_noise_microvolt_per_V": 9.0})
    settings = {"kinetic_share": 0.8, "hardware": noisy, "relaxation_per_minute": 0.1}
    estimator = SimpleNamespace(at_noise=noises.append)
    own = replace(bench, grip=bench.grip.model_copy(update=settings), face="upper")
    own = replace(own, gripping=softer, opposite=bench.problem, estimator=estimator)
    own.episode(Cell("oracle_1.5", 0.4, 150.0, 0.25))
    problem, face, mass, other, pulls, timed, kinetic = lifts[0][0]
    assert (id(problem.model), id(other.model)) == (id(softer.model), id(bench.problem.model))
    assert (problem.law.coefficient, other.law.coefficient) == (0.4, 0.4)
    assert (face, mass, kinetic, timed.relaxation.share) == ("upper", 150.0, 0.8, 0.1)
    assert (len(pulls) > 0, noises) == (True, [0.25])
    hardware = own._noisy(0.25)
    assert (hardware.gage_noise_microstrain, hardware.gage_noise_microvolt_per_V) == (0.25, 0.0)
