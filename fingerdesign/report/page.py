"""Pages as one file of HTML that opens offline: a feature's template, the common parts."""

import base64
import gzip
import hashlib
from functools import lru_cache
from pathlib import Path
from typing import Any

from fingerdesign.errors import FingerDesignError
from fingerdesign.report.style import Canvas, ReportFigure, png_element, to_svg

COMMON = Path(__file__).parent / "templates"  # parts.html.j2 and report.css, for every page


def rendered(template: Path, **values: Any) -> str:
    """A feature's template as text, all values escaped; ``style`` is the common style sheet.

    A template may take macros from ``parts.html.j2``. Raises jinja2.UndefinedError where it names a
    value that is not given.
    """
    made = _environment(template.parent, COMMON, autoescape=True)
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
    made = _environment(template.parent, autoescape=False)
    made.filters["to"] = format  # {{ 0.1234 | to(".2f") }}
    return made.get_template(template.name).module


def _environment(*folders: Path, autoescape: bool) -> Any:
    import jinja2

    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(folders),
        autoescape=autoescape,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def said(template: Path, name: str, /, **values: Any) -> list[str]:
    """The paragraphs of a macro, parted by lines of ---; any white space in them is one blank."""
    text = str(getattr(macros(template), name)(**values))
    return [" ".join(part.split()) for part in text.split("\n---\n")]


def captioned(
    drawing: Canvas, template: Path, name: str, key: str = "", **values: Any
) -> ReportFigure:
    """A drawing with the words of a macro: its title, how to read it, what it shows.

    key: of the figure on the page, by default the macro's name.
    """
    title, reading, alternative = said(template, name, **values)
    image = to_svg(drawing, key or name, alternative)
    return ReportFigure(key or name, title, image, reading, alternative)


def sentences(template: Path, macro: str, *given: Any) -> tuple[str, ...]:
    """What a macro of a template of plain sentences says, a sentence a line."""
    lines = str(getattr(macros(template), macro)(*given)).splitlines()
    return tuple(line for line in lines if line.strip())


def _safe(text: str) -> Any:
    """Text of the program's own that needs no escaping."""
    from markupsafe import Markup

    return Markup(text)


# Interactive pictures by Plotly, in a page that fetches nothing.
#
# A page carries plotly.js packed (gzip in base64, 2 MB instead of 4.8 MB) and unpacks it for the
# first chart. Its content policy names the digests of the scripts that may run: what an outcome or
# a design brings along can be no script. Of Plotly's traces all that this program draws run under
# such a policy; parallel coordinates ("parcoords") do not, for they compile functions from text.


@lru_cache(maxsize=1)
def plotly_script() -> tuple[str, str]:
    """plotly.js as it is installed: packed for a page, and its digest for the page's policy.

    Raises FingerDesignError where the script is not where the plotly package has it.
    """
    from importlib.resources import files

    place = files("plotly") / "package_data" / "plotly.min.js"
    try:
        text = place.read_text(encoding="utf-8")
    except OSError as error:
        raise FingerDesignError(f"plotly has no script: {error}; install plotly again") from error
    return packed(text), digest(text)


def packed(text: str) -> str:
    """gzip in base64: browsers open a page of a few MB faster than one of many."""
    return base64.b64encode(gzip.compress(text.encode(), 6, mtime=0)).decode("ascii")


def digest(script: str) -> str:
    """A script's name in a content policy."""
    found = hashlib.sha256(script.encode()).digest()
    return f"'sha256-{base64.b64encode(found).decode('ascii')}'"


def content_policy(*scripts: str) -> str:
    """A policy under which a page loads nothing and runs only the scripts of these digests."""
    allowed = " ".join(scripts)
    return (
        "default-src 'none'; img-src data:; style-src 'unsafe-inline'; "
        f"script-src {allowed}; base-uri 'none'; form-action 'none'"
    )
