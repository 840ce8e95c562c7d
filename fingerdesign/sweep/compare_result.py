"""A result of `analyse` as an outcome, so that single analyses stand beside studies."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from fingerdesign.design.layout import plate_frames
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.result_folder import read_result
from fingerdesign.results import Analysis, GripResult, Result, ResultError
from fingerdesign.sweep.measured import grip_metrics, metrics_of, traces_of
from fingerdesign.sweep.outcome import (
    Failure,
    GripOutcome,
    Numbers,
    Outcome,
    OutcomeError,
    Traces,
    Validity,
    bounded,
)
from fingerdesign.sweep.study_file import Cost

MOST_POINTS = 60  # of a grip's path, as in every outcome
_SCENE = "scene."
_WRONG = (ValueError, TypeError, AttributeError)


def outcome_of_result(folder: Path) -> Outcome:
    """The outcome that a result folder tells of: metrics of its grips and of its path's end.

    What the record does not hold is left out: contact maps, and metrics that ask for the model
    (the gage error of the stick ratio). Raises DesignError for what is no result.
    """
    try:
        result = read_result(folder)
    except ResultError as error:
        fault = Fault("RESULT", folder, "a result that can be read", str(error))
        raise DesignError([fault]) from error
    try:
        found = _outcome_of(result, folder)
        Outcome.from_json(found.to_json())  # nor numbers that no page could bear
        return found
    except DesignError:
        raise
    except (OutcomeError, ArithmeticError, LookupError, RecursionError, *_WRONG) as error:
        why = f"{type(error).__name__}: {error}"[:200]
        bound = "a result whose numbers can be compared"
        raise DesignError([Fault("RESULT", folder, bound, f"{why}; run analyse again")]) from error


def _outcome_of(result: Result, folder: Path) -> Outcome:
    failed = result.status == "failed"
    data = _design(result)
    design = None if failed else _read_design(data)
    return Outcome(
        digest=result.digest,
        name=result.design,
        values={},
        design=data,
        scene=result.scene,
        fidelity=result.fidelity,
        status=result.status,
        failure=Failure("failed", result.failure or "") if failed else None,
        metrics={} if failed else _metrics(result, design),
        traces=_traces(result, design),
        grips=tuple(_grip(grip, folder) for grip in result.grips),
        validity=_validity(result),
        warnings=result.warnings,
        versions=result.versions,
        seeds=result.seeds,
        seconds=sum(result.timings_s.values()),
        peak_memory_MB=result.peak_memory_MB,
    )


def _design(result: Result) -> dict[str, Any]:
    """The design's tables from the dotted keys of the record."""
    design: dict[str, Any] = {}
    for key, value in result.parameters.items():
        if key.startswith(_SCENE) or value is None:
            continue
        *tables, last = key.split(".")
        place = design
        for table in tables:
            place = place.setdefault(table, {})
        place[last] = value
    if result.assumed:
        design["assumed"] = list(result.assumed)
    return design


def _metrics(result: Result, design: Design | None) -> dict[str, float | None]:
    """As every outcome's, of what the record holds; no cost, since no prices were given."""
    found: dict[str, float | None] = {}
    if result.increments and design is not None:
        path = Analysis(replace(result, grips=(), slip_studies=()), plates=plate_frames(design))
        found = metrics_of(design, Cost(), path)
        del found["cost"]
    return found | grip_metrics(result.grips)


def _traces(result: Result, design: Design | None) -> Traces:
    """The path; none where the design is of a version that this one cannot place gages of."""
    if not result.increments or design is None:
        return Traces()
    return traces_of(Analysis(result, plates=plate_frames(design)))


def _read_design(data: dict[str, Any]) -> Design | None:
    from pydantic import ValidationError

    try:
        return Design.model_validate(data)
    except (ValidationError, DesignError):
        return None


def _grip(grip: GripResult, folder: Path) -> GripOutcome:
    normal, tangential = _path(grip, folder)
    return GripOutcome(
        grip.controller,
        grip.friction_coefficient,
        grip.object_mass_g,
        grip.lifted,
        grip.gross_slip,
        grip.safety_margin,
        grip.peak_normal_force_N,
        grip.minimum_stick_ratio,
        normal,
        tangential,
    )


def _path(grip: GripResult, folder: Path) -> tuple[Numbers, Numbers]:
    """Forces of a grip from its grip_*.csv, thinned; none where the folder has no such file."""
    parts = f"{grip.controller}_mu{grip.friction_coefficient:g}_{grip.object_mass_g:g}g"
    stem = "grip_" + "".join(c if c.isalnum() or c in "-_." else "_" for c in parts)
    path = folder / f"{stem}.csv"
    if not path.is_file():
        return (), ()
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            rows = list(_forces(csv.DictReader(stream)))
    except (OSError, KeyError, csv.Error, *_WRONG) as error:
        fault = Fault("RESULT", path, "the path of a grip", f"{error!r}; run analyse again")
        raise DesignError([fault]) from error
    kept = _thinned(rows)
    return tuple(row[0] for row in kept), tuple(row[1] for row in kept)


def _forces(rows: Iterator[dict[str, str]] | csv.DictReader[str]) -> Iterator[tuple[float, float]]:
    for row in rows:
        forces = float(row["normal_force_N"]), float(row["tangential_force_N"])
        if not all(bounded(each) for each in forces):
            raise ValueError("a force that is no finite number")
        yield forces


def _thinned(rows: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    if len(rows) <= MOST_POINTS:
        return list(rows)
    last = len(rows) - 1
    return [rows[round(i * last / (MOST_POINTS - 1))] for i in range(MOST_POINTS)]


def _validity(result: Result) -> Validity:
    ladder = result.ladder
    if ladder is None:
        return Validity()
    worst = max(ladder.error_estimates.values(), default=None)
    return Validity(mesh_error=worst, sentences=(ladder.why_ended,) if ladder.why_ended else ())
