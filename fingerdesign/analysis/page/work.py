"""Every figure of a report, in the order in which they are read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.page.contact import force_figure, status_figure, traction_figure
from fingerdesign.analysis.page.gage import area_figure, response_figure, strain_figure
from fingerdesign.analysis.page.grip import paths_figure, rule_figure
from fingerdesign.analysis.page.picture import region_of
from fingerdesign.analysis.page.verdict import slip_grows_with_shear
from fingerdesign.mesh.types import Mesh
from fingerdesign.records.result import Result
from fingerdesign.report.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    PAPER,
    VERMILION,
    ReportFigure,
    canvas,
    house_style,
    spread,
    to_svg,
)

# Figures of the work itself: the mesh's quality and where the time went.


def least_angles(mesh: Mesh) -> NDArray[np.float64]:
    """Each cell's least angle, degrees, (c,): of its corners in 2-D, dihedral in 3-D.

    Straight edges are assumed: curved mid-nodes change the angles by far less than a bin.
    """
    corners = mesh.points[mesh.corners]
    if mesh.dimension == 2:
        ahead = np.roll(corners, -1, axis=1) - corners
        back = np.roll(corners, 1, axis=1) - corners
        cosine = _cosine(ahead, back)
    else:
        # The facet opposite corner i has the normal grad(lambda_i); dihedral = pi - their angle.
        edges = corners[:, 1:] - corners[:, :1]
        gradients = np.linalg.inv(edges).transpose(0, 2, 1)
        gradients = np.concatenate([-gradients.sum(axis=1, keepdims=True), gradients], axis=1)
        first, second = np.triu_indices(4, k=1)
        cosine = -_cosine(gradients[:, first], gradients[:, second])
    return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1, 1))).min(axis=1))


def quality_figure(mesh: Mesh) -> ReportFigure:
    """Histogram of the cells' least angles, elastomer, plates and core apart."""
    angles = least_angles(mesh)
    what = "least angle" if mesh.dimension == 2 else "least dihedral angle"
    bins = np.arange(0.0, 75.1, 2.5)
    parts = [
        ("elastomer", mesh.regions == 0, BLUE, ""),
        ("plates", region_of(mesh, "plates"), VERMILION, "//"),
        ("core", region_of(mesh, "core"), GREEN, ""),
    ]
    parts = [part for part in parts if part[1].any()]
    figure = canvas(7.2, 2.4)
    panels = np.atleast_1d(figure.subplots(1, len(parts), sharex=True))
    for axes, (name, own, colour, hatch) in zip(panels, parts, strict=True):
        axes.hist(angles[own], bins=bins, color=colour, hatch=hatch, edgecolor=PAPER, lw=0.3)
        axes.set_title(f"{name}: {own.sum():,} cells")
        axes.axvline(angles[own].min(), color=INK, ls=":", lw=1.2)
    figure.supxlabel(f"{what} of a cell (degrees)", fontsize="medium")
    panels[0].set_ylabel("cells")
    worst = "; ".join(f"{name} {angles[own].min():.1f} degrees" for name, own, *_ in parts)
    alternative = f"Worst {what}: {worst}. Median over all cells {np.median(angles):.1f} degrees."
    return ReportFigure(
        "quality",
        "The mesh's quality",
        to_svg(figure, "quality", alternative),
        f"The {what} of each cell; the dotted line is the worst. Thin cells (a few degrees) make "
        "the strains near them unsure.",
        alternative,
    )


def time_figure(result: Result) -> ReportFigure:
    """Seconds by stage."""
    stages = {name: seconds for name, seconds in result.timings_s.items() if seconds > 0}
    figure = canvas(7.2, 0.6 + 0.27 * max(len(stages), 1))
    axes = figure.subplots()
    bars = axes.barh(list(stages), list(stages.values()), color=MUTED, height=0.6)
    axes.bar_label(bars, [f"{seconds:.1f} s" for seconds in stages.values()], padding=3)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("seconds")
    axes.margins(x=0.12)
    total = sum(stages.values())
    alternative = f"{total:.1f} s in all, without making this page: " + ", ".join(
        f"{name} {seconds:.1f} s" for name, seconds in stages.items()
    )
    return ReportFigure(
        "time",
        "Where the time went",
        to_svg(figure, "time", alternative + "."),
        f"{total:.1f} s in all, without making this page. A stage whose answer was kept shows "
        "what fetching it took.",
        alternative + ".",
    )


def _cosine(a: NDArray[np.floating], b: NDArray[np.floating]) -> NDArray[np.float64]:
    lengths = np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1)
    return np.asarray(np.sum(a * b, axis=-1) / lengths)


RESPONSES = 3  # friction coefficients whose responses are drawn gage by gage; the areas are for all
SECTIONS = {
    "contact": "The contact",
    "gages": "The gages",
    "grips": "The grips",
    "work": "The work",
}


def report_figures(analysis: Analysis) -> dict[str, list[ReportFigure]]:
    """Section of :data:`SECTIONS` -> figures; what the analysis does not hold is left out."""
    result = analysis.result
    figures: dict[str, list[ReportFigure]] = {section: [] for section in SECTIONS}
    with house_style():
        if result.increments:
            figures["contact"].append(force_figure(result))
        if analysis.contact is not None and len(analysis.contact.status):
            grows = slip_grows_with_shear(result.increments)
            figures["contact"].append(status_figure(analysis.contact, grows))
            figures["contact"].append(traction_figure(analysis.contact))
        if analysis.slip_studies:
            figures["gages"].append(area_figure(analysis.slip_studies))
            shown = spread(len(analysis.slip_studies), RESPONSES)
            figures["gages"] += [response_figure(analysis.slip_studies[i]) for i in shown]
        if result.increments and result.increments[0].gages:
            figures["gages"].append(strain_figure(result, analysis.plates))
        traces = tuple(trace for trace in analysis.grip_traces if len(trace.dx))
        if traces:
            figures["grips"] += [paths_figure(traces), rule_figure(traces)]
        if analysis.mesh is not None:
            figures["work"].append(quality_figure(analysis.mesh))
        if any(result.timings_s.values()):
            figures["work"].append(time_figure(result))
    return figures
