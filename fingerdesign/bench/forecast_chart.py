"""Forecasts drawn: what was foretold over what was measured, one panel a quantity."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fingerdesign.bench.growth import tick
from fingerdesign.bench.machine import caption
from fingerdesign.report.style import PAPER, SERIES, canvas, house_style

_PANELS = (("dofs", "dofs"), ("memory_MB", "peak memory, MB"), ("time_s", "time, s"))
_FOOT = (
    "One process an analysis, from the design to the report, mesh cache empty. Time: for the "
    "machine's speed as measured before and after each. Lines: equal, and the factor of 2 asked."
)


def draw_forecasts(records: Sequence[dict[str, Any]], machine: dict[str, Any], path: Path) -> None:
    """Three panels, logarithmic, with the line of equality and the band of a factor of two."""
    done = [each for each in records if each["status"] == "ok"]
    kinds = list(dict.fromkeys(kind(each) for each in done))
    with house_style():
        figure = canvas(12.5, 4.9)
        parts: Any = figure.subfigures(2, 1, height_ratios=[4.0, 0.9])
        top, bottom = parts
        for axes, (name, words) in zip(top.subplots(1, 3), _PANELS, strict=True):
            every = [each[name] for each in done] + [each["forecast"][name] for each in done]
            ends = [0.7 * min(every), 1.4 * max(every)]
            for factor, dashes in ((0.5, ":"), (1.0, "-"), (2.0, ":")):
                axes.plot(ends, [factor * end for end in ends], dashes, color="#888888", lw=1.0)
            for number, each_kind in enumerate(kinds):
                colour, _, marker = SERIES[number % len(SERIES)]
                mine = [each for each in done if kind(each) == each_kind]
                axes.plot(
                    [each[name] for each in mine],
                    [each["forecast"][name] for each in mine],
                    color=colour,
                    marker=marker,
                    linestyle="none",
                    label=f"{each_kind} ({len(mine)})",
                )
            axes.set(xscale="log", yscale="log", xlim=ends, ylim=ends)
            axes.set_title(f"{words}: foretold over measured")
            axes.set_xlabel("measured")
            tick(axes.xaxis)
            tick(axes.yaxis)
        top.axes[0].legend(loc="upper left", fontsize=8)
        text = f"{_FOOT}\n{caption(machine)}"
        bottom.text(0.008, 0.98, text, va="top", fontsize=7.5, linespacing=1.3)
        figure.savefig(path, dpi=110, facecolor=PAPER)


def kind(record: dict[str, Any]) -> str:
    """How a record's finger was meshed."""
    mesher = {"netgen": "plane strain", "extrude": "3-D, extruded"}
    return mesher.get(record["forecast"]["mesher"], "3-D, fTetWild")
