"""``generate``, ``sweep`` and ``compare``: files, counts, words; wrong input is named."""

import itertools
import json
import os
import struct
from dataclasses import replace
from pathlib import Path

import pytest
from fingerdesign_cli.main import main
from fingerdesign_cli.search import StudyProgress, words
from fingerdesign_cli.search import _read as read_with

from fingerdesign.search.compare.read import read_comparison
from fingerdesign.search.run.run import Standing
from fingerdesign.search.study.file import parse_study
from tests.support.any_outcomes import any_outcomes

TEXT = (
    '[study]\nname = "few"\nbase = "maeno2000"\nsampling = "grid"\n'
    '[parameters]\n"plates.count" = [9, 11, 45]\n'
)
NONE = TEXT.replace('"few"', '"none"').replace("[9, 11, 45]", "[99, 101]")
MADE = any_outcomes(12)


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "few.toml"
    path.write_text(TEXT, "utf-8")
    return str(path)


def test_files_of_a_finger(study, tmp_path, said):
    out = tmp_path / "out"
    assert (
        "1 variants, 0 of them there already"
        in said("generate", study, "--out", out, "--count", "1", "--workers", "1").out
    )
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


def test_invalid_variants_are_counted_and_reported(study, tmp_path, said):
    arguments = ["generate", study, "--out", str(tmp_path), "--no-cad"]
    shown = said(*arguments).out
    assert "few-0003: plates." in shown
    assert "2 variants" in shown
    assert "1 cannot exist" in shown
    *each, reported = map(json.loads, said(*arguments, "--json").out.splitlines())
    assert (reported["valid"], reported["invalid"], reported["cad_failed"]) == (2, 1, 0)
    assert [one["done"] for one in each] == [1, 2, 3]
    by_number = {one["number"]: one for one in each}
    assert [by_number[number]["kept"] for number in (1, 2, 3)] == [True, True, False]
    assert by_number[3]["faults"]
    shown = said(*arguments, "--quiet")
    assert not shown.out
    assert shown.err.splitlines() == [
        f"1 of 3 cannot exist: faults in {tmp_path / 'few' / 'invalid.csv'}"
    ]


def test_only_some(study, tmp_path, capsys, said):
    arguments = ["generate", study, "--out", str(tmp_path / "out"), "--no-cad"]
    assert main([*arguments, "--only", "2"]) == 0
    assert not (tmp_path / "out" / "few" / "few-0001").exists()
    assert (tmp_path / "out" / "few" / "few-0002" / "few-0002.toml").exists()
    capsys.readouterr()
    assert main([*arguments, "--only", "3", "--quiet"]) == 1
    assert capsys.readouterr().err.startswith(
        "no variant can exist: all 1 have faults, reported in "
    )
    assert "at most 3" in said(*arguments, "--only", "4", code=2).err


def test_wrong_input_ends_before_any_work(study, tmp_path, said):
    out = tmp_path / "out"
    assert "did you mean fingers" in said("generate", "fngers", "--out", out, code=2).err
    (tmp_path / "bad.toml").write_text(TEXT.replace("plates.count", "plates.cuont"), "utf-8")
    assert (
        "did you mean plates.count"
        in said("generate", tmp_path / "bad.toml", "--out", out, code=2).err
    )
    assert not out.exists()
    (out / "few").mkdir(parents=True)
    (out / "few" / "mine.txt").write_text("mine", "utf-8")
    assert "mine.txt" in said("generate", study, "--out", out, code=2).err


def test_the_commands_fidelity_stands_in_the_study_that_is_kept(study):
    text, found = read_with(Path(study), "3d")
    assert found.study.fidelity == "3d"
    assert parse_study(text) == found
    assert text.replace('fidelity = "3d"\n', "") == TEXT
    assert read_with(Path(study), None)[0] == TEXT


def test_a_wrong_study_names_every_fault(tmp_path, said):
    (tmp_path / "bad.toml").write_text(
        NONE.replace("[99, 101]", "[9, 11]").replace('"grid"', '"sobol"')
        + '[limits]\ntime_s = 0\n"a" = 1\n'
    )
    shown = said("sweep", tmp_path / "bad.toml", "--out", tmp_path / "out", code=2).err
    assert "study.count" in shown
    assert "limits.time_s" in shown
    assert not (tmp_path / "out").exists()
    assert main(["sweep", str(tmp_path / "absent.toml"), "--out", str(tmp_path / "out")]) == 2


def test_workers_and_scheduler_exclude_each_other(tmp_path, said):
    options = ["--out", str(tmp_path), "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"]
    for order in (options, options[:2] + options[4:] + options[2:4]):
        assert "give one" in said("sweep", "fingers", *order, code=2).err


@pytest.mark.parametrize("address", ["", " "])
def test_an_empty_scheduler_is_refused_where_nothing_is_computed_too(tmp_path, said, address):
    (tmp_path / "study.toml").write_text(NONE)
    options = ["--out", tmp_path / "out", "--scheduler", address]
    assert "must be an address" in said("sweep", tmp_path / "study.toml", *options, code=2).err
    assert not (tmp_path / "out").exists()


def test_what_is_in_the_way_is_refused_before_any_work(tmp_path, said):
    (tmp_path / "study.toml").write_text(NONE)
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "thesis.tex").touch()
    assert "thesis.tex" in said("sweep", tmp_path / "study.toml", "--out", tmp_path, code=2).err


def test_no_finger_at_all_is_a_failure_with_a_report(tmp_path, said, monkeypatch):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path / "cache"))
    (tmp_path / "study.toml").write_text(NONE)
    shown = said("sweep", tmp_path / "study.toml", "--out", tmp_path, code=1).out
    assert "failed: 2 invalid; causes in" in shown
    assert (tmp_path / "none" / "report.html").exists()
    quiet = said("sweep", tmp_path / "study.toml", "--out", tmp_path, "--quiet", code=1)
    assert not quiet.out
    causes = tmp_path / "none" / "failures.csv"
    assert quiet.err.splitlines() == [f"2 of 2 failed: causes in {causes}"]
    shown = said("sweep", tmp_path / "study.toml", "--out", tmp_path, "--json", code=1).out
    *lines, last = map(json.loads, shown.splitlines())
    assert [(each["done"], each["number"]) for each in lines] == [(1, 1), (2, 2)]
    assert last["failures"] == 2


@pytest.mark.parametrize(
    ("changes", "reported"),
    [
        ({}, "3 of 8"),
        ({"failures": 1, "left": 200.0}, "3 of 8, 1 failed, 3 min left"),
        ({"waiting": True, "left": 5.0}, "3 of 8, waiting for workers"),
        ({"number": 8, "left": 0.0}, "8 of 8"),
    ],
)
def test_progress_in_words(changes, reported):
    assert words(replace(Standing(3, 8, 0, 0, 3, 1.0), **changes)) == reported


def test_plain_lines_are_few(monkeypatch):
    monkeypatch.setattr("sys.stderr.isatty", lambda: False, raising=False)
    shown = []
    reported = StudyProgress(lambda message, fraction=None: shown.append(message), True, False)
    for number in range(1, 201):
        reported(Standing(number, 200, 0, 0, number, 1.0))
    assert shown == ["1 of 200", "200 of 200"]
    reported(Standing(3, 200, 0, 0, 1, 1.0, waiting=True))
    reported(Standing(4, 200, 0, 0, 1, 1.0, threads=2))
    assert shown[2:] == ["3 of 200, waiting for workers", "4 of 200"]


def test_a_long_variant_is_reported_to_be_alive(monkeypatch):
    """Where nothing comes, a line at least every ten seconds, each another than the last."""
    monkeypatch.setattr("sys.stderr.isatty", lambda: False, raising=False)
    clock = [1000.0]
    monkeypatch.setattr("fingerdesign_cli.search.time.monotonic", lambda: clock[0])
    shown: dict[str, float] = {}
    reported = StudyProgress(
        lambda message, fraction=None: shown.setdefault(message, clock[0]), True, False
    )
    for _ in range(200):  # a look each two seconds, with the same words
        reported(Standing(1, 3, 0, 0, 1, 1.0, left=300.0, threads=2))
        clock[0] += 2.0
    times = list(shown.values())
    assert max(after - before for before, after in itertools.pairwise(times)) <= 10.0
    assert times[-1] > clock[0] - 12.0
    assert all(message.startswith("1 of 3, 5 min left") for message in shown)


@pytest.fixture
def outcomes(tmp_path):
    folder = tmp_path / "study"
    folder.mkdir()
    text = "".join(f"{outcome.to_json()}\n" for outcome in MADE)
    (folder / "outcomes.jsonl").write_text(text, encoding="utf-8")
    return folder


def test_page_csv_and_outcomes(outcomes, tmp_path, said):
    out = tmp_path / "new" / "page.html"
    csv, lines = tmp_path / "designs.csv", tmp_path / "all.jsonl"
    requested = [
        "compare",
        str(outcomes),
        "--out",
        str(out),
        "--csv",
        str(csv),
        "--json",
        str(lines),
    ]
    shown = said(*requested, "--objective", "stick_error", "--objective", "cost:min").out
    assert "recommended: any_" in shown
    assert "program's own choice" not in shown
    assert "<title>study: fingers compared</title>" in out.read_text("utf-8")
    assert len(csv.read_text("utf-8").splitlines()) == 13
    assert read_comparison([lines]).outcomes == MADE
    assert sorted(path.name for path in out.parent.iterdir()) == ["page.html"]
    reported = json.loads(said("compare", outcomes, "--out", out, "--json", "-").out)
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
        (["--out", "page.txt"], "must end in .html"),
    ],
)
def test_wrong_input_is_named(outcomes, tmp_path, said, more, named):
    out = tmp_path / "page.html"
    assert named in said("compare", outcomes, "--out", out, *more, code=2).err
    assert not out.exists()


@pytest.mark.parametrize("where", ["study", "study/outcomes.jsonl", "study/outcomes.jsonl/x.html"])
def test_nothing_of_the_study_is_written_over(outcomes, tmp_path, said, where):
    assert "choose another" in said("compare", outcomes, "--out", tmp_path / where, code=2).err
    assert read_comparison([outcomes]).outcomes == MADE


@pytest.mark.parametrize("option", ["--out", "--csv", "--json"])
def test_a_pipe_is_not_replaced(outcomes, tmp_path, said, option):
    pipe, out = tmp_path / "pipe.html", tmp_path / "page.html"
    os.mkfifo(pipe)
    err = said("compare", outcomes, "--out", out, option, pipe, code=2).err
    assert "must be a regular file" in err
    assert pipe.is_fifo()
    assert not out.exists()


def test_what_is_left_out_is_said(outcomes, tmp_path, said):
    good = next(each for each in MADE if each.status == "ok")
    plain = replace(good, digest="f" * 64, name="plain", metrics={"cost": 1.0})
    extra = tmp_path / "extra.jsonl"
    extra.write_text(f"{plain.to_json()}\n", encoding="utf-8")
    out = tmp_path / "page.html"
    requested = [
        "compare",
        str(outcomes),
        str(extra),
        "--out",
        str(out),
        "--objective",
        "stick_error",
    ]
    assert "1 design lacks stick_error and was left out (plain)" in said(*requested).out
    reported = json.loads(said(*requested, "--json", "-").out)
    assert reported["not_feasible"] == {"plain": ["no stick_error, an objective"]}
