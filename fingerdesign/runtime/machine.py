"""Capacity of this machine: arithmetic a second, cores, free memory."""

import contextlib
import functools
import hashlib
import json
import os
import platform
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from fingerdesign.runtime.cache import Cache

if sys.platform != "win32":
    import resource

_SIZE, _REPEATS = 512, 3  # Size and number of the matrix products: 0.03 s in all.
_VALID_S = 86_400.0  # A measured speed is valid for a day.
_CGROUP = Path("/sys/fs/cgroup")
_UNLIMITED = 1 << 60  # Bytes that cgroups report where there is no limit.

_PEAK = Path("/proc/self/clear_refs")


def processor_seconds() -> float:
    """Return the processor time of this process and of all that it started, since they began, s.

    Only differences mean something. The system counts a process that has ended with its parent and
    not before, so the mesher, which stays, is measured itself; each is counted once either way.
    """
    import psutil

    ended = os.times()
    total = time.process_time() + ended.children_user + ended.children_system
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


def largest_memory_MB() -> float:
    """Largest resident memory of this process or of one that it started, since they began. Not by
    the system's count of this process, which begins with what its parent had."""
    return max(_own_peak_MB(), _largest_MB(children=True))


def _largest_MB(children: bool = False) -> float:
    """Return the peak of this process, or of ended ones that it started (0 on Windows)."""
    if sys.platform == "win32":
        import psutil

        return 0.0 if children else float(psutil.Process().memory_info().peak_wset) / 2**20
    else:
        whose = resource.RUSAGE_CHILDREN if children else resource.RUSAGE_SELF
        unit = 2**20 if sys.platform == "darwin" else 1024  # bytes there, kilobytes elsewhere
        return resource.getrusage(whose).ru_maxrss / unit


def _own_peak_MB() -> float:
    with contextlib.suppress(OSError):
        for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) / 1024.0
    return _largest_MB()


@dataclass(frozen=True)
class Machine:
    """one_core, all_cores: double-precision matrix products, GFLOP/s, on one core and on ``cores``;
    cores: how many this process may use."""

    one_core: float
    all_cores: float
    cores: int


@functools.cache
def this_machine() -> Machine:
    """The machine as measured once a process, or within the last day by another one."""
    cache, name = Cache("machines"), _name()
    known = _read(cache, name)
    if known is not None:
        return known
    found = measure_machine()
    if not busy(found.cores):
        with contextlib.suppress(OSError):  # not to be written: measured again next time
            cache.put_text(name, json.dumps(asdict(found)))
    return found


def busy(cores: int) -> bool:
    """Tell whether more processes want to run than there are cores: speeds measured now are not the
    machine's."""
    return hasattr(os, "getloadavg") and os.getloadavg()[0] > cores


def measure_machine() -> Machine:
    """Measure now: concurrent work counts. A twentieth of a second."""
    from threadpoolctl import threadpool_limits

    cores = usable_cores()
    with threadpool_limits(limits=1, user_api="blas"):
        one = _gigaflops()
    if cores == 1:
        return Machine(one, one, 1)
    with threadpool_limits(limits=cores, user_api="blas"):
        every = _gigaflops()
    return Machine(one, max(every, one), cores)


def _gigaflops() -> float:
    """Median speed of a few products: one that is interrupted does not count."""
    a = np.random.default_rng(0).random((_SIZE, _SIZE))
    a @ a
    seconds = []
    for _ in range(_REPEATS):
        start = time.perf_counter()
        a @ a
        seconds.append(time.perf_counter() - start)
    return float(2e-9 * _SIZE**3 / np.median(seconds))


def usable_cores() -> int:
    """Cores that this process may use: its affinity, and the quota of its control group."""
    if hasattr(os, "sched_getaffinity"):
        cores = len(os.sched_getaffinity(0))
    else:
        cores = os.cpu_count() or 1
    quota = _quota()
    return max(1, min(cores, cores if quota is None else round(quota)))


def _quota() -> float | None:
    """Cores that the control group grants; None without a limit."""
    with contextlib.suppress(OSError, ValueError):
        given, period = (_CGROUP / "cpu.max").read_text("ascii").split()
        return None if given == "max" else int(given) / int(period)
    with contextlib.suppress(OSError, ValueError):
        given = (_CGROUP / "cpu/cpu.cfs_quota_us").read_text("ascii")
        period = (_CGROUP / "cpu/cpu.cfs_period_us").read_text("ascii")
        return None if int(given) <= 0 else int(given) / int(period)
    return None


def available_memory_MB() -> float | None:
    """Memory that can be had now without swapping, within the control group's limit; None where
    the system does not tell."""
    import psutil

    found = []
    with contextlib.suppress(psutil.Error, OSError):
        found.append(float(psutil.virtual_memory().available))
    for limit, used in (
        ("memory.max", "memory.current"),
        ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes"),
    ):
        with contextlib.suppress(OSError, ValueError):
            most = int((_CGROUP / limit).read_text("ascii"))
            if most < _UNLIMITED:
                found.append(float(most - int((_CGROUP / used).read_text("ascii"))))
    return max(0.0, min(found)) / 2**20 if found else None


def _name() -> str:
    """Return the key of this machine's speed: its name, processor, cores and numpy."""
    about = [platform.node(), platform.machine(), platform.processor(), str(usable_cores())]
    return hashlib.sha256("\n".join([*about, np.__version__]).encode()).hexdigest()[:16]


def _read(cache: Cache, name: str) -> Machine | None:
    try:
        found = Machine(**json.loads(cache.text(name, younger_than_s=_VALID_S) or ""))
        sound = min(found.one_core, found.all_cores) > 0.0 and found.cores == usable_cores()
    except (OSError, ValueError, TypeError):
        return None
    return found if sound else None
