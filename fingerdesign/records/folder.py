"""Result folders: written aside and renamed, so that each is there whole or not at all."""

import fnmatch
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from fingerdesign.records.base import ResultError
from fingerdesign.runtime.files import locked, take_place, whole_folder


@dataclass(frozen=True)
class RecordFolder:
    """A kind of folder of files made together: written aside and renamed, so it is there whole or
    not at all. What is not an older folder of the same kind is not replaced.

        VALIDATION = RecordFolder("validation", "validation.json", ("validation.json", "*.png"))
        with VALIDATION.written(out / name) as folder:
            ...

    kind: what it is called; record: the file that it must hold; products: patterns of all it may.
    filled: it is written into in place, and may hold folders, or not yet its record.
    """

    kind: str
    record: str
    products: tuple[str, ...]
    filled: bool = False

    @contextmanager
    def written(self, target: Path | str) -> Iterator[Path]:
        """A temporary folder next to ``target`` that takes its place when the block ends well.

        An older one is replaced, and put back should the renaming fail. Anything else in the way is
        a ResultError before any work. When the block raises, nothing is left.
        """
        target = Path(target).absolute()
        self.refuse_foreign(target)
        with ExitStack() as stack:
            try:
                aside = stack.enter_context(whole_folder(target))
            except OSError as error:
                raise ResultError(f"cannot write next to {target}: {error}") from error
            yield aside
            if not (aside / self.record).is_file():
                raise ResultError(f"{target} was not written: it was made without {self.record}")
            with locked(target.with_name(f".{target.name}.lock")):
                self.refuse_foreign(target)
                try:
                    take_place(aside, target)
                except OSError as error:
                    why = f"cannot put the result in place at {target}: {error}"
                    raise ResultError(why) from error

    def refuse_foreign(self, target: Path) -> None:
        """ResultError where ``target`` is no place for such a folder: what is not ours stays."""
        in_the_way = f"{target} is in the way and not a folder; choose another --out"
        if target.is_symlink():
            raise ResultError(in_the_way)
        try:
            names = sorted(entry.name for entry in target.iterdir())
        except FileNotFoundError:
            return
        except NotADirectoryError as error:
            raise ResultError(in_the_way) from error
        except OSError as error:
            raise ResultError(f"cannot look into {target}: {error}") from error
        foreign = [name for name in names if self._foreign(target / name)]
        if foreign:
            held = f"{', '.join(foreign[:5])}, which is no {self.kind}"
        elif names and not self.filled and self.record not in names:
            held = f"{', '.join(names[:5])} but no {self.record}, so it is no older {self.kind}"
        else:
            return
        raise ResultError(f"{target} holds {held}; choose another --out")

    def _foreign(self, path: Path) -> bool:
        if not any(fnmatch.fnmatch(path.name, pattern) for pattern in self.products):
            return True
        return not self.filled and path.is_dir()
