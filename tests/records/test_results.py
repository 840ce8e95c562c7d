"""result.json holds what CONTRACT promises, comes back the same, and is written whole or not."""

import csv
import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import fingerdesign.records.result as results
from fingerdesign.errors import DesignError
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.base import ResultError, schema_text
from fingerdesign.records.folder import RESULTS, read_result
from fingerdesign.records.result import (
    GageResult,
    GripResult,
    IncrementResult,
    MeshSummary,
    ModelSummary,
    PointStrain,
    Result,
)
from tests.support.result_folders import write_result_folder

SCHEMA = Path(results.__file__).parents[1] / "data" / "result.schema.json"


def increment(number, stick_ratio=0.5):
    gages = tuple(
        GageResult(plate, 3.0 + number, 1.0, 2.0 + number / 2, 1.0 + number / 2, 2.0 + number / 2)
        for plate in range(3)
    )
    return IncrementResult(
        approach_mm=0.1 * number,
        shear_mm=0.0,
        normal_force_N=2.0 * number,
        tangential_force_N=0.25 * number,
        contact_width_mm=1.5,
        stick_ratio=stick_ratio,
        open_nodes=4,
        stick_nodes=3,
        slip_nodes=2,
        peak_pressure_MPa=0.2,
        iterations=5,
        residual=1e-12,
        gages=gages,
        points=(PointStrain(1.0, 2.0, 0.0, 3.0, 0.0, 0.0),),
    )


def result(**changes):
    whole = Result(
        design="finger",
        scene="fundamental",
        digest="0" * 64,
        versions={"fingerdesign": "0.1.0"},
        fidelity="plane-strain",
        model=ModelSummary(2, "P2 triangles", 1000, 60, False, ("constant section",)),
        mesh=MeshSummary("netgen", 500, 21.0, 1e-9, 2e-10),
        increments=(increment(1, None), increment(2)),
        grips=(GripResult("paper", 0.3, 200.0, True, False, 4.0, 1.0, 1.2, 0.3, 4.1, 0.0, 50),),
        timings_s={"mesh": 0.3},
        peak_memory_MB=210.5,
    )
    return dataclasses.replace(whole, **changes)  # type: ignore[arg-type]


def trace(steps=4):
    rising = np.linspace(0.0, 1.0, steps)
    return GripTrace(
        controller="paper/1",
        friction_coefficient=0.3,
        object_mass_g=200.0,
        approach=rising,
        shear=rising,
        normal_force=4 * rising,
        tangential_force=rising,
        stick_ratio=np.where(rising > 0, 1.0 - 0.3 * rising, np.nan),
        gage_area_mm=rising,
        dx=rising,
        dy=rising,
        hold=rising > 0.5,
        gage_readings=np.zeros((steps, 3)),
    )


def test_result_comes_back_the_same_from_json():
    before = result(
        seeds={"plant": 3}, parameters={"body.width_mm": 20.0, "plates.placement": None}
    )
    assert Result.from_json(before.to_json()) == before


def test_failed_result_comes_back_too():
    before = result(
        status="failed", failure="No mesh was accepted.", model=None, mesh=None, increments=()
    )
    assert Result.from_json(before.to_json()) == before


def test_keys_are_those_of_the_contract():
    content = json.loads(result().to_json())
    assert {
        *("design", "scene", "digest", "versions", "fidelity", "status", "failure", "warnings"),
        *("model", "mesh", "increments", "grips", "schema_version", "seeds", "timings_s"),
        "peak_memory_MB",
    } <= set(content)
    assert set(content["model"]) == {
        *("dimension", "element", "dofs", "contact_nodes", "symmetry", "reasons")
    }
    assert set(content["increments"][0]["gages"][0]) == {
        *("plate", "upper", "lower", "membrane", "bending", "reading")
    }
    assert list(content["increments"][0]["points"][0]) == ["xx", "yy", "zz", "xy", "xz", "yz"]
    assert content["increments"][0]["stick_ratio"] is None
    stages = ["geometry", "mesh", "assemble", "condense", "increments", "grips", "report"]
    assert list(content["timings_s"]) == stages
    assert content["timings_s"]["grips"] == 0.0


@pytest.mark.parametrize("value", [float("nan"), float("inf"), np.float64("nan")])
def test_a_value_that_is_no_number_is_refused_by_key(value):
    broken = dataclasses.replace(increment(1), normal_force_N=value)
    with pytest.raises(ResultError, match=r"increments\[1\].normal_force_N"):
        result(increments=(increment(1), broken)).to_json()


def test_numpy_scalars_are_written_as_numbers():
    odd = dataclasses.replace(increment(1), iterations=np.int64(7), residual=np.float32(0.5))
    assert json.loads(result(increments=(odd,)).to_json())["increments"][0]["iterations"] == 7


def test_every_fault_of_a_file_is_named():
    content = json.loads(result().to_json())
    content["increments"][1]["iterations"] = "five"
    content["grips"][0]["controler"] = content["grips"][0].pop("controller")
    with pytest.raises(DesignError) as caught:
        Result.from_json(json.dumps(content), "old.json")
    keys = {fault.key for fault in caught.value.faults}
    assert {"increments.1.iterations", "grips.0.controller", "grips.0.controler"} <= keys
    assert str(caught.value).startswith("old.json: ")


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"schema_version": 99}', '{"a": NaN}', "\x00"])
def test_what_is_no_result_is_a_named_fault(text):
    with pytest.raises(DesignError, match=r"schema_version|JSON"):
        Result.from_json(text)


def test_status_and_failure_agree():
    with pytest.raises(ValueError, match="failure"):
        result(status="failed")
    with pytest.raises(ValueError, match="failure"):
        result(failure="It failed.")
    with pytest.raises(ValueError, match="mesh"):
        result(mesh=None)


def test_shipped_schema_is_current_and_holds_a_result():
    import jsonschema

    wanted = schema_text("result")
    assert SCHEMA.read_text(encoding="utf-8") == wanted, "run python -m fingerdesign.records.base"
    schema = json.loads(wanted)
    jsonschema.validate(json.loads(result().to_json()), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(json.loads(result().to_json()) | {"status": "perhaps"}, schema)


def test_folder_holds_history_a_row_an_increment(tmp_path):
    folder = write_result_folder(tmp_path / "a", result(), [trace(), trace()], {"r.html": "hello"})
    assert {path.name for path in folder.iterdir()} == {
        *("result.json", "history.csv", "r.html"),
        *("grip_paper_1_mu0.3_200g.csv", "grip_paper_1_mu0.3_200g_2.csv"),
    }
    assert read_result(folder) == result()
    with (folder / "history.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["normal_force_N"] for row in rows] == ["2.0", "4.0"]
    assert [row["stick_ratio"] for row in rows] == ["", "0.5"]
    assert rows[1]["gage_2_reading_microstrain"] == "3.0"
    assert rows[1]["point_1_strain_xy_microstrain"] == "3.0"
    with (folder / "grip_paper_1_mu0.3_200g.csv").open(encoding="utf-8", newline="") as stream:
        steps = list(csv.DictReader(stream))
    assert len(steps) == 4
    assert steps[0]["stick_ratio"] == ""
    assert float(steps[-1]["friction_limit_N"]) == pytest.approx(1.2)


def test_older_result_is_replaced_whole(tmp_path):
    write_result_folder(tmp_path / "a", result(), [trace()])
    write_result_folder(tmp_path / "a", result(scene="other"))
    assert read_result(tmp_path / "a").scene == "other"
    assert not list((tmp_path / "a").glob("grip_*"))
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


def test_failed_renaming_puts_the_older_result_back(tmp_path, monkeypatch):
    write_result_folder(tmp_path / "a", result())
    rename = Path.rename

    def refuse_the_new(self, target):
        if ".partial-" in self.name:
            raise OSError("no")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refuse_the_new)
    with pytest.raises(ResultError, match="in place"):
        write_result_folder(tmp_path / "a", result(scene="other"))
    assert read_result(tmp_path / "a") == result()
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_a_foreign_folder_is_left_alone(tmp_path):
    (tmp_path / "thesis.txt").write_text("years of work", encoding="utf-8")
    with pytest.raises(ResultError, match="left alone"):
        write_result_folder(tmp_path, result())
    assert (tmp_path / "thesis.txt").exists()
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(ResultError, match="not a folder"):
        write_result_folder(tmp_path / "file", result())


def test_a_folder_without_result_json_does_not_appear(tmp_path):
    def without():
        with RESULTS.written(tmp_path / "a") as folder:
            (folder / "history.csv").write_text("", encoding="utf-8")

    with pytest.raises(ResultError, match="without"):
        without()
    assert not list(tmp_path.iterdir())


def test_arrays_of_other_shapes_are_refused():
    with pytest.raises(ValueError, match=r"GripTrace.dx has shape \(3,\)"):
        dataclasses.replace(trace(), dx=np.zeros(3))
