"""Variants of a study as files: a folder each with its design and CAD, and two lists.

OUT/NAME/NAME-0007/   NAME-0007.toml, finger.step, finger.stl (the outside), body.stl, plates.stl
variants.csv          a row a variant: its values, its design's digest, what came of its CAD
invalid.csv           a row a fault of those that cannot exist
generate.json         what was asked, versions, counts

A variant's folder is there whole or not at all. Run again, only what is missing or was another
design is made, so an interrupted run goes on.
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
import os
import queue
import re
import shutil
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.analysis.summary import versions
from fingerdesign.checks.load import dump_design
from fingerdesign.errors import Fault, cell_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.records.result import ResultError
from fingerdesign.runtime.child import Child, ChildFailed
from fingerdesign.search.study.variants import stems

if TYPE_CHECKING:
    from fingerdesign.search.study.file import Study
    from fingerdesign.search.study.variants import Variant


# The lists of generated variants: those that are, and those that cannot be with every reason.

VARIANTS, INVALID = "variants.csv", "invalid.csv"


def variants_csv(keys: Sequence[str], found: Iterable[tuple[Variant, str]]) -> str:
    """A row a valid variant: number, name, values, the design's digest, what came of its CAD."""
    rows = [
        [variant.number, variant.name, *_values(variant, keys), variant.design.digest(), cad]
        for variant, cad in found
        if variant.design is not None
    ]
    return _csv(["number", "name", *keys, "design_digest", "cad"], rows)


def invalid_csv(keys: Sequence[str], found: Iterable[Variant]) -> str:
    """A row a fault: number and name of the variant, its values, and the fault in parts."""
    rows = [
        [variant.number, variant.name, *_values(variant, keys), *_parts(fault)]
        for variant in found
        if variant.design is None
        for fault in variant.faults
    ]
    return _csv(["number", "name", *keys, "key", "value", "must_be", "remedy"], rows)


def reasons(found: Iterable[Variant]) -> list[tuple[str, int, Fault, str]]:
    """Why variants are invalid, most frequent first: key, of how many, one fault and whose it is.

    A variant with several faults of one key counts once.
    """
    counted: dict[str, tuple[int, Fault, str]] = {}
    for variant in found:
        for key, fault in {fault.key: fault for fault in variant.faults}.items():
            count, first, name = counted.get(key, (0, fault, variant.name))
            counted[key] = (count + 1, first, name)
    ordered = sorted(counted.items(), key=lambda item: (-item[1][0], item[0]))
    return [(key, count, fault, name) for key, (count, fault, name) in ordered]


def _values(variant: Variant, keys: Sequence[str]) -> list[object]:
    return [variant.values.get(key) for key in keys]


def _parts(fault: Fault) -> list[object]:
    return [fault.key, str(fault.value), fault.bound, fault.remedy]


def _csv(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(cell_text(name) for name in header)
    for row in rows:
        writer.writerow("" if cell is None else _cell(cell) for cell in row)
    return stream.getvalue()


def _cell(value: object) -> object:
    return cell_text(value) if isinstance(value, str) else value


try:
    import fcntl
except ImportError:  # Windows: two writers of one folder are not kept apart there
    fcntl = None  # type: ignore[assignment]


RECORD = "generate.json"
CAD_WORKER = "fingerdesign.search.study.generate_worker:written"
CHORD_TOLERANCE_MM = 0.01
LEFT_OUT, WRITTEN = "left out", "written"  # of a variant's CAD, beside the reason of a failure
_UNFINISHED = (".*.partial-*", ".*.older-*")
_LOCK = ".lock"


@dataclass(frozen=True)
class Made:
    """What came of a variant. cad: "written", "left out", a reason why there is none, or "" where
    the variant is invalid; kept: it was there already."""

    variant: Variant
    cad: str = ""
    kept: bool = False

    @property
    def failed(self) -> bool:
        """Whether its CAD could not be made."""
        return self.variant.design is not None and self.cad not in (LEFT_OUT, WRITTEN)


Tell = Callable[[Made, int], None]  # with how many are done


def folder_of(study: Study) -> RecordFolder:
    """The kind of folder that a study's variants are generated into."""
    lists = (RECORD, VARIANTS, INVALID, _LOCK, *_UNFINISHED)
    digits = ["[0-9]" * number for number in (4, 5, 6)]
    children = tuple(f"{stem}-{each}" for stem in stems(study.name) for each in digits)
    return RecordFolder(
        f"folder of variants of {study.name}", RECORD, (*lists, *children), filled=True
    )


def refuse_foreign(study: Study, target: Path) -> None:
    """ResultError, before any work, where ``target`` or a variant's folder in it holds what is not
    generated."""
    folder_of(study).refuse_foreign(target)
    for place in _variant_folders(study, target):
        _variant_folder(place.name).refuse_foreign(place)


def generate(
    study: Study,
    chosen: Iterator[Variant],
    target: Path,
    *,
    cad: bool = True,
    whole: bool = True,
    workers: int = 1,
    tell: Tell = lambda made, done: None,
) -> tuple[Made, ...]:
    """Write variants into ``target``; what came of each, in order.

    whole: ``chosen`` are all of the study's: folders of others, of an older study of that name, are
    removed. CAD that fails is a reason in the lists, never raised. Raises ResultError for what is
    foreign in ``target`` and where another process writes there, OSError where the disk is full.
    """
    refuse_foreign(study, target)
    target.mkdir(parents=True, exist_ok=True)
    with _alone(target):
        _clear_abandoned(target)
        found = []
        for made in _all_made(study, chosen, target, cad, workers):
            found.append(made)
            tell(made, len(found))
        found.sort(key=lambda each: each.variant.number)
        _write_lists(study, found, target, whole)
    return tuple(found)


def _write_lists(study: Study, found: Sequence[Made], target: Path, whole: bool) -> None:
    """The lists and the record; variants that the whole study no longer has are removed."""
    valid = {made.variant.name for made in found if made.variant.design is not None}
    for place in _variant_folders(study, target) if whole else ():
        if place.name not in valid:
            shutil.rmtree(place)
    keys = list(study.parameters)
    _write(target / VARIANTS, variants_csv(keys, [(made.variant, made.cad) for made in found]))
    _write(target / INVALID, invalid_csv(keys, [made.variant for made in found]))
    _write(target / RECORD, json.dumps(_record(study, found), indent=2, allow_nan=False) + "\n")


def _all_made(
    study: Study, chosen: Iterator[Variant], target: Path, cad: bool, workers: int
) -> Iterator[Made]:
    """Each variant as it is done; a process a worker builds the CAD of many."""
    children = [Child(CAD_WORKER) for _ in range(workers)]
    ended = threading.Event()
    free: queue.Queue[Child] = queue.Queue()
    for child in children:
        free.put(child)

    def make(variant: Variant) -> Made:
        child = free.get()
        try:
            return _made(study, variant, target, child if cad else None, ended)
        finally:
            free.put(child)

    running: set[Future[Made]] = set()
    with ThreadPoolExecutor(workers) as pool:
        try:
            for variant in chosen:
                if variant.design is None:
                    yield Made(variant)
                    continue
                running.add(pool.submit(make, variant))
                while len(running) >= 2 * workers:
                    done, running = wait(running, return_when=FIRST_COMPLETED)
                    yield from (each.result() for each in done)
            while running:
                done, running = wait(running, return_when=FIRST_COMPLETED)
                yield from (each.result() for each in done)
        except BaseException:
            ended.set()
            pool.shutdown(wait=False, cancel_futures=True)
            for child in children:
                child.kill()
            raise
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
            for child in children:
                child.end()


def _made(
    study: Study, variant: Variant, target: Path, child: Child | None, ended: threading.Event
) -> Made:
    place = target / variant.name
    text = _design_text(study, variant)
    if _is_there(place, text, child is not None):
        built = (place / "finger.step").is_file()
        return Made(variant, WRITTEN if built else LEFT_OUT, kept=True)
    with _variant_folder(variant.name).written(place) as aside:
        (aside / f"{variant.name}.toml").write_text(text, encoding="utf-8")
        said = LEFT_OUT if child is None else _cad(study, variant, aside, child, ended)
    return Made(variant, said)


def _cad(study: Study, variant: Variant, folder: Path, child: Child, ended: threading.Event) -> str:
    """Build and write the CAD files; a reason where there are none."""
    assert variant.design is not None
    asked = {
        "design": variant.design.model_dump(mode="json"),
        "cad": str(folder),
        "chord_tolerance_mm": CHORD_TOLERANCE_MM,
    }
    try:
        limits = study.limits
        why = str(json.loads(child.run(asked, limits.time_s, limits.memory_MB))["error"])
    except ChildFailed as error:
        if ended.is_set():
            raise  # interrupted: it is not the design's fault
        why = f"the CAD kernel: {error}"
    if not why:
        return WRITTEN
    for file in folder.iterdir():  # some may stand already
        if file.name != f"{variant.name}.toml":
            file.unlink()
    return why


def _design_text(study: Study, variant: Variant) -> str:
    assert variant.design is not None
    made_by = versions().get("fingerdesign", "")
    head = [
        f"# Variant {variant.number} of the study {study.name}, by fingerdesign {made_by}.",
        *(f"#   {key} = {value}" for key, value in variant.values.items()),
        f"# Digest {variant.design.digest()}",
    ]
    return "\n".join([*head, "", dump_design(variant.design)])


def _is_there(place: Path, text: str, cad: bool) -> bool:
    """Whether a variant's folder holds this design, and its CAD if that is asked for."""
    try:
        same = (place / f"{place.name}.toml").read_text(encoding="utf-8") == text
    except (OSError, UnicodeDecodeError):
        return False
    return same and (not cad or (place / "finger.step").is_file())


def _variant_folder(name: str) -> RecordFolder:
    files = (f"{name}.toml", *(f"finger.{ending}" for ending in ("step", "stl")))
    return RecordFolder(
        "generated variant", f"{name}.toml", (*files, "body.stl", "plates.stl", "core.stl")
    )


def _variant_folders(study: Study, target: Path) -> list[Path]:
    names = "|".join(re.escape(stem) for stem in stems(study.name))
    pattern = re.compile(rf"({names})-\d{{4,6}}")
    if not target.is_dir():
        return []
    return sorted(each for each in target.iterdir() if pattern.fullmatch(each.name))


@contextlib.contextmanager
def _alone(target: Path) -> Iterator[None]:
    """ResultError while another process writes into ``target``; its lock ends with it."""
    if fcntl is None:
        yield
        return
    lock = target / _LOCK
    with lock.open("a") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ResultError(f"{target} is being written by another process") from None
        except OSError:  # a file system without locks
            pass
        try:
            yield
        finally:
            lock.unlink(missing_ok=True)


def _clear_abandoned(target: Path) -> None:
    """Remove what a run that was killed has left half-written; no other is at work."""
    for place in [each for pattern in _UNFINISHED for each in target.glob(pattern)]:
        if place.is_dir() and not place.is_symlink():
            shutil.rmtree(place)
        else:
            place.unlink()


def _write(path: Path, text: str) -> None:
    """Whole or not at all."""
    aside = path.with_name(f".{path.name}.partial-{os.getpid()}")
    try:
        aside.write_text(text, encoding="utf-8")
        aside.replace(path)
    finally:
        aside.unlink(missing_ok=True)


def _record(study: Study, found: Sequence[Made]) -> dict[str, object]:
    table = study.study
    return {
        "schema_version": 1,
        "name": study.name,
        "digest": study.digest(),
        "sampling": table.sampling,
        "count": table.count,
        "seed": table.seed,
        "variants": sum(made.variant.design is not None for made in found),
        "invalid": sum(made.variant.design is None for made in found),
        "cad_failed": sum(made.failed for made in found),
        "versions": versions(),
    }
