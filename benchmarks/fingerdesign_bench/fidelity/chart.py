"""The ladder against one model for all: its price, what holds, and whether it knows its error."""

from pathlib import Path

from fingerdesign.analysis.fidelity.estimate import of_most
from fingerdesign.report.style import Axes, canvas
from fingerdesign_bench.chart import save
from fingerdesign_bench.fidelity.judge import FidelityBench

_MARKS = {0.01: "o", 0.02: "s", 0.05: "^", 0.1: "D"}
_COLOURS = {"plane strain": "#d2560a", "3-D": "#0b6fb0"}


def draw_fidelity(found: FidelityBench, path: Path) -> Path:
    """Left: seconds over all pairs against readings that hold; right: stated and true errors."""
    figure = canvas(11.5, 4.8)
    left, right = figure.subplots(1, 2)
    _prices(left, found)
    _estimates(right, found)
    for axes in (left, right):
        axes.grid(alpha=0.25)
    return save(figure, path, 130)


def _prices(axes: Axes, found: FidelityBench) -> None:
    for dimension in ("plane strain", "3-D"):
        mine = [each for each in found.fixed if each.name.startswith(dimension)]
        axes.plot(
            [each.seconds for each in mine],
            [100 * each.within for each in mine],
            marker="o" if dimension == "3-D" else "s",
            color=_COLOURS[dimension],
            label=f"one model for all, {dimension}",
        )
        for number, each in enumerate(mine):
            flat = dimension != "3-D"
            axes.annotate(
                f"{each.name.split(', ')[1]}: {each.meets}/{each.solved}",
                (each.seconds, 100 * each.within),
                xytext=(0, 12 if flat and number % 2 else -15) if flat else (7, -12),
                textcoords="offset points",
                ha="center" if flat else "left",
                fontsize=7,
            )
    axes.plot(
        found.seconds, 100 * found.within, "*", color="#0a8f6b", markersize=16, label="the ladder"
    )
    axes.axhline(95.0, color="#6c6f73", linewidth=1.0, linestyle=":")
    axes.margins(x=0.13)
    axes.set(
        xscale="log",
        xlabel="seconds over all pairs (labels: sizes, and pairs whose tolerance they meet)",
        ylabel="readings within the tolerance, %",
    )
    axes.legend(fontsize=8, loc="lower right")
    axes.set_title(
        f"The ladder takes 1/{1 / found.seconds_share:.1f} of {found.rival.name}",
        loc="left",
        fontsize=10,
    )


def _estimates(axes: Axes, found: FidelityBench) -> None:
    for tolerance, mark in _MARKS.items():
        for dimension, colour in _COLOURS.items():
            mine = [
                each
                for each in found.outcomes
                if each.pair.tolerance == tolerance
                and each.ladder.chosen.model.dimension == dimension
                and each.ladder.estimate is not None
            ]
            if mine:
                axes.scatter(
                    [100 * each.ladder.estimate.worst for each in mine if each.ladder.estimate],
                    [max(100 * of_most(each.true_errors), 1e-2) for each in mine],
                    marker=mark,
                    color=colour,
                    label=f"{100 * tolerance:g} % tolerance, {dimension}",
                )
    ends = (0.05, 20.0)
    axes.plot(ends, ends, color="#6c6f73", linewidth=1.0, linestyle=":")
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="error that the ladder states, % (worst quantity)",
        ylabel="true error of 95 % of the readings, %",
    )
    axes.legend(fontsize=7, loc="upper left")
    axes.set_title("Estimated and true error", loc="left", fontsize=10)
