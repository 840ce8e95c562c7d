"""The grips that controllers are tuned on, and the processes that run them.

Frictions and masses are Sobol points of the grid's own span, none of them a point of the grid, and
their noise is another: what a controller is judged on later it has not been tuned to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import get_context
from typing import TYPE_CHECKING, Protocol

from fingerdesign.control.metrics import Outcome
from fingerdesign.control.remembered import Memory
from fingerdesign.errors import SolverError
from fingerdesign.process import die_with_parent
from fingerdesign.study.control_bench import GripBench
from fingerdesign.study.control_grid import FRICTIONS, GOOD_AMPLIFIER, MASSES_G, Cell
from fingerdesign.study.tuning import Values

if TYPE_CHECKING:
    from fingerdesign.design.grip import Grip

Asked = Sequence[tuple[Values, Sequence[Cell]]]
Made = Callable[[int, list[Outcome]], None]  # a trial's number in what was asked, its outcomes


class BenchJudge(Protocol):
    """A ``Judge`` that tells of each trial as soon as its grips are over, in order."""

    def __call__(self, asked: Asked, made: Made = ...) -> list[list[Outcome]]:
        """Outcomes of each (parameters, grips), in order."""
        ...


_APART = 1009  # added to the seed of all noise: the grid's grips are felt with another


def tuning_cells(
    controller: str,
    count: int,
    seed: int = 0,
    noises: Sequence[float] = (GOOD_AMPLIFIER,),
    frictions: tuple[float, float] = (FRICTIONS[0], FRICTIONS[-1]),
    masses_g: tuple[float, float] = (MASSES_G[0], MASSES_G[-1]),
) -> list[Cell]:
    """``count`` grips, the same for every controller; masses evenly by their logarithm."""
    from scipy.stats import qmc

    power = max(count - 1, 0).bit_length()
    points = qmc.Sobol(2, scramble=True, seed=seed).random_base2(power)[:count]
    return [
        Cell(
            controller,
            round(float(frictions[0] + x * (frictions[1] - frictions[0])), 4),
            round(float(masses_g[0] * (masses_g[1] / masses_g[0]) ** y), 1),
            float(noises[k % len(noises)]),
        )
        for k, (x, y) in enumerate(points)
    ]


def tuned_grip(grip: Grip, values: Values) -> Grip:
    """A ``[grip]`` table with dotted keys of the design set, checked like a file."""
    from fingerdesign.design.grip import Grip as Table

    data = grip.model_dump(mode="json", exclude_none=True)
    for key, value in values.items():
        *tables, name = key.removeprefix("grip.").split(".")
        inner = data
        for table in tables:
            inner = inner[table]
        inner[name] = value
    return Table.model_validate(data)


def run_cells(bench: GripBench, values: Values, cells: Sequence[Cell]) -> list[Outcome]:
    """The outcomes of grips whose controllers take ``values``."""
    tuned = bench.with_grip(tuned_grip(bench.grip, values))
    return [tuned.run_cell(cell, Memory()) for cell in cells]


@contextmanager
def bench_judge(bench: GripBench, workers: int) -> Iterator[BenchJudge]:
    """A judge of trials on a bench, over processes; ``workers`` 1: in this one.

    It raises SolverError where a process died.
    """
    seeded = replace(bench, grid=replace(bench.grid, seed=bench.grid.seed + _APART, tug=None))
    if workers <= 1:
        yield lambda asked, made=_unheard: _in_order(
            (run_cells(seeded, values, cells) for values, cells in asked), made
        )
        return
    pool = ProcessPoolExecutor(
        workers, get_context("spawn"), initializer=_begin, initargs=(seeded,)
    )

    def judge(asked: Asked, made: Made = _unheard) -> list[list[Outcome]]:
        try:
            waiting = [pool.submit(_run, dict(values), tuple(cells)) for values, cells in asked]
            return _in_order((each.result() for each in waiting), made)
        except BrokenProcessPool as error:
            raise SolverError("a process of the tuning ended; was there memory enough?") from error

    try:
        yield judge
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _unheard(number: int, outcomes: list[Outcome]) -> None:
    """Nobody is told."""


def _in_order(found: Iterable[list[Outcome]], made: Made) -> list[list[Outcome]]:
    judged = []
    for number, outcomes in enumerate(found):
        made(number, outcomes)
        judged.append(outcomes)
    return judged


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


def _run(values: Mapping[str, float], cells: tuple[Cell, ...]) -> list[Outcome]:
    assert _bench is not None
    return run_cells(_bench, values, cells)
