"""Growth of time and memory with the model: power laws fitted to a series of meshes, and drawn."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.report.style import SERIES, house_style, points
from fingerdesign_bench.chart import footed, save, tick
from fingerdesign_bench.machine import caption

_POINTS = 3  # through fewer a law is not fitted
# quantity of a Size -> what it grows with, and in words
LAWS = (
    ("model_s", "dofs", "model, s"),
    ("memory_MB", "dofs", "peak memory of the model, MB"),
    ("increment_s", "contact_nodes", "mean increment, s"),
)
_TIMED = (
    "One process a mesh; times: the least of the runs after the first, imports left out, no cache. "
    "Model: mesh, assembly and condensation; memory: beyond that of the process before."
)


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


def draw_growth(
    sizes: Sequence[Size],
    laws: Sequence[Growth],
    machine: dict[str, Any],
    path: Path,
    notes: Sequence[str] = (),
) -> Path:
    """Model time and memory against dofs, increment time against contact nodes, log-log."""
    fitted = {(law.kind, law.quantity): law for law in laws}
    with house_style():
        figure, top = footed(3.6, [_TIMED, *notes, caption(machine)])
        for axes, (quantity, against, words) in zip(top.subplots(1, len(LAWS)), LAWS, strict=True):
            for number, kind in enumerate(dict.fromkeys(each.kind for each in sizes)):
                mine = [each for each in sizes if each.kind == kind]
                x, y = ([getattr(each, name) for each in mine] for name in (against, quantity))
                colour, dashes, marker = SERIES[number]
                label, law = kind, fitted.get((kind, quantity))
                if law is not None:
                    label = f"{kind}: power {law.exponent:.2f}"
                    ends = np.array([min(x), max(x)], dtype=float)
                    line = law.factor * ends**law.exponent
                    axes.plot(ends, line, color=colour, linestyle=dashes)
                axes.plot(x, y, **points(colour, marker, 4.5, label))
            axes.set(xscale="log", yscale="log", title=words)
            axes.set_xlabel(against.replace("_", " "))
            axes.legend(loc="best", fontsize=8)
            tick(axes.xaxis)
            tick(axes.yaxis)
        return save(figure, path)
