"""A command's own limits on time and memory: what exceeds them is interrupted, as by Ctrl-C.

    with limited(time_s=60.0, memory_MB=None): ...

A thread watches this process and all that it has started; where one of both is over, the main
thread is interrupted (KeyboardInterrupt), so that what is finished is stored, and :func:`reached`
says why. Native code is interrupted where it returns; after GRACE_S more the process ends at once.
"""

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

GRACE_S = 30.0  # from the interruption on, for native code that does not return
_EVERY_S = 0.1
_reached: list[str] = []


def reached() -> str:
    """Which limit has ended the work, in words; empty where none has."""
    return _reached[-1] if _reached else ""


def forget() -> None:
    """Another command begins: no limit has been reached."""
    _reached.clear()


@contextmanager
def limited(
    time_s: float | None = None,
    memory_MB: float | None = None,
    end: Callable[[], None] | None = None,
) -> Iterator[None]:
    """Interrupt the block where it takes longer, or more memory. end: instead of interrupting. The
    block is to be in the main thread."""
    over = threading.Event()
    given = (time_s, memory_MB, over, end or _interrupt)
    watch = threading.Thread(target=_watch, args=given, daemon=True)
    watch.start()
    try:
        yield
    finally:
        over.set()


def _watch(
    time_s: float | None, memory_MB: float | None, over: threading.Event, end: Callable[[], None]
) -> None:
    start = time.monotonic()
    while not over.wait(_EVERY_S):
        words = ""
        if time_s is not None and time.monotonic() - start > time_s:
            words = f"--time-limit = {time_s:g} s is over"
        elif memory_MB is not None and (used := family_memory_MB(os.getpid())) > memory_MB:
            words = f"{used:.0f} MB were taken, more than --memory-limit = {memory_MB:g} MB"
        if words:
            _reached.append(words)
            end()
            if not over.wait(GRACE_S):
                os._exit(1)
            return


def _interrupt() -> None:
    if sys.platform == "win32":  # there os.kill ends the process
        import _thread

        _thread.interrupt_main(signal.SIGINT)
        return
    # What shells start in the background ignores SIGINT; the program takes SIGTERM for the same.
    handled = callable(signal.getsignal(signal.SIGTERM))
    os.kill(os.getpid(), signal.SIGTERM if handled else signal.SIGINT)


def family_memory_MB(leader: int) -> float:
    """Resident memory of a process and of all that it has started, MB. Not its address space: MKL
    and the CAD kernel reserve what they never touch."""
    import psutil

    total = 0
    for each in family_of(leader):
        with contextlib.suppress(psutil.Error):
            total += each.memory_info().rss
    return total / 1e6


def family_of(leader: int) -> list[Any]:
    """A process and all that it has started, as psutil has them; none where it is gone."""
    import psutil

    try:
        process = psutil.Process(leader)
        return [process, *process.children(recursive=True)]
    except psutil.Error:
        return []
