"""Records of former versions are read: real files, each written by the code of its day.

No version is released yet; these are from states of the program on three days before the first
(`analyse` of a finger with three plates in plane strain, `sweep` of two). A release adds its own.
"""

import json
import shutil
from pathlib import Path

import pytest

from fingerdesign.records.result import Result
from fingerdesign.records.result_files import RESULT_FILE, read_result

FORMER = sorted((Path(__file__).parent / "former").glob("result_*.json"))
OUTCOMES = sorted((Path(__file__).parent / "former").glob("outcomes_*.jsonl"))


def test_there_are_some():
    assert len(FORMER) >= 3
    assert len(OUTCOMES) >= 2


@pytest.mark.parametrize("path", FORMER, ids=lambda path: path.stem)
def test_a_former_result_is_read_and_keeps_its_numbers(path, tmp_path):
    shutil.copy(path, tmp_path / RESULT_FILE)
    result, written = read_result(tmp_path), json.loads(path.read_text("utf-8"))
    assert result.status == "ok"
    for read, row in zip(result.increments, written["increments"], strict=True):
        assert read.normal_force_N == row["normal_force_N"]
        assert [gage.reading for gage in read.gages] == [gage["reading"] for gage in row["gages"]]
    assert Result.from_json(result.to_json()) == result


@pytest.mark.filterwarnings("ignore::fingerdesign.errors.FormerKeyWarning")  # as a user sees it
@pytest.mark.parametrize("path", FORMER, ids=lambda path: path.stem)
def test_former_results_are_compared_on_one_page(path, tmp_path, terminal):
    shutil.copy(path, tmp_path / RESULT_FILE)
    page = tmp_path / "page.html"
    terminal("compare", tmp_path, "--out", page, code=0)
    assert "small" in page.read_text("utf-8")


@pytest.mark.filterwarnings("ignore::fingerdesign.errors.FormerKeyWarning")
@pytest.mark.parametrize("path", OUTCOMES, ids=lambda path: path.stem)
def test_former_studies_are_read_and_compared(path, tmp_path, terminal):
    """Two outcomes each, as `sweep` wrote them."""
    page, rows = tmp_path / "page.html", tmp_path / "rows.csv"
    terminal("compare", path, "--out", page, "--csv", rows, code=0)
    assert len(rows.read_text("utf-8").splitlines()) == 1 + 2
