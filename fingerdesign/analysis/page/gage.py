"""Figures of the gages: strain profiles, response, gage area and stick area (Fig. 8)."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fingerdesign.analysis.page.tables import FIGURES
from fingerdesign.analysis.verdicts import GOOD_CORRELATION
from fingerdesign.arrays import Array, IntArray
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.records.arrays import GripTrace, SlipStudy
from fingerdesign.records.result import IncrementResult, Result
from fingerdesign.report import style
from fingerdesign.report.figure import Figure, Panel, caption_chart, panels
from fingerdesign.report.page import caption_drawing, texts_of
from fingerdesign.report.style import Axes
from fingerdesign.report.table import loaded_increments, number_text, without_noise


def paths_figure(traces: tuple[GripTrace, ...]) -> style.ReportFigure:
    """F_t over F_n for every grip, a panel each, with limit, holds and target (paper, Fig. 10)."""
    columns = min(3, len(traces))
    figure = style.canvas(7.2, 0.7 + 2.4 * -(-len(traces) // columns))
    panels = style.small_multiples(figure, len(traces), columns, up="tangential force (N)")
    for axes, trace in zip(panels, traces, strict=True):
        _draw_path(axes, trace)
        axes.set_xlabel("normal force (N)")
    style.shared_legend(panels, 3)
    return caption_drawing(figure, FIGURES, "paths", grips="; ".join(map(_lift_text, traces)))


def _lift_text(trace: GripTrace) -> str:
    grip = f"μ {trace.friction_coefficient:g}, {trace.object_mass_g:g} g"
    if trace.lift_step is None:
        return f"{grip}: not lifted in {len(trace.dx)} steps"
    least = trace.weight_per_finger_N / trace.friction_coefficient
    force = trace.normal_force[trace.lift_step]
    return f"{grip}: lifted at {force:.2f} N, the least is {least:.2f} N"


def _draw_rule(panels: Sequence[Axes], trace: GripTrace) -> None:
    """Draw one grip's stick ratio and, in the second panel where there is one, its gage area."""
    upper, lower = panels[0], panels[-1]
    step = np.arange(1, len(trace.dx) + 1)
    for axes in panels:
        axes.set_axis_on()
        _shade_holds(axes, trace)
        axes.set_xlim(0.5, len(step) + 0.5)
    upper.plot(step, trace.stick_ratio, color=style.BLUE, label="stick ratio (the judge's)")
    if trace.reported_stick_ratio is not None:  # of the sample before the step
        reported = trace.reported_stick_ratio
        upper.plot(step - 1, reported, color=style.VERMILION, ls=(0, (3, 2)), lw=1.0)
    upper.set_ylim(-0.04, 1.04)
    upper.set_title(f"μ = {trace.friction_coefficient:g}, {trace.object_mass_g:g} g")
    if lower is not upper:
        upper.tick_params(labelbottom=False)
        dashed = (0, (6, 2))
        lower.plot(step, trace.gage_area_mm, color=style.VERMILION, ls=dashed, label="gage area")
        lower.set_ylim(bottom=0.0)
    lower.set_xlabel("step")


def rule_figure(traces: tuple[GripTrace, ...]) -> style.ReportFigure:
    """True stick ratio and, of a rule that makes one, its gage area by step; holds shaded."""
    columns = min(3, len(traces))
    sampled = any(np.isfinite(trace.gage_area_mm).any() for trace in traces)
    high = 2 if sampled else 1  # panels of one grip
    rows = -(-len(traces) // columns)
    figure = style.canvas(7.2, 0.5 + (3.4 if sampled else 1.9) * rows)
    grid = figure.subplots(high * rows, columns, squeeze=False)
    for spare in grid.ravel():
        spare.set_axis_off()
    for number, trace in enumerate(traces):
        row, column = high * (number // columns), number % columns
        panels = [grid[row + k][column] for k in range(high)]
        _draw_rule(panels, trace)
        if column == 0:
            panels[0].set_ylabel("true stick ratio")
            if sampled:
                panels[-1].set_ylabel("gage area (mm)")
    grips = "; ".join(
        f"{trace.object_mass_g:g} g, μ {trace.friction_coefficient:g}: the {trace.controller} "
        f"controller holds {len(trace.hold_starts)} times, for {trace.hold.sum()} of the "
        f"{len(trace.hold)} steps from first contact on"
        for trace in traces
    )
    return caption_drawing(figure, FIGURES, "rule", grips=grips)


def _draw_path(axes: Axes, trace: GripTrace) -> None:
    weight, mu, free = trace.weight_per_finger_N, trace.friction_coefficient, trace.without_rule
    reach = max(float(trace.normal_force.max()), weight / mu) * 1.08
    limit = "slip limit F_t = μ F_n"
    axes.plot([0, reach], [0, mu * reach], color=style.INK, ls=":", lw=1.2, label=limit)
    axes.axhline(weight, color=style.MUTED, ls="-.", lw=1.0, label="weight mg/2")
    if free is not None:
        dashed = dict[str, Any](color=style.PURPLE, ls=(0, (4, 2)), lw=1.2)
        axes.plot(*free.forces, **dashed, label="without the rule")
    axes.plot(*trace.forces, color=style.BLUE, lw=1.8, label="grip")
    if len(starts := trace.hold_starts):
        axes.plot(*trace.forces[:, starts], **style.points(style.VERMILION, "^", 5, "hold begins"))
    least = style.points(style.INK, "x", 7, "least force (mg/2μ, mg/2)", mew=1.6)
    axes.plot([weight / mu], [weight], **least)
    if trace.lift_step is not None:
        star = style.points(style.GREEN, "*", 11, "lifted")
        axes.plot(*trace.forces[:, [trace.lift_step]], **star)
    axes.set_title(f"μ = {mu:g}, {trace.object_mass_g:g} g")
    axes.set_xlim(0, reach)
    axes.set_ylim(0, 1.15 * max(weight, float(trace.tangential_force.max())))


def _shade_holds(axes: Axes, trace: GripTrace) -> None:
    edges = np.flatnonzero(np.diff(trace.hold.astype(int), prepend=0, append=0))
    for begin, end in edges.reshape(-1, 2):
        axes.axvspan(begin + 0.5, end + 0.5, color=style.SERIES[4][0], alpha=0.22, lw=0)


def plate_rows(plates: Sequence[PlateFrame], placed: bool = False) -> tuple[tuple[int, ...], ...]:
    """The plates by rows, by their places in ``plates``: of one direction, from - to +.

    placed: their centres were given one by one, in any order: one row.
    """
    rows: list[list[int]] = []
    for k, plate in enumerate(plates):
        before = plates[k - 1]
        same = before.along == plate.along and before.place < plate.place
        if k and (placed or same):
            rows[-1].append(k)
        else:
            rows.append([k])
    return tuple(map(tuple, rows))


def gages_chart(
    result: Result, plates: Sequence[PlateFrame] = (), chosen: Sequence[int] | None = None
) -> Figure:
    """Membrane and bending strain of every gage at the chosen increments, a pair of panels a row.

    plates: the plates' frames, (gages,); without them the plate's number is the abscissa. Rows
    along x are drawn over x, rows along z over z. chosen: from 0, by default a few under load.
    """
    rows = result.increments
    shown = _few_under_load(rows) if chosen is None else chosen
    numbers, known, strains = _strains(rows, plates)
    placed = result.parameters.get("plates.placement") is not None
    groups = plate_rows(plates, placed) if known else (tuple(range(len(numbers))),)
    titles = ("Membrane: mean of both faces", "Bending: half their difference")
    drawn = []
    for number, group in enumerate(groups):
        order, label = np.array(group), "plate"
        x = numbers[order].astype(float)
        if known:
            x = np.array([plates[k].place for k in group])
            label = f"plate centre {plates[group[0]].along} (mm)"
            order, x = order[np.argsort(x, kind="stable")], np.sort(x)
        row = f"Row {number + 1}. " if len(groups) > 1 else ""
        for title, values in zip(titles, strains, strict=True):
            lines = [(f"increment {k + 1}", x, values[k, order]) for k in shown]
            drawn.append(Panel(row + title, label, "strain (microstrain)", lines))
    return panels(drawn, 2)


def _few_under_load(rows: Sequence[IncrementResult]) -> list[int]:
    shown = loaded_increments(rows) or list(range(len(rows)))
    return [shown[i] for i in style.evenly_spaced(len(shown), 4)]


def _strains(
    rows: Sequence[IncrementResult], plates: Sequence[PlateFrame]
) -> tuple[IntArray, bool, Array]:
    """Plates of the gages, whether ``plates`` are theirs, and membrane and bending strain (2, k,
    gages), microstrain."""
    numbers = np.array([gage.plate for gage in rows[0].gages], dtype=int)
    both = ("membrane", "bending")
    strains = [[[getattr(g, part) for g in row.gages] for row in rows] for part in both]
    return numbers, len(plates) == len(numbers), without_noise(np.array(strains))


def strain_figure(result: Result, plates: Sequence[PlateFrame] = ()) -> style.ReportFigure:
    """:func:`gages_chart` at a few increments for the page, with its words."""
    numbers, _, strains = _strains(result.increments, plates)
    number = _few_under_load(result.increments)[-1]
    last = strains[:, number]
    most, bent = (int(np.abs(values).argmax()) for values in last)
    values: dict[str, Any] = {"membrane": (numbers[most], last[0, most]), "number": number + 1}
    values |= {"bending": (numbers[bent], last[1, bent])}
    grid = texts_of(FIGURES)["grids"][result.parameters.get("gages.grid", "axial")]
    return caption_chart(gages_chart(result, plates), FIGURES, "strains", grid=grid, **values)


def shade_over(axes: Axes, x: Array, over: Array, threshold: float, fine: int = 8) -> None:
    """Fill what of the curve is over the threshold."""
    places = np.linspace(x[0], x[-1], fine * (len(x) - 1) + 1)
    height = np.interp(places, x, over)
    above = height > threshold
    axes.fill_between(places, threshold, height, where=above, color=style.BLUE, alpha=0.25, lw=0)


def response_figure(study: SlipStudy, share: float) -> style.ReportFigure:
    """|change of strain / change of F_t| gage by gage at up to eight steps (paper, Fig. 8).

    share: of the largest response at full stick, where the threshold is (``gages.area_share``).
    """
    mu = study.friction_coefficient
    key = f"response-{mu:g}".replace(".", "-")
    usable = np.flatnonzero(np.isfinite(study.response).any(axis=1))
    chosen = [int(usable[i]) for i in style.evenly_spaced(len(usable), 8)]
    count = max(len(chosen), 1)
    figure = style.canvas(7.2, 0.7 + 1.75 * -(-count // 4))
    labels = {"across": "plate centre x (mm)", "up": "microstrain/N"}
    panels = style.small_multiples(figure, count, 4, **labels, sharex=True, sharey=True)
    x = study.gage_x_mm
    raw = dict[str, Any](color=style.MUTED, ls=(0, (1.5, 1.5)), lw=1.1, label="raw")
    level = dict[str, Any](color=style.VERMILION, ls=(0, (5, 2)), lw=1.1, label="threshold")
    for axes, step in zip(panels, chosen, strict=False):
        over = np.nan_to_num(study.response[step])
        axes.plot(x, study.response_raw[step], **raw)
        axes.plot(x, over, color=style.BLUE, marker="o", ms=2.8, label="compensated")
        axes.axhline(study.threshold, **level)
        shade_over(axes, x, over, study.threshold)
        title = f"step {step + 1}: A {study.gage_area_mm[step]:.1f},"
        title += f" stick {study.stick_length_mm[step]:.1f} mm"
        axes.set_title(title, fontsize=7.5, fontweight="normal")
    finite = study.response[np.isfinite(study.response)]
    # The raw curve may be far above while F_n grows; the scale is that of what is judged.
    top = max(float(finite.max(initial=0.0)), study.threshold)
    panels[0].set_ylim(0.0, 1.25 * top)
    if chosen:
        style.shared_legend(panels[:1], 3, "upper right")
    steps = "; ".join(
        f"step {step + 1}: gage area {study.gage_area_mm[step]:.2f} mm, "
        f"stick length {study.stick_length_mm[step]:.2f} mm"
        for step in chosen
    )
    values = {"mu": mu, "share": share, "floor": study.force_floor_N, "threshold": study.threshold}
    return caption_drawing(figure, FIGURES, "response", key, **values, top=top, steps=steps)


def area_figure(studies: tuple[SlipStudy, ...]) -> style.ReportFigure:
    """Gage area and true stick length by step, a panel a friction coefficient."""
    columns = min(3, len(studies))
    figure = style.canvas(7.2, 0.6 + 2.3 * -(-len(studies) // columns))
    up = "length along x (mm)"
    panels = style.small_multiples(figure, len(studies), columns, up=up, sharey=True)
    for axes, study in zip(panels, studies, strict=True):
        step = np.arange(1, len(study.stick_ratio) + 1)
        curves = (
            (study.stick_length_mm, "stick length (true)", style.INK),
            (study.gage_area_mm, "gage area A", style.BLUE),
            (study.gage_area_raw_mm, "gage area, raw", style.MUTED),
        )
        for look, (values, name, colour) in enumerate(curves):
            style.series(axes, step, values, look, name, color=colour, ms=3.5)
        ranks = (study.rank_correlation, study.rank_correlation_raw)
        own, raw = ("not defined" if each is None else f"{each:.2f}" for each in ranks)
        title = f"μ = {study.friction_coefficient:g}: rank correlation\n{own} (raw {raw})"
        axes.set_title(title)
        axes.set_xlabel("step")
        axes.set_ylim(bottom=0.0)
    style.shared_legend(panels[:1], 3)
    named = (
        f"{number_text(study.rank_correlation, 2)} at μ {study.friction_coefficient:g}"
        for study in studies
    )
    shown = ", ".join(named)
    return caption_drawing(figure, FIGURES, "areas", enough=GOOD_CORRELATION, ranks=shown)
