"""Variants of a study as files: a folder each with its design and CAD, and two lists.

OUT/NAME/NAME-0007/   NAME-0007.toml, finger.step, finger.stl (the outside), body.stl, plates.stl
variants.csv          a row a variant: its values, its design's digest, the result of its CAD
invalid.csv           a row a fault of those that cannot exist
generate.json         the request, versions, counts

A variant's folder is there whole or not at all. Run again, only what is missing or was another
design is made, so an interrupted run goes on.
"""

import shutil
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fingerdesign.design.io import dump_design
from fingerdesign.errors import DesignError, Fault, GeometryError
from fingerdesign.records.base import ResultError, json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.records.outcome import cells_csv
from fingerdesign.runtime.files import BusyError, locked, write_whole
from fingerdesign.runtime.isolate import ProcessError
from fingerdesign.runtime.pool import Pool
from fingerdesign.search.study.file import Study
from fingerdesign.search.study.variants import Variant, stems
from fingerdesign.version import versions

VARIANTS, INVALID = "variants.csv", "invalid.csv"
RECORD = "generate.json"
BUILD = "fingerdesign.cad.export:build_and_write"
RECYCLED_AFTER, READY_S = 100, 120.0  # designs that one process builds; seconds to start it
CHORD_TOLERANCE_MM = 0.01
LEFT_OUT, WRITTEN = "left out", "written"  # of a variant's CAD, or else the reason of a failure
_UNFINISHED = (".*.lock", ".*.partial-*", ".*.older-*", ".????????????-*")
_LOCK = ".lock"


def _csv(
    keys: Sequence[str], more: Sequence[str], rows: Iterable[tuple[Variant, list[str]]]
) -> str:
    """A row each: number and name of a variant, its values, and further cells."""
    cells = (
        [variant.number, variant.name, *(variant.values.get(key) for key in keys), *rest]
        for variant, rest in rows
    )
    return cells_csv(("number", "name", *keys, *more), cells)


def reasons(found: Iterable[Variant]) -> list[tuple[str, int, Fault, str]]:
    """List causes of invalid variants, most frequent first: key, count, a fault and its variant.

    A variant with several faults of one key counts once.
    """
    owners: dict[str, list[tuple[Fault, str]]] = {}
    for variant in found:
        for key, fault in {fault.key: fault for fault in variant.faults}.items():
            owners.setdefault(key, []).append((fault, variant.name))
    ordered = sorted(owners.items(), key=lambda item: (-len(item[1]), item[0]))
    return [(key, len(each), *each[0]) for key, each in ordered]


@dataclass(frozen=True)
class Made:
    """Result of generating a variant.

    cad: "written", "left out", the cause of a failure, or "" where the variant is invalid. existed:
    it was there already.
    """

    variant: Variant
    cad: str = ""
    existed: bool = False

    @property
    def failed(self) -> bool:
        """True where its CAD failed."""
        return self.variant.design is not None and self.cad not in (LEFT_OUT, WRITTEN)


Report = Callable[[Made, int], None]  # with how many are done


def folder_of(study: Study) -> RecordFolder:
    """The kind of folder that a study's variants are generated into."""
    products = (RECORD, VARIANTS, INVALID, _LOCK, *_UNFINISHED, *_children(study))
    return RecordFolder(f"folder of variants of {study.name}", RECORD, products, filled=True)


def _children(study: Study) -> list[str]:
    """Patterns of the names of the variants' folders."""
    return [f"{stem}-{'[0-9]' * count}" for stem in stems(study.name) for count in (4, 5, 6)]


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
    report: Report = lambda made, done: None,
) -> tuple[Made, ...]:
    """Write variants into ``target``; what came of each, in order.

    whole: ``chosen`` are all of the study's: folders of others, of an older study of that name, are
    removed. CAD that fails is a reason in the lists, never raised. Raises ResultError for what is
    foreign in ``target`` and where another process writes there, OSError where the disk is full.
    """
    refuse_foreign(study, target)
    target.mkdir(parents=True, exist_ok=True)
    found: list[Made] = []
    try:
        with locked(target / _LOCK, wait=False):
            # What a run that was killed has left half-written; no other is at work.
            for place in [each for pattern in _UNFINISHED for each in target.glob(pattern)]:
                if place.is_dir() and not place.is_symlink():
                    shutil.rmtree(place)
                else:
                    place.unlink()
            for made in _all_made(study, chosen, target, cad, workers):
                found.append(made)
                report(made, len(found))
            found.sort(key=lambda each: each.variant.number)
            _write_lists(study, found, target, whole)
    except BusyError:
        raise ResultError(f"{target} is being written by another process") from None
    return tuple(found)


def _write_lists(study: Study, found: Sequence[Made], target: Path, whole: bool) -> None:
    """The lists and the record; variants that the whole study no longer has are removed."""
    valid = {made.variant.name for made in found if made.variant.design is not None}
    for place in _variant_folders(study, target) if whole else ():
        if place.name not in valid:
            shutil.rmtree(place)
    keys = list(study.parameters)
    good = ((m.variant, [m.variant.design.digest(), m.cad]) for m in found if m.variant.design)
    bad = (
        (m.variant, [fault.key, str(fault.value), fault.bound, fault.remedy])
        for m in found
        for fault in m.variant.faults
    )
    write_whole(target / VARIANTS, _csv(keys, ("design_digest", "cad"), good))
    write_whole(target / INVALID, _csv(keys, ("key", "value", "must_be", "remedy"), bad))
    write_whole(target / RECORD, json_text(_record(study, found)))


def _all_made(
    study: Study, chosen: Iterator[Variant], target: Path, cad: bool, workers: int
) -> Iterator[Made]:
    """Each variant as it is done; a process a worker builds the CAD of many."""
    ended = threading.Event()
    with Pool(
        workers,
        **study.limits.model_dump(),
        recycled_after=RECYCLED_AFTER,
        load=BUILD.partition(":")[0],
        ready_s=READY_S,
    ) as pool:

        def make(variant: Variant) -> Made:
            if variant.design is None:
                return Made(variant)
            return _made(study, variant, target, pool if cad else None, ended)

        try:
            yield from pool.as_done(make, chosen)
        except BaseException:
            ended.set()
            pool.kill()
            raise


def _made(
    study: Study, variant: Variant, target: Path, pool: Pool | None, ended: threading.Event
) -> Made:
    place, text = target / variant.name, _design_text(study, variant)
    built = (place / "finger.step").is_file()
    try:
        same = (place / f"{variant.name}.toml").read_text(encoding="utf-8") == text
    except (OSError, UnicodeDecodeError):
        same = False
    if same and (built or pool is None):
        return Made(variant, WRITTEN if built else LEFT_OUT, existed=True)
    with _variant_folder(variant.name).written(place) as aside:
        (aside / f"{variant.name}.toml").write_text(text, encoding="utf-8")
        outcome = LEFT_OUT if pool is None else _cad(study, variant, aside, pool, ended)
    return Made(variant, outcome)


def _cad(study: Study, variant: Variant, folder: Path, pool: Pool, ended: threading.Event) -> str:
    """Build and write the CAD files; a reason where there are none."""
    try:
        pool.call(BUILD, variant.design, folder, CHORD_TOLERANCE_MM)
        return WRITTEN
    except ProcessError as error:
        if ended.is_set():
            raise  # interrupted: it is not the design's fault
        late = f"not done after {study.limits.time_s:g} s"
        why = f"the CAD kernel: {late if error.kind == 'timeout' else error}"
    except (DesignError, GeometryError) as error:
        why = str(error)
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


def _variant_folder(name: str) -> RecordFolder:
    cad = ("finger.step", "finger.stl", "body.stl", "plates.stl", "core.stl")
    return RecordFolder("generated variant", f"{name}.toml", (f"{name}.toml", *cad))


def _variant_folders(study: Study, target: Path) -> list[Path]:
    return sorted(place for pattern in _children(study) for place in target.glob(pattern))


def _record(study: Study, found: Sequence[Made]) -> dict[str, object]:
    table, invalid = study.study, sum(made.variant.design is None for made in found)
    return {
        "schema_version": 1,
        "name": study.name,
        "digest": study.digest(),
        **{key: getattr(table, key) for key in ("sampling", "count", "seed")},
        "variants": len(found) - invalid,
        "invalid": invalid,
        "cad_failed": sum(made.failed for made in found),
        "versions": versions(),
    }
