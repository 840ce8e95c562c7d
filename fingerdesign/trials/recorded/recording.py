"""A recording of slip on an array of taxels, and its plain format as CSV or HDF5.

    time_s, x_1, y_1, z_1, ..., x_n, y_n, z_n, slip

A row is one sample. Taxel k has two tangential signals, x and y, and the normal one, z, all in one
unit: N, mm, or counts of the sensor. slip is 0 (none), 1 (incipient: the edge slips) or 2 (gross:
the object moves). The first REST_S seconds are at rest: baseline and noise are measured there.
An HDF5 file holds one recording, or a group for each: the data sets time_s (k,), taxels (k, n, 3)
and slip (k,).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.control.trace import csv_lines, csv_numbers, csv_text_of, refuse_faults
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.extras import needs

REST_S = 0.2  # It gives 8 samples of the slowest public set, of 38 Hz.
# Of a window: longer ones would have more alarms. A slip sooner after the rest has a shorter one.
SPAN_S = 1.0
_MANY = 100_000  # Of a load that is held, the time grows with their square.
_WRONG = (OSError, LookupError, AttributeError, TypeError, ValueError, RuntimeError, MemoryError)
_UNLABELLED = (
    "label each sample 0, 1 or 2: slip that nobody labelled cannot be judged; where nothing slips "
    "write 0 throughout, and false alarms are judged"
)
_SETS = ("time_s", "taxels", "slip")


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

    @property
    def onset(self) -> float | None:
        """Time (s) of the gross slip; None where there is none or it is not known."""
        known = self.slip is not None and (self.slip == 2).any()
        return float(self.time[np.argmax(self.slip == 2)]) if known else None

    @property
    def rest(self) -> Array:
        """Samples (k,) of the rest at the begin, as true."""
        return np.asarray(self.time <= self.time[0] + REST_S)


def changes(signals: Array) -> bool:
    """Return True if a signal of (k, ...) changes, by a number that can be squared."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(1e-9 <= np.ptp(signals, axis=0).max() <= 1e100)


def read_csv(path: Path) -> Recording:
    """Read a recording's CSV file; DesignError with every fault, each by its row and column."""
    header, lines = csv_lines(csv_text_of(path, "recording", "a readable CSV file"), str(path))
    wanted = _columns(max(2, (len(header) - 1) // 3))
    remedies = {} if "slip" in header else {"slip": _UNLABELLED}
    usual = "see docs/how_to/recorded.md"
    refuse_faults(
        [
            Fault(f"row 1, column {k}", f"'{name}'", f"'{right}'", remedies.get(right, usual))
            for k, (name, right) in enumerate(zip_longest(header, wanted, fillvalue=""), 1)
            if name != right
        ],
        str(path),
    )
    table, faults = csv_numbers(header, lines)
    refuse_faults([*faults, *_faults(table, [f"row {row}" for row, _ in lines])], str(path))
    return _recording(path.stem, table)


def read_hdf5(path: Path) -> list[Recording]:
    """Read the recordings of an HDF5 file; MissingExtra without h5py; DesignError with every
    fault, each by its group, sample and column."""
    needs("recorded", "h5py")
    import h5py

    found: list[Recording] = []
    faults: list[Fault] = []
    try:
        with h5py.File(path, "r") as file:
            for group in [file] if _SETS[0] in file else [file[e] for e in file]:
                name = group.name.strip("/") or path.stem
                named = isinstance(group, h5py.Group)
                there = [group[e].astype(float)[:_MANY] for e in _SETS if named and e in group]
                table = _table(name, there, faults)
                rows = [f"{name}[{each}]" for each in range(len(table))]
                if rows:
                    faults += _faults(table, rows, True)
                    found.append(_recording(name, table))
            if not len(file):
                raise ValueError("it is empty")
    except _WRONG as error:
        bound = "an HDF5 file of numbers"
        raise DesignError([Fault("recording", str(path), bound, str(error))]) from None
    refuse_faults(faults, str(path))
    return found


def _table(name: str, sets: Sequence[Array], faults: list[Fault]) -> Array:
    """The rows of a CSV file of one group's data sets; none, and a fault, for other shapes."""
    shapes = [each.shape for each in sets]
    k, n = shapes[1][:2] if len(shapes) == 3 and len(shapes[1]) == 3 else (0, 0)
    if k and n >= 2 and shapes == [(k,), (k, n, 3), (k,)]:
        return np.column_stack([sets[0], sets[1].reshape(k, -1), sets[2]])
    bound = f"{', '.join(_SETS)} of (k,), (k, n, 3), (k,) with k > 0 and n > 1"
    faults.append(Fault(name, f"data sets of {shapes}", bound, "transpose them"))
    return np.empty((0, 0))


def _columns(taxels: int) -> list[str]:
    return ["time_s", *(f"{axis}_{k + 1}" for k in range(taxels) for axis in "xyz"), "slip"]


def _recording(name: str, table: Array) -> Recording:
    slip = np.clip(np.nan_to_num(table[:, -1]), -1.0, 3.0).astype(np.int64)
    taxels = table[:, 1:-1].reshape(len(table), -1, 3)
    return Recording(name, table[:, 0], (taxels,), bool((slip == 2).any()), slip)


def _faults(table: Array, rows: Sequence[str], gaps: bool = False) -> Iterator[Fault]:
    """Faults of the values; of each kind the first row. gaps: of what is no finite number too."""
    time, slip, names = table[:, 0], table[:, -1], _columns(table.shape[1] // 3)
    for k, column in np.argwhere(~np.isfinite(table))[:1] if gaps else ():
        remedy = "the sensor gave nothing: cut the recording there"
        yield Fault(f"{rows[k]}, column {names[column]}", table[k, column], "finite", remedy)
    for k in np.flatnonzero(~np.isin(slip, (0.0, 1.0, 2.0)) & np.isfinite(slip))[:1]:
        remedy = "0 is no slip, 1 incipient, 2 gross"
        yield Fault(f"{rows[k]}, column slip", f"{slip[k]:g}", "0, 1 or 2", remedy)
    step = np.diff(time)
    for k in np.flatnonzero((step <= 0.0) | (step > REST_S))[:1]:
        bound = f"after the sample before, {time[k]:.10g}, by at most {REST_S:g} s"
        yield Fault(f"{rows[k + 1]}, column time_s", f"{time[k + 1]:.10g}", bound, "sort or cut it")
    yield from _faults_of_all(table)
    rest = time <= time[0] + REST_S
    for k in np.flatnonzero(rest & np.isin(slip, (1.0, 2.0)))[:1]:
        bound = f"0 in the first {REST_S:g} s"
        yield Fault(f"{rows[k]}, column slip", f"{slip[k]:g}", bound, "begin the recording earlier")
    if rest.sum() < 3 or rest.all():
        bound = f"3 and more in the first {REST_S:g} s, and some after it"
        yield Fault("column time_s", f"{rest.sum()} samples", bound, "write seconds; begin at rest")


def _faults_of_all(table: Array) -> Iterator[Fault]:
    time, signals = table[:, 0], np.delete(table[:, 1:-1], np.s_[2::3], axis=1)
    if len(table) >= _MANY:
        yield Fault("recording", "longer", f"of fewer than {_MANY} samples", "cut it in parts")
    if time[-1] < time[0] + REST_S + SPAN_S and not (table[:, -1] == 2.0).any():
        bound = f"at least {REST_S + SPAN_S:g} s long without a gross slip"
        yield Fault("column time_s", f"{time[-1] - time[0]:g} s", bound, "record for longer")
    if np.isfinite(signals).all() and not changes(signals):
        first, bound = f"{signals[0, 0]:g} at first", "changing by 1e-9 to 1e100"
        yield Fault("columns x and y", first, bound, "record a load, in another unit")
