"""``fingerdesign bench suite``: every case run, judged and shown."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

from fingerdesign.errors import FingerDesignError
from fingerdesign.report.page import render_page
from fingerdesign.report.table import Table
from fingerdesign.runtime.files import write_whole
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Shown
from fingerdesign_bench.known.case import Case, Outcome, Solution, load_cases
from fingerdesign_bench.known.export import write_problem
from fingerdesign_bench.machine import caption, machine

TEMPLATES = Path(__file__).parent / "templates"
HEADINGS = ("case", "kind", "found", "reference", "known to", "error", "tolerance", "verdict")


@dataclass
class Found:
    """Outcomes in the cases' order; what each problem gave and took, by its name."""

    outcomes: list[Outcome] = field(default_factory=list)
    solutions: dict[str, Solution] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    machine: dict[str, Any] = field(default_factory=machine)

    @property
    def fails(self) -> bool:
        return any(each.fails for each in self.outcomes)

    def groups(self) -> dict[str, list[Outcome]]:
        """Outcomes by their problem."""
        grouped: dict[str, list[Outcome]] = {}
        for each in self.outcomes:
            grouped.setdefault(each.case.problem, []).append(each)
        return grouped


def suite(folder: Path, report: Report, quick: bool, problems: bool) -> Shown:
    """Run the cases, or the quick ones, and write their page."""
    found = run_cases([case for case in load_cases() if case.quick or not quick], report)
    cases = [each.as_dict() for each in found.outcomes]
    return Shown(
        machine=found.machine,
        record={"seconds": found.seconds, "cases": cases},
        paths=write_suite(found, folder, problems),
        tables=[("Cases with known answers", HEADINGS, [row(each) for each in found.outcomes])],
        listed=cases,
        fails=found.fails,
    )


def run_cases(cases: Sequence[Case], report: Report = lambda message: None) -> Found:
    """Each problem once, its cases judged; one that fails is missed and keeps no other back."""
    found, failures = Found(), dict[str, str]()
    for case in cases:
        name = case.problem
        if name not in found.seconds:
            report(name)
            start = time.perf_counter()
            try:
                found.solutions[name] = solution(case)
            except FingerDesignError as error:
                failures[name] = str(error)
            found.seconds[name] = round(time.perf_counter() - start, 2)
        solved = found.solutions.get(name)
        value = None if solved is None else float(solved.values[case.quantity])
        why = failures.get(name, "")
        if value is not None and not isfinite(value):
            value, why = None, "the answer is not a finite number"
        found.outcomes.append(Outcome(case, value, why))
    return found


def solution(case: Case) -> Solution:
    """The answer of the case's function. Raises AttributeError where there is none of that name."""
    made: Solution = resolve_name(f"{__package__}.{case.function}")(**case.arguments)
    return made


def row(outcome: Outcome) -> tuple[str, ...]:
    """Cells under HEADINGS. Relative errors in percent, absolute ones as they are."""
    case = outcome.case

    def off(value: float | None) -> str:
        if value is None:
            return "-"
        return f"{value:.2g}" if case.absolute else f"{100.0 * value:.2g} %"

    least = "at least " if case.at_least else ""
    return (
        case.words,
        "another code" if case.kind == "code" else case.kind,
        "failed" if outcome.value is None else f"{outcome.value:.4g}",
        f"{least}{case.reference:.4g}",
        off(case.uncertainty),
        off(outcome.error),
        off(case.tolerance),
        outcome.verdict,
    )


def write_suite(found: Found, folder: Path, problems: bool = False) -> list[Path]:
    """Write suite.html; with ``problems`` an .npz of each problem that others may solve."""
    table = tuple(row(each) for each in found.outcomes)
    page = render_page(
        TEMPLATES / "suite.html.j2",
        table=Table("cases", "Every case", HEADINGS, table, frozenset({0, 1, 7})),
        groups=found.groups().values(),
        machine=caption(found.machine),
        found=found,
        minutes=f"{sum(found.seconds.values()) / 60.0:.1f}",
        explained=[each for each in found.outcomes if each.case.known_miss or each.fails],
    )
    folder.mkdir(parents=True, exist_ok=True)
    paths = [write_whole(folder / "suite.html", page)]
    for name, outcomes in found.groups().items() if problems else ():
        solved = found.solutions[name].solved if name in found.solutions else None
        if solved is not None:
            paths.append(folder / "problems" / f"{outcomes[0].case.name}.npz")
            write_problem(paths[-1], *solved)
    return paths
