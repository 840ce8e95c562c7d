"""Histograms of a mesh's angles and sizes, on matplotlib's axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_NAMES = {"contact": "at the contact", "rest": "elsewhere in the rubber"}
_COLOURS = {"contact": "#0b6fb0", "plates": "#d2560a", "core": "#b0569a", "rest": "#0a8f6b"}
_STYLES = {"contact": "-", "plates": "--", "core": "-.", "rest": ":"}


def draw_angles(axes: Any, data: dict[str, NDArray[Any]], about: dict[str, Any]) -> None:
    """All angles as bars, the least of each element as steps, the least of all as a line."""
    edges, counts, least = data["edges"], data["counts"], data["least"]
    width = np.diff(edges)
    share = 100.0 * counts / max(counts.sum(), 1.0)
    axes.bar(edges[:-1], share, width, align="edge", color="#cfd8e3", edgecolor="#33475b", lw=0.5)
    own = np.histogram(least, edges)[0]
    axes.stairs(100.0 * own / len(least), edges, color="#0b6fb0", lw=1.6)
    axes.axvline(float(least.min()), color="#e0102a", lw=1.2)
    axes.set_xlim(0.0, 180.0)
    axes.set_xticks(np.arange(0, 181, 30))
    axes.set_xlabel("degrees")
    axes.set_ylabel("per cent")
    axes.set_title(
        f"{about['angle']}s: all (grey), the least of each element (blue)\n"
        f"least of all {least.min():.1f} deg (red), {about['inverted']} inverted",
        loc="left",
        fontsize=9.5,
    )


def draw_ratios(axes: Any, ratios: dict[str, NDArray[Any]]) -> None:
    """Mean edges over the sizes asked for, zone by zone."""
    edges = np.geomspace(0.25, 4.0, 49)
    for zone, values in ratios.items():
        counts = np.histogram(np.clip(values, edges[0], edges[-1]), edges)[0]
        axes.stairs(
            100.0 * counts / len(values),
            edges,
            color=_COLOURS[zone],
            linestyle=_STYLES[zone],
            lw=1.5,
            label=f"{_NAMES.get(zone, 'in the ' + zone)} (mean {values.mean():.2f})",
        )
    axes.axvline(1.0, color="#6c6f73", lw=0.8)
    axes.set_xscale("log")
    axes.set_xticks([0.25, 0.5, 1.0, 2.0, 4.0], ["1/4", "1/2", "1", "2", "4"])
    axes.minorticks_off()
    axes.set_xlabel("mean edge over the size asked for there")
    axes.set_ylabel("per cent of the zone's elements")
    axes.set_ylim(0.0, 1.4 * axes.get_ylim()[1])
    axes.legend(fontsize=8.5, frameon=False, loc="upper left")
    axes.set_title("sizes against those asked", loc="left", fontsize=9.5)
