"""Figures of the contact: forces and stick ratio by increment, tractions (paper, Fig. 6)."""

from collections.abc import Iterable, Sequence

import numpy as np

from fingerdesign.analysis.page.tables import FIGURES, leaves_section
from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.recovery import middle_weights
from fingerdesign.records.arrays import OPEN, SLIP, STICK, ContactHistory
from fingerdesign.records.result import IncrementResult, Result
from fingerdesign.report import style
from fingerdesign.report.figure import Figure, Panel, caption_chart, panels
from fingerdesign.report.page import caption_drawing
from fingerdesign.report.style import Axes
from fingerdesign.report.table import number_text, without_noise

STATUS_NAMES = {OPEN: "open", STICK: "stick", SLIP: "slip"}
STATUS_LOOK = {  # colour, hatch: the hatch tells them apart without the colour
    OPEN: (style.OPEN_COLOUR, ""),
    STICK: (style.BLUE, ""),
    SLIP: (style.VERMILION, "////"),
}


def path_chart(result: Result) -> Figure:
    """Forces by increment, the twist moment where there is one, and the stick ratio (Fig. 6)."""
    rows = result.increments
    step = np.arange(1.0, len(rows) + 1.0)
    normal, tangential, along, moment = _loads(rows)
    ratio = np.array([r.stick_ratio for r in rows], dtype=float)  # None is NaN
    aside = leaves_section(rows)
    forces = [("normal force", step, normal)]
    forces.append((f"tangential force{', x' if aside else ''}", step, tangential))
    drawn = [Panel("Forces", "increment", "force on the finger (N)", forces)]
    if aside:
        forces.append(("force along z", step, along))
        up, lines = "moment about y (N mm)", [("twist moment", step, moment)]
        drawn.append(Panel("Twist moment", "increment", up, lines, looks=[4]))
    up, lines = "stick area / contact area", [("stick ratio", step, ratio)]
    drawn.append(Panel("Stick ratio", "increment", up, lines, rise=(-0.04, 1.04), looks=[3]))
    return panels(drawn, len(drawn))


def _loads(rows: Sequence[IncrementResult]) -> tuple[Array, Array, Array, Array]:
    """F_n, F_t, F_z (N) and the twist moment (N mm), rid of noise."""
    both = np.array([[row.normal_force_N, row.tangential_force_N] for row in rows])
    normal, tangential = without_noise(both).T  # on one scale: F_t may be noise compared with F_n
    most = float(np.abs(normal).max(initial=0.0))
    along = without_noise((row.force_z_N for row in rows), scale=most)
    moment = without_noise((row.twist_moment_Nmm for row in rows), scale=most)
    return normal, tangential, along, moment


def force_figure(result: Result) -> style.ReportFigure:
    """:func:`path_chart` for the page, with its words."""
    rows = result.increments
    normal, tangential, _, _ = _loads(rows)
    ends = {"normal": normal[[0, -1]], "tangential": tangential[[0, -1]]}
    values = {**ends, "count": len(rows), "ratio": number_text(rows[-1].stick_ratio, 2)}
    return caption_chart(path_chart(result), FIGURES, "forces", "", **values)


def contact_chart(contact: ContactHistory, chosen: Sequence[int]) -> Figure:
    """Pressure and shear traction on the mid-plane at the chosen increments (from 0).

    Along x, signed; its magnitude where it has a part along z.
    """
    x, pressure, shear, turned = _middle(contact)
    reach = touched_reach(contact, contact.mid_line())
    what = "magnitude of shear traction" if turned else "shear traction along x"
    drawn = []
    for title, up, values in (("Pressure", "pressure", pressure), ("Shear traction", what, shear)):
        lines = [(f"increment {k + 1}", x, values[k]) for k in chosen]
        drawn.append(Panel(title, "x (mm)", f"{up} (MPa)", lines, reach=reach, marked=False))
    return panels(drawn, 2)


def _middle(contact: ContactHistory) -> tuple[Array, Array, Array, bool]:
    """Places (l,), pressure and shear traction (k, l) there, and whether it is a magnitude."""
    x, normal, tangential = middle_tractions(contact, contact.mid_line())
    pressure = without_noise(normal)
    both = without_noise(tangential, scale=float(pressure.max(initial=0.0)))
    size = np.linalg.norm(both, axis=2)
    # A free mesh has no row of nodes on z = 0: it has a small part along z even in pure shear.
    turned = bool(np.abs(both[..., 1:]).max(initial=0.0) > 0.02 * size.max(initial=0.0))
    return x, pressure, size if turned else both[..., 0], turned


def traction_figure(contact: ContactHistory) -> style.ReportFigure:
    """:func:`contact_chart` at a few increments for the page, with its words."""
    x, pressure, shear, _ = _middle(contact)
    touching = np.flatnonzero((contact.status != OPEN).any(axis=1))
    shown = touching if len(touching) else np.arange(len(pressure))
    chosen = [int(shown[i]) for i in style.evenly_spaced(len(shown), 4)]
    last = chosen[-1]
    values = {"pressure": pressure[last].max(), "shear": np.abs(shear[last]).max()}
    values |= {"number": last + 1, "at": x[pressure[last].argmax()]}
    return caption_chart(contact_chart(contact, chosen), FIGURES, "tractions", **values)


def middle_tractions(contact: ContactHistory, line: IntArray) -> tuple[Array, Array, Array]:
    """Places (l,) along ``line``, normal (k, l) and tangential (k, l, 1 | 2) tractions there: in
    3-D recovered from the nodes around."""
    x = contact.points[line, 0]
    if contact.dimension == 2:
        return x, contact.normal_traction[:, line], contact.tangential_traction[:, line]
    x = np.linspace(x.min(), x.max(), 2 * len(x))
    weights = middle_weights(contact.points, contact.areas, line, x, contact.symmetric)
    normal = np.maximum(contact.normal_traction @ weights.T, 0.0)
    tangential: Array = weights @ contact.tangential_traction
    if contact.symmetric:
        tangential[..., 1] = 0.0
    tangential[normal == 0.0] = 0.0  # Recovery blurs the contact's edge; no pressure, no friction.
    return x, normal, tangential


def touched_reach(contact: ContactHistory, line: IntArray) -> tuple[float, float]:
    """The x that are worth showing: all that ever touched, and a little more."""
    x = contact.points[line, 0]
    touched = (contact.status[:, line] != OPEN).any(axis=0)
    if not touched.any():
        return float(x.min()), float(x.max())
    low, high = float(x[touched].min()), float(x[touched].max())
    more = 0.15 * (high - low) + 0.05
    return max(low - more, float(x.min())), min(high + more, float(x.max()))


def status_figure(contact: ContactHistory) -> style.ReportFigure:
    """Open, stick and slip over x and increment, in 3-D on z = 0 (Fig. 7)."""
    figure = style.canvas(7.2, 0.9 + 0.24 * len(contact.status))
    axes = figure.subplots()
    status_bars(axes, contact)
    axes.set_xlim(*touched_reach(contact, contact.mid_line()))
    axes.set_ylim(len(contact.status) + 0.6, 0.4)
    axes.set(xlabel="x (mm)", ylabel="increment")
    axes.grid(visible=False, axis="y")
    axes.yaxis.set_major_locator(style.whole_numbers(16))
    status_legend(axes)
    touched, lengths = (contact.status != OPEN).any(axis=1).sum(), contact.stick_length()
    values = {"touched": int(touched), "most": lengths.max(), "last": lengths[-1]}
    return caption_drawing(figure, FIGURES, "status", **values)


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


def status_legend(
    axes: Axes, shown: Iterable[int] = (STICK, SLIP, OPEN), below: bool = False
) -> None:
    """The legend of the colours: above the axes, or ``below`` the figure."""
    from matplotlib.patches import Patch

    looks = {STATUS_NAMES[status]: STATUS_LOOK[status] for status in shown}
    handles = [
        Patch(facecolor=colour, hatch=hatch, edgecolor=style.PAPER, label=name)
        for name, (colour, hatch) in looks.items()
    ]
    if below:
        axes.figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    else:
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0)}
        axes.legend(handles=handles, ncols=len(handles), **place)
