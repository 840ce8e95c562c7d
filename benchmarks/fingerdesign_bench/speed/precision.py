"""Work-precision diagrams: errors of forces, stick ratio and gage strains against wall time."""

from __future__ import annotations

import csv
import json
import math
import os
import textwrap
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.errors import SolverError
from fingerdesign.report.style import COLOURS, MUTED, PAPER, SERIES, canvas, house_style
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import plain
from fingerdesign_bench.machine import caption, machine
from fingerdesign_bench.speed.precision_plan import (
    CHARTS,
    REFERENCES,
    Chart,
    Group,
    Line,
    Reference,
)
from fingerdesign_bench.speed.precision_run import STAGES, Method, Run, errors, measured

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Errors = tuple[float, float, float, float]

QUANTITIES = {
    "normal_force_error": "normal force, relative",
    "tangential_force_error": "tangential force, relative",
    "stick_ratio_error": "stick ratio, absolute",
    "gage_error": "gage strain, of the largest",
}
NORM = (
    "Error: the worst of five increments; gages: membrane strain of three plates, relative to the "
    "largest reading of the increment"
)
TIMED = (
    "Time: design to last increment in a process that has made one run before (imports and the "
    "mesher's own start are left out), no cache; the least of 2 to 3 runs where they are short"
)
OFF_THE_CHART = 5.0  # an error as large tells that there is no answer, and needs no place
_LARGE = 0.02  # of F_n: what is still this far off on its finest mesh does not converge


@dataclass(frozen=True)
class Point:
    """One run in one line of a chart. Errors are None where it failed; ``failure`` says why."""

    chart: str
    group: str
    line: str
    reference: str
    size_mm: float
    element: str
    dofs: int
    contact_nodes: int
    seconds: float
    geometry_s: float
    mesh_s: float
    assemble_s: float
    condense_s: float
    increments_s: float
    runs: int
    normal_force_error: float | None
    tangential_force_error: float | None
    stick_ratio_error: float | None
    gage_error: float | None
    failure: str = ""

    def error(self, key: str) -> float | None:
        """The error of one of QUANTITIES."""
        value: float | None = getattr(self, key)
        return value


@dataclass(frozen=True)
class Precision:
    """Everything that the diagrams show.

    doubts: how far the two references of each (chart, group) differ, in the order of QUANTITIES.
    remarks: what failed or does not converge, by chart.
    """

    points: tuple[Point, ...]
    doubts: dict[tuple[str, str], Errors]
    remarks: dict[str, tuple[str, ...]]
    references: dict[str, Run]
    machine: dict[str, Any]
    charts: tuple[Chart, ...]
    seconds: float
    cpu_seconds: float
    quick: bool


def measure_precision(
    report: Report = lambda message: None,
    quick: bool = False,
    charts: Sequence[Chart] = CHARTS,
    references: Sequence[Reference] = REFERENCES,
) -> Precision:
    """All points of ``charts``: six minutes on two quiet cores; ``quick``: half a minute.

    A run that fails is a point with its reason. Raises SolverError where a reference fails.
    """
    began, used = time.perf_counter(), _processor_seconds()
    found_machine = machine()
    wanted = {name for chart in charts for group in chart.groups for name in _names(group)}
    kept: dict[tuple[Method, float], Run] = {}

    def run(method: Method, size: float, repeat: bool) -> Run:
        key = (method, size)
        if key not in kept:
            report(f"{describe(method)}, {size:g} mm")
            kept[key] = measured(method, size, repeat)
        return kept[key]

    measured(Method("plane strain"), 0.4, repeat=False)  # warms imports and the mesher's process
    solved: dict[str, Run] = {}
    for each in references:
        if each.name in wanted:
            result = run(each.method, each.quick_size_mm if quick else each.size_mm, False)
            if result.answers is None:
                raise SolverError(f"the reference {each.name} failed: {result.failure}")
            solved[each.name] = result
    points: list[Point] = []
    doubts: dict[tuple[str, str], Errors] = {}
    remarks: dict[str, tuple[str, ...]] = {}
    for chart in charts:
        said: list[str] = []
        for group in chart.groups:
            first, second = (solved[name].answers for name in group.doubt)
            assert first is not None
            assert second is not None
            doubts[chart.key, group.heading] = errors(first, second)
            for line in group.lines:
                sizes = line.sizes[: line.quick] if quick else line.sizes
                new = [
                    _point(chart, group, line, run(line.method, size, not quick), solved)
                    for size in sizes
                ]
                points += new
                said += _remarks(group, line, new)
        remarks[chart.key] = tuple(said)
    return Precision(
        tuple(points),
        doubts,
        remarks,
        solved,
        found_machine,
        tuple(charts),
        time.perf_counter() - began,
        _processor_seconds() - used,
        quick,
    )


def write_precision(found: Precision, folder: Path) -> list[Path]:
    """precision.csv, precision.json and a picture a chart, and one of the stages."""
    folder.mkdir(parents=True, exist_ok=True)
    table, record = folder / "precision.csv", folder / "precision.json"
    with table.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(asdict(found.points[0])), lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(point) for point in found.points)
    record.write_text(json.dumps(_record(found), indent=1, allow_nan=False) + "\n", "utf-8")
    pictures = []
    for chart in found.charts:
        pictures.append(folder / f"precision-{chart.key}.png")
        draw_chart(found, chart, pictures[-1])
    pictures.append(folder / "precision-stages.png")
    draw_stages(found, pictures[-1])
    return [table, record, *pictures]


def describe(method: Method) -> str:
    """A method in words."""
    plates = "" if method.plates == "solid" else f", plates: {method.plates}"
    element = "" if method.element == "auto" else f", {method.element}"
    full = ", full at each iteration" if method.solve == "full" else ""
    return f"{method.kind}{element}, nu = {method.poissons_ratio:g}{plates}{full}"


def _names(group: Group) -> set[str]:
    return {*group.doubt, *(line.reference for line in group.lines)}


def _point(chart: Chart, group: Group, line: Line, run: Run, solved: dict[str, Run]) -> Point:
    reference = solved[line.reference].answers
    assert reference is not None
    normal, tangential, stick, gage = (
        (None,) * 4 if run.answers is None else errors(run.answers, reference)
    )
    stages = {f"{name}_s": run.seconds.get(name, 0.0) for name in STAGES}
    return Point(
        chart=chart.key,
        group=group.heading,
        line=line.label,
        reference=line.reference,
        size_mm=run.size_mm,
        element=run.element,
        dofs=run.dofs,
        contact_nodes=run.contact_nodes,
        seconds=run.total,
        runs=run.runs,
        normal_force_error=normal,
        tangential_force_error=tangential,
        stick_ratio_error=stick,
        gage_error=gage,
        failure=run.failure,
        **stages,
    )


def _remarks(group: Group, line: Line, points: Sequence[Point]) -> list[str]:
    """What failed, and what its finest mesh leaves."""
    name = f"{line.label} ({group.heading})"
    said = [f"{name}, {p.size_mm:g} mm: failed: {p.failure}" for p in points if p.failure]
    last = [point for point in points if not point.failure][-1:]
    for point in last:
        worst = point.normal_force_error
        if worst is not None and worst > _LARGE:
            left = f"F_n still {worst:.0%} off at {point.size_mm:g} mm ({point.dofs} dofs)"
            said.append(f"{name}: {line.floor}: {left}" if line.floor else f"{name}: {left}")
        if point.gage_error is not None and point.gage_error > OFF_THE_CHART:
            said.append(f"{name}: gage strain {point.gage_error:.0f} times off, off the chart")
    return said


def _record(found: Precision) -> dict[str, Any]:
    return {
        "machine": found.machine,
        "norm": NORM,
        "timed": TIMED,
        "quick": found.quick,
        "seconds": round(found.seconds, 1),
        "processor_seconds": round(found.cpu_seconds, 1),
        "references": {
            name: {
                "method": describe(run.method),
                "element": run.element,
                "size_mm": run.size_mm,
                "dofs": run.dofs,
                "seconds": round(run.total, 2),
            }
            for name, run in found.references.items()
        },
        "references_differ": [
            {"chart": chart, "group": group, **dict(zip(QUANTITIES, values, strict=True))}
            for (chart, group), values in found.doubts.items()
        ],
        "remarks": found.remarks,
    }


def _processor_seconds() -> float:
    """Of this process and of those that it started and that have ended."""
    times = os.times()
    return float(times.user + times.system + times.children_user + times.children_system)


# The work-precision diagrams drawn: a row of panels a group, all that must be said underneath.

_WIDTH = 12.5  # inches
_ROW = 3.0
_LINE = 0.165  # a line of small text
_LETTERS = 215
_TETWILD = (
    "The time of fTetWild does not follow the size: its own optimisation dominates it, and varies."
)
_STAGE_LOOKS = (
    (COLOURS["muted"], ""),
    (COLOURS["blue"], "//"),
    (COLOURS["green"], ".."),
    (COLOURS["vermilion"], ""),
    (COLOURS["purple"], "xx"),
)


def draw_chart(found: Precision, chart: Chart, path: Path) -> None:
    """One chart: panels by quantity, errors against seconds, log-log."""
    foot = _wrapped(_foot(found, chart))
    panels, below = _ROW * len(chart.groups) + 0.4, _LINE * (len(foot) + 1)
    with house_style():
        figure = canvas(_WIDTH, panels + below)
        parts: Any = figure.subfigures(2, 1, height_ratios=[panels, below])
        top, bottom = parts
        top.suptitle(chart.title, x=0.01, ha="left", fontsize=12, fontweight="bold")
        grid = top.subplots(len(chart.groups), len(QUANTITIES), squeeze=False, sharex="row")
        for row, group in zip(grid, chart.groups, strict=True):
            _draw_group(list(row), found, chart, group)
        bottom.text(0.008, 0.98, "\n".join(foot), va="top", fontsize=7.5, linespacing=1.3)
        _save(figure, path)


def _draw_group(row: list[Axes], found: Precision, chart: Chart, group: Group) -> None:
    doubts = found.doubts[chart.key, group.heading]
    mine = [p for p in found.points if p.chart == chart.key and p.group == group.heading]
    for axes, (key, title), doubt in zip(row, QUANTITIES.items(), doubts, strict=True):
        shown: list[float] = []
        away: list[str] = []
        for number, line in enumerate(group.lines):
            colour, dashes, marker = SERIES[number % len(SERIES)]
            points = [p for p in mine if p.line == line.label and p.error(key) is not None]
            every = [max(p.error(key) or 0.0, 1e-9) for p in points]
            values = [value if value <= OFF_THE_CHART else math.nan for value in every]
            shown += [value for value in values if value <= OFF_THE_CHART]
            seconds = [p.seconds for p in points]
            axes.plot(
                seconds, values, color=colour, linestyle=dashes, marker=marker, label=line.label
            )
            off = [p for p, value in zip(points, every, strict=True) if value > OFF_THE_CHART]
            if off:
                rim: Any = {"transform": axes.get_xaxis_transform(), "clip_on": False}
                top = [1.0] * len(off)
                axes.plot([p.seconds for p in off], top, "^", color=colour, ms=6, **rim)
                count = "" if len(off) == len(points) else f"{len(off)} of {len(points)} points "
                away.append(f"{line.label}: {count}off the chart (to {plain(max(every))})")
        if doubt > 0.0:
            axes.axhspan(1e-12, doubt, color=COLOURS["open"], zorder=0)
        axes.set_xscale("log")
        axes.set_yscale("log")
        if shown:
            _span_errors(axes, min(shown), max(shown) * (2.0 if away else 1.0), doubt)
        if away:
            said = "\n".join(away)
            axes.text(0.97, 0.95, said, transform=axes.transAxes, ha="right", va="top", fontsize=8)
        axes.set_title(title)
        axes.set_xlabel("seconds")
    _tick_seconds(row)
    row[0].set_ylabel(f"{group.heading}\nworst error")
    row[-1].legend(loc="upper left", bbox_to_anchor=(1.01, 1.02), fontsize=7.5)


def _span_errors(axes: Axes, least: float, most: float, doubt: float) -> None:
    """From the least error, or well into the doubt, to the largest; a decade at least."""
    from matplotlib.ticker import NullFormatter

    low, high = max(0.5 * least, 0.03 * doubt, 1e-8), 2.0 * most
    low = min(low, 0.1 * high)
    axes.set_ylim(low, high)
    axes.yaxis.set_minor_formatter(NullFormatter())


def _tick_seconds(row: list[Axes]) -> None:
    """A decade at least, and plain numbers on it."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = row[0].get_xlim()
    spare = max(1.0, (10.0 / (high / low)) ** 0.5)
    decades = math.log10(high / low * spare * spare)
    marked = (1.0, 2.0, 5.0) if decades < 1.7 else (1.0, 3.0) if decades < 2.7 else (1.0,)
    for axes in row:
        axes.set_xlim(low / spare, high * spare)
        axes.xaxis.set_major_locator(LogLocator(subs=marked))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())


def _foot(found: Precision, chart: Chart) -> list[str]:
    lines = [f"{NORM}. {TIMED}."]
    for group in chart.groups:
        names = dict.fromkeys(line.reference for line in group.lines)
        judged = "; ".join(
            f"{_reference(found, name)} judges "
            + " and ".join(line.label for line in group.lines if line.reference == name)
            for name in names
        )
        other = [name for name in group.doubt if name not in names]
        more = "".join(f"; also {_reference(found, name)}" for name in other)
        lines.append(
            f"References, {group.heading}: {judged}{more}. "
            f'Grey band: the two references "{group.doubt[0]}" and "{group.doubt[1]}" differ by '
            "that much."
        )
    bare = _without_plates(chart)
    if bare:
        lines.append(f"Gages of {bare}: strain of the rubber where three plates would be.")
    if any(line.method.kind == "tetwild" for group in chart.groups for line in group.lines):
        lines.append(_TETWILD)
    said = found.remarks[chart.key]
    lines.append("Failures and floors: " + ("; ".join(said) if said else "none") + ".")
    lines += caption(found.machine).splitlines()
    return lines


def _without_plates(chart: Chart) -> str:
    """The groups without plates, and the lines without among others with them."""
    names = []
    for group in chart.groups:
        lines = [line for line in group.lines if line.method.plates == "none"]
        if len(lines) == len(group.lines):
            names.append(group.heading)
        else:
            names += [f"{line.label} ({group.heading})" for line in lines]
    return "; ".join(names)


def _reference(found: Precision, name: str) -> str:
    run = found.references[name]
    return f"{name} ({run.element}, {run.size_mm:g} mm, {run.dofs} dofs)"


def draw_stages(found: Precision, path: Path) -> None:
    """Where the time goes: the finest run of each line, its stages as shares of its seconds."""
    chosen = _finest(found.points)
    foot = _wrapped([f"The finest run of each line of the diagrams. {TIMED}.", *_machine(found)])
    panel, below = 0.3 * len(chosen) + 1.2, _LINE * (len(foot) + 1)
    with house_style():
        figure = canvas(_WIDTH, panel + below)
        parts: Any = figure.subfigures(2, 1, height_ratios=[panel, below])
        top, bottom = parts
        top.suptitle("Where the time goes", x=0.01, ha="left", fontsize=12, fontweight="bold")
        axes = top.subplots()
        rows = range(len(chosen))
        left = [0.0] * len(chosen)
        for (colour, hatch), stage in zip(_STAGE_LOOKS, STAGES, strict=True):
            shares = [100.0 * getattr(p, f"{stage}_s") / max(p.seconds, 1e-12) for p in chosen]
            axes.barh(
                rows,
                shares,
                left=left,
                color=colour,
                edgecolor=PAPER,
                hatch=hatch,
                height=0.72,
                label=stage,
            )
            left = [a + b for a, b in zip(left, shares, strict=True)]
        for row, point in zip(rows, chosen, strict=True):
            size = f"{point.seconds:.3g} s, {point.dofs / 1000:.0f}k dofs"
            axes.text(101, row, size, va="center", fontsize=8, color=MUTED)
        names = [f"{p.line} ({p.group})" for p in chosen]
        axes.set_yticks(list(rows), names)
        axes.invert_yaxis()
        axes.set_xlim(0, 118)
        axes.set_xticks(range(0, 101, 20))
        axes.set_xlabel("% of the time")
        axes.grid(False, axis="y")
        axes.legend(loc="lower center", bbox_to_anchor=(0.42, 1.0), ncols=len(STAGES))
        bottom.text(0.008, 0.98, "\n".join(foot), va="top", fontsize=7.5, linespacing=1.3)
        _save(figure, path)


def _finest(points: Sequence[Point]) -> list[Point]:
    """The last run of each line that did not fail, each method once."""
    finest: dict[tuple[str, str], Point] = {}
    for point in points:
        if not point.failure:
            finest[point.group, point.line] = point
    seen: set[tuple[float, int]] = set()
    kept = []
    for point in finest.values():
        if (point.seconds, point.dofs) not in seen:
            seen.add((point.seconds, point.dofs))
            kept.append(point)
    return kept


def _machine(found: Precision) -> list[str]:
    return caption(found.machine).splitlines()


def _wrapped(lines: Sequence[str]) -> list[str]:
    return [part for line in lines for part in textwrap.wrap(line, _LETTERS)]


def _save(figure: Figure, path: Path) -> None:
    figure.savefig(path, dpi=110, facecolor=PAPER)
