"""Figures 3, 6, 7 and 8 of the paper: rectangles, eight steps, stick map, gages' responses."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fingerdesign.analysis.page.contact import (
    STATUS_LOOK,
    STATUS_NAMES,
    status_bars,
    status_legend,
    touched_reach,
)
from fingerdesign.analysis.page.gage import shade_over
from fingerdesign.records.arrays import SLIP, STICK, ContactHistory, SlipStudy
from fingerdesign.records.result import IncrementResult
from fingerdesign.report import style
from fingerdesign.report.style import Axes
from fingerdesign_bench.paper.figures import PaperFigure, paper_figure
from fingerdesign_bench.paper.rectangles import Rectangles

_LOOK = {STATUS_NAMES[status]: look for status, look in STATUS_LOOK.items()}
_DRAWN_TURN = 14.0  # degrees: how far the most turned rectangle of a panel is drawn


def _rectangle_rows(turned: Rectangles) -> tuple[list[str], list[list[object]]]:
    """Names and rows of the data file: each rectangle's corners and angles in every state."""
    corner_names = ("lower_left", "lower_right", "upper_right", "upper_left")
    columns = ["rectangle", "x_mm", "surface_above"]
    columns += [f"angle_{name}_deg" for name in ("pressed", "since_pressed", "short_time_more")] + [
        "angle_change_per_force_deg_per_N"
    ]
    for state in ("undeformed", "pressed", "sheared", "changed"):
        columns += [f"{state}_{corner}_{axis}_mm" for corner in corner_names for axis in "xy"]
    rows: list[list[object]] = []
    for k, status in enumerate(turned.status):
        row: list[object] = [k + 1, turned.corners[k, :, 0].mean(), status]
        row += [turned.angle[state][k] for state in ("pressed", "added", "change")]
        row.append(turned.change_per_N[k])
        row += turned.corners[k].ravel().tolist()
        for state in ("pressed", "sheared", "changed"):
            row += (turned.corners[k] + turned.moved[state][k]).ravel().tolist()
        rows.append(row)
    return columns, rows


def rectangles_figure(turned: Rectangles) -> PaperFigure:
    """Fig. 3: pressed, sheared, and what a short time more changes; shear angles below."""
    figure = style.canvas(7.2, 4.6)
    grid = figure.subplots(3, 2, width_ratios=(9, 4), sharex="col")
    zero = np.zeros_like(turned.moved["pressed"])
    panels = (
        ("(a) pressed", "pressed", zero),
        ("(b) sheared, since (a)", "added", turned.moved["pressed"]),
        ("(c) a short time more, since (b)", "change", turned.moved["sheared"]),
    )
    ends = {"pressed": "pressed", "added": "sheared", "change": "changed"}
    number = np.arange(1, len(turned.status) + 1)
    for (drawn, bars), (title, state, before) in zip(grid, panels, strict=True):
        moved = turned.moved[ends[state]] - before
        pressed_only = state == "pressed"
        most = float(np.abs(turned.angle[state]).max())
        scale = _DRAWN_TURN / max(most, 1e-9)
        if pressed_only:  # on the scale of (b), so that "nearly square" is seen as such
            scale = _DRAWN_TURN / max(float(np.abs(turned.angle["added"]).max()), 1e-9)
        _draw_rectangles(drawn, turned, moved, scale, pressed_only)
        drawn.set_title(f"{title}; drawn {scale:.{0 if scale >= 10.0 else 1}f} times")
        colours = [style.MUTED if pressed_only else _LOOK[s][0] for s in turned.status]
        hatches = ["" if pressed_only else _LOOK[s][1] for s in turned.status]
        look: dict[str, Any] = {"color": colours, "hatch": hatches, "edgecolor": style.PAPER}
        bars.bar(number, turned.angle[state], width=0.78, linewidth=0, **look)
        bars.axhline(0.0, color=style.MUTED, lw=0.8)
        bars.set_ylabel("turned (degrees)")
        bars.xaxis.set_major_locator(style.whole_numbers(6))
        bars.grid(visible=False, axis="x")
    grid[-1][1].set_xlabel("rectangle")
    grid[-1][0].set_xlabel("x (mm)")
    status_legend(grid[1][0], (STICK, SLIP), below=True)
    means = {s: [turned.mean(k, s) for k in ("added", "change")] for s in ("stick", "slip")}
    return paper_figure(figure, "fig03", *_rectangle_rows(turned), turned=turned, means=means)


def _draw_rectangles(
    axes: Axes, turned: Rectangles, moved: np.ndarray, scale: float, plain: bool
) -> None:
    from matplotlib.patches import Polygon

    # What all rectangles share is no turning: without it the magnified ones stay in place.
    middle = moved.mean(axis=1, keepdims=True)
    for corners, step, mean, status in zip(
        turned.corners, moved, middle, turned.status, strict=True
    ):
        colour, hatch = (style.OPEN_COLOUR, "") if plain else _LOOK[status]
        axes.add_patch(Polygon(corners, closed=True, fill=False, ec=style.GRID, lw=0.8))
        drawn = corners + scale * (step - mean)
        look: dict[str, Any] = {"facecolor": colour, "edgecolor": style.INK, "hatch": hatch}
        axes.add_patch(Polygon(drawn, closed=True, alpha=0.75, lw=0.9, **look))
    low, high = turned.corners.reshape(-1, 2).min(0), turned.corners.reshape(-1, 2).max(0)
    room = 0.45 * (high[1] - low[1])
    axes.set_xlim(low[0] - room, high[0] + room)
    axes.set_ylim(low[1] - room, high[1] + room)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)


def steps_figure(increments: Sequence[IncrementResult]) -> PaperFigure:
    """Fig. 6: normal and tangential force of the eight steps."""
    step = np.arange(1, len(increments) + 1)
    normal = np.array([row.normal_force_N for row in increments])
    tangential = np.array([row.tangential_force_N for row in increments])
    figure = style.canvas(7.2, 3.0)
    over, path = figure.subplots(1, 2)
    style.series(over, step, normal, 0, "normal force F_n")
    style.series(over, step, tangential, 1, "tangential force F_t")
    over.set(xlabel="time step", ylabel="force on the finger (N)", title="Forces by step")
    over.set_ylim(bottom=0.0)
    over.xaxis.set_major_locator(style.whole_numbers(len(step)))
    over.legend(loc="upper left", bbox_to_anchor=(0.3, 0.72))
    path.plot(normal, tangential, color=style.INK, marker="o", ms=4)
    for k in range(len(step)):
        place = (normal[k], tangential[k])
        path.annotate(str(k + 1), place, (-10, 1), textcoords="offset points")
    path.set(xlabel="F_n (N)", ylabel="F_t (N)", title="The same in the plane of Fig. 2")
    path.set_xlim(0.0, 1.1 * float(normal.max()))
    path.set_ylim(0.0, 1.1 * float(tangential.max()))
    keys = ("approach_mm", "shear_mm", "normal_force_N", "tangential_force_N")
    rows = [(k, *(getattr(r, key) for key in keys)) for k, r in enumerate(increments, 1)]
    forces = {"normal": normal, "tangential": tangential}
    return paper_figure(figure, "fig06", ("step", *keys), rows, **forces)


def stick_map_figure(contact: ContactHistory, increments: Sequence[IncrementResult]) -> PaperFigure:
    """Fig. 7: what each node of the surface does at each step."""
    line = contact.mid_line()
    x = contact.points[line, 0]
    figure = style.canvas(7.2, 3.6)
    axes = figure.subplots()
    status_bars(axes, contact, upright=True)
    axes.set_ylim(*touched_reach(contact, line))
    axes.set_xlim(0.4, len(contact.status) + 0.6)
    axes.set(xlabel="time step", ylabel="x on the surface (mm)")
    axes.grid(visible=False, axis="x")
    axes.xaxis.set_major_locator(style.whole_numbers(len(contact.status)))
    status_legend(axes)
    lengths = [r.contact_width_mm * (r.stick_ratio or 0.0) for r in increments]
    names = [STATUS_NAMES[s] for s in range(3)]
    rows = [
        (step + 1, node + 1, x[node], names[int(status[line[node]])])
        for step, status in enumerate(contact.status)
        for node in range(len(line))
    ]
    columns = ("step", "node", "x_mm", "status")
    return paper_figure(figure, "fig07", columns, rows, nodes=len(line), lengths=lengths)


def _response_rows(studies: Sequence[SlipStudy]) -> list[tuple[object, ...]]:
    rows: list[tuple[object, ...]] = []
    for each in studies:
        facts = (each.gage_area_mm, each.stick_length_mm, each.stick_ratio)
        for step, gage in np.ndindex(*each.response.shape):
            place = (each.friction_coefficient, step + 1, gage, studies[0].gage_x_mm[gage])
            read = (each.response[step, gage], each.response_raw[step, gage], each.threshold)
            rows.append((*place, *read, *(fact[step] for fact in facts)))
    return rows


def responses_figure(
    studies: Sequence[SlipStudy], friction: float, contact: ContactHistory
) -> PaperFigure:
    """Fig. 8: change of strain per change of F_t, gage by gage and step by step.

    contact: of the same steps at ``friction``, for where the surface sticks.
    """
    study = next(s for s in studies if s.friction_coefficient == friction)
    count = len(study.stick_ratio)
    figure = style.canvas(7.2, 0.8 + 1.85 * -(-count // 4))
    labels = {"across": "x (mm)", "up": "microstrain/N"}
    panels = style.small_multiples(figure, count, 4, **labels, sharex=True, sharey=True)
    x = study.gage_x_mm
    for step, axes in enumerate(panels):
        values = study.response[step]
        axes.plot(x, values, color=style.BLUE, marker="o", ms=2.8, label="this finger")
        axes.axhline(
            study.threshold, color=style.VERMILION, ls=(0, (5, 2)), lw=1.1, label="threshold"
        )
        shade_over(axes, x, np.nan_to_num(values), study.threshold, fine=12)
        sticking = contact.points[contact.status[step] == STICK, 0]
        ends = [sticking.min(), sticking.max()] if len(sticking) else [np.nan, np.nan]
        axes.plot(ends, [0.0, 0.0], color=style.GREEN, lw=4, label="here the surface sticks")
        title = f"step {step + 1}: A {study.gage_area_mm[step]:.1f}, "
        title += f"stick {study.stick_length_mm[step]:.1f}"
        axes.set_title(title, fontsize=8, fontweight="normal")
    top = float(np.nanmax(study.response)) if np.isfinite(study.response).any() else 1.0
    panels[0].set_ylim(-0.04 * top, 1.1 * max(top, study.threshold))
    style.shared_legend(panels[:1], 3)
    columns = (
        *("friction_coefficient", "step", "gage", "x_mm", "response_microstrain_per_N"),
        *("response_raw_microstrain_per_N", "threshold_microstrain_per_N", "gage_area_mm"),
        *("stick_length_mm", "stick_ratio"),
    )
    context = {"study": study, "friction": friction}
    return paper_figure(figure, "fig08", columns, _response_rows(studies), **context)
