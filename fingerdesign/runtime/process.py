"""Run a module of this package in a process of its own, with a time limit; where files are kept.

Native code (CAD kernel, mesher, graphics) can crash or hang; there it harms nobody.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from fingerdesign.errors import FingerDesignError

MACHINE_FAILED = 75  # exit code of a worker that lacked disk or memory, not sound input
_PARENT = "FINGERDESIGN_PARENT"  # process number


class ProcessError(FingerDesignError):
    """A process did not do its work; the message says how it ended ("it did not finish in 5 s").

    code: what it ended with, negative for a signal; None where it did not end in time
    """

    def __init__(self, message: str, code: int | None = None) -> None:
        self.code = code
        super().__init__(message)


def machine_failed(error: ProcessError) -> bool:
    """Whether a process ended for want of disk or memory, or somebody ended it: not its input."""
    ended = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGXCPU)
    return error.code == MACHINE_FAILED or error.code in [-number for number in ended]


def die_with_parent() -> None:
    """End this process when the one that started it ends, however that ends (Linux)."""
    if sys.platform == "linux":
        import ctypes

        pr_set_pdeathsig = 1
        ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGKILL)
        if os.environ.get(_PARENT, str(os.getppid())) != str(os.getppid()):
            os._exit(1)  # it had ended already (in a container the parent itself may be process 1)


def environment() -> dict[str, str]:
    """The environment in which a Python process finds this package and knows who started it."""
    root = str(Path(__file__).resolve().parents[2])
    path = os.pathsep.join(filter(None, [root, os.environ.get("PYTHONPATH", "")]))
    return os.environ | {"PYTHONPATH": path, _PARENT: str(os.getpid())}


def run_module(module: str, arguments: list[str], folder: Path, time_limit_s: float) -> None:
    """Run ``python -m module arguments`` in ``folder``; ProcessError says how it failed."""
    try:
        done = subprocess.run(
            [sys.executable, "-m", module, *arguments],
            cwd=folder,
            env=environment(),
            timeout=time_limit_s,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise ProcessError(f"it did not finish in {time_limit_s:g} s") from error
    if done.returncode < 0:
        name = signal.Signals(-done.returncode).name
        raise ProcessError(f"its process was ended by {name}", done.returncode)
    if done.returncode > 0:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        told = f"it failed with exit code {done.returncode}: {last[:300]}"
        raise ProcessError(told, done.returncode)


# A module at work in a process of its own while the caller goes on; leaving ends it.


class WorkerJob:
    """``python -m module FOLDER`` beside the caller's work.

        with WorkerJob("fingerdesign.mold.placement_worker", write_request, 60.0) as job:
            ...                                    # other work
            folder = job.finished()                # waits; ProcessError says how it failed

    ask: writes the request into the temporary folder before the process starts. The folder is
    there until the block ends; a process that still runs then is killed. time_limit_s counts from
    the start.
    """

    def __init__(self, module: str, ask: Callable[[Path], None], time_limit_s: float) -> None:
        self.module, self.ask, self.time_limit_s = module, ask, time_limit_s

    def __enter__(self) -> WorkerJob:
        self._home = tempfile.TemporaryDirectory(prefix="fingerdesign-job-")
        self.folder = Path(self._home.name)
        try:
            self.ask(self.folder)
            self._errors = (self.folder / "errors.txt").open("wb")
        except BaseException:
            self._home.cleanup()
            raise
        self._started = time.monotonic()
        self._process = subprocess.Popen(
            [sys.executable, "-m", self.module, str(self.folder)],
            cwd=self.folder,
            env=environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
        )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        self._errors.close()
        self._home.cleanup()

    def finished(self) -> Path:
        """Wait for its end; the folder that it has answered in."""
        left = max(0.0, self._started + self.time_limit_s - time.monotonic())
        try:
            code = self._process.wait(left)
        except subprocess.TimeoutExpired as error:
            raise ProcessError(f"it did not finish in {self.time_limit_s:g} s") from error
        if code < 0:
            raise ProcessError(f"its process was ended by {signal.Signals(-code).name}", code)
        if code > 0:
            text = (self.folder / "errors.txt").read_text("utf-8", "replace")
            last = (text.strip().splitlines() or ["no message"])[-1]
            raise ProcessError(f"it failed with exit code {code}: {last[:300]}", code)
        return self.folder
