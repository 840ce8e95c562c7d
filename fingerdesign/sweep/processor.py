"""What work costs this process and all that it has started: processor seconds, memory."""

from __future__ import annotations

import contextlib
import os
import resource
from pathlib import Path

_PEAK = Path("/proc/self/clear_refs")


def processor_seconds() -> float:
    """Of this process and of all below it, living or ended, since they began.

    Only differences mean something. The system counts a process that has ended with its parent and
    not before, so the mesher, which stays, is asked itself; each is counted once either way.
    """
    import psutil

    own, ended = (resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    total = own.ru_utime + own.ru_stime + ended.ru_utime + ended.ru_stime
    for child in psutil.Process().children(recursive=True):
        with contextlib.suppress(psutil.Error):  # it ended just now
            times = child.cpu_times()
            total += times.user + times.system + times.children_user + times.children_system
    return total


def forget_peak_memory() -> None:
    """Let the peak of this process's memory count from now on, where the system can (Linux)."""
    with contextlib.suppress(OSError):
        _PEAK.write_text("5", encoding="ascii")


def peak_memory_MB() -> float:
    """Peak of this process's resident memory since :func:`forget_peak_memory`, and what the
    processes that it started and that live take now."""
    import psutil

    total = _own_peak_MB()
    for child in psutil.Process(os.getpid()).children(recursive=True):
        with contextlib.suppress(psutil.Error):
            total += child.memory_info().rss / 2**20
    return total


def _own_peak_MB() -> float:
    with contextlib.suppress(OSError):
        for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
