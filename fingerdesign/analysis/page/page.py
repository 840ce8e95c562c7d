"""report.html: one file that opens offline and fetches nothing."""

from itertools import chain
from time import perf_counter

import numpy as np

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.page import gage, tables, words
from fingerdesign.analysis.page.contact import force_figure, status_figure, traction_figure
from fingerdesign.analysis.page.finger import finger_report
from fingerdesign.control.foresight import CLEARLY
from fingerdesign.errors import PictureError
from fingerdesign.mesh.measures import cell_angles
from fingerdesign.mesh.types import Mesh
from fingerdesign.report import style
from fingerdesign.report.page import caption_drawing, drawing_scripts, render_page

RESPONSES = 3  # friction coefficients whose responses are drawn gage by gage; the areas are for all
SECTIONS = {
    "contact": "The contact",
    "gages": "The gages",
    "grips": "The grips",
    "work": "The work",
}
TEMPLATE = words.TEMPLATES / "report.html.j2"
PAGE_STAGE = "this page"
# In the table of times, until the page is made: no text of a design can hold a NUL.
OWN_TIME, WHOLE_TIME = "\0own", "\0whole"


def quality_figure(mesh: Mesh) -> style.ReportFigure:
    """Histogram of the cells' least angles, elastomer, plates and core apart."""
    angles = cell_angles(mesh.points, mesh.corners).min(axis=1)
    what = "least angle" if mesh.dimension == 2 else "least dihedral angle"
    bins = np.arange(0.0, 75.1, 2.5)
    looks = ((style.BLUE, ""), (style.VERMILION, "//"), (style.GREEN, ""))
    pairs = zip(mesh.parts.items(), looks, strict=True)
    parts = [(name, own, *look) for (name, own), look in pairs if own.any()]
    figure = style.canvas(7.2, 2.4)
    panels = np.atleast_1d(figure.subplots(1, len(parts), sharex=True))
    for axes, (name, own, colour, hatch) in zip(panels, parts, strict=True):
        axes.hist(angles[own], bins=bins, color=colour, hatch=hatch, edgecolor=style.PAPER, lw=0.3)
        axes.set_title(f"{name}: {own.sum():,} cells")
        axes.axvline(angles[own].min(), color=style.INK, ls=":", lw=1.2)
    figure.supxlabel(f"{what} of a cell (degrees)", fontsize="medium")
    panels[0].set_ylabel("cells")
    worst = {name: angles[own].min() for name, own, *_ in parts}
    return caption_drawing(
        figure, words.FIGURES, "quality", what=what, worst=worst, median=np.median(angles)
    )


def time_figure(stages: dict[str, float]) -> style.ReportFigure:
    """Seconds by stage."""
    figure = style.canvas(7.2, 0.6 + 0.27 * max(len(stages), 1))
    axes = figure.subplots()
    bars = axes.barh(list(stages), list(stages.values()), color=style.MUTED, height=0.6)
    axes.bar_label(bars, [f"{seconds:.1f} s" for seconds in stages.values()], padding=3)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("seconds")
    axes.margins(x=0.12)
    return caption_drawing(figure, words.FIGURES, "time", stages=stages, total=sum(stages.values()))


def report_figures(analysis: Analysis) -> dict[str, list[style.ReportFigure]]:
    """Section of :data:`SECTIONS` -> figures; what the analysis does not hold is left out."""
    result = analysis.result
    figures: dict[str, list[style.ReportFigure]] = {section: [] for section in SECTIONS}
    with style.house_style():
        if result.increments:
            figures["contact"].append(force_figure(result))
        if analysis.contact is not None and len(analysis.contact.status):
            grows = words.slip_grows_with_shear(result.increments)
            figures["contact"].append(status_figure(analysis.contact, grows))
            figures["contact"].append(traction_figure(analysis.contact))
        if analysis.slip_studies:
            figures["gages"].append(gage.area_figure(analysis.slip_studies))
            shown = style.evenly_spaced(len(analysis.slip_studies), RESPONSES)
            figures["gages"] += [gage.response_figure(analysis.slip_studies[i]) for i in shown]
        if result.increments and result.increments[0].gages:
            figures["gages"].append(gage.strain_figure(result, analysis.plates))
        traces = tuple(trace for trace in analysis.grip_traces if len(trace.dx))
        if traces:
            figures["grips"] += [gage.paths_figure(traces), gage.rule_figure(traces)]
        if analysis.mesh is not None:
            figures["work"].append(quality_figure(analysis.mesh))
    return figures


def report_html(analysis: Analysis) -> str:
    """The whole report as HTML text; the time that it says includes its own making.

    A finger that cannot be drawn is said in its place; everything else that fails, raises.
    """
    begin = perf_counter()
    result, missing, finger = analysis.result, "", None
    try:
        finger = finger_report(analysis)
    except PictureError as error:
        missing = f"The finger could not be drawn: {error}."
    figures = report_figures(analysis)
    took = {name: seconds for name, seconds in result.timings_s.items() if seconds > 0}
    drawn = perf_counter() - begin
    if took:
        with style.house_style():
            chart = time_figure({**took, PAGE_STAGE: drawn})
        figures = {**figures, "work": [*figures["work"], chart]}
    all_drawn = [*filter(None, [finger]), *chain(*figures.values())]
    text = render_page(
        TEMPLATE,
        result=result,
        short=words.in_short(result),
        verdict=words.verdict(result, analysis.grip_traces),
        figures=figures,
        sections=SECTIONS,
        space=finger,
        picture_missing=missing,
        **drawing_scripts(any(each.drawn for each in all_drawn)),
        assumed=tables.assumed_values(result),
        increments=tables.increment_table(result),
        grips=tables.grip_table(result),
        foreseen=tables.foreseen_tables(result),
        warning=result.parameters.get("grip.warning_stick_ratio", 0.3),
        clearly=CLEARLY,
        model=tables.model_table(result),
        work=tables.work_table(result, OWN_TIME, WHOLE_TIME),
        ladder=tables.ladder_table(result),
        design=tables.design_table(result),
        scene=tables.scene_table(result),
        rigid=words.object_text(result),
        finger=words.finger_words(result.parameters),
        points=tables.points_table(result),
        colours=style.COLOURS,
    )
    own = perf_counter() - begin
    text = text.replace(OWN_TIME, f"{own:.2f} s", 1)
    return text.replace(WHOLE_TIME, f"{sum(took.values()) + own:.2f} s", 1)
