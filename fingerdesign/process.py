"""Run a module of this package in a process of its own, with a time limit; where files are kept.

Native code (CAD kernel, mesher, graphics) can crash or hang; there it harms nobody.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

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
    root = str(Path(__file__).resolve().parents[1])
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


def cache_folder(kind: str) -> Path:
    """The folder that files of a kind are kept in; it need not exist.

    Below that of the environment variable FINGERDESIGN_CACHE, or the platform's cache folder.
    """
    given = os.environ.get("FINGERDESIGN_CACHE")
    if given:
        return Path(given) / kind
    from platformdirs import user_cache_path

    return user_cache_path("fingerdesign", appauthor=False) / kind
