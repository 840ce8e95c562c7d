"""What the gages tell of sticking: one relation for every friction? each of the surface near it?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.report.figures_paper import PaperFigure, paper_figure, shades, shared_legend
from fingerdesign.report.style import (
    GREEN,
    MUTED,
    SERIES,
    VERMILION,
    canvas,
    small_multiples,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fingerdesign.study.paper_places import Verdicts
    from fingerdesign.study.paper_relation import Relation


_PATH_TITLES = {
    "similar": "Shear in proportion to μ",
    "same": "One motion for all",
    "growing": "Approach growing to the end",
}


def relation_figure(relations: Sequence[Relation]) -> PaperFigure:
    """Fig. 8's claim: gage area against stick length at every friction, a panel a path."""
    figure = canvas(7.2, 3.5)
    panels = small_multiples(figure, len(relations), len(relations), sharey=True)
    colours = shades(len(relations[0].frictions))
    marks = "osD^v<>Ph"
    for axes, each in zip(panels, relations, strict=True):
        for k, (friction, colour) in enumerate(zip(each.frictions, colours, strict=True)):
            own = each.friction == friction
            axes.plot(
                each.area[own],
                each.stick[own],
                ls="none",
                marker=marks[k % len(marks)],
                ms=3.2,
                color=colour,
                label=f"μ = {friction:g}",
            )
        axes.set_xlabel("gage area A (mm)")
        axes.set_title(
            f"{_PATH_TITLES[each.path]}\nrank correlation {each.pooled_rank:.3f},\n"
            f"error {100 * each.other_share:.1f} %",
            fontsize=8.5,
        )
    panels[0].set_ylabel("stick length (mm)")
    panels[0].set_ylim(bottom=-0.1)
    shared_legend(panels[:1], 5)
    rows = [
        (each.path, each.friction[k], each.area[k], each.stick[k])
        for each in relations
        for k in range(len(each.area))
    ]
    return paper_figure(
        figure,
        "fig08_relation",
        "Fig. 8's claim: one relation for every friction coefficient?",
        "A point an increment, of rows cut into finer ones. If the relation did not depend on the "
        "friction, all points of a panel would lie on one curve. Error: of the stick length told "
        "from A by the relation of the other friction coefficients.",
        " ".join(
            f"{_PATH_TITLES[each.path]}: rank correlation of all {each.pooled_rank:.3f}, error of "
            f"the stick length {100 * each.other_share:.1f} % of {each.largest_mm:.2f} mm."
            for each in relations
        ),
        ("path", "friction_coefficient", "gage_area_mm", "stick_length_mm"),
        rows,
    )


def places_figure(places: Sequence[Verdicts], x: np.ndarray) -> PaperFigure:
    """2.3: does each gage tell whether the surface near it sticks?"""
    figure = canvas(7.2, 4.1)
    depth, roc, by_gage = figure.subplots(1, 3, width_ratios=(5, 4, 4))
    rubber = [v for v in places if v.reading.startswith("rubber,")]
    plates = places[0].reading
    for touching, name, (colour, dashes, marker) in (
        (False, "all gages", SERIES[0]),
        (True, "under the contact", SERIES[1]),
    ):
        own = sorted((v for v in rubber if v.touching == touching), key=lambda v: v.depth_mm)
        depths = [v.depth_mm for v in own]
        right = [100 * v.right for v in own]
        depth.plot(depths, right, color=colour, ls=dashes, marker=marker, label=f"rubber, {name}")
        gage = next(v for v in places if v.reading == plates and v.touching == touching)
        depth.plot(
            [gage.depth_mm],
            [100 * gage.right],
            color=colour,
            marker="*",
            ms=12,
            ls="none",
            label=f"plates, {name}",
        )
        depth.axhline(100 * gage.constant, color=colour, lw=0.9, ls=(0, (1, 2)))
        roc.plot(*gage.roc, color=colour, ls=dashes, label=f"plates, {name}: {gage.auc:.2f}")
    depth.set(xlabel="depth under the surface (mm)", ylabel="right (%)", title="Right answers")
    depth.set_ylim(45, 101)
    skin = min(v.depth_mm for v in rubber)
    shallow = next(v for v in rubber if v.depth_mm == skin and v.touching)
    felt = f"rubber {skin:g} mm, contact: {shallow.auc:.2f}"
    roc.plot(*shallow.roc, color=GREEN, ls=(0, (1.5, 1.5)), label=felt)
    roc.plot([0, 1], [0, 1], color=MUTED, lw=0.8)
    roc.set(xlabel="slip called stick", ylabel="stick called stick", title="ROC, and area under it")
    deep = next(v for v in places if v.reading == plates and v.touching)
    for verdict, name, colour, marker in (
        (deep, "plates", VERMILION, "s"),
        (shallow, f"rubber, {skin:g} mm", GREEN, "^"),
    ):
        by_gage.plot(
            x,
            100 * verdict.by_place,
            color=colour,
            marker=marker,
            ms=4,
            label=f"{name}, by gage",
        )
    by_gage.set(xlabel="x of the gage (mm)", ylabel="right (%)", title="Under the contact")
    by_gage.set_ylim(-3, 103)
    for axes in (depth, roc, by_gage):
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), fontsize=7)
    rows = []
    for each in places:
        head: list[object] = [each.reading, each.depth_mm]
        head += ["contact" if each.touching else "all", each.threshold, each.right]
        head += [each.constant, each.sticking, each.slipping, each.auc]
        rows.append([*head, *each.by_place.tolist()])
    return paper_figure(
        figure,
        "each_gage",
        "Does each gage tell whether the surface near it sticks?",
        "Left: share of right answers over the depth at which strain is felt; dotted, what always "
        "giving the commoner answer gets. The threshold was chosen at other friction coefficients. "
        "All gages: does the surface above stick, or not (slip or open)? Under the contact: stick "
        "or slip? Middle: over all thresholds, with the area under each curve (0.5: a guess). "
        "Right: gage by gage.",
        " ".join(
            f"{each.reading}, {'under the contact' if each.touching else 'all'}: right in "
            f"{100 * each.right:.0f} % (constant answer {100 * each.constant:.0f} %)."
            for each in places
        ),
        (
            *("reading", "depth_mm", "asked_of", "threshold", "right", "constant_answer_right"),
            *("right_where_sticking", "right_where_not", "area_under_roc"),
            *(f"right_gage_{k}" for k in range(len(x))),
        ),
        rows,
    )
