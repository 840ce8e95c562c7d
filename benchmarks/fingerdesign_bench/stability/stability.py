"""The stability map: hundreds of hard contact cases through every method, judged and drawn.

Every case has an answer: with the object's motion given and a positive definite compliance, the
forces that solve Coulomb's problem for any given friction bound are bounded by the motion alone, so
the bound's fixed point exists (Brouwer). Refusing is right only where the contact outgrows the
candidate zone. For a large friction coefficient there may be several answers: each that obeys the
laws is right, and is counted apart.
"""

from __future__ import annotations

import os
import platform
import time
from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import Report
from fingerdesign.version import versions
from fingerdesign_bench.check import Check
from fingerdesign_bench.files import write_csv, write_json
from fingerdesign_bench.stability.bodies import HardBody, hard_bodies
from fingerdesign_bench.stability.cases import cases_of
from fingerdesign_bench.stability.map import draw_stability
from fingerdesign_bench.stability.run import METHODS, PRODUCTION, CaseResult, Verdict, run_case

_WORKERS = 2  # The project's times are for two cores.
SOLVED_SHARE = 0.99  # of the cases that have a solution, the target of the production solver
# Bodies of the quick map, and which part of their cases: every third, every ninth, ...
_QUICK = {"coarse, nu 0.3": 3, "coarse, nu 0.4999": 4, "flat, nu 0.0": 9, "3-D, nu 0.0": 15}


@dataclass(frozen=True)
class StabilityMap:
    """Outcomes of all cases, and what it took."""

    outcomes: tuple[CaseResult, ...]
    seconds: float
    workers: int
    quick: bool

    def counts(self) -> dict[str, dict[str, int]]:
        """Cases by method and verdict."""
        found = {method: dict.fromkeys((v.value for v in Verdict), 0) for method in METHODS}
        for (method, verdict), number in Counter(
            (each.method, each.verdict.value) for each in self.outcomes
        ).items():
            found[method][verdict] = number
        return found

    def cases(self) -> int:
        return _cases(self.outcomes)

    def checks(self) -> list[Check]:
        """List the targets of the production solver."""
        counts = self.counts()[PRODUCTION]
        solvable = self.cases() - counts[Verdict.REFUSED.value]
        unsolved = (counts["failed"] + counts["hang"] + counts["wrong"]) / max(solvable, 1)
        return [
            Check("stability: wrong answers", 0, counts[Verdict.WRONG.value]),
            Check("stability: hangs", 0, counts[Verdict.HANG.value]),
            Check("stability: unsolved share", 1.0 - SOLVED_SHARE, unsolved),
        ]


def measure_stability(report: Report = lambda message: None, quick: bool = False) -> StabilityMap:
    """Run all cases (minutes), or some of those of four bodies (``quick``, seconds)."""
    start = time.perf_counter()
    bodies = [body for body in hard_bodies() if not quick or body.name in _QUICK]
    outcomes: dict[str, list[CaseResult]] = {}

    def add(body: HardBody, found: list[CaseResult]) -> None:
        outcomes[body.name] = found
        done = "" if quick else f" ({len(outcomes)} of {len(bodies)} bodies)"
        report(f"{body.name}: {_cases(found)} cases{done}")

    if quick:
        for body in bodies:
            add(body, run_body(body, _QUICK[body.name]))
    else:
        with Pool(_WORKERS) as pool:
            # The longest first.
            queue = sorted(bodies, key=lambda body: not body.solid)
            for body, found in pool.as_done(lambda each: (each, pool.call(run_body, each)), queue):
                add(body, found)
    ordered = tuple(each for body in bodies for each in outcomes[body.name])
    seconds = time.perf_counter() - start
    return StabilityMap(ordered, seconds, 1 if quick else _WORKERS, quick)


def run_body(body: HardBody, every: int = 1) -> list[CaseResult]:
    """Outcomes of one body's cases (each ``every``-th of them), on one BLAS thread."""
    with threadpool_limits(limits=1, user_api="blas"):
        model, crest = body.build()
        cases = list(cases_of(body, model, crest))[::every]
        return [outcome for case in cases for outcome in run_case(case, model)]


def write_stability(found: StabilityMap, folder: Path) -> list[Path]:
    """stability.csv (an outcome a row), stability.json (counts, versions), stability.png."""
    table = write_csv(folder / "stability.csv", [asdict(each) for each in found.outcomes])
    record = write_json(folder / "stability.json", summary(found))
    picture = folder / "stability.png"
    draw_stability(found.outcomes, picture)
    return [table, record, picture]


def summary(found: StabilityMap) -> dict[str, Any]:
    """Counts by method and verdict, the targets, every case not plainly right, versions."""
    mine = [each for each in found.outcomes if each.method == PRODUCTION]
    seconds = dict.fromkeys(METHODS, 0.0)
    for each in found.outcomes:
        seconds[each.method] += each.seconds
    return {
        "cases": found.cases(),
        "increments": sum(each.increments for each in mine),
        "confirmed_by_a_second_method": sum(each.confirmed for each in mine),
        "quick": found.quick,
        "counts": found.counts(),
        "seconds_by_method": {method: round(total, 2) for method, total in seconds.items()},
        "seconds": round(found.seconds, 1),
        "workers": found.workers,
        "checks": [check.as_dict() for check in found.checks()],
        "production_not_plainly_right": [
            {
                "case": f"{each.body}; {each.family}; mu {each.friction:g}",
                "verdict": each.verdict.value,
                "reason": each.reason,
            }
            for each in mine
            if each.verdict not in (Verdict.RIGHT, Verdict.REFUSED)
        ],
        "seeds": {body.name: body.seed for body in hard_bodies() if body.distortion},
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "versions": versions(),
    }


def _cases(outcomes: Iterable[CaseResult]) -> int:
    """Every case is one of the production solver's; not every rival takes every case."""
    return sum(each.method == PRODUCTION for each in outcomes)
