"""Pictures of the work-precision diagrams."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.report.style import COLOURS, SERIES, Axes, house_style, series
from fingerdesign_bench.chart import footed, save, tick
from fingerdesign_bench.speed.precision_lines import Chart, Group, Reference
from fingerdesign_bench.speed.precision_points import NORM, OFF_THE_CHART, TIMED, Point, Precision
from fingerdesign_bench.speed.precision_run import QUANTITIES

_ROW = 3.0  # Inches: a row of panels.


def draw_chart(found: Precision, chart: Chart, machine: str, path: Path) -> Path:
    """Draw one chart: a row of panels a group, errors against seconds, log-log."""
    with house_style():
        foot = [*_foot(found, chart), machine]
        figure, top = footed(_ROW * len(chart.groups) + 0.4, foot, chart.title)
        grid = top.subplots(len(chart.groups), len(QUANTITIES), squeeze=False, sharex="row")
        for row, group in zip(grid, chart.groups, strict=True):
            _draw_group(list(row), found, chart, group)
        return save(figure, path)


def draw_fingers(found: Precision, chart: Chart, path: Path) -> Path:
    """Draw errors against operations, which no load of the machine changes, in panels that all
    fingers share."""
    panels = {"forces, relative": list(QUANTITIES)[:2]}
    panels |= {QUANTITIES[key]: [key] for key in list(QUANTITIES)[2:]}
    with house_style():
        foot = [f"Thin: a finger; thick: the geometric mean. {NORM}."]
        figure, top = footed(_ROW + 0.4, foot, chart.title)
        row = top.subplots(1, len(panels))
        for axes, (title, keys) in zip(row, panels.items(), strict=True):
            axes.set(xscale="log", yscale="log", title=title, xlabel="Gflop of the factorisation")
            for number, line in enumerate(chart.groups[0].lines):
                mine = (chart.key, line.label)
                own = [p for p in found.points if (p.chart, p.line.label) == mine]
                _draw_method(axes, number, [p for p in own if p.errors], keys)
            tick(axes.xaxis)
        row[0].set_ylabel("worst error")
        row[-1].legend(loc="upper left", bbox_to_anchor=(1.01, 1.02), fontsize=7.5)
        return save(figure, path)


def _draw_method(axes: Axes, number: int, points: Sequence[Point], keys: Sequence[str]) -> None:
    """Draw work and error of a method: a thin line a finger, a thick one of their means."""
    if not points:
        return
    fingers: dict[str, Any] = {}
    sizes: dict[float, Any] = {}
    for point in points:
        value = (point.run.gflop, max(point.errors[key] or 1e-9 for key in keys))
        fingers.setdefault(point.group, []).append(value)
        sizes.setdefault(point.run.size_mm, []).append(np.log(value))
    for values in fingers.values():
        axes.plot(*np.transpose(values), color=SERIES[number][0], linewidth=0.6, alpha=0.4)
    means = np.exp([np.mean(each, axis=0) for each in sizes.values()])
    series(axes, means[:, 0], means[:, 1], number, points[0].line.label)


def _draw_group(row: list[Axes], found: Precision, chart: Chart, group: Group) -> None:
    differences = found.differences[chart.key, group.heading]
    mine = [p for p in found.points if (p.chart, p.group) == (chart.key, group.heading)]
    for axes, (key, difference) in zip(row, differences.items(), strict=True):
        axes.set(xscale="log", yscale="log", title=QUANTITIES[key], xlabel="seconds")
        if difference > 0.0:  # An error in this band is not known: the references differ by it.
            axes.axhspan(1e-12, difference, color=COLOURS["open"], zorder=0)
        shown = []
        for number, line in enumerate(group.lines):
            own = [(p.run.total, p.errors.get(key, np.inf)) for p in mine if p.line == line]
            drawn = [(seconds, max(e, 1e-9)) for seconds, e in own if e <= OFF_THE_CHART]
            errors = [error for _, error in drawn]
            series(axes, [seconds for seconds, _ in drawn], errors, number, line.label)
            shown += errors
        if shown:
            low = max(0.5 * min(shown), 0.03 * difference, 1e-8)
            axes.set_ylim(min(low, 0.2 * max(shown)), 2.0 * max(shown))
        tick(axes.xaxis)
    row[0].set_ylabel(f"{group.heading}\nworst error")
    row[-1].legend(loc="upper left", bbox_to_anchor=(1.01, 1.02), fontsize=7.5)


def _foot(found: Precision, chart: Chart) -> list[str]:
    lines = [f"{NORM}. {TIMED}."]
    for group in chart.groups:
        pairs = [f"{line.label}: {_reference(found, line.reference)}" for line in group.lines]
        lines.append(f"References, {group.heading}: {'; '.join(pairs)}. They differ by the band.")
    remarks = found.remarks[chart.key]
    lines.append("Failures and floors: " + ("; ".join(remarks) if remarks else "none") + ".")
    return lines


def _reference(found: Precision, reference: Reference) -> str:
    run = found.references[reference]
    return f"{reference.name} ({run.element}, {run.size_mm:g} mm, {run.dofs} dofs)"
