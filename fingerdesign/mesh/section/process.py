"""Netgen run safely and often: a worker process that stays, with a time limit for each mesh.

Starting Python and loading netgen takes longer than meshing a section, and a sweep meshes hundreds.
So the process is started once (``start_mesher`` does it ahead of need, without waiting) and asked
again and again. One that crashes, fails or runs out of time is ended, and the next mesh starts
another. Each thread has its own: a process ends with the thread that started it.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import weakref
from typing import IO, Any

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.worker import environment

WORKER = "fingerdesign.mesh.section.worker"


class SectionProcess:
    """One worker process, its pipes and the file that holds what it complains of."""

    def __init__(self) -> None:
        self.owner = os.getpid()
        self._log: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  open as long as the process
        self._process = subprocess.Popen(
            [sys.executable, "-m", WORKER],
            env=environment(),
            cwd=tempfile.gettempdir(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
        )
        # Called once: by close, when nobody holds this object any more, or when the program ends.
        self._end = weakref.finalize(self, _end, self._process, self._log, self.owner)

    @property
    def alive(self) -> bool:
        """Whether it can be asked: it runs, and this process (not a fork's parent) started it."""
        return self.owner == os.getpid() and self._process.poll() is None

    def ask(self, request: dict[str, Any], time_limit_s: float) -> tuple[Array, IntArray, IntArray]:
        """Points (n, 2), triangles (t, 3) and their domains (t,). MeshError says how it failed."""
        late = threading.Event()

        def stop() -> None:
            late.set()
            self._process.kill()

        timer = threading.Timer(time_limit_s, stop)
        timer.start()
        try:
            return self._exchange(json.dumps(request).encode())
        except MeshError:
            self.close()
            if late.is_set():
                raise MeshError(f"it did not finish in {time_limit_s:g} s") from None
            raise
        except BaseException:
            self.close()
            raise
        finally:
            timer.cancel()

    def _exchange(self, request: bytes) -> tuple[Array, IntArray, IntArray]:
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        try:
            stdin.write(request + b"\n")
            stdin.flush()
            line = stdout.readline()
            if not line.endswith(b"\n"):
                raise MeshError(self._ending())
            answer = json.loads(line)
            if "error" in answer:
                raise MeshError(f"it failed: {answer['error']}")
            points = np.frombuffer(self._read(stdout, 16 * answer["points"]), dtype="<f8")
            whole = np.frombuffer(self._read(stdout, 32 * answer["triangles"]), dtype="<i8")
        except OSError:  # the pipe broke: it ended while it was asked
            raise MeshError(self._ending()) from None
        table = whole.reshape(-1, 4).astype(np.int64)
        return points.reshape(-1, 2).astype(float), table[:, :3].copy(), table[:, 3].copy()

    def _read(self, stream: IO[bytes], size: int) -> bytes:
        content = stream.read(size)
        if len(content) != size:
            raise MeshError(self._ending())
        return content

    def _ending(self) -> str:
        """How the process ended, in words."""
        code = self._process.wait()
        if code < 0:
            return f"its process was ended by {signal.Signals(-code).name}"
        self._log.seek(0)
        said = self._log.read().decode(errors="replace").strip().splitlines() or ["no message"]
        return f"it ended with exit code {code}: {said[-1][:300]}"

    def close(self) -> None:
        """End the process, whatever it is doing, and let go of its pipes."""
        self._end()


def _end(process: subprocess.Popen[bytes], log: IO[bytes], owner: int) -> None:
    if owner != os.getpid():  # a fork's copy: the process is its parent's
        return
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout, log):
        if stream is not None:
            with contextlib.suppress(OSError):  # a request was left unsent in the buffer
                stream.close()


_LOCAL = threading.local()


def start_mesher() -> SectionProcess:
    """This thread's worker, started where there is none; does not wait until it is ready."""
    worker: SectionProcess | None = getattr(_LOCAL, "worker", None)
    if worker is None or not worker.alive:
        if worker is not None:
            worker.close()
        worker = SectionProcess()
        _LOCAL.worker = worker
    return worker


def run_netgen(request: dict[str, Any], time_limit_s: float) -> tuple[Array, IntArray, IntArray]:
    """Points (n, 2), triangles (t, 3) and domains (t,) of an outline (``Outline.as_dict``).

    Raises MeshError where the worker fails, crashes or takes longer than ``time_limit_s``.
    """
    return start_mesher().ask(request, time_limit_s)
