"""Parts of the remade figures: a drawing as PNG, SVG and inline, its data as CSV."""

import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fingerdesign.records.base import write_csv
from fingerdesign.report.page import paragraphs
from fingerdesign.report.style import PAPER, Canvas, ReportFigure, inline_svg

WORDS = Path(__file__).parent / "templates" / "figures.txt.j2"
_DIGITS = 6  # of a number in a CSV file


@dataclass(frozen=True)
class PaperFigure:
    """One remade figure and its data.

    shown: the figure on the page; png, svg: files that stand alone; columns, rows: of the CSV file,
    units in the names, an empty text where there is no value.
    """

    shown: ReportFigure
    png: bytes
    svg: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def key(self) -> str:
        """The files' name."""
        return self.shown.key

    def write(self, folder: Path) -> list[Path]:
        """KEY.png, KEY.svg and KEY.csv in an existing folder; returns the files."""
        paths = [folder / f"{self.key}.{kind}" for kind in ("png", "svg", "csv")]
        paths[0].write_bytes(self.png)
        paths[1].write_text(self.svg, encoding="utf-8")
        write_csv(paths[2], self.columns, self.rows)
        return paths


def paper_figure(
    canvas: Canvas, key: str, columns: Sequence[str], rows: Iterable[Sequence[Any]], **values: Any
) -> PaperFigure:
    """Save a drawing in all its forms, with the template's words; inside the house style."""
    title, reading, alternative = paragraphs(WORDS, key, **values)
    canvas.draw_without_rendering()  # lays out once for both
    canvas.set_layout_engine("none")
    picture, drawing = io.BytesIO(), io.StringIO()
    canvas.savefig(picture, format="png", dpi=160, facecolor=PAPER, metadata={"Software": None})
    canvas.savefig(drawing, format="svg", facecolor=PAPER, metadata={"Date": None})
    image = inline_svg(drawing.getvalue(), key, alternative)
    shown = ReportFigure(key, title, image, reading, alternative)
    cells = tuple(tuple(_text(value) for value in row) for row in rows)
    return PaperFigure(shown, picture.getvalue(), drawing.getvalue(), tuple(columns), cells)


def shades(count: int) -> list[tuple[float, float, float, float]]:
    """Colours of an ordered set (friction coefficients), dark to light; viridis' first 90 %."""
    from matplotlib import colormaps

    return [colormaps["viridis"](0.9 * k / max(count - 1, 1)) for k in range(count)]


def _text(value: Any) -> str:
    if value is None or isinstance(value, str):
        return value or ""
    number = value.item() if hasattr(value, "item") else value
    if isinstance(number, int):
        return str(int(number))
    return f"{number:.{_DIGITS}g}" if math.isfinite(number) else ""
