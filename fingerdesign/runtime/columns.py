"""Rows of plain values in a file of columns that grow as they come (SQLite, standard library).

with ColumnWriter(path) as columns:
    columns.add({"name": "one", "metric cost": 3.0})
read_columns(path, ["metric cost"]), read_rows(path, [0])
"""

import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Self

from fingerdesign.errors import FingerDesignError

_TOGETHER = 1000  # rows of one transaction


class ColumnError(FingerDesignError):
    """A file is no file of columns, or cannot be read or written."""


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


class ColumnWriter:
    """Write rows one after another into a new file; a new key adds a column."""

    def __init__(self, path: Path, first: Sequence[str]) -> None:
        self._base = sqlite3.connect(path)
        self._base.execute(f"create table outcomes ({', '.join(map(_quoted, first))})")
        self._known, self.count = set(first), 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._base.commit()
        self._base.close()

    def add(self, row: Mapping[str, Any]) -> None:
        """Write a row; a key that it lacks is null. ColumnError where that fails."""
        try:
            for name in [each for each in row if each not in self._known]:
                self._base.execute(f"alter table outcomes add column {_quoted(name)}")
                self._known.add(name)
            names, marks = ", ".join(map(_quoted, row)), ", ".join("?" * len(row))
            self._base.execute(f"insert into outcomes ({names}) values ({marks})", [*row.values()])
            self.count += 1
            if self.count % _TOGETHER == 0:
                self._base.commit()
        except sqlite3.Error as error:
            raise ColumnError(f"a row cannot be written: {error}") from error


@contextmanager
def _opened(path: Path) -> Iterator[sqlite3.Connection]:
    try:
        with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as base:
            yield base
    except (sqlite3.Error, ValueError, TypeError) as error:
        raise ColumnError(f"{path} holds no columns: {error}") from error


def read_columns(path: Path, names: Sequence[str]) -> list[tuple[Any, ...]]:
    """Values of some columns of every row, in order; None in those that there are not."""
    with _opened(path) as base:
        known = {name for _, name, *_ in base.execute("pragma table_info(outcomes)")}
        picked = ", ".join(_quoted(name) if name in known else "null" for name in names)
        return base.execute(f"select {picked or 'null'} from outcomes order by rowid").fetchall()


def read_rows(path: Path, numbers: Sequence[int]) -> list[dict[str, Any]]:
    """Some rows, numbered from 0, in the order of the numbers."""
    found = []
    with _opened(path) as base:
        for number in numbers:
            cursor = base.execute("select * from outcomes where rowid = ?", [number + 1])
            names = [each[0] for each in cursor.description]
            found.append(dict(zip(names, cursor.fetchone(), strict=True)))
    return found
