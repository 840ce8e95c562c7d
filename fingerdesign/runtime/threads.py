"""Threads of this process: of BLAS, and of calls in compiled code, without Python's lock."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager
from contextvars import copy_context
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

Item = TypeVar("Item")
Found = TypeVar("Found")
# Each call in work holds its arrays, and Python's lock at times: more threads would gain little.
_MOST = 4
_found: tuple[int, ThreadpoolController] | None = None  # and how many modules were loaded then


def blas_libraries() -> ThreadpoolController:
    """The BLAS libraries that are loaded. To look through all libraries takes 10 ms: it is done
    again only where a module has been imported since, for none is loaded otherwise."""
    global _found
    from threadpoolctl import ThreadpoolController

    if _found is None or _found[0] != len(sys.modules):
        _found = len(sys.modules), ThreadpoolController().select(user_api="blas")
    return _found[1]


def one_thread() -> AbstractContextManager[object]:
    """One BLAS thread: contact solves are small, and threads that wait for each other cost far more
    than they save as soon as another process wants the cores (measured: 70 times)."""
    limit: AbstractContextManager[object] = blas_libraries().limit(limits=1)
    return limit


def in_threads(function: Callable[[Item], Found], items: Iterable[Item]) -> Iterator[Found]:
    """``function(item)`` of each item, in their order, in as many threads as BLAS may use here, but
    no more than four.

    Each has one thread of BLAS: answers have the same bits for any number of threads. One item more
    than there are threads is taken ahead of the answers. An error of a call is raised in its turn.
    Calls see the caller's context variables.
    """
    libraries = blas_libraries()
    threads = min(max((each["num_threads"] for each in libraries.info()), default=1), _MOST)
    with libraries.limit(limits=1):
        if threads == 1:
            yield from map(function, items)
            return
        with ThreadPoolExecutor(threads) as pool:
            waiting = deque[Future[Found]]()
            for item in items:
                waiting.append(pool.submit(copy_context().run, function, item))
                if len(waiting) > threads:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
