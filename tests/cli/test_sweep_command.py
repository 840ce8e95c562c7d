"""``fingerdesign sweep``: help at once, faults of the study, options that exclude each other."""

import itertools
import json
import subprocess
import sys

import pytest
from fingerdesign_cli.main import main
from fingerdesign_cli.search import StudyProgress, words

STUDY = """
[study]
name = "none"
base = "maeno2000"
sampling = "grid"
[parameters]
"plates.count" = [99, 101]
"""


def test_help_and_the_main_help_load_neither_numpy_nor_dask():
    code = (
        "import sys; from fingerdesign_cli.main import main; main(['sweep', '--help']);"
        "sys.exit(bool({'numpy', 'distributed', 'pydantic'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "--scheduler" in done.stdout


def test_a_wrong_study_names_every_fault(tmp_path, capsys):
    (tmp_path / "bad.toml").write_text(
        STUDY.replace("[99, 101]", "[9, 11]").replace('"grid"', '"sobol"')
        + '[limits]\ntime_s = 0\n"a" = 1\n'
    )
    assert main(["sweep", str(tmp_path / "bad.toml"), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "study.count" in said
    assert "limits.time_s" in said
    assert not (tmp_path / "out").exists()
    assert main(["sweep", str(tmp_path / "absent.toml"), "--out", str(tmp_path / "out")]) == 2


def test_workers_and_scheduler_exclude_each_other(tmp_path, capsys):
    options = ["--out", str(tmp_path), "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"]
    for order in (options, options[:2] + options[4:] + options[2:4]):
        assert main(["sweep", "fingers", *order]) == 2
        assert "give one" in capsys.readouterr().err


def test_what_is_in_the_way_is_refused_before_any_work(tmp_path, capsys):
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "thesis.tex").touch()
    assert main(["sweep", str(tmp_path / "study.toml"), "--out", str(tmp_path)]) == 2
    assert "thesis.tex" in capsys.readouterr().err


def test_no_finger_at_all_is_a_failure_with_a_report(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path / "cache"))
    (tmp_path / "study.toml").write_text(STUDY)
    assert main(["sweep", str(tmp_path / "study.toml"), "--out", str(tmp_path)]) == 1
    said = capsys.readouterr().out
    assert "failed: 2 invalid; causes in" in said
    assert (tmp_path / "none" / "report.html").exists()
    assert main(["sweep", str(tmp_path / "study.toml"), "--out", str(tmp_path), "--quiet"]) == 1
    quiet = capsys.readouterr()
    assert not quiet.out
    causes = tmp_path / "none" / "failures.csv"
    assert quiet.err.splitlines() == [f"2 of 2 failed: causes in {causes}"]
    assert main(["sweep", str(tmp_path / "study.toml"), "--out", str(tmp_path), "--json"]) == 1
    *lines, last = map(json.loads, capsys.readouterr().out.splitlines())
    assert [(each["done"], each["number"]) for each in lines] == [(1, 1), (2, 2)]
    assert last["failures"] == 2


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, "3 of 8"),
        ({"failures": 1, "left": 200.0}, "3 of 8, 1 failed, 3 min left"),
        ({"waiting": True, "left": 5.0}, "3 of 8, waiting for workers"),
        ({"number": 8, "left": 0.0}, "8 of 8"),
    ],
)
def test_progress_in_words(changes, said):
    from fingerdesign.search.run.run import Standing

    standing = {
        "number": 3,
        "of": 8,
        "failures": 0,
        "stored": 0,
        "computed": 3,
        "seconds": 1.0,
    }
    assert words(Standing(**(standing | changes))) == said


def test_plain_lines_are_few(monkeypatch, capsys):
    from fingerdesign.search.run.run import Standing

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
    from fingerdesign.search.run.run import Standing

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
