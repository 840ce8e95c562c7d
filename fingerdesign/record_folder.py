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
import re
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from fingerdesign.result_folder import sibling, take_place
from fingerdesign.results import ResultError

DAY_S = 86400.0


@dataclass(frozen=True)
class RecordFolder:
    """A kind of folder: what it is called, the file that it must hold, patterns of all it may.

    filled: it is written into in place, and may hold folders, or not yet its record.
    """

    kind: str
    record: str
    products: tuple[str, ...]
    filled: bool = False

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
        foreign = [name for name in names if self._foreign(target / name)]
        if foreign:
            raise ResultError(
                f"{target} holds {', '.join(foreign[:5])}, which is no {self.kind}; choose another "
                "--out"
            )
        if names and not self.filled and self.record not in names:
            raise ResultError(
                f"{target} holds {', '.join(names[:5])} but no {self.record}, so it is no older "
                f"{self.kind}; choose another --out"
            )

    def _foreign(self, path: Path) -> bool:
        if not any(fnmatch.fnmatch(path.name, pattern) for pattern in self.products):
            return True
        return not self.filled and path.is_dir()


def sweep_abandoned(target: Path, older_than_s: float = DAY_S) -> tuple[Path, ...]:
    """Remove the temporary folders beside ``target`` that killed processes left; which they were.

    For kinds that are made in minutes: nothing in such a folder was changed for ``older_than_s``.
    """
    pattern = re.compile(rf"\.{re.escape(target.name)}\.partial-[0-9a-f]{{8}}")
    return swept(target.absolute().parent, pattern, older_than_s)


def swept(parent: Path, pattern: re.Pattern[str], older_than_s: float) -> tuple[Path, ...]:
    """Remove this user's folders in ``parent`` of names that ``pattern`` matches, where they and
    what lies in them are older; which they were. What cannot be looked into stays."""
    gone = []
    try:
        found = [path for path in parent.iterdir() if pattern.fullmatch(path.name)]
    except OSError:
        return ()
    for path in found:
        try:
            mine = not hasattr(os, "getuid") or path.lstat().st_uid == os.getuid()
            if not mine or path.is_symlink() or not path.is_dir():
                continue
            last = max(each.lstat().st_mtime for each in (path, *path.rglob("*")))
        except OSError:
            continue
        if time.time() - last > older_than_s:
            shutil.rmtree(path, ignore_errors=True)
            gone.append(path)
    return tuple(gone)
