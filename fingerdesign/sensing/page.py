"""The chart of what gages tell: error by number of gages, and what each gage's silence costs.

Data as in observability.json.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.records.folder import RecordFolder
from fingerdesign.report.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    OPEN_COLOUR,
    PAPER,
    VERMILION,
    canvas,
    house_style,
    whole_numbers,
)
from fingerdesign.sensing.record import (
    CHART_FILE,
    COUNTS_FILE,
    GAGES_FILE,
    RECORD_FILE,
    Observability,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# The folder of a study of gages, and what is written into it.

FOLDER = RecordFolder(
    "study of gages", RECORD_FILE, (RECORD_FILE, GAGES_FILE, COUNTS_FILE, CHART_FILE)
)


def write_observability(found: Observability, folder: Path) -> None:
    """The record, its tables and its chart into an existing folder."""
    (folder / CHART_FILE).write_bytes(chart_png(found.data()))
    for name, text in found.texts().items():
        (folder / name).write_text(text, encoding="utf-8")


def chart_png(data: dict[str, Any]) -> bytes:
    """The chart as a PNG on paper's colour."""
    with house_style():
        figure = canvas(9.6, 4.9)
        by_count, along = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
        _by_count(by_count, data)
        _along(along, data)
        figure.suptitle(f"{data['design']}, gage noise {data['noise_microstrain']:g} microstrain")
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=150, facecolor=PAPER, metadata={"Software": None})
    return stream.getvalue()


def _by_count(axes: Axes, data: dict[str, Any]) -> None:
    rows = data["counts"]
    counts = [row["count"] for row in rows]
    quick = [row["quick_stick_error"] for row in rows]
    axes.plot(
        counts, quick, color=MUTED, ls=(0, (2, 2)), lw=1.2, label="stick ratio, quick learner"
    )
    taught = [row for row in rows if row["stick_error"] is not None]
    counts = [row["count"] for row in taught]
    stick = np.array([row["stick_error"] for row in taught])
    spread = np.array([row["stick_spread"] for row in taught])
    axes.vlines(counts, stick - spread, stick + spread, color=BLUE, lw=1.0)
    axes.plot(counts, stick, color=BLUE, marker="o", label="stick ratio, network")
    used = [row["used_error"] for row in taught]
    axes.plot(
        counts, used, color=GREEN, ls=(0, (6, 2)), marker="^", label="friction in use, network"
    )
    target = data["target_stick_error"]
    axes.axhline(target, color=VERMILION, zorder=1, ls=(0, (4, 3)), lw=1.0)
    axes.annotate(
        f"goal: {target:g}",
        (0.99, target),
        (0, -11),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        ha="right",
        color=VERMILION,
        fontsize=8.5,
    )
    axes.xaxis.set_major_locator(whole_numbers())
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("gages (0: forces and moves alone)")
    axes.set_ylabel("error (RMS)")
    axes.set_title("Fewer gages")
    _legend_below(axes)


def _along(axes: Axes, data: dict[str, Any]) -> None:
    gages = sorted(data["gages"], key=lambda gage: gage["x_mm"])
    x = np.array([gage["x_mm"] for gage in gages])
    for pressing in data["pressings"]:
        half = pressing["half_width_mm"]
        axes.axvspan(-half, half, color=OPEN_COLOUR, alpha=0.55, lw=0, zorder=0)
        axes.annotate(
            f"{pressing['normal_force_N']:.3g} N",
            (half, 0.995),
            (-2, -2),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            ha="right",
            va="top",
            fontsize=7.5,
            color=MUTED,
        )
    width = 0.35 * float(np.diff(x).min(initial=1.0))
    untold = [gage["untold_stick_cost"] for gage in gages]
    axes.bar(
        x, untold, width, color=VERMILION, hatch="///", edgecolor=PAPER, label="reads 0, untold"
    )
    axes.set_xlabel("x of the gage (mm); shaded: contact under a normal force")
    axes.set_ylabel("cost of a dead gage, stick ratio (RMS)")
    axes.set_title("Which gages")
    reported = [max(gage["told_stick_cost"], 0.0) for gage in gages]
    top = 1.12 * max([*untold, *reported, 1e-3])  # room for the forces
    least = data["gages_that_suffice"]
    kept = next(row["plates"] for row in data["counts"] if row["count"] == least)
    chosen = [gage["x_mm"] for gage in gages if gage["plate"] in kept]
    if least:
        axes.plot(
            chosen,
            np.full(len(chosen), -0.04 * top),  # under the bars, clear of the dots at 0
            color=INK,
            ls="none",
            marker="^",
            ms=7,
            label=f"the {least} that suffice",
        )
    axes.plot(
        x,
        reported,
        color=BLUE,
        marker="o",
        ls="none",
        ms=4,
        zorder=4,
        label="taught without it",
    )
    axes.axhline(0.0, color=MUTED, lw=0.8, zorder=1)
    axes.set_ylim(-0.08 * top, top)
    _legend_below(axes)


def _legend_below(axes: Axes) -> None:
    """Under the axis' label, where it hides nothing."""
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.17), borderaxespad=0.0)
