"""The sets of recordings in a folder: found by their files, read, judged, and as a record."""

import os
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
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
_HDF5 = (".h5", ".hdf5")
_SUFFIXES = (*_HDF5, ".csv", ".pkl", ".pt", ".xlsx")
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
    """Results of a folder's recordings. unread: files and folders that were not read, each with the
    reason."""

    folder: str
    sets: tuple[SetData, ...]
    friction: FrictionData | None
    unread: tuple[str, ...]


def judge_recorded(folder: Path) -> RecordedData:
    """Judge all recordings in a folder and in those inside it.

    Raises DesignError with the faults of every file, or where none has a known layout.
    """
    if not folder.is_dir():
        remedy = "docs/how_to/recorded.md names the sets"
        raise DesignError([Fault("--recorded", str(folder), "a folder of recordings", remedy)])
    files, reasons = _files(folder)
    errors: list[DesignError] = []
    books = [each for each in files if each.match(pillars.PATTERN)]
    laws = _read(read_friction, _only(books, errors), errors)
    sets = (*_eflesh(files, errors), *_uskin(files, errors), *_plain(files, errors))
    if errors:
        raise DesignError.together(errors)
    reasons |= dict(_of_no_layout(files))
    unread = tuple(f"{shown(str(each.relative_to(folder)))}: {reasons[each]}" for each in reasons)
    if not sets and not laws:
        remedy = "docs/how_to/recorded.md has the layouts"
        remedy = f"{remedy}; {unread[0]}" if unread else remedy
        bound = "a folder that holds recordings of a known layout"
        raise DesignError([Fault("--recorded", str(folder), bound, remedy)])
    return RecordedData(shown(str(folder)), sets, next(iter(laws), None), unread)


def _files(folder: Path) -> tuple[list[Path], dict[Path, str]]:
    """The files that may hold recordings; what cannot be read, with the reason."""
    files: list[Path] = []
    unread: dict[Path, str] = {}

    def closed_folder(error: OSError) -> None:
        unread[Path(error.filename)] = error.strerror or "it cannot be opened"

    for place, folders, names in os.walk(folder, onerror=closed_folder):
        links = (Path(place, name) for name in folders if Path(place, name).is_symlink())
        unread |= dict.fromkeys(links, "links to folders are not followed")
        every = (Path(place, name) for name in names)
        files += (f for f in every if f.suffix.lower() in _SUFFIXES and f.is_file())
    pointers = [each for each in files if _begin(each).startswith(_POINTER)]
    unread |= dict.fromkeys(sorted(pointers), "a pointer of Git LFS: git lfs pull fetches it")
    return sorted(each for each in files if each not in pointers), unread


def _of_no_layout(files: Sequence[Path]) -> Iterator[tuple[Path, str]]:
    """Files that belong to no set, each with the reason; HDF5 files are read or refused."""
    tugs = {each.parent for each in files if each.name == "seq_0.pt"}
    carried = {each.parent for each in files if each.name == uskin.SENSORS[0]}
    for each in files:
        kind = each.suffix.lower()
        known = _is_of_set(each, tugs, carried) or kind in _HDF5
        if not (known or (kind == ".csv" and _is_plain(each))):
            yield each, "its first column is not time_s" if kind == ".csv" else "of no known layout"


def _is_of_set(file: Path, tugs: Container[Path], carried: Container[Path]) -> bool:
    """True of a file of the public sets; tugs, carried: the folders of eFlesh and of uSkin."""
    if file.parent in tugs and file.match("seq_*.pt"):
        return True
    if file.parent in carried and file.name in uskin.FILES:
        return True
    return file.match(pillars.PATTERN) or (bool(tugs) and file.name == eflesh.CLASSIFIER)


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
    hdf5 = (each for each in files if each.suffix.lower() in _HDF5)
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
    """Read each file; the faults of those that cannot be read are added to ``errors``."""
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
        fault = Fault("--recorded", names, "one such file", "leave out others")
        errors.append(DesignError([fault]))
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
