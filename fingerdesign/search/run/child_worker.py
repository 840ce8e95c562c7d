"""The process that evaluates: ``python -m fingerdesign.search.run.child_worker MODULE:FUNCTION``.

Reads jobs, one JSON line each, from standard input; says that it has taken each, and answers it
with one JSON line, on the pipe that was standard output. It loads what work needs before it says
that it is ready. It ends, with
all that it has started, when its parent is gone, or when no job has come for ten minutes, as on a
cluster whose driver has ended.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from fingerdesign.mesh.section.process import start_mesher
from fingerdesign.search.run.evaluate import Job, evaluate

EVALUATE = "fingerdesign.search.run.child_worker:evaluated"
IDLE_S = 600.0
_WATCH_S = 0.5
_idle_since: list[float] = []  # empty while a job runs


def main(arguments: Sequence[str]) -> int:
    """Answer jobs until standard input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8", buffering=1)
    os.dup2(2, 1)  # what a library prints is no answer
    _offer_to_be_killed()
    parent = os.getppid()
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    module, _, name = arguments[0].partition(":")
    function: Callable[[dict[str, Any]], str] = getattr(import_module(module), name)
    if arguments[0] == EVALUATE:
        _preload()
    answers.write(json.dumps({"ready": os.getpid()}) + "\n")
    _idle_since.append(time.monotonic())
    for line in sys.stdin:
        _idle_since.clear()
        answers.write(json.dumps({"taken": os.getpid()}) + "\n")
        answers.write(function(json.loads(line)) + "\n")
        _idle_since.append(time.monotonic())
    return 0


def evaluated(data: dict[str, Any]) -> str:
    """The outcome of a job, both as plain values."""
    return evaluate(Job.from_data(data)).to_json()


def _preload() -> None:
    """Load what an analysis loads, and the mesher's process: two seconds, once for many jobs."""
    start_mesher()


def _offer_to_be_killed() -> None:
    """Where memory runs out, let Linux end this process, not the study's driver."""
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500", encoding="ascii")


def _end_with(parent: int) -> None:
    """End this process group once the parent is gone, or for want of jobs."""
    while os.getppid() == parent:
        time.sleep(_WATCH_S)
        since = _idle_since[:1]
        if since and time.monotonic() - since[0] > IDLE_S:
            break
    os.killpg(0, signal.SIGKILL)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
