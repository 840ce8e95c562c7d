"""Figures of the contact: forces and stick ratio by increment, tractions (paper, Fig. 6)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.report.motion import force_controlled, leaves_section
from fingerdesign.report.numbers import cleaned
from fingerdesign.report.style import (
    SERIES,
    ReportFigure,
    canvas,
    spread,
    to_svg,
    whole_numbers,
)
from fingerdesign.results import OPEN, SLIP, ContactHistory, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray


def force_figure(result: Result) -> ReportFigure:
    """Forces by increment, the twist moment where there is one, and the stick ratio (Fig. 6)."""
    rows = result.increments
    step = np.arange(1, len(rows) + 1)
    both = [[row.normal_force_N, row.tangential_force_N] for row in rows]
    normal, tangential = cleaned(np.array(both)).T  # on one scale: F_t may be noise beside F_n
    ratio = np.array([np.nan if r.stick_ratio is None else r.stick_ratio for r in rows])
    aside = leaves_section(rows)
    figure = canvas(7.2, 2.9)
    if aside:
        forces, moments, sticks = figure.subplots(1, 3, width_ratios=(3, 2, 2))
    else:
        forces, sticks = figure.subplots(1, 2, width_ratios=(3, 2))
    curves = [
        (normal, "normal force", SERIES[0]),
        (tangential, "tangential force", SERIES[1]),
    ]
    most = float(np.abs(normal).max(initial=0.0))
    if aside:
        along = cleaned((row.force_z_N for row in rows), scale=most)
        moment = cleaned((row.twist_moment_Nmm for row in rows), scale=most)
        curves[1] = (tangential, "tangential force, x", SERIES[1])
        curves.append((along, "force along z", SERIES[3]))
        colour, dashes, marker = SERIES[4]
        moments.plot(step, moment, color=colour, ls=dashes, marker=marker)
        moments.set(xlabel="increment", ylabel="moment about y (N mm)", title="Twist moment")
        moments.xaxis.set_major_locator(whole_numbers(5))
        _show_zero(moments, moment)
    for values, name, (colour, dashes, marker) in curves:
        forces.plot(step, values, color=colour, ls=dashes, marker=marker, label=name)
    forces.set(xlabel="increment", ylabel="force on the finger (N)", title="Forces")
    forces.legend(loc="best")
    colour, dashes, marker = SERIES[2]
    sticks.plot(step, ratio, color=colour, ls=dashes, marker=marker)
    sticks.set(xlabel="increment", ylabel="stick area / contact area", title="Stick ratio")
    sticks.set_ylim(-0.04, 1.04)
    for axes in (forces, sticks):
        axes.xaxis.set_major_locator(whole_numbers(5 if aside else 8))
    _show_zero(forces, normal, tangential)
    last = f"{ratio[-1]:.2f}" if np.isfinite(ratio[-1]) else "not defined (no contact)"
    alternative = (
        f"Over {len(rows)} increments the normal force goes from {normal[0]:.3g} to "
        f"{normal[-1]:.3g} N and the tangential force from {tangential[0]:.3g} to "
        f"{tangential[-1]:.3g} N; "
        + (
            f"at the end the force along z is {along[-1]:.3g} N and the twist moment "
            f"{moment[-1]:.3g} N mm; "
            if aside
            else ""
        )
        + f"the stick ratio at the end is {last}."
    )
    point = "forces prescribed" if force_controlled(result) else "object's motion"
    paper = "" if aside else " (After Fig. 6 of the paper.)"
    return ReportFigure(
        "forces",
        "Forces and stick ratio, increment by increment",
        to_svg(figure, "forces", alternative),
        f"Each point is one increment of the {point}. The finger is near complete slip where the "
        f"stick ratio comes down to zero: friction can then carry no more at this pressure.{paper}",
        alternative,
    )


def traction_figure(contact: ContactHistory) -> ReportFigure:
    """Pressure and shear traction on the mid-plane at a few increments.

    Along x, signed; its magnitude where it has a part along z.
    """
    line = contact.mid_line()
    x = contact.points[line, 0]
    pressure = cleaned(contact.normal_traction[:, line])
    both = cleaned(contact.tangential_traction[:, line], scale=float(pressure.max(initial=0.0)))
    size = np.linalg.norm(both, axis=2)
    # A free mesh has no row of nodes on z = 0: a little stands aside there even in pure shear.
    turned = bool(np.abs(both[..., 1:]).max(initial=0.0) > 0.02 * size.max(initial=0.0))
    shear = size if turned else both[..., 0]
    touching = np.flatnonzero((contact.status != OPEN).any(axis=1))
    shown = touching if len(touching) else np.arange(len(pressure))
    chosen = [int(shown[i]) for i in spread(len(shown), 4)]
    figure = canvas(7.2, 3.2)
    left, right = figure.subplots(1, 2, sharex=True)
    for number, (colour, dashes, _) in zip(chosen, SERIES, strict=False):
        label = f"increment {number + 1}"
        left.plot(x, pressure[number], color=colour, ls=dashes, label=label)
        right.plot(x, shear[number], color=colour, ls=dashes, label=label)
    reach = touched_reach(contact, line)
    left.set_xlim(*reach)
    left.set(xlabel="x (mm)", ylabel="pressure (MPa)", title="Pressure")
    what = "magnitude of shear traction" if turned else "shear traction along x"
    right.set(xlabel="x (mm)", ylabel=f"{what} (MPa)", title="Shear traction")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    _show_zero(left, pressure)
    _show_zero(right, shear)
    last = chosen[-1]
    place = "" if contact.dimension == 2 else " on the mid-plane z = 0"
    if not len(touching):
        alternative = "The object touches in none of the increments: all tractions are 0 MPa."
    elif pressure[last].any():
        alternative = (
            f"At increment {last + 1} the pressure{place} peaks at {pressure[last].max():.3g} MPa "
            f"at x = {x[pressure[last].argmax()]:.2f} mm; "
        ) + (
            f"the shear traction reaches {np.abs(shear[last]).max():.3g} MPa."
            if shear[last].any()
            else "there is no shear traction (0 MPa)."
        )
    else:
        alternative = f"At increment {last + 1} the surface{place} carries no pressure (0 MPa)."
    return ReportFigure(
        "tractions",
        "Pressure and shear traction",
        to_svg(figure, "tractions", alternative),
        f"Tractions on the finger{place} at a few increments"
        + (", the shear traction's magnitude over x and z" if turned else "")
        + ". Where the surface slips, the shear traction is in magnitude the friction coefficient "
        "times the pressure; where it sticks, it is at most that."
        + (
            " Here that is so to a few percent: the object slopes; the tractions are drawn along "
            "the finger's axes, not along its surface."
            if _slopes(contact)
            else ""
        ),
        alternative,
    )


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
