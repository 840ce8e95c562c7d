"""Figure 8 of the paper, and what it rests on: plates feel what rubber would shear."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from fingerdesign.analysis.page.gage import shade_over
from fingerdesign.records.arrays import STICK
from fingerdesign.report import style
from fingerdesign_bench.paper.case import PATHS
from fingerdesign_bench.paper.figures import PaperFigure, paper_figure, shades

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fingerdesign.records.arrays import ContactHistory, SlipStudy
    from fingerdesign_bench.paper.places import Likeness, Verdicts
    from fingerdesign_bench.paper.relation import Relation


# What the gages tell of sticking: one relation for every friction? each of the surface near it?

_PATH_TITLES = {path: words[0].upper() + words[1:] for path, words in PATHS.items()}


def relation_figure(relations: Sequence[Relation]) -> PaperFigure:
    """Fig. 8's claim: gage area against stick length at every friction, a panel a path."""
    figure = style.canvas(7.2, 3.5)
    labels = {"across": "gage area A (mm)", "up": "stick length (mm)"}
    panels = style.small_multiples(figure, len(relations), len(relations), **labels, sharey=True)
    colours = shades(len(relations[0].frictions))
    marks = "osD^v<>Ph"
    for axes, each in zip(panels, relations, strict=True):
        for k, (friction, colour) in enumerate(zip(each.frictions, colours, strict=True)):
            own = each.friction == friction
            look = style.points(colour, marks[k % len(marks)], 3.2, f"μ = {friction:g}")
            axes.plot(each.area[own], each.stick[own], **look)
        axes.set_title(
            f"{_PATH_TITLES[each.path]}\nrank correlation {each.pooled_rank:.3f},\n"
            f"error {100 * each.other_share:.1f} %",
            fontsize=8.5,
        )
    panels[0].set_ylim(bottom=-0.1)
    style.shared_legend(panels[:1], 5)
    rows = [
        (each.path, each.friction[k], each.area[k], each.stick[k])
        for each in relations
        for k in range(len(each.area))
    ]
    columns = ("path", "friction_coefficient", "gage_area_mm", "stick_length_mm")
    said = {"relations": relations, "titles": _PATH_TITLES}
    return paper_figure(figure, "fig08_relation", columns, rows, **said)


def _draw_right_answers(depth: Axes, roc: Axes, places: Sequence[Verdicts]) -> None:
    """Share of right answers over depth, and over all thresholds, of rubber and of the plates."""
    rubber = [v for v in places if v.reading.startswith("rubber,")]
    plates = places[0].reading
    for touching, name in enumerate(("all gages", "under the contact")):
        colour, dashes, _ = style.SERIES[touching]
        own = sorted((v for v in rubber if v.touching == touching), key=lambda v: v.depth_mm)
        right = [100 * v.right for v in own]
        style.series(depth, [v.depth_mm for v in own], right, touching, f"rubber, {name}")
        gage = next(v for v in places if v.reading == plates and v.touching == touching)
        look = style.points(colour, "*", 12, f"plates, {name}")
        depth.plot([gage.depth_mm], [100 * gage.right], **look)
        depth.axhline(100 * gage.constant, color=colour, lw=0.9, ls=(0, (1, 2)))
        roc.plot(*gage.roc, color=colour, ls=dashes, label=f"plates, {name}: {gage.auc:.2f}")


def places_figure(places: Sequence[Verdicts], x: np.ndarray) -> PaperFigure:
    """2.3: does each gage tell whether the surface near it sticks?"""
    figure = style.canvas(7.2, 4.1)
    depth, roc, by_gage = figure.subplots(1, 3, width_ratios=(5, 4, 4))
    rubber = [v for v in places if v.reading.startswith("rubber,")]
    plates = places[0].reading
    _draw_right_answers(depth, roc, places)
    depth.set(xlabel="depth under the surface (mm)", ylabel="right (%)", title="Right answers")
    depth.set_ylim(45, 101)
    skin = min(v.depth_mm for v in rubber)
    shallow = next(v for v in rubber if v.depth_mm == skin and v.touching)
    felt = f"rubber {skin:g} mm, contact: {shallow.auc:.2f}"
    roc.plot(*shallow.roc, color=style.GREEN, ls=(0, (1.5, 1.5)), label=felt)
    roc.plot([0, 1], [0, 1], color=style.MUTED, lw=0.8)
    roc.set(xlabel="slip called stick", ylabel="stick called stick", title="ROC, and area under it")
    deep = next(v for v in places if v.reading == plates and v.touching)
    for verdict, name, colour, marker in (
        (deep, "plates", style.VERMILION, "s"),
        (shallow, f"rubber, {skin:g} mm", style.GREEN, "^"),
    ):
        right, label = 100 * verdict.by_place, f"{name}, by gage"
        by_gage.plot(x, right, color=colour, marker=marker, ms=4, label=label)
    by_gage.set(xlabel="x of the gage (mm)", ylabel="right (%)", title="Under the contact")
    by_gage.set_ylim(-3, 103)
    for axes in (depth, roc, by_gage):
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), fontsize=7)
    rows = [
        (
            *(v.reading, v.depth_mm, "contact" if v.touching else "all", v.threshold, v.right),
            *(v.constant, v.sticking, v.slipping, v.auc, *v.by_place.tolist()),
        )
        for v in places
    ]
    columns = (
        *("reading", "depth_mm", "asked_of", "threshold", "right", "constant_answer_right"),
        *("right_where_sticking", "right_where_not", "area_under_roc"),
        *(f"right_gage_{k}" for k in range(len(x))),
    )
    return paper_figure(figure, "each_gage", columns, rows, places=places)


_PANELS = 4  # steps of the comparison of plates and rubber that are drawn


def _draw_all_steps(spare: Axes, alike: Likeness) -> None:
    """Plates over rubber at all gages and steps, with the one slope."""
    slope = alike.overall_slope
    spare.plot(
        1e-3 * alike.shear.ravel(), alike.membrane.ravel(), **style.points(style.GREEN, "o", 2.5)
    )
    reach = np.array([alike.shear.min(), alike.shear.max()])
    spare.plot(1e-3 * reach, slope * reach, color=style.INK, lw=1.0)
    spare.set(xlabel="shear of rubber (1e-3)", ylabel="plates (microstrain)")
    spare.set_title(f"all: r = {alike.overall_correlation:.2f}")


def likeness_figure(alike: Likeness) -> PaperFigure:
    """Plates' normal strain beside the shear strain of the finger without plates."""
    slope = alike.overall_slope
    chosen = style.evenly_spaced(len(alike.shear), _PANELS)
    figure = style.canvas(7.2, 4.6)
    panels = style.small_multiples(figure, len(chosen) + 1 + (len(chosen) + 1) % 2, 3)
    for axes, step in zip(panels, chosen, strict=False):
        plates, rubber = "plates, both faces", "rubber's shear strain, scaled"
        axes.plot(alike.x, alike.membrane[step], color=style.BLUE, marker="o", ms=3, label=plates)
        look = style.points(style.VERMILION, "s", 3, rubber) | {"ls": (0, (6, 2))}
        axes.plot(alike.x, slope * alike.shear[step], **look)
        axes.axhline(0.0, color=style.MUTED, lw=0.8)
        axes.set_title(f"step {step + 1}: r = {alike.correlation[step]:.2f}")
        axes.set_xlabel("x (mm)")
    panels[0].set_ylabel("microstrain")
    steps = np.arange(1, len(alike.correlation) + 1)
    last = panels[len(chosen)]
    for values, name, kind in (
        (alike.correlation, "both faces", 0),
        (alike.change_correlation, "their changes", 2),
        (alike.upper_correlation, "upper face alone", 3),
    ):
        style.series(last, steps, values, kind, name, ms=3.5)
    last.set_ylim(-1.08, 1.08)
    last.set(xlabel="step", title="correlation")
    last.axhline(0.0, color=style.MUTED, lw=0.8)
    last.xaxis.set_major_locator(style.whole_numbers(8))
    last.legend(loc="center right", fontsize=7, bbox_to_anchor=(1.0, 0.66))
    for spare in panels[len(chosen) + 1 :]:
        _draw_all_steps(spare, alike)
    style.shared_legend(panels[:1], 3)
    fields = (alike.membrane, alike.upper, alike.shear)
    rows = [
        (step + 1, gage, alike.x[gage], *(field[step, gage] for field in fields))
        for step, gage in np.ndindex(*alike.shear.shape)
    ]
    columns = (
        *("step", "gage", "x_mm", "plate_membrane_microstrain"),
        *("plate_upper_face_microstrain", "rubber_shear_microstrain"),
    )
    return paper_figure(figure, "likeness", columns, rows, alike=alike, slope=slope)


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
    said = {"study": study, "friction": friction}
    return paper_figure(figure, "fig08", columns, _response_rows(studies), **said)
