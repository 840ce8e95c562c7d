"""``fingerdesign replay``: a recorded grip put before a controller; faulty ones refused.

``fingerdesign grip``: options over the design's table, the record it leaves, exit codes.
"""

import csv
import json

import numpy as np
import pytest
from fingerdesign_cli.main import main

from fingerdesign import load_design
from fingerdesign.control.c_code import c_files
from fingerdesign.control.estimator import (
    Band,
    FingerCurves,
    GripEstimator,
    Layer,
    feature_count,
)
from fingerdesign.control.plants.lift import LiftPlant
from fingerdesign.control.plants.recorded import trace_of
from fingerdesign.control.plants.rig import Hardware, ImperfectPlant
from fingerdesign.sensing.model import grip_problem
from fingerdesign.sensing.onnx_file import onnx_file
from fingerdesign.sensing.training import settings_of, training_key

DESIGN = """
[design]
name = "coarse"
[plates]
length_mm = 1.0
cover_mm = 1.2
[gages]
length_mm = 0.6
[mesh.section]
contact_size_mm = 0.3
plate_size_mm = 0.3
plate_end_size_mm = 0.1
"""
MOVES = [(0.0, 0.004)] * 10 + [(0.004, 0.004)] * 20


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A design's file and a grip "recorded" on its model, a little noisy."""
    folder = tmp_path_factory.mktemp("replay")
    (folder / "coarse.toml").write_text(DESIGN)
    fine = DESIGN.replace("contact_size_mm = 0.3", "contact_size_mm = 0.1")
    (folder / "fine.toml").write_text(f"{fine}[grip]\nmax_steps = 12\n")
    problem = grip_problem(load_design(folder / "coarse.toml"), contact_size_mm=0.3)
    lift = LiftPlant(problem.with_friction(0.3), "both", 500.0)
    rig = ImperfectPlant(lift, Hardware(gage_noise_microstrain=0.5), np.random.default_rng(0))
    trace = trace_of([rig.move(*move) for move in MOVES], MOVES, 100.0)
    (folder / "grip.csv").write_text(trace.to_csv())
    return folder


def run(folder, out, *options, trace="grip.csv"):
    return main(
        ["replay", str(folder / "coarse.toml"), str(folder / trace), "--out", str(out), *options]
    )


def test_what_the_controller_asks_for_stands_beside_what_the_rig_did(folder, tmp_path, capsys):
    assert run(folder, tmp_path, "--json", "--controller", "reactive") == 0
    printed = json.loads(capsys.readouterr().out)
    record = json.loads((tmp_path / "coarse/replay.json").read_text())
    assert record == printed
    assert (record["controller"], record["samples"]) == ("reactive", len(MOVES))
    with (tmp_path / "coarse/replay.csv").open() as file:
        rows = list(csv.DictReader(file))
    # 0.03 mm of preload are eight moves; the header is row 1.
    assert [int(row["row"]) for row in rows] == list(range(10, 32))
    assert float(rows[-1]["dx_mm"]) == 0.004
    assert abs(float(rows[-1]["asked_dy_mm"])) <= 0.004  # one approach_step_mm, either way
    assert {row["stick_ratio_told"] for row in rows} == {""}
    total = sum(float(row["asked_dx_mm"]) for row in rows)
    assert record["asked_shear_mm"] == pytest.approx(total, rel=1e-6)


def test_the_table_is_for_people(folder, tmp_path, capsys):
    assert run(folder, tmp_path) == 0
    shown = capsys.readouterr().out
    assert "the rig" in shown
    assert "rows 10 to 31 of grip.csv" in shown


def test_a_faulty_trace_is_refused_by_row_and_column_and_leaves_nothing(folder, tmp_path, capsys):
    lines = (folder / "grip.csv").read_text().splitlines()
    cells = lines[6].split(",")
    cells[5], cells[7] = "nan", ""
    (folder / "bad.csv").write_text("\n".join([*lines[:6], ",".join(cells), *lines[7:]]))
    assert run(folder, tmp_path, trace="bad.csv") == 2
    reported = capsys.readouterr().err.splitlines()
    assert len([line for line in reported if "row 7" in line]) == 2
    assert any("bad.csv" in line and "row 7, column gage_1 = nan" in line for line in reported)
    assert any("row 7, column gage_3 = empty" in line for line in reported)
    assert list(tmp_path.iterdir()) == []


def test_another_fingers_trace_and_unfit_controllers_are_refused(folder, tmp_path, capsys):
    few = [",".join(line.split(",")[:10]) for line in (folder / "grip.csv").read_text().split()]
    (folder / "few.csv").write_text("\n".join(few))
    assert run(folder, tmp_path, trace="few.csv") == 2
    assert "row 1, column gage_6 = 5 gages: must be at least 15" in capsys.readouterr().err
    for name in ("oracle_1.2", "regulator", "magic"):
        assert run(folder, tmp_path, "--controller", name) == 2
        assert name in capsys.readouterr().err
    assert run(folder, tmp_path, "--controller", "regulator") == 2
    assert "give --estimator FILE (fingerdesign teach" in capsys.readouterr().err
    assert run(folder, tmp_path, "--estimator", str(folder / "none.json")) == 2
    assert "--estimator" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_an_estimator_reports_and_the_regulator_asks(folder, tmp_path, capsys, said):
    """One that was taught nothing: its numbers mean nothing, but they are in their columns."""
    gages, rng = 15, np.random.default_rng(0)
    forces, ones = np.array([0.0, 5.0]), np.full((2, gages), 1.0)
    curves = FingerCurves(forces, np.zeros((2, gages)), ones, 0.01 * forces, np.full(2, 10.0))
    layer = Layer(0.01 * rng.standard_normal((feature_count(gages), 2)), np.array([0.7, 0.4]))
    count = feature_count(gages)
    band = Band(10.0, np.zeros(count), np.ones(count), (layer,), np.array([[1.0, 0.1]]))
    path = tmp_path / "estimator.json"
    path.write_text(GripEstimator("another", curves, 0.5, (band,)).to_json())
    out = tmp_path / "out"
    assert run(folder, out, "--estimator", str(path)) == 2
    reported = capsys.readouterr().err
    assert "--estimator = one taught on another: must be one taught on this design" in reported
    assert "fingerdesign teach" in reported
    for command in ("study-control", "tune"):
        arguments = [command, str(folder / "coarse.toml"), "--out", str(out)]
        assert (
            "must be one taught on this design" in said(*arguments, "--estimator", path, code=2).err
        )
    in_c = ["export-c", path, folder / "coarse.toml", "--out", out]
    assert "ESTIMATOR = one taught on another: must be" in said(*in_c, code=2).err
    assert not out.exists()
    design = load_design(folder / "coarse.toml")
    key = training_key(design, settings_of(design))
    path.write_text(GripEstimator(key, curves, 0.5, (band,)).to_json())
    solid = ["grip", str(folder / "coarse.toml"), "--controller", "regulator", "--fidelity", "3d"]
    refused = said(*solid, "--estimator", path, "--out", tmp_path / "solid", code=2).err
    assert "--estimator = taught in plane-strain: must be one taught in 3d" in refused
    louder = GripEstimator.from_json(path.read_text()).at_noise(2.0)
    assert "15 gages, 198 weights" in said(*in_c[:-1], tmp_path / "c", "--noise", 2.0).out
    written = {file.name: file.read_text() for file in (tmp_path / "c/coarse").iterdir()}
    assert written == c_files(louder, design.grip)
    as_onnx = ["export-onnx", *in_c[1:-1], tmp_path / "onnx", "--noise", 2.0]
    assert "estimator.onnx, 15 gages, 198 weights" in said(*as_onnx).out
    assert (tmp_path / "onnx/coarse/estimator.onnx").read_bytes() == onnx_file(louder)
    assert run(folder, out, "--estimator", str(path), "--controller", "regulator", "--quiet") == 0
    with (out / "coarse/replay.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        used = float(row["friction_used_told"])
        assert 0.0 < used <= 1.0
        ratio = float(row["tangential_force_N"]) / float(row["normal_force_N"])
        rounding = 0.5e-4 / used + 0.5e-3  # four decimals of what is used, four digits of friction
        assert float(row["friction_told"]) == pytest.approx(ratio / used, rel=rounding)
        assert 0.0 <= float(row["stick_ratio_told"]) <= 1.0
    record = json.loads((out / "coarse/replay.json").read_text())
    assert record["controller"] == "regulator"
    assert record["most_friction_used_told"] == pytest.approx(
        max(float(row["friction_used_told"]) for row in rows), abs=1e-4
    )


def test_a_folder_of_something_else_is_left_alone(folder, tmp_path, said):
    (tmp_path / "coarse").mkdir()
    (tmp_path / "coarse/control.json").write_text("{}")
    for command in (
        ["replay", str(folder / "coarse.toml"), str(folder / "grip.csv")],
        ["tune", str(folder / "coarse.toml")],
        ["teach", str(folder / "coarse.toml")],
        ["gages", str(folder / "coarse.toml")],
        ["study-control", str(folder / "coarse.toml"), "--quick"],
    ):
        (tmp_path / "coarse/mine.txt").write_text("mine")
        reported = said(*command, "--out", tmp_path, code=2).err
        assert "--out = " in reported
        assert "mine.txt" in reported
    assert len(list((tmp_path / "coarse").iterdir())) == 2


def test_each_friction_is_lifted_once_and_recorded(folder, tmp_path, said):
    options = ["--friction", "0.3", "--friction", "0.7", "--mass-g", "30"]
    arguments = ["grip", folder / "fine.toml", "--out", tmp_path / "out", *options]
    printed = json.loads(said(*arguments, "--json").out)
    record = json.loads((tmp_path / "out/coarse/result.json").read_text())
    assert record["fidelity"] == "plane-strain"
    assert record["grips"] == printed["grips"]
    assert [grip["friction_coefficient"] for grip in record["grips"]] == [0.3, 0.7]
    for grip in record["grips"]:
        assert grip["object_mass_g"] == 30.0
        assert grip["lifted"]
        # mg < 2 F_t of each finger.
        assert grip["final_tangential_force_N"] > 0.5 * 0.030 * 9.80665


SOLID = """
[mesh]
contact_size_mm = 0.7
plate_size_mm = 1.0
far_size_mm = 3.0
layers = 2
[grip]
max_approach_mm = 0.2
max_steps = 20
"""


def test_every_decision_on_grips_can_be_taken_in_3d(tmp_path, said):
    """On a short finger swept through two layers: another model, said so, and taken by each."""
    short = DESIGN.replace("[plates]", "[body]\ndepth_mm = 4.0\n[plates]\ncount = 5\nspan_mm = 4.0")
    (tmp_path / "short.toml").write_text(short.replace("[mesh.section]", f"{SOLID}[mesh.section]"))
    options = [tmp_path / "short.toml", "--controller", "fixed_ratio", "--quiet"]
    study = ["--friction", "0.6", "--mass-g", "30", "--noise", "0", "--workers", "1", "--no-tug"]
    found = {}
    for fidelity in ("plane-strain", "3d"):
        more = ["--fidelity", fidelity, "--out", tmp_path / fidelity]
        said("study-control", *options, *study, *more)
        record = json.loads((tmp_path / fidelity / "coarse/control.json").read_text())
        assert record["model"]["fidelity"] == fidelity
        with (tmp_path / fidelity / "coarse/grips.csv").open() as file:
            (found[fidelity],) = csv.DictReader(file)
    flat, solid = (float(each["peak_normal_force_N"]) for each in found.values())
    assert 0.6 * flat < solid != flat
    problem = grip_problem(load_design(tmp_path / "short.toml"), "3d")
    assert problem.model.dimension == 3
    design = load_design(tmp_path / "short.toml")
    keys = {training_key(design, settings_of(design), each) for each in ("plane-strain", "3d")}
    assert len(keys) == 2


def test_a_finger_that_feels_nothing_cannot_grip(tmp_path, said):
    path = tmp_path / "plain.toml"
    path.write_text('design.name = "plain"\nplates.count = 0\n')
    assert "plates.count" in said("grip", path, "--out", tmp_path / "out", code=2).err


def test_a_faulty_option_is_one_fault_that_names_it(folder, tmp_path, said):
    options = ["--friction", "0", "--mass-g", "-3", "--controller", "magic"]
    shown = said(
        "grip", folder / "fine.toml", "--out", tmp_path / "out", *options, code=2
    ).err.splitlines()
    assert len(shown) == 3
    magic, first, second = sorted(shown)
    assert magic.startswith("--controller (grip.controller) = 'magic': ")
    assert not (tmp_path / "out").exists()
    assert first.startswith("--friction (grip.friction_coefficients[0]) = 0.0: must be more than 0")
    assert second.startswith("--mass-g (grip.object_mass_g) = -3.0: must be more than 0")
