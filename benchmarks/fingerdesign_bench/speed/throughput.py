"""``fingerdesign bench sweep``: variants an hour on one worker process and on two.

The shipped study of fingers, in one run, each time with a store and caches of its own, from the
start of the workers to the last outcome. What a second core is worth, and what a variant costs.
"""

from __future__ import annotations

import json
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign_bench.check import Check
from fingerdesign_bench.machine import machine

if TYPE_CHECKING:
    from fingerdesign.search.run.run import Planned
    from fingerdesign.search.study.file import Limits

Report = Callable[[str, float | None], None]

STUDY, WORKERS = "fingers", (1, 2)
QUICK_VARIANTS = 8
ASKED_RATIO, ASKED_CORE_S = 1.7, 2.0
_CACHE = "FINGERDESIGN_CACHE"


@dataclass(frozen=True)
class Throughput:
    """A study on so many workers: s by the clock; of each analysed variant, its processor time."""

    workers: int
    variants: int
    analysed: int
    failures: dict[str, int]
    seconds: float
    core_seconds: tuple[float, ...]

    @property
    def an_hour(self) -> float:
        """Analysed variants an hour."""
        return 3600.0 * self.analysed / self.seconds

    @property
    def mean_core_s(self) -> float:
        """Processor seconds of an analysed variant, on average."""
        return sum(self.core_seconds) / max(len(self.core_seconds), 1)


@dataclass(frozen=True)
class Throughputs:
    """One run, on each number of workers, and the machine."""

    runs: tuple[Throughput, ...]
    machine: dict[str, Any]

    @property
    def ratio(self) -> float:
        """Throughput on the most workers over that on the fewest."""
        return self.runs[-1].an_hour / self.runs[0].an_hour

    def checks(self) -> list[Check]:
        """What issue 8 asks, against what was measured."""
        first, last = self.runs[0], self.runs[-1]
        of = f"{first.variants} variants"
        workers = f"{last.workers} workers over {first.workers}"
        return [
            Check(f"{of}: time on {workers}", round(1.0 / ASKED_RATIO, 3), 1.0 / self.ratio),
            *(
                Check(f"{of}: core time each, {run.workers} at a time", ASKED_CORE_S, cost, "s")
                for run in self.runs
                for cost in (run.mean_core_s,)
            ),
        ]

    def as_dict(self) -> dict[str, Any]:
        """As throughput.json holds it."""
        return {
            "runs": [asdict(run) | {"an_hour": round(run.an_hour, 1)} for run in self.runs],
            "ratio": self.ratio,
            "checks": [check.as_dict() for check in self.checks()],
            "machine": self.machine,
        }


def measure_throughput(
    report: Report = lambda message, fraction: None, quick: bool = False, study: str = STUDY
) -> Throughputs:
    """Run the study on 1 worker and on 2. Raises what run_jobs does."""
    from fingerdesign.search.run.run import planned, study_scenes
    from fingerdesign.search.study.file import read_study
    from fingerdesign.search.study.variants import base_design, variants

    found = machine()
    read = read_study(study)
    plan = list(planned(read, variants(read, base_design(read)), study_scenes(read)))
    plan = plan[:QUICK_VARIANTS] if quick else plan
    runs = tuple(_measured(plan, read.limits, workers, report) for workers in WORKERS)
    return Throughputs(runs, found)


def write_throughput(found: Throughputs, folder: Path) -> list[Path]:
    """throughput.json into a folder; its path."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "throughput.json"
    path.write_text(json.dumps(found.as_dict(), indent=1, allow_nan=False) + "\n", "utf-8")
    return [path]


def _measured(plan: Sequence[Planned], limits: Limits, workers: int, report: Report) -> Throughput:
    from collections import Counter

    from fingerdesign.search.run.cluster import Cluster
    from fingerdesign.search.run.run import Standing, Store, run_jobs

    def show(standing: Standing) -> None:
        report(f"{standing.of} variants, {workers} at a time", standing.number / standing.of)

    with _fresh_caches() as folder, Cluster(workers) as cluster:
        start = time.perf_counter()
        outcomes = run_jobs(plan, Store(folder / "outcomes"), cluster, limits, show)
        seconds = time.perf_counter() - start
    good = [outcome for outcome in outcomes if outcome.status == "ok"]
    kinds = Counter[str](each.failure.kind for each in outcomes if each.failure is not None)
    cost = tuple(round(outcome.core_seconds, 4) for outcome in good)
    return Throughput(workers, len(plan), len(good), dict(kinds), seconds, cost)


@contextmanager
def _fresh_caches() -> Iterator[Path]:
    """A folder that this process and those that it starts keep their caches in."""
    older = os.environ.get(_CACHE)
    with tempfile.TemporaryDirectory() as folder:
        os.environ[_CACHE] = folder
        try:
            yield Path(folder)
        finally:
            if older is None:
                del os.environ[_CACHE]
            else:
                os.environ[_CACHE] = older
