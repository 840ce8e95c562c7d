"""Outcomes as CSV for pandas and spreadsheets: a row a design, an increment, a step of a grip.

Numbers are exact, an empty cell has no value, a line is one row. Texts are without control
characters, and those that a spreadsheet would take for a formula begin with an apostrophe.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Iterator, Sequence
from itertools import zip_longest
from typing import Any

from fingerdesign.sweep.outcome import Outcome
from fingerdesign.sweep.plain_text import cell_text

_FACTS = ("name", "digest", "scene", "fidelity", "status")
_WORK = ("seconds", "core_seconds", "peak_memory_MB")
_PATH = (
    *("approach_mm", "shear_mm", "normal_force_N", "tangential_force_N", "stick_ratio"),
    "contact_width_mm",
)


def designs_csv(outcomes: Sequence[Outcome]) -> str:
    """A row an outcome, in order: facts, studied values by their keys, metrics, validity, work.

    A metric that has the name of a fact of the work (core_seconds) stands once, as the fact.
    """
    keys = dict.fromkeys(key for outcome in outcomes for key in outcome.values)
    metrics = dict.fromkeys(
        name for outcome in outcomes for name in outcome.metrics if name not in _WORK
    )
    checks = [name for name in ("plane_strain_error", "mesh_error") if name not in metrics]
    header = [*_FACTS, "failure_kind", "failure", *keys, *metrics, *checks, *_WORK]
    rows = (
        [
            *(getattr(outcome, name) for name in _FACTS),
            *(("", "") if outcome.failure is None else _failure(outcome)),
            *(outcome.values.get(key) for key in keys),
            *(outcome.metrics.get(name) for name in metrics),
            *(getattr(outcome.validity, name) for name in checks),
            *(getattr(outcome, name) for name in _WORK),
        ]
        for outcome in outcomes
    )
    return _text(header, rows)


def increments_csv(outcomes: Sequence[Outcome]) -> str:
    """A row an increment of every outcome's path, with its gages' readings, microstrain."""
    most = max((len(o.traces.gage_x_mm) for o in outcomes), default=0)
    gages = [f"gage_{number}_microstrain" for number in range(most)]
    header = ["name", "digest", "increment", *_PATH, *gages]
    return _text(header, (row for outcome in outcomes for row in _increments(outcome, most)))


def grips_csv(outcomes: Sequence[Outcome]) -> str:
    """A row a kept step of every grip: forces beside the grip's own facts."""
    facts = ("controller", "friction_coefficient", "object_mass_g", "lifted", "gross_slip")
    forces = ("normal_force_N", "tangential_force_N")
    header = ["name", "digest", "grip", *facts, "safety_margin", "step", *forces]
    rows = (
        [
            *(outcome.name, outcome.digest, number, *(getattr(grip, fact) for fact in facts)),
            *(grip.safety_margin, step, normal, tangential),
        ]
        for outcome in outcomes
        for number, grip in enumerate(outcome.grips)
        for step, (normal, tangential) in enumerate(
            zip_longest(grip.normal_force_N, grip.tangential_force_N)
        )
    )
    return _text(header, rows)


def _failure(outcome: Outcome) -> tuple[str, str]:
    return (outcome.failure.kind, outcome.failure.sentence) if outcome.failure else ("", "")


def _increments(outcome: Outcome, gages: int) -> Iterator[list[Any]]:
    traces = outcome.traces
    for number in range(len(traces.normal_force_N)):
        path = (getattr(traces, name) for name in _PATH)
        readings = traces.gages[number] if number < len(traces.gages) else ()
        yield [
            *(outcome.name, outcome.digest, number + 1),
            *(column[number] if number < len(column) else None for column in path),
            *readings,
            *[None] * (gages - len(readings)),
        ]


def _text(header: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([cell_text(name) for name in header])
    for row in rows:
        writer.writerow([_cell(value) for value in row])
    return stream.getvalue()


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    if isinstance(value, bool | int | float):
        return value
    return cell_text(value if isinstance(value, str) else json.dumps(value))
