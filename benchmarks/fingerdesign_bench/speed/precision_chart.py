"""Pictures of the work-precision diagrams, and of the time that each stage takes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.report.style import COLOURS, MUTED, PAPER, SERIES, house_style
from fingerdesign_bench.chart import footed, save, tick
from fingerdesign_bench.machine import caption
from fingerdesign_bench.speed.precision_points import NORM, OFF_THE_CHART, QUANTITIES, TIMED
from fingerdesign_bench.speed.precision_run import STAGES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fingerdesign_bench.speed.precision_lines import Chart, Group
    from fingerdesign_bench.speed.precision_points import Point, Precision

_ROW = 3.0  # Inches: a row of panels.
_STAGE_LOOKS = (
    (COLOURS["muted"], ""),
    (COLOURS["blue"], "//"),
    (COLOURS["green"], ".."),
    (COLOURS["vermilion"], ""),
    (COLOURS["purple"], "xx"),
)


def draw_chart(found: Precision, chart: Chart, path: Path) -> None:
    """Draw one chart: a row of panels a group, errors against seconds, log-log."""
    with house_style():
        figure, top = footed(_ROW * len(chart.groups) + 0.4, _foot(found, chart), chart.title)
        grid = top.subplots(len(chart.groups), len(QUANTITIES), squeeze=False, sharex="row")
        for row, group in zip(grid, chart.groups, strict=True):
            _draw_group(list(row), found, chart, group)
        save(figure, path)


def draw_stages(found: Precision, path: Path) -> None:
    """Draw the finest run of each line, its stages as percentages of its seconds."""
    finest = {(p.group, p.line): p for p in found.points if not p.failure}
    chosen = list({(p.seconds, p.dofs): p for p in finest.values()}.values())
    foot = [f"The finest run of each line of the diagrams. {TIMED}.", caption(found.machine)]
    with house_style():
        figure, top = footed(0.3 * len(chosen) + 1.2, foot, "Where the time goes")
        axes = top.subplots()
        rows = range(len(chosen))
        left = [0.0] * len(chosen)
        for (colour, hatch), stage in zip(_STAGE_LOOKS, STAGES, strict=True):
            parts = [100.0 * getattr(p, f"{stage}_s") / max(p.seconds, 1e-12) for p in chosen]
            look = {"color": colour, "edgecolor": PAPER, "hatch": hatch, "height": 0.72}
            axes.barh(rows, parts, left=left, label=stage, **look)
            left = [a + b for a, b in zip(left, parts, strict=True)]
        for row, point in zip(rows, chosen, strict=True):
            size = f"{point.seconds:.3g} s, {point.dofs / 1000:.0f}k dofs"
            axes.text(101, row, size, va="center", fontsize=8, color=MUTED)
        axes.set_yticks(list(rows), [f"{p.line} ({p.group})" for p in chosen])
        axes.invert_yaxis()
        axes.set_xlim(0, 118)
        axes.set_xlabel("% of the time")
        axes.grid(False, axis="y")
        axes.legend(loc="lower center", bbox_to_anchor=(0.42, 1.0), ncols=len(STAGES))
        save(figure, path)


def _draw_group(row: list[Axes], found: Precision, chart: Chart, group: Group) -> None:
    differences = found.differences[chart.key, group.heading]
    mine = [p for p in found.points if (p.chart, p.group) == (chart.key, group.heading)]
    for axes, key, difference in zip(row, QUANTITIES, differences, strict=True):
        axes.set(xscale="log", yscale="log", title=QUANTITIES[key], xlabel="seconds")
        if difference > 0.0:  # An error in this band is not known: the references differ by it.
            axes.axhspan(1e-12, difference, color=COLOURS["open"], zorder=0)
        shown = []
        for number, line in enumerate(group.lines):
            points = _shown([p for p in mine if p.line == line.label], key)
            colour, dashes, marker = SERIES[number % len(SERIES)]
            look: Any = {"color": colour, "linestyle": dashes, "marker": marker}
            axes.plot(*points, label=line.label, **look)
            shown += points[1]
        if shown:
            low = max(0.5 * min(shown), 0.03 * difference, 1e-8)
            axes.set_ylim(min(low, 0.2 * max(shown)), 2.0 * max(shown))
        tick(axes.xaxis)
    row[0].set_ylabel(f"{group.heading}\nworst error")
    row[-1].legend(loc="upper left", bbox_to_anchor=(1.01, 1.02), fontsize=7.5)


def _shown(points: Sequence[Point], key: str) -> tuple[list[float], list[float]]:
    """Seconds and errors of the points that are on the chart."""
    own = [(point.seconds, point.error(key)) for point in points]
    found = [(s, max(e, 1e-9)) for s, e in own if e is not None and e <= OFF_THE_CHART]
    return [s for s, _ in found], [e for _, e in found]


def _foot(found: Precision, chart: Chart) -> list[str]:
    lines = [f"{NORM}. {TIMED}."]
    for group in chart.groups:
        pairs = [f"{line.label}: {_reference(found, line.reference)}" for line in group.lines]
        lines.append(f"References, {group.heading}: {'; '.join(pairs)}. They differ by the band.")
    remarks = found.remarks[chart.key]
    lines.append("Failures and floors: " + ("; ".join(remarks) if remarks else "none") + ".")
    return [*lines, caption(found.machine)]


def _reference(found: Precision, name: str) -> str:
    run = found.references[name]
    return f"{name} ({run.element}, {run.size_mm:g} mm, {run.dofs} dofs)"
