"""Figures of the gages: strain profiles, response and gage area beside stick area (Fig. 8)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.analysis.page.verdict import GOOD_CORRELATION, UNDEFINED
from fingerdesign.analysis.page.words import plate_rows
from fingerdesign.arrays import Array
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.records.result import Result, SlipStudy
from fingerdesign.report.numbers import cleaned, under_load
from fingerdesign.report.style import (
    BLUE,
    INK,
    MUTED,
    SERIES,
    VERMILION,
    ReportFigure,
    canvas,
    small_multiples,
    spread,
    to_svg,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SAME_PATH = (
    "Other friction coefficients run the same approach, and the shear scaled by μ / μ of the scene."
)


def strain_figure(result: Result, plates: Sequence[PlateFrame] = ()) -> ReportFigure:
    """Membrane and bending strain of every gage at a few increments, a pair of panels a row.

    plates: the plates' frames, (gages,); without them the plate's number is the abscissa. Rows
    along x are drawn over x, rows along z over z.
    """
    rows = result.increments
    shown = under_load(rows) or list(range(len(rows)))
    chosen = [shown[i] for i in spread(len(shown), 4)]
    numbers = np.array([gage.plate for gage in rows[0].gages])
    known = len(plates) == len(numbers)
    placed = result.parameters.get("plates.placement") is not None
    groups = plate_rows(plates, placed) if known else (tuple(range(len(numbers))),)
    both = ("membrane", "bending")
    strains = cleaned(
        np.array([[[getattr(g, part) for g in row.gages] for row in rows] for part in both])
    )
    figure = canvas(7.2, 0.6 + 2.6 * len(groups))
    panels = figure.subplots(len(groups), 2, squeeze=False)
    titles = ("Membrane: mean of both faces", "Bending: half their difference")
    for number, (group, pair) in enumerate(zip(groups, panels, strict=True)):
        order = np.array(group)
        x, label = numbers[order], "plate"
        if known:
            x = np.array([plates[k].place for k in group])
            label = f"plate centre {plates[group[0]].along} (mm)"
            order, x = order[np.argsort(x, kind="stable")], np.sort(x)
        for axes, values, title in zip(pair, strains, titles, strict=True):
            _draw_strains(axes, x, values[:, order], chosen)
            axes.set_xlabel(label)
            row = f"Row {number + 1}. " if len(groups) > 1 else ""
            axes.set_title(row + title)
        pair[0].set_ylabel("strain (microstrain)")
    lines = panels[0, 0].get_legend_handles_labels()
    figure.legend(*lines, loc="outside lower center", ncols=4)
    last = strains[:, chosen[-1]]
    most, bent = (int(np.abs(values).argmax()) for values in last)
    alternative = (
        f"At increment {chosen[-1] + 1} the largest membrane strain is {last[0, most]:.3g} "
        f"microstrain (plate {numbers[most]}) and the largest bending strain {last[1, bent]:.3g} "
        f"microstrain (plate {numbers[bent]})."
    )
    reading = (
        "Strain along each plate, tension positive. A single gage on one face reads membrane plus "
        "or minus bending; a two-gage bridge reads the membrane part alone."
    )
    if known and any(plate.along == "z" for plate in plates):
        reading += " Plates of rows along z are strained by shear in z, not in x."
    return ReportFigure(
        "strains",
        "What the gages read",
        to_svg(figure, "strains", alternative),
        reading,
        alternative,
    )


def _draw_strains(axes: Axes, x: np.ndarray, values: np.ndarray, chosen: list[int]) -> None:
    for number, (colour, dashes, marker) in zip(chosen, SERIES, strict=False):
        label = f"increment {number + 1}"
        axes.plot(x, values[number], color=colour, ls=dashes, marker=marker, ms=3.5, label=label)
    axes.axhline(0.0, color=MUTED, lw=0.8)
    if not values[chosen].any():
        axes.set_ylim(-1.0, 1.0)


def _shade_over(axes: Axes, x: Array, over: Array, threshold: float) -> None:
    """Fill what of the curve is over the threshold."""
    fine = np.linspace(x[0], x[-1], 8 * (len(x) - 1) + 1)
    height = np.interp(fine, x, over)
    axes.fill_between(
        fine,
        threshold,
        height,
        where=height > threshold,
        color=BLUE,
        alpha=0.25,
        lw=0,
    )


def response_figure(study: SlipStudy) -> ReportFigure:
    """|change of strain / change of F_t| gage by gage at up to eight steps (paper, Fig. 8)."""
    mu = study.friction_coefficient
    key = f"response-{mu:g}".replace(".", "-")
    usable = np.flatnonzero(np.isfinite(study.response).any(axis=1))
    chosen = [int(usable[i]) for i in spread(len(usable), 8)]
    figure = canvas(7.2, 0.7 + 1.75 * -(-max(len(chosen), 1) // 4))
    panels = small_multiples(figure, max(len(chosen), 1), 4, sharex=True, sharey=True)
    x = study.gage_x_mm
    for axes, step in zip(panels, chosen, strict=False):
        over = np.nan_to_num(study.response[step])
        axes.plot(x, study.response_raw[step], color=MUTED, ls=(0, (1.5, 1.5)), lw=1.1, label="raw")
        axes.plot(x, over, color=BLUE, marker="o", ms=2.8, label="compensated")
        axes.axhline(study.threshold, color=VERMILION, ls=(0, (5, 2)), lw=1.1, label="threshold")
        _shade_over(axes, x, over, study.threshold)
        title = f"step {step + 1}: A {study.gage_area_mm[step]:.1f},"
        axes.set_title(
            f"{title} stick {study.stick_length_mm[step]:.1f} mm", fontsize=7.5, fontweight="normal"
        )
    finite = study.response[np.isfinite(study.response)]
    # The raw curve may be far above while F_n grows; the scale is that of what is judged.
    top = max(float(finite.max(initial=0.0)), study.threshold)
    panels[0].set_ylim(0.0, 1.25 * top)
    for axes in panels[-4:]:
        axes.set_xlabel("plate centre x (mm)")
    for axes in panels[::4]:
        axes.set_ylabel("microstrain/N")
    if chosen:
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=3)
    alternative = (
        f"At friction coefficient {mu:g} the compensated response reaches {top:.3g} microstrain/N "
        f"at most; the threshold is {study.threshold:.3g}. "
        + " ".join(
            f"Step {step + 1}: gage area {study.gage_area_mm[step]:.2f} mm, stick length "
            f"{study.stick_length_mm[step]:.2f} mm."
            for step in chosen
        )
    )
    return ReportFigure(
        key,
        f"Response of each gage, friction coefficient {mu:g}",
        to_svg(figure, key, alternative),
        "Change of strain per change of tangential force. The gage area A is the length of plate "
        "positions where the curve is over the threshold (shaded), which is half of "
        "this finger's largest response at full stick. Compensated: rid of what the "
        "change of normal force alone would cause; raw is dotted and may leave the panel. Steps in "
        f"which F_t changes by less than {study.force_floor_N:.2g} N have no curve: A is held. "
        f"{SAME_PATH} (Fig. 8 of the paper.)",
        alternative,
    )


def area_figure(studies: tuple[SlipStudy, ...]) -> ReportFigure:
    """Gage area beside true stick length by step, a panel a friction coefficient."""
    columns = min(3, len(studies))
    figure = canvas(7.2, 0.6 + 2.3 * -(-len(studies) // columns))
    panels = small_multiples(figure, len(studies), columns, sharey=True)
    words = []
    for axes, study in zip(panels, studies, strict=True):
        step = np.arange(1, len(study.stick_ratio) + 1)
        for values, name, look, colour in (
            (study.stick_length_mm, "stick length (true)", SERIES[0], INK),
            (study.gage_area_mm, "gage area A", SERIES[1], BLUE),
            (study.gage_area_raw_mm, "gage area, raw", SERIES[2], MUTED),
        ):
            axes.plot(step, values, color=colour, ls=look[1], marker=look[2], ms=3.5, label=name)
        compensated, raw = (
            "not defined" if value is None else f"{value:.2f}"
            for value in (study.rank_correlation, study.rank_correlation_raw)
        )
        axes.set_title(
            f"μ = {study.friction_coefficient:g}: rank correlation\n{compensated} (raw {raw})"
        )
        axes.set_xlabel("step")
        axes.set_ylim(bottom=0.0)
        words.append(
            f"At friction coefficient {study.friction_coefficient:g} the rank correlation is "
            f"{compensated}, without compensation {raw}."
        )
    for axes in panels[::columns]:
        axes.set_ylabel("length along x (mm)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    alternative = " ".join(words)
    return ReportFigure(
        "areas",
        "Does the gage area follow the stick area?",
        to_svg(figure, "areas", alternative),
        "What matters is that both rise and fall together, not that they are equal: the rank "
        "correlation of A with the stick area says how well (1: always, 0: not at all); over "
        f"{GOOD_CORRELATION:g} counts as following. It is not defined where there is {UNDEFINED}. "
        f"{SAME_PATH}",
        alternative,
    )
