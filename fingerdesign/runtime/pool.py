"""Many calls over a few processes.

    with Pool(workers, shared=(bench,)) as pool:
        for outcomes in pool.as_done(run_batch, batches): ...

Each thread of the pool has a process of its own (:class:`isolate.Worker`), which lives from one
call to the next, with one thread of BLAS. With one worker the calls may be made in this process
instead.
"""

import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from functools import partial
from typing import Any, Self, TypeVar

from fingerdesign.runtime.isolate import Function, Worker

Item = TypeVar("Item")
Found = TypeVar("Found")
AHEAD = 2  # items a worker handed over before they are needed: none is idle meanwhile


class Pool:
    """So many processes. A context manager: leaving it waits for the calls that are running, a
    second or two where they are short, and ends the processes; ``kill`` does not wait.

    time_s and memory_MB: limits of one call. The rest as of :class:`isolate.Worker`: ``shared`` is
    given to every function before its own arguments.
    """

    def __init__(
        self,
        workers: int,
        *,
        time_s: float | None = None,
        memory_MB: float | None = None,
        **of_worker: Any,
    ) -> None:
        self.workers, self._time_s, self._memory_MB = workers, time_s, memory_MB
        self._make: Callable[[], Worker] = partial(Worker, threads=1, **of_worker)
        self._own, self._lock = threading.local(), threading.Lock()
        self._all: list[Worker] = []
        self._ended = False
        self._threads = ThreadPoolExecutor(workers)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._threads.shutdown(wait=True, cancel_futures=True)
        for worker in self._all:
            worker.end()

    def call(self, function: Function, *given: Any) -> Any:
        """``function(*shared, *given)`` in the calling thread's process; waits for the answer."""
        return self._worker().call(function, *given, time_s=self._time_s, memory_MB=self._memory_MB)

    def as_done(self, function: Callable[[Item], Found], items: Iterable[Item]) -> Iterator[Found]:
        """Return each item's answer of ``function``, a thread's, in the order in which they come.
        It runs in a thread of this process, and has its work done by :meth:`call`."""
        source, running = iter(items), set[Future[Found]]()
        while True:
            for item in source:
                running.add(self._threads.submit(function, item))
                if len(running) >= AHEAD * self.workers:
                    break
            if not running:
                return
            done, running = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()

    def in_order(self, function: Function, items: Iterable[tuple[Any, ...]]) -> Iterator[Any]:
        """``function(*shared, *item)`` of each item, in their order."""
        waiting = [self._threads.submit(self.call, function, *item) for item in items]
        for future in waiting:
            yield future.result()

    def kill(self) -> None:
        """End all processes, whatever they are doing; calls that are running fail."""
        with self._lock:
            self._ended = True
            found = list(self._all)
        self._threads.shutdown(wait=False, cancel_futures=True)
        for worker in found:
            worker.kill()

    def _worker(self) -> Worker:
        worker: Worker | None = getattr(self._own, "worker", None)
        if worker is None:
            worker = self._own.worker = self._make()
            with self._lock:
                self._all.append(worker)
                if self._ended:
                    worker.kill()
        return worker
