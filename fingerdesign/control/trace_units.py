"""Bounds that show whether a recorded trace is in the units of its columns, and has no gaps.

Bounds are far outside what an elastic finger on a stage does and well inside what a wrong unit
makes of it: strain for microstrain is off by 1e6, metres or micrometres by 1e3, milliseconds too,
millinewtons by 1e3. Grams-force for newtons (off by 102) show against the closing alone. Smaller
factors are not found.
"""

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.errors import Fault

Columns = Mapping[str, Array]
Rows = NDArray[np.int64]

_UNEVEN = 0.5  # of the usual step: further off, a sample is missing or came twice
_STEP_S = (1e-5, 5.0)  # from 100 kHz to a stage that settles for seconds
_MOVE_MM, _TRAVEL_MM = 5.0, 50.0  # as [grip] has them
_FORCE_N = 1000.0  # a thumb presses with 100
_FRICTION = 5.0  # the most that [grip] takes
_LOADED_N = 0.5  # Below it the loads are too small to judge.
_ZERO_N = 0.1  # an offset of the force cell, in addition to 5 % of its largest reading
_STIFFNESS = (0.1, 2000.0)  # N/mm; silicone fingers have 30 to 200, of the softest rubber 1
_STRAIN = (0.02, 20_000.0)  # microstrain: the noise of any amplifier; what a gage survives


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
    if normal.max() <= _LOADED_N or not len(touched):
        return
    first, most = int(touched[0]), int(np.argmax(normal))
    way = float(closed[first:].max() - closed[0])
    rise = float(normal[most] - normal[0])
    remedy = "write newtons and millimetres"
    if rise > _LOADED_N and 0.0 < way * _STIFFNESS[1] < rise:
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
    if column["normal_force_N"].max() > _LOADED_N and table.max() < _STRAIN[0]:
        gage, row = np.unravel_index(int(np.argmax(table)), table.shape)
        bound = f"over {_STRAIN[0]:g} microstrain somewhere, with {_LOADED_N:g} N and more on it"
        yield _fault(column, rows, row, names[gage], bound, units)


def _fault(
    column: Columns, rows: Rows, place: int | np.intp, name: str, bound: str, remedy: str
) -> Fault:
    return cell_fault(int(rows[place]), name, f"{column[name][place]:.10g}", bound, remedy)


def cell_fault(row: int, column: str, value: object, bound: str, remedy: str) -> Fault:
    """Fault of one cell, named by its row in the file and its column."""
    return Fault(f"row {row}, column {column}", value, bound, remedy)
