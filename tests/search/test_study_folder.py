"""OUT/NAME of a study: every outcome in every table, invalid variants too, nothing hostile."""

import csv
import json
from dataclasses import replace

import pytest

from fingerdesign.design.shipped import shipped_text
from fingerdesign.errors import DesignError
from fingerdesign.records.outcome import Failure, Outcome
from fingerdesign.search.compare.folder import FILES, FOLDER, failures_csv, write_study
from fingerdesign.search.compare.read import read_comparison
from fingerdesign.search.run.run import Job, planned, study_scenes
from fingerdesign.search.study.file import parse_study
from fingerdesign.search.study.variants import base_design, variants
from tests.support.any_outcomes import any_outcomes

TEXT = """
[study]
name = "three"
base = "maeno2000"
sampling = "grid"
scenes = []
[parameters]
"plates.count" = [9, 15, 99]
[[objectives]]
metric = "plates"
goal = "min"
[constraints]
cost = { at_most = 100.0 }
"""

MADE = any_outcomes(3)


def planned_with(study, scenes):
    return list(planned(study, variants(study, base_design(study)), scenes))


@pytest.fixture(scope="module")
def study():
    return parse_study(TEXT)


@pytest.fixture(scope="module")
def plan(study):
    return planned_with(study, study_scenes(study))


def test_invalid_variants_are_outcomes_and_each_scene_is_a_job(study, plan):
    assert [isinstance(each, Job) for each in plan] == [True, True, False]
    bad = plan[2]
    assert (bad.status, bad.failure.kind, bad.design) == ("failed", "invalid", {})
    assert bad.values == {"plates.count": 99}
    assert "plates." in bad.failure.sentence
    assert Outcome.from_json(bad.to_json()) == bad
    jobs = planned_with(study, {"a": None, "b": None})
    found = [(each.name[-1], getattr(each, "scene_name", "")) for each in jobs]
    assert found == [("1", "a"), ("1", "b"), ("2", "a"), ("2", "b"), ("3", "")]


def test_scenes_are_read_next_to_the_study(tmp_path):
    (tmp_path / "press.toml").write_text(shipped_text("fundamental", "scene"))
    found = parse_study(TEXT.replace("scenes = []", 'scenes = ["press.toml", "pull"]'))
    scenes = study_scenes(found, tmp_path)
    assert list(scenes) == ["press", "pull"]
    assert None not in scenes.values()
    with pytest.raises(DesignError, match="press"):
        study_scenes(found, tmp_path / "elsewhere")


def test_the_folder_holds_all_of_it(study, plan, tmp_path):
    outcomes, folder = [*MADE[:3], plan[2]], tmp_path / "three"
    with FOLDER.written(folder) as aside:
        write_study(aside, study, outcomes, TEXT)
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES)
    assert list(read_comparison([folder]).outcomes) == outcomes
    record = json.loads((folder / "study.json").read_text())
    assert record["objectives"] == [{"metric": "plates", "goal": "min"}]
    assert record["constraints"] == {"cost": {"at_least": None, "at_most": 100.0}}
    assert (record["outcomes"]["all"], record["outcomes"]["invalid"]) == (4, 1)
    assert record["digest"] == study.digest()
    assert (folder / "study.toml").read_text() == TEXT
    rows = list(csv.DictReader((folder / "outcomes.csv").read_text().splitlines()))
    assert [row["name"] for row in rows] == [each.name for each in outcomes]
    assert rows[3]["failure_kind"] == "invalid"
    assert plan[2].name in (folder / "report.html").read_text()


def test_failures_cannot_be_formulas_or_break_rows():
    failure = Failure("failed", "one\ntwo\r\x00three")
    facts = {"name": "=cmd()", "status": "failed", "values": {"+key": "@x"}}
    rows = list(csv.reader(failures_csv([replace(MADE[0], failure=failure, **facts)]).splitlines()))
    assert [rows[0][4], rows[1][0], rows[1][4]] == ["'+key", "'=cmd()", "'@x"]
    assert len(rows) == 2
