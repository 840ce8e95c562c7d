"""uSkin: two fingers of 16 taxels that carry objects, and a camera that sees the object.

Of the public repository imanlab/tactile_prediction_flat_dataset (no licence: read it, do not hand
it on): folders with xela_sensor1.csv and xela_sensor2.csv (txl1_x, ..., txl16_z in counts),
marker.csv (the object's marker in the frame of a camera that the hand carries, m), meta_data.csv.
The authors' labels of slip are not in it. Ours are from the marker.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.trace import csv_lines, csv_numbers, csv_text_of, refuse_faults
from fingerdesign.errors import Fault
from fingerdesign.trials.recorded.recording import Recording

SENSORS = ("xela_sensor1.csv", "xela_sensor2.csv")
# The object that has moved so far in the hand slips: a soft skin shears by 1 mm at most.
GROSS_MM = 2.0
_TAXELS = [f"txl{k + 1}_{axis}" for k in range(16) for axis in "xyz"]
_MARKER = [f"marker1_position_{axis}" for axis in "xyz"]
_LOST = 9.0  # m: where no marker is seen the authors wrote 10.
_LEAST, _AT_REST = 20, 8  # samples


def read_uskin(folder: Path) -> Recording | None:
    """The recording of a folder, until the marker is lost; None where that is within _LEAST
    samples or it moves at rest: slip is not known. DesignError with the faults of a file."""
    fingers = [_table(folder / name, _TAXELS) for name in SENSORS]
    marker = _table(folder / "marker.csv", _MARKER)
    rate = _table(folder / "meta_data.csv", ["frequency_hz"], 1)[0, 0]
    if not 20.0 <= rate <= 1e5:  # At rest there are four samples then.
        fault = Fault("meta_data.csv: frequency_hz", rate, "20 to 100000", "fetch it again")
        refuse_faults([fault], str(folder))
    seen = (np.abs(marker) < _LOST).all(axis=1)
    count = int(np.argmin(np.append(seen, False)))
    count = min(count, *map(len, fingers))
    if count < _LEAST:
        return None
    away = 1e3 * np.linalg.norm(marker[:count] - np.median(marker[:_AT_REST], axis=0), axis=1)
    slip = 2 * np.maximum.accumulate(away > GROSS_MM).astype(np.int64)
    taxels = tuple(each[:count].reshape(count, -1, 3) for each in fingers)
    found = Recording(folder.name, np.arange(count) / rate, taxels, bool(slip.any()), slip)
    return None if slip[found.rest].any() else found


def _table(path: Path, names: Sequence[str], least: int = 2) -> Array:
    """Columns of a CSV file (k, names); DesignError, by row and column, for what is no number."""
    text = csv_text_of(path, "recording", "a readable CSV file")
    header, lines = csv_lines(text, str(path), least)
    lacking = [name for name in names if name not in header]
    refuse_faults([Fault("row 1", n, "a column", "fetch it again") for n in lacking], str(path))
    places = [header.index(name) for name in names]
    own = [(row, [cells[k] for k in places if k < len(cells)]) for row, cells in lines]
    table, faults = csv_numbers(names, own)
    refuse_faults(faults, str(path))
    return table
