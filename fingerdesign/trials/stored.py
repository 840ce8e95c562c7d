"""Grips in a study's journal: lists of results by key, and processes that make them.

An interrupted study continues where it stopped, also with other frictions, weights, noises or
controllers than before.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, fields
from typing import TypeVar

from pydantic import TypeAdapter

from fingerdesign.errors import SolverError
from fingerdesign.records.base import ResultError
from fingerdesign.records.result import GripResult
from fingerdesign.runtime.isolate import ProcessError
from fingerdesign.runtime.journal import Journal
from fingerdesign.runtime.pool import Pool
from fingerdesign.trials.bench import Bench
from fingerdesign.trials.grid import Cell

KIND = "a control study"  # The kind of a study's journal.
# A journal whose grips have other fields than these is another version's.
FIELDS = [field.name for field in fields(GripResult)]

Found = TypeVar("Found")
Report = Callable[[str, float], None]  # It is given a message and the fraction that is done.


def stored_grips(journal: Journal) -> dict[str, list[GripResult]]:
    """A journal's lists of grips by key. ResultError where a record is none."""
    adapter = TypeAdapter(list[GripResult])
    try:
        return {
            key: adapter.validate_json(json.dumps(record), strict=True) for key, record in journal
        }
    except ValueError as error:
        words = f"{journal.path}: not the grips of a control study; move it away, or choose "
        raise ResultError(f"{words}another --out") from error


def key_of(cell: Cell, design: str) -> str:
    """The key of a grip in a journal; design: the digest of what is studied, tuned or not."""
    parts = (cell.controller, cell.friction, cell.mass_g, cell.noise, cell.tug)
    return repr((*parts, cell.fault, cell.plant, cell.values, design[:16]))


def run_batches(
    bench: Bench,
    batches: Iterable[Sequence[Cell]],
    journal: Journal,
    workers: int,
    report: Report = lambda message, fraction: None,
    design: str = "",
) -> dict[Cell, GripResult]:
    """All cells' results; those that the journal does not hold are run, and stored.

    workers 1: in this process. An interruption waits for the batches that are running, a second or
    two. Raises SolverError where a process died.
    """
    stored = stored_grips(journal)
    found: dict[Cell, GripResult] = {}
    total, left = 0, []
    for cells in batches:
        total += len(cells)
        for cell in cells:
            if key_of(cell, design) in stored:
                (found[cell],) = stored[key_of(cell, design)]
        if rest := [cell for cell in cells if cell not in found]:
            left.append(rest)
    for cells, results in in_processes(_run, bench, left, workers):
        new = dict(zip(cells, results, strict=True))
        journal.add({key_of(cell, design): [asdict(each)] for cell, each in new.items()})
        found |= new
        first = cells[0]
        subject = first.controller if first.fault == "none" else first.fault
        report(f"gripping: {subject}", len(found) / total)
    return found


def _run(bench: Bench, cells: Sequence[Cell]) -> list[GripResult]:
    return bench.run_batch(cells)


def in_processes(
    function: Callable[[Bench, Sequence[Cell]], Found],
    bench: Bench,
    batches: Sequence[Sequence[Cell]],
    workers: int,
) -> Iterator[tuple[Sequence[Cell], Found]]:
    """Batches with what a function makes of each, as they come, in processes; workers 1: here.

    Raises SolverError where a process died.
    """
    if workers <= 1 or len(batches) <= 1:
        yield from ((cells, function(bench, cells)) for cells in batches)
        return
    with Pool(min(workers, len(batches)), shared=(bench,)) as pool:
        try:
            yield from pool.as_done(lambda cells: (cells, pool.call(function, cells)), batches)
        except ProcessError as error:
            words = f"a process of the study ended ({error}); was there memory enough? Run it again"
            raise SolverError(f"{words}: it continues where it stopped") from error
