"""Outcomes on disk by digest: whole or absent, shared by all studies of a user.

One file an outcome, in a folder by the digest's first two digits. A file is written aside, flushed
to the disk and renamed; it holds the checksum of its content, so that one that a crash or a full
disk has spoiled is taken for absent. Nothing but the driver of a study writes here.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import secrets
import time
from pathlib import Path

from fingerdesign.errors import FingerDesignError
from fingerdesign.records.outcome import Outcome, OutcomeError
from fingerdesign.runtime.cache import cache_folder

_DIGEST = re.compile(r"[0-9a-f]{64}")
# Another machine, or another day, may fare better; "failed": as where a mesher ran out of time.
TRANSIENT = ("crashed", "timeout", "memory", "failed")
_OLD_S = 3600.0  # nobody writes a file for so long


class StoreError(FingerDesignError):
    """An outcome cannot be kept: no room, no right; nothing half is left."""


class Store:
    """Outcomes in ``folder``; by default the user's own store."""

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = cache_folder("outcomes") if folder is None else folder

    def get(self, digest: str, retry: bool = False) -> Outcome | None:
        """The outcome kept under a digest; None where there is none, or only a spoiled one.

        retry: neither one that failed but was not refused.
        """
        try:
            text = self._path(digest).read_text(encoding="utf-8")
        except (FileNotFoundError, IsADirectoryError, UnicodeDecodeError):
            return None
        except OSError as error:
            raise StoreError(f"{self._path(digest)} cannot be read: {error}") from error
        sum_, _, line = text.partition("\n")
        if sum_ != _sum_of(line):
            return None
        try:
            found = Outcome.from_json(line)
        except OutcomeError:  # of another version of this format
            return None
        if found.digest != digest:
            return None
        transient = found.failure is not None and found.failure.kind in TRANSIENT
        return None if retry and transient else found

    def put(self, outcome: Outcome) -> None:
        """Keep an outcome, in the place of an older one. StoreError where that fails."""
        path = self._path(outcome.digest)
        line = outcome.to_json()
        aside = path.with_name(f".{secrets.token_hex(6)}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with aside.open("x", encoding="utf-8") as stream:
                stream.write(f"{_sum_of(line)}\n{line}")
                stream.flush()
                os.fsync(stream.fileno())
            if path.is_dir():  # not ours: out of the way
                path.rename(path.with_name(f"{path.name}.{secrets.token_hex(6)}"))
            os.replace(aside, path)
        except OSError as error:
            raise StoreError(f"an outcome cannot be kept in {self.folder}: {error}") from error
        finally:
            with contextlib.suppress(OSError):
                aside.unlink(missing_ok=True)

    def clear(self) -> None:
        """Remove what drivers that were killed have left half-written; nobody would read it."""
        old = time.time() - _OLD_S
        for path in self.folder.glob("??/.*"):
            with contextlib.suppress(OSError):
                if path.stat().st_mtime < old:
                    path.unlink()

    def _path(self, digest: str) -> Path:
        if not _DIGEST.fullmatch(digest):
            raise ValueError(f"{digest!r} is no digest")
        return self.folder / digest[:2] / f"{digest}.txt"


def _sum_of(line: str) -> str:
    return hashlib.sha256(line.encode()).hexdigest()
