"""report.html: one file that opens offline, with no script and nothing fetched."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fingerdesign.report.figures import SECTIONS, report_figures
from fingerdesign.report.finger_words import finger_text
from fingerdesign.report.ladder_table import ladder_table
from fingerdesign.report.picture import Picture, PictureError, PictureJob
from fingerdesign.report.style import COLOURS, png_element
from fingerdesign.report.tables import (
    assumed_values,
    design_table,
    grip_table,
    increment_table,
    model_table,
    object_text,
    points_table,
    scene_table,
    work_table,
)
from fingerdesign.report.verdict import findings
from fingerdesign.results import Analysis

TEMPLATES = Path(__file__).parent / "templates"
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
        "report.html.j2",
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


def rendered(template: str, **values: Any) -> str:
    """A template of this package as text; ``style``, the pages' style sheet, is always there."""
    import jinja2

    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["picture"] = lambda shown: _safe(png_element(shown.png, shown.alternative))
    # The images are the program's own; all words of the design go through escaping.
    made.filters["image"] = lambda figure: _safe(figure.image)
    style = _safe((TEMPLATES / "report.css").read_text(encoding="utf-8"))
    return str(made.get_template(template).render(style=style, **values))


def _safe(text: str) -> Any:
    """Text of the program's own that needs no escaping."""
    from markupsafe import Markup

    return Markup(text)
