"""The command: its folder, its refusals, its exit codes."""

import csv
import json

import pytest
from fingerdesign_cli.main import main

from fingerdesign.results import ResultError
from fingerdesign.validate.folder import validation_folder

DESIGN = '[design]\nname = "bare"\n[body]\ndepth_mm = 4.0\n[plates]\ncount = 0\n'


@pytest.fixture
def design(tmp_path):
    path = tmp_path / "bare.toml"
    path.write_text(DESIGN, encoding="utf-8")
    return path


def test_a_whole_folder_is_written(design, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["validate", str(design), "--out", str(out), "--only", "youngs_modulus", "--json"]
    assert main(arguments) == 0
    folder = out / "bare"
    assert sorted(path.name for path in out.iterdir()) == ["bare"]
    assert {path.name for path in folder.iterdir()} == {
        *("validate.json", "validate.csv", "validate.html", "validate.png"),
    }
    record = json.loads((folder / "validate.json").read_text("utf-8"))
    assert record == json.loads(capsys.readouterr().out)
    page = (folder / "validate.html").read_text("utf-8")
    assert "Young&#39;s modulus" in page
    assert "<script" not in page
    assert "http:" not in page.replace("http://www.w3.org", "")
    with (folder / "validate.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["at"] for row in rows] == ["equal_motion", "equal_force"]
    assert float(rows[0]["normal_force_greatest"]) == pytest.approx(0.2, abs=1e-6)
    assert (folder / "validate.png").read_bytes().startswith(b"\x89PNG")


def test_an_older_one_is_replaced_and_foreign_files_are_left(tmp_path):
    target = tmp_path / "bare"
    for text in ("1", "2"):
        with validation_folder(target) as folder:
            (folder / "validate.json").write_text(text)
    assert (target / "validate.json").read_text() == "2"
    (target / "mine.txt").write_text("kept")
    with (
        pytest.raises(ResultError, match="holds mine"),
        validation_folder(target),
    ):
        pass
    assert (target / "mine.txt").read_text() == "kept"


def test_a_failure_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError), validation_folder(tmp_path / "a"):
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_what_is_wrong_is_refused_before_work(design, tmp_path, capsys):
    taken = tmp_path / "taken" / "bare"
    taken.mkdir(parents=True)
    (taken / "result.json").write_text("{}")
    assert main(["validate", str(design), "--out", str(tmp_path / "taken")]) == 2
    assert "--out" in capsys.readouterr().err
    assert main(["validate", str(tmp_path / "none.toml"), "--out", str(tmp_path / "o")]) == 2
    arguments = ["validate", str(design), "--out", str(tmp_path / "o"), "--only", "linear"]
    assert main(arguments) == 2
    assert "must be one of plane_strain" in capsys.readouterr().err
    assert not (tmp_path / "o").exists() or not list((tmp_path / "o").iterdir())


def test_where_nothing_can_be_tested_the_record_says_so(design, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["validate", str(design), "--out", str(out), "--only", "sheets", "-q"]) == 1
    record = json.loads((out / "bare" / "validate.json").read_text("utf-8"))
    assert record["status"] == "failed"
    assert record["assumptions"][0]["reason"] == "the design has no plates"
    assert "nothing to draw" in (out / "bare" / "validate.html").read_text("utf-8")
    assert capsys.readouterr().out == ""
