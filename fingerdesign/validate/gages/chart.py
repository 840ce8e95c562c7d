"""The chart of a study of gages: error by number of gages, and the cost of each gage's failure."""

from typing import Any

import numpy as np

from fingerdesign.report import style
from fingerdesign.report.style import Axes


def chart_png(data: dict[str, Any]) -> bytes:
    """Draw the error by number of gages and the cost of each gage's failure, from the record."""
    with style.house_style():
        figure = style.canvas(9.6, 4.9)
        by_count, along = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
        _by_count(by_count, data)
        _along(along, data)
        figure.suptitle(f"{data['design']}, gage noise {data['noise_microstrain']:g} microstrain")
        return style.to_png(figure)


def _by_count(axes: Axes, data: dict[str, Any]) -> None:
    rows = data["counts"]
    counts = [row["count"] for row in rows]
    quick = [row["quick_stick_error"] for row in rows]
    label = "stick ratio, quick learner"
    axes.plot(counts, quick, color=style.MUTED, ls=(0, (2, 2)), lw=1.2, label=label)
    confirmed = [row for row in rows if row["stick_error"] is not None]
    counts = [row["count"] for row in confirmed]
    stick = np.array([row["stick_error"] for row in confirmed])
    std = np.array([row["stick_std"] for row in confirmed])
    axes.vlines(counts, stick - std, stick + std, color=style.BLUE, lw=1.0)
    axes.plot(counts, stick, color=style.BLUE, marker="o", label="stick ratio, network")
    utilisation = [row["friction_utilisation_error"] for row in confirmed]
    label = "friction utilisation, network"
    axes.plot(counts, utilisation, color=style.GREEN, ls=(0, (6, 2)), marker="^", label=label)
    target = data["target_stick_error"]
    axes.axhline(target, color=style.VERMILION, zorder=1, ls=(0, (4, 3)), lw=1.0)
    look = {"color": style.VERMILION, "fontsize": 8.5}
    _note(axes, f"target: {target:g}", (0.99, target), (0, -11), ("axes fraction", "data"), **look)
    axes.xaxis.set_major_locator(style.whole_numbers())
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("gages (0: forces and moves alone)")
    axes.set_ylabel("error (RMS)")
    axes.set_title("Fewer gages")
    _legend_below(axes)


def _along(axes: Axes, data: dict[str, Any]) -> None:
    gages = sorted(data["gages"], key=lambda gage: gage["x_mm"])
    x = np.array([gage["x_mm"] for gage in gages])
    look = {"va": "top", "fontsize": 7.5, "color": style.MUTED}
    for pressing in data["pressings"]:
        half = pressing["half_width_mm"]
        axes.axvspan(-half, half, color=style.OPEN_COLOUR, alpha=0.55, lw=0, zorder=0)
        force = f"{pressing['normal_force_N']:.3g} N"
        _note(axes, force, (half, 0.995), (-2, -2), ("data", "axes fraction"), **look)
    width = 0.35 * float(np.diff(x).min(initial=1.0))
    unnoticed = [gage["unnoticed_stick_cost"] for gage in gages]
    axes.bar(
        x,
        unnoticed,
        width,
        color=style.VERMILION,
        hatch="///",
        edgecolor=style.PAPER,
        label="reads 0, unnoticed",
    )
    axes.set_xlabel("x of the gage (mm); shaded: contact under a normal force")
    axes.set_ylabel("cost of a dead gage, stick ratio (RMS)")
    axes.set_title("Which gages")
    reported = [max(gage["known_stick_cost"], 0.0) for gage in gages]
    top = 1.12 * max([*unnoticed, *reported, 1e-3])  # The forces stand above the bars.
    least = data["gages_that_suffice"]
    plates = next(row["plates"] for row in data["counts"] if row["count"] == least)
    chosen = [gage["x_mm"] for gage in gages if gage["plate"] in plates]
    if least:
        under = np.full(len(chosen), -0.04 * top)  # Markers below the bars do not hide dots at 0.
        axes.plot(chosen, under, "^", color=style.INK, ms=7, label=f"the {least} that suffice")
    axes.plot(x, reported, "o", color=style.BLUE, ms=4, zorder=4, label="trained without it")
    axes.axhline(0.0, color=style.MUTED, lw=0.8, zorder=1)
    axes.set_ylim(-0.08 * top, top)
    _legend_below(axes)


def _note(axes: Axes, text: str, place: Any, shift: Any, of: tuple[str, str], **look: Any) -> None:
    axes.annotate(text, place, shift, xycoords=of, textcoords="offset points", ha="right", **look)


def _legend_below(axes: Axes) -> None:
    """Put the legend under the axis' label, where it hides nothing."""
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.17), borderaxespad=0.0)
