"""report.html: one file that opens offline, with no script and nothing fetched."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.page.picture import Picture, PictureJob
from fingerdesign.analysis.page.tables import (
    assumed_values,
    design_table,
    grip_table,
    increment_table,
    ladder_table,
    model_table,
    object_text,
    points_table,
    scene_table,
    work_table,
)
from fingerdesign.analysis.page.verdict import findings
from fingerdesign.analysis.page.words import finger_text
from fingerdesign.analysis.page.work import SECTIONS, report_figures
from fingerdesign.errors import PictureError
from fingerdesign.report.page import rendered
from fingerdesign.report.style import COLOURS

TEMPLATE = Path(__file__).parent / "templates" / "report.html.j2"
NO_MESH = "There is no mesh, so there is no picture."


def report_html(analysis: Analysis, picture: bool = True) -> str:
    """The whole report as HTML text.

    picture=False leaves the pictures of the finger out (tests, speed). A picture that cannot be
    drawn is said in its place; everything else that fails, raises.
    """
    if not picture or analysis.mesh is None:
        why = NO_MESH if analysis.mesh is None else "The pictures were not asked for."
        return _render(analysis, report_figures(analysis), {}, why)
    missing, figures = "", None
    pictures: dict[str, Picture] = {}
    try:
        with PictureJob(analysis) as job:  # draws beside, while the figures are made
            figures = report_figures(analysis)
            pictures = job.pictures()
    except PictureError as error:
        missing = f"The finger could not be drawn: {error}."
    return _render(analysis, figures or report_figures(analysis), pictures, missing)


def write_report(analysis: Analysis, folder: Path, picture: bool = True) -> Path:
    """Write ``report.html`` into an existing folder; returns its path."""
    path = folder / "report.html"
    path.write_text(report_html(analysis, picture), encoding="utf-8")
    return path


def _render(
    analysis: Analysis, figures: dict[str, Any], pictures: dict[str, Picture], missing: str
) -> str:
    result = analysis.result
    return rendered(
        TEMPLATE,
        result=result,
        findings=findings(result, analysis.grip_traces),
        figures=figures,
        sections=SECTIONS,
        pictures=pictures,
        picture_missing=missing,
        assumed=assumed_values(result),
        increments=increment_table(result),
        grips=grip_table(result),
        model=model_table(result),
        work=work_table(result),
        ladder=ladder_table(result),
        design=design_table(result),
        scene=scene_table(result),
        rigid=object_text(result),
        finger=finger_text(result),
        points=points_table(result),
        colours=COLOURS,
    )
