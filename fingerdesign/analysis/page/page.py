"""report.html: one file that opens offline and fetches nothing."""

from collections.abc import Iterator
from time import perf_counter

import numpy as np

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.page import gage, tables
from fingerdesign.analysis.page.contact import force_figure, status_figure, traction_figure
from fingerdesign.analysis.page.finger import finger_report
from fingerdesign.analysis.page.tables import FIGURES
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.control.foresight import CLEARLY
from fingerdesign.errors import PictureError
from fingerdesign.mesh.measures import cell_angles
from fingerdesign.mesh.types import Mesh
from fingerdesign.records.result import Result
from fingerdesign.report import style
from fingerdesign.report.page import (
    Bullets,
    Fold,
    Item,
    Page,
    Section,
    Text,
    caption_drawing,
    page_html,
    texts_of,
)
from fingerdesign.report.table import Table

# Placeholders in the table of times until the page is made: no text of a design can hold a NUL.
OWN_TIME, WHOLE_TIME = "\0own", "\0whole"
WORDS = texts_of(FIGURES.with_name("page.toml"))


def quality_figure(mesh: Mesh) -> style.ReportFigure:
    """Histogram of the cells' least angles, elastomer, plates and core apart."""
    angles = cell_angles(mesh.points, mesh.corners).min(axis=1)
    angle = "least angle" if mesh.dimension == 2 else "least dihedral angle"
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
    figure.supxlabel(f"{angle} of a cell (degrees)", fontsize="medium")
    panels[0].set_ylabel("cells")
    worst = ", ".join(f"{name} {angles[own].min():.1f}" for name, own, *_ in parts)
    values = {"angle": angle, "worst": worst, "median": np.median(angles)}
    return caption_drawing(figure, FIGURES, "quality", **values)


def report_figures(analysis: Analysis) -> dict[str, list[style.ReportFigure]]:
    """Section -> figures; those of what the analysis does not hold are left out."""
    traces = tuple(trace for trace in analysis.grip_traces if len(trace.dx))
    with style.house_style():
        return {
            "contact": _contact_figures(analysis),
            "gages": _gage_figures(analysis),
            "grips": [gage.paths_figure(traces), gage.rule_figure(traces)] if traces else [],
            "model": [quality_figure(analysis.mesh)] if analysis.mesh is not None else [],
        }


def _contact_figures(analysis: Analysis) -> list[style.ReportFigure]:
    figures = [force_figure(analysis.result)] if analysis.result.increments else []
    if analysis.contact is not None and len(analysis.contact.status):
        figures += [status_figure(analysis.contact), traction_figure(analysis.contact)]
    return figures


def _gage_figures(analysis: Analysis) -> list[style.ReportFigure]:
    result, studies, figures = analysis.result, analysis.slip_studies, list[style.ReportFigure]()
    if studies:
        share = float(result.parameters.get("gages.area_share") or 0.5)
        middle = studies[len(studies) // 2]  # by friction; the others differ little in kind
        figures += [gage.area_figure(studies), gage.response_figure(middle, share)]
    if result.increments and result.increments[0].gages:
        figures.append(gage.strain_figure(result, analysis.plates))
    return figures


def report_html(analysis: Analysis) -> str:
    """The whole report as HTML text; its time includes its own making.

    A text replaces a finger that cannot be drawn; everything else that fails, raises.
    """
    begin = perf_counter()
    result = analysis.result
    first: style.ReportFigure | Text
    try:
        first = finger_report(analysis)
    except PictureError as error:
        first = Text(f"The finger could not be drawn: {error}.", "quiet")
    figures = report_figures(analysis)
    text = page_html(_page(analysis, first, figures))
    own = perf_counter() - begin
    text = text.replace(OWN_TIME, f"{own:.2f} s", 1)
    return text.replace(WHOLE_TIME, f"{sum(result.timings_s.values()) + own:.2f} s", 1)


def _page(
    analysis: Analysis,
    first: style.ReportFigure | Text,
    figures: dict[str, list[style.ReportFigure]],
) -> Page:
    result = analysis.result
    view = verdict_view(result)
    lead = (view.summary, view.fidelity, f"scene {result.scene}", f"analysis {view.seconds:.0f} s")
    sections = []
    if notices := [each for each in (result.failure, *result.warnings) if each]:
        sections.append(Section("warnings", "Warnings", [Bullets(notices, "warnings")]))
    makers = {"contact": _contact, "gages": _gages, "grips": _grips, "model": _model}
    for key, make in {**makers, "design": _design}.items():
        if items := [*figures.get(key, ()), *make(result)]:
            sections.append(Section(key, WORDS["titles"][key], items))
    title = f"{result.design}: {'failed analysis' if result.status == 'failed' else 'analysis'}"
    return Page(
        title=title,
        heading=result.design,
        lead=" · ".join(lead),
        sections=sections,
        record=list(_record(result)),
        first=first,
        view=view,
    )


def _filled(*found: Table | None) -> list[Table]:
    return [each for each in found if each is not None and each.rows]


def _contact(result: Result) -> Iterator[Item]:
    yield from _filled(
        tables.increment_table(result), tables.error_table(result), tables.points_table(result)
    )
    if scene := _filled(tables.scene_table(result)):
        yield Fold("The scene, key by key", scene)


def _gages(result: Result) -> Iterator[Item]:
    yield from _filled(tables.study_table(result), tables.signal_table(result))


def _grips(result: Result) -> Iterator[Item]:
    yield from _filled(tables.grip_table(result))
    if foreseen := tables.foreseen_table(result):
        warning = float(result.parameters.get("grip.warning_stick_ratio") or 0.3)
        words = WORDS["foreseen"]["text"].format(warning=warning, alarm=warning + CLEARLY)
        yield Fold(WORDS["foreseen"]["title"], [foreseen, Text(words, "quiet")])


def _model(result: Result) -> Iterator[Item]:
    if result.model is not None and result.model.reasons:
        yield Fold("Why this model", [Bullets(result.model.reasons)])
    yield from _filled(tables.ladder_table(result), tables.model_table(result))
    yield tables.work_table(result, OWN_TIME, WHOLE_TIME)


def _design(result: Result) -> Iterator[Item]:
    if result.model is not None:
        yield Text(WORDS["laws"]["finite" if result.fidelity == "finite" else "linear"])
    if result.assumed:
        count = len(result.assumed)
        assumed = [f"{key} = {value}" for key, value in tables.assumed_values(result)]
        listed = Bullets(assumed, "keys")
        yield Fold(f"Assumed: {count} keys that its source does not give", [listed])
    if rows := _filled(tables.design_table(result)):
        yield Fold("The design, key by key", rows)


def _record(result: Result) -> Iterator[Item]:
    versions = ", ".join(f"{name} {each}" for name, each in result.versions.items())
    seeds = ", ".join(f"{name} {each}" for name, each in result.seeds.items())
    yield Text(f"Status: {result.status}. Digest {result.digest}.")
    yield Text(f"Versions: {versions or 'not recorded'}. Seeds: {seeds or 'none used'}.")
    yield Text(WORDS["record"]["files"], "quiet")
    if result.model is not None and result.model.symmetry:
        yield Text(WORDS["record"]["half"], "quiet")
