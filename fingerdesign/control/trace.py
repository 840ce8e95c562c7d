"""A grip recorded on a rig, as a CSV file (numpy only): read whole, or refused row by row.

    time_s, dx_mm, dy_mm, normal_force_N, tangential_force_N, gage_1, ..., gage_n
        [, lifted] [, temperature_C]

A row is one sample: its time, the move of the object that led to it, the finger's two forces and
the gages in microstrain; lifted is 0 or 1; temperature is the finger's. Signs are those of
:class:`Sample`. Rows are numbered as in the file, the header being row 1. A program
would compute with a gap, a NaN or another unit all the same: so such a trace is refused.
"""

import csv
import difflib
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.control.signals import Sample
from fingerdesign.control.trace_units import cell_fault, unit_faults
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import csv_text
from fingerdesign.runtime.files import whole_text

COLUMNS = ("time_s", "dx_mm", "dy_mm", "normal_force_N", "tangential_force_N")
TEMPERATURE = "temperature_C"
LEAST_GAGES = 2  # One alone cannot locate where it sticks.
_MOST_FAULTS = 20  # reported at once


@dataclass(frozen=True)
class Trace:
    """A recorded grip of k samples: (k,) arrays, readings (k, g) microstrain; mm, N, s.

    rows (k,): the samples' rows in their file. lifted (k,) and temperature (k,) in degrees Celsius,
    None where they are not recorded.
    """

    time: Array
    dx: Array
    dy: Array
    normal_force: Array
    tangential_force: Array
    readings: Array
    rows: NDArray[np.int64]
    lifted: NDArray[np.bool_] | None = None
    temperature: Array | None = None

    def __len__(self) -> int:
        return len(self.time)

    def to_csv(self) -> str:
        """The trace as its file's text."""
        moved = (self.time, self.dx, self.dy, self.normal_force, self.tangential_force)
        columns = dict(zip(COLUMNS, moved, strict=True))
        columns |= {f"gage_{k}": each for k, each in enumerate(self.readings.T, 1)}
        if self.lifted is not None:
            columns["lifted"] = self.lifted.astype(float)
        if self.temperature is not None:
            columns[TEMPERATURE] = self.temperature
        rows = ([f"{value:.9g}" for value in row] for row in zip(*columns.values(), strict=True))
        return csv_text(columns, rows)


def trace_of(samples: Sequence[Sample], moves: Sequence[tuple[float, float]], rate: float) -> Trace:
    """The trace of samples, the moves (dx, dy) mm that led to them, and their rate in Hz."""
    count = len(samples)
    dx, dy = np.array(moves, dtype=float).reshape(count, 2).T
    normal = np.array([sample.normal_force for sample in samples])
    tangential = np.array([sample.tangential_force for sample in samples])
    readings = np.array([sample.readings for sample in samples]).reshape(count, -1)
    lifted = np.array([sample.lifted for sample in samples], dtype=bool)
    time, rows = np.arange(1, count + 1) / rate, np.arange(2, count + 2)
    return Trace(time, dx, dy, normal, tangential, readings, rows, lifted)


def read_trace(path: Path | str, gages: int | None = None) -> Trace:
    """Read a trace's file; ``gages``: how many the finger has, where that is known.

    Raises DesignError with the faults found, each with its row and column.
    """
    path = Path(path)
    return parse_trace(csv_text_of(path, "trace", "a readable CSV file"), gages, str(path))


def csv_text_of(path: Path, key: str, bound: str) -> str:
    """Text of a file of the user's; DesignError, by ``key`` and ``bound``, if it cannot be read."""

    def refuse(bound: str, why: str) -> DesignError:
        return DesignError([Fault(key, str(path), bound, why)])

    try:
        if path.exists() and not path.is_file() and not path.is_dir():
            raise refuse("an ordinary file", "a device or pipe may never end")
        return whole_text(path, "utf-8-sig")
    except OSError as error:
        raise refuse(bound, error.strerror or "it cannot be read") from None
    except UnicodeDecodeError:
        raise refuse(bound, "it is not UTF-8 text") from None
    except ValueError:
        raise refuse(bound, "its name holds a zero byte") from None


def parse_trace(text: str, gages: int | None = None, source: str = "trace") -> Trace:
    """Read a file's text like :func:`read_trace`; ``source`` names it in errors."""
    header, lines = csv_lines(text, source)
    refuse_faults(_header_faults(header, gages), source)
    table, faults = csv_numbers(header, lines)
    refuse_faults(faults, source)
    rows = np.array([row for row, _ in lines], dtype=np.int64)
    column = dict(zip(header, table.T, strict=True))
    lifted = column.get("lifted")
    if lifted is not None:
        faults = [
            cell_fault(int(rows[k]), "lifted", f"{lifted[k]:g}", "0 or 1", "say which")
            for k in np.flatnonzero(~np.isin(lifted, (0.0, 1.0)))
        ]
        lifted = lifted > 0.0
    refuse_faults([*faults, *unit_faults(column, rows)], source)
    readings = table[:, [header.index(name) for name in _gages_of(header)]]
    time, dx, dy, normal, tangential = (column[name] for name in COLUMNS)
    heated = column.get(TEMPERATURE)
    return Trace(time, dx, dy, normal, tangential, readings, rows, lifted, heated)


def refuse_faults(faults: Sequence[Fault], source: str) -> None:
    """Raise DesignError with the faults, if any; of very many, the first ones."""
    if len(faults) > _MOST_FAULTS:
        left = len(faults) - _MOST_FAULTS
        more = Fault("trace", f"{left} more faults", "without any", "mend these first")
        faults = [*faults[:_MOST_FAULTS], more]
    if faults:
        raise DesignError(list(faults), source)


def csv_lines(
    text: str, source: str, least: int = 2
) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The header's names, and (row, cells) of each line that holds anything, ``least`` or more."""
    try:
        reader = csv.reader(text.splitlines(), strict=True)
        lines = [(reader.line_num, [cell.strip() for cell in cells]) for cells in reader if cells]
    except csv.Error as error:
        raise DesignError([Fault("trace", source, "a CSV file", str(error))]) from None
    mark = (
        next((each for each in ";\t" if each in "".join(lines[0][1][:1])), None) if lines else None
    )
    if mark is not None:
        key, remedy = "row 1", "write commas between columns, and points in decimals"
        raise DesignError([Fault(key, f"columns apart by {mark!r}", "by ','", remedy)], source)
    if len(lines) < 1 + least:
        bound = f"a header and at least {least} samples"
        raise DesignError([Fault("trace", f"{len(lines)} rows", bound, "record a grip")], source)
    return lines[0][1], lines[1:]


def _gages_of(header: Sequence[str]) -> list[str]:
    """The gages' columns in the order of their numbers."""
    named = [name for name in header if re.fullmatch(r"gage_[1-9]\d*", name)]
    return sorted(named, key=lambda name: int(name.removeprefix("gage_")))


def _header_faults(header: Sequence[str], gages: int | None) -> list[Fault]:
    found = _gages_of(header)
    known = [*COLUMNS, *found, "lifted", TEMPERATURE]
    faults = []
    for place, name in enumerate(header, 1):
        if name not in known:
            near = difflib.get_close_matches(name, [*known, "gage_1"], 1, 0.5)
            remedy = f"did you mean {near[0]}?" if near else "units stand in the names"
            faults.append(cell_fault(1, str(place), f"'{name}'", "a known column", remedy))
        elif name in header[: place - 1]:
            faults.append(cell_fault(1, str(place), f"'{name}'", "there once", "leave one out"))
    faults += [
        cell_fault(1, name, "absent", "there", f"the columns are {', '.join(COLUMNS)}, gage_1, ...")
        for name in COLUMNS
        if name not in header
    ]
    return [*faults, *_gage_column_faults(found, gages)]


def _gage_column_faults(found: Sequence[str], gages: int | None) -> Iterator[Fault]:
    """The fault of the gages' columns: too few, too many, or with a gap."""
    least = LEAST_GAGES if gages is None else gages
    whose = "" if gages is None else ", as the finger has"
    if len(found) < least:
        bound = f"at least {least} gages (gage_1 to gage_{least}){whose}"
        name = f"gage_{len(found) + 1}"
        yield cell_fault(1, name, f"{len(found)} gages", bound, "record every gage")
    elif gages is not None and len(found) > gages:
        remedy = "leave out what the finger has not"
        yield cell_fault(1, found[gages], f"{len(found)} gages", f"{gages}{whose}", remedy)
    elif found and found[-1] != f"gage_{len(found)}":
        bound = f"gage_1 to gage_{len(found)} without a gap"
        yield cell_fault(1, found[-1], "a number too high", bound, "number them from 1")


def csv_numbers(
    header: Sequence[str], lines: Sequence[tuple[int, list[str]]]
) -> tuple[Array, list[Fault]]:
    """The table (k, columns), and a fault for each cell that holds no finite number."""
    table = np.full((len(lines), len(header)), np.nan)
    faults = []
    for k, (row, cells) in enumerate(lines):
        if len(cells) != len(header):
            bound = f"{len(header)}, one for each name of the header"
            place = header[min(len(cells), len(header) - 1)]
            remedy = "mend the row; decimals take a point"
            faults.append(cell_fault(row, place, f"{len(cells)} cells in the row", bound, remedy))
            continue
        table[k] = list(map(_number, cells))
        for j in np.flatnonzero(~np.isfinite(table[k])).tolist():
            cell, bound = cells[j], "a finite number"
            remedy = "the sensor gave nothing: cut the trace there"
            if _number(cell) is None:
                cell, bound = f"'{cell}'" if cell else "empty", "a number"
                point = "," in cell
                remedy = "decimals take a point" if point else "record it, or cut the trace there"
            faults.append(cell_fault(row, header[j], cell, bound, remedy))
    return table, faults


def _number(cell: str) -> float | None:
    """The number in a cell; None, in a table NaN, without one. Python would read 1_0 as 10."""
    try:
        return float(cell.replace("_", "?"))
    except ValueError:
        return None
