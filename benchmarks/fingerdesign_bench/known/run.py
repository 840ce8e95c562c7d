"""``fingerdesign bench suite``: every case run, judged and shown."""

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import import_module
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.errors import FingerDesignError
from fingerdesign.report import style
from fingerdesign.report.page import macros, render_page
from fingerdesign.report.table import Table
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.known.case import Case, Outcome, Picture, Solution
from fingerdesign_bench.known.export import write_problem
from fingerdesign_bench.machine import caption, machine

TEMPLATES = Path(__file__).parent / "templates"
HEADINGS = ("case", "kind", "found", "reference", "known to", "error", "tolerance", "verdict")
_IN_WORDS = {
    "analytic": "analytic",
    "code": "another code",
    "experiment": "experiment",
    "regression": "regression",
}


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
        if value is not None and not isfinite(value):
            value, failures[name] = None, "the answer is not a finite number"
        found.outcomes.append(Outcome(case, value, failures.get(name, "")))
    return found


def solution(case: Case) -> Solution:
    """The answer of the case's function. Raises AttributeError where there is none of that name."""
    module, _, name = case.function.partition(".")
    function = getattr(import_module(f"{__package__}.{module}"), name)
    made: Solution = function(**case.arguments)
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
        _IN_WORDS[case.kind],
        "failed" if outcome.value is None else f"{outcome.value:.4g}",
        f"{least}{case.reference:.4g}",
        off(case.uncertainty),
        off(outcome.error),
        off(case.tolerance),
        outcome.verdict,
    )


def write_suite(found: Found, folder: Path, problems: bool = False) -> list[Path]:
    """suite.json, suite.html, suite.md; with ``problems`` an .npz of each that others may solve."""
    folder.mkdir(parents=True, exist_ok=True)
    groups = found.groups()
    total = sum(found.seconds.values())
    explained = [each for each in found.outcomes if each.case.known_miss or each.fails]
    shown = {"found": found, "minutes": f"{total / 60.0:.1f}", "explained": explained}
    record = {
        "machine": found.machine,
        "seconds": found.seconds,
        "cases": [each.as_dict() for each in found.outcomes],
    }
    table = tuple(row(each) for each in found.outcomes)
    page = render_page(
        TEMPLATES / "suite.html.j2",
        table=Table("cases", "Every case", HEADINGS, table, frozenset({0, 1, 7})),
        groups=[
            (number, each, _drawn(number, found.solutions.get(name)))
            for number, (name, each) in enumerate(groups.items())
        ],
        machine=caption(found.machine),
        **shown,
    )
    markdown = str(macros(TEMPLATES / "suite.md.j2").suite(found, table, HEADINGS, explained))
    texts = {
        "suite.json": json.dumps(record, indent=1, allow_nan=False) + "\n",
        "suite.html": page,
        "suite.md": markdown,
    }
    paths = [folder / name for name in texts]
    for path in paths:
        path.write_text(texts[path.name], encoding="utf-8")
    return paths + (_write_problems(found, folder / "problems") if problems else [])


def _write_problems(found: Found, folder: Path) -> list[Path]:
    """Write each contact problem under the name of its first case."""
    paths = []
    for name, outcomes in found.groups().items():
        solved = found.solutions[name].solved if name in found.solutions else None
        if solved is not None:
            folder.mkdir(exist_ok=True)
            paths.append(folder / f"{outcomes[0].case.name}.npz")
            write_problem(paths[-1], *solved)
    return paths


def _drawn(number: int, solved: Solution | None) -> Any:
    """The problem's picture, inline."""
    if solved is None:
        return None
    picture: Picture = solved.picture
    with style.house_style():
        canvas = style.canvas(5.6, 2.6)
        axes = canvas.subplots()
        for look, curve in enumerate(picture.curves):
            colour, dashes, marker = style.SERIES[look % len(style.SERIES)]
            if curve.known:
                axes.plot(curve.x, curve.y, color=colour, ls=dashes, label=curve.label)
            else:
                axes.plot(curve.x, curve.y, **style.points(colour, marker, 3.0, curve.label))
        axes.set(xlabel=picture.across, ylabel=picture.up)
        axes.legend()
        ends = ", ".join(
            f"{c.label} from {np.min(c.y):.3g} to {np.max(c.y):.3g}" for c in picture.curves
        )
        words = f"{picture.up} over {picture.across}: {ends}."
        return style.ReportFigure(
            f"case{number}", "", style.to_svg(canvas, f"case{number}", words), "", words
        )
