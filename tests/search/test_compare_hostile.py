"""Files of strangers: whatever is in them, a fault names the file and what to do."""

import json

import pytest

from fingerdesign.errors import DesignError
from fingerdesign.records.result import GripResult, MeshSummary, ModelSummary, Result
from fingerdesign.search.compare.read import read_comparison
from tests.support.any_outcomes import any_outcomes
from tests.support.result_folders import write_result_folder

GOOD = any_outcomes(3, failed=0.0)


def refused(folder, *names):
    with pytest.raises(DesignError) as caught:
        read_comparison([folder])
    reported = str(caught.value)
    assert "run" in reported  # again
    assert len(reported) < 2000
    for name in names:
        assert name in reported


@pytest.mark.parametrize(
    "record",
    [
        "[" * 100_000,
        json.dumps({"constraints": {"cost": {"at_most": 10**400}}}),
        '{"constraints": {"cost": {"at_most": 1e999}}}',
        '{"constraints": {"cost": {"at_least": NaN}}}',
        '{"seed": ' + "9" * 5000 + "}",
        '{"parameters": ' + "[" * 200 + "]" * 200 + "}",
        "\xff",
    ],
    ids=range(7),
)
def test_records_of_studies(tmp_path, record):
    lines = "".join(f"{each.to_json()}\n" for each in GOOD)
    (tmp_path / "outcomes.jsonl").write_text(lines, encoding="utf-8")
    (tmp_path / "study.json").write_text(record, encoding="latin-1")
    refused(tmp_path, "study.json")


@pytest.mark.parametrize("line", ["[" * 100_000, '{"digest": ' + "9" * 5000 + "}"], ids=range(2))
def test_lines_of_outcomes(tmp_path, line):
    (tmp_path / "outcomes.jsonl").write_text(f"{GOOD[0].to_json()}\n{line}\n", encoding="utf-8")
    refused(tmp_path, "outcomes.jsonl, line 2")


@pytest.fixture
def analysed(tmp_path):
    grips = (GripResult("paper", 0.5, 500.0, True, False, 10.0, 2.4, 1.2, 0.3, 12.0, 0.0, 40),)
    result = Result(
        design="mine",
        scene="fundamental",
        digest="d" * 64,
        versions={},
        parameters={"design.name": "mine"},
        fidelity="plane-strain",
        status="ok",
        model=ModelSummary(2, "t", 10, 5, False),
        mesh=MeshSummary("m", 3, 30.0, 0.0, None),
        grips=grips,
    )
    return write_result_folder(tmp_path / "mine", result)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("friction_coefficient", "0.0"),
        ("peak_normal_force_N", "1e300"),
        ("peak_normal_force_N", "1e999"),
        ("safety_margin", "9" * 400),
        ("object_mass_g", "9" * 5000),
        ("object_mass_g", "[" * 100_000),
    ],
)
def test_numbers_of_results(analysed, key, value):
    path = analysed / "result.json"
    data = json.loads(path.read_text(encoding="utf-8"))
    data["grips"][0][key] = "HERE"
    path.write_text(json.dumps(data).replace('"HERE"', value), encoding="utf-8")
    refused(analysed, "mine")


@pytest.mark.parametrize("row", ["1.0", "nan,1.0", "1.0,inf", "1e300,1.0", "a,b", "1.0,\0"])
def test_rows_of_grips(analysed, row):
    name = "grip_paper_mu0.5_500g.csv"
    path = analysed / name
    path.write_text(f"normal_force_N,tangential_force_N\n1.0,0.5\n{row}\n", encoding="utf-8")
    refused(analysed, name)
    path.write_text("normal_force_N\n1.0\n", encoding="utf-8")
    refused(analysed, name)
    path.write_text("normal_force_N,tangential_force_N\n1.0,0.5\n", encoding="utf-8")
    (found,) = read_comparison([analysed]).outcomes
    assert found.grips[0].normal_force_N == (1.0,)
