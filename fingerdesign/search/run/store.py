"""Outcomes on disk by digest: whole or absent, shared by all studies of a user.

One file an outcome, in a folder by the digest's first two digits. A file is written aside, flushed
to the disk and renamed; it holds the checksum of its content, so that one that a crash or a full
disk has invalid is taken for absent. Nothing but the driver of a study writes here.
"""

from __future__ import annotations

import re
from pathlib import Path

from fingerdesign.errors import FingerDesignError
from fingerdesign.records.outcome import Outcome, OutcomeError
from fingerdesign.runtime.cache import Cache

_DIGEST = re.compile(r"[0-9a-f]{64}")
# Another machine, or another day, may fare better; "failed": as where a mesher ran out of time.
TRANSIENT = ("crashed", "timeout", "memory", "failed")


class StoreError(FingerDesignError):
    """An outcome cannot be kept: no room, no right; nothing half is left."""


class Store:
    """Outcomes in ``folder``; by default the user's own store."""

    def __init__(self, folder: Path | None = None) -> None:
        self._kept = Cache("outcomes", folder=folder)
        self.folder = self._kept.folder

    def get(self, digest: str, retry: bool = False) -> Outcome | None:
        """The outcome kept under a digest; None where there is none, or only a invalid one.

        retry: neither one that failed but was not refused.
        """
        name = _name(digest)
        try:
            line = self._kept.text(name)
        except OSError as error:
            raise StoreError(f"{self._kept.path(name)} cannot be read: {error}") from error
        if line is None:
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
        try:
            self._kept.put_text(_name(outcome.digest), outcome.to_json(), durable=True)
        except OSError as error:
            raise StoreError(f"an outcome cannot be kept in {self.folder}: {error}") from error

    def clear(self) -> None:
        """Remove what drivers that were killed have left half-written; nobody would read it."""
        self._kept.clear()


def _name(digest: str) -> str:
    if not _DIGEST.fullmatch(digest):
        raise ValueError(f"{digest!r} is no digest")
    return f"{digest[:2]}/{digest}.txt"
