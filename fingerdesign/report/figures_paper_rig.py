"""Figure 12 of the paper: lifts on a rig with noise, and what noise does to them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.report.figures_paper import PaperFigure, paper_figure, shared_legend
from fingerdesign.report.figures_paper_grips import mark_holds, mark_slip, trace_rows
from fingerdesign.report.style import INK, MUTED, SERIES, canvas, small_multiples

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from fingerdesign.study.paper_rig import Measured, Rig


def measured_figure(rigs: Sequence[Rig], samples: int | None, noise: float) -> PaperFigure:
    """Fig. 12: grips on the rig at both friction coefficients, a row a finger, a line a seed."""
    frictions = sorted({each.friction for each in rigs[0].grips})
    figure = canvas(7.2, 0.8 + 2.6 * len(rigs))
    panels = small_multiples(figure, len(rigs) * len(frictions), len(frictions), sharey=True)
    chosen = [(rig, friction) for rig in rigs for friction in frictions]
    for axes, (rig, friction) in zip(panels, chosen, strict=True):
        _draw_measured(axes, rig.at(samples, friction), friction)
        axes.set_title(f"{rig.finger}, μ = {friction:g}")
    for axes in panels[-len(frictions) :]:
        axes.set_xlabel("normal force F_n (N)")
    for axes in panels[:: len(frictions)]:
        axes.set_ylabel("F_t (N)")
    shared_legend(panels, 4)
    pause = "no noise" if samples is None else f"each step the mean of {samples:,} samples"
    return paper_figure(
        figure,
        "fig12",
        "Fig. 12: lifts on a rig with noise",
        f"Noise of a step's readings {noise:.2g} microstrain ({pause}): the most at which one of "
        "the fingers works, or the least tried. A line a seed; triangles: the rule sets the slope "
        "to zero; the cross: the least force. The data file holds the grips at all levels.",
        " ".join(_measured_words(rig, each) for rig in rigs for each in rig.at(samples)),
        _MEASURED_COLUMNS,
        [
            row
            for rig in rigs
            for each in rig.grips
            for row in trace_rows(_measured_head(rig, each), each.episode.trace)
        ],
    )


def _draw_measured(axes: Axes, grips: Sequence[Measured], friction: float) -> None:
    weight = grips[0].episode.trace.weight_per_finger_N
    furthest = max(float(each.episode.trace.normal_force.max(initial=0.0)) for each in grips)
    reach = 1.08 * max(weight / friction, furthest)
    axes.plot([0, reach], [0, friction * reach], color=INK, ls=":", lw=1.2, label="F_t = μ F_n")
    axes.axhline(weight, color=MUTED, ls="-.", lw=1.0, label="mg/2")
    for each, (colour, dashes, _) in zip(grips, SERIES, strict=False):
        trace = each.episode.trace
        axes.plot(
            trace.normal_force,
            trace.tangential_force,
            color=colour,
            ls=dashes,
            lw=1.3,
            label=f"seed {each.seed}",
        )
        mark_holds(axes, trace)
        if each.outcome == "slipped":
            mark_slip(axes, trace)
    axes.plot([weight / friction], [weight], color=INK, marker="x", ms=8, mew=1.8, ls="none")
    axes.set_xlim(0.0, reach)
    axes.set_ylim(0.0, 1.35 * weight)


_MEASURED_COLUMNS = (
    *("finger", "samples_a_step", "friction_coefficient", "seed", "outcome", "step"),
    *("normal_force_N", "tangential_force_N", "friction_limit_N", "stick_ratio", "gage_area_mm"),
    "hold",
)


def noise_figure(rigs: Sequence[Rig], sample_noise: float) -> PaperFigure:
    """Fig. 12's ground: the force at the lift over the noise, a panel a finger."""
    figure = canvas(7.2, 3.5)
    panels = small_multiples(figure, len(rigs), max(len(rigs), 2), sharey=True)
    frictions = sorted({each.friction for each in rigs[0].grips})
    for axes, rig in zip(panels, rigs, strict=True):
        levels = rig.levels
        for k, (friction, (colour, dashes, marker)) in enumerate(
            zip(frictions, SERIES, strict=False)
        ):
            weight = rig.at(None, friction)[0].episode.trace.weight_per_finger_N
            axes.axhline(weight / friction, color=colour, ls=":", lw=1.1)
            middles = []
            for place, samples in enumerate(levels):
                grips = rig.at(samples, friction)
                good = [_force(each) for each in grips if each.outcome == "lifted"]
                bad = [_force(each) for each in grips if each.outcome == "slipped"]
                at = place + 0.12 * (k - 0.5)
                axes.plot([at] * len(good), good, color=colour, ls="none", marker=marker, ms=4.5)
                axes.plot(
                    [at] * len(bad),
                    bad,
                    color=INK,
                    ls="none",
                    marker="X",
                    ms=7,
                    label="slipped",
                )
                middles.append(float(np.median(good)) if good else np.nan)
            axes.plot(
                np.arange(len(levels)) + 0.12 * (k - 0.5),
                middles,
                color=colour,
                ls=dashes,
                marker=marker,
                ms=4.5,
                label=f"μ = {friction:g}",
            )
        axes.set_xticks(
            range(len(levels)),
            ["none" if s is None else f"{sample_noise / s**0.5:.2g}\n({s:,})" for s in levels],
        )
        axes.set_title(rig.finger)
        axes.set_xlabel("noise, microstrain (samples a step)")
    panels[0].set_ylabel("F_n at the lift (N)")
    panels[0].set_ylim(bottom=0.0)
    shared_legend(panels, 3)
    words = [
        f"{rig.finger}, {'no noise' if s is None else f'{s:,} samples a step'}: F_n as "
        f"{rig.force_ratio(s):.1f} to 1, {sum(g.outcome == 'slipped' for g in rig.at(s))} of "
        f"{len(rig.at(s))} slip."
        for rig in rigs
        for s in rig.levels
    ]
    rows = [
        (
            rig.finger,
            each.samples,
            0.0 if each.samples is None else sample_noise / each.samples**0.5,
            each.friction,
            each.seed,
            each.outcome,
            _force(each),
            each.episode.result.safety_margin,
            each.episode.result.holds,
            each.episode.result.steps,
        )
        for rig in rigs
        for each in rig.grips
    ]
    return paper_figure(
        figure,
        "fig12_noise",
        "Fig. 12's ground: what noise does to the force at the lift",
        "Dotted: the least force at each friction coefficient. A rule that feels the friction "
        "lifts the slippery object with about twice the force; one that is blind lifts both alike, "
        "safely or not. The number of samples is the mean of how many a step's readings are.",
        " ".join(words),
        (
            *("finger", "samples_a_step", "noise_microstrain", "friction_coefficient", "seed"),
            *("outcome", "final_normal_force_N", "safety_margin", "holds", "steps"),
        ),
        rows,
    )


def _force(each: Measured) -> float:
    return each.episode.result.final_normal_force_N


def _measured_head(rig: Rig, each: Measured) -> tuple[object, ...]:
    return (rig.finger, each.samples, each.friction, each.seed, each.outcome)


def _measured_words(rig: Rig, each: Measured) -> str:
    return f"{rig.finger}, μ = {each.friction:g}, seed {each.seed}: {each.episode.reason}."
