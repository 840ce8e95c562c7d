"""Figures of the grips: force paths against the friction limit, and what the rule saw (Fig. 10)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.records.result import GripTrace
from fingerdesign.report.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    PURPLE,
    SERIES,
    VERMILION,
    ReportFigure,
    canvas,
    small_multiples,
    to_svg,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes


def paths_figure(traces: tuple[GripTrace, ...]) -> ReportFigure:
    """F_t over F_n for every grip, a panel each, with limit, holds and target (paper, Fig. 10)."""
    columns = min(3, len(traces))
    figure = canvas(7.2, 0.7 + 2.4 * -(-len(traces) // columns))
    panels = small_multiples(figure, len(traces), columns)
    for axes, trace in zip(panels, traces, strict=True):
        _draw_path(axes, trace)
        axes.set_xlabel("normal force (N)")
    for axes in panels[::columns]:
        axes.set_ylabel("tangential force (N)")
    seen: dict[str, Artist] = {}
    for axes in panels:
        handles, labels = axes.get_legend_handles_labels()
        seen = dict(zip(labels, handles, strict=True)) | seen
    figure.legend(seen.values(), seen.keys(), loc="outside lower center", ncols=3)
    alternative = " ".join(_path_words(trace) for trace in traces)
    return ReportFigure(
        "paths",
        "The grips: tangential over normal force",
        to_svg(figure, "paths", alternative),
        "The object would slip on the dotted line (F_t = μ F_n). Triangles mark where the rule "
        "begins to hold the tangential motion. A good grip reaches the weight line (dash-dotted: "
        "half the weight for each finger) without touching the dotted line and not far right of "
        "the cross, the least force that could do it. (Fig. 10 of the "
        "paper.)",
        alternative,
    )


def rule_figure(traces: tuple[GripTrace, ...]) -> ReportFigure:
    """True stick ratio and, of a rule that makes one, its gage area by step; holds shaded."""
    columns = min(3, len(traces))
    sampled = any(np.isfinite(trace.gage_area_mm).any() for trace in traces)
    high = 2 if sampled else 1  # panels of one grip
    rows = -(-len(traces) // columns)
    figure = canvas(7.2, 0.5 + (3.4 if sampled else 1.9) * rows)
    grid = figure.subplots(high * rows, columns, squeeze=False)
    for spare in grid.ravel():
        spare.set_axis_off()
    for number, trace in enumerate(traces):
        row, column = high * (number // columns), number % columns
        panels = [grid[row + k][column] for k in range(high)]
        step = np.arange(1, len(trace.dx) + 1)
        for axes in panels:
            axes.set_axis_on()
            _shade_holds(axes, trace)
            axes.set_xlim(0.5, len(step) + 0.5)
        upper, lower = panels[0], panels[-1]
        upper.plot(step, trace.stick_ratio, color=BLUE, label="stick ratio (the judge's)")
        upper.set_ylim(-0.04, 1.04)
        upper.set_title(f"μ = {trace.friction_coefficient:g}, {trace.object_mass_g:g} g")
        if sampled:
            upper.tick_params(labelbottom=False)
            lower.plot(step, trace.gage_area_mm, color=VERMILION, ls=(0, (6, 2)), label="gage area")
            lower.set_ylim(bottom=0.0)
        lower.set_xlabel("step")
        if column == 0:
            upper.set_ylabel("true stick ratio")
            if sampled:
                lower.set_ylabel("gage area (mm)")
    alternative = " ".join(
        f"At friction coefficient {trace.friction_coefficient:g} the stick ratio is never below "
        f"{_least(trace.stick_ratio)}; {trace.controller} held {int(trace.hold.sum())} of "
        f"{len(trace.hold)} steps."
        for trace in traces
    )
    caption = "the true stick ratio, which the controller never sees"
    below = "; below, the gage area that it makes of its readings" if sampled else ""
    return ReportFigure(
        "rule",
        "What the rule saw and what was true" if sampled else "How much stuck",
        to_svg(figure, "rule", alternative),
        f"{'Above, ' if sampled else 'By step, '}{caption}{below}. Shaded: steps in which it held "
        "the tangential motion.",
        alternative,
    )


def _draw_path(axes: Axes, trace: GripTrace) -> None:
    normal, tangential = trace.normal_force, trace.tangential_force
    weight, mu = trace.weight_per_finger_N, trace.friction_coefficient
    free = trace.without_rule
    reach = max(float(normal.max()), weight / mu) * 1.08
    axes.plot(
        [0, reach], [0, mu * reach], color=INK, ls=":", lw=1.2, label="slip limit F_t = μ F_n"
    )
    axes.axhline(weight, color=MUTED, ls="-.", lw=1.0, label="weight mg/2")
    if free is not None:
        axes.plot(
            free.normal_force,
            free.tangential_force,
            color=PURPLE,
            ls=(0, (4, 2)),
            lw=1.2,
            label="without the rule",
        )
    axes.plot(normal, tangential, color=BLUE, lw=1.8, label="grip")
    starts = np.flatnonzero(np.diff(trace.hold.astype(int), prepend=0) == 1)
    if len(starts):
        axes.plot(
            normal[starts],
            tangential[starts],
            color=VERMILION,
            ls="none",
            marker="^",
            ms=5,
            label="hold begins",
        )
    axes.plot(
        [weight / mu],
        [weight],
        color=INK,
        ls="none",
        marker="x",
        ms=7,
        mew=1.6,
        label="least force (mg/2μ, mg/2)",
    )
    if trace.lift_step is not None:
        axes.plot(
            [normal[trace.lift_step]],
            [tangential[trace.lift_step]],
            color=GREEN,
            ls="none",
            marker="*",
            ms=11,
            label="lifted",
        )
    axes.set_title(f"μ = {mu:g}, {trace.object_mass_g:g} g")
    axes.set_xlim(0, reach)
    axes.set_ylim(0, 1.15 * max(weight, float(tangential.max())))


def _shade_holds(axes: Axes, trace: GripTrace) -> None:
    edges = np.flatnonzero(np.diff(trace.hold.astype(int), prepend=0, append=0))
    for begin, end in edges.reshape(-1, 2):
        axes.axvspan(begin + 0.5, end + 0.5, color=SERIES[4][0], alpha=0.22, lw=0)


def _path_words(trace: GripTrace) -> str:
    head = f"Friction coefficient {trace.friction_coefficient:g}, {trace.object_mass_g:g} g: "
    holds = int(np.sum(np.diff(trace.hold.astype(int), prepend=0) == 1))
    if trace.lift_step is None:
        tail = f"not lifted in {len(trace.dx)} steps"
    else:
        normal = trace.normal_force[trace.lift_step]
        least = trace.weight_per_finger_N / trace.friction_coefficient
        tail = f"lifted at a normal force of {normal:.2f} N, where {least:.2f} N is the least"
    return f"{head}{tail}; {holds} hold{'' if holds == 1 else 's'}."


def _least(values: np.ndarray) -> str:
    finite = values[np.isfinite(values)]
    return f"{finite.min():.2f}" if len(finite) else "defined"
