"""Cache of this machine: content -> arrays, texts or files.

    cache = Cache("meshes", most=300)
    cache.put_arrays(f"{key}.npz", arrays, about)
    arrays, about = cache.arrays(f"{key}.npz")

An entry is a file named by the digest of all that it was made from, there whole or not at all. One
that a crash or a full disk has garbled is taken for absent. A change of what an entry holds
raises the format number that its name is made from.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import math
import os
import struct
import time
import zipfile
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.errors import FingerDesignError
from fingerdesign.runtime.files import make_private, sibling, writable_by_others, write_whole

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MOST_TEXT = 1_000_000_000  # bytes of a text in the cache: garbage beyond
_OLD_S = 3600.0  # nobody writes a file for so long
# What reading a garbled .npz raises, and using what it holds.
GARBLED = (
    *(OSError, EOFError, KeyError, ValueError, TypeError, IndexError, AttributeError),
    *(zipfile.BadZipFile, zlib.error, struct.error, OverflowError, NotImplementedError),
)


class CacheError(FingerDesignError):
    """Others can write into the cache's folder; the message names it and the remedy."""


def cache_folder(kind: str) -> Path:
    """Return the cache folder of a kind; it need not exist.

    Below that of the environment variable FINGERDESIGN_CACHE, or the platform's cache folder.
    Raises CacheError where others can write into it: what is read from there is believed, and
    compiled files are run.
    """
    if given := os.environ.get("FINGERDESIGN_CACHE"):
        base = Path(given)
    else:
        from platformdirs import user_cache_path

        base = user_cache_path("fingerdesign", appauthor=False)
    if open_folder := writable_by_others((base / kind, base)):
        words = f"other users can write into {open_folder}, where caches and compiled files are"
        remedy = "chmod go-w it, or set FINGERDESIGN_CACHE to a folder of yours"
        raise CacheError(f"{words}; {remedy}")
    return base / kind


@cache
def code_digest(folder: Path) -> str:
    """Digest of the program's files below a folder, by place, size and time: of what is stored by
    it, nothing outlives a change of the code that made it."""
    kinds = (".py", ".c", ".j2", ".toml")
    found = sorted(path for path in folder.rglob("*.*") if path.suffix in kinds)
    stats = [(str(path), path.stat().st_size, path.stat().st_mtime_ns) for path in found]
    return hashlib.sha256(repr(stats).encode()).hexdigest()


class Cache:
    """The files of one kind; names may lie in folders. most (with it, most_MB together): the
    longest unused go first."""

    def __init__(
        self,
        kind: str,
        most: int | None = None,
        folder: Path | None = None,
        most_MB: float = math.inf,
    ) -> None:
        self.folder = cache_folder(kind) if folder is None else folder
        self._most, self._most_MB = most, most_MB

    def path(self, name: str) -> Path:
        """Return the path of a name's entry, whether it exists or not."""
        return self.folder / name

    def put(self, name: str, content: bytes, durable: bool = False) -> Path:
        """Keep an entry in the place of an older one; its path. OSError where that fails."""
        path = self.path(name)
        make_private(path.parent)
        if path.exists() and not path.is_file():  # not ours: out of the way
            path.rename(sibling(path, "older"))
        write_whole(path, content, durable)
        if self._most is not None:
            with contextlib.suppress(OSError):  # another process clears, too
                self._clear_beyond(self._most)
        return path

    def _clear_beyond(self, most: int) -> None:
        """Remove the longest unused of more entries than ``most``, or of more than most_MB."""
        found = [each for each in self.folder.glob("[!.]*") if each.is_file()]
        entries = sorted(((each.stat(), each) for each in found), key=lambda e: -e[0].st_mtime)
        total = 0.0
        for number, (stat, old) in enumerate(entries):
            total += 1e-6 * stat.st_size
            if number >= most or (number and total > self._most_MB):
                old.unlink(missing_ok=True)

    def text(self, name: str, younger_than_s: float | None = None) -> str | None:
        """Read the text of a name; None: nothing, a garbled one, or one that is too old. OSError
        where it is there and cannot be read."""
        path = self.path(name)
        try:
            if younger_than_s is not None:
                age = time.time() - path.stat().st_mtime
                if not 0.0 <= age < younger_than_s:
                    return None
            if not path.is_file() or path.stat().st_size > _MOST_TEXT:  # a pipe never ends
                return None
            digest, _, text = path.read_bytes().decode().partition("\n")
        except (FileNotFoundError, IsADirectoryError, UnicodeDecodeError):
            return None
        return text if digest == _digest(text) else None

    def put_text(self, name: str, text: str, durable: bool = False) -> None:
        """Keep a text, its digest before it. OSError where that fails."""
        self.put(name, f"{_digest(text)}\n{text}".encode(), durable)

    def arrays(self, name: str) -> tuple[dict[str, NDArray[Any]], Any] | None:
        """Read the arrays of a name and the facts about them; None: nothing that can be read."""
        import numpy as np

        path = self.path(name)
        try:
            if not path.is_file():  # a pipe never ends
                return None
            with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
                found = {key: data[key] for key in data.files}
            about = json.loads(str(found.pop("about")))
            os.utime(path)
        except (*GARBLED, MemoryError):  # a header may claim any shape
            return None
        return found, about

    def put_arrays(
        self, name: str, arrays: Mapping[str, NDArray[Any]], about: Any, packed: bool = True
    ) -> bool:
        """Keep arrays, and plain values about them; False where the folder cannot be written.
        packed: compressed, which pays for what is not random in its last digits."""
        import numpy as np

        content = io.BytesIO()
        named: dict[str, Any] = {"about": np.array(json.dumps(about)), **arrays}
        (np.savez_compressed if packed else np.savez)(content, **named)
        try:
            self.put(name, content.getvalue())
        except OSError:
            return False
        return True

    def files(self, name: str) -> dict[str, bytes] | None:
        """Read the files stored under a name, by their own names; None: nothing to be read."""
        path = self.path(name)
        try:
            if not path.is_file():
                return None
            with zipfile.ZipFile(path) as archive:
                return {Path(each).name: archive.read(each) for each in archive.namelist()}
        except GARBLED:
            return None

    def put_files(self, name: str, files: Iterable[Path], packed: bool = True) -> None:
        """Keep copies of files under a name. A folder that cannot be written is no fault."""
        content = io.BytesIO()
        kind = zipfile.ZIP_DEFLATED if packed else zipfile.ZIP_STORED
        with zipfile.ZipFile(content, "w", kind) as archive:
            for path in files:
                archive.write(path, path.name)
        with contextlib.suppress(OSError):
            self.put(name, content.getvalue())

    def clear(self) -> None:
        """Remove what processes that were killed have left half-written; nobody would read it."""
        old = time.time() - _OLD_S
        for path in [*self.folder.glob(".*"), *self.folder.glob("*/.*")]:
            with contextlib.suppress(OSError):
                if path.stat().st_mtime < old:
                    path.unlink()


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def packed(value: Any, arrays: dict[str, Any], name: str = "") -> Any:
    """Dataclasses and pydantic models with their content (arrays, numbers, texts, tuples, dicts,
    None) in JSON's types, as :func:`unpacked` reads them.

    Their arrays are added to ``arrays`` under their dotted path: "contact.points".
    """
    import numpy as np
    from pydantic import BaseModel

    def inner(each: Any, key: object) -> Any:
        return packed(each, arrays, f"{name}.{key}" if name else f"{key}")

    if isinstance(value, np.ndarray):
        name = name or "array"
        arrays[name] = value
        return {"array": name}
    if isinstance(value, BaseModel):
        return {"kind": type(value).__name__, "values": value.model_dump(mode="json")}
    if is_dataclass(value):
        values = {each.name: inner(getattr(value, each.name), each.name) for each in fields(value)}
        return {"kind": type(value).__name__, "values": values}
    if isinstance(value, dict):
        return {"pairs": [[key, inner(each, key)] for key, each in value.items()]}
    if isinstance(value, tuple):
        return [inner(each, place) for place, each in enumerate(value)]
    return value.item() if isinstance(value, np.generic) else value


def unpacked(plain: Any, arrays: Mapping[str, Any], kinds: Mapping[str, type]) -> Any:
    """Unpack what :func:`packed` made, of ``kinds`` by name alone, so that no file can run code.
    Raises one of GARBLED, or RecursionError, where it does not fit."""
    if isinstance(plain, list):
        return tuple(unpacked(each, arrays, kinds) for each in plain)
    if not isinstance(plain, dict):
        return plain
    if "array" in plain:
        return arrays[plain["array"]]
    if "pairs" in plain:
        return {key: unpacked(each, arrays, kinds) for key, each in plain["pairs"]}
    values = {name: unpacked(each, arrays, kinds) for name, each in plain["values"].items()}
    return kinds[plain["kind"]](**values)
