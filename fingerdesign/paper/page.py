"""The figures of the paper, remade, and paper.html: its words beside what was measured."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.paper.figures import PaperFigure
from fingerdesign.paper.figures_contact import (
    rectangles_figure,
    steps_figure,
    stick_map_figure,
)
from fingerdesign.paper.figures_gages import (
    likeness_figure,
    places_figure,
    relation_figure,
    responses_figure,
)
from fingerdesign.paper.figures_grips import (
    lifts_figure,
    measured_figure,
    noise_figure,
    route_figure,
)
from fingerdesign.report.page import rendered
from fingerdesign.report.style import house_style

if TYPE_CHECKING:
    from fingerdesign.paper.claims import Remade
    from fingerdesign.paper.lifts import Rig


# What the remade figures of the paper share: a drawing as PNG, SVG and inline, its data as CSV.

TEMPLATES = Path(__file__).parent / "templates"


ORDER = (
    *("fig02", "fig03", "fig06", "fig07", "likeness", "fig08", "fig08_relation", "each_gage"),
    *("fig10", "fig12", "fig12_noise"),
)


def paper_figures(found: Remade, route_friction: float, sample_noise: float) -> list[PaperFigure]:
    """All figures, in :data:`ORDER`."""
    route = next(lift for lift in found.lifts if lift.friction == route_friction)
    samples = _shown(found.rigs)
    noise = 0.0 if samples is None else sample_noise / samples**0.5
    with house_style():
        made = [
            route_figure(route, found.route),
            rectangles_figure(found.rectangles),
            steps_figure(found.increments),
            stick_map_figure(found.contact, found.increments),
            likeness_figure(found.likeness),
            responses_figure(found.studies, found.friction, found.contact),
            relation_figure(found.relations),
            places_figure(found.places, found.likeness.x),
            lifts_figure(found.lifts),
            measured_figure(found.rigs, samples, noise),
            noise_figure(found.rigs, sample_noise),
        ]
    assert tuple(figure.key for figure in made) == ORDER
    return made


def paper_html(found: Remade, figures: list[PaperFigure], versions: dict[str, str]) -> str:
    """The page: verdicts first, then each figure with the paper's words about it."""
    claims = {claim.figure: claim for claim in found.claims}
    return rendered(
        TEMPLATES / "paper.html.j2",
        found=found,
        figures=[(figure, claims.get(figure.key)) for figure in figures],
        assumed=found.design.assumed,
        versions=versions,
    )


def _shown(rigs: tuple[Rig, ...]) -> int | None:
    """The fewest samples a step at which a finger lifts with noise; else the most tried."""
    working = [rig.least_samples[-1] for rig in rigs if rig.least_samples]
    noisy = [samples for samples in working if samples is not None]
    levels = rigs[0].levels
    return min(noisy) if noisy else levels[min(1, len(levels) - 1)]
