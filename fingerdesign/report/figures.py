"""Every figure of a report, in the order in which they are read."""

from __future__ import annotations

from fingerdesign.report.figures_contact import force_figure, traction_figure
from fingerdesign.report.figures_gage import area_figure, response_figure, strain_figure
from fingerdesign.report.figures_grip import paths_figure, rule_figure
from fingerdesign.report.figures_status import status_figure
from fingerdesign.report.figures_work import quality_figure, time_figure
from fingerdesign.report.motion import slip_grows_with_shear
from fingerdesign.report.style import ReportFigure, house_style, spread
from fingerdesign.results import Analysis

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
