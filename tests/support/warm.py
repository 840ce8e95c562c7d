"""Processes that have loaded what they need: the CAD kernel takes 2 s to load, a half-second's work
is done with it. That a call gets a fresh process is tested with ``runtime.isolate``.
"""

import contextlib
import os
import pickle
import threading
from collections import defaultdict

from fingerdesign.runtime.child import name_of, resolved
from fingerdesign.runtime.isolate import Worker, call

_CACHE, _CURRENT = "FINGERDESIGN_CACHE", "PYTEST_CURRENT_TEST"  # others for each test
_ENDED_S = 1.0  # a call with less time is made to be ended: it gets a fresh process


class _Own(threading.local):
    """The workers of a thread that wait, by their environment and what they have loaded."""

    def __init__(self):
        self.free = defaultdict(list)


class Warm:
    """``call`` and ``concurrently`` of :mod:`fingerdesign.runtime.isolate` by processes that stay:
    for each environment some for the kernel, and some for each other module whose functions they
    run. The cache's folder is sent with each call."""

    def __init__(self):
        self._own = _Own()

    def call(self, function, *given, time_s, memory_MB=None, **named):
        """As ``isolate.call``, but for its folder."""
        if time_s < _ENDED_S:
            return call(function, *given, time_s=time_s, memory_MB=memory_MB, **named)
        with self._worker(function) as worker:
            request = os.environ.get(_CACHE), name_of(function), given, named
            return worker.call(run, *request, time_s=time_s, memory_MB=memory_MB)

    @contextlib.contextmanager
    def concurrently(self, function, *given, time_s):
        """As ``isolate.concurrently``."""
        request = os.environ.get(_CACHE), name_of(function), given, {}
        with self._worker(function) as worker:
            worker.begin(pickle.dumps((name_of(run), pickle.dumps((request, {}), 5)), 5), time_s)
            answered = False

            def answer():
                nonlocal answered
                answered = True
                return worker.answer(None)

            try:
                yield answer
            finally:
                if not answered:
                    worker.end()

    @contextlib.contextmanager
    def _worker(self, function):
        around = ((key, each) for key, each in os.environ.items() if key not in (_CACHE, _CURRENT))
        module = name_of(function).partition(":")[0]
        place = frozenset(around), "cad" if "cad" in module.split(".") else module
        free = self._own.free[place]
        worker = free.pop() if free else Worker(recycled_after=60, idle_s=120.0)
        try:
            yield worker
        finally:
            free.append(worker)


def run(cache, name, given, named):
    """Run a function, there, with the caller's cache."""
    os.environ.pop(_CACHE, None)
    if cache is not None:
        os.environ[_CACHE] = cache
    return resolved(name)(*given, **named)
