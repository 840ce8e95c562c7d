"""The command: its folder, its refusals, its exit codes."""

import csv
import json
import re
from dataclasses import replace

import jsonschema
import pytest
from fingerdesign_cli.commands.finger import validate as command

from fingerdesign.errors import SolverError
from fingerdesign.records.base import json_schema
from fingerdesign.validate.assumptions import ASSUMPTIONS
from tests.support.pages import DOCS, run_python

DESIGN = '[design]\nname = "bare"\n[body]\ndepth_mm = 4.0\n[plates]\ncount = 0\n'


@pytest.fixture
def design(tmp_path):
    path = tmp_path / "bare.toml"
    path.write_text(DESIGN, encoding="utf-8")
    return path


@pytest.mark.slow
def test_a_whole_folder_is_written(design, tmp_path, terminal):
    out = tmp_path / "out"
    shown = terminal("validate", design, "--out", out, "--only", "youngs_modulus", "--json").out
    folder = out / "bare"
    assert [path.name for path in out.iterdir()] == ["bare"]
    names = {f"validate.{ending}" for ending in ("json", "csv", "html", "png")}
    assert {path.name for path in folder.iterdir()} == names
    record = json.loads((folder / "validate.json").read_text("utf-8"))
    assert record == json.loads(shown)
    page = (folder / "validate.html").read_text("utf-8")
    assert "Young&#39;s modulus" in page
    assert "<script" not in page
    assert "http:" not in page.replace("http://www.w3.org", "")
    with (folder / "validate.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["at"] for row in rows] == ["equal_motion", "equal_force"]
    assert float(rows[0]["normal_force_greatest"]) == pytest.approx(0.2, abs=1e-6)
    for row in rows:
        assert row["gage_greatest"] == row["gage_median"] == ""
    assert rows[1]["normal_force_greatest"] == rows[1]["tangential_force_greatest"] == ""
    reported = record["assumptions"][0]
    assert reported["equal_force"]["errors"]["normal_force"] is None
    assert reported["equal_motion"]["errors"]["gage"] is None
    assert "<td>–</td>" in page.replace(' class="number"', "")
    assert (folder / "validate.png").read_bytes().startswith(b"\x89PNG")


def test_what_is_wrong_is_refused_before_work(design, tmp_path, terminal):
    taken, none, out = tmp_path / "taken", tmp_path / "none.toml", tmp_path / "o"
    (taken / "bare").mkdir(parents=True)
    (taken / "bare" / "result.json").write_text("{}")
    for words, reported in (
        ((design, "--out", taken), "--out"),
        ((none, "--out", out), "none.toml"),
        ((design, "--out", out, "--only", "linear"), "must be one of plane_strain"),
        ((design, "--out", out, "--only", "sheet"), "did you mean sheets?"),
    ):
        assert reported in terminal("validate", *words, code=2).err
    assert not out.exists() or not list(out.iterdir())
    shown = "".join(terminal("validate", "--help").out.split())
    assert all(each.key in shown for each in ASSUMPTIONS)
    # `view` names what it cannot read.
    (taken / "bare" / "result.json").rename(taken / "bare" / "validate.json")
    for place in (taken, taken / "bare"):
        assert "RESULT = " in terminal("view", place, code=2).err


def test_models_that_fail_are_no_success_and_nothing_to_report_is_none(
    design, tmp_path, monkeypatch, terminal
):
    def recorded(code, *only):
        shown = terminal("validate", design, "--out", tmp_path, *only, "-q", code=code)
        record = json.loads((tmp_path / "bare" / "validate.json").read_text("utf-8"))
        jsonschema.validate(record, json_schema("validate"))
        return record, shown

    def fails(solves, deep):
        raise SolverError("no equilibrium")

    record, shown = recorded(0, "--only", "sheets")
    assert (record["status"], record["failure"], shown.out) == ("ok", None, "")
    assert record["assumptions"][0]["reason"] == "the design has no plates"
    assert "nothing to draw" in (tmp_path / "bare" / "validate.html").read_text("utf-8")
    of = replace(ASSUMPTIONS[0], pairs=fails)
    monkeypatch.setattr("fingerdesign.validate.run.ASSUMPTIONS", (of,))
    record, shown = recorded(1)
    assert record["status"] == "failed"
    assert record["failure"] == "no assumption could be tested: Plane strain: no equilibrium"
    assert record["failure"] in shown.err


def test_its_python_runs(capsys):
    run_python("how_to/validate.md")
    advice, numbers = capsys.readouterr().out.splitlines()
    assert advice.endswith(").")
    assert float(numbers.split()[0]) > 0.05


def test_every_assumption_and_option_is_reported_of():
    text = (DOCS / "how_to/validate.md").read_text("utf-8")
    keys = re.findall(r"^\| `(\w+)` \|", text, flags=re.MULTILINE)
    assert keys == [each.key for each in ASSUMPTIONS]
    options = {name for parameter in command.params for name in parameter.opts}
    assert set(re.findall(r"`(--\w+)", text)) <= options
