"""A function called in another process, with limits of time and memory.

    call("fingerdesign.cad.solid:finger_parts", design, 0.02, time_s=120.0)     fresh
    with concurrently(placement_effect, design, plan, time_s=60.0) as wait: ...  concurrent work
    worker = Worker(); worker.start(); ...; worker.call(mesh_outline, outline)  warm

Native code (CAD kernel, mesher, graphics) can crash or hang; there it harms nobody. Arguments and
answers are pickled (protocol 5). An error of this package that the function raises is raised here;
all else is a ProcessError, a sentence that says how it ended. Each process leads a group of its
own: what it started ends with it, and it ends when its parent does, however that ends.

Our own and no library's: pebble and loky limit the time of a call, but neither the memory of all
that it started nor the life of a process whose parent was killed.
"""

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Literal, Self

from fingerdesign.errors import FingerDesignError
from fingerdesign.runtime.child import HEAD, PARENT, name_of
from fingerdesign.runtime.limits import family_memory_MB, family_of

_SERVE = "from fingerdesign.runtime.child import serve; serve()"
_LOOK_S = 0.2  # between two looks at a process's memory: a fifth of a per cent of a core
_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_CHUNK = 1 << 16  # bytes: what a pipe holds
_OTHERS = ("SIGKILL", "SIGTERM", "SIGINT", "SIGHUP", "SIGXCPU")  # that no defect sends

Function = Callable[..., Any] | str  # "package.module:function", or the function itself
Wait = Callable[[], Any]  # for the answer of a concurrent call
Kind = Literal["crashed", "timeout", "memory"]


class ProcessError(FingerDesignError):
    """A process did not do its work; the message says how it ended ("it did not finish in 5 s").

    kind             "crashed" (or the function raised what is no error of this package),
                     "timeout" or "memory"
    ended_by_others  a signal that no defect sends ended it: a user, or the system short of memory
    machine          it was not its input's fault: ended by others, no disk, no memory
    """

    def __init__(
        self, kind: Kind, message: str, ended_by_others: bool = False, machine: bool = False
    ) -> None:
        self.kind: Kind = kind
        self.ended_by_others = ended_by_others
        self.machine = machine or ended_by_others
        super().__init__(message)

    def __reduce__(self) -> tuple[Any, ...]:
        return ProcessError, (self.kind, str(self), self.ended_by_others, self.machine)


def call(
    function: Function,
    *given: Any,
    time_s: float | None,
    memory_MB: float | None = None,
    folder: Path | None = None,
    **named: Any,
) -> Any:
    """``function(*given, **named)`` in a fresh process; folder: where it runs, for what litters.

    The time counts from now, loading included. Raises ProcessError and what ``function`` raises of
    this package's errors.
    """
    with Worker(folder=folder) as worker:
        return worker.call(function, *given, time_s=time_s, memory_MB=memory_MB, **named)


@contextlib.contextmanager
def concurrently(function: Function, *given: Any, time_s: float) -> Iterator[Wait]:
    """``function(*given)`` in a fresh process, concurrently with the caller's work.

    What is yielded waits for the answer, once, and raises as :func:`call` does; leaving the block
    ends a process that still runs. time_s counts from entering.
    """
    with Worker() as worker:
        worker.begin(_request(function, given, {}), time_s)
        yield lambda: worker.answer(None)


class Worker:
    """One process for many calls: started by the first (or ``start``), replaced when it dies, hangs
    or takes too much memory. A context manager: leaving it ends it. For one thread at a time.

    load            a module, or a function to call: once a process, before the first call
    shared          given to every function before its own arguments; sent once a process
    recycled_after  calls; then a new process, so that nothing that it leaks adds up
    ready_s         what loading may take, apart from the call's own time; None: it counts to it
    threads         of BLAS
    idle_s          without a call it ends by itself
    folder          where it runs; the system's for temporary files
    """

    def __init__(
        self,
        *,
        load: Function | None = None,
        shared: tuple[Any, ...] = (),
        recycled_after: int | None = None,
        ready_s: float | None = None,
        threads: int | None = None,
        idle_s: float | None = None,
        folder: Path | None = None,
    ) -> None:
        self._load = "" if load is None else name_of(load)
        self._shared = pickle.dumps(("", pickle.dumps(shared, 5)), 5) if shared else b""
        self._recycled_after, self._ready_s, self._folder = recycled_after, ready_s, folder
        self._idle_s = idle_s
        self._environment = {} if threads is None else dict.fromkeys(_THREADS, str(threads))
        self._killed = False
        self._process: _Process | None = None
        self._calls = 0
        self._time_s: float | None = None
        self._began = 0.0  # of the running call

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.end()

    @property
    def pid(self) -> int | None:
        """Number of the process; None where there is none."""
        return None if self._process is None else self._process.pid

    @property
    def alive(self) -> bool:
        """Tell whether its process runs, and this process (not a fork's parent) started it."""
        return self._process is not None and self._process.alive

    def start(self) -> None:
        """Start the process where there is none; does not wait until it has loaded."""
        if self.alive:
            return
        self.end()
        if self._killed:
            raise ProcessError("crashed", "it was requested to end")
        environment = os.environ | self._environment
        self._process = _Process(self._load, self._idle_s, environment, self._folder)
        if self._shared:
            self._process.send(self._shared)
        if self._killed:  # meanwhile
            self.end()
            raise ProcessError("crashed", "it was requested to end")

    def call(
        self,
        function: Function,
        *given: Any,
        time_s: float | None,
        memory_MB: float | None = None,
        **named: Any,
    ) -> Any:
        """``function(*shared, *given, **named)`` there. Raises ProcessError (the next call gets a
        new process) and what ``function`` raises of this package's errors."""
        request = _request(function, given, named)
        before = self._process if self._calls > 0 else None
        try:
            self.begin(request, time_s)
            return self.answer(memory_MB)
        except ProcessError as error:
            died_idle = before is not None and before.seen.taken is None and error.kind == "crashed"
            if not died_idle or self._killed:
                raise
        self.begin(request, time_s)  # it had died while it had nothing to do
        return self.answer(memory_MB)

    def begin(self, request: bytes, time_s: float | None) -> None:
        """Hand a pickled call over; does not wait."""
        if self._recycled_after is not None and self._calls >= self._recycled_after:
            self.end()
        self.start()
        assert self._process is not None
        self._calls += 1
        self._time_s, self._began = time_s, time.monotonic()
        self._process.seen.taken = None
        self._process.send(request)

    def answer(self, memory_MB: float | None) -> Any:
        """Wait for the outcome of the call that was begun."""
        try:
            kind, value = self._next(memory_MB)
            if kind == "failed":
                words, machine = value
                raise ProcessError("crashed", f"it failed: {words}", machine=machine)
        except BaseException:
            self.end()
            raise
        if kind == "raised":
            raise value
        return value

    def kill(self) -> None:
        """End the process from another thread; a call that it does fails, and none follows."""
        self._killed = True
        process = self._process
        if process is not None:
            process.kill()

    def end(self) -> None:
        """End the process and all that it has started."""
        process, self._process = self._process, None
        self._calls = 0
        if process is not None:
            process.end()

    def _limit(self, taken: float | None) -> tuple[float | None, float]:
        """Return the call's time limit, s, and the time that is left of it."""
        limit, since = self._time_s, self._began
        if self._ready_s is not None:
            limit, since = (self._ready_s, since) if taken is None else (limit, taken)
        return limit, float("inf") if limit is None else since + limit - time.monotonic()

    def _next(self, memory_MB: float | None) -> tuple[str, Any]:
        process = self._process
        if process is None:
            raise ProcessError("crashed", "its process is gone")
        while True:
            limit, left = self._limit(process.seen.taken)
            try:
                frame = process.frames.get(timeout=max(0.0, min(_LOOK_S, left)))
            except queue.Empty:
                if memory_MB is not None:
                    used = family_memory_MB(process.pid) + process.seen.unread / 1e6
                    if used > memory_MB:
                        words = f"took {used:.0f} MB, more than {memory_MB:g} MB"
                        raise ProcessError("memory", words) from None
                limit, left = self._limit(process.seen.taken)
                if left <= 0.0:
                    words = f"it did not finish in {limit:g} s"
                    raise ProcessError("timeout", words) from None
                continue
            if frame is None:
                raise process.ending()
            message: tuple[str, Any] = pickle.loads(frame)
            return message


@dataclass
class _Seen:
    """State of the thread that reads: bytes of an answer that is not whole yet; the time at which
    the process took the call (an empty message reports it), None: not yet."""

    unread: int = 0
    taken: float | None = None


class _Process:
    """A running process, its pipes, the thread that reads what it answers, and what it complains
    of. It is ended once: by ``end``, when nobody holds this any more, or with the program."""

    def __init__(
        self, load: str, idle_s: float | None, environment: dict[str, str], folder: Path | None
    ) -> None:
        root = str(Path(__file__).resolve().parents[2])
        paths = filter(None, [root, environment.get("PYTHONPATH", "")])
        own = {"PYTHONPATH": os.pathsep.join(paths), PARENT: str(os.getpid())}
        errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the process
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", _SERVE, load, "" if idle_s is None else str(idle_s)],
            cwd=folder or tempfile.gettempdir(),
            env=environment | own,
            bufsize=0,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            start_new_session=True,
        )
        self._owner, self._errors = os.getpid(), errors
        self.frames: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self.seen = _Seen()
        self._threads: list[threading.Thread] = []
        self._go(_read, self._process.stdout, self.frames, self.seen)
        self.end = weakref.finalize(
            self, _end, self._process, self._threads, self._errors, self._owner
        )

    @property
    def pid(self) -> int:
        """Its number."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Tell whether it runs and is this process's own."""
        return self._owner == os.getpid() and self._process.poll() is None

    def send(self, content: bytes) -> None:
        """Write a frame; what a pipe does not hold at once is written by a thread."""
        frame = HEAD.pack(len(content)) + content
        if len(frame) < _CHUNK and not self._threads[1:]:
            _write(self._process.stdin, frame, None)
        else:
            before = self._threads[-1] if self._threads[1:] else None
            self._go(_write, self._process.stdin, frame, before)

    def kill(self) -> None:
        """End it and its group; from any thread."""
        kill_group(self._process)

    def ending(self) -> ProcessError:
        """Report in words how it ended."""
        try:
            code = self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            return ProcessError("crashed", "its process closed its pipe")
        self._errors.seek(0)
        lines = self._errors.read().decode("utf-8", "replace").strip().splitlines()
        tail = f": {lines[-1][:300]}" if lines else ""
        if code >= 0:
            return ProcessError("crashed", f"its process ended with code {code}{tail}")
        named = {each.value: each.name for each in signal.Signals}
        name = named.get(-code, f"signal {-code}")
        return ProcessError("crashed", f"its process was ended by {name}{tail}", name in _OTHERS)

    def _go(self, function: Callable[..., None], *given: Any) -> None:
        thread = threading.Thread(target=function, args=given, daemon=True)
        self._threads.append(thread)
        thread.start()


def _read(stream: IO[bytes], frames: queue.SimpleQueue[bytes | None], seen: _Seen) -> None:
    """Put every frame of a stream into the queue; None at its end."""
    with contextlib.suppress(OSError, ValueError):  # closed: it was ended
        while (head := _exactly(stream, HEAD.size, seen)) is not None:
            (size,) = HEAD.unpack(head)
            if size == 0:  # nobody need wake up for it
                seen.taken = time.monotonic()
                continue
            frame = _exactly(stream, size, seen)
            if frame is None:
                break
            frames.put(frame)
    frames.put(None)


def _exactly(stream: IO[bytes], size: int, seen: _Seen) -> bytes | None:
    """So many bytes of a raw stream; None where it ends before."""
    found = bytearray()
    while len(found) < size:
        more = stream.read(min(size - len(found), 1 << 20))
        if not more:
            return None
        found += more
        seen.unread = len(found)
    seen.unread = 0
    return bytes(found)


def _write(stream: IO[bytes] | None, frame: bytes, before: threading.Thread | None) -> None:
    """Write a frame, after another; a process that is gone is found by reading."""
    if before is not None:
        before.join()
    assert stream is not None
    left = memoryview(frame)
    with contextlib.suppress(OSError, ValueError):
        while left:
            left = left[stream.write(left) or 0 :]


def _end(
    process: subprocess.Popen[bytes], threads: list[threading.Thread], errors: IO[bytes], owner: int
) -> None:
    if owner != os.getpid():  # a fork's copy: the process is its parent's
        return
    kill_group(process)
    process.wait()
    for thread in threads:
        thread.join(1.0)
    for stream in (process.stdin, process.stdout, errors):
        if stream is not None:
            with contextlib.suppress(OSError):
                stream.close()


def kill_group(process: subprocess.Popen[bytes]) -> None:
    """End a process and its group, also where only what it started is left."""
    if hasattr(os, "killpg"):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    else:
        import psutil

        for each in family_of(process.pid):
            with contextlib.suppress(psutil.Error):
                each.kill()


def _request(function: Function, given: tuple[Any, ...], named: dict[str, Any]) -> bytes:
    return pickle.dumps((name_of(function), pickle.dumps((given, named), 5)), 5)
