"""A process for the page's long work: one call at a time, given up at any time."""

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from fingerdesign.runtime.isolate import Function, Worker


class Process:
    """Calls in one process, awaited; it stays warm for ``idle_s`` seconds (None: always)."""

    def __init__(self, name: str, idle_s: float | None = 60.0) -> None:
        self._idle_s = idle_s
        self._worker = Worker(idle_s=idle_s)
        self._thread = ThreadPoolExecutor(1, thread_name_prefix=f"studio-{name}")
        self._calls = 0

    async def call(self, function: Function, *given: Any, time_s: float) -> Any:
        """The answer of ``function``. FingerDesignError where it fails or was given up."""
        worker = self._worker
        self._calls += 1

        def work() -> Any:
            return worker.call(function, *given, time_s=time_s)

        try:
            return await asyncio.get_running_loop().run_in_executor(self._thread, work)
        finally:
            self._calls -= 1

    def give_up(self) -> None:
        """End the work that goes on; the next call has a process of its own."""
        if self._calls:
            self._worker.kill()
            self._worker = Worker(idle_s=self._idle_s)

    def close(self) -> None:
        """End it."""
        self._worker.kill()
        self._thread.shutdown(wait=False, cancel_futures=True)
