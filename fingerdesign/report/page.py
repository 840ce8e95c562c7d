"""Pages as one file of HTML that opens offline: typed parts, or a feature's own template.

The ``kind`` of a part names the macro of parts.html.j2 that shows it.
"""

import base64
import gzip
import hashlib
import re
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from html import unescape
from pathlib import Path
from typing import Any, ClassVar

from fingerdesign.errors import FingerDesignError
from fingerdesign.records.verdict import VerdictView
from fingerdesign.report.style import Canvas, ReportFigure, to_svg
from fingerdesign.report.table import Table

COMMON = Path(__file__).parent / "templates"  # parts.html.j2 and report.css, for every page
# Elements that may hold no button, whole; then any other tag. The rest is text.
_TAGS = re.compile(
    r"(<(script|style|svg|a|button|h1|code|summary|label|select|nav)\b.*?</\2>|<[^>]*>)", re.DOTALL
)
# The space between a number and the sign or unit behind it.
_UNIT = re.compile(
    r"(?<=\d) (?=(?:%|°|µm|mm|cm|cm³|mm²|m?N|[kM]?Pa|[mk]?g|[mµ]?s|min|h|[kMG]B|Hz|K|V|mV|ml)"
    r"(?![\w³²]))"
)


@dataclass(frozen=True)
class Text:
    """A paragraph; look: "", "quiet" or "warnings"."""

    text: str
    look: str = ""
    kind: ClassVar[str] = "text"


@dataclass(frozen=True)
class Bullets:
    """A list of sentences."""

    entries: Sequence[str]
    look: str = ""
    kind: ClassVar[str] = "list"


@dataclass(frozen=True)
class Fold:
    """Items that open with a click on their summary."""

    summary: str
    items: Sequence["Item"]
    kind: ClassVar[str] = "fold"


@dataclass(frozen=True)
class Steps:
    """A list to tick off under a title: sentences, each with the HTML of its picture or ""."""

    title: str
    entries: Sequence[tuple[str, str]]
    kind: ClassVar[str] = "steps"


@dataclass(frozen=True)
class Widget:
    """Controls that the scripts of one page use, as HTML whose values are escaped."""

    html: str
    kind: ClassVar[str] = "widget"


Item = ReportFigure | Table | Text | Bullets | Fold | Steps | Widget


@dataclass(frozen=True)
class Section:
    """Items under a heading; key: the heading's anchor; look: a class of the page's own style."""

    key: str
    title: str
    items: Sequence[Item]
    look: str = ""


@dataclass(frozen=True)
class Page:
    """A whole page: heading, first screen, sections, and the record in the footer.

    first: the picture at the left of the first screen; view: the verdicts and fixes at its right.
    end: controls and data below the footer. style: rules of this page alone. scripts: those that
    its controls need; by default what draws a report's figures, where there are any.
    """

    title: str
    heading: str
    lead: str
    sections: Sequence[Section]
    record: Sequence[Item]
    first: Item | None = None
    view: VerdictView | None = None
    end: Sequence[Item] = ()
    style: str = ""
    scripts: Sequence[Path] = ()

    @property
    def contents(self) -> list[tuple[str, str]]:
        """Anchor and title of each section, for the bar at the top."""
        return [*((each.key, each.title) for each in self.sections), ("record", "Record")]

    @property
    def charted(self) -> bool:
        """True if a figure is drawn by Plotly."""
        if self.scripts:
            return True
        items = [item for section in self.sections for item in _flat(section.items)]
        return any(isinstance(each, ReportFigure) and each.drawn for each in [self.first, *items])


def _flat(items: Sequence[Item]) -> Iterator[Item]:
    for item in items:
        yield item
        if isinstance(item, Fold):
            yield from _flat(item.items)


def page_html(page: Page) -> str:
    """The page as HTML that opens offline."""
    scripts = drawing_scripts(page.charted, *page.scripts)
    return render_page(COMMON / "page.html.j2", page=page, **scripts)


def widget(template: Path, **values: Any) -> Widget:
    """A page's own controls, from a template of the feature; all values are escaped."""
    made = _environment(template.parent, COMMON, autoescape=True)
    return Widget(made.get_template(template.name).render(**values))


def render_page(template: Path, **values: Any) -> str:
    """A template as text, all values escaped; ``style`` is the common style sheet.

    No number is parted from its unit at the end of a line. The first use of each term of the
    glossary opens its definition. A template may take macros from ``parts.html.j2``. Raises
    jinja2.UndefinedError where it names a value that is not given.
    """
    made = _environment(template.parent, COMMON, autoescape=True)
    style = _safe((COMMON / "report.css").read_text(encoding="utf-8"))
    page = str(made.get_template(template.name).render(style=style, **values))
    return add_definitions(joined(page))


def joined(html: str) -> str:
    """The HTML with a space that does not break between each number and its unit, but not in code
    and scripts.

    >>> joined("<p>9.7 % of 3 mm</p><code>9.7 %</code>").replace("\\xa0", "_")
    '<p>9.7_% of 3_mm</p><code>9.7 %</code>'
    """
    return _with_texts(html, partial(_UNIT.sub, "\xa0"))


def _with_texts(html: str, change: Callable[[str], str]) -> str:
    """The HTML with its texts changed, what is between the tags."""
    parts, place = [], 0
    for tag in _TAGS.finditer(html):
        parts += [change(html[place : tag.start()]), tag[0]]
        place = tag.end()
    return "".join([*parts, change(html[place:])])


@dataclass(frozen=True)
class Entry:
    """A term: its key, its names on pages, its meaning, and an SVG's inside where one helps."""

    key: str
    names: Sequence[str]
    text: str
    sketch: str = ""


@lru_cache
def glossary() -> dict[str, Entry]:
    """Every entry of glossary.toml under each of its names, in lower case."""
    entries = [Entry(key, **each) for key, each in texts_of(COMMON / "glossary.toml").items()]
    return {name.lower(): entry for entry in entries for name in entry.names}


@lru_cache
def term_pattern() -> re.Pattern[str]:
    """A name of the glossary, or its plural, as a word of its own and not part of a key."""
    from markupsafe import escape

    names = sorted((re.escape(escape(name)) for name in glossary()), key=len, reverse=True)
    return re.compile(rf"(?<![\w.\[/-])({'|'.join(names)})(?:e?s)?(?!\w|[.=/_-]\w)", re.IGNORECASE)


def add_definitions(page: str) -> str:
    """The page with the first use of each term in <main> as a button that opens its definition."""
    used: dict[str, Entry] = {}

    def button(match: re.Match[str]) -> str:
        entry = glossary()[unescape(match[1]).lower()]
        if entry.key in used:
            return match[0]
        used[entry.key] = entry
        return f'<button class="term" popovertarget="term-{entry.key}">{match[0]}</button>'

    head, opening, rest = page.partition('<main id="main">')
    inside, closing, foot = rest.partition("</main>")
    inside = _with_texts(inside, partial(term_pattern().sub, button))
    if not used:
        return page
    parts = _environment(COMMON, autoescape=True).get_template("parts.html.j2").module
    shown = parts.show_definitions(sorted(used.values(), key=lambda each: each.key))
    return head + opening + inside + str(shown) + closing + foot


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
    made.filters["parts"] = partial(_shown, made)
    # The images are the program's own; all words of the design go through escaping.
    made.filters["image"] = lambda figure: _safe(figure.image)
    return made


def _shown(made: Any, items: Sequence[Item], headed: bool = True) -> Any:
    """The items as HTML, each by the macro of its kind."""
    macros = made.get_template("parts.html.j2").module
    shown = (getattr(macros, f"show_{each.kind}")(each, headed) for each in items)
    return _safe("\n".join(shown))


def paragraphs(template: Path, name: str, /, **values: Any) -> list[str]:
    """The texts of an entry of a TOML file, or of a macro, there separated by lines of ---.

    White space is one blank. In TOML they are format strings: "{mu:g}".
    """
    if template.suffix == ".toml":
        texts = [text.format(**values) for text in texts_of(template)[name].values()]
    else:
        texts = str(getattr(macros(template), name)(**values)).split("\n---\n")
    return [" ".join(text.split()) for text in texts]


def caption_drawing(
    drawing: Canvas, template: Path, name: str, key: str = "", **values: Any
) -> ReportFigure:
    """A drawing with the words of a macro: its title, how to read it, what it shows.

    key: of the figure on the page, by default the macro's name.
    """
    title, reading, alternative = paragraphs(template, name, **values)
    image = to_svg(drawing, key or name, alternative)
    return ReportFigure(key or name, title, image, reading, alternative)


@lru_cache
def texts_of(file: Path) -> dict[str, dict[str, str]]:
    """Entries of a TOML file of words."""
    return tomllib.loads(file.read_text(encoding="utf-8"))


def sentences(template: Path, macro: str, *given: Any) -> tuple[str, ...]:
    """The lines of a macro of plain sentences, without empty ones."""
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


def drawing_scripts(charted: bool, *more: Path) -> dict[str, Any]:
    """The values of a page with figures by Plotly: ``plotly``, ``scripts`` (the common one, then
    ``more``, by default what draws a report's figures) and the page's ``policy``."""
    if not charted:
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
    found = base64.b64encode(hashlib.sha256(script.encode()).digest())
    return f"'sha256-{found.decode('ascii')}'"


def content_policy(*scripts: str) -> str:
    """A policy under which a page loads nothing and runs only the scripts of these digests."""
    return (
        "default-src 'none'; img-src data:; style-src 'unsafe-inline'; "
        f"script-src {' '.join(scripts)}; base-uri 'none'; form-action 'none'"
    )
