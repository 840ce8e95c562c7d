"""C files of this package, compiled once on a machine and cached by content.

    library = compiled(Path(__file__).with_name("kernel.c"))

Where there is no compiler, or FINGERDESIGN_NATIVE is 0, there is no library: what it does is done
in Python as well, and its callers go that way.
"""

import ctypes
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import threading
from functools import cache
from pathlib import Path

from fingerdesign.runtime.cache import Cache

_FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared")
_COMPILERS = ("cc", "gcc", "clang")
_SECONDS = 60.0
_MOST_BYTES = 100_000_000  # of a library: thousands of times what one has
_ONE = threading.Lock()  # who asks while another thread compiles waits for what that makes


def compiled(source: Path) -> ctypes.CDLL | None:
    """The library made of a C file, or None: no compiler, or what it made cannot be loaded."""
    with _ONE:
        return _compiled(source)


@cache
def _compiled(source: Path) -> ctypes.CDLL | None:
    if os.environ.get("FINGERDESIGN_NATIVE") == "0" or sys.platform == "win32":
        return None
    text = source.read_bytes()
    about = repr((_FLAGS, platform.machine(), platform.platform())).encode()
    name = f"{source.stem}-{hashlib.sha256(text + about).hexdigest()[:24]}.so"
    cache = Cache("native", most=40)
    try:
        path = cache.path(name)
        if not _is_whole(path, cache.text(f"{name}.sha256")):
            content = made_library(source)
            if content is None:
                return None
            path = cache.put(name, content)
            cache.put_text(f"{name}.sha256", hashlib.sha256(content).hexdigest())
        return ctypes.CDLL(str(path))
    except OSError:
        return None


def _is_whole(path: Path, digest: str | None) -> bool:
    """Tell whether it is the library of that digest; a garbled one, loaded, would end the
    process."""
    if digest is None or not path.is_file() or path.stat().st_size > _MOST_BYTES:
        return False
    return hashlib.sha256(path.read_bytes()).hexdigest() == digest


def made_library(source: Path, flags: tuple[str, ...] = ()) -> bytes | None:
    """Compile a C file with the first compiler that is found; None without one. flags: added to,
    and after, the usual ones."""
    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    if compiler is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "library.so"
        command = [compiler, *_FLAGS, *flags, str(source), "-o", str(target), "-lm"]
        try:
            subprocess.run(command, check=True, capture_output=True, timeout=_SECONDS)
        except (OSError, subprocess.SubprocessError):
            return None
        return target.read_bytes()
