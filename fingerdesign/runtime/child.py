"""The other end of :mod:`isolate`: a process that answers calls until its input ends.

A message is its length in eight bytes and a pickle. In come calls, (function's name, its pickled
arguments), before them the shared arguments under the name "", if there are any. Out goes for each
call an empty message when it is taken, and then ("done", value), ("raised", error) or ("failed",
(words, machine)).
"""

import contextlib
import os
import pickle
import signal
import struct
import sys
import threading
import time
from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import Any

from fingerdesign.errors import FingerDesignError

HEAD = struct.Struct("<Q")
PARENT = "FINGERDESIGN_PARENT"  # environment variable: the number of the process that started this
ALLOWED = "FINGERDESIGN_ALLOWED_CODE"  # references that files may name; "*": any
MODULES = "FINGERDESIGN_MODULES"  # folders in which it finds what a reference names, too
_WATCH_S = 0.5
_idle_since: list[float] = []  # empty while a call runs


def name_of(function: Callable[..., Any] | str) -> str:
    """ "package.module:function" of a function that another process can import. ValueError else."""
    if isinstance(function, str):
        return function
    name = function.__qualname__
    if "<" in name or function.__module__ == "__main__":
        raise ValueError(f"{function.__module__}:{name} cannot be imported by another process")
    return f"{function.__module__}:{name}"


def resolved(name: str) -> Callable[..., Any]:
    """The function of a name of :func:`name_of`."""
    module, _, path = name.partition(":")
    found: Any = import_module(module)
    for part in path.split("."):
        found = getattr(found, part)
    function: Callable[..., Any] = found
    return function


def die_with_parent() -> None:
    """End this process when the one that started it ends, however that ends (Linux)."""
    if sys.platform == "linux":
        import ctypes

        pr_set_pdeathsig = 1
        ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGKILL)
        if os.environ.get(PARENT, str(os.getppid())) != str(os.getppid()):
            os._exit(1)  # it had ended already (in a container the parent itself may be process 1)


def load_vtk_later() -> None:
    """Load the 150 modules of `vtk` when a name of it is first used. CadQuery imports `vtk` and
    uses no name of it: half of its loading, 1 s of each process."""
    later = ModuleType("vtk")

    def load(name: str) -> Any:
        if sys.modules.get("vtk") is later:
            del sys.modules["vtk"]
        names = vars(import_module("vtk"))
        vars(later).update(names)
        if name not in names:
            raise AttributeError(f"module 'vtk' has no attribute {name!r}")
        return names[name]

    vars(later)["__getattr__"] = load
    sys.modules["vtk"] = later


def serve() -> None:
    """Answer calls. Arguments of the command line: what to load first (a module, or a function to
    call), seconds without a call after which to end; both may be empty."""
    die_with_parent()
    load_vtk_later()
    sys.path += filter(None, os.environ.get(MODULES, "").split(os.pathsep))
    calls, answers = os.fdopen(os.dup(0), "rb"), os.dup(1)
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)  # what a library prints is no answer
    with (
        contextlib.suppress(OSError),
        open("/proc/self/oom_score_adj", "w", encoding="ascii") as score,
    ):
        score.write("500")  # where memory runs out, let Linux end this process, not its parent
    load, idle_s = sys.argv[1], float(sys.argv[2] or "inf")
    threading.Thread(target=_watch, args=(os.getppid(), idle_s), daemon=True).start()
    if ":" in load:
        resolved(load)()
    elif load:
        import_module(load)
    shared: tuple[Any, ...] = ()
    _idle_since.append(time.monotonic())
    while (size := calls.read(HEAD.size)) and len(size) == HEAD.size:
        name, given = pickle.loads(calls.read(*HEAD.unpack(size)))
        if not name:
            shared = pickle.loads(given)
            continue
        _idle_since.clear()
        os.write(answers, HEAD.pack(0))  # taken
        kind, value = _answer(name, given, shared)
        _send(answers, kind, value)
        if kind == "failed":
            return  # who knows in what state
        _idle_since.append(time.monotonic())


def _answer(name: str, given: bytes, shared: tuple[Any, ...]) -> tuple[str, Any]:
    """Answer a call: the kind of its outcome, and the value or error."""
    try:
        positional, named = pickle.loads(given)
        return "done", resolved(name)(*shared, *positional, **named)
    except FingerDesignError as error:
        if _travels(error):
            return "raised", error
        return "failed", (str(error), False)
    except Exception as error:
        machine = isinstance(error, OSError | MemoryError)
        words = " ".join(f"{type(error).__name__}: {error}".split())
        return "failed", (words[:300], machine)


def _travels(error: FingerDesignError) -> bool:
    """Tell whether an error survives pickling."""
    try:
        return str(pickle.loads(pickle.dumps(error, 5))) == str(error)
    except Exception:
        return False


def _send(answers: int, kind: str, value: Any) -> None:
    try:
        content = pickle.dumps((kind, value), 5)
    except Exception as error:
        words = f"its answer cannot be sent: {type(error).__name__}: {error}"[:300]
        content = pickle.dumps(("failed", (words, False)), 5)
    left = memoryview(HEAD.pack(len(content)) + content)
    while left:
        left = left[os.write(answers, left) :]


def _orphaned(parent: int) -> bool:
    if sys.platform == "win32":  # which goes on naming a parent that is gone
        import psutil

        return not psutil.pid_exists(parent)
    return os.getppid() != parent


def _watch(parent: int, idle_s: float) -> None:
    """End this process group once the parent is gone, or for want of calls."""
    while not _orphaned(parent):
        time.sleep(_WATCH_S)
        since = _idle_since[:1]
        if since and time.monotonic() - since[0] > idle_s:
            break
    if hasattr(os, "killpg"):
        os.killpg(0, signal.SIGKILL)
    os._exit(1)
