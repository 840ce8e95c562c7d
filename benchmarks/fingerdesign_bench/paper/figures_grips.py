"""Figures 2, 10 and 12 of the paper: the way of the forces to the lift."""

from collections.abc import Sequence

import numpy as np

from fingerdesign.records.arrays import GripTrace
from fingerdesign.report import style
from fingerdesign.report.style import Axes
from fingerdesign_bench.paper.figures import PaperFigure, paper_figure, shades
from fingerdesign_bench.paper.lifts import Lift, Route
from fingerdesign_bench.paper.measurement import Measured, Rig, noise_of

_TRACE_COLUMNS = (
    *("step", "normal_force_N", "tangential_force_N", "friction_limit_N", "stick_ratio"),
    *("gage_area_mm", "hold"),
)


def _mark_target(axes: Axes, weight: float, mu: float, label: str | None = None) -> None:
    """The least forces that could hold the object."""
    axes.plot([weight / mu], [weight], **style.points(style.INK, "x", 8, label, mew=1.8))


def _draw_limits(axes: Axes, weight: float, mu: float, reach: float, words: bool = False) -> None:
    """Draw where the object slips and where it is held, up to a normal force of ``reach``."""
    slips, lifts = (": it slips", ": it lifts") if words else ("", "")
    axes.plot(
        [0, reach], [0, mu * reach], color=style.INK, ls=":", lw=1.2, label=f"F_t = μ F_n{slips}"
    )
    axes.axhline(weight, color=style.MUTED, ls="-.", lw=1.0, label=f"mg/2{lifts}")
    axes.set_xlim(0.0, reach)
    axes.set_ylim(0.0, 1.35 * weight)


def _route_rows(lift: Lift, route: Route) -> list[tuple[object, ...]]:
    """The target and the three routes, a row a step."""
    trace, free = lift.ruled.trace, lift.free.trace
    weight = trace.weight_per_finger_N
    rows: list[tuple[object, ...]] = [("target", 1, weight / lift.friction, weight)]
    for name, forces in (
        ("paper", trace.forces),
        ("never_holding", free.forces),
        ("squeeze", route.forces),
    ):
        rows += [(name, k + 1, *both) for k, both in enumerate(forces.T)]
    return rows


def route_figure(lift: Lift, route: Route) -> PaperFigure:
    """Fig. 2: the path of the forces, its target point, and two other routes."""
    trace, free = lift.ruled.trace, lift.free.trace
    weight, mu = trace.weight_per_finger_N, lift.friction
    figure = style.canvas(7.2, 3.8)
    axes = figure.subplots()
    most = [float(forces[0].max(initial=0.0)) for forces in (route.forces, trace.forces)]
    reach, squeezed = 1.06 * max(most), most[0] * mu / weight
    _draw_limits(axes, weight, mu, reach, words=True)
    ends = "slips" if lift.free.result.gross_slip else "lifts"
    label = f"never holding: {ends}"
    axes.plot(*free.forces, color=style.PURPLE, ls=(0, (4, 2)), lw=1.4, label=label)
    ends = "slips" if route.slips else f"{squeezed:.1f} times the least"
    label = f"pressing first: {ends}"
    axes.plot(*route.forces, color=style.VERMILION, ls=(0, (6, 2, 1.5, 2)), lw=1.4, label=label)
    axes.plot(*trace.forces, color=style.BLUE, lw=2.0, label="paper's rule")
    mark_holds(axes, trace)
    if lift.free.result.gross_slip:
        axes.plot(*free.forces[:, -1:], color=style.PURPLE, marker="X", ms=7)
    _mark_target(axes, weight, mu, "target (mg/2μ, mg/2)")
    words, place = f"({weight / mu:.2f}, {weight:.2f}) N", (weight / mu, weight)
    axes.annotate(words, place, (-4, 9), textcoords="offset points", ha="right")
    axes.set(xlabel="normal force F_n (N)", ylabel="tangential force F_t (N)")
    style.shared_legend([axes], 3)
    context = {"trace": trace, "weight": weight, "mu": mu, "route": route}
    columns = ("route", "step", "normal_force_N", "tangential_force_N")
    return paper_figure(figure, "fig02", columns, _route_rows(lift, route), **context)


def lifts_figure(lifts: Sequence[Lift]) -> PaperFigure:
    """Fig. 10: controlled lifts at several friction coefficients, all in one plane."""
    figure = style.canvas(7.2, 4.2)
    axes = figure.subplots()
    weight = lifts[0].ruled.trace.weight_per_finger_N
    most = np.max([lift.ruled.trace.forces.max(axis=1, initial=0.0) for lift in lifts], axis=0)
    reach, top = 1.05 * float(most[0]), 1.25 * max(weight, float(most[1]))
    marks = "osD^v<>Ph"
    for k, (lift, colour) in enumerate(zip(lifts, shades(len(lifts)), strict=True)):
        marker, label = marks[k % len(marks)], f"μ = {lift.friction:g}"
        axes.plot(
            *lift.ruled.trace.forces, color=colour, marker=marker, ms=3.2, lw=1.6, label=label
        )
        axes.plot([0, reach], [0, lift.friction * reach], color=colour, ls=":", lw=1.1)
        at = min(0.97 * reach, 0.97 * top / lift.friction)
        axes.text(
            at, lift.friction * at, f"{lift.friction:g}", color=style.INK, fontsize=8, ha="right"
        )
    axes.axhline(weight, color=style.MUTED, ls="-.", lw=1.0, label="mg/2")
    for lift in lifts:
        mark_holds(axes, lift.ruled.trace)
        if lift.ruled.result.gross_slip:
            mark_slip(axes, lift.ruled.trace)
    axes.set(xlabel="normal force F_n (N)", ylabel="tangential force F_t (N)")
    axes.set_xlim(0.0, reach)
    axes.set_ylim(0.0, top)
    style.shared_legend([axes], 4)
    rows = [
        row
        for lift in lifts
        for name, trace in (("paper", lift.ruled.trace), ("never_holding", lift.free.trace))
        for row in trace_rows((lift.friction, name), trace)
    ]
    columns = ("friction_coefficient", "rule", *_TRACE_COLUMNS)
    return paper_figure(figure, "fig10", columns, rows, lifts=lifts)


def mark_slip(axes: Axes, trace: GripTrace) -> None:
    """A cross where the object slipped."""
    axes.plot(*trace.forces[:, -1:], **style.points(style.INK, "X", 8, "slipped", zorder=5))


def mark_holds(axes: Axes, trace: GripTrace) -> None:
    """Triangles where the rule begins to hold."""
    before = np.maximum(trace.hold_starts - 1, 0)  # the sample on which the rule decided
    if len(before):
        look = style.points(
            style.VERMILION, "^", 7.5, "rule holds", zorder=4, mec=style.PAPER, mew=0.6
        )
        axes.plot(*trace.forces[:, before], **look)


def trace_rows(head: tuple[object, ...], trace: GripTrace) -> list[tuple[object, ...]]:
    """Rows of a data file, one a step: ``head``, step, F_n, F_t, limit, stick ratio, A, hold."""
    columns = (*trace.forces, trace.limit, trace.stick_ratio, trace.gage_area_mm)
    steps = zip(*columns, trace.hold.astype(int), strict=True)
    return [(*head, k + 1, *row) for k, row in enumerate(steps)]


def measured_figure(rigs: Sequence[Rig], samples: int | None) -> PaperFigure:
    """Fig. 12: grips on the rig at both friction coefficients, a row a finger, a line a seed."""
    frictions = sorted({each.friction for each in rigs[0].grips})
    figure = style.canvas(7.2, 0.8 + 2.6 * len(rigs))
    labels = {"across": "normal force F_n (N)", "up": "F_t (N)"}
    many = len(frictions)
    panels = style.small_multiples(figure, len(rigs) * many, many, **labels, sharey=True)
    chosen = [(rig, friction) for rig in rigs for friction in frictions]
    for axes, (rig, friction) in zip(panels, chosen, strict=True):
        _draw_measured(axes, rig.at(samples, friction), friction)
        axes.set_title(f"{rig.finger}, μ = {friction:g}")
    style.shared_legend(panels, 4)
    columns = ("finger", "samples_a_step", "friction_coefficient", "seed", "outcome")
    rows = [
        row
        for rig in rigs
        for g in rig.grips
        for row in trace_rows((rig.finger, g.samples, g.friction, g.seed, g.ended), g.episode.trace)
    ]
    context = {"rigs": rigs, "samples": samples, "noise": noise_of(samples)}
    return paper_figure(figure, "fig12", (*columns, *_TRACE_COLUMNS), rows, **context)


def _draw_measured(axes: Axes, grips: Sequence[Measured], friction: float) -> None:
    weight = grips[0].episode.trace.weight_per_finger_N
    furthest = max(float(each.episode.trace.normal_force.max(initial=0.0)) for each in grips)
    reach = 1.08 * max(weight / friction, furthest)
    _draw_limits(axes, weight, friction, reach)
    for each, (colour, dashes, _) in zip(grips, style.SERIES, strict=False):
        trace = each.episode.trace
        axes.plot(*trace.forces, color=colour, ls=dashes, lw=1.3, label=f"seed {each.seed}")
        mark_holds(axes, trace)
        if each.ended == "slipped":
            mark_slip(axes, trace)
    _mark_target(axes, weight, friction)
