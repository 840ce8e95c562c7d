"""The picture of ``bench hexahedra``: errors against arithmetic and against size, a line a cell."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.bench.growth import tick
from fingerdesign.bench.machine import caption
from fingerdesign.report.style import GRID, PAPER, SERIES, canvas, house_style

if TYPE_CHECKING:
    from fingerdesign.bench.hexahedra import Hexahedra

_WHAT = ((0, "forces, of the normal force"), (1, "stick ratio"), (2, "gages, of the largest"))
_ACROSS = (("gigaflop", "factorisation and condensation (Gflop)"), ("dofs", "equations"))


def draw_hexahedra(found: Hexahedra, path: Path) -> None:
    """Errors against the finest mixed mesh of the other kind of cell; grey: where both differ."""
    from fingerdesign.bench.hexahedra import LINES

    band = found.band()
    with house_style():
        figure = canvas(12.5, 8.2)
        parts: Any = figure.subfigures(2, 1, height_ratios=[7.0, 1.0])
        panels = parts[0].subplots(2, len(_WHAT))
        for row, (cost, words) in zip(panels, _ACROSS, strict=True):
            for axes, (which, title) in zip(row, _WHAT, strict=True):
                for line, (colour, dashes, marker) in zip(LINES, SERIES, strict=False):
                    mine = [p for p in found.points if p.line == line]
                    shown = [p for p in mine if p is not found.reference(_other(line))]
                    axes.plot(
                        [getattr(p, cost) for p in shown],
                        [max(found.errors(p)[which], 1e-6) for p in shown],
                        color=colour,
                        ls=dashes,
                        marker=marker,
                        label=line,
                    )
                axes.set_xscale("log")
                axes.set_yscale("log")
                axes.axhspan(axes.get_ylim()[0], max(band[which], 1e-6), color=GRID, zorder=0)
                tick(axes.xaxis)
                axes.set(xlabel=words, ylabel="worst error over the increments", title=title)
        panels[0, 0].legend(loc="best", fontsize=8)
        text = (
            "Half of an extruded finger with three plates, nu = 0.49, pressed and sheared. Each "
            "line is measured against the finest mixed mesh of the other\nkind of cell; in the "
            "grey these two references differ, and nothing can be read.\n" + caption(found.machine)
        )
        parts[1].text(0.008, 0.95, text, va="top", fontsize=7.5, linespacing=1.3)
        figure.savefig(path, dpi=110, facecolor=PAPER)


def _other(line: str) -> str:
    """A line of the other kind of cell, whose reference is this kind's."""
    return "mixed hexahedra" if "tetrahedra" in line else "mixed tetrahedra"
