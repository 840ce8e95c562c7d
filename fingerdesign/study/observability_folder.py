"""The folder of a study of gages: written aside and renamed, so that it is there whole or not."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fingerdesign.result_folder import sibling, take_place
from fingerdesign.results import ResultError
from fingerdesign.study.observability_record import (
    CHART_FILE,
    COUNTS_FILE,
    GAGES_FILE,
    RECORD_FILE,
    Observability,
)

PRODUCTS = (RECORD_FILE, GAGES_FILE, COUNTS_FILE, CHART_FILE)


@contextmanager
def observability_folder(target: Path | str) -> Iterator[Path]:
    """A temporary folder beside ``target`` that takes its place when the block ends well.

    An older study of gages is replaced, and put back should the renaming fail; anything else in the
    way is a ResultError before any work. When the block raises, nothing is left.
    """
    target = Path(target).absolute()
    refuse_foreign(target)
    aside = sibling(target, "partial")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        aside.mkdir()
    except OSError as error:
        raise ResultError(f"cannot write beside {target}: {error}") from error
    try:
        yield aside
        if not (aside / RECORD_FILE).is_file():
            raise ResultError(f"{target} was not written: it was made without {RECORD_FILE}")
        refuse_foreign(target)
        take_place(aside, target)
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def write_observability(found: Observability, folder: Path) -> None:
    """The record, its tables and its chart into an existing folder."""
    from fingerdesign.report.figures_observability import chart_png

    (folder / CHART_FILE).write_bytes(chart_png(found.data()))
    for name, text in found.texts().items():
        (folder / name).write_text(text, encoding="utf-8")


def refuse_foreign(target: Path) -> None:
    """ResultError where ``target`` is no place for a study of gages."""
    try:
        if target.is_symlink() or (target.exists() and not target.is_dir()):
            raise ResultError(f"{target} is in the way and not a folder; choose another --out")
        names = sorted(os.listdir(target))
    except FileNotFoundError:
        return
    except OSError as error:
        raise ResultError(f"cannot look into {target}: {error}") from error
    foreign = [name for name in names if name not in PRODUCTS]
    if foreign:
        raise ResultError(
            f"{target} holds {', '.join(foreign[:5])}, which is no study of gages; choose another "
            "--out"
        )
