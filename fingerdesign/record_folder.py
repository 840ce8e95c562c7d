"""A folder of files made together: written aside and renamed, so it is there whole or not at all.

    VALIDATION = RecordFolder("validation", "validation.json", ("validation.json", "*.png"))
    with VALIDATION.written(out / name) as folder:
        ...

What is not an older folder of the same kind is not replaced. Results of analyses have a folder of
their own kind (result_folder.py).
"""

from __future__ import annotations

import fnmatch
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from fingerdesign.result_folder import sibling, take_place
from fingerdesign.results import ResultError


@dataclass(frozen=True)
class RecordFolder:
    """A kind of folder: what it is called, the file that it must hold, patterns of all it may."""

    kind: str
    record: str
    products: tuple[str, ...]

    @contextmanager
    def written(self, target: Path | str) -> Iterator[Path]:
        """A temporary folder beside ``target`` that takes its place when the block ends well.

        An older one is replaced, and put back should the renaming fail. Anything else in the way is
        a ResultError before any work. When the block raises, nothing is left.
        """
        target = Path(target).absolute()
        self.refuse_foreign(target)
        aside = sibling(target, "partial")
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            aside.mkdir()
        except OSError as error:
            raise ResultError(f"cannot write beside {target}: {error}") from error
        try:
            yield aside
            if not (aside / self.record).is_file():
                raise ResultError(f"{target} was not written: it was made without {self.record}")
            self.refuse_foreign(target)
            take_place(aside, target)
        finally:
            shutil.rmtree(aside, ignore_errors=True)

    def refuse_foreign(self, target: Path) -> None:
        """ResultError where ``target`` is no place for such a folder."""
        try:
            if target.is_symlink() or (target.exists() and not target.is_dir()):
                raise ResultError(f"{target} is in the way and not a folder; choose another --out")
            names = sorted(os.listdir(target))
        except FileNotFoundError:
            return
        except OSError as error:
            raise ResultError(f"cannot look into {target}: {error}") from error
        foreign = [n for n in names if not any(fnmatch.fnmatch(n, p) for p in self.products)]
        if foreign:
            raise ResultError(
                f"{target} holds {', '.join(foreign[:5])}, which is no {self.kind}; choose another "
                "--out"
            )
