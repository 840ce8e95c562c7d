"""Pages as one file of HTML that opens offline: a feature's template, the common parts."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

from fingerdesign.report.style import png_element

COMMON = Path(__file__).parent / "templates"  # parts.html.j2 and report.css, for every page


def rendered(template: Path, **values: Any) -> str:
    """A feature's template as text, all values escaped; ``style`` is the common style sheet.

    A template may take macros from ``parts.html.j2``. Raises jinja2.UndefinedError where it names a
    value that is not given.
    """
    import jinja2

    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader([template.parent, COMMON]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["picture"] = lambda shown: _safe(png_element(shown.png, shown.alternative))
    # The images are the program's own; all words of the design go through escaping.
    made.filters["image"] = lambda figure: _safe(figure.image)
    style = _safe((COMMON / "report.css").read_text(encoding="utf-8"))
    return str(made.get_template(template.name).render(style=style, **values))


@lru_cache
def macros(template: Path) -> Any:
    """The macros of a template of plain sentences, each a function; nothing is escaped.

    Whoever shows them on a page lets the page's own template escape them.
    """
    import jinja2

    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader(template.parent),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return made.get_template(template.name).module


def _safe(text: str) -> Any:
    """Text of the program's own that needs no escaping."""
    from markupsafe import Markup

    return Markup(text)
