"""``fingerdesign sweep``: help at once, faults of the study, options that exclude each other."""

import itertools
import json
from dataclasses import replace

import pytest
from fingerdesign_cli.main import main
from fingerdesign_cli.search import StudyProgress, words

from fingerdesign.search.run.run import Standing

STUDY = """
[study]
name = "none"
base = "maeno2000"
sampling = "grid"
[parameters]
"plates.count" = [99, 101]
"""


def test_a_wrong_study_names_every_fault(tmp_path, said):
    (tmp_path / "bad.toml").write_text(
        STUDY.replace("[99, 101]", "[9, 11]").replace('"grid"', '"sobol"')
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


def test_what_is_in_the_way_is_refused_before_any_work(tmp_path, said):
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "thesis.tex").touch()
    assert "thesis.tex" in said("sweep", tmp_path / "study.toml", "--out", tmp_path, code=2).err


def test_no_finger_at_all_is_a_failure_with_a_report(tmp_path, said, monkeypatch):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path / "cache"))
    (tmp_path / "study.toml").write_text(STUDY)
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
