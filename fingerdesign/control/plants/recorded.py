"""A recorded grip in the place of a plant: the same controllers and estimators beside a real rig.

A record cannot answer to what is asked of it: each move returns its next sample, whatever the
controller would have done. :func:`replay` asks a controller along it.
"""

from __future__ import annotations

import csv
import difflib
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.control.calibration import Calibration
from fingerdesign.control.estimator import Estimated, GripEstimator, Moment
from fingerdesign.control.plants.plant import Truth
from fingerdesign.control.roster import Command, Controller
from fingerdesign.control.signals import Sample
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.runtime.files import whole_text

# Whether a recorded trace can be in the units that its columns say, and has no holes.
#
# Bounds are far outside what an elastic finger on a stage does and well inside what a wrong unit
# makes of it: strain for microstrain is off by 1e6, metres or micrometres by 1e3, milliseconds too,
# millinewtons by 1e3. Grams-force for newtons (off by 102) show against the closing alone. What is
# off by less is not found.

Rows = NDArray[np.int64]

_UNEVEN = 0.5  # of the usual step: further off, a sample is missing or came twice
_STEP_S = (1e-5, 5.0)  # from 100 kHz to a stage that settles for seconds
_MOVE_MM, _TRAVEL_MM = 5.0, 50.0  # as [grip] has them
_FORCE_N = 1000.0  # a thumb presses with 100
_FRICTION = 5.0  # the most that [grip] takes
_FELT_N = 0.5  # below it too little is going on to tell
_ZERO_N = 0.1  # an offset of the force cell, beside 5 % of its largest reading
_STIFFNESS = (0.1, 2000.0)  # N/mm; silicone fingers have 30 to 200, of the softest rubber 1
_STRAIN = (0.02, 20_000.0)  # microstrain: the noise of any amplifier; what a gage survives


Columns = Mapping[str, Array]


def unit_faults(column: Columns, rows: Rows) -> Iterator[Fault]:
    """Faults of a trace whose cells are all finite numbers; of each kind the first row."""
    yield from _time_faults(column, rows)
    scale = [*_move_faults(column, rows), *_force_faults(column, rows)]
    yield from scale
    if not scale:
        yield from _stiffness_faults(column, rows)
    yield from _strain_faults(column, rows)


def _time_faults(column: Columns, rows: Rows) -> Iterator[Fault]:
    time = column["time_s"]
    steps = np.diff(time)
    usual = float(np.median(steps))
    back = np.flatnonzero(steps <= 0.0)
    if len(back):
        bound = f"after the row before, {time[back[0]]:.10g}"
        remedy = "put the samples in their order"
        yield _fault(column, rows, back[0] + 1, "time_s", bound, remedy)
    elif not _STEP_S[0] <= usual <= _STEP_S[1]:
        bound = f"{_STEP_S[0]:g} to {_STEP_S[1]:g} s after the row before, not {usual:g}"
        yield _fault(column, rows, 1, "time_s", bound, "write seconds")
    else:
        remedy = "samples are missing or doubled: record at one rate, or cut the trace there"
        for k in np.flatnonzero(np.abs(steps - usual) > _UNEVEN * usual):
            bound = f"about {usual:.4g} s after the row before, not {steps[k]:.4g}"
            yield _fault(column, rows, k + 1, "time_s", bound, remedy)


def _first(
    column: Columns, rows: Rows, name: str, wrong: NDArray[np.bool_], bound: str, remedy: str
) -> list[Fault]:
    """The fault of the first row (k,) that is ``wrong``, if any is."""
    found = np.flatnonzero(wrong)[:1]
    return [_fault(column, rows, place, name, bound, remedy) for place in found]


def _move_faults(column: Columns, rows: Rows) -> Iterator[Fault]:
    remedy = "write millimetres, and each step alone"
    total = f"such that all steps so far make at most {_TRAVEL_MM:g} mm"
    for name in ("dx_mm", "dy_mm"):
        way = column[name]
        far, away = np.abs(way) > _MOVE_MM, np.abs(np.cumsum(way)) > _TRAVEL_MM
        yield from _first(
            column, rows, name, far, f"at most {_MOVE_MM:g} mm in one step", remedy
        ) or _first(column, rows, name, away, total, remedy)


def _force_faults(column: Columns, rows: Rows) -> list[Fault]:
    normal, tangential = column["normal_force_N"], column["tangential_force_N"]
    units, most = "write newtons", f"at most {_FORCE_N:g} N"
    large: list[Fault] = []
    for name in ("normal_force_N", "tangential_force_N"):
        large += _first(column, rows, name, np.abs(column[name]) > _FORCE_N, most, units)
    if large:
        return large
    slack = _ZERO_N + 0.05 * float(np.abs(normal).max())
    bound, remedy = f"over {-slack:.3g} N: a contact only presses", "count pressing positive"
    pulled = _first(column, rows, "normal_force_N", normal < -slack, bound, remedy)
    over = np.abs(tangential) > _FRICTION * np.maximum(normal, 0.0) + slack
    bound = f"at most {_FRICTION:g} times the normal force, {normal[np.argmax(over)]:.4g} N"
    return pulled or _first(column, rows, "tangential_force_N", over, bound, units)


def _stiffness_faults(column: Columns, rows: Rows) -> Iterator[Fault]:
    """Forces against the closing that they took: one of the two may be in another unit."""
    normal, closed = column["normal_force_N"], np.cumsum(column["dy_mm"])
    touched = np.flatnonzero(normal > _ZERO_N)
    if normal.max() <= _FELT_N or not len(touched):
        return
    first, most = int(touched[0]), int(np.argmax(normal))
    way = float(closed[first:].max() - closed[0])
    rise = float(normal[most] - normal[0])
    remedy = "write newtons and millimetres"
    if rise > _FELT_N and 0.0 < way * _STIFFNESS[1] < rise:
        bound = f"at most {_STIFFNESS[1]:g} N for each mm of closing, {way:.4g} mm"
        yield _fault(column, rows, most, "normal_force_N", bound, remedy)
    pressed = float(closed[first:].max() - closed[first])
    if pressed * _STIFFNESS[0] > normal[most]:
        place = first + int(np.argmax(closed[first:]))
        bound = f"at least {_STIFFNESS[0]:g} N for each mm of closing since touch, {pressed:.4g} mm"
        yield _fault(column, rows, place, "normal_force_N", bound, remedy)


def _strain_faults(column: Columns, rows: Rows) -> Iterator[Fault]:
    names = [name for name in column if name.startswith("gage_")]
    table = np.abs(np.array([column[name] for name in names]))
    units, bound = "write microstrain (1e-6)", f"at most {_STRAIN[1]:g} microstrain"
    for name, strain in zip(names, table, strict=True):
        yield from _first(column, rows, name, strain > _STRAIN[1], bound, units)
    if column["normal_force_N"].max() > _FELT_N and table.max() < _STRAIN[0]:
        gage, row = np.unravel_index(int(np.argmax(table)), table.shape)
        bound = f"over {_STRAIN[0]:g} microstrain somewhere, with {_FELT_N:g} N and more on it"
        yield _fault(column, rows, row, names[gage], bound, units)


def _fault(
    column: Columns, rows: Rows, place: int | np.intp, name: str, bound: str, remedy: str
) -> Fault:
    return _cell(int(rows[place]), name, f"{column[name][place]:.10g}", bound, remedy)


# A grip recorded on a rig, as a CSV file (numpy only): read whole, or refused row by row.
#
#     time_s, dx_mm, dy_mm, normal_force_N, tangential_force_N, gage_1, ..., gage_n
#         [, lifted] [, temperature_C]
#
# A row is one sample: its time, the move of the object that led to it, the finger's two forces and
# the gages in microstrain; lifted is 0 or 1; temperature is the finger's. Signs are those of
# :class:`Sample`. Rows are numbered as in the file, the header being row 1. A controller that is
# fed a trace with a hole, a NaN or another unit would answer all the same: so none is read.

COLUMNS = ("time_s", "dx_mm", "dy_mm", "normal_force_N", "tangential_force_N")
TEMPERATURE = "temperature_C"
LEAST_GAGES = 2  # one tells nothing about where it sticks
_MOST_FAULTS = 20  # reported at once


@dataclass(frozen=True)
class Trace:
    """A recorded grip of k samples: (k,) arrays, readings (k, g) microstrain; mm, N, s.

    rows (k,): the samples' rows in their file. lifted (k,) and temperature (k,) in degrees Celsius,
    None where the rig does not tell.
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
        gages = [f"gage_{k + 1}" for k in range(self.readings.shape[1])]
        columns = [self.time, self.dx, self.dy, self.normal_force, self.tangential_force]
        names = [*COLUMNS, *gages]
        columns += list(self.readings.T)
        if self.lifted is not None:
            names, columns = [*names, "lifted"], [*columns, self.lifted.astype(float)]
        if self.temperature is not None:
            names, columns = [*names, TEMPERATURE], [*columns, self.temperature]
        rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
        return "\n".join([",".join(names), *rows]) + "\n"


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
    try:
        if path.exists() and not path.is_file() and not path.is_dir():
            bound, why = "an ordinary file", "a device or pipe may never end"
            raise DesignError([Fault("trace", str(path), bound, why)])
        text = whole_text(path, "utf-8-sig")
    except OSError as error:
        why = error.strerror or "it cannot be read"
        raise DesignError([Fault("trace", str(path), "a readable CSV file", why)]) from None
    except ValueError as error:
        text_is_bad = isinstance(error, UnicodeDecodeError)
        why = "it is not UTF-8 text" if text_is_bad else "its name holds a zero byte"
        raise DesignError([Fault("trace", str(path), "a readable CSV file", why)]) from None
    return parse_trace(text, gages, str(path))


def parse_trace(text: str, gages: int | None = None, source: str = "trace") -> Trace:
    """As :func:`read_trace`, of a file's text; ``source`` names it in what is raised."""
    header, lines = _lines(text, source)
    _refuse(_header_faults(header, gages), source)
    table, faults = _numbers(header, lines)
    _refuse(faults, source)
    rows = np.array([row for row, _ in lines], dtype=np.int64)
    column = dict(zip(header, table.T, strict=True))
    lifted = column.get("lifted")
    if lifted is not None:
        faults = [
            _cell(int(rows[k]), "lifted", f"{lifted[k]:g}", "0 or 1", "say which")
            for k in np.flatnonzero(~np.isin(lifted, (0.0, 1.0)))
        ]
        lifted = lifted > 0.0
    _refuse([*faults, *unit_faults(column, rows)], source)
    readings = table[:, [header.index(name) for name in _gages_of(header)]]
    time, dx, dy, normal, tangential = (column[name] for name in COLUMNS)
    own = (lifted, column.get(TEMPERATURE))
    return Trace(time, dx, dy, normal, tangential, readings, rows, *own)


def _refuse(faults: Sequence[Fault], source: str) -> None:
    if len(faults) > _MOST_FAULTS:
        left = len(faults) - _MOST_FAULTS
        more = Fault("trace", f"{left} more faults", "without any", "mend these first")
        faults = [*faults[:_MOST_FAULTS], more]
    if faults:
        raise DesignError(list(faults), source)


def _lines(text: str, source: str) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The header's names, and (row, cells) of each line that holds anything."""
    try:
        reader = csv.reader(text.splitlines(), strict=True)
        lines = [(reader.line_num, [cell.strip() for cell in cells]) for cells in reader if cells]
    except csv.Error as error:
        raise DesignError([Fault("trace", source, "a CSV file", str(error))]) from None
    if len(lines) < 3:
        bound = "a header and at least 2 samples"
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
            faults.append(_cell(1, str(place), f"'{name}'", "a known column", remedy))
        elif name in header[: place - 1]:
            faults.append(_cell(1, str(place), f"'{name}'", "there once", "leave one out"))
    faults += [
        _cell(1, name, "absent", "there", f"the columns are {', '.join(COLUMNS)}, gage_1, ...")
        for name in COLUMNS
        if name not in header
    ]
    least = LEAST_GAGES if gages is None else gages
    whose = "" if gages is None else ", as the finger has"
    if len(found) < least:
        bound = f"at least {least} gages (gage_1 to gage_{least}){whose}"
        name = f"gage_{len(found) + 1}"
        faults.append(_cell(1, name, f"{len(found)} gages", bound, "record every gage"))
    elif gages is not None and len(found) > gages:
        remedy = "leave out what the finger has not"
        faults.append(_cell(1, found[gages], f"{len(found)} gages", f"{gages}{whose}", remedy))
    elif found and found[-1] != f"gage_{len(found)}":
        bound = f"gage_1 to gage_{len(found)} without a gap"
        faults.append(_cell(1, found[-1], "a number too high", bound, "number them from 1"))
    return faults


def _numbers(
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
            faults.append(_cell(row, place, f"{len(cells)} cells in the row", bound, remedy))
            continue
        if (whole := _sound_row(cells)) is not None:
            table[k] = whole
            continue
        for j, (name, cell) in enumerate(zip(header, cells, strict=True)):
            try:
                table[k, j] = float(cell.replace("_", "?"))
            except ValueError:
                what = f"'{cell}'" if cell else "empty"
                remedy = "record it, or cut the trace there"
                faults.append(_cell(row, name, what, "a number", remedy))
                continue
            if not np.isfinite(table[k, j]):
                remedy = "the sensor gave nothing: cut the trace there"
                faults.append(_cell(row, name, cell, "a finite number", remedy))
    return table, faults


def _sound_row(cells: Sequence[str]) -> list[float] | None:
    """The numbers of a row, None where a cell of it holds no finite number."""
    if any("_" in cell for cell in cells):  # Python would read 1_0 as 10
        return None
    try:
        numbers = list(map(float, cells))
    except ValueError:
        return None
    return numbers if all(map(math.isfinite, numbers)) else None


def _cell(row: int, column: str, value: object, bound: str, remedy: str) -> Fault:
    return Fault(f"row {row}, column {column}", value, bound, remedy)


class TraceEnded(SolverError):
    """More samples were asked for than the trace has."""


class RecordedPlant:
    """Plays a trace back, sample by sample; see :func:`parse_trace`.

    source: a CSV file or a Trace. gages: how many the finger has, where that is known. Raises
    DesignError, with row and column, for a file that is faulty.
    """

    def __init__(self, source: Path | str | Trace, gages: int | None = None) -> None:
        self.trace = source if isinstance(source, Trace) else read_trace(source, gages)
        self._next = 0
        self._truth = Truth(0.0, 0.0, 0.0, 0.0, None, 0.0, False)

    def move(self, dx: float, dy: float) -> Sample:
        """The next sample; what is asked for is not done. Raises TraceEnded after the last."""
        trace, k = self.trace, self._next
        if k >= len(trace):
            raise TraceEnded(
                f"the trace has {len(trace)} samples and ends in row {trace.rows[-1]}; "
                "record a longer one"
            )
        self._next += 1
        normal, tangential = float(trace.normal_force[k]), float(trace.tangential_force[k])
        lifted = None if trace.lifted is None else bool(trace.lifted[k])
        self._truth = Truth(
            approach=self._truth.approach + float(trace.dy[k]),
            shear=self._truth.shear + float(trace.dx[k]),
            normal_force=normal,
            tangential_force=tangential,
            stick_ratio=None,
            slip_distance=0.0,
            complete_slip=False,
            lifted=lifted,
        )
        return Sample(trace.readings[k].copy(), normal, tangential, bool(lifted))

    def truth(self) -> Truth:
        """Where the stage is and what was felt; nobody knows what stuck or slipped."""
        return self._truth

    def __len__(self) -> int:
        """Samples left."""
        return len(self.trace) - self._next


# What a controller and an estimator make of a recorded grip (numpy only).
#
#     for step in replay(RecordedPlant("grip.csv", gages=15), calibration, 0.03, controller):
#         print(step.row, step.requested.dx, "asked;", step.dx, "done")
#
# This judges their senses, not a grip: the rig went its own way, and a controller believes all
# along that it is obeyed.


@dataclass(frozen=True)
class Replayed:
    """One sample of a trace: its row and time (s), and the move (mm) that the rig made before it.

    requested: what the controller asks for after it. estimated: what the estimator makes of all up
    to it, the rig's own moves among it; None without one.
    """

    row: int
    time: float
    dx: float
    dy: float
    sample: Sample
    requested: Command
    estimated: Estimated | None = None


def replay(
    plant: RecordedPlant,
    calibration: Calibration,
    preload: float,
    controller: Controller,
    estimator: GripEstimator | None = None,
) -> Iterator[Replayed]:
    """Every sample after the one at which the stage has closed by ``preload`` mm in all.

    Raises DesignError where the trace never closes so far, or where calibration or estimator are of
    a finger with other gages.
    """
    _refuse_other_gages(plant, len(calibration.gage_x), "the controller is calibrated")
    if estimator is not None:
        _refuse_other_gages(plant, estimator.gages, "the estimator was taught")
    trace = plant.trace
    history: list[Moment] = []
    started, first = False, None
    for k in range(len(trace)):
        sample = calibration.felt(plant.move(0.0, 0.0))
        dx, dy = float(trace.dx[k]), float(trace.dy[k])
        history.append(Moment(sample, dx, dy))
        if started:
            estimated = None if estimator is None else estimator.estimate(history)
            requested = controller.command(sample)
            row, time = int(trace.rows[k]), float(trace.time[k])
            yield Replayed(row, time, dx, dy, sample, requested, estimated)
        elif plant.truth().approach >= preload * (1.0 - 1e-6):
            started, first = True, sample
            controller.start(calibration, sample)
    if not started or history[-1].sample is first:
        bound = f"rows that close by {preload:g} mm in all, the preload, and samples after them"
        closed = f"{plant.truth().approach:.4g}"
        where = f"row {trace.rows[-1]}, column dy_mm"
        raise DesignError([Fault(where, closed, bound, "record from the first touch on")])


def _refuse_other_gages(plant: RecordedPlant, wanted: int, who: str) -> None:
    gages = plant.trace.readings.shape[1]
    if gages != wanted:
        bound = f"{wanted}, for which {who}"
        remedy = "take the design of this finger"
        raise DesignError([Fault("row 1, column gage_1", f"{gages} gages", bound, remedy)])
