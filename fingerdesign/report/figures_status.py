"""Figure of open, stick and slip: rows over x in plane strain, top views in 3-D (paper, Fig. 7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.report.figures_contact import touched_reach
from fingerdesign.report.style import (
    BLUE,
    OPEN_COLOUR,
    PAPER,
    VERMILION,
    ReportFigure,
    canvas,
    small_multiples,
    spread,
    to_svg,
    whole_numbers,
)
from fingerdesign.results import OPEN, SLIP, STICK, ContactHistory

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
# In the top view small patches take no hatch, so lightness tells them apart; it is a raster, whose
# colours do not follow the theme (hence not the palette's own).
TOP_VIEW = {STICK: "#0c6fb1", SLIP: "#f0b189", OPEN: OPEN_COLOUR}


def status_figure(contact: ContactHistory, shear_grows: bool = False) -> ReportFigure:
    """Open, stick and slip over x and increment; in 3-D a top view an increment (Fig. 7).

    shear_grows: the stick ratio falls as the tangential force grows, so the words may say it.
    """
    flat = contact.dimension == 2
    image, alternative = (_status_rows if flat else _status_views)(contact)
    reading = (
        "Each row is one increment; along it, what the surface does at each x. Slip is hatched"
        if flat
        else "Each panel looks down on the contact zone at one increment. Slip is pale"
    )
    reading += (
        ": it enters from the contact's edges and eats up the stick zone as the tangential force "
        "grows. (After Fig. 7 of the paper.)"
        if shear_grows
        else ": there the shear traction has reached what friction can carry."
    )
    return ReportFigure(
        "status",
        "Where the surface is open, sticks and slips",
        image,
        reading,
        alternative,
    )


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
    axes.set_xlim(*touched_reach(contact, line))
    axes.set_ylim(len(contact.status) + 0.6, 0.4)
    axes.set(xlabel="x (mm)", ylabel="increment")
    axes.grid(visible=False, axis="y")
    axes.yaxis.set_major_locator(whole_numbers(16))
    _status_legend(axes)
    return to_svg(figure, "status", text := _status_words(contact)), text


def _status_views(contact: ContactHistory) -> tuple[str, str]:
    from matplotlib.collections import PolyCollection

    patches, owner = dual_patches(contact)
    chosen = spread(len(contact.status), 8)
    across, along = _touched_window(contact, patches, owner)
    height, width = along[1] - along[0], across[1] - across[0]
    columns, panel = _panel_grid(len(chosen), height / width)
    rows = -(-len(chosen) // columns)
    figure = canvas(7.2, 0.75 + (panel * height / width + 0.6) * rows)
    panels = small_multiples(figure, len(chosen), columns, sharex=True, sharey=True)
    for axes, number in zip(panels, chosen, strict=True):
        for status in (STICK, SLIP):
            own = contact.status[number][owner] == status
            # One raster image a panel: thousands of polygons would make the page heavy.
            axes.add_collection(
                PolyCollection(
                    patches[own],
                    facecolors=TOP_VIEW[status],
                    edgecolors=TOP_VIEW[status],
                    lw=0.2,  # or the seams between patches would show
                    rasterized=True,
                )
            )
        axes.set_title(f"incr. {number + 1}" if columns > 4 else f"increment {number + 1}")
        axes.set_xlim(*across)
        axes.set_ylim(*along)
        axes.set_aspect("equal", adjustable="box")
        axes.xaxis.set_major_locator(_few_ticks(panel / 0.45))
        axes.yaxis.set_major_locator(_few_ticks(panel * height / width / 0.3))
        axes.set_facecolor(OPEN_COLOUR)  # under the patches: the legend's "open"
        axes.grid(visible=False)
    for axes in panels[-columns:]:
        axes.set_xlabel("x (mm)")
    for axes in panels[::columns]:
        axes.set_ylabel("z (mm)")
    _status_legend(panels[0], figure_wide=True)
    return to_svg(figure, "status", text := _status_words(contact)), text


def _touched_window(
    contact: ContactHistory, patches: NDArray[np.float64], owner: NDArray[np.int64]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """What a top view shows of x and of z: all that ever touched, and a little more."""
    touched = (contact.status != OPEN).any(axis=0)[owner]
    shown = (patches[touched] if touched.any() else patches).reshape(-1, 2)
    ends = patches.reshape(-1, 2)
    low, high = shown.min(axis=0), shown.max(axis=0)
    more = 0.1 * (high - low) + 0.05
    low = np.maximum(low - more, ends.min(axis=0))
    high = np.minimum(high + more, ends.max(axis=0))
    x, z = (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))
    # A sliver cannot be read: no side is shown under a sixth of the other.
    return _at_least(x, (z[1] - z[0]) / 6), _at_least(z, (x[1] - x[0]) / 6)


def _at_least(window: tuple[float, float], width: float) -> tuple[float, float]:
    lacking = max(0.0, width - (window[1] - window[0]))
    return window[0] - 0.5 * lacking, window[1] + 0.5 * lacking


def _panel_grid(count: int, slope: float) -> tuple[int, float]:
    """Columns and a panel's width (inches) for panels of this height over width.

    Each panel is kept under 2.4 inches high and the figure under 6; then no place is left empty,
    no panel is under 1.2 inches wide, and the columns are few.
    """
    fitting = []
    for columns in range(min(2, count), min(count, 8) + 1):
        width = min((6.5 - 0.25 * (columns - 1)) / columns, 3.2)
        rows = -(-count // columns)
        if width * slope <= 2.4 and (width * slope + 0.6) * rows <= 5.5:
            spare = rows * columns - count
            fitting.append((spare + 10 * (width < 1.2), columns, width))
    if fitting:
        return min(fitting)[1:]
    columns = min(count, 8)
    return columns, min((6.5 - 0.25 * (columns - 1)) / columns, 4.5 / slope)


def _few_ticks(room: float) -> Locator:
    """Ticks for an axis with room for so many labels: at least two, from round steps."""
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(nbins=int(min(max(room, 1), 5)), steps=[1, 2, 5, 10], min_n_ticks=2)


def dual_patches(contact: ContactHistory) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
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

    handles = [
        Patch(
            facecolor=TOP_VIEW[status] if figure_wide else STATUS_LOOK[status][0],
            hatch="" if figure_wide else STATUS_LOOK[status][1],
            edgecolor=PAPER,
            label=STATUS_NAMES[status],
        )
        for status in (STICK, SLIP, OPEN)
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
    place = "" if contact.dimension == 2 else " on z = 0"
    begins = f"Contact begins at increment {touching[0] + 1}"
    last = int(touching[-1])
    ends = "" if last == len(lengths) - 1 else f"; none is left after increment {last + 1}"
    if not lengths.any():
        return f"{begins}{ends}; the surface slips wherever it touches{place}, none of it sticks."
    widest = int(np.argmax(lengths))
    gone = [number + 1 for number in touching if lengths[number] == 0]
    end = (
        f"none sticks at increment {gone[0]}"
        if gone
        else f"{lengths[last]:.2f} mm stick at increment {last + 1}"
    )
    return (
        f"{begins}{ends}; along x{place} the surface sticks over at most "
        f"{lengths[widest]:.2f} mm (increment {widest + 1}); {end}."
    )
