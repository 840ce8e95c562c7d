"""Outcomes of a large study in columns: an SQLite file, a row an outcome of at most 2 kB.

Columns of the table ``outcomes``: those of FACTS, "value KEY" of each studied key, "metric NAME" of
each metric. Designs, traces and grips are left out; a design is its study's base with the row's
values. For pandas: ``pandas.read_sql("select * from outcomes", sqlite3.connect(path))``.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.records.outcome import CHECKS, OWN, WORK, Failure, Outcome, Validity
from fingerdesign.runtime.columns import read_columns, read_rows

FACTS = (*OWN, "failure_kind", "failure", *CHECKS, *WORK)
VALUE, METRIC = "value ", "metric "
MOST_FAILURE = 400  # characters of a failure's sentence


def row_of(outcome: Outcome) -> dict[str, Any]:
    """The row of an outcome."""
    failure = outcome.failure
    return {
        **{name: getattr(outcome, name) for name in (*OWN, *WORK)},
        **{name: getattr(outcome.validity, name) for name in CHECKS},
        "failure_kind": None if failure is None else failure.kind,
        "failure": None if failure is None else failure.sentence[:MOST_FAILURE],
        **{VALUE + key: _cell(value) for key, value in outcome.values.items()},
        **{METRIC + name: value for name, value in outcome.metrics.items()},
    }


def _cell(value: Any) -> Any:
    """A studied value as the file holds it: numbers as such, all else as JSON."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return value if number else json.dumps(value)


def metrics_at(path: Path, metrics: Sequence[str]) -> tuple[Array, BoolArray]:
    """Metrics of every row (rows, metrics), NaN where one has none; and which rows are good. Raises
    ColumnError for what is no such file."""
    rows = read_columns(path, ["status", *(METRIC + name for name in metrics)])
    table = np.array([row[1:] for row in rows], dtype=float).reshape(len(rows), len(metrics))
    return table, np.array([row[0] == "ok" for row in rows], dtype=bool)


def outcomes_at(path: Path, rows: Sequence[int]) -> tuple[Outcome, ...]:
    """The outcomes of some rows, numbered from 0, in their order; what columns hold of them. Raises
    ColumnError for what is no such file."""
    return tuple(map(_outcome, read_rows(path, rows)))


def _outcome(row: dict[str, Any]) -> Outcome:
    values = {
        key.removeprefix(VALUE): json.loads(value) if isinstance(value, str) else value
        for key, value in row.items()
        if key.startswith(VALUE) and value is not None
    }
    metrics = {k.removeprefix(METRIC): v for k, v in row.items() if k.startswith(METRIC)}
    kind = row["failure_kind"]
    return Outcome(
        **{name: row[name] for name in (*OWN, *WORK)},
        values=values,
        design={},
        failure=None if kind is None else Failure(kind, row["failure"]),
        metrics=metrics if row["status"] == "ok" else {},
        validity=Validity(*(row[name] for name in CHECKS)),
    )
