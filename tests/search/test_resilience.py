"""What dies mid-study loses nothing: real processes, real signals, a real scheduler on loopback.

Each study is disturbed, run again, and held to the outcomes of an undisturbed run.
"""

import contextlib
import json
import os
import shutil
import signal
import socket
import socketserver
import struct
import subprocess
import threading
import time
from collections import Counter
from pathlib import Path

import psutil
import pytest

from fingerdesign.runtime.isolate import Worker
from tests.support.forked import Program

STUDY = """
[study]
name = "many"
base = "homogeneous"
sampling = "latin_hypercube"
count = 20
seed = 7
[parameters]
"body.base_height_mm" = { low = 5.0, high = 10.0 }
[limits]
time_s = 20.0
memory_MB = 500
"""
SEARCH = """
study = { name = "search", base = "maeno2000", count = 8, seed = 5 }
objectives = [{ metric = "stick_error" }, { metric = "peak_force_N" }]
optimise = { trials = 20, confirm = 1 }
[parameters]
"body.arc_radius_mm" = { low = 30.0, high = 90.0 }
"plates.length_mm" = { low = 0.6, high = 1.0 }
"""
PATIENCE_S = 90.0
ROOT = Path(__file__).parents[2]
SUPPORT = ROOT / "tests" / "support"


@pytest.fixture
def place(tmp_path):
    with contextlib.closing(Place(tmp_path)) as made:
        yield made


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The outcomes of the study that nothing disturbed."""
    with contextlib.closing(Place(tmp_path_factory.mktemp("undisturbed"))) as made:
        made.swept(EVALUATOR_SECONDS="0")
        return made.outcomes()


class Place:
    """A folder with a study. It starts processes; those that still run end when it is closed."""

    def __init__(self, folder):
        self.folder, self.store = folder, folder / "cache" / "outcomes"
        self.evaluator, self.started = "slow", []
        paths = map(str, (ROOT, ROOT / "cli", SUPPORT))
        self.environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(paths),
            "FINGERDESIGN_CACHE": str(folder / "cache"),
            "EVALUATED": str(folder / "evaluated"),
            "EVALUATOR_SECONDS": "0.1",
            "OPENBLAS_NUM_THREADS": "1",
        }
        (folder / "many.toml").write_text(STUDY)

    def close(self):
        for process in self.started:
            process.kill()
            process.communicate()

    def command(self, evaluator, *arguments, **changes):
        """Start a command with an evaluator of tests/support."""
        return self.start(SUPPORT / "command_with.py", evaluator, *arguments, "--json", **changes)

    def sweep(self, *more, **changes):
        study = ["sweep", "many.toml", "--out", "out", *more]
        return self.command(f"evaluators:{self.evaluator}", *study, **changes)

    def optimise(self, out, seconds=0.0, confirmed_after="search.toml"):
        """Start `fingerdesign optimise` with a store of its own; 3-D analyses await a file."""
        (self.folder / "search.toml").write_text(SEARCH)
        changes = {
            "FINGERDESIGN_CACHE": str(self.folder / f"cache-{out}"),
            "EVALUATED": str(self.folder / f"evaluated-{out}"),
            "EVALUATOR_SECONDS": str(seconds),
            "EVALUATOR_3D_AFTER": str(self.folder / confirmed_after),
        }
        study = ["optimise", "search.toml", "--out", out, "--workers", "2"]
        return self.command("evaluators:formula", *study, **changes)

    def start(self, *command, most_bytes=None, **changes):
        process = Program(command, self.folder, self.environment | changes, most_bytes)
        self.started.append(process)
        return process

    def done(self, out=""):
        """Names evaluated so far."""
        evaluated = self.folder / (f"evaluated-{out}" if out else "evaluated")
        return evaluated.read_text().split() if evaluated.exists() else []

    def stored(self):
        """Outcomes in the store."""
        return len(list(self.store.glob("??/[!.]*.txt")))

    def wait_for(self, count, process):
        """Until so many outcomes are in the store."""
        until(lambda: self.stored() >= count, process)

    def outcomes(self):
        return (self.folder / "out" / "many" / "outcomes.jsonl").read_text()

    def swept(self, *more, **changes):
        """What a run says that goes well."""
        return well(self.sweep("--workers", "1", *more, **changes))


def until(reached, process):
    """Wait for what a process that lives on is to reach."""
    end = time.monotonic() + PATIENCE_S
    while not reached():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)


def ended(process):
    """Exit code, JSON lines and what was stated on stderr."""
    out, err = process.communicate(timeout=PATIENCE_S)
    return process.returncode, [json.loads(each) for each in out.splitlines()], err


def well(process):
    """The JSON lines of a process that ends well."""
    code, lines, err = ended(process)
    assert code == 0, err
    return lines


def family(process):
    return psutil.Process(process.pid).children(recursive=True)


def gone(processes, patience_s=10.0):
    _, alive = psutil.wait_procs(processes, patience_s)
    return processes and not alive


@contextlib.contextmanager
def dask(place, workers=2, protocol="tcp"):
    """A scheduler and workers of one thread each, real processes on loopback; its address."""
    where = place.folder / "scheduler.json"
    where.unlink(missing_ok=True)
    address = ["--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(where)]
    address += ["--protocol", protocol]
    module, quiet = ["-m", "distributed.cli.dask_scheduler"], "--no-dashboard"
    scheduler = place.start(*module, *address, quiet)
    until(lambda: where.exists() and where.read_text().endswith("}"), scheduler)  # whole, that is
    at = json.loads(where.read_text())["address"]
    join = ["distributed.cli.dask_worker", at, "--nthreads", "1", "--no-nanny", quiet]
    joined = [place.start("-m", *join) for _ in range(workers)]
    yield at, scheduler, joined
    for process in (scheduler, *joined):
        process.kill()
        process.communicate()


@pytest.mark.usefixtures("interruptible")
@pytest.mark.slow
def test_a_killed_and_an_interrupted_driver_go_on_where_they_stopped(place, undisturbed):
    stored = 4
    for sign in (signal.SIGKILL, signal.SIGINT):
        run = place.sweep("--workers", "2")
        place.wait_for(stored + 2, run)
        children = family(run)
        begun = time.monotonic()
        run.send_signal(sign)
        _, err = run.communicate(timeout=PATIENCE_S)
        assert gone(children)
        assert not (place.folder / "out" / "many").exists()
        stored = place.stored()
    assert run.returncode == 130
    assert err.strip() == "interrupted; finished work is stored: run the same command to go on"
    assert time.monotonic() - begun < 10.0
    assert stored >= 8
    assert place.swept()[-1]["from_store"] == stored
    assert place.outcomes() == undisturbed
    times = Counter(place.done())
    assert len(times) == 20
    assert sum(times.values()) <= len(times) + 8  # what ran, or was on its way, at either end


@pytest.mark.slow
def test_a_killed_search_ends_as_one_that_was_not_and_refused_a_second(place):
    """The second one comes while the first confirms in 3-D."""
    whole = place.optimise("whole", confirmed_after="come.txt")
    until(lambda: any("reference-maeno2000" in each for each in place.done("whole")), whole)
    code, _, err = ended(place.optimise("whole"))
    assert code == 1
    assert "is being written by another process" in err
    assert whole.poll() is None
    (place.folder / "come.txt").touch()
    assert well(whole)[-1]["trials"] == 20
    process = place.optimise("killed", 0.15)
    until(lambda: len(place.done("killed")) >= 10, process)
    process.kill()
    process.communicate()
    lines = well(place.optimise("killed"))
    undisturbed, resumed = (
        sorted(
            str((found["name"], found["values"], found["metrics"]))
            for found in map(json.loads, (each / "outcomes.jsonl").read_text().splitlines())
        )
        for each in (place.folder / "whole" / "search", place.folder / "killed" / "search")
    )
    assert resumed == undisturbed
    # What two workers ran, or had just done, when it was killed ran again, and no more than that.
    assert len(place.done("killed")) <= 20 + 3 + 4
    assert lines[-1]["trials"] == 20
    assert lines[-1]["confirmations"]
    page = (place.folder / "whole" / "search" / "report.html").read_text()
    for part in ("reference-maeno2000", 'id="table-sensitivity"', 'id="table-confirmed"'):
        assert part in page
    assert (place.folder / "whole" / "search" / "front.png").stat().st_size > 10_000


@pytest.mark.slow
def test_a_full_disk_says_so_and_keeps_what_fitted(place, undisturbed):
    """Full is a file's size by a limit."""
    place.evaluator = "large"
    code, _, err = ended(place.sweep("--workers", "1", most_bytes=100_000))
    assert code == 1
    assert "cannot be stored" in err
    assert "File too large" in err
    files = [path for path in place.store.rglob("*") if path.is_file()]
    assert files
    assert all(path.suffix == ".txt" for path in files)  # nothing half
    place.evaluator = "slow"
    assert place.swept()[-1]["from_store"] == len(files)
    assert place.outcomes() == undisturbed


@pytest.mark.slow
def test_a_killed_worker_is_replaced_and_a_killed_scheduler_ends_the_driver(place, undisturbed):
    with dask(place) as (address, scheduler, workers):
        run = place.sweep("--scheduler", address)
        place.wait_for(4, run)
        workers[0].kill()
        place.wait_for(10, run)  # what it had goes to the other
        scheduler.kill()
        code, _, err = ended(run)
    assert code == 1
    assert f"Dask scheduler at {address} is gone; finished work is stored" in err
    with dask(place, workers=1):
        summary = well(place.sweep("--scheduler", "scheduler.json"))[-1]
    assert summary["from_store"] >= 10
    assert summary["failures"] == 0
    assert place.outcomes() == undisturbed


@pytest.mark.slow
def test_a_finger_that_kills_every_worker_is_one_failure(place):
    place.environment |= {
        "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1",
        "DASK_DISTRIBUTED__SCHEDULER__WORKER_SATURATION": "1.0",
    }
    place.evaluator = "deadly"
    with dask(place, workers=3) as (address, _, _):
        lines = well(place.sweep("--scheduler", address))
    assert lines[-1]["failures_by_kind"] == {"crashed": 1}
    (bad,) = [each for each in lines if each.get("failure")]
    assert bad["name"] == "many-0005"
    assert bad["failure"]["cause"] == "the workers that had it died, 2 in turn"


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes the certificate")
def test_over_tls_a_study_is_the_same_and_without_a_certificate_refused(place, undisturbed):
    cert, key = (str(place.folder / name) for name in ("cert.pem", "key.pem"))
    new = "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=127.0.0.1"
    subprocess.run([*new.split(), "-keyout", key, "-out", cert], check=True, capture_output=True)
    bare, prefix = dict(place.environment), "DASK_DISTRIBUTED__COMM__TLS__"
    place.environment |= {f"{prefix}CA_FILE": cert}
    for who in ("SCHEDULER", "WORKER", "CLIENT"):
        place.environment |= {f"{prefix}{who}__CERT": cert, f"{prefix}{who}__KEY": key}
    with dask(place, workers=1, protocol="tls") as (address, _, _):
        assert address.startswith("tls://")
        own, place.environment = place.environment, bare
        code, _, err = ended(place.sweep("--scheduler", address))
        place.environment = own
        assert well(place.sweep("--scheduler", address))[-1]["failures"] == 0
    assert place.outcomes() == undisturbed
    assert code == 2
    assert "CLIENT__CERT" in err


@contextlib.contextmanager
def anything(stated):
    """What is no scheduler: it says its bytes to whoever comes, and goes away; its address."""

    class Says(socketserver.BaseRequestHandler):
        def handle(self):
            with contextlib.suppress(OSError):
                self.request.sendall(stated)
                self.request.shutdown(socket.SHUT_WR)
                self.request.settimeout(1.0)
                self.request.recv(1000)

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Says) as server:
        server.daemon_threads = True
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"tcp://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


@pytest.fixture(scope="module")
def worker(tmp_path_factory):
    """A process with a study and half a file of a scheduler in its folder."""
    folder = tmp_path_factory.mktemp("worker")
    (folder / "many.toml").write_text(STUDY)
    (folder / "scheduler.json").write_text("{")
    (folder / "foreign.json").write_text('{"address": "nowhere"}')
    with Worker(folder=folder) as worker:
        yield worker


@pytest.mark.parametrize(
    ("address", "code", "stated"),
    [
        ("tcp://127.0.0.1:1", 1, "failed: no Dask scheduler answers at tcp://127.0.0.1:1: "),
        (struct.pack("<Q", 2) + b"\xff\xff", 1, "Dask scheduler"),
        ("nonsense://x", 2, "--scheduler = nonsense://x: must be an address"),
        ("scheduler.json", 2, "must be a file that a Dask scheduler"),
        ("nosuch", 2, "--scheduler = nosuch: must be an address"),
        ("foreign.json", 2, "--scheduler = nowhere: must be an address"),
    ],
    ids=range(6),
)
def test_no_scheduler_is_an_error(worker, address, code, stated):
    """Bytes: what somebody else answers there."""
    strange = isinstance(address, bytes)
    with anything(address) if strange else contextlib.nullcontext(address) as at:
        arguments = ("sweep", "many.toml", "--out", "out", "--json", "--scheduler", at)
        found = worker.call("tests.support.calls:command", arguments, time_s=PATIENCE_S)
    assert found[0] == code
    assert stated in found[1]
    assert len(found[1].splitlines()) == 1
