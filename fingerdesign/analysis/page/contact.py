"""Figures of the contact: forces and stick ratio by increment, tractions (paper, Fig. 6)."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from fingerdesign.analysis.page.words import FIGURES, force_controlled, leaves_section
from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.recovery import middle_weights
from fingerdesign.records.arrays import OPEN, SLIP, STICK, ContactHistory
from fingerdesign.records.result import Result
from fingerdesign.report import style
from fingerdesign.report.page import captioned
from fingerdesign.report.style import Axes, Canvas, Locator
from fingerdesign.report.table import cleaned


def force_figure(result: Result) -> style.ReportFigure:
    """Forces by increment, the twist moment where there is one, and the stick ratio (Fig. 6)."""
    rows = result.increments
    step = np.arange(1, len(rows) + 1)
    both = [[row.normal_force_N, row.tangential_force_N] for row in rows]
    normal, tangential = cleaned(np.array(both)).T  # on one scale: F_t may be noise beside F_n
    ratio = np.array([np.nan if r.stick_ratio is None else r.stick_ratio for r in rows])
    aside = leaves_section(rows)
    figure = style.canvas(7.2, 2.9)
    if aside:
        forces, moments, sticks = figure.subplots(1, 3, width_ratios=(3, 2, 2))
    else:
        forces, sticks = figure.subplots(1, 2, width_ratios=(3, 2))
    style.series(forces, step, normal, 0, "normal force")
    style.series(forces, step, tangential, 1, f"tangential force{', x' if aside else ''}")
    most = float(np.abs(normal).max(initial=0.0))
    if aside:
        along = cleaned((row.force_z_N for row in rows), scale=most)
        moment = cleaned((row.twist_moment_Nmm for row in rows), scale=most)
        style.series(forces, step, along, 3, "force along z")
        style.series(moments, step, moment, 4)
        moments.set(xlabel="increment", ylabel="moment about y (N mm)", title="Twist moment")
        moments.xaxis.set_major_locator(style.whole_numbers(5))
        _show_zero(moments, moment)
    forces.set(xlabel="increment", ylabel="force on the finger (N)", title="Forces")
    forces.legend(loc="best")
    style.series(sticks, step, ratio, 2)
    sticks.set(xlabel="increment", ylabel="stick area / contact area", title="Stick ratio")
    sticks.set_ylim(-0.04, 1.04)
    for axes in (forces, sticks):
        axes.xaxis.set_major_locator(style.whole_numbers(5 if aside else 8))
    _show_zero(forces, normal, tangential)
    return captioned(
        figure,
        FIGURES,
        "forces",
        count=len(rows),
        normal=normal,
        tangential=tangential,
        ratio=rows[-1].stick_ratio,
        aside=(along[-1], moment[-1]) if aside else (),
        forced=force_controlled(result),
    )


def traction_figure(contact: ContactHistory) -> style.ReportFigure:
    """Pressure and shear traction on the mid-plane at a few increments.

    Along x, signed; its magnitude where it has a part along z.
    """
    line = contact.mid_line()
    x, normal, tangential = middle_tractions(contact, line)
    pressure = cleaned(normal)
    both = cleaned(tangential, scale=float(pressure.max(initial=0.0)))
    size = np.linalg.norm(both, axis=2)
    # A free mesh has no row of nodes on z = 0: a little stands aside there even in pure shear.
    turned = bool(np.abs(both[..., 1:]).max(initial=0.0) > 0.02 * size.max(initial=0.0))
    shear = size if turned else both[..., 0]
    touching = np.flatnonzero((contact.status != OPEN).any(axis=1))
    shown = touching if len(touching) else np.arange(len(pressure))
    chosen = [int(shown[i]) for i in style.spread(len(shown), 4)]
    figure = style.canvas(7.2, 3.2)
    left, right = figure.subplots(1, 2, sharex=True)
    for look, number in enumerate(chosen):
        style.series(left, x, pressure[number], look, f"increment {number + 1}", marker="")
        style.series(right, x, shear[number], look, marker="")
    left.set_xlim(*touched_reach(contact, line))
    left.set(xlabel="x (mm)", ylabel="pressure (MPa)", title="Pressure")
    what = "magnitude of shear traction" if turned else "shear traction along x"
    right.set(xlabel="x (mm)", ylabel=f"{what} (MPa)", title="Shear traction")
    style.shared_legend([left], 4)
    _show_zero(left, pressure)
    _show_zero(right, shear)
    last = chosen[-1]
    place = "" if contact.dimension == 2 else " on the mid-plane z = 0"
    return captioned(
        figure,
        FIGURES,
        "tractions",
        number=last + 1,
        place=place,
        touches=len(touching) > 0,
        turned=turned,
        slopes=_slopes(contact),
        pressure=pressure[last].max(),
        shear=np.abs(shear[last]).max(),
        at=x[pressure[last].argmax()],
    )


def middle_tractions(contact: ContactHistory, line: IntArray) -> tuple[Array, Array, Array]:
    """Places (l,) along ``line``, normal (k, l) and tangential (k, l, 1 | 2) tractions there: in
    3-D recovered from the nodes around."""
    x = contact.points[line, 0]
    if contact.dimension == 2:
        return x, contact.normal_traction[:, line], contact.tangential_traction[:, line]
    x = np.linspace(x.min(), x.max(), 2 * len(x))
    weights = middle_weights(contact.points, contact.areas, line, x, contact.symmetric)
    tangential: Array = weights @ contact.tangential_traction
    if contact.symmetric:
        tangential[..., 1] = 0.0
    return x, np.maximum(contact.normal_traction @ weights.T, 0.0), tangential


def _slopes(contact: ContactHistory) -> bool:
    """Whether shear traction over pressure differs among the points that slip."""
    size = np.linalg.norm(contact.tangential_traction, axis=2)
    pressure = contact.normal_traction
    slipping = (contact.status == SLIP) & (pressure > 0.01 * pressure.max(initial=0.0))
    ratio = size[slipping] / pressure[slipping]
    return bool(ratio.size and np.ptp(ratio) > 1e-3 * ratio.max())


def _show_zero(axes: Axes, *values: NDArray[np.float64]) -> None:
    """A scale for what is zero everywhere, which matplotlib would magnify without end."""
    if not any(part.any() for part in values):
        axes.set_ylim(-1.0, 1.0)


def touched_reach(contact: ContactHistory, line: NDArray[np.int64]) -> tuple[float, float]:
    """The x that are worth showing: all that ever touched, and a little more."""
    x = contact.points[line, 0]
    touched = (contact.status[:, line] != OPEN).any(axis=0)
    if not touched.any():
        return float(x.min()), float(x.max())
    low, high = float(x[touched].min()), float(x[touched].max())
    more = 0.15 * (high - low) + 0.05
    return max(low - more, float(x.min())), min(high + more, float(x.max()))


# Figure of open, stick and slip: rows over x in plane strain, top views in 3-D (paper, Fig. 7).

STATUS_NAMES = {OPEN: "open", STICK: "stick", SLIP: "slip"}
STATUS_LOOK = {  # colour, hatch: the hatch tells them apart without the colour
    OPEN: (style.OPEN_COLOUR, ""),
    STICK: (style.BLUE, ""),
    SLIP: (style.VERMILION, "////"),
}
# In the top view small patches take no hatch, so lightness tells them apart; it is a raster, whose
# colours do not follow the theme (hence not the palette's own).
TOP_VIEW = {STICK: "#0c6fb1", SLIP: "#f0b189", OPEN: style.OPEN_COLOUR}


def status_figure(contact: ContactHistory, shear_grows: bool = False) -> style.ReportFigure:
    """Open, stick and slip over x and increment; in 3-D a top view an increment (Fig. 7).

    shear_grows: the stick ratio falls as the tangential force grows, so the words may say it.
    """
    flat = contact.dimension == 2
    touching = np.flatnonzero((contact.status != OPEN).any(axis=1))
    return captioned(
        _status_rows(contact) if flat else _status_views(contact),
        FIGURES,
        "status",
        flat=flat,
        shear_grows=shear_grows,
        touching=touching.tolist(),
        lengths=contact.stick_length().tolist(),
    )


def _status_rows(contact: ContactHistory) -> Canvas:
    figure = style.canvas(7.2, 0.9 + 0.24 * len(contact.status))
    axes = figure.subplots()
    status_bars(axes, contact)
    axes.set_xlim(*touched_reach(contact, contact.mid_line()))
    axes.set_ylim(len(contact.status) + 0.6, 0.4)
    axes.set(xlabel="x (mm)", ylabel="increment")
    axes.grid(visible=False, axis="y")
    axes.yaxis.set_major_locator(style.whole_numbers(16))
    status_legend(axes)
    return figure


def status_bars(axes: Axes, contact: ContactHistory, upright: bool = False) -> None:
    """A bar an increment along x (up the axes where ``upright``): what the surface does there."""
    line = contact.mid_line()
    x = contact.points[line, 0]
    edges = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
    draw = axes.bar if upright else axes.barh
    for row, status in enumerate(contact.status[:, line], start=1):
        starts = np.flatnonzero(np.diff(status, prepend=-1))
        for begin, end in zip(starts, [*starts[1:], len(status)], strict=True):
            colour, hatch = STATUS_LOOK[int(status[begin])]
            size = (row, edges[end] - edges[begin], 0.72, edges[begin])
            draw(*size, color=colour, hatch=hatch, edgecolor=style.PAPER, linewidth=0)


def _status_views(contact: ContactHistory) -> Canvas:
    from matplotlib.collections import PolyCollection

    patches, owner = dual_patches(contact)
    chosen = style.spread(len(contact.status), 8)
    across, along = _touched_window(contact, patches, owner)
    height, width = along[1] - along[0], across[1] - across[0]
    columns, panel = _panel_grid(len(chosen), height / width)
    rows = -(-len(chosen) // columns)
    figure = style.canvas(7.2, 0.75 + (panel * height / width + 0.6) * rows)
    labels = {"across": "x (mm)", "up": "z (mm)"}
    panels = style.small_multiples(figure, len(chosen), columns, **labels, sharex=True, sharey=True)
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
        axes.set_facecolor(style.OPEN_COLOUR)  # under the patches: the legend's "open"
        axes.grid(visible=False)
    status_legend(panels[0], views=True)
    return figure


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


def status_legend(
    axes: Axes, shown: Iterable[int] = (STICK, SLIP, OPEN), below: bool = False, views: bool = False
) -> None:
    """What colours stand for: above the axes, ``below`` the figure, or above it (``views``)."""
    from matplotlib.patches import Patch

    handles = []
    for status in shown:
        colour, hatch = (TOP_VIEW[status], "") if views else STATUS_LOOK[status]
        name = STATUS_NAMES[status]
        handles.append(Patch(facecolor=colour, hatch=hatch, edgecolor=style.PAPER, label=name))
    if below or views:
        where = "outside lower center" if below else "outside upper right"
        axes.figure.legend(handles=handles, loc=where, ncols=len(handles))
    else:
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
        axes.legend(handles=handles, ncols=len(handles), **place)
