"""How time and memory grow with the model: power laws fitted to a series of meshes, and drawn."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.report.style import PAPER, SERIES, canvas, house_style
from fingerdesign_bench.machine import caption

if TYPE_CHECKING:
    from matplotlib.axis import Axis


@dataclass(frozen=True)
class Size:
    """One mesh of a series: its model's seconds and peak memory, and seconds an increment.

    Times are the least of the runs; ``cold_s`` is the whole first run of a new process.
    memory_MB: beyond the ``base_MB`` of the process before the case.
    """

    kind: str
    dofs: int
    contact_nodes: int
    mesh_s: float
    assemble_s: float
    condense_s: float
    model_s: float
    increment_s: float
    worst_increment_s: float
    total_s: float
    cold_s: float
    memory_MB: float
    base_MB: float


@dataclass(frozen=True)
class Growth:
    """y = factor x^exponent, fitted in logarithms over the series of one kind."""

    kind: str
    quantity: str
    against: str
    exponent: float
    factor: float


_POINTS = 3  # through fewer a law is not fitted

# quantity of a Size -> what it grows with, and in words
LAWS = (
    ("model_s", "dofs", "model, s"),
    ("memory_MB", "dofs", "peak memory of the model, MB"),
    ("increment_s", "contact_nodes", "mean increment, s"),
)


def fit(kind: str, sizes: Sequence[Size]) -> list[Growth]:
    """The power laws of one kind's series, where it has three different sizes or more."""
    mine = [each for each in sizes if each.kind == kind]
    laws = []
    for quantity, against, _ in LAWS:
        if len({getattr(each, against) for each in mine}) < _POINTS:
            continue
        x = np.log([getattr(each, against) for each in mine])
        y = np.log([max(getattr(each, quantity), 1e-9) for each in mine])
        exponent, level = np.polyfit(x, y, 1)
        laws.append(Growth(kind, quantity, against, float(exponent), float(np.exp(level))))
    return laws


_TIMED = (
    "One process a mesh; times: the least of the runs after the first, imports left out, no cache. "
    "Model: mesh, assembly and condensation; memory: beyond that of the process before."
)


def draw_growth(
    sizes: Sequence[Size],
    laws: Sequence[Growth],
    machine: dict[str, Any],
    path: Path,
    notes: Sequence[str] = (),
) -> None:
    """Model time and memory against dofs, increment time against contact nodes, log-log."""
    kinds = list(dict.fromkeys(each.kind for each in sizes))
    with house_style():
        figure = canvas(12.5, 4.7)
        parts: Any = figure.subfigures(2, 1, height_ratios=[3.6, 1.1])
        top, bottom = parts
        row = top.subplots(1, len(LAWS))
        for axes, (quantity, against, words) in zip(row, LAWS, strict=True):
            for number, kind in enumerate(kinds):
                colour, dashes, marker = SERIES[number % len(SERIES)]
                mine = [each for each in sizes if each.kind == kind]
                x = [getattr(each, against) for each in mine]
                law = [e for e in laws if e.kind == kind and e.quantity == quantity]
                label = f"{kind}: power {law[0].exponent:.2f}" if law else kind
                axes.plot(
                    x,
                    [getattr(each, quantity) for each in mine],
                    color=colour,
                    linestyle="none",
                    marker=marker,
                    label=label,
                )
                if law:
                    ends = np.array([min(x), max(x)], dtype=float)
                    fitted = law[0].factor * ends ** law[0].exponent
                    axes.plot(ends, fitted, color=colour, linestyle=dashes)
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_title(words)
            axes.set_xlabel(against.replace("_", " "))
            axes.legend(loc="best", fontsize=8)
            tick(axes.xaxis)
            tick(axes.yaxis)
        foot = [part for line in (_TIMED, *notes) for part in textwrap.wrap(line, 215)]
        text = "\n".join([*foot, caption(machine)])
        bottom.text(0.008, 0.98, text, va="top", fontsize=7.5, linespacing=1.3)
        figure.savefig(path, dpi=110, facecolor=PAPER)


def tick(axis: Axis) -> None:
    """Plain numbers at 1, 2 and 5 of each decade, or at 1 alone where there are many."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high / low < 1000.0 else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
