"""Calls in other processes: their answers, their limits, their ends, and of all they started."""

import os
import pickle
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import psutil
import pytest

from fingerdesign.errors import DesignError, GeometryError
from fingerdesign.runtime.child import PARENT
from fingerdesign.runtime.isolate import ProcessError, Worker, call, concurrently
from tests.support import calls


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


def pid_of(worker):
    return worker.call(calls.who, time_s=20.0)[0]


def numbers(path):
    return [int(each) for each in path.read_text().split()]


def written(path):
    end = time.monotonic() + 20.0
    while not (path.exists() and path.read_text()):
        assert time.monotonic() < end
        time.sleep(0.02)
    return path


# A fresh process.


def test_arrays_go_in_and_out_whatever_their_size(tmp_path):
    for size in (3, 200_000):
        found = call(calls.double, np.arange(size), time_s=20.0)
        np.testing.assert_array_equal(found, 2 * np.arange(size))
    assert call("tests.support.calls:added", 1, 2, time_s=20.0) == 3
    assert call(calls.who, time_s=20.0)[0] != os.getpid()
    assert call("os:getcwd", time_s=20.0, folder=tmp_path) == str(tmp_path)
    with pytest.raises(ValueError, match="cannot be imported"):
        call(lambda: None, time_s=20.0)


def test_errors_of_this_package_come_back_as_they_are():
    with pytest.raises(DesignError, match=r"must be at most 0\.5; lower it") as caught:
        call(calls.refuse, "design", time_s=20.0)
    assert [fault.key for fault in caught.value.faults] == ["a.key"]
    with pytest.raises(GeometryError, match="face 7 is an undercut"):
        call(calls.refuse, "geometry", time_s=20.0)


@pytest.mark.parametrize(
    ("function", "given", "words", "machine", "by_others"),
    [
        (calls.refuse, ("value",), r"^it failed: ValueError: a reason$", False, False),
        (calls.refuse, ("disk",), "Error: a reason", True, False),
        (calls.refuse, ("memory",), "Error: a reason", True, False),
        (calls.unsent, (), "its answer cannot be sent", False, False),
        ("fingerdesign.no_such:thing", (), r"failed: ModuleNotFoundError.*no_such", False, False),
        ("tests.support.calls:nothing", (), "no attribute 'nothing'", False, False),
        (calls.end, (11,), "ended by SIGSEGV: on the way", False, False),
        (calls.end, (9,), "ended by SIGKILL", True, True),
        (calls.end, (-3,), "ended with code 3: on the way", False, False),
    ],
)
def test_how_it_failed_or_ended_is_a_sentence(function, given, words, machine, by_others):
    with pytest.raises(ProcessError, match=words) as caught:
        call(function, *given, time_s=20.0)
    for error in (caught.value, pickle.loads(pickle.dumps(caught.value))):
        assert str(error) == str(caught.value)
        assert (error.kind, error.machine, error.ended_by_others) == ("crashed", machine, by_others)


@pytest.mark.slow
def test_its_time_and_its_family(tmp_path):
    with pytest.raises(ProcessError, match=r"did not finish in 2 s") as caught:
        call(calls.hang, str(tmp_path / "pids"), time_s=2.0)
    assert caught.value.kind == "timeout"
    assert gone(numbers(tmp_path / "pids"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("function", "time_s", "memory_MB", "kind"),
    [
        (calls.eat, 60.0, 200.0, "memory"),
        (calls.endless, 1.0, 100_000.0, "timeout"),
        (calls.endless, 120.0, 150.0, "memory"),
    ],
)
def test_one_that_takes_or_writes_without_end_is_held_to_its_limits(
    function, time_s, memory_MB, kind
):
    with pytest.raises(ProcessError) as caught:
        call(function, time_s=time_s, memory_MB=memory_MB)
    assert caught.value.kind == kind


# Next to other work.


def test_a_job_answers_next_to_the_callers_work_or_is_left_and_ends(tmp_path):
    with concurrently(calls.double, np.ones(300_000), time_s=20.0) as wait:
        assert wait().sum() == 600_000.0
    with concurrently(calls.hang, str(tmp_path / "pids"), time_s=60.0):
        found = numbers(written(tmp_path / "pids"))
    assert gone(found)
    late = pytest.raises(ProcessError, match=r"did not finish in 0\.2 s")
    with concurrently(calls.sleep, 60.0, time_s=0.2) as wait, late:
        wait()


# A warm one.


@pytest.mark.slow
def test_it_loads_ahead_and_once_and_in_its_own_time_if_it_has_one():
    with Worker(load=calls.load) as worker:
        worker.start()
        assert worker.alive
        assert worker.call(calls.loaded_in, time_s=20.0) == worker.pid
    with Worker(load=calls.load_slowly, ready_s=20.0) as worker:
        assert worker.call(calls.added, 1, time_s=0.9) == 1
    with (
        Worker(load=calls.load_slowly) as worker,
        pytest.raises(ProcessError, match="did not finish"),
    ):
        worker.call(calls.added, 1, time_s=0.9)


def test_what_is_shared_is_given_to_every_process_and_prints_are_no_answers():
    with Worker(shared=(1, 2), recycled_after=1) as worker:
        assert [worker.call(calls.added, each, time_s=20.0) for each in (3, 4)] == [6, 7]
    with Worker(threads=1) as worker:
        assert worker.call(calls.who, time_s=20.0)[1] == "1"


def test_another_thread_ends_it(tmp_path):
    worker, failures = Worker(), []

    def run():
        with pytest.raises(ProcessError) as caught:
            worker.call(calls.hang, str(tmp_path / "pids"), time_s=60.0)
        failures.append(caught.value)

    thread = threading.Thread(target=run)
    thread.start()
    found = numbers(written(tmp_path / "pids"))
    worker.kill()
    thread.join(10.0)
    assert [each.kind for each in failures] == ["crashed"]
    assert gone(found)
    with pytest.raises(ProcessError, match="requested to end"):
        worker.call(calls.who, time_s=20.0)


@pytest.mark.slow
def test_one_that_is_idle_or_that_nobody_holds_ends():
    with Worker(idle_s=0.2) as worker:
        number = pid_of(worker)
        assert gone([number])
        assert pid_of(worker) != number
    worker = Worker()
    number = pid_of(worker)
    del worker
    assert gone([number])


def python(code, **variables):
    path = os.pathsep.join([str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"PYTHONPATH": path} | variables
    command = [sys.executable, "-c", code]
    return subprocess.run(command, env=environment, capture_output=True, check=False)


def test_a_killed_parent_leaves_nobody():
    done = python(
        "import os, signal\n"
        "from fingerdesign.runtime.isolate import Worker\n"
        "from tests.support import calls\n"
        "worker = Worker()\n"
        "worker.call(calls.who, time_s=20.0)\n"
        "print(worker.pid, flush=True)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    assert gone([int(done.stdout)])


def test_one_whose_parent_has_gone_ends_at_once_and_importing_it_is_light():
    code = "from fingerdesign.runtime.child import die_with_parent; die_with_parent()"
    for parent, expected in ((str(os.getpid()), 0), ("1", 1)):
        assert python(code, **{PARENT: parent}).returncode == expected
    light = "import sys, fingerdesign.runtime.isolate; sys.exit('numpy' in sys.modules)"
    assert python(light).returncode == 0


def test_a_process_is_reused_after_refusals_recycled_and_replaced_after_failures():
    with Worker(recycled_after=3) as worker:
        first = pid_of(worker)
        with pytest.raises(GeometryError):
            worker.call(calls.refuse, "geometry", time_s=20.0)
        second, third = pid_of(worker), pid_of(worker)
        assert first == second != third
        assert gone([first])
        os.kill(third, 9)  # while it has nothing to do
        assert gone([third])
        fourth = pid_of(worker)
        assert fourth != third
        with pytest.raises(ProcessError):
            worker.call(calls.refuse, "value", time_s=20.0)
        assert not worker.alive
        assert pid_of(worker) != fourth
    assert gone([fourth])
