"""``fingerdesign compare``: page, CSV and JSON from studies; wrong input is named, exit code 2."""

import json
from dataclasses import replace

import pytest

from fingerdesign.search.compare.read import read_comparison
from tests.support.any_outcomes import any_outcomes

MADE = any_outcomes(12)


@pytest.fixture
def study(tmp_path):
    folder = tmp_path / "study"
    folder.mkdir()
    text = "".join(f"{outcome.to_json()}\n" for outcome in MADE)
    (folder / "outcomes.jsonl").write_text(text, encoding="utf-8")
    return folder


def test_page_csv_and_outcomes(study, tmp_path, said):
    out = tmp_path / "new" / "page.html"
    csv, lines = tmp_path / "designs.csv", tmp_path / "all.jsonl"
    requested = ["compare", str(study), "--out", str(out), "--csv", str(csv), "--json", str(lines)]
    shown = said(*requested, "--objective", "stick_error", "--objective", "cost:min").out
    assert "recommended: any_" in shown
    assert "program's own choice" not in shown
    assert "<title>study: fingers compared</title>" in out.read_text("utf-8")
    assert len(csv.read_text("utf-8").splitlines()) == 13
    assert read_comparison([lines]).outcomes == MADE
    assert sorted(path.name for path in out.parent.iterdir()) == ["page.html"]


def test_json_on_stdout(study, tmp_path, said):
    out = tmp_path / "page.html"
    reported = json.loads(said("compare", study, "--out", out, "--json", "-").out)
    assert reported["designs"] == 12
    assert reported["recommended"] in reported["front"]


@pytest.mark.parametrize(
    ("more", "named"),
    [
        (["--objective", "stick_eror:min"], "did you mean stick_error?"),
        (["--objective", "normal_force_N"], "METRIC:min or METRIC:max"),
        (["--objective", "stik"], "did you mean stick_error?"),
        (["--objective", "stik:min"], "did you mean stick_error?"),
        (["nowhere"], "RESULT = nowhere"),
    ],
)
def test_wrong_input_is_named(study, tmp_path, said, more, named):
    out = tmp_path / "page.html"
    assert named in said("compare", study, "--out", out, *more, code=2).err
    assert not out.exists()


@pytest.mark.parametrize("where", ["study", "study/outcomes.jsonl", "study/outcomes.jsonl/x.html"])
def test_nothing_of_the_study_is_written_over(study, tmp_path, said, where):
    assert "choose another" in said("compare", study, "--out", tmp_path / where, code=2).err
    assert read_comparison([study]).outcomes == MADE


def test_the_page_is_an_html_file(study, tmp_path, said):
    assert "must end in .html" in said("compare", study, "--out", tmp_path / "page.txt", code=2).err


def test_what_is_left_out_is_said(study, tmp_path, said):
    good = next(each for each in MADE if each.status == "ok")
    plain = replace(good, digest="f" * 64, name="plain", metrics={"cost": 1.0})
    extra = tmp_path / "extra.jsonl"
    extra.write_text(f"{plain.to_json()}\n", encoding="utf-8")
    out = tmp_path / "page.html"
    requested = ["compare", str(study), str(extra), "--out", str(out), "--objective", "stick_error"]
    assert "1 design lacks stick_error and was left out (plain)" in said(*requested).out
    reported = json.loads(said(*requested, "--json", "-").out)
    assert reported["not_feasible"] == {"plain": ["no stick_error, an objective"]}
