"""One look for all figures, and matplotlib figures as inline SVG that follows the page's theme.

Colours are blue, vermilion, green and purple of a palette made for colour-blind readers; every
meaning is also carried by a line style, a marker, a hatch or a word. Of a finger what sticks is
blue, what slips vermilion, plates are bronze and gages purple. In the SVG each colour becomes
a CSS variable with the print colour as its fallback, so one figure serves light, dark and paper.
"""

import base64
import html
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

if TYPE_CHECKING:
    from matplotlib import axes, axis, figure, ticker

    Axes = axes.Axes
    Axis = axis.Axis
    Canvas = figure.Figure
    Locator = ticker.Locator
else:  # only annotations name them, and matplotlib takes a third of a second to load
    Axes = Axis = Canvas = Locator = Any

# CSS variable -> print colour. The templates give the dark values of the same names.
COLOURS = {
    "ink": "#1c1d1f",
    "muted": "#6c6f73",
    "grid": "#d9dbde",
    "open": "#e6e8eb",
    "blue": "#0b6fb0",
    "vermilion": "#d2560a",
    "green": "#0a8f6b",
    "purple": "#b0569a",
    "bronze": "#b87333",
    "paper": "#fefefd",
}
_NAMES = {colour: name for name, colour in COLOURS.items()}
INK, MUTED, GRID, OPEN_COLOUR, BLUE, VERMILION, GREEN, PURPLE, BRONZE, PAPER = COLOURS.values()

# The looks of series differ in colour, dashes and marker: a reader needs only one of the three.
SERIES: tuple[tuple[str, Any, str], ...] = (
    (BLUE, "-", "o"),
    (VERMILION, (0, (6, 2)), "s"),
    (GREEN, (0, (1.5, 1.5)), "^"),
    (PURPLE, (0, (6, 2, 1.5, 2)), "D"),
    (MUTED, (0, (3, 1, 1, 1, 1, 1)), "v"),
)

LOOK = Path(__file__).parent / "templates" / "house.mplstyle"


@dataclass(frozen=True)
class ReportFigure:
    """One figure of the report.

    key: anchor. image: an <svg> or <img> element. reading: how to read it. alternative: what it
    shows, in words and numbers, for those who do not see it. drawn: by Plotly, in the page.
    """

    key: str
    title: str
    image: str
    reading: str
    alternative: str
    drawn: bool = False
    kind: ClassVar[str] = "figure"


@contextmanager
def house_style() -> Iterator[None]:
    """matplotlib's settings for the block; figures must be made and saved inside it."""
    import matplotlib

    with matplotlib.rc_context(fname=LOOK):
        yield


def load_matplotlib_ahead() -> None:
    """Load matplotlib in another thread; loading takes a third of a second."""

    def load() -> None:
        import matplotlib.backends.backend_svg
        import matplotlib.figure  # noqa: F401

    Thread(target=load, daemon=True).start()


def canvas(width: float = 7.2, height: float = 3.0) -> Canvas:
    """A figure of its own (no pyplot state), inches."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def points(
    colour: Any, marker: str, size: float, label: str | None = None, **more: Any
) -> dict[str, Any]:
    """The arguments of ``plot`` for points that no line joins."""
    return {"color": colour, "marker": marker, "ms": size, "label": label, "ls": "none", **more}


def series(
    axes: Axes, x: Any, values: Any, look: int, label: str | None = None, **more: Any
) -> None:
    """A curve of the look ``SERIES[look]``."""
    colour, dashes, marker = SERIES[look]
    axes.plot(x, values, **{"color": colour, "ls": dashes, "marker": marker, "label": label} | more)


def shared_legend(axes: Sequence[Axes], columns: int, where: str = "lower center") -> None:
    """One legend outside several panels, each name once."""
    seen: dict[str, Any] = {}
    for each in axes:
        handles, labels = each.get_legend_handles_labels()
        seen = dict(zip(labels, handles, strict=True)) | seen
    axes[0].figure.legend(seen.values(), seen.keys(), loc=f"outside {where}", ncols=columns)


def to_svg(figure: Canvas, key: str, alternative: str) -> str:
    """The figure as one inline <svg>: see :func:`inline_svg`."""
    for axis in (each for axes in figure.axes for each in (axes.xaxis, axes.yaxis)):
        if not axis.get_label_text():
            axis.set_label_coords(0.5, 0.0)  # else a place is sought for it
    if (layout := figure.get_layout_engine()) is not None:
        layout.execute(figure)
        figure.set_layout_engine(None)  # else the whole figure is drawn twice
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None}, dpi=150)
    return inline_svg(stream.getvalue(), key, alternative)


def to_png(figure: Canvas) -> bytes:
    """The figure as a PNG on paper's colour, the same in every run."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=150, facecolor=PAPER, metadata={"Software": None})
    return stream.getvalue()


def inline_svg(text: str, key: str, alternative: str) -> str:
    """A drawing's SVG file as an element: ids made unique by ``key``, colours as CSS variables."""
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="|url\(#|href="#', rf"\g<0>{key}-", text)
    text = text.replace("'DejaVu Sans'", "var(--figure-font, sans-serif)")
    text = re.sub(r"(stroke|fill): (#[0-9a-f]{6})", _variable, text)
    text = re.sub(r'\b(stroke|fill)="(#[0-9a-f]{6})"', _variable, text)
    name = html.escape(alternative, quote=True)
    return re.sub(r"<svg ", f'<svg role="img" aria-label="{name}" ', text, count=1).strip()


def png_element(png: bytes, alternative: str) -> str:
    """A PNG as an <img> with the data inside."""
    data = base64.b64encode(png).decode("ascii")
    name = html.escape(alternative, quote=True)
    return f'<img src="data:image/png;base64,{data}" alt="{name}">'


def small_multiples(
    figure: Canvas, count: int, columns: int, across: str = "", up: str = "", **sharing: Any
) -> list[Axes]:
    """``count`` axes in rows of ``columns``; places left over stay empty.

    across, up: labels of the last axes of each column, and of the first of each row.
    """
    rows = -(-count // columns)
    grid = figure.subplots(rows, columns, squeeze=False, **sharing).ravel()
    for spare in grid[count:]:
        spare.set_axis_off()
        # With shared axes the panel above carries no labels of its own otherwise.
    for axes in grid[max(0, count - columns) : count]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel(across)
    for axes in grid[:count:columns]:
        axes.set_ylabel(up)
    return list(grid[:count])


def evenly_spaced(count: int, most: int) -> list[int]:
    """Up to ``most`` whole numbers from 0 to count - 1, evenly spread, both ends in.

    >>> evenly_spaced(8, 4), evenly_spaced(2, 4), evenly_spaced(0, 4)
    ([0, 2, 5, 7], [0, 1], [])
    """
    return sorted({round(i) for i in np.linspace(0, count - 1, min(most, count))})


def whole_numbers(most: int = 8) -> Locator:
    """Ticks of an axis that counts."""
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(integer=True, nbins=most)


def _variable(match: re.Match[str]) -> str:
    if (name := _NAMES.get(match[2])) is None:
        return match[0]
    found = f"{match[1]}: var(--{name}, {match[2]})"
    # A presentation attribute cannot hold var(); a style can.
    return f'style="{found}"' if match[0].endswith('"') else found
