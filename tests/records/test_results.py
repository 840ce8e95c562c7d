"""result.json holds what CONTRACT promises, comes back the same, and is written whole or not."""

import csv
import json
import multiprocessing
import os
import sys
import zipfile
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign.errors import DesignError
from fingerdesign.records import arrays, result_files
from fingerdesign.records.arrays import read_packed
from fingerdesign.records.base import DATA, SCHEMAS, ResultError, schema_text
from fingerdesign.records.result import (
    GageResult,
    IncrementResult,
    Measurability,
    MeasuredState,
    MeshSummary,
    ModelSummary,
    PointStrain,
    Result,
)
from fingerdesign.records.result_files import MOST_BYTES, RESULTS, read_result
from tests.support.calls import write_results
from tests.support.closed_form_analysis import make_analysis
from tests.support.result_folders import write_result_folder

made = cache(make_analysis)


def result(**changes):
    """Two increments of the closed forms', the first before any contact."""
    points = (PointStrain(1.0, 2.0, 0.0, 3.0, 0.0, 0.0),)
    first, second = (replace(row, points=points) for row in made().result.increments[:2])
    changes = {"increments": (replace(first, stick_ratio=None), second)} | changes
    return replace(made().result, timings_s={"mesh": 0.3}, **changes)


def trace():
    first = made().grip_traces[0]
    ratio = np.where(np.arange(len(first.dx)) > 0, first.stick_ratio, np.nan)
    return replace(first, controller="paper/1", stick_ratio=ratio, without_rule=None)


@pytest.mark.parametrize(
    "changes",
    [
        {"seeds": {"plant": 3}, "parameters": {"body.width_mm": 20.0, "plates.placement": None}},
        {"status": "failed", "failure": "No mesh.", "model": None, "mesh": None, "increments": ()},
    ],
)
def test_a_result_comes_back_the_same_from_json(changes):
    before = result(**changes)
    assert Result.from_json(before.to_json()) == before


def test_stages_and_gaps_are_as_the_contract_says():
    content = json.loads(result().to_json())
    assert content["increments"][0]["stick_ratio"] is None
    stages = ["geometry", "mesh", "assemble", "condense", "increments", "grips", "report"]
    assert list(content["timings_s"]) == stages
    assert content["timings_s"]["grips"] == 0.0


def test_numpy_scalars_are_written_as_numbers_and_what_is_none_is_refused_by_key():
    first, second = made().result.increments[:2]
    odd = replace(second, iterations=np.int64(7), residual=np.float32(0.5))
    assert json.loads(result(increments=(odd,)).to_json())["increments"][0]["iterations"] == 7
    for value in (float("nan"), float("inf"), np.float64("nan")):
        broken = replace(second, normal_force_N=value)
        with pytest.raises(ResultError, match=r"increments\[1\].normal_force_N"):
            result(increments=(first, broken)).to_json()


def test_every_fault_of_a_file_is_named():
    content = json.loads(result().to_json())
    content["increments"][1]["iterations"] = "five"
    content["grips"][0]["controler"] = content["grips"][0].pop("controller")
    with pytest.raises(DesignError) as caught:
        Result.from_json(json.dumps(content), "old.json")
    keys = {fault.key for fault in caught.value.faults}
    assert {"increments.1.iterations", "grips.0.controller", "grips.0.controler"} <= keys
    assert str(caught.value).startswith("old.json: ")


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"schema_version": 99}', '{"a": NaN}', "\x00", '{"a": 1e400}']
)
def test_what_is_no_result_is_a_named_fault(text):
    with pytest.raises(DesignError, match=r"schema_version|JSON"):
        Result.from_json(text)


@pytest.mark.parametrize(
    ("changes", "named"),
    [({"status": "failed"}, "failure"), ({"failure": "No."}, "failure"), ({"mesh": None}, "mesh")],
)
def test_status_and_failure_agree(changes, named):
    with pytest.raises(ValueError, match=named):
        result(**changes)


@pytest.mark.parametrize("name", SCHEMAS)
def test_shipped_schemas_are_current(name):
    shipped = (DATA / f"{name}.schema.json").read_text("utf-8")
    assert shipped == schema_text(name), "run python -m fingerdesign.records.base"


def test_the_schema_holds_a_result():
    import jsonschema

    schema = json.loads(schema_text("result"))
    jsonschema.validate(json.loads(result().to_json()), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(json.loads(result().to_json()) | {"status": "perhaps"}, schema)


def test_folder_holds_history_a_row_an_increment(tmp_path):
    folder = write_result_folder(tmp_path / "a", result(), [trace(), trace()], {"report.html": "x"})
    assert {path.name for path in folder.iterdir()} == {
        *("result.json", "history.csv", "report.html"),
        *("grip_paper_1_mu0.3_200g.csv", "grip_paper_1_mu0.3_200g_2.csv"),
    }
    assert read_result(folder) == result()
    with (folder / "history.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    _, second = result().increments
    assert [row["normal_force_N"] for row in rows] == ["3.0", "6.0"]
    assert [row["stick_ratio"] for row in rows] == ["", str(second.stick_ratio)]
    assert rows[1]["gage_2_reading_microstrain"] == str(second.gages[2].reading)
    assert rows[1]["point_1_strain_xy_microstrain"] == "3.0"
    assert [row["increment"] for row in rows] == ["1", "2"]
    with (folder / "grip_paper_1_mu0.3_200g.csv").open(encoding="utf-8", newline="") as stream:
        steps = list(csv.DictReader(stream))
    assert len(steps) == len(trace().dx)
    assert steps[0]["stick_ratio"] == ""
    assert float(steps[-1]["friction_limit_N"]) == pytest.approx(trace().limit[-1])
    write_result_folder(folder, result(scene="other"))  # the older result is replaced whole
    assert read_result(folder).scene == "other"
    assert not list(folder.glob("grip_*"))
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_interrupted_work_leaves_the_older_result_and_nothing_else(tmp_path):
    write_result_folder(tmp_path / "a", result())

    def interrupted():
        with RESULTS.written(tmp_path / "a") as folder:
            (folder / "result.json").write_text("half", encoding="utf-8")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert read_result(tmp_path / "a") == result()
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_a_foreign_folder_is_left_alone(tmp_path):
    (tmp_path / "thesis.txt").write_text("years of work", encoding="utf-8")
    with pytest.raises(ResultError, match=r"thesis\.txt, which is no result"):
        write_result_folder(tmp_path, result())
    assert (tmp_path / "thesis.txt").exists()
    (tmp_path / "file").write_text("", encoding="utf-8")
    (tmp_path / "link").symlink_to(write_result_folder(tmp_path / "own", result()))
    for name in ("file", "link"):
        with pytest.raises(ResultError, match="not a folder"):
            write_result_folder(tmp_path / name, result())


def test_a_folder_without_result_json_does_not_appear(tmp_path):
    def without():
        with RESULTS.written(tmp_path / "a") as folder:
            (folder / "history.csv").write_text("", encoding="utf-8")

    with pytest.raises(ResultError, match="without"):
        without()
    assert not list(tmp_path.iterdir())


def write(target, text):
    with RESULTS.written(target) as folder:
        (folder / "result.json").write_text(json.dumps(text), encoding="utf-8")


def test_writers_of_one_folder_take_turns(tmp_path):
    context = multiprocessing.get_context("spawn")
    writers = [context.Process(target=write_results, args=(tmp_path / "a",)) for _ in range(2)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert [writer.exitcode for writer in writers] == [0, 0]
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert json.loads((tmp_path / "a" / "result.json").read_text("utf-8")) == "14"


def failing(monkeypatch, names, error):
    rename = Path.rename

    def refuse(self, target):
        if any(name in self.name for name in names):
            raise error
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refuse)


def test_an_older_result_that_cannot_be_put_back_stays(tmp_path, monkeypatch):
    write(tmp_path / "a", "older")
    failing(monkeypatch, [".partial-", ".older-"], OSError("no"))
    with pytest.raises(ResultError, match="the older result is in"):
        write(tmp_path / "a", "new")
    (stored,) = tmp_path.iterdir()
    assert json.loads((stored / "result.json").read_text("utf-8")) == "older"


def test_a_file_system_without_locks_loses_no_work(tmp_path, monkeypatch):
    fcntl = pytest.importorskip("fcntl")

    def refuse(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr(fcntl, "flock", refuse)
    write(tmp_path / "a", "new")
    assert (tmp_path / "a" / "result.json").is_file()


def test_a_notebook_takes_the_numbers_of_a_result(monkeypatch, not_installed):
    gages = tuple(GageResult(k, 1.0, 1.0, 1.0, 0.0, 1.0 + k) for k in (0, 2))
    row = IncrementResult(0.1, 0.0, 6.0, 3.0, 2.0, None, 1, 2, 3, 0.2, 4, 0.0, gages)
    model, mesh = ModelSummary(2, "P2", 9, 5, False), MeshSummary("m", 3, 30.0, 0.0, None)
    found = Result("<mine>", "s", "d", {}, "3d", model=model, mesh=mesh, increments=(row, row))
    assert repr(found) == (
        "<Result of <mine>: scene s, 3d, ok; 2 increments to F_n and F_t of 6 and 3 N>"
    )
    arrays = found.arrays()
    assert arrays["gages"].tolist() == [[1.0, 3.0], [1.0, 3.0]]
    assert arrays["normal_force_N"].tolist() == [6.0, 6.0]
    assert np.isnan(arrays["stick_ratio"]).all()
    not_installed("pandas")
    with pytest.raises(ImportError, match="pip install pandas"):
        found.to_dataframe()
    # pandas need not be there: what it is given stands for it.
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=dict))
    assert found.to_dataframe()["gage_2"].tolist() == [3.0, 3.0]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_a_pipe_and_a_giant_are_no_results(tmp_path):
    os.mkfifo(tmp_path / "result.json")
    with pytest.raises(ResultError, match="not an ordinary file"):
        read_result(tmp_path)
    giant = tmp_path / "giant.json"
    with giant.open("wb") as file:
        file.truncate(MOST_BYTES + 1)
    with pytest.raises(ResultError, match="larger than"):
        read_result(giant)


@pytest.mark.parametrize(
    ("shape", "zeros", "words"), [(10**11, 9, "Memory"), (10**6, 8 * 10**6, "MB")]
)
def test_arrays_that_claim_more_than_they_are_are_refused(tmp_path, shape, zeros, words):
    path = tmp_path / "arrays.npz"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("a.npy", "w") as to,
    ):
        about = {"descr": "<f8", "fortran_order": False, "shape": (shape,)}
        np.lib.format.write_array_header_1_0(to, about)
        to.write(bytes(zeros))
    with pytest.raises(ResultError, match=words):
        read_packed(path)


COLUMNS = {
    "approach_mm": "approach",
    "shear_mm": "shear",
    "command_dx_mm": "dx",
    "command_dy_mm": "dy",
    "rise_mm": "rise",
    "normal_force_N": "normal_force",
    "tangential_force_N": "tangential_force",
    **{name: name for name in ("stick_ratio", "gage_area_mm", "hold", "reported_stick_ratio")},
    **{name: name for name in ("unsure", "warns")},
}


def small_trace():
    values = {name: 10.0 * k + np.arange(3.0) for k, name in enumerate(COLUMNS.values(), start=1)}
    values |= {"hold": np.array([True, False, True]), "unsure": np.array([False, True, True])}
    values |= {"warns": np.array([False, False, True])}
    return arrays.GripTrace("c", 0.5, 200.0, **values, gage_readings=np.arange(6.0).reshape(3, 2))


def test_each_array_of_a_grip_stands_under_its_own_heading(tmp_path):
    made = small_trace()
    result_files.write_grip_csv(tmp_path / "a.csv", made)
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as stream:
        steps = list(csv.DictReader(stream))
    read = {key: [float(row[key]) for row in steps] for key in steps[0]}
    wanted = {key: getattr(made, name).astype(float).tolist() for key, name in COLUMNS.items()}
    wanted |= {"friction_limit_N": made.limit.tolist(), "step": [1.0, 2.0, 3.0]}
    gages = {f"gage_{k}_reading_microstrain": made.gage_readings[:, k].tolist() for k in (0, 1)}
    assert read == wanted | gages
    result_files.write_result_files(tmp_path, result(), [replace(made, without_rule=made)])
    assert (tmp_path / "grip_c_mu0.5_200g_without_rule.csv").is_file()


def test_what_is_read_off_a_grip():
    made = small_trace()
    assert made.forces.tolist() == [made.normal_force.tolist(), made.tangential_force.tolist()]
    assert made.hold_starts.tolist() == [0, 2]
    assert made.weight_per_finger_N == pytest.approx(0.1 * 9.80665)


def history(points, status):
    m, dim = points.shape
    tractions = {"normal_traction": np.ones((len(status), m))}
    tractions |= dict.fromkeys(("tangential_traction", "slip"), np.ones((len(status), m, dim - 1)))
    return arrays.ContactHistory(points, np.ones(m), np.zeros((1, dim), int), status, **tractions)


def test_the_length_that_sticks_is_that_of_its_points_share_on_the_middle_line():
    """Points at 0, 1, 2 and 4 mm, in any order, stand for 0.5, 1, 1.5 and 1 mm."""
    x, order = np.array([0.0, 1.0, 2.0, 4.0]), [2, 0, 3, 1]
    stick, slip = arrays.STICK, arrays.SLIP
    status = np.array([[stick, slip, stick, arrays.OPEN], [slip, stick, stick, stick]])
    flat = history(np.column_stack([x, 0 * x])[order], status[:, order])
    assert flat.stick_length().tolist() == [2.0, 3.5]
    near, far = (np.column_stack([x[order], 0 * x, 0 * x + z]) for z in (0.4, 0.6))
    points, own = np.vstack([far, near]), status[:, order]
    deep = history(points, np.hstack([np.full((2, 4), stick), own]))
    assert deep.stick_length().tolist() == [2.0, 3.5]
    assert points[deep.mid_line(), 0].tolist() == x.tolist()


def test_arrays_of_unlike_lengths_are_refused():
    deep = history(np.ones((4, 3)), np.zeros((2, 4), int))
    for record in (made().slip_studies[0], small_trace(), deep):
        for name in [each.name for each in fields(record)]:
            if isinstance(value := getattr(record, name), np.ndarray) and name != "facets":
                less = value[:-1] if name == "gage_readings" else value.T[:-1].T
                with pytest.raises(ValueError, match="shape"):
                    replace(record, **{name: less})
    for wrong in (np.full((1, 3), 4), np.full((1, 3), -1)):
        with pytest.raises(ValueError, match="must index the 4 points"):
            replace(deep, facets=wrong)
    with pytest.raises(ValueError, match="FieldHistory"):
        arrays.FieldHistory((0, 1), np.zeros((3, 5, 2)))


def test_the_worst_state_decides_what_gages_can_measure():
    states = [MeasuredState(0.5, 2.0, 0.980665, 1.0, 1.0, change, 0.1) for change in (0.3, 0.1)]
    assert states[0].object_mass_g == pytest.approx(200.0)
    for order in (states, states[::-1]):
        assert Measurability(0.5, True, 0.2, tuple(order)).smallest_stick_change == 0.3
