"""The stability map: hundreds of hard contact cases through every method, judged and drawn.

Every case has an answer: with the object's motion given and a positive definite compliance, the
forces that solve Coulomb's problem for any given friction bound are bounded by the motion alone, so
the bound's fixed point exists (Brouwer). Refusing is right only where the contact outgrows the
candidate zone. For a large friction coefficient there may be several answers: each that obeys the
laws is right, and is counted apart.
"""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Check, Shown
from fingerdesign_bench.machine import machine
from fingerdesign_bench.stability.bodies import HardBody, hard_bodies
from fingerdesign_bench.stability.cases import cases_of
from fingerdesign_bench.stability.map import draw_stability
from fingerdesign_bench.stability.run import METHODS, PRODUCTION, CaseResult, Verdict, run_case

_WORKERS = 2  # The project's times are for two cores.
SOLVED_SHARE = 0.99  # of the cases that have a solution, the target of the production solver
# Bodies of the quick map, and which part of their cases: every third, every ninth, ...
_QUICK = {"coarse, nu 0.3": 3, "coarse, nu 0.4999": 4, "flat, nu 0.0": 9, "3-D, nu 0.0": 15}


def measure_stability(folder: Path, report: Report, quick: bool = False) -> Shown:
    """Run all cases (minutes), or some of those of four bodies (``quick``, seconds); draw the map.

    Rows: an outcome each.
    """
    outcomes = run_bodies(report, quick)
    picture = draw_stability(outcomes, folder / "stability.png")
    return Shown(
        "Stability",
        checks_of(outcomes),
        machine(),
        {"quick": quick, **summary(outcomes)},
        rows=[asdict(each) for each in outcomes],
        paths=[picture],
    )


def run_bodies(report: Report, quick: bool) -> list[CaseResult]:
    """Outcomes of all bodies' cases, in the bodies' order."""
    bodies = [body for body in hard_bodies() if not quick or body.name in _QUICK]
    if quick:
        return [each for body in bodies for each in run_body(body, _QUICK[body.name])]
    outcomes: dict[str, list[CaseResult]] = {}
    with Pool(_WORKERS) as pool:
        queue = sorted(bodies, key=lambda body: not body.solid)  # the longest first
        for body, found in pool.as_done(lambda each: (each, pool.call(run_body, each)), queue):
            outcomes[body.name] = found
            report(f"{body.name}: {cases(found)} cases ({len(outcomes)} of {len(bodies)} bodies)")
    return [each for body in bodies for each in outcomes[body.name]]


def run_body(body: HardBody, every: int = 1) -> list[CaseResult]:
    """Outcomes of one body's cases (each ``every``-th of them), on one BLAS thread."""
    with threadpool_limits(limits=1, user_api="blas"):
        model, crest = body.build()
        cases = list(cases_of(body, model, crest))[::every]
        return [outcome for case in cases for outcome in run_case(case, model)]


def counts_of(outcomes: Iterable[CaseResult]) -> dict[str, dict[str, int]]:
    """Count cases by method and verdict."""
    found = {method: dict.fromkeys((v.value for v in Verdict), 0) for method in METHODS}
    for each in outcomes:
        found[each.method][each.verdict.value] += 1
    return found


def cases(outcomes: Iterable[CaseResult]) -> int:
    """Every case is one of the production solver's; not every rival takes every case."""
    return sum(each.method == PRODUCTION for each in outcomes)


def checks_of(outcomes: Sequence[CaseResult]) -> list[Check]:
    """List the targets of the production solver."""
    counts = counts_of(outcomes)[PRODUCTION]
    solvable = cases(outcomes) - counts["refused rightly"]
    unsolved = (counts["failed"] + counts["hang"] + counts["wrong"]) / max(solvable, 1)
    return [
        Check("stability: wrong answers", 0, counts["wrong"]),
        Check("stability: hangs", 0, counts["hang"]),
        Check("stability: unsolved share", 1.0 - SOLVED_SHARE, unsolved),
    ]


def summary(outcomes: Sequence[CaseResult]) -> dict[str, Any]:
    """Counts by method and verdict, and every case not plainly right."""
    mine = [each for each in outcomes if each.method == PRODUCTION]
    seconds = {m: sum(each.seconds for each in outcomes if each.method == m) for m in METHODS}
    return {
        "cases": len(mine),
        "increments": sum(each.increments for each in mine),
        "confirmed_by_a_second_method": sum(each.confirmed for each in mine),
        "counts": counts_of(outcomes),
        "seconds_by_method": {method: round(total, 2) for method, total in seconds.items()},
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
    }
