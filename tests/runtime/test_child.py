"""An evaluating process: kept, recycled, replaced; what it has started ends with it."""

import json
import os
import sys
import threading
import time
from pathlib import Path

import psutil
import pytest

from fingerdesign.runtime.child import Child, ChildFailed

ROOM_MB = 1000.0


@pytest.fixture(autouse=True)
def evaluators(monkeypatch):
    path = os.pathsep.join(
        [str(Path(__file__).parents[1] / "support"), os.environ.get("PYTHONPATH", "")]
    )
    monkeypatch.setenv("PYTHONPATH", path)


def pid_of(child):
    return json.loads(child.run({}, 20.0, ROOM_MB))["pid"]


def runs(number):
    try:
        return psutil.Process(number).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def gone(numbers, patience_s=10.0):
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        if not any(runs(each) for each in numbers):
            return True
        time.sleep(0.05)
    return False


def test_a_process_is_kept_recycled_and_replaced():
    with Child("sweep_evaluators:who", recycled_after=2) as child:
        first, second, third = (pid_of(child) for _ in range(3))
        assert first == second != third
        assert gone([first])
        os.kill(third, 9)  # while it has nothing to do
        assert gone([third])
        fourth = pid_of(child)
        assert fourth != third
    assert gone([fourth])


def test_one_thread_each_and_prints_are_no_answers():
    with Child("sweep_evaluators:who") as child:
        assert json.loads(child.run({}, 20.0, ROOM_MB))["threads"] == "1"


def test_a_hanging_job_ends_with_all_that_it_has_started(tmp_path):
    with Child("sweep_evaluators:who") as child:
        with pytest.raises(ChildFailed, match=r"not done after 0\.5 s") as caught:
            child.run({"hang": str(tmp_path / "pids")}, 0.5, ROOM_MB)
        assert caught.value.kind == "timeout"
        assert gone([int(each) for each in (tmp_path / "pids").read_text().split()])
        assert pid_of(child)


def test_another_thread_ends_it(tmp_path):
    child, failures = Child("sweep_evaluators:who"), []

    def run():
        with pytest.raises(ChildFailed) as caught:
            child.run({"hang": str(tmp_path / "pids")}, 60.0, ROOM_MB)
        failures.append(caught.value)

    thread = threading.Thread(target=run)
    thread.start()
    while not (tmp_path / "pids").exists() or not (tmp_path / "pids").read_text():
        time.sleep(0.02)
    child.kill()
    thread.join(10.0)
    assert [each.kind for each in failures] == ["crashed"]
    assert gone([int(each) for each in (tmp_path / "pids").read_text().split()])
    with pytest.raises(ChildFailed, match="told to end"):
        child.run({}, 20.0, ROOM_MB)


def test_an_evaluator_that_is_none_is_a_crash_with_its_cause():
    with (
        Child("sweep_evaluators:nothing") as child,
        pytest.raises(ChildFailed, match="no attribute 'nothing'"),
    ):
        child.run({}, 20.0, ROOM_MB)


def test_an_idle_process_ends():
    code = (
        "import fingerdesign.search.run.child_worker as w; w.IDLE_S = 0.2; w.main(['json:dumps'])"
    )
    process = psutil.Popen(
        [sys.executable, "-c", code], stdin=-1, stdout=-1, start_new_session=True
    )
    assert b"ready" in process.stdout.readline()
    assert process.wait(10.0) == -9
    process.stdin.close()
    process.stdout.close()


def test_one_that_writes_without_end_is_held_to_its_time_and_memory():
    with Child("sweep_evaluators:endless") as child:
        with pytest.raises(ChildFailed) as caught:
            child.run({}, 1.0, 100_000.0)
        assert caught.value.kind == "timeout"
        with pytest.raises(ChildFailed) as caught:
            child.run({}, 20.0, 150.0)
        assert caught.value.kind == "memory"
