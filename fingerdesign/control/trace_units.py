"""Whether a recorded trace can be in the units that its columns say, and has no holes.

Bounds are far outside what an elastic finger on a stage does and well inside what a wrong unit
makes of it: strain for microstrain is off by 1e6, metres or micrometres by 1e3, milliseconds too,
millinewtons by 1e3. Grams-force for newtons (off by 102) show against the closing alone. What is
off by less is not found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.errors import Fault

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


def unit_faults(column: Mapping[str, Array], rows: Rows) -> Iterator[Fault]:
    """Faults of a trace whose cells are all finite numbers; of each kind the first row."""
    yield from _time_faults(column["time_s"], rows)
    moves = list(_move_faults(column, rows))
    forces = list(_force_faults(column, rows))
    yield from moves
    yield from forces
    if not moves and not forces:
        yield from _stiffness_faults(column, rows)
    yield from _strain_faults(column, rows)


def _time_faults(time: Array, rows: Rows) -> Iterator[Fault]:
    steps = np.diff(time)
    back = np.flatnonzero(steps <= 0.0)
    if len(back):
        bound = f"after the row before, {time[back[0]]:.10g}"
        yield _fault(rows, back[0] + 1, "time_s", time, bound, "put the samples in their order")
        return
    usual = float(np.median(steps))
    if not _STEP_S[0] <= usual <= _STEP_S[1]:
        bound = f"{_STEP_S[0]:g} to {_STEP_S[1]:g} s after the row before, not {usual:g}"
        yield _fault(rows, 1, "time_s", time, bound, "write seconds")
        return
    for k in np.flatnonzero(np.abs(steps - usual) > _UNEVEN * usual):
        bound = f"about {usual:.4g} s after the row before, not {steps[k]:.4g}"
        remedy = "samples are missing or doubled: record at one rate, or cut the trace there"
        yield _fault(rows, k + 1, "time_s", time, bound, remedy)


def _move_faults(column: Mapping[str, Array], rows: Rows) -> Iterator[Fault]:
    for name in ("dx_mm", "dy_mm"):
        way = column[name]
        far = np.flatnonzero(np.abs(way) > _MOVE_MM)
        if len(far):
            bound = f"at most {_MOVE_MM:g} mm in one step"
            yield _fault(rows, far[0], name, way, bound, "write millimetres, and each step alone")
            continue
        total = np.cumsum(way)
        far = np.flatnonzero(np.abs(total) > _TRAVEL_MM)
        if len(far):
            bound = f"such that all steps so far make at most {_TRAVEL_MM:g} mm"
            yield _fault(rows, far[0], name, way, bound, "write millimetres, and each step alone")


def _force_faults(column: Mapping[str, Array], rows: Rows) -> Iterator[Fault]:
    normal, tangential = column["normal_force_N"], column["tangential_force_N"]
    units = "write newtons"
    large = False
    for name, force in (("normal_force_N", normal), ("tangential_force_N", tangential)):
        over = np.flatnonzero(np.abs(force) > _FORCE_N)
        if len(over):
            large = True
            yield _fault(rows, over[0], name, force, f"at most {_FORCE_N:g} N", units)
    if large:
        return
    slack = _ZERO_N + 0.05 * float(np.abs(normal).max())
    pulled = np.flatnonzero(normal < -slack)
    if len(pulled):
        bound = f"over {-slack:.3g} N: a contact only presses"
        yield _fault(rows, pulled[0], "normal_force_N", normal, bound, "count pressing positive")
        return
    over = np.flatnonzero(np.abs(tangential) > _FRICTION * np.maximum(normal, 0.0) + slack)
    if len(over):
        bound = f"at most {_FRICTION:g} times the normal force, {normal[over[0]]:.4g} N"
        yield _fault(rows, over[0], "tangential_force_N", tangential, bound, units)


def _stiffness_faults(column: Mapping[str, Array], rows: Rows) -> Iterator[Fault]:
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
        yield _fault(rows, most, "normal_force_N", normal, bound, remedy)
    pressed = float(closed[first:].max() - closed[first])
    if pressed * _STIFFNESS[0] > normal[most]:
        place = first + int(np.argmax(closed[first:]))
        bound = f"at least {_STIFFNESS[0]:g} N for each mm of closing since touch, {pressed:.4g} mm"
        yield _fault(rows, place, "normal_force_N", normal, bound, remedy)


def _strain_faults(column: Mapping[str, Array], rows: Rows) -> Iterator[Fault]:
    names = [name for name in column if name.startswith("gage_")]
    units = "write microstrain (1e-6)"
    for name in names:
        over = np.flatnonzero(np.abs(column[name]) > _STRAIN[1])
        if len(over):
            bound = f"at most {_STRAIN[1]:g} microstrain"
            yield _fault(rows, over[0], name, column[name], bound, units)
    table = np.abs(np.array([column[name] for name in names]))
    if column["normal_force_N"].max() > _FELT_N and table.max() < _STRAIN[0]:
        gage, row = np.unravel_index(int(np.argmax(table)), table.shape)
        bound = f"over {_STRAIN[0]:g} microstrain somewhere, with {_FELT_N:g} N and more on it"
        yield _fault(rows, row, names[gage], column[names[gage]], bound, units)


def _fault(
    rows: Rows, place: int | np.intp, name: str, values: Array, bound: str, remedy: str
) -> Fault:
    return Fault(f"row {rows[place]}, column {name}", f"{values[place]:.10g}", bound, remedy)
