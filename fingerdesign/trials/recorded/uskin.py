"""uSkin: two fingers of 16 taxels that carry objects, and a camera that sees the object.

Of the public repository imanlab/tactile_prediction_flat_dataset (no licence: read it, do not hand
it on): folders data_sample_* with xela_sensor1.csv and xela_sensor2.csv (txl1_x, ..., txl16_z in
counts), marker.csv (the object's marker in the frame of the camera, which the hand carries, in m)
and meta_data.csv (rate, notes). The authors' labels of slip are not in it. Ours are from the
marker: the object that has moved by GROSS_MM in the hand slips.

Also ARQ-CRISP/slip_detection_dataset_2021 (BSD): HDF5 files with groups of 18 taxels (18, 3, k),
times in ms and the authors' labels, a 1 where the object slips.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.trace import csv_lines, csv_numbers, csv_text_of, refuse_faults
from fingerdesign.errors import DesignError, Fault
from fingerdesign.trials.recorded.recording import Recording, labelled, open_hdf5

SENSORS = ("xela_sensor1.csv", "xela_sensor2.csv")
TACTILE = "tactile_data_raw"
# Soft skins of 4 mm shear by 1 mm at most, and at rest the marker is known to some 0.1 mm.
GROSS_MM = 2.0
_TAXELS = [f"txl{k + 1}_{axis}" for k in range(16) for axis in "xyz"]
_MARKER = [f"marker1_position_{axis}" for axis in "xyz"]
_LOST = 9.0  # m: where no marker is seen the authors wrote 10.
_LEAST = 20  # samples


def read_folder(folder: Path) -> Recording | None:
    """The recording of a folder; None where the camera sees no marker at rest, so that slip is not
    known. DesignError with the faults of its files."""
    fingers = tuple(_table(folder / name, _TAXELS) for name in SENSORS)
    marker = _table(folder / "marker.csv", _MARKER)
    count = min(len(marker), *map(len, fingers))
    rate = _table(folder / "meta_data.csv", ["frequency_hz"])[0, 0]
    if count < _LEAST or not 1.0 <= rate <= 1e5:
        bound = f"at least {_LEAST} samples, at 1 to 100000 Hz"
        fault = Fault("recording", f"{count} at {rate:g} Hz", bound, "fetch it again")
        raise DesignError([fault], str(folder))
    seen = (np.abs(marker[:count]) < _LOST).all(axis=1)
    if not seen[:_LEAST].any():
        return None
    # Once the marker is lost nobody knows whether the object slips.
    first = int(np.argmax(seen))
    lost = np.flatnonzero(~seen[first:])
    span = slice(first, first + int(lost[0]) if lost.size else count)
    place = 1e3 * marker[span]
    if len(place) < _LEAST:
        return None
    away = np.linalg.norm(place - np.median(place[:8], axis=0), axis=1)
    slip = 2 * np.asarray(np.maximum.accumulate(away) > GROSS_MM, dtype=np.int64)
    arrays = tuple(each[span].reshape(len(place), 16, 3) for each in fingers)
    time = np.arange(len(place)) / rate
    return Recording(folder.name, time, arrays, bool(slip.any()), slip)


def _table(path: Path, names: list[str]) -> Array:
    """Columns of a CSV file (k, names); DesignError by row and column for what is no number."""
    header, lines = csv_lines(csv_text_of(path, "recording", "a readable CSV file"), str(path), 1)
    lacking = [Fault("row 1", each, "a column", "fetch it again") for each in names]
    refuse_faults([each for each in lacking if each.value not in header], str(path))
    places = [header.index(name) for name in names]
    own = [(row, [cells[k] for k in places]) for row, cells in lines if len(cells) > max(places)]
    table, faults = csv_numbers(names, own)
    refuse_faults(faults, str(path))
    return table


def read_hdf5_groups(path: Path) -> Iterator[Recording]:
    """The recordings of a file of the HDF5 set; MissingExtra without h5py."""
    with open_hdf5(path) as file:
        groups: list[str] = []
        file.visit(lambda name: groups.append(name) if name.endswith(TACTILE) else None)
        for name in groups:
            group = file[name].parent
            taxels = np.moveaxis(np.asarray(group[TACTILE], dtype=float), 2, 0)
            time = np.asarray(group["tactile_timestamps"], dtype=float) / 1e3
            slips = np.asarray(group["tactile_slips_label"]) != 0
            yield labelled(group.name.strip("/"), time, taxels, 2.0 * slips)
