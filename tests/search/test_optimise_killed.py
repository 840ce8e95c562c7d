"""The command killed in the midst of its work, with real processes, and its folder."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest

STUDY = """
[study]
name = "search"
base = "maeno2000"
count = 8
seed = 5
[parameters]
"body.arc_radius_mm" = { low = 30.0, high = 90.0 }
"plates.length_mm" = { low = 0.6, high = 1.0 }
[[objectives]]
metric = "stick_error"
[[objectives]]
metric = "peak_force_N"
[optimise]
trials = 22
confirm = 1
"""
PATIENCE_S = 90.0


@pytest.fixture
def command(tmp_path):
    """Starts `optimise` into a folder; each has its own store."""
    root, running = Path(__file__).parents[2], []
    paths = [str(root), str(root / "cli"), str(Path(__file__).parents[1] / "support")]
    command_with = str(Path(__file__).parents[1] / "support" / "command_with.py")
    (tmp_path / "search.toml").write_text(STUDY)

    def start(name, seconds, confirming_s=0):
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(paths),
            "FINGERDESIGN_CACHE": str(tmp_path / f"cache-{name}"),
            "EVALUATED": str(tmp_path / f"evaluated-{name}"),
            "EVALUATOR_SECONDS": str(seconds),
            "EVALUATOR_3D_SECONDS": str(confirming_s),
            "OPENBLAS_NUM_THREADS": "1",
        }
        line = ["optimise", "search.toml", "--out", name, "--workers", "2", "--json"]
        process = subprocess.Popen(
            [sys.executable, command_with, "optimise_evaluators:formula", *line],
            cwd=tmp_path,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        running.append(process)
        return process

    yield start
    for process in running:
        process.kill()
        process.communicate()


def trials_of(folder):
    """Names, values and metrics of what was searched, by the folder's own record."""
    lines = (folder / "outcomes.jsonl").read_text().splitlines()
    found = [json.loads(line) for line in lines]
    return sorted((each["name"], str(each["values"]), str(each["metrics"])) for each in found)


def test_killed_and_run_again_it_ends_as_one_that_was_not(tmp_path, command):
    whole = command("whole", 0)
    reported, said = whole.communicate(timeout=PATIENCE_S)
    assert whole.returncode == 0, said
    process, evaluated = command("killed", 0.15), tmp_path / "evaluated-killed"
    end = time.monotonic() + PATIENCE_S
    while not evaluated.exists() or len(evaluated.read_text().splitlines()) < 11:
        assert time.monotonic() < end
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    again = command("killed", 0)
    _, said = again.communicate(timeout=PATIENCE_S)
    assert again.returncode == 0, said
    assert trials_of(tmp_path / "killed/search") == trials_of(tmp_path / "whole/search")
    counted = Counter((tmp_path / "evaluated-killed").read_text().splitlines())
    # What two workers ran, or had just done, when it was killed ran again, and no more than that.
    assert sum(counted.values()) <= 22 + 3 + 4
    record = json.loads((tmp_path / "killed/search/study.json").read_text())["optimise"]
    assert record["trials"] == 22
    assert [each["trial"] for each in record["confirmations"]]
    last = json.loads(reported.splitlines()[-1])
    assert last["trials"] == 22
    page = (tmp_path / "whole/search/report.html").read_text()
    assert "reference-maeno2000" in page
    assert 'id="table-sensitivity"' in page
    assert 'id="table-confirmed"' in page
    assert (tmp_path / "whole/search/front.png").stat().st_size > 10_000


def test_a_second_one_is_refused_during_confirmation_too(tmp_path, command):
    first, evaluated = command("out", 0, confirming_s=PATIENCE_S), tmp_path / "evaluated-out"
    end = time.monotonic() + PATIENCE_S
    while not evaluated.exists() or "reference-maeno2000" not in evaluated.read_text():
        assert time.monotonic() < end
        assert first.poll() is None
        time.sleep(0.05)
    second = command("out", 0)
    _, said = second.communicate(timeout=PATIENCE_S)
    assert second.returncode == 1
    assert "is being written by another process" in said
    assert first.poll() is None  # it is at its 3-D analyses
