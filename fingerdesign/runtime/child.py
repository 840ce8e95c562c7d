"""A process that evaluates one job after the other, under a time and a memory limit.

It is started once for many jobs (loading takes two seconds), replaced when it dies, hangs or takes
too much memory, and after ``RECYCLED_AFTER`` jobs, so that nothing it leaks adds up. It leads a
process group of its own: what it has started (mesher, CAD kernel) ends with it. Memory is the
resident one of the whole group, looked at five times a second: a limit of the address space would
refuse what MKL and the CAD kernel reserve and never touch, and would not hold for the processes
that it starts.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from types import TracebackType
from typing import IO, Any, Literal, Self

from fingerdesign.errors import FingerDesignError
from fingerdesign.runtime.process import environment

RECYCLED_AFTER = 100  # jobs: 3 s of loading are 2 % of their work
START_LIMIT_S = 120.0  # to load; 2 s on a quiet machine
_LOOK_S = 0.2
_OTHERS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
_WORKER = "fingerdesign.search.run.child_worker"

FailureKind = Literal["invalid", "refused", "failed", "crashed", "timeout", "memory"]


class ChildFailed(FingerDesignError):
    """The process did not answer; ``kind`` says how: "crashed", "timeout" or "memory".

    ended_by_others: a signal that no defect sends ended it: a user, or the system short of memory.
    """

    def __init__(self, kind: FailureKind, message: str, ended_by_others: bool = False) -> None:
        self.kind: FailureKind = kind
        self.ended_by_others = ended_by_others
        super().__init__(message)


class Child:
    """One evaluating process; started by the first job. A context manager: leaving it ends it.

    evaluator: "module:function" of plain values to a line of JSON. ended: it starts no process.
    """

    def __init__(
        self,
        evaluator: str,
        recycled_after: int = RECYCLED_AFTER,
        ended: bool = False,
    ) -> None:
        self.evaluator, self._recycled_after = evaluator, recycled_after
        self._killed = ended
        self._process: subprocess.Popen[bytes] | None = None
        self._errors: IO[bytes] | None = None
        self._jobs = 0
        self._read = bytearray()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.end()

    def run(self, data: dict[str, Any], time_s: float, memory_MB: float) -> str:
        """The answer to one job. Raises ChildFailed; the next job gets a new process."""
        gone = self._process is not None and self._process.poll() is not None
        if gone or self._jobs >= self._recycled_after:
            self.end()
        line = (json.dumps(data, allow_nan=False) + "\n").encode()
        kept = self._process is not None
        try:
            self._hand(line, memory_MB)
        except ChildFailed as error:
            if not kept or self._killed or error.kind != "crashed":
                raise
            self._hand(line, memory_MB)  # it had died while it had nothing to do
        process = self._process
        assert process is not None
        try:
            return self._answer(process, time_s, memory_MB)
        except BaseException:
            self.end()
            raise

    def _hand(self, line: bytes, memory_MB: float) -> None:
        """Give a job to the process, started where there is none, and hear that it was taken."""
        try:
            process = self._process or self._start(memory_MB)
            assert process.stdin is not None
            self._jobs += 1
            process.stdin.write(line)
            process.stdin.flush()
            self._answer(process, START_LIMIT_S, memory_MB)
        except BrokenPipeError:
            raise self._died() from None
        except BaseException:
            self.end()
            raise

    def kill(self) -> None:
        """End the process from another thread; a job that it does fails, and none follows."""
        self._killed = True
        process = self._process
        if process is not None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)

    def end(self) -> None:
        """End the process and all that it has started."""
        process, self._process = self._process, None
        self._jobs, self._read = 0, bytearray()
        if process is not None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    with contextlib.suppress(BrokenPipeError):
                        pipe.close()
        if self._errors is not None:
            self._errors.close()
            self._errors = None

    def _start(self, memory_MB: float) -> subprocess.Popen[bytes]:
        if self._killed:
            raise ChildFailed("crashed", "it was told to end")
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed by end()
        self._process = subprocess.Popen(
            [sys.executable, "-m", _WORKER, self.evaluator],
            env=environment() | {"OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            start_new_session=True,
        )
        if self._killed:  # meanwhile
            raise ChildFailed("crashed", "it was told to end")
        self._answer(self._process, START_LIMIT_S, memory_MB)  # "ready"
        return self._process

    def _answer(self, process: subprocess.Popen[bytes], time_s: float, memory_MB: float) -> str:
        """The next line that it writes."""
        assert process.stdout is not None
        end = time.monotonic() + time_s
        look, seen = time.monotonic() + _LOOK_S, 0
        while True:
            found = self._read.find(b"\n", seen)
            if found >= 0:
                line = self._read[:found].decode()
                del self._read[: found + 1]
                return line
            seen = len(self._read)
            if (now := time.monotonic()) >= look:  # also while it keeps writing
                look = now + _LOOK_S
                used = _group_memory_MB(process.pid) + len(self._read) / 1e6
                if used > memory_MB:
                    raise ChildFailed("memory", f"took {used:.0f} MB, more than {memory_MB:g} MB")
                if now > end:
                    raise ChildFailed("timeout", f"not done after {time_s:g} s")
            ready, _, _ = select.select([process.stdout], [], [], _LOOK_S)
            if ready:
                more = os.read(process.stdout.fileno(), 1 << 20)
                if not more:
                    raise self._died()
                self._read += more

    def _died(self) -> ChildFailed:
        """Why the process is gone, in words; it is cleared away."""
        process, said = self._process, ""
        if process is None:
            return ChildFailed("crashed", "its process is gone")
        try:
            code = process.wait(5.0)
        except subprocess.TimeoutExpired:
            code = 0
        if self._errors is not None:
            self._errors.seek(0)
            lines = self._errors.read().decode("utf-8", "replace").strip().splitlines()
            said = f": {lines[-1][:300]}" if lines else ""
        self.end()
        if code < 0:
            others = -code in _OTHERS
            return ChildFailed(
                "crashed", f"its process was ended by {_signal(-code)}{said}", others
            )
        return ChildFailed("crashed", f"its process ended with code {code}{said}")


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _group_memory_MB(leader: int) -> float:
    """Resident memory of a process and of all that it has started, MB."""
    import psutil

    try:
        process = psutil.Process(leader)
        family = [process, *process.children(recursive=True)]
    except psutil.Error:
        return 0.0
    total = 0
    for each in family:
        try:
            total += each.memory_info().rss
        except psutil.Error:
            continue
    return total / 1e6
