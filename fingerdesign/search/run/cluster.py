"""Jobs on a Dask cluster: the cores of this machine, or any scheduler that is named.

Dask hands out the work; what evaluates it is a child process of each worker thread, which bears the
limits and the crashes. So the local workers are threads of this process: no port is opened, and
nothing is left when it ends. Each thread reuses its own child. Text goes in and out, so that a
worker needs nothing of a study but this package.
"""

import contextlib
import json
import logging
import os
import queue
import secrets
import socket
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from importlib import metadata
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from fingerdesign.errors import DesignError, Fault, FingerDesignError
from fingerdesign.records.outcome import Failure, Outcome, OutcomeError
from fingerdesign.runtime.extras import needs
from fingerdesign.runtime.isolate import ProcessError
from fingerdesign.runtime.machine import usable_cores
from fingerdesign.runtime.pool import Pool
from fingerdesign.search.run.evaluate import EVALUATE, Job, failed
from fingerdesign.search.study.file import Limits

TRIES = 3  # of a job whose process somebody ended: the system for want of memory, or a user
RECYCLED_AFTER = 100  # jobs: 3 s of loading are 2 % of their work
READY_S = 120.0  # to load; 2 s on a quiet machine
IDLE_S = 600.0  # a child ends then, as on a cluster whose driver has ended
_LOAD = "fingerdesign.search.run.evaluate:load"
_POOLS: dict[tuple[str, ...], Pool] = {}  # by name, evaluator and limits
_ENDED: set[str] = set()
_LOCK = threading.Lock()
AHEAD = 500  # jobs handed to the scheduler before their turn: enough for it to ask for workers by
CONNECT_S, CLOSE_S, LOOK_S = 15.0, 10.0, 2.0
_LIKE = "an address like tcp://host:8786 or tls://host:8786"
_LOGGERS = ("distributed", "distributed.client", "distributed.scheduler", "distributed.worker")


def work(text: str) -> str:
    """One job; JSON {"outcome": its line} or {"failure": [kind, sentence]}.

    text: JSON of data, evaluator, time_s, memory_MB, and pool, which tells children of one process
    apart.
    """
    task = json.loads(text)
    for tried in range(1, TRIES + 1):
        try:
            return json.dumps({"outcome": _pool(task).call(task["evaluator"], task["data"])})
        except ProcessError as error:
            if error.ended_by_others and tried < TRIES and task["pool"] not in _ENDED:
                continue
            again = f", tried {tried} times" if tried > 1 else ""
            words = f"not done after {task['time_s']:g} s" if error.kind == "timeout" else error
            return json.dumps({"failure": [error.kind, f"{words}{again}"]})
    raise AssertionError("unreachable")


def _pool(task: dict[str, Any]) -> Pool:
    """The children that do such tasks, one a thread; dead ones once their pool has ended."""
    evaluator = task["evaluator"]
    key = (task["pool"], evaluator, str(task["time_s"]), str(task["memory_MB"]))
    with _LOCK:
        if key not in _POOLS:
            _POOLS[key] = Pool(
                1,  # the threads are Dask's
                time_s=task["time_s"],
                memory_MB=task["memory_MB"],
                recycled_after=RECYCLED_AFTER,
                load=_LOAD if evaluator == EVALUATE else evaluator.partition(":")[0],
                ready_s=READY_S,
                idle_s=IDLE_S,
            )
            if task["pool"] in _ENDED:
                _POOLS[key].kill()
        return _POOLS[key]


def end_pool(name: str) -> None:
    """Kill the children of a pool, whatever they are doing; no more are started in it."""
    with _LOCK:
        _ENDED.add(name)
        found = [pool for key, pool in _POOLS.items() if key[0] == name]
    for pool in found:
        pool.kill()


def forget_pool(name: str) -> None:
    """Clear away the children of a pool that was ended, once no thread uses them any more."""
    with _LOCK:
        found = [_POOLS.pop(key) for key in list(_POOLS) if key[0] == name]
    for pool in found:
        pool.__exit__()


class ClusterError(FingerDesignError):
    """The cluster cannot work: no scheduler answers, it was lost, its workers cannot evaluate."""


class Cluster(ExitStack):
    """Evaluation of jobs; the first job starts it. A context manager.

    workers: processes at a time on this machine (None: as many as cores); scheduler: the address
    of a Dask scheduler instead, or the file that it wrote it to. evaluator: "module:function", see
    runtime/isolate.py.
    """

    def __init__(
        self, workers: int | None = None, scheduler: str | None = None, evaluator: str = EVALUATE
    ) -> None:
        super().__init__()
        self._workers, self._evaluator = workers, evaluator
        self._scheduler = scheduler if scheduler is None else _address(scheduler)
        self._pool = secrets.token_hex(8) if scheduler is None else ""
        self._client: Any = None
        self.threads = 0  # that evaluate, when last looked at
        self.dashboard: str | None = None  # address of the scheduler's, once connected

    def start(self) -> None:
        """Connect, or start the local workers; the first job does it too. Raises ClusterError,
        MissingExtra without Dask."""
        if self._client is not None:
            return
        needs("search", "distributed")
        self.enter_context(_quiet())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of versions that differ: results are held to theirs
            if self._scheduler is None:
                self._start_here()
            else:
                self._connect(self._scheduler)
        self._count()

    def outcomes(
        self,
        jobs: Iterable[tuple[str, Job]],
        limits: Limits,
        look: Callable[[], None] = lambda: None,
    ) -> Iterator[tuple[str, Outcome]]:
        """Each job's digest and outcome, as they come; what fails is an outcome too.

        jobs: with their digests. look: called every second or two while nothing comes. Raises
        ClusterError.
        """
        self.start()
        from distributed import Future

        waiting: dict[str, tuple[str, Job, Future]] = {}
        finished: queue.SimpleQueue[str] = queue.SimpleQueue()
        source = iter(jobs)
        try:
            while True:
                while len(waiting) < AHEAD and (each := next(source, None)) is not None:
                    future = self._submit(each[1], limits)
                    waiting[future.key] = (*each, future)
                    future.add_done_callback(lambda done: finished.put(done.key))
                if not waiting:
                    return
                try:
                    key = finished.get(timeout=LOOK_S)
                except queue.Empty:
                    self._count()
                    look()
                    continue
                digest, job, future = waiting.pop(key)
                yield digest, self._outcome(digest, job, future)
        finally:
            if waiting:
                with contextlib.suppress(Exception):
                    self._client.cancel([future for _, _, future in waiting.values()])

    def _submit(self, job: Job, limits: Limits) -> Any:
        task = {"data": job.to_data(), "evaluator": self._evaluator, "pool": self._pool}
        text = json.dumps(task | limits.model_dump(), allow_nan=False)
        return self._client.submit(work, text, key=f"fingerdesign-{secrets.token_hex(12)}")

    def _outcome(self, digest: str, job: Job, future: Any) -> Outcome:
        from distributed import CancelledError, KilledWorker

        try:
            answer = json.loads(self._result(future))
        except KilledWorker as error:
            died = f"the workers that had it died, {error.allowed_failures + 1} in turn"
            return failed(job, Failure("crashed", died))
        except (CancelledError, OSError) as error:
            raise self._lost() from error
        except ClusterError:
            raise
        except Exception as error:
            remedy = "does it have this version of fingerdesign, and what that needs?"
            kind = type(error).__name__
            raise ClusterError(f"a worker cannot evaluate: {kind}: {error}; {remedy}") from error
        if "failure" in answer:
            return failed(job, Failure(*answer["failure"]))
        try:
            found = Outcome.from_json(answer["outcome"])
        except OutcomeError as error:
            return failed(job, Failure("crashed", f"its process answered with {error}"))
        if found.digest != digest:
            here, there = failed(job, Failure("crashed", "")).versions, found.versions
            differ = [f"{name} {there.get(name)}" for name in here if here[name] != there.get(name)]
            reported = ", ".join(differ) or "another fingerdesign"
            raise ClusterError(f"a worker has {reported}; install the same everywhere")
        return found

    def _result(self, future: Any) -> str:
        """Result of a task; computed again where its worker died."""
        while True:
            try:
                return str(future.result(timeout=CONNECT_S))
            except TimeoutError:
                self._count()  # raises where the scheduler no longer answers

    def _start_here(self) -> None:
        from distributed import Client, LocalCluster

        threads = self._workers or usable_cores()
        cluster = self.enter_context(
            LocalCluster(
                n_workers=1,
                threads_per_worker=threads,
                processes=False,
                memory_limit=0,  # the children's memory is what counts
                dashboard_address="127.0.0.1:0",  # on this machine alone
                worker_dashboard_address="127.0.0.1:0",
                silence_logs=False,
            )
        )
        self._client = Client(cluster, set_as_default=False)
        self.callback(forget_pool, self._pool)
        self.callback(self._client.close, CLOSE_S)
        self.callback(end_pool, self._pool)  # first: what runs would be waited for

    def _connect(self, address: str) -> None:
        from distributed import Client
        from distributed.comm import get_address_host_port

        host, port = get_address_host_port(address)
        _refuse_without_certificate(address)
        client: Any = None
        try:
            # Dask would go on trying, and complain at the end of a client without a connection.
            socket.create_connection((host, port), CONNECT_S).close()
            # Before it connects, so that one that cannot is in hand: it would try to end well.
            client = Client.__new__(Client)
            client.__init__(address, timeout=CONNECT_S, set_as_default=False)
            self._client = client
        except Exception as error:  # Dask takes whatever it is answered for a scheduler's words
            if client is not None:
                client.status = "closed"
            elif isinstance(error, OverflowError | TypeError):  # a port that there is not
                fault = Fault("--scheduler", address, _LIKE, f"{error}")
                raise DesignError([fault]) from error
            silent = isinstance(error, OSError)
            reported = (
                "no Dask scheduler answers" if silent else "what answers is no Dask scheduler"
            )
            why = error if silent else f"{type(error).__name__} {error}"
            remedy = "start one, or leave --scheduler out"
            raise ClusterError(f"{reported} at {address}: {why}; {remedy}") from error
        self.callback(self._client.close, CLOSE_S)
        with contextlib.suppress(Exception):  # without bokeh its address is an empty page's
            self._client.run_on_scheduler(metadata.version, "bokeh")
            self.dashboard = self._client.dashboard_link

    def _count(self) -> None:
        try:
            self.threads = sum(self._client.nthreads().values())
        except Exception as error:
            raise self._lost() from error

    def _lost(self) -> ClusterError:
        at = f" at {self._scheduler}" if self._scheduler else ""
        reported = f"the Dask scheduler{at} is gone; finished work is stored"
        return ClusterError(f"{reported}: run it again, and it goes on")


def _refuse_without_certificate(address: str) -> None:
    """Raise DesignError where a scheduler is named that speaks TLS, and Dask has no certificate."""
    import dask

    keys = {"ca-file": "CA_FILE", "client.cert": "CLIENT__CERT", "client.key": "CLIENT__KEY"}
    lacking = [
        f"DASK_DISTRIBUTED__COMM__TLS__{name}"
        for key, name in keys.items()
        if not dask.config.get(f"distributed.comm.tls.{key}", None)
    ]
    if address.startswith("tls://") and lacking:
        remedy = f"set {' and '.join(lacking)} in the environment, or Dask's own configuration"
        raise DesignError([Fault("--scheduler", address, "reached with a certificate", remedy)])


def _address(scheduler: str) -> str:
    """The address itself, or the one in a file that the scheduler wrote. Raises DesignError."""
    if not os.path.isfile(scheduler):
        return _sound(scheduler)
    try:
        return _sound(str(json.loads(Path(scheduler).read_text(encoding="utf-8"))["address"]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        remedy = "wait until it is written, or give the address"
        fault = Fault("--scheduler", scheduler, "a file that a Dask scheduler wrote", remedy)
        raise DesignError([fault]) from error


def _sound(address: str) -> str:
    """The address. Raises DesignError where it is like none."""
    try:
        whole = urlsplit(address if "://" in address else f"tcp://{address}")
        if whole.hostname and whole.port and whole.scheme in ("tcp", "tls"):
            return address
    except ValueError:  # the port is no number, or too large
        pass
    raise DesignError([Fault("--scheduler", address, _LIKE, "correct it")])


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep what Dask logs off the terminal: failures are reported as outcomes."""
    import distributed  # noqa: F401 - it sets its loggers' levels when it is loaded

    loggers = [logging.getLogger(name) for name in _LOGGERS]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
