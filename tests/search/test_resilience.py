"""What dies mid-study loses nothing: real processes, real signals, a real scheduler on loopback.

Each study is disturbed, run again, and held to the outcomes of an undisturbed run.
"""

import contextlib
import json
import os
import resource
import signal
import socket
import socketserver
import struct
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

import psutil
import pytest

from fingerdesign.runtime.isolate import Worker

STUDY = """
[study]
name = "many"
base = "maeno2000"
sampling = "latin_hypercube"
count = {count}
seed = 7
[parameters]
"body.base_height_mm" = {{ low = 5.0, high = 10.0 }}
[limits]
time_s = {time_s}
memory_MB = 500
"""
SEARCH = """
study = { name = "search", base = "maeno2000", count = 8, seed = 5 }
objectives = [{ metric = "stick_error" }, { metric = "peak_force_N" }]
optimise = { trials = 22, confirm = 1 }
[parameters]
"body.arc_radius_mm" = { low = 30.0, high = 90.0 }
"plates.length_mm" = { low = 0.6, high = 1.0 }
"""
PATIENCE_S = 90.0
COMMAND = str(Path(__file__).parents[1] / "support" / "command_with.py")


@pytest.fixture
def place(tmp_path):
    """A folder with a study, and the environment in which it is run."""
    root = Path(__file__).parents[2]
    paths = [str(root), str(root / "cli"), str(Path(__file__).parents[1] / "support")]
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(paths),
        "FINGERDESIGN_CACHE": str(tmp_path / "cache"),
        "EVALUATED": str(tmp_path / "evaluated"),
        "EVALUATOR_SECONDS": "0.1",
        "OPENBLAS_NUM_THREADS": "1",
    }
    made = Place(tmp_path, environment)
    yield made
    for process in made.started:
        process.kill()
        process.communicate()


class Place:
    """Starts and ends processes; what it started and still runs ends with the test."""

    def __init__(self, folder, environment):
        self.folder, self.environment = folder, environment
        self.store = folder / "cache" / "outcomes"
        self.evaluator = "slow"
        self.started = []

    def study(self, count=24, time_s=20.0):
        (self.folder / "many.toml").write_text(STUDY.format(count=count, time_s=time_s))

    def sweep(self, *more, out="out", **changes):
        """Start `fingerdesign sweep` with the place's evaluator."""
        study = ["sweep", "many.toml", "--out", out, "--json", *more]
        return self.start(COMMAND, f"sweep_evaluators:{self.evaluator}", *study, **changes)

    def optimise(self, out, seconds=0.0, confirming_s=0.0):
        """Start `fingerdesign optimise` with a store of its own."""
        (self.folder / "search.toml").write_text(SEARCH)
        study = ["search.toml", "--out", out, "--workers", "2", "--json"]
        changes = {
            "FINGERDESIGN_CACHE": str(self.folder / f"cache-{out}"),
            "EVALUATED": str(self.folder / f"evaluated-{out}"),
            "EVALUATOR_SECONDS": str(seconds),
            "EVALUATOR_3D_SECONDS": str(confirming_s),
        }
        return self.start(COMMAND, "optimise_evaluators:formula", "optimise", *study, **changes)

    def start(self, *command, limit=None, **changes):
        process = subprocess.Popen(
            [sys.executable, *command],
            cwd=self.folder,
            env=self.environment | changes,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=limit or None,
        )
        self.started.append(process)
        return process

    def done(self, out=""):
        """Names evaluated so far."""
        evaluated = self.folder / (f"evaluated-{out}" if out else "evaluated")
        return evaluated.read_text().split() if evaluated.exists() else []

    def wait_for(self, count, process):
        """Until so many outcomes are in the store."""
        until(lambda: len(list(self.store.glob("??/[!.]*.txt"))) >= count, process)

    def outcomes(self, out="out"):
        return (self.folder / out / "many" / "outcomes.jsonl").read_text()

    def swept(self, *more, **changes):
        """What a run says that goes well."""
        code, lines, err = ended(self.sweep("--workers", "2", *more, **changes))
        assert code == 0, err
        return lines

    def undisturbed(self):
        """The outcomes of a run with a store of its own."""
        cache = str(self.folder / "other")
        changes = {"FINGERDESIGN_CACHE": cache, "EVALUATED": "", "EVALUATOR_SECONDS": "0"}
        self.swept(out="other", **changes)
        return self.outcomes("other")


def until(reached, process):
    """Wait for what a process that lives on is to reach."""
    end = time.monotonic() + PATIENCE_S
    while not reached():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)


def ended(process):
    """Exit code, JSON lines and what was said on stderr."""
    out, err = process.communicate(timeout=PATIENCE_S)
    return process.returncode, [json.loads(each) for each in out.splitlines()], err


def family(process):
    return psutil.Process(process.pid).children(recursive=True)


def gone(processes, patience_s=10.0):
    _, alive = psutil.wait_procs(processes, patience_s)
    return not alive


@contextlib.contextmanager
def dask(place, workers=2):
    """A scheduler and workers of one thread each, real processes on loopback; its address."""
    where = place.folder / "scheduler.json"
    where.unlink(missing_ok=True)
    address = ["--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(where)]
    module, quiet = ["-m", "distributed.cli.dask_scheduler"], "--no-dashboard"
    scheduler = place.start(*module, *address, quiet)
    until(where.exists, scheduler)
    at = json.loads(where.read_text())["address"]
    join = ["distributed.cli.dask_worker", at, "--nthreads", "1", "--no-nanny", quiet]
    joined = [place.start("-m", *join) for _ in range(workers)]
    yield at, scheduler, joined
    for process in (scheduler, *joined):
        process.kill()
        process.communicate()


@pytest.mark.usefixtures("interruptible")
@pytest.mark.slow
def test_a_killed_and_an_interrupted_driver_go_on_where_they_stopped(place):
    place.study(count=40)
    kept = 4
    for sign in (signal.SIGKILL, signal.SIGINT):
        run = place.sweep("--workers", "2")
        place.wait_for(kept + 2, run)
        children = family(run)
        begun = time.monotonic()
        run.send_signal(sign)
        _, err = run.communicate(timeout=PATIENCE_S)
        assert children
        assert gone(children)
        assert not (place.folder / "out" / "many").exists()
        kept = len(list(place.store.glob("??/[!.]*.txt")))
    assert run.returncode == 130
    assert err.strip() == "interrupted; finished work is kept"
    assert time.monotonic() - begun < 10.0
    assert kept >= 8
    assert place.swept()[-1]["from_store"] == kept
    assert place.outcomes() == place.undisturbed()
    times = Counter(place.done())
    assert len(times) == 40
    assert sum(times.values()) <= len(times) + 8  # what ran, or was on its way, at either end
    assert place.swept()[-1]["computed"] == 0


@pytest.mark.slow
def test_a_killed_search_ends_as_one_that_was_not(place):
    code, lines, err = ended(place.optimise("whole"))
    assert code == 0, err
    assert lines[-1]["trials"] == 22
    process = place.optimise("killed", 0.15)
    until(lambda: len(place.done("killed")) >= 11, process)
    process.kill()
    process.communicate()
    code, lines, err = ended(place.optimise("killed"))
    assert code == 0, err
    undisturbed, resumed = (
        sorted(
            str((found["name"], found["values"], found["metrics"]))
            for found in map(json.loads, (each / "outcomes.jsonl").read_text().splitlines())
        )
        for each in (place.folder / "whole" / "search", place.folder / "killed" / "search")
    )
    assert resumed == undisturbed
    # What two workers ran, or had just done, when it was killed ran again, and no more than that.
    assert len(place.done("killed")) <= 22 + 3 + 4
    assert lines[-1]["trials"] == 22
    assert lines[-1]["confirmations"]
    page = (place.folder / "whole" / "search" / "report.html").read_text()
    for part in ("reference-maeno2000", 'id="table-sensitivity"', 'id="table-confirmed"'):
        assert part in page
    assert (place.folder / "whole" / "search" / "front.png").stat().st_size > 10_000


def test_a_second_search_is_refused_during_confirmation_too(place):
    first = place.optimise("out", confirming_s=PATIENCE_S)
    until(lambda: any("reference-maeno2000" in each for each in place.done("out")), first)
    code, _, err = ended(place.optimise("out"))
    assert code == 1
    assert "is being written by another process" in err
    assert first.poll() is None  # it is at its 3-D analyses


def limited():
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))


@pytest.mark.slow
def test_a_full_disk_says_so_and_keeps_what_fitted(place):
    """Full is a file's size by a limit."""
    place.study(count=20)
    place.evaluator = "large"
    code, _, err = ended(place.sweep("--workers", "1", limit=limited))
    assert code == 1
    assert "cannot be kept" in err
    assert "File too large" in err
    files = [path for path in place.store.rglob("*") if path.is_file()]
    assert files
    assert all(path.suffix == ".txt" for path in files)  # nothing half
    lines = place.swept()
    assert lines[-1]["from_store"] == len(files)
    assert place.outcomes() == place.undisturbed()


@pytest.mark.slow
def test_a_tenth_crashes_hangs_or_eats_memory(place):
    place.study(count=30, time_s=2.0)
    place.evaluator = "tenth"
    lines = place.swept()
    place.evaluator = "slow"
    assert lines[-1]["failures_by_kind"] == {"crashed": 1, "memory": 1, "timeout": 1}
    causes = (place.folder / "out" / "many" / "failures.csv").read_text()
    page = (place.folder / "out" / "many" / "report.html").read_text()
    for said in ("SIGABRT", "not done after 2 s", "more than 500 MB"):
        assert said in causes
        assert said in page
    lines = place.swept()
    assert lines[-1]["computed"] == 0  # failures are outcomes, too
    lines = place.swept("--retry")
    assert (lines[-1]["computed"], lines[-1]["failures"]) == (3, 0)
    assert place.outcomes() == place.undisturbed()


@pytest.mark.slow
def test_a_killed_worker_is_replaced_by_others(place):
    place.study()
    with dask(place) as (address, _, workers):
        run = place.sweep("--scheduler", address)
        place.wait_for(6, run)
        children = family(workers[0])
        workers[0].kill()
        assert children
        assert gone(children)
        code, lines, err = ended(run)
    assert (code, lines[-1]["failures"]) == (0, 0)
    assert "Traceback" not in err
    assert place.outcomes() == place.undisturbed()


@pytest.mark.slow
def test_a_killed_scheduler_ends_the_driver_and_loses_nothing(place):
    place.study()
    with dask(place) as (address, scheduler, _):
        run = place.sweep("--scheduler", address)
        place.wait_for(6, run)
        scheduler.kill()
        code, _, err = ended(run)
    assert code == 1
    assert f"Dask scheduler at {address} is gone; what was done is kept" in err
    with dask(place):
        code, lines, _ = ended(place.sweep("--scheduler", "scheduler.json"))
    assert code == 0
    assert lines[-1]["from_store"] >= 6
    assert place.outcomes() == place.undisturbed()


@pytest.mark.slow
def test_a_finger_that_kills_every_worker_is_one_failure(place):
    place.study(count=12)
    place.environment |= {
        "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1",
        "DASK_DISTRIBUTED__SCHEDULER__WORKER_SATURATION": "1.0",
    }
    place.evaluator = "deadly"
    with dask(place, workers=3) as (address, _, _):
        code, lines, _ = ended(place.sweep("--scheduler", address))
    assert (code, lines[-1]["failures_by_kind"]) == (0, {"crashed": 1})
    (bad,) = [each for each in lines if each.get("failure")]
    assert bad["name"] == "many-0005"
    assert bad["failure"]["cause"] == "the workers that had it died, 2 in turn"


@contextlib.contextmanager
def anything(said):
    """What is no scheduler: it says its bytes to whoever comes, and goes away; its address."""

    class Says(socketserver.BaseRequestHandler):
        def handle(self):
            with contextlib.suppress(OSError):
                self.request.sendall(said)
                self.request.shutdown(socket.SHUT_WR)
                self.request.settimeout(1.0)
                self.request.recv(1000)

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Says) as server:
        server.daemon_threads = True
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"tcp://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


def test_no_scheduler_is_an_error(place):
    place.study(count=2)

    def said(address):
        arguments = ("sweep", "many.toml", "--out", "out", "--json", "--scheduler", address)
        found = worker.call("tests.support.calls:command", arguments, time_s=PATIENCE_S)
        assert len(found[1].splitlines()) == 1, found[1]
        return found

    with Worker(folder=place.folder) as worker:
        code, written = said("tcp://127.0.0.1:1")
        assert code == 1
        assert written.startswith("failed: no Dask scheduler answers at tcp://127.0.0.1:1: ")
        for answer in (b"", b"HTTP/1.0 400 Bad\r\n\r\n", struct.pack("<Q", 2) + b"\xff\xff"):
            with anything(answer) as address:
                code, written = said(address)
            assert code == 1
            assert "Dask scheduler" in written
        (place.folder / "scheduler.json").write_text("{")
        for wrong, bound in (
            ("nonsense://x", "an address"),
            ("scheduler.json", "a file that a Dask scheduler"),
        ):
            code, written = said(wrong)
            assert code == 2
            assert written.startswith(f"--scheduler = {wrong}: must be {bound}")
