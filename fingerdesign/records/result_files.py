"""The files of a result, as they lie in its folder: written, and read again."""

import dataclasses
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.base import ResultError, write_csv
from fingerdesign.records.folder import RecordFolder
from fingerdesign.records.result import GripResult, IncrementResult, Result
from fingerdesign.runtime.files import why_unread

RESULT_FILE = "result.json"
MOST_BYTES = 100_000_000  # of a result.json: 10,000 increments of fifteen gages take 30 MB
RESULTS = RecordFolder(
    "result",
    RESULT_FILE,
    (
        *("result.json", "design.toml", "arrays.npz", "report.html"),
        *("*.csv", "fields_*.vtu", "*.step", "*.stl"),
    ),
)


def write_result_files(folder: Path, result: Result, grip_traces: Iterable[GripTrace] = ()) -> None:
    """result.json, history.csv and a grip_*.csv for each trace into an existing folder."""
    write_history_csv(folder / "history.csv", result)
    traces = tuple(grip_traces)
    for stem, trace in zip(grip_stems(traces), traces, strict=True):
        write_grip_csv(folder / f"{stem}.csv", trace)
        if trace.without_rule is not None:
            write_grip_csv(folder / f"{stem}_without_rule.csv", trace.without_rule)
    (folder / RESULT_FILE).write_text(result.to_json(), encoding="utf-8")


def read_result(folder: Path | str) -> Result:
    """The result in a folder (or at the path of its result.json). Raises ResultError when there is
    none, DesignError when the file is not a result."""
    path = Path(folder)
    path = path / RESULT_FILE if path.is_dir() else path
    if path.exists() and not path.is_file():  # a pipe or a device may never end
        raise ResultError(f"no result can be read at {path}: it is not an ordinary file")
    try:
        if path.stat().st_size > MOST_BYTES:
            words = f"it is larger than {MOST_BYTES // 10**6} MB; check the path"
            raise ResultError(f"no result can be read at {path}: {words}")
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ResultError(f"no result can be read at {path}: {why_unread(error)}") from error
    return Result.from_json(text, str(path))


def write_history_csv(path: Path, result: Result) -> None:
    """A row an increment; units in the column names; empty where there is no value. Readout points
    are numbered from 1 in the scene's order; xy, xz and yz are engineering shear."""
    names = [item.name for item in dataclasses.fields(IncrementResult)]
    names = [name for name in names if name not in ("gages", "points")]

    def cells(row: IncrementResult) -> dict[str, Any]:
        found = {name: getattr(row, name) for name in names}
        found |= {f"gage_{gage.plate}_reading_microstrain": gage.reading for gage in row.gages}
        for point, strain in enumerate(row.points, start=1):
            parts = vars(strain).items()
            found |= {f"point_{point}_strain_{part}_microstrain": each for part, each in parts}
        return found

    rows = [cells(row) for row in result.increments]
    header = ["increment", *(rows[0] if rows else names)]
    write_csv(path, header, ([k, *row.values()] for k, row in enumerate(rows, start=1)))


def write_grip_csv(path: Path, trace: GripTrace) -> None:
    """A row a step of one grip; units in the column names; empty where there is no value."""
    columns = {
        "approach_mm": trace.approach,
        "shear_mm": trace.shear,
        "normal_force_N": trace.normal_force,
        "tangential_force_N": trace.tangential_force,
        "friction_limit_N": trace.limit,
        "stick_ratio": trace.stick_ratio,
        "gage_area_mm": trace.gage_area_mm,
        "command_dx_mm": trace.dx,
        "command_dy_mm": trace.dy,
        "hold": trace.hold,
        "rise_mm": trace.rise,
        "unsure": trace.unsure,
        "reported_stick_ratio": trace.reported_stick_ratio,
        "warns": trace.warns,
    }
    for plate, readings in enumerate(trace.gage_readings.T):
        columns[f"gage_{plate}_reading_microstrain"] = readings
    known = {name: (1 * each).tolist() for name, each in columns.items() if each is not None}
    rows = zip(*known.values(), strict=True)
    write_csv(path, ["step", *known], ([i, *row] for i, row in enumerate(rows, start=1)))


def grip_stems(grips: Iterable[GripResult | GripTrace]) -> Iterator[str]:
    """Distinct names of files, grip_CONTROLLER_muMU_MASSg: two may agree to the digits shown."""
    taken: dict[str, int] = {}
    for grip in grips:
        parts = f"{grip.controller}_mu{grip.friction_coefficient:g}_{grip.object_mass_g:g}g"
        stem = "grip_" + "".join(c if c.isalnum() or c in "-_." else "_" for c in parts)
        taken[stem] = taken.get(stem, 0) + 1
        yield stem + (f"_{taken[stem]}" if taken[stem] > 1 else "")
