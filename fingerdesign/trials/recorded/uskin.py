"""uSkin: two fingers of 16 taxels that lift and carry objects; a camera sees the object.

Of the public repository imanlab/tactile_prediction_flat_dataset (no licence: read it, do not hand
it on): folders with xela_sensor1.csv and xela_sensor2.csv (txl1_x, ..., txl16_z in counts),
marker.csv (the object's marker in the frame of a camera that the hand carries, m), robot_state.csv
(the hand's place, m) and meta_data.csv. A recording begins in front of the lift, when the hand has
closed: before it the fingers push the object about. The authors' labels of slip are not there; ours
are from the marker.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.trace import csv_lines, csv_numbers, csv_text_of, refuse_faults
from fingerdesign.errors import Fault
from fingerdesign.trials.recorded.recording import REST_S, Recording

SENSORS = ("xela_sensor1.csv", "xela_sensor2.csv")
FILES = (*SENSORS, "marker.csv", "robot_state.csv", "meta_data.csv")
# The object that has moved so far in the hand slips: a soft skin shears by 1 mm at most.
GROSS_MM = 2.0
_LIFT_MM = 1.0  # The hand that has moved so far lifts: at rest it is still to 0.1 mm.
_TAXELS = [f"txl{k + 1}_{axis}" for k in range(16) for axis in "xyz"]
_MARKER = [f"marker1_position_{axis}" for axis in "xyz"]
_HAND = [f"ee_state_position_{axis}" for axis in "xyz"]
_LOST = 9.0  # m: where no marker is seen the authors wrote 10.
_LEAST = 20  # samples


def read_uskin(folder: Path) -> Recording | None:
    """The recording of a folder, from REST_S before the lift until the marker is lost; None without
    a lift or a marker, or of too few samples: slip is not known. DesignError with the faults of a
    file."""
    fingers = [_table(folder / name, _TAXELS) for name in SENSORS]
    marker = _table(folder / "marker.csv", _MARKER)
    hand = _table(folder / "robot_state.csv", _HAND)
    rate = _table(folder / "meta_data.csv", ["frequency_hz"], 1)[0, 0]
    if not 20.0 <= rate <= 1e5:  # At rest there are four samples then.
        fault = Fault("meta_data.csv: frequency_hz", rate, "20 to 100000", "fetch it again")
        refuse_faults([fault], str(folder))
    rest = int(REST_S * rate)
    lift = int(np.argmax(1e3 * np.linalg.norm(hand - hand[0], axis=1) > _LIFT_MM))
    begin = lift - rest - 1
    end = min(len(marker), *map(len, fingers))
    if begin < 0 or end - begin < _LEAST:
        return None
    lost = np.abs(marker[begin:end]).max(axis=1) > _LOST
    count = int(np.argmax(np.append(lost, True)))
    if count < _LEAST:
        return None
    place = 1e3 * marker[begin : begin + count]
    away = np.linalg.norm(place - np.median(place[:rest], axis=0), axis=1)
    away[: rest + 1] = 0.0
    slip = 2 * np.maximum.accumulate(away > GROSS_MM).astype(np.int64)
    taxels = tuple(each[begin : begin + count].reshape(count, -1, 3) for each in fingers)
    return Recording(folder.name, np.arange(count) / rate, taxels, bool(slip.any()), slip)


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
