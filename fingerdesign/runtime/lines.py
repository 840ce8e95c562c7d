"""A program in any language that answers lines of JSON: one to its standard input, one back."""

from __future__ import annotations

import json
import queue
import subprocess
import threading
import weakref
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

from fingerdesign.errors import FingerDesignError
from fingerdesign.runtime.isolate import kill_group

_MOST_BYTES = 1_000_000  # of an answer


class ProgramError(FingerDesignError):
    """A program that did not start, answer in time, or answer in JSON."""


class LineProgram:
    """A running program; it is ended with this object, and its errors go to standard error."""

    def __init__(self, command: Sequence[str], folder: Path, time_s: float = 10.0) -> None:
        """time_s: for each answer. Raises ProgramError where it does not start."""
        self._words, self._time = " ".join(command), time_s
        try:
            self._process = subprocess.Popen(
                list(command),
                cwd=folder,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                bufsize=0,
                start_new_session=True,  # so that what it starts ends with it
            )
        except OSError as error:
            raise self._wrong(f"it does not start: {error}") from None
        self._lines: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        arguments = self._process.stdout, self._lines
        threading.Thread(target=_read, args=arguments, daemon=True).start()
        self.end = weakref.finalize(self, _end, self._process)

    def ask(self, question: Any) -> Any:
        """Its answer, any JSON. Raises ProgramError, and the program is then ended."""
        if not self.end.alive:
            raise self._wrong("it was ended")
        try:
            assert self._process.stdin is not None
            self._process.stdin.write(json.dumps(question, allow_nan=False).encode() + b"\n")
            line = self._lines.get(timeout=self._time)
            if not line:
                raise self._wrong("it ended")
            return json.loads(line)
        except OSError:
            raise self._wrong("it ended") from None
        except queue.Empty:
            raise self._wrong(f"no answer in {self._time:g} s") from None
        except ValueError:
            raise self._wrong(f"no line of JSON: {line[:80]!r}") from None

    def _wrong(self, why: str) -> ProgramError:
        if hasattr(self, "end"):
            self.end()  # a second time it does nothing
        return ProgramError(f"the program `{self._words}`: {why}; try it by hand")


def _read(stream: IO[bytes], lines: queue.SimpleQueue[bytes]) -> None:
    """Hand on lines; an empty one at the end, and for a line that does not end. The stream is
    closed here alone: closed by another thread, a read of it may fail."""
    with stream:
        while line := stream.readline(_MOST_BYTES):
            if not line.endswith(b"\n"):
                break
            lines.put(line)
    lines.put(b"")


def _end(process: subprocess.Popen[bytes]) -> None:
    kill_group(process)
    if process.stdin is not None:
        process.stdin.close()
    process.wait()
