"""The lots of a grid over processes; what is done is kept, line by line, and not done again.

A line of the file is one grip. Its first line names what decides every grip beside its own
conditions: a study that was interrupted goes on where it stopped, also with other frictions,
weights, noises or controllers than before (one that is taught anew apart).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import asdict, replace
from multiprocessing import get_context
from pathlib import Path

from pydantic import TypeAdapter

from fingerdesign.control.metrics import Outcome
from fingerdesign.errors import SolverError
from fingerdesign.process import die_with_parent
from fingerdesign.results import ResultError
from fingerdesign.study.control_bench import GripBench
from fingerdesign.study.control_grid import Cell, Lot

Tell = Callable[[str, float], None]
Key = tuple[str, float, float, float, float]

_HEAD = '{"control_study": "'
_OUTCOME = TypeAdapter(Outcome)


def key_of(cell: Cell | Outcome) -> Key:
    """What tells one grip of a study from another."""
    return cell.controller, cell.friction, cell.mass_g, cell.noise, cell.tug


class Journal:
    """Outcomes in a JSON-lines file, those of an earlier run first.

    digest: of all that decides a grip beside its cell. A file of another digest, or one that is no
    journal, is a ResultError: it is somebody's work. A last line cut short is left out.
    """

    def __init__(self, path: Path, digest: str) -> None:
        self._path, self._digest = path, digest
        self.outcomes: dict[Key, Outcome] = {}
        if path.exists():
            self._read()

    def add(self, outcomes: Iterable[Outcome]) -> None:
        """Keep outcomes, in memory and in the file."""
        found = list(outcomes)
        new = not self._path.exists()
        with self._path.open("a", encoding="utf-8") as stream:
            if new:
                stream.write(json.dumps({"control_study": self._digest}) + "\n")
            stream.writelines(json.dumps(asdict(each), allow_nan=False) + "\n" for each in found)
        self.outcomes |= {key_of(each): each for each in found}

    def discard(self) -> None:
        """Remove the file: its outcomes stand elsewhere."""
        self._path.unlink(missing_ok=True)

    def _read(self) -> None:
        try:
            text = self._path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ResultError(f"{self._path} cannot be read: {error}") from error
        whole = text[: text.rfind("\n") + 1]
        lines = whole.splitlines()
        remedy = "move it away, or choose another --out"
        if not lines and not _HEAD.startswith(text[: len(_HEAD)]):
            raise ResultError(f"{self._path} is no journal of a control study; {remedy}")
        for number, line in enumerate(lines, start=1):
            try:
                record = json.loads(line, parse_constant=_not_finite)
                if number > 1:
                    Outcome(**record)  # no key too many
                    each = _OUTCOME.validate_json(line, strict=True)
                    self.outcomes[key_of(each)] = each
                    continue
                found = record["control_study"]
            except (ValueError, TypeError, KeyError, RecursionError) as error:
                what = f"{self._path}, line {number}: not a grip of a control study"
                raise ResultError(f"{what}; {remedy}") from error
            if found != self._digest:
                what = f"{self._path} is of another design, setting or version"
                raise ResultError(f"{what}; {remedy}")
        if whole != text or not lines:  # go on behind the last whole line
            self._path.write_text(whole, encoding="utf-8") if lines else self._path.unlink()


def _not_finite(text: str) -> float:
    raise ValueError(f"{text} is not a finite number")


def run_lots(
    bench: GripBench,
    lots: Sequence[Lot],
    journal: Journal,
    workers: int,
    tell: Tell = lambda message, fraction: None,
) -> None:
    """Run the cells that the journal does not hold, into it; ``workers`` 1: in this process.

    An interruption waits for the lots that are running, a second or two; what the journal was told
    by then is kept. Raises SolverError where a process died.
    """
    left = [rest for lot in lots if (rest := _left(lot, journal)).cells]
    total = sum(len(lot.cells) for lot in lots)
    done = total - sum(len(lot.cells) for lot in left)
    with _results(bench, left, workers) as results:
        for found in results:
            journal.add(found)
            done += len(found)
            tell(f"gripping: {found[0].controller}", done / total)


def _left(lot: Lot, journal: Journal) -> Lot:
    cells = tuple(cell for cell in lot.cells if key_of(cell) not in journal.outcomes)
    return replace(lot, cells=cells)


@contextmanager
def _results(
    bench: GripBench, lots: Sequence[Lot], workers: int
) -> Iterator[Iterator[list[Outcome]]]:
    if workers <= 1 or len(lots) <= 1:
        yield (bench.run_lot(lot) for lot in lots)
        return
    pool = ProcessPoolExecutor(
        min(workers, len(lots)), get_context("spawn"), initializer=_begin, initargs=(bench,)
    )
    waiting = {pool.submit(_run, lot) for lot in lots}
    try:
        yield _as_they_come(waiting)
    except BrokenProcessPool as error:
        raise SolverError(
            "a process of the study ended; was there memory enough? Run it again: it goes on where "
            "it stopped"
        ) from error
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _as_they_come(waiting: set[Future[list[Outcome]]]) -> Iterator[list[Outcome]]:
    while waiting:
        done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
        for future in done:
            yield future.result()


_bench: GripBench | None = None  # of a process of the pool


def _begin(bench: GripBench) -> None:
    """Start a process of the pool: one BLAS thread, the bench, and no ear for Ctrl-C."""
    import signal

    from threadpoolctl import threadpool_limits

    global _bench
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    die_with_parent()
    threadpool_limits(limits=1, user_api="blas")
    _bench = bench


def _run(lot: Lot) -> list[Outcome]:
    assert _bench is not None
    return _bench.run_lot(lot)
