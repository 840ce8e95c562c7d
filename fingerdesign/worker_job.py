"""A module at work in a process of its own while the caller goes on; leaving ends it."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from fingerdesign.process import ProcessError, environment


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
