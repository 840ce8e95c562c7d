"""Figure 8 of the paper: change of strain per change of tangential force."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.analysis.page.gage import shade_over
from fingerdesign.records.arrays import STICK
from fingerdesign.report import style
from fingerdesign_bench.paper.figures import PaperFigure, paper_figure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fingerdesign.records.arrays import ContactHistory, SlipStudy


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
