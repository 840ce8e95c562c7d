"""Outcomes of a large study in columns: an SQLite file, a row an outcome of at most 2 kB.

    with ColumnWriter(path) as columns:
        columns.add(outcome)
    table = read_columns(path, ["cost", "peak_ratio"])
    outcomes = outcomes_at(path, [0, 7])

Columns of the table ``outcomes``: those of FACTS, "value KEY" of each studied key, "metric NAME" of
each metric. Designs, traces and grips are left out; a design is its study's base with the row's
values. For pandas: ``pandas.read_sql("select * from outcomes", sqlite3.connect(path))``.
"""

import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Self

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.records.base import ResultError
from fingerdesign.records.outcome import Failure, Outcome, Validity

FACTS = (
    *("name", "digest", "scene", "fidelity", "status", "failure_kind", "failure"),
    *("plane_strain_error", "mesh_error", "seconds", "core_seconds", "peak_memory_MB"),
)
VALUE, METRIC = "value ", "metric "
MOST_FAILURE = 400  # characters of a failure's sentence
_TOGETHER = 1000  # rows to a transaction: a killed run loses no more, and its store has them


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


class ColumnWriter:
    """Write outcomes one after another; a key or metric that is new adds a column."""

    def __init__(self, path: Path) -> None:
        self._base = sqlite3.connect(path)
        names = ", ".join(_quoted(name) for name in FACTS)
        self._base.execute(f"create table outcomes ({names})")
        self._known = list(FACTS)
        self.kinds: dict[str, int] = {}  # number of outcomes: "ok", or by the kind of failure

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._base.commit()
        self._base.close()

    @property
    def count(self) -> int:
        """Number of rows written."""
        return sum(self.kinds.values())

    def add(self, outcome: Outcome) -> None:
        """Write a row."""
        failure = outcome.failure or Failure("failed", "")
        row: dict[str, Any] = {name: getattr(outcome, name, None) for name in FACTS}
        row |= {"failure_kind": None, "failure": None}
        if outcome.failure is not None:
            row |= {"failure_kind": failure.kind, "failure": failure.sentence[:MOST_FAILURE]}
        row |= {name: getattr(outcome.validity, name) for name in ("plane_strain_error",)}
        row |= {"mesh_error": outcome.validity.mesh_error}
        row |= {VALUE + key: _cell(value) for key, value in outcome.values.items()}
        row |= {METRIC + name: value for name, value in outcome.metrics.items()}
        for name in row.keys() - set(self._known):
            self._base.execute(f"alter table outcomes add column {_quoted(name)}")
            self._known.append(name)
        names = ", ".join(map(_quoted, row))
        marks = ", ".join("?" * len(row))
        self._base.execute(f"insert into outcomes ({names}) values ({marks})", [*row.values()])
        kind = "ok" if outcome.failure is None else failure.kind
        self.kinds[kind] = self.kinds.get(kind, 0) + 1
        if self.count % _TOGETHER == 0:
            self._base.commit()


def _cell(value: Any) -> Any:
    """A studied value as SQLite keeps it: numbers as such, all else as JSON."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return value if number else json.dumps(value)


@contextmanager
def _opened(path: Path) -> Iterator[sqlite3.Connection]:
    """Open for reading alone. Raises ResultError for what is no such file."""
    try:
        with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as base:
            yield base
    except (sqlite3.Error, ValueError, TypeError) as error:
        raise ResultError(f"{path} holds no outcomes in columns: {error}") from error


def read_columns(path: Path, metrics: Sequence[str]) -> tuple[Array, Array]:
    """Metrics of every row (rows, metrics), NaN where one has none; and True where it is good.

    Raises ResultError for what is no such file.
    """
    with _opened(path) as base:
        known = {name for _, name, *_ in base.execute("pragma table_info(outcomes)")}
        wanted = [METRIC + name if METRIC + name in known else None for name in metrics]
        names = ", ".join("null" if name is None else _quoted(name) for name in wanted)
        rows = base.execute(f"select status = 'ok', {names or 'null'} from outcomes").fetchall()
    table = np.array(rows, dtype=float).reshape(len(rows), -1)
    return table[:, 1 : 1 + len(metrics)], table[:, 0] == 1.0


def outcomes_at(path: Path, rows: Sequence[int]) -> tuple[Outcome, ...]:
    """The outcomes of some rows, numbered from 0, in their order; what columns hold of them.

    Raises ResultError for what is no such file.
    """
    found = []
    with _opened(path) as base:
        for number in rows:
            cursor = base.execute("select * from outcomes where rowid = ?", [number + 1])
            names = [each[0] for each in cursor.description]
            found.append(_outcome(dict(zip(names, cursor.fetchone(), strict=True))))
    return tuple(found)


def _outcome(row: dict[str, Any]) -> Outcome:
    kind, sentence = row["failure_kind"], row["failure"]
    values = {key: value for key, value in row.items() if key.startswith(VALUE)}
    return Outcome(
        digest=row["digest"],
        name=row["name"],
        values={
            key.removeprefix(VALUE): json.loads(value) if isinstance(value, str) else value
            for key, value in values.items()
            if value is not None
        },
        design={},
        scene=row["scene"],
        fidelity=row["fidelity"],
        status=row["status"],
        failure=None if kind is None else Failure(kind, sentence),
        metrics={
            key.removeprefix(METRIC): value
            for key, value in row.items()
            if key.startswith(METRIC) and row["status"] == "ok"
        },
        validity=Validity(row["plane_strain_error"], row["mesh_error"]),
        seconds=row["seconds"],
        core_seconds=row["core_seconds"],
        peak_memory_MB=row["peak_memory_MB"],
    )
