"""eFlesh: tugs at objects in a gripper, two sensors of five magnetometers each, at 100 Hz.

Of the public repository notvenky/eFlesh (MIT), slip_detection/data: seq_0.pt to seq_136.pt, each
300 samples of 30 numbers, and labels, a 1 where the object was tugged. A .pt file is a zip archive
with the numbers as they are; nothing in it is run.
"""

import pickletools
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from scipy.signal import savgol_filter

from fingerdesign.arrays import Array
from fingerdesign.control.trace import csv_text_of, refuse_faults
from fingerdesign.errors import DesignError, Fault
from fingerdesign.trials.recorded.detect import Detector
from fingerdesign.trials.recorded.pillars import ZIP_ERRORS
from fingerdesign.trials.recorded.recording import Recording, changes

CLASSIFIER, ALL = "eflesh_linear.pkl", 137  # its file, and the recordings of the whole set
_RATE, _NUMBERS, _SENSORS = 100.0, 30, 2  # Hz, numbers a sample, sensors
_LEAST, _MOST_BYTES = 50, 10_000_000  # rows, and bytes, of a sequence; the authors' have 36 kB


def read_eflesh(folder: Path) -> list[Recording]:
    """The recordings of a folder with labels and seq_*.pt; DesignError with every fault."""
    lines = csv_text_of(folder / "labels", "labels", "a text file").split()
    faults, found = [], []
    if len(lines) < (count := len(list(folder.glob("seq_*.pt")))):
        faults.append(Fault("labels", len(lines), f"{count}, one a sequence", "fetch it again"))
    for k, label in enumerate(lines):
        path = folder / f"seq_{k}.pt"
        if label not in ("0", "1"):
            faults.append(Fault(f"labels, line {k + 1}", label, "0 or 1", "fetch it again"))
        try:
            samples = _samples(path)
        except ZIP_ERRORS as error:
            bound = f"a tensor of at least {_LEAST} rows of {_NUMBERS} numbers"
            faults.append(Fault("sequence", str(path), bound, f"fetch it again ({error})"))
            continue
        taxels = samples.reshape(len(samples), _SENSORS, -1, 3)
        time = np.arange(len(samples)) / _RATE
        fingers = tuple(taxels[:, each] for each in range(_SENSORS))
        found.append(Recording(path.stem, time, fingers, label == "1"))
    refuse_faults(faults, str(folder))
    return found


def _samples(path: Path) -> Array:
    with zipfile.ZipFile(path) as archive:
        name = next((each for each in archive.namelist() if each.endswith("/data/0")), "data/0")
        if archive.getinfo(name).file_size > _MOST_BYTES:
            raise ValueError(f"over {_MOST_BYTES} bytes")
        samples = np.frombuffer(archive.read(name), "<f4").astype(float).reshape(-1, _NUMBERS)
    if len(samples) < _LEAST or not changes(samples):
        raise ValueError("too short, still, or not all are finite numbers")
    return samples


def authors_detector(file: Path) -> Detector:
    """The authors' classifier, a logistic regression on three features of a whole sequence.

    Its numbers are taken out of the pickle, of which no code is run. DesignError for another file.
    """
    try:
        *coefficients, intercept = _floats(file.read_bytes())
        weights = np.array(coefficients).reshape(3)
        if not (np.abs([*weights, intercept]) <= 1e9).all():
            raise ValueError("not all are finite numbers under 1e9")
    except (OSError, ValueError) as error:
        remedy = f"fetch it again ({error})"
        raise DesignError([Fault("classifier", str(file), "of 3 features", remedy)]) from None

    def scores(recording: Recording) -> Array:
        samples = recording.fingers[-1].reshape(len(recording.time), -1)
        smooth = savgol_filter(samples, 11, 3, axis=0)
        tangential = np.arange(smooth.shape[1]) % 3 != 2
        moved = ((smooth - np.median(smooth[:_LEAST], axis=0)) / 100.0)[:, tangential]
        features = np.ptp(moved), abs(moved.sum()), moved.std(axis=0).sum()
        return np.array([float(weights @ features) + intercept])

    note = "alarm over 0; their checkpoint, trained on most of these recordings"
    return Detector("logistic regression", scores, 0.0, note, ours=False)


def authors_test(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings that the authors' classifier was not trained on: their notebook draws a fifth
    of all by scikit-learn with the seed 42."""
    from sklearn.model_selection import train_test_split

    return list(train_test_split(recordings, test_size=0.2, random_state=42)[1])


def _floats(pickled: bytes) -> Iterator[float]:
    """The numbers of a pickle's arrays of doubles: the bytes after the name of that type."""
    doubles = False
    for code, value, _ in pickletools.genops(pickled):
        doubles = doubles or value == "f8"
        if doubles and code.name == "SHORT_BINBYTES":
            yield from np.frombuffer(bytes(value or b""), "<f8").tolist()
