"""Figure 8 of the paper, and what it rests on: plates feel what rubber would shear."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.report.figures_paper import PaperFigure, paper_figure, shared_legend
from fingerdesign.report.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    SERIES,
    VERMILION,
    canvas,
    small_multiples,
    spread,
    whole_numbers,
)
from fingerdesign.results import STICK

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fingerdesign.results import ContactHistory, SlipStudy
    from fingerdesign.study.paper_likeness import Likeness


_PANELS = 4  # steps of the comparison of plates and rubber that are drawn


def likeness_figure(alike: Likeness) -> PaperFigure:
    """Plates' normal strain beside the shear strain of the finger without plates."""
    slope = alike.overall_slope
    chosen = spread(len(alike.shear), _PANELS)
    figure = canvas(7.2, 4.6)
    panels = small_multiples(figure, len(chosen) + 1 + (len(chosen) + 1) % 2, 3)
    for axes, step in zip(panels, chosen, strict=False):
        axes.plot(
            alike.x, alike.membrane[step], color=BLUE, marker="o", ms=3, label="plates, both faces"
        )
        axes.plot(
            alike.x,
            slope * alike.shear[step],
            color=VERMILION,
            ls=(0, (6, 2)),
            marker="s",
            ms=3,
            label="rubber's shear strain, scaled",
        )
        axes.axhline(0.0, color=MUTED, lw=0.8)
        axes.set_title(f"step {step + 1}: r = {alike.correlation[step]:.2f}")
        axes.set_xlabel("x (mm)")
    panels[0].set_ylabel("microstrain")
    steps = np.arange(1, len(alike.correlation) + 1)
    last = panels[len(chosen)]
    for values, name, (colour, dashes, marker) in (
        (alike.correlation, "both faces", SERIES[0]),
        (alike.change_correlation, "their changes", SERIES[2]),
        (alike.upper_correlation, "upper face alone", SERIES[3]),
    ):
        last.plot(steps, values, color=colour, ls=dashes, marker=marker, ms=3.5, label=name)
    last.set_ylim(-1.08, 1.08)
    last.set(xlabel="step", title="correlation")
    last.axhline(0.0, color=MUTED, lw=0.8)
    last.xaxis.set_major_locator(whole_numbers(8))
    last.legend(loc="center right", fontsize=7, bbox_to_anchor=(1.0, 0.66))
    for spare in panels[len(chosen) + 1 :]:
        spare.plot(
            1e-3 * alike.shear.ravel(),
            alike.membrane.ravel(),
            ls="none",
            marker="o",
            ms=2.5,
            color=GREEN,
        )
        reach = np.array([alike.shear.min(), alike.shear.max()])
        spare.plot(1e-3 * reach, slope * reach, color=INK, lw=1.0)
        spare.set(xlabel="shear of rubber (1e-3)", ylabel="plates (microstrain)")
        spare.set_title(f"all: r = {alike.overall_correlation:.2f}")
    shared_legend(panels[:1], 3)
    rows = [
        (
            step + 1,
            gage,
            alike.x[gage],
            alike.membrane[step, gage],
            alike.upper[step, gage],
            alike.shear[step, gage],
        )
        for step in range(len(alike.shear))
        for gage in range(len(alike.x))
    ]
    return paper_figure(
        figure,
        "likeness",
        "Plates' normal strain and a homogeneous finger's shear strain",
        "At the gages' places and at equal motion. The rubber's shear strain is scaled by one "
        f"number for all steps, {slope:.2g}; the strain of rubber along 45 degrees would be 0.5 of "
        "it. A gage on one face feels the plate bend, and is not like it at all.",
        f"Correlation over the gages from {alike.correlation.min():.2f} to "
        f"{alike.correlation.max():.2f} at the steps; of one face alone from "
        f"{alike.upper_correlation.min():.2f} to {alike.upper_correlation.max():.2f}.",
        (
            *("step", "gage", "x_mm", "plate_membrane_microstrain"),
            *("plate_upper_face_microstrain", "rubber_shear_microstrain"),
        ),
        rows,
    )


def responses_figure(
    studies: Sequence[SlipStudy], friction: float, contact: ContactHistory
) -> PaperFigure:
    """Fig. 8: change of strain per change of F_t, gage by gage and step by step.

    contact: of the same steps at ``friction``, for where the surface sticks.
    """
    study = next(s for s in studies if s.friction_coefficient == friction)
    count = len(study.stick_ratio)
    figure = canvas(7.2, 0.8 + 1.85 * -(-count // 4))
    panels = small_multiples(figure, count, 4, sharex=True, sharey=True)
    x = study.gage_x_mm
    fine = np.linspace(x[0], x[-1], 12 * (len(x) - 1) + 1)
    for step, axes in enumerate(panels):
        values = study.response[step]
        axes.plot(x, values, color=BLUE, marker="o", ms=2.8, label="this finger")
        axes.axhline(study.threshold, color=VERMILION, ls=(0, (5, 2)), lw=1.1, label="threshold")
        height = np.interp(fine, x, np.nan_to_num(values))
        over = height > study.threshold
        axes.fill_between(fine, study.threshold, height, where=over, color=BLUE, alpha=0.25, lw=0)
        sticking = contact.points[contact.status[step] == STICK, 0]
        ends = [sticking.min(), sticking.max()] if len(sticking) else [np.nan, np.nan]
        axes.plot(ends, [0.0, 0.0], color=GREEN, lw=4, label="here the surface sticks")
        axes.set_title(
            f"step {step + 1}: A {study.gage_area_mm[step]:.1f}, "
            f"stick {study.stick_length_mm[step]:.1f}",
            fontsize=8,
            fontweight="normal",
        )
    top = float(np.nanmax(study.response)) if np.isfinite(study.response).any() else 1.0
    panels[0].set_ylim(-0.04 * top, 1.1 * max(top, study.threshold))
    for axes in panels[-4:]:
        axes.set_xlabel("x (mm)")
    for axes in panels[::4]:
        axes.set_ylabel("microstrain/N")
    shared_legend(panels[:1], 3)
    rows = [
        (
            each.friction_coefficient,
            step + 1,
            gage,
            x[gage],
            each.response[step, gage],
            each.response_raw[step, gage],
            each.threshold,
            each.gage_area_mm[step],
            each.stick_length_mm[step],
            each.stick_ratio[step],
        )
        for each in studies
        for step in range(len(each.stick_ratio))
        for gage in range(len(x))
    ]
    areas = ", ".join(f"{area:.1f}" for area in study.gage_area_mm)
    sticks = ", ".join(f"{length:.1f}" for length in study.stick_length_mm)
    return paper_figure(
        figure,
        "fig08",
        f"Fig. 8: change of strain per tangential force, μ = {friction:g}",
        "Where the curve is over the threshold (shaded) is the area A that the paper's controller "
        "goes by; lengths in mm. The normal force's part is taken out. All friction coefficients "
        "are in the data file.",
        f"Gage area by step: {areas} mm; true stick length: {sticks} mm.",
        (
            *("friction_coefficient", "step", "gage", "x_mm", "response_microstrain_per_N"),
            *("response_raw_microstrain_per_N", "threshold_microstrain_per_N", "gage_area_mm"),
            *("stick_length_mm", "stick_ratio"),
        ),
        rows,
    )
