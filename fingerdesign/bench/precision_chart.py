"""The work-precision diagrams drawn: a row of panels a group, all that must be said underneath."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.bench.check import plain
from fingerdesign.bench.machine import caption
from fingerdesign.bench.precision import (
    NORM,
    OFF_THE_CHART,
    QUANTITIES,
    TIMED,
    Point,
    Precision,
)
from fingerdesign.bench.precision_plan import Chart, Group
from fingerdesign.bench.precision_run import STAGES
from fingerdesign.report.style import COLOURS, MUTED, PAPER, SERIES, canvas, house_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
