"""Parts of the charts: a figure with small text at its foot, and plain logarithmic axes."""

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fingerdesign.report.style import PAPER, Axis, Canvas, canvas

_WIDTH, _LINE = 12.5, 0.165  # Inches: the figure, a line of small text.
_LETTERS = 215  # of a line of small text
_MANY = 1000.0  # An axis over more than these decades has ticks at 1 alone.


def footed(height: float, foot: Sequence[str], title: str = "") -> tuple[Canvas, Any]:
    """Return a figure with its foot, and the part above the foot, ``height`` inches tall."""
    lines = [
        part
        for text in foot
        for line in text.splitlines()
        for part in textwrap.wrap(line, _LETTERS)
    ]
    below = _LINE * (len(lines) + 1)
    figure = canvas(_WIDTH, height + below)
    parts: Any = figure.subfigures(2, 1, height_ratios=[height, below])
    top, bottom = parts
    if title:
        top.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold")
    bottom.text(0.008, 0.98, "\n".join(lines), va="top", fontsize=7.5, linespacing=1.3)
    return figure, top


def save(figure: Canvas, path: Path, dpi: float = 110.0) -> Path:
    """Save a figure as a picture."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=dpi, facecolor=PAPER)
    return path


def tick(axis: Axis) -> None:
    """Plain numbers at 1, 2 and 5 of each decade, or at 1 alone where there are many."""
    from matplotlib.ticker import LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high / low < _MANY else (1.0,)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def fixed_ticks(axis: Axis, places: Sequence[float]) -> None:
    """Plain numbers at these places."""
    from matplotlib.ticker import FixedLocator, NullLocator

    axis.set_major_locator(FixedLocator(list(places)))  # ``set_ticks`` would widen the axis
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter("{x:g}")
