"""The folder of a control study: written aside and renamed; and the journal beside it.

What is not an older control study is not replaced: an analysis has a folder of its own.
"""

from __future__ import annotations

import fnmatch
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fingerdesign.result_folder import sibling, take_place
from fingerdesign.results import ResultError
from fingerdesign.study.control_record import RECORD_FILE
from fingerdesign.study.control_study import PATHS, PRODUCTS


def journal_beside(target: Path) -> Path:
    """The JSON-lines file that keeps the grips of an unfinished study for the folder ``target``."""
    return target.with_name(f"{target.name}.unfinished.jsonl")


@contextmanager
def control_folder(target: Path | str) -> Iterator[Path]:
    """A temporary folder beside ``target`` that takes its place when the block ends well.

    An older study is replaced, and put back should the renaming fail. Anything else in the way is a
    ResultError before any work. When the block raises, the folder is not there; the journal is.
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


def refuse_foreign(target: Path) -> None:
    """ResultError where ``target`` is no place for a control study."""
    try:
        if target.is_symlink() or (target.exists() and not target.is_dir()):
            raise ResultError(f"{target} is in the way and not a folder; choose another --out")
        names = sorted(os.listdir(target))
    except FileNotFoundError:
        return
    except OSError as error:
        raise ResultError(f"cannot look into {target}: {error}") from error
    foreign = [name for name in names if name not in PRODUCTS and not fnmatch.fnmatch(name, PATHS)]
    if foreign:
        raise ResultError(
            f"{target} holds {', '.join(foreign[:5])}, which is no control study; choose another "
            "--out"
        )
