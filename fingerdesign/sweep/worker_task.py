"""What a Dask worker does with a job: hand it to a child process, and hand back what comes of it.

Each thread of a worker has a child of its own, kept from one job to the next. Text goes in and out,
so that a worker needs nothing of a study but this package.
"""

from __future__ import annotations

import json
import threading
from typing import Any

from fingerdesign.sweep.child import Child, ChildFailed

TRIES = 3  # of a job whose process somebody ended: the system for want of memory, or a user
_CHILDREN: dict[tuple[str, int], Child] = {}  # by pool and thread
_ENDED: set[str] = set()
_LOCK = threading.Lock()


def task_text(
    data: dict[str, Any], evaluator: str, time_s: float, memory_MB: float, pool: str = ""
) -> str:
    """A job as :func:`work` takes it; ``pool`` tells children of one process apart."""
    task = {"data": data, "evaluator": evaluator, "time_s": time_s, "memory_MB": memory_MB}
    return json.dumps(task | {"pool": pool}, allow_nan=False)


def work(text: str) -> str:
    """One job of :func:`task_text`; JSON {"outcome": its line} or {"failure": [kind, sentence]}."""
    task = json.loads(text)
    for tried in range(1, TRIES + 1):
        child = _child(task["pool"], task["evaluator"])
        try:
            line = child.run(task["data"], task["time_s"], task["memory_MB"])
        except ChildFailed as error:
            if error.ended_by_others and tried < TRIES and task["pool"] not in _ENDED:
                continue
            again = f", tried {tried} times" if tried > 1 else ""
            return json.dumps({"failure": [error.kind, f"{error}{again}"]})
        return json.dumps({"outcome": line})
    raise AssertionError("unreachable")


def end_pool(pool: str) -> None:
    """Kill the children of a pool, whatever they are doing; no more are started in it."""
    with _LOCK:
        _ENDED.add(pool)
        found = [child for (name, _), child in _CHILDREN.items() if name == pool]
    for child in found:
        child.kill()


def forget_pool(pool: str) -> None:
    """Clear away the children of a pool that was ended, once no thread uses them any more."""
    with _LOCK:
        found = [key for key in _CHILDREN if key[0] == pool]
        children = [_CHILDREN.pop(key) for key in found]
    for child in children:
        child.end()


def _child(pool: str, evaluator: str) -> Child:
    """This thread's child."""
    key = (pool, threading.get_ident())
    with _LOCK:
        if pool in _ENDED:
            return Child(evaluator, ended=True)
        child = _CHILDREN.get(key)
        if child is not None and child.evaluator == evaluator:
            return child
        new = _CHILDREN[key] = Child(evaluator)
    if child is not None:
        child.end()
    return new
