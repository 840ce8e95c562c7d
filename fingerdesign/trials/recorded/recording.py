"""A recording of slip on an array of taxels, and its plain format as CSV or HDF5.

    time_s, x_1, y_1, z_1, ..., x_n, y_n, z_n, slip

A row is one sample. Taxel k has two tangential signals, x and y, and the normal one, z, all in one
unit: N, mm, or counts of the sensor. slip is 0 (none), 1 (incipient: the edge slips) or 2 (gross:
the object moves). The first REST_S seconds are at rest: baseline and noise are measured there.

An HDF5 file holds a group for each recording, or one recording itself, with the data sets time_s
(k,), taxels (k, n, 3) and slip (k,).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.control.trace import csv_lines, csv_numbers, csv_text_of, refuse_faults
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.extras import needs

REST_S = 0.2  # A fifth of a second gives 8 samples of the slowest public set, of 38 Hz.
LEAST_TAXELS = 2  # One alone has no share that sticks.
_AXES = ("x", "y", "z")
_DATA_SETS = ("time_s", "taxels", "slip")


@dataclass(frozen=True)
class Recording:
    """Samples (k,) of a hand. time (k,) s; fingers: of each its taxels (k, n, 3), tangential x and
    y, normal z, in one unit; slips: whether the object slips; slip (k,) of 0, 1 and 2, None where
    only the whole is labelled."""

    name: str
    time: Array
    fingers: tuple[Array, ...]
    slips: bool
    slip: IntArray | None = None

    def onset(self, level: int = 2) -> float | None:
        """Time (s) at which the slip first has this level; None where it never has."""
        if self.slip is None or not (found := np.flatnonzero(self.slip >= level)).size:
            return None
        return float(self.time[found[0]])


def read_csv(path: Path) -> Recording:
    """Read a recording's CSV file; DesignError with every fault, each by its row and column."""
    source = str(path)
    header, lines = csv_lines(csv_text_of(path, "recording", "a readable CSV file"), source)
    refuse_faults(list(_header_faults(header)), source)
    table, faults = csv_numbers(header, lines)
    column = dict(zip(header, table.T, strict=True))
    count = len(header) // 3
    taxels = np.array([[column[f"{a}_{k + 1}"] for a in _AXES] for k in range(count)])
    rows = [f"row {row}, column" for row, _ in lines]
    time, slip = column["time_s"], column["slip"]
    refuse_faults([*faults, *_faults(time, slip, rows)], source)
    return labelled(path.stem, time, np.moveaxis(taxels, 2, 0), slip)


def labelled(name: str, time: Array, taxels: Array, slip: Array) -> Recording:
    """A recording of one finger with a label for each sample."""
    levels = np.asarray(slip, dtype=np.int64)
    return Recording(name, time, (taxels,), bool((levels == 2).any()), levels)


def read_hdf5(path: Path) -> list[Recording]:
    """Read the recordings of an HDF5 file in the plain format; MissingExtra without h5py;
    DesignError with every fault, each by its group, data set and place."""
    found: list[Recording] = []
    faults: list[Fault] = []
    with open_hdf5(path) as file:
        for group in [file] if _DATA_SETS[0] in file else list(file.values()):
            name = group.name.strip("/") or path.stem
            lacking = [each for each in _DATA_SETS if each not in group]
            remedy = f"a recording has {', '.join(_DATA_SETS)}"
            faults += [Fault(f"{name}/{each}", "absent", "there", remedy) for each in lacking]
            if not lacking:
                values = [np.asarray(group[each], dtype=float) for each in _DATA_SETS]
                own = list(_array_faults(name, *values))
                faults += own
                found += [] if own else [labelled(name, *values)]
    refuse_faults(faults, str(path))
    return found


def open_hdf5(path: Path) -> Any:
    """An HDF5 file, open for reading; MissingExtra without h5py, DesignError for another file."""
    try:
        with path.open("rb") as stream:
            pointer = stream.read(19) == b"version https://git"
        if pointer:
            bound, remedy = "the file itself", "it is a pointer: fetch it by git lfs pull"
            raise DesignError([Fault("recording", str(path), bound, remedy)])
        needs("recorded", "h5py")
        import h5py

        return h5py.File(path, "r")
    except OSError as error:
        raise DesignError([Fault("recording", str(path), "an HDF5 file", str(error))]) from None


def _array_faults(name: str, time: Array, taxels: Array, slip: Array) -> Iterator[Fault]:
    """Faults of a group's arrays."""
    shape, n = taxels.shape, len(taxels)
    if len(shape) != 3 or shape[2] != 3 or not LEAST_TAXELS <= shape[1] or time.shape != (n,):
        bound = f"(k,) of time_s and (k, n, 3) of taxels, n at least {LEAST_TAXELS}"
        yield Fault(f"{name}: shapes", f"{time.shape} and {shape}", bound, "transpose them")
    elif slip.shape != (n,):
        yield Fault(f"{name}/slip: shape", slip.shape, f"({n},)", "label every sample")
    else:
        still = "the sensor gave nothing: cut the recording there"
        for k, taxel, axis in np.argwhere(~np.isfinite(taxels))[:1]:
            place, value = f"{name}/taxels[{k}, {taxel}, {axis}]", taxels[k, taxel, axis]
            yield Fault(place, value, "a finite number", still)
        yield from _faults(time, slip, [f"{name}[{k}]," for k in range(n)])


def _header_faults(header: Sequence[str]) -> Iterator[Fault]:
    """Faults of the names of the columns."""
    count = max(LEAST_TAXELS, -(-(len(header) - 2) // 3))
    known = ["time_s", *(f"{a}_{k + 1}" for k in range(count) for a in _AXES), "slip"]
    remedy = "the columns are time_s, x_1, y_1, z_1, x_2, ..., slip"
    for name in known:
        if (times := header.count(name)) != 1:
            yield Fault(f"row 1, column {name}", f"there {times} times", "there once", remedy)
    for name in dict.fromkeys(header):
        if name not in known:
            yield Fault("row 1", f"'{name}'", "a known column", remedy)


def _faults(time: Array, slip: Array, rows: Sequence[str]) -> Iterator[Fault]:
    """Faults of time and labels; of each kind the first row. NaN: csv_numbers has its fault."""
    for k in np.flatnonzero(~np.isin(slip, (0.0, 1.0, 2.0)) & ~np.isnan(slip))[:1]:
        bound, remedy = "0, 1 or 2", "0 is no slip, 1 incipient, 2 gross"
        yield Fault(f"{rows[k]} slip", f"{slip[k]:g}", bound, remedy)
    for k in np.flatnonzero(np.diff(time) <= 0.0)[:1]:
        bound, remedy = f"after the sample before, {time[k]:.10g}", "put the samples in order"
        yield Fault(f"{rows[k + 1]} time_s", f"{time[k + 1]:.10g}", bound, remedy)
    rest = time <= time[0] + REST_S
    for k in np.flatnonzero(rest & (slip > 0.0))[:1]:
        bound = f"0 in the first {REST_S:g} s"
        yield Fault(f"{rows[k]} slip", f"{slip[k]:g}", bound, "begin the recording earlier")
    if rest.sum() < 3 or rest.all():
        bound = f"such that 3 samples and more, but not all, lie in the first {REST_S:g} s"
        yield Fault("time_s", f"{rest.sum()} samples there", bound, "write seconds; record at rest")
