"""Work-precision diagrams: errors of forces, stick ratio and gage strains against wall time."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from fingerdesign.errors import SolverError
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Shown
from fingerdesign_bench.machine import caption, machine
from fingerdesign_bench.speed.precision_chart import draw_chart, draw_fingers
from fingerdesign_bench.speed.precision_lines import Chart, Group, Line, Reference
from fingerdesign_bench.speed.precision_plan import CHARTS
from fingerdesign_bench.speed.precision_points import (
    HEADINGS,
    NORM,
    OFF_THE_CHART,
    TIMED,
    Point,
    Precision,
)
from fingerdesign_bench.speed.precision_run import Errors, Method, Run, errors, measured

_LARGE = 0.02  # A line whose finest mesh has a larger error of F_n does not converge.


def precision(folder: Path, report: Report, quick: bool) -> Shown:
    """Measure the points of all charts, and draw them."""
    begun = machine()
    return shown(measure_precision(report, quick), folder, begun)


def shown(found: Precision, folder: Path, begun: dict[str, Any]) -> Shown:
    """Draw a picture a chart; return all that is printed and written."""
    points = [point.record() for point in found.points]
    references = {
        each.name: {
            "method": describe(run.method),
            "element": run.element,
            "size_mm": run.size_mm,
            "dofs": run.dofs,
            "seconds": round(run.total, 2),
        }
        for each, run in found.references.items()
    }
    differ = [
        {"chart": chart, "group": group, **values}
        for (chart, group), values in found.differences.items()
    ]
    pictures = []
    for chart in found.charts:
        path = folder / f"precision-{chart.key}.png"
        if chart.fingers:
            pictures.append(draw_fingers(found, chart, path))
        else:
            pictures.append(draw_chart(found, chart, caption(begun), path))
    rows = [point.row() for point in found.points]
    return Shown(
        machine=begun,
        record={
            "norm": NORM,
            "timed": TIMED,
            "references": references,
            "references_differ": differ,
            "remarks": found.remarks,
        },
        rows=points,
        paths=pictures,
        tables=[("Errors against references of another kind", HEADINGS, rows)],
        notes=[remark for remarks in found.remarks.values() for remark in remarks],
        listed=points,
    )


def measure_precision(
    report: Report, quick: bool = False, charts: Sequence[Chart] = CHARTS
) -> Precision:
    """Measure all points of ``charts``: six minutes on two quiet cores; ``quick``: half a minute.

    A run that fails is a point with its reason. Raises SolverError where a reference fails.
    """

    @cache
    def run(method: Method, size: float, repeat: bool) -> Run:
        report(f"{describe(method)}, {size:g} mm")
        return measured(method, size, repeat)

    measured(Method("plane strain"), 0.4, repeat=False)  # Warms imports and the mesher's process.
    groups = [(chart, group) for chart in charts for group in chart.groups]
    needed = [line.reference for _, group in groups for line in group.lines]
    needed += [each for _, group in groups for each in group.references]
    solved = dict[Reference, Run]()
    for each in dict.fromkeys(needed):
        size = each.quick_size_mm if quick else each.size_mm
        solved[each] = run(each.method, size, False)
        if why := solved[each].failure:
            raise SolverError(f"the reference {each.name} failed: {why}")
    points: list[Point] = []
    differences: dict[tuple[str, str], Errors] = {}
    remarks: dict[str, list[str]] = {chart.key: [] for chart in charts}
    for chart, group in groups:
        first, second = (solved[each].known for each in group.references)
        differences[chart.key, group.heading] = errors(first, second)
        for line in group.lines:
            sizes = line.sizes[: line.quick if quick else None]
            runs = [run(line.method, size, not quick) for size in sizes]
            known = solved[line.reference].known
            new = [Point(chart.key, group.heading, line, each, each.errors(known)) for each in runs]
            points += new
            remarks[chart.key] += _remarks(group, line, new)
    return Precision(tuple(points), differences, remarks, solved, tuple(charts))


def describe(method: Method) -> str:
    """Return a method in words."""
    plates = "" if method.plates == "solid" else f", plates: {method.plates}"
    element = "" if method.element == "auto" else f", {method.element}"
    body = method.finger or f"nu = {method.poissons_ratio:g}"
    return f"{method.kind}{element}, {body}{plates}"


def _remarks(group: Group, line: Line, points: Sequence[Point]) -> list[str]:
    """List failures, and large errors of the finest mesh."""
    name = f"{line.label} ({group.heading})"
    failed = [point.run for point in points if point.run.failure]
    notes = [f"{name}, {run.size_mm:g} mm: failed: {run.failure}" for run in failed]
    for point in [point for point in points if point.errors][-1:]:
        run, worst, gage = point.run, point.errors["normal_force_error"], point.errors["gage_error"]
        if worst > _LARGE:
            left = f"F_n still {worst:.0%} off at {run.size_mm:g} mm ({run.dofs} dofs)"
            notes.append(f"{name}: {line.floor}: {left}" if line.floor else f"{name}: {left}")
        if gage > OFF_THE_CHART:
            notes.append(f"{name}: gage strain {gage:.0f} times off, off the chart")
    return notes
