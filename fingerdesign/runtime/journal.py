"""Records by key in one file: what long work has done, to go on from when it is run again.

    with Journal(path, "tuning", digest) as journal:
        journal.add({key: {"outcomes": [...]}})
        journal.get(key), dict(journal)

A record is there whole or not at all, whenever the process is killed (SQLite, from the standard
library). identity: the digest of all that decides the records apart from their keys; a journal of
another one, or a file that is none, is refused: it is somebody's work.
"""

import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Self

from fingerdesign.errors import DesignError, Fault, FingerDesignError
from fingerdesign.runtime.files import BusyError, is_full, locked
from fingerdesign.runtime.finite import finite_json

FORMAT = 1
_WAIT_S = 10.0  # for another process that is writing
_HEADER = b"SQLite format 3\x00"
_BUSY = (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED)


class JournalError(FingerDesignError):
    """A journal is in use by another process, or cannot be written."""


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Keep other processes from the journal ``path``, from its reading to its removal. JournalError
    where another process holds it, or its folder cannot be made."""
    with ExitStack() as stack:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            stack.enter_context(locked(path.with_name(f".{path.name}.lock"), wait=False))
        except BusyError as error:
            words = f"{path} is being written by another process"
            raise JournalError(f"{words}; wait for it, or choose another --out") from error
        except OSError as error:
            raise JournalError(f"{path} cannot be written: {error}") from error
        yield


class Journal:
    """Records (plain values, as of JSON) by key, in the order in which they were added.

    The file is made by the first record. A context manager; it may be used without, too. Raises
    JournalError, and DesignError for a file of something else. identity: of the work; None reads a
    journal of any.
    """

    def __init__(self, path: Path, kind: str, identity: str | None) -> None:
        self.path = path
        self._about = {"format": str(FORMAT), "kind": kind}
        if identity is not None:
            self._about["identity"] = identity
        self._base: sqlite3.Connection | None = None
        self._found: dict[str, Any] = {}
        if path.exists():
            self._read()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __contains__(self, key: str) -> bool:
        return key in self._found

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return iter(self._found.items())

    def __len__(self) -> int:
        return len(self._found)

    def get(self, key: str) -> Any:
        """The record of a key; None where there is none."""
        return self._found.get(key)

    def add(self, records: Mapping[str, Any]) -> None:
        """Keep records, all or none, in the place of older ones of their keys."""
        rows = [(key, json.dumps(record, allow_nan=False)) for key, record in records.items()]
        try:
            base = self._base or self._made()
            with base:
                base.executemany("insert or replace into records (key, record) values (?, ?)", rows)
        except (sqlite3.Error, OSError) as error:
            full = _kind(error) == sqlite3.SQLITE_FULL or (
                isinstance(error, OSError) and is_full(error)
            )
            remedy = "; free space there, or choose another --out" if full else ""
            raise JournalError(f"{self.path} cannot be written: {error}{remedy}") from error
        self._found |= records

    def foreign(self, what: str = "") -> DesignError:
        """The refusal of a file that is not ``what``: by default a journal of this kind."""
        what = what or f"a journal of {self._about['kind']}"
        remedy = "move it away, or choose another --out"
        return DesignError([Fault("--out", str(self.path), what, remedy)])

    def close(self) -> None:
        """Let go of the file."""
        if self._base is not None:
            self._base.close()
            self._base = None

    def _made(self) -> sqlite3.Connection:
        """The file, made where it is not there."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        base = sqlite3.connect(self.path, timeout=_WAIT_S, check_same_thread=False)
        try:
            with base:
                base.execute("create table if not exists about (key text primary key, value text)")
                base.execute(
                    "create table if not exists records (key text primary key, record text)"
                )
                base.executemany("insert or ignore into about values (?, ?)", self._about.items())
        except BaseException:
            base.close()
            raise
        self._base = base
        return base

    def _read(self) -> None:
        foreign = self.foreign()
        if not self.path.is_file():
            raise foreign
        try:
            with self.path.open("rb") as stream:
                begun = stream.read(len(_HEADER))
            if begun != _HEADER[: len(begun)]:
                raise foreign
            if not begun:  # it was ended before its first record
                return
            base = self._base = sqlite3.connect(self.path, _WAIT_S, check_same_thread=False)
            about = dict(base.execute("select key, value from about"))
            if any(about.get(key) != self._about[key] for key in ("format", "kind")):
                raise foreign
            own = about["identity"]  # KeyError: it is not whole
            if self._about.get("identity", own) != own:
                raise self.foreign("of this design, setting and version")
            rows = base.execute("select key, record from records order by rowid").fetchall()
            self._found = {str(key): finite_json(record) for key, record in rows}
        except OSError as error:
            raise JournalError(f"{self.path} cannot be read: {error}") from error
        except (sqlite3.Error, ValueError, TypeError, LookupError, RecursionError) as error:
            self.close()
            if _kind(error) in _BUSY:
                busy = f"{self.path} is in use by another process; wait for it"
                raise JournalError(f"{busy}, or choose another --out") from error
            raise foreign from error
        except BaseException:
            self.close()
            raise


def _kind(error: Exception) -> int:
    """SQLite's code of an error, without what it adds of details in the upper bytes."""
    return int(getattr(error, "sqlite_errorcode", 0)) & 0xFF
