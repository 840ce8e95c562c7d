"""Pages as one file of HTML that opens offline: a feature's template, the common parts."""

import base64
import gzip
import hashlib
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from fingerdesign.errors import FingerDesignError
from fingerdesign.report.style import Canvas, ReportFigure, png_element, to_svg

COMMON = Path(__file__).parent / "templates"  # parts.html.j2 and report.css, for every page


def render_page(template: Path, **values: Any) -> str:
    """A feature's template as text, all values escaped; ``style`` is the common style sheet.

    The first use of each term of the glossary leads to its entry at the end of the page's <main>.
    A template may take macros from ``parts.html.j2``. Raises jinja2.UndefinedError where it names a
    value that is not given.
    """
    made = _environment(template.parent, COMMON, autoescape=True)
    style = _safe((COMMON / "report.css").read_text(encoding="utf-8"))
    return add_definitions(str(made.get_template(template.name).render(style=style, **values)))


# The glossary: glossary.toml, and the links of a page to the entries of the terms that it uses.


@dataclass(frozen=True)
class Entry:
    """A term: its anchor, its names on pages, what it means, an SVG's inside where one helps."""

    key: str
    names: tuple[str, ...]
    text: str
    sketch: str = ""


@lru_cache
def glossary() -> dict[str, Entry]:
    """Every entry under each of its names, in lower case where the name is no symbol."""
    text = (COMMON / "glossary.toml").read_text(encoding="utf-8")
    entries = [
        Entry(key, tuple(each["names"]), each["text"], each.get("sketch", ""))
        for key, each in tomllib.loads(text).items()
    ]
    return {name.lower(): entry for entry in entries for name in entry.names}


@lru_cache
def term_pattern() -> re.Pattern[str]:
    """A name of the glossary, or its plural, as a word of its own and not part of a key."""
    from markupsafe import escape

    names = sorted((re.escape(escape(name)) for name in glossary()), key=len, reverse=True)
    return re.compile(rf"(?<![\w.\[/-])({'|'.join(names)})(?:e?s)?(?!\w|[.=/_-]\w)", re.IGNORECASE)


# What no link may stand in, whole; then any other tag. What lies between is text.
_TAGS = re.compile(
    r"(<(script|style|svg|a|button|h[1-6]|code|summary|label|select|nav)\b.*?</\2>|<[^>]*>)",
    re.DOTALL,
)


def terms_in(html: str) -> dict[str, Entry]:
    """The entries, by key, whose names stand in a page's text, its drawings and headings too."""
    from html import unescape

    text = re.sub(r"<(script|style|code)\b.*?</\1>|<[^>]*>", "\n", html, flags=re.DOTALL)
    found = (glossary()[unescape(name).lower()] for name in term_pattern().findall(text))
    return {entry.key: entry for entry in found}


def add_definitions(page: str) -> str:
    """The page with its first use of each term linked to a glossary at the end of its <main>."""
    head, opening, rest = page.partition('<main id="main">')
    inside, closing, foot = rest.partition("</main>")
    used = terms_in(inside)
    while more := {k: v for each in used.values() for k, v in terms_in(each.text).items()}:
        if more.keys() <= used.keys():
            break
        used |= more
    if not opening or not used:
        return page
    inside = inside.replace(
        "</ul>\n</nav>", '<li><a href="#glossary">Glossary</a></li>\n</ul>\n</nav>', 1
    )
    linked = "".join(_linked(inside, set()))
    made = _environment(COMMON, autoescape=True).get_template("parts.html.j2").module
    entries = sorted(used.values(), key=lambda each: each.names[0].lower())
    return head + opening + linked + str(made.show_glossary(entries)) + closing + foot


def _linked(html: str, done: set[str]) -> Iterator[str]:
    """The parts of the HTML, the first name of each entry as a link; done: keys linked before."""
    from html import unescape

    def link(match: re.Match[str]) -> str:
        key = glossary()[unescape(match[1]).lower()].key
        if key in done:
            return match[0]
        done.add(key)
        return f'<a class="term" href="#term-{key}">{match[0]}</a>'

    place = 0
    for tag in _TAGS.finditer(html):
        yield term_pattern().sub(link, html[place : tag.start()])
        yield tag[0]
        place = tag.end()
    yield term_pattern().sub(link, html[place:])


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

    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folders),
        autoescape=autoescape,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["picture"] = lambda shown: _safe(png_element(shown.png, shown.alternative))
    # The images are the program's own; all words of the design go through escaping.
    made.filters["image"] = lambda figure: _safe(figure.image)
    return made


def paragraphs(template: Path, name: str, /, **values: Any) -> list[str]:
    """The paragraphs of a macro, parted by lines of ---; any white space in them is one blank."""
    text = str(getattr(macros(template), name)(**values))
    return [" ".join(part.split()) for part in text.split("\n---\n")]


def caption_drawing(
    drawing: Canvas, template: Path, name: str, key: str = "", **values: Any
) -> ReportFigure:
    """A drawing with the words of a macro: its title, how to read it, what it shows.

    key: of the figure on the page, by default the macro's name.
    """
    title, reading, alternative = paragraphs(template, name, **values)
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
    return pack(text), digest(text)


def drawing_scripts(wanted: bool, *more: Path) -> dict[str, Any]:
    """What a template needs for figures by Plotly: ``plotly``, ``scripts`` (the common one, then
    ``more``, by default what draws a report's figures) and the page's ``policy``."""
    if not wanted:
        return {"plotly": "", "scripts": [], "policy": content_policy("'none'")}
    paths = (COMMON / "chart.js", *(more or (COMMON / "figures.js",)))
    plotly, plotly_digest = plotly_script()
    scripts = [path.read_text(encoding="utf-8") for path in paths]
    policy = content_policy(*map(digest, scripts), plotly_digest)
    return {"plotly": plotly, "scripts": scripts, "policy": policy}


def pack(text: str) -> str:
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
