"""``fingerdesign bench``: exit codes, files and words; the measuring itself is tested elsewhere."""

import json
from dataclasses import replace

import pytest
from fingerdesign_bench.check import Check, Shown
from fingerdesign_bench.known.case import load_cases


@pytest.mark.parametrize(
    "arguments",
    [
        ["bench", "--out", "there", "precision", "--out", "there"],
        ["bench", "speed", "--out"],
        ["bench", "nonsense"],
    ],
)
def test_wrong_use_is_exit_code_2(arguments, tmp_path, in_tmp_path, terminal):
    assert "Error" in terminal(*arguments, code=2).err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["precision", "speed", "stability", "whole"])
def test_a_file_cannot_be_the_folder(name, tmp_path, terminal):
    taken = tmp_path / "taken"
    taken.write_text("", encoding="utf-8")
    assert str(taken) in terminal("bench", name, "--out", taken, code=2).err


@pytest.mark.parametrize(
    ("measured", "failures", "code"), [(0.5, {}, 0), (2.0, {}, 1), (0.5, {"speed": "no answer"}, 1)]
)
def test_the_whole_bench(measured, failures, code, tmp_path, monkeypatch, terminal):
    def run_parts(folder, report, quick, parts):
        assert quick
        report("at work")
        check = Check("a number", 1.0, measured, "s")
        return Shown("T", [check], fails=bool(failures)), failures

    monkeypatch.setattr("fingerdesign_bench.cli.bench.run_parts", run_parts)
    shown = terminal("bench", "--out", tmp_path, "--quick", code=code)
    assert "a number" in shown.out
    assert "bench.json" in shown.out
    assert ("speed failed: no answer" in shown.err) == bool(failures)


@pytest.mark.parametrize(("off", "code"), [(0.0, 0), (0.1, 1)])
def test_the_suite_writes_a_page_and_fails_where_an_answer_is_missed(
    off, code, tmp_path, monkeypatch, terminal
):
    wedge = next(case for case in load_cases() if case.name == "wedge")
    case = replace(wedge, reference=wedge.reference + off)
    monkeypatch.setattr("fingerdesign_bench.known.run.load_cases", lambda: [case])
    shown = terminal("bench", "suite", "--quick", "--problems", "--out", tmp_path, code=code).out
    assert case.title in shown
    assert json.loads((tmp_path / "suite.json").read_text("utf-8"))["cases"][0]["value"]
    assert (tmp_path / "problems" / "wedge.npz").exists()
