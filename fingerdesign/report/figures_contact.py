"""Figures of the contact: forces by step, the stick/slip map, tractions (paper, Figs 6 and 7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.report.style import (
    BLUE,
    OPEN_COLOUR,
    PAPER,
    SERIES,
    VERMILION,
    ReportFigure,
    canvas,
    small_multiples,
    to_svg,
)
from fingerdesign.results import OPEN, SLIP, STICK, ContactHistory, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.ticker import Locator
    from numpy.typing import NDArray

STATUS_NAMES = {OPEN: "open", STICK: "stick", SLIP: "slip"}
STATUS_LOOK = {  # colour, hatch: the hatch tells them apart without the colour
    OPEN: (OPEN_COLOUR, ""),
    STICK: (BLUE, ""),
    SLIP: (VERMILION, "////"),
}


def force_figure(result: Result) -> ReportFigure:
    """F_n and F_t by increment, and the stick ratio below (paper, Fig. 6)."""
    rows = result.increments
    step = np.arange(1, len(rows) + 1)
    normal = np.array([row.normal_force_N for row in rows])
    tangential = np.array([row.tangential_force_N for row in rows])
    ratio = np.array([np.nan if r.stick_ratio is None else r.stick_ratio for r in rows])
    figure = canvas(7.2, 2.9)
    forces, sticks = figure.subplots(1, 2, width_ratios=(3, 2))
    for values, name, (colour, dashes, marker) in (
        (normal, "normal force", SERIES[0]),
        (tangential, "tangential force", SERIES[1]),
    ):
        forces.plot(step, values, color=colour, ls=dashes, marker=marker, label=name)
    forces.set(xlabel="increment", ylabel="force on the finger (N)", title="Forces")
    forces.legend(loc="best")
    colour, dashes, marker = SERIES[2]
    sticks.plot(step, ratio, color=colour, ls=dashes, marker=marker)
    sticks.set(xlabel="increment", ylabel="stick area / contact area", title="Stick ratio")
    sticks.set_ylim(-0.04, 1.04)
    for axes in (forces, sticks):
        axes.xaxis.set_major_locator(whole_numbers())
    last = f"{ratio[-1]:.2f}" if np.isfinite(ratio[-1]) else "not defined"
    alternative = (
        f"Over {len(rows)} increments the normal force goes from {normal[0]:.3g} to "
        f"{normal[-1]:.3g} N and the tangential force from {tangential[0]:.3g} to "
        f"{tangential[-1]:.3g} N; the stick ratio at the end is {last}."
    )
    return ReportFigure(
        "forces",
        "Forces and stick ratio, increment by increment",
        to_svg(figure, "forces", alternative),
        "Each point is one increment of the object's motion. The finger is near complete slip "
        "where the stick ratio comes down to zero; the tangential force then stops growing. "
        "(Fig. 6 of the paper.)",
        alternative,
    )


def status_figure(contact: ContactHistory) -> ReportFigure:
    """Open, stick and slip over x and increment; in 3-D a top view an increment (Fig. 7)."""
    flat = contact.dimension == 2
    image, alternative = (_status_rows if flat else _status_views)(contact)
    reading = (
        "Each row is one increment; along it, what the surface does at each x. "
        if flat
        else "Each panel looks down on the contact zone at one increment. "
    )
    return ReportFigure(
        "status",
        "Where the surface is open, sticks and slips",
        image,
        reading + "Slip (hatched where the map is in rows, light where it is a top view) enters "
        "from the contact's edges and eats the stick zone as the tangential force grows. (Fig. 7 "
        "of the paper.)",
        alternative,
    )


def traction_figure(contact: ContactHistory) -> ReportFigure:
    """Pressure and shear traction along x on the mid-plane at a few increments."""
    line = contact.mid_line()
    x = contact.points[line, 0]
    pressure = contact.normal_traction[:, line]
    shear = contact.tangential_traction[:, line, 0]
    chosen = spread(len(pressure), 4)
    figure = canvas(7.2, 3.0)
    left, right = figure.subplots(1, 2, sharex=True)
    for number, (colour, dashes, _) in zip(chosen, SERIES, strict=False):
        label = f"increment {number + 1}"
        left.plot(x, pressure[number], color=colour, ls=dashes, label=label)
        right.plot(x, shear[number], color=colour, ls=dashes, label=label)
    reach = _reach(contact, line)
    left.set_xlim(*reach)
    left.set(xlabel="x (mm)", ylabel="pressure (MPa)", title="Pressure")
    right.set(xlabel="x (mm)", ylabel="shear traction along x (MPa)", title="Shear traction")
    left.legend(loc="best")
    last = chosen[-1]
    alternative = (
        f"At increment {last + 1} the pressure peaks at {pressure[last].max():.3g} MPa at x = "
        f"{x[pressure[last].argmax()]:.2f} mm; the shear traction reaches "
        f"{np.abs(shear[last]).max():.3g} MPa."
    )
    place = "" if contact.dimension == 2 else " on the mid-plane z = 0"
    return ReportFigure(
        "tractions",
        "Pressure and shear traction",
        to_svg(figure, "tractions", alternative),
        f"Tractions on the finger{place} at a few increments. Where the surface slips, the shear "
        "traction is the friction coefficient times the pressure; where it sticks, it is less.",
        alternative,
    )


def spread(count: int, most: int) -> list[int]:
    """Up to ``most`` whole numbers from 0 to count - 1, evenly spread, both ends in.

    >>> spread(8, 4), spread(2, 4), spread(0, 4)
    ([0, 2, 5, 7], [0, 1], [])
    """
    return sorted({round(i) for i in np.linspace(0, count - 1, min(most, count))})


def _status_rows(contact: ContactHistory) -> tuple[str, str]:
    line = contact.mid_line()
    x = contact.points[line, 0]
    edges = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
    figure = canvas(7.2, 0.9 + 0.24 * len(contact.status))
    axes = figure.subplots()
    for row, status in enumerate(contact.status[:, line], start=1):
        starts = np.flatnonzero(np.diff(status, prepend=-1))
        for begin, end in zip(starts, [*starts[1:], len(status)], strict=True):
            colour, hatch = STATUS_LOOK[int(status[begin])]
            axes.barh(
                row,
                edges[end] - edges[begin],
                left=edges[begin],
                height=0.72,
                color=colour,
                hatch=hatch,
                edgecolor=PAPER,
                linewidth=0,
            )
    axes.set_xlim(*_reach(contact, line))
    axes.set_ylim(len(contact.status) + 0.6, 0.4)
    axes.set(xlabel="x (mm)", ylabel="increment")
    axes.grid(visible=False, axis="y")
    axes.yaxis.set_major_locator(whole_numbers(16))
    _status_legend(axes)
    return to_svg(figure, "status", text := _status_words(contact)), text


def _status_views(contact: ContactHistory) -> tuple[str, str]:
    from matplotlib.collections import PolyCollection

    patches, owner = _dual_patches(contact)
    chosen = spread(len(contact.status), 8)
    figure = canvas(7.2, 1.0 + 1.9 * -(-len(chosen) // 4))
    panels = small_multiples(figure, len(chosen), 4, sharex=True, sharey=True)
    reach = _reach(contact, np.arange(len(contact.points)))
    for axes, number in zip(panels, chosen, strict=True):
        for status in (STICK, SLIP):
            colour, _ = STATUS_LOOK[status]
            own = contact.status[number][owner] == status
            # One raster image a panel: thousands of polygons would make the page heavy.
            axes.add_collection(
                PolyCollection(
                    patches[own], facecolors=colour, edgecolors=colour, lw=0.2, rasterized=True
                )
            )
        axes.set_title(f"increment {number + 1}")
        axes.set_xlim(*reach)
        axes.set_ylim(patches[..., 1].min(), patches[..., 1].max())
        axes.set_aspect("equal", adjustable="box")
    for axes in panels[-4:]:
        axes.set_xlabel("x (mm)")
    for axes in panels[::4]:
        axes.set_ylabel("z (mm)")
    _status_legend(panels[0], figure_wide=True)
    return to_svg(figure, "status", text := _status_words(contact)), text


def _dual_patches(contact: ContactHistory) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Each facet cut into three kites, one a corner: (3 f, 4, 2) in (x, z), and their points."""
    flat = contact.points[:, [0, 2]]
    corners = flat[contact.facets]
    middle = corners.mean(axis=1)
    after = 0.5 * (corners + np.roll(corners, -1, axis=1))
    before = np.roll(after, 1, axis=1)
    centre = np.broadcast_to(middle[:, None], corners.shape)
    kites = np.stack([corners, after, centre, before], axis=2).reshape(-1, 4, 2)
    owner = contact.facets.reshape(-1)
    if contact.symmetric:
        kites, owner = np.concatenate([kites, kites * [1, -1]]), np.tile(owner, 2)
    return kites, owner


def _status_legend(axes: Axes, figure_wide: bool = False) -> None:
    from matplotlib.patches import Patch

    shown = [STICK, SLIP] if figure_wide else [STICK, SLIP, OPEN]
    handles = [
        Patch(
            facecolor=STATUS_LOOK[status][0],
            hatch="" if figure_wide else STATUS_LOOK[status][1],
            edgecolor=PAPER,
            label=STATUS_NAMES[status],
        )
        for status in shown
    ]
    place = axes.figure if figure_wide else axes
    where = "outside upper right" if figure_wide else "lower right"
    anchor = {} if figure_wide else {"bbox_to_anchor": (1.0, 1.0)}
    place.legend(handles=handles, loc=where, ncols=len(handles), **anchor)


def _status_words(contact: ContactHistory) -> str:
    lengths = contact.stick_length()
    touching = np.flatnonzero((contact.status != OPEN).any(axis=1))
    if not len(touching):
        return "The object does not touch the finger in any increment."
    widest = int(np.argmax(lengths))
    gone = [number + 1 for number in touching if lengths[number] == 0]
    end = (
        f"none sticks at increment {gone[0]}" if gone else f"{lengths[-1]:.2f} mm stick at the end"
    )
    return (
        f"Contact begins at increment {touching[0] + 1}; along x the surface sticks over at most "
        f"{lengths[widest]:.2f} mm (increment {widest + 1}); {end}."
    )


def _reach(contact: ContactHistory, line: NDArray[np.int64]) -> tuple[float, float]:
    """The x that are worth showing: all that ever touched, and a little more."""
    x = contact.points[line, 0]
    touched = (contact.status[:, line] != OPEN).any(axis=0)
    if not touched.any():
        return float(x.min()), float(x.max())
    low, high = float(x[touched].min()), float(x[touched].max())
    more = 0.15 * (high - low) + 0.05
    return max(low - more, float(x.min())), min(high + more, float(x.max()))


def whole_numbers(most: int = 8) -> Locator:
    """Ticks of an axis that counts."""
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(integer=True, nbins=most)
