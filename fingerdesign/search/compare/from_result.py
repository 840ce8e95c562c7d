"""The outcome of an analysis, read from its folder, as a study would have made it."""

import csv
from itertools import chain
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.answers import read_arrays
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.rows import plate_frames
from fingerdesign.records.arrays import ContactHistory
from fingerdesign.records.base import ResultError
from fingerdesign.records.outcome import (
    Failure,
    Numbers,
    Outcome,
    OutcomeError,
    Traces,
    bounded,
)
from fingerdesign.records.result import Result
from fingerdesign.records.result_files import grip_stems, read_result
from fingerdesign.runtime.files import whole_text
from fingerdesign.search.run import measured
from fingerdesign.search.study.file import Cost

SCENE = "scene."  # keys of a record's parameters that are the scene's
_WRONG = (ValueError, TypeError, AttributeError)


def outcome_of_result(folder: Path) -> Outcome:
    """The outcome of a result folder: metrics of its grips and of its path's end.

    The contact map is that of the folder's arrays, where it holds them. Metrics that ask for the
    model (the gage error of the stick ratio) or for prices are left out: see
    :func:`read_comparison`. Raises DesignError for what is no result.
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
    data, traces, metrics = _design(result), Traces(), dict[str, float | None]()
    try:
        design = None if failed else Design.model_validate(data)
    except (ValidationError, DesignError):  # of a version that this one cannot place gages of
        design = None
    if result.increments and design is not None:
        plates = plate_frames(design)
        analysis = Analysis(result, plates=plates, contact=_contact(result, folder))
        traces = measured.traces_of(analysis)
        metrics = measured.metrics_of(design, Cost(), analysis)
        del metrics["cost"]  # no prices were given
    return Outcome(
        digest=result.digest,
        name=result.design,
        values={},
        design=data,
        scene=result.scene,
        fidelity=result.fidelity,
        status=result.status,
        failure=Failure("failed", result.failure or "") if failed else None,
        metrics={} if failed else metrics | measured.verdict_metrics(result),
        traces=traces,
        grips=tuple(
            measured.grip_outcome(grip, *_path(folder / f"{stem}.csv"))
            for stem, grip in zip(grip_stems(result.grips), result.grips, strict=True)
        ),
        validity=measured.mesh_validity(result),
        warnings=result.warnings,
        versions=result.versions,
        seeds=result.seeds,
        seconds=sum(result.timings_s.values()),
        peak_memory_MB=result.peak_memory_MB,
    )


def _contact(result: Result, folder: Path) -> ContactHistory | None:
    """The contact map of the folder's arrays; None where it holds none, or another one's."""
    try:
        found = read_arrays(folder).get("contact")
    except ResultError:  # of another version: the comparison goes on without
        return None
    fits = isinstance(found, ContactHistory) and len(found.status) == len(result.increments)
    return found if fits else None


def _design(result: Result) -> dict[str, Any]:
    """The design's tables from the dotted keys of the record."""
    keys = {k: v for k, v in result.parameters.items() if not k.startswith(SCENE)}
    design = tables_of(keys)
    if result.assumed:
        design["assumed"] = list(result.assumed)
    return design


def tables_of(parameters: dict[str, Any]) -> dict[str, Any]:
    """Dotted keys as tables, those without a value left out."""
    found: dict[str, Any] = {}
    for key, value in parameters.items():
        if value is None:
            continue
        *tables, last = key.split(".")
        place = found
        for table in tables:
            place = place.setdefault(table, {})
        place[last] = value
    return found


def _path(path: Path) -> tuple[Numbers, Numbers]:
    """Forces of a grip from its grip_*.csv; none where there is no such file."""
    if not path.is_file():
        return (), ()
    keys = ("normal_force_N", "tangential_force_N")
    try:
        lines = whole_text(path).splitlines()
        rows = [tuple(float(row[key]) for key in keys) for row in csv.DictReader(lines)]
        if not all(map(bounded, chain.from_iterable(rows))):
            raise ValueError("a force that is no finite number")
    except (OSError, KeyError, csv.Error, *_WRONG) as error:
        fault = Fault("RESULT", path, "the path of a grip", f"{error!r}; run analyse again")
        raise DesignError([fault]) from error
    return tuple(row[0] for row in rows), tuple(row[1] for row in rows)
