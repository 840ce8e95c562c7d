"""The sets of recordings in a folder: found by their files, read, judged, and as a record."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from fingerdesign.errors import DesignError, Fault, shown
from fingerdesign.records.base import Count, closed
from fingerdesign.records.folder import RecordFolder
from fingerdesign.trials.recorded import eflesh, pillars, uskin
from fingerdesign.trials.recorded.detect import OURS, Detector, Score, score
from fingerdesign.trials.recorded.friction import FrictionData, read_friction
from fingerdesign.trials.recorded.recording import Recording, read_csv, read_hdf5

NAME, RECORD, PAGE = "recorded", "recorded.json", "recorded.html"
FOLDER = RecordFolder("judgement of recordings", RECORD, (RECORD, PAGE))
_POINTER = b"version https://git-lfs"  # Git LFS leaves it in the place of a large file.
_SUFFIXES = (".csv", ".h5", ".hdf5", ".pkl", ".pt", ".xlsx")
_Read = TypeVar("_Read")


@closed
@dataclass(frozen=True)
class SetData:
    """A set of recordings and the scores on it. slips: recordings whose object slips; unknown:
    those of which that is not known, which count in no score; published: the authors' figure."""

    name: str
    source: str
    published: str
    recordings: Count
    slips: Count
    unknown: Count
    scores: tuple[Score, ...]


@closed
@dataclass(frozen=True)
class RecordedData:
    """What the recordings of a folder show. absent: files that are only named there."""

    folder: str
    sets: tuple[SetData, ...]
    friction: FrictionData | None
    absent: tuple[str, ...]


def judge_recorded(folder: Path) -> RecordedData:
    """Judge all recordings in a folder and in those inside it.

    Raises DesignError with the faults of every file, or where none has a known layout.
    """
    if not folder.is_dir():
        remedy = "docs/how_to/recorded.md names the sets"
        raise DesignError([Fault("--recorded", str(folder), "a folder of recordings", remedy)])
    files, absent = _files(folder)
    errors: list[DesignError] = []
    books = [each for each in files if each.match(pillars.PATTERN)]
    laws = _read(read_friction, _only(books, errors), errors)
    sets = (*_eflesh(files, errors), *_uskin(files, errors), *_plain(files, errors))
    if errors:
        raise DesignError.together(errors)
    if not sets and not laws:
        remedy = "docs/how_to/recorded.md has the layouts"
        remedy = f"fetch {absent[0]} and others by git lfs pull" if absent else remedy
        bound = "a folder that holds recordings of a known layout"
        raise DesignError([Fault("--recorded", str(folder), bound, remedy)])
    names = tuple(map(shown, absent))
    return RecordedData(shown(str(folder)), sets, next(iter(laws), None), names)


def _files(folder: Path) -> tuple[list[Path], tuple[str, ...]]:
    """The files that may hold recordings, and the names of those that are only pointers."""
    files = sorted(f for f in folder.rglob("*") if f.suffix.lower() in _SUFFIXES and f.is_file())
    pointers = [each for each in files if _begin(each).startswith(_POINTER)]
    names = tuple(str(each.relative_to(folder)) for each in pointers)
    return [each for each in files if each not in pointers], names


def _eflesh(files: Sequence[Path], errors: list[DesignError]) -> Iterator[SetData]:
    """The set where its files are; faults of files are added to ``errors``, here and below."""
    folders = [each.parent for each in files if each.name == "seq_0.pt"]
    classifiers = [each for each in files if each.name == eflesh.CLASSIFIER]
    tugs = [each for part in _read(eflesh.read_eflesh, folders, errors) for each in part]
    classifier = _only(classifiers, errors) if tugs else []
    theirs = _read(eflesh.authors_detector, classifier, errors)
    source = "notvenky/eFlesh, MIT"
    yield from _judged("eFlesh", source, "95 % right on unseen objects (paper)", tugs, theirs)
    test = eflesh.authors_test(tugs) if theirs and len(tugs) == eflesh.ALL else []
    yield from _judged("eFlesh, test", source, "28 of 28 right (notebook)", test, theirs)


def _uskin(files: Sequence[Path], errors: list[DesignError]) -> Iterator[SetData]:
    folders = [each.parent for each in files if each.name == uskin.SENSORS[0]]
    carried = _read(uskin.read_uskin, folders, errors)
    source = "imanlab/tactile_prediction_flat_dataset, no licence"
    yield from _judged("uSkin", source, "none with this label", carried)


def _plain(files: Sequence[Path], errors: list[DesignError]) -> Iterator[SetData]:
    """Recordings in the plain format, all as one set."""
    plain = (each for each in files if each.suffix.lower() == ".csv" and _is_plain(each))
    own: list[Recording] = _read(read_csv, plain, errors)
    hdf5 = (each for each in files if each.suffix.lower() in (".h5", ".hdf5"))
    own += [each for part in _read(read_hdf5, hdf5, errors) for each in part]
    yield from _judged("plain format", "CSV and HDF5", "none", own)


def _judged(
    name: str,
    source: str,
    published: str,
    read: Sequence[Recording | None],
    theirs: Sequence[Detector] = (),
) -> Iterator[SetData]:
    known = [each for each in read if each is not None]
    if known:
        counts = len(known), sum(each.slips for each in known), len(read) - len(known)
        scores = tuple(score(detector, known) for detector in (*OURS, *theirs))
        yield SetData(name, source, published, *counts, scores)


def _read(
    read: Callable[[Path], _Read], files: Iterable[Path], errors: list[DesignError]
) -> list[_Read]:
    """What is read of each file; the faults of the others are added to ``errors``."""
    found = []
    for each in files:
        try:
            found.append(read(each))
        except DesignError as error:
            errors.append(error)
    return found


def _only(files: Sequence[Path], errors: list[DesignError]) -> Sequence[Path]:
    """The file, if any; of two the user decides which one counts."""
    if len(files) > 1:
        names = ", ".join(shown(str(each)) for each in files)
        errors.append(
            DesignError([Fault("--recorded", names, "one such file", "leave out others")])
        )
    return files[:1]


def _is_plain(path: Path) -> bool:
    begin = _begin(path).replace(b"\0", b"").lstrip(b"\xef\xbb\xbf\xff\xfe \"'")
    return begin[:4].lower() == b"time"  # UTF-16 has zeros; a wrong name is a fault.


def _begin(path: Path) -> bytes:
    try:
        with path.open("rb") as stream:
            return stream.read(len(_POINTER))
    except OSError as error:
        fault = Fault("recording", str(path), "a readable file", error.strerror or "open it")
        raise DesignError([fault]) from None
