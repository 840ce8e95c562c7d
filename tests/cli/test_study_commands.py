"""``generate``, ``sweep`` and ``compare``: files, counts, words; wrong input is named."""

import json
import os
import re
import struct
from dataclasses import replace
from pathlib import Path

import pytest
from fingerdesign_cli.studies.progress import SearchProgress, StudyProgress

from fingerdesign.records.outcome import Failure
from fingerdesign.search.compare.read import read_comparison
from fingerdesign.search.run.run import Standing
from tests.support.any_outcomes import any_outcomes

TEXT = (
    '[study]\nname = "few"\nbase = "maeno2000"\nsampling = "grid"\n'
    '[parameters]\n"plates.count" = [9, 11, 45]\n'
)
NONE = TEXT.replace("[9, 11, 45]", "[99, 101]")
WRONG = TEXT.replace('"grid"', '"sobol"') + '[limits]\ntime_s = 0\n"a" = 1\n'
MADE = any_outcomes(12)


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "few.toml"
    path.write_text(TEXT, "utf-8")
    return path


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


@pytest.mark.slow
def test_files_of_a_finger(study, out, terminal):
    shown = terminal("generate", study, "--out", out, "--only", "1", "--workers", "1").out
    assert "1 variant: " in shown
    folder = out / "few" / "few-0001"
    names = ["body.stl", "few-0001.toml", "finger.step", "finger.stl", "plates.stl"]
    assert sorted(path.name for path in folder.iterdir()) == names
    step = (folder / "finger.step").read_text("utf-8")
    assert step.startswith("ISO-10303-21")
    assert "plate_8" in step
    for name in ("body.stl", "plates.stl", "finger.stl"):
        content = (folder / name).read_bytes()
        (triangles,) = struct.unpack("<I", content[80:84])
        assert len(content) == 84 + 50 * triangles
        assert triangles >= 12


def test_invalid_variants_are_counted_and_reported(study, out, terminal):
    arguments = ["generate", study, "--out", out, "--no-cad"]
    shown = terminal(*arguments).out
    for each in ("few-0003: plates.", "2 variants", "1 cannot exist"):
        assert each in shown
    *each, reported = map(json.loads, terminal(*arguments, "--json").out.splitlines())
    assert (reported["valid"], reported["invalid"], reported["cad_failed"]) == (2, 1, 0)
    assert [one["done"] for one in each] == [1, 2, 3]
    by_number = {one["number"]: one for one in each}
    assert [by_number[number]["kept"] for number in (1, 2, 3)] == [True, True, False]
    assert by_number[3]["faults"]
    shown = terminal(*arguments, "--quiet")
    assert not shown.out
    assert str(out / "few" / "invalid.csv") in shown.err


def test_only_some(study, out, terminal):
    arguments = ["generate", study, "--out", out, "--no-cad", "--quiet", "--only"]
    terminal(*arguments, "2")
    assert not (out / "few" / "few-0001").exists()
    assert (out / "few" / "few-0002" / "few-0002.toml").exists()
    assert terminal(*arguments, "3", code=1).err.startswith("no variant can exist")
    assert "at most 3" in terminal(*arguments, "4", code=2).err


@pytest.mark.parametrize("command", ["generate", "sweep"])
@pytest.mark.parametrize(
    ("name", "text", "named"),
    [
        ("fngers", TEXT, ["did you mean fingers"]),
        ("few.toml", TEXT.replace("plates.count", "plates.cuont"), ["did you mean plates.count"]),
        ("few.toml", WRONG, ["study.count", "limits.time_s"]),
    ],
)
def test_wrong_input_ends_before_any_work(
    command, name, text, named, study, out, terminal, in_tmp_path
):
    study.write_text(text)
    err = terminal(command, name, "--out", out, code=2).err
    assert all(each in err for each in named)
    assert not out.exists()


@pytest.mark.parametrize("command", ["generate", "sweep"])
def test_what_is_in_the_way_is_refused_before_any_work(command, study, out, terminal):
    (out / "few").mkdir(parents=True)
    (out / "few" / "thesis.tex").touch()
    assert "thesis.tex" in terminal(command, study, "--out", out, code=2).err


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "give one"),
        (["--scheduler", "tcp://127.0.0.1:1", "--workers", "2"], "give one"),
        (["--scheduler", ""], "must be an address"),
        (["--scheduler", " "], "must be an address"),
        (["--scheduler", "nosuch"], "must be an address"),
    ],
)
def test_wrong_schedulers_are_refused_where_nothing_is_computed_too(
    study, out, terminal, options, named
):
    study.write_text(NONE)
    assert named in terminal("sweep", study, "--out", out, *options, code=2).err
    assert not out.exists()


def test_no_finger_at_all_is_a_failure_with_a_report(study, out, terminal, own_cache):
    study.write_text(NONE)
    arguments = ["sweep", study, "--out", out]
    shown = terminal(*arguments, code=1)
    assert "failed: 2 invalid; causes in" in shown.out
    assert "few-0001 invalid: plates." in shown.err  # at once, not at the end alone
    assert "Dask" not in shown.err
    assert (out / "few" / "report.html").exists()
    quiet = terminal(*arguments, "--quiet", code=1)
    assert not quiet.out
    assert str(out / "few" / "failures.csv") in quiet.err
    *lines, last = map(json.loads, terminal(*arguments, "--json", code=1).out.splitlines())
    assert [(each["done"], each["number"]) for each in lines] == [(1, 1), (2, 2)]
    assert last["failures"] == 2


@pytest.mark.parametrize("command", ["sweep", "optimise"])
def test_an_interruption_names_what_goes_on(command, study, out, terminal, own_cache, monkeypatch):
    def stopped(*given, **named):
        raise KeyboardInterrupt

    monkeypatch.setattr("fingerdesign.search.run.run.run_jobs", stopped)
    study.write_text(TEXT + '[[objectives]]\nmetric = "cost"\n')
    err = terminal(command, study, "--out", out, code=130).err
    assert "interrupted; finished work is stored: run the same command to go on" in err


@pytest.fixture
def outcomes(tmp_path):
    folder = tmp_path / "study"
    folder.mkdir()
    text = "".join(f"{outcome.to_json()}\n" for outcome in MADE)
    (folder / "outcomes.jsonl").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def page(tmp_path):
    return tmp_path / "new" / "page.html"


def test_page_and_csv(outcomes, page, tmp_path, terminal):
    csv = tmp_path / "designs.csv"
    requested = ["compare", outcomes, "--out", page, "--csv", csv]
    shown = terminal(*requested, "--objective", "stick_error", "--objective", "cost:min").out
    assert "Recommended: any_" in shown
    assert shown.index("★ recommended") < shown.index("○ feasible")  # a row a design
    assert "<title>study: fingers compared</title>" in page.read_text("utf-8")
    assert len(csv.read_text("utf-8").splitlines()) == 13
    assert [path.name for path in page.parent.iterdir()] == ["page.html"]
    reported = json.loads(terminal("compare", outcomes, "--out", page, "--json", "--complete").out)
    assert reported["designs"] == 12
    assert reported["recommended"] in reported["front"]


def test_warnings_fit_80_columns_and_name_the_variant(outcomes, terminal, in_tmp_path, capsys):
    shown = terminal("compare", outcomes.name, "--out", "c.html").out
    chosen = re.search(r"Recommended: (\w+)", shown)[1]
    assert f"warning: {chosen} was analysed in plane strain" in shown
    failed = next(each for each in MADE if each.failure)
    failed = replace(failed, failure=Failure("failed", "No mesh. " * 20))
    say = StudyProgress(lambda *_: None, None)
    say(Standing(1, 2, 1, 0, 0, 1.0, outcome=failed))
    shown += (reported := capsys.readouterr().err)
    assert reported.startswith(f"{failed.name} without a result")
    assert max(map(len, shown.splitlines())) <= 80


@pytest.mark.parametrize(
    ("more", "named"),
    [
        (["--objective", "stick_eror:min"], "did you mean stick_error?"),
        (["--objective", "normal_force_N"], "METRIC:min or METRIC:max"),
        (["--objective", "stik"], "did you mean stick_error?"),
        (["--objective", "cost:min", "--objective", "cost:max"], "a metric once"),
        (["nowhere"], "RESULT = nowhere"),
        (["--out", "page.txt"], "must end in .html"),
        (["--csv", "new/page.html"], "must end in .csv"),
        (["--csv", "notes.toml"], "must end in .csv"),
        (["--csv", "study/history.csv"], "a result's own file"),
        # Nothing of the study is written over.
        (["--out", "study"], "choose another"),
        (["--out", "study/outcomes.jsonl"], "choose another"),
        (["--out", "study/outcomes.jsonl/x.html"], "choose another"),
        *(([option, "pipe.html"], "a regular file") for option in ("--out", "--csv")),
    ],
)
def test_wrong_input_of_a_comparison_is_named(outcomes, page, terminal, in_tmp_path, more, named):
    os.mkfifo("pipe.html")
    (outcomes / "history.csv").touch()
    assert named in terminal("compare", "study", "--out", page, *more, code=2).err
    assert not page.exists()
    assert read_comparison([outcomes]).outcomes == MADE
    assert Path("pipe.html").is_fifo()


def test_the_time_left_of_a_search_that_goes_on_is_by_the_trials_of_this_run():
    shown = []
    progress = SearchProgress(shown.append, scenes=2)
    progress.trials(10, 20)
    progress.standing(Standing(4, 8, 0, 0, 4, 0.0))
    (now,) = shown
    assert (now.number, now.of) == (24, 40)
    assert now.left == pytest.approx(now.seconds / 4 * 16)  # four came since it began


def test_a_users_own_file_is_not_taken_for_one_of_a_search(tmp_path, terminal):
    own = tmp_path / "plain-optimised.toml"
    terminal("new", tmp_path / "plain.toml", "-q")
    # Notes of the user's; a design that a search once made and that is the one to begin with.
    made = "# Made by `fingerdesign optimise\n" + (tmp_path / "plain.toml").read_text("utf-8")
    for text, design in (("my notes", tmp_path / "plain.toml"), (made, own)):
        own.write_text(text, "utf-8")
        assert "your own file" in terminal("optimise", design, "--out", tmp_path, code=2).err
        assert own.read_text("utf-8") == text
