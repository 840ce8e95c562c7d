"""Controls of the comparison page: chart, table to sort and filter, two designs, downloads.

Their templates hold fixed sentences; here are the lists that they show.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fingerdesign.report.page import Widget, widget
from fingerdesign.search.compare.table import Column, DesignTable

TEMPLATES = Path(__file__).parent / "templates"
SIDES = ((0, "A", "mark-a"), (1, "B", "mark-b"))
READINGS = {
    "normal_force_N": "normal force (N)",
    "tangential_force_N": "tangential force (N)",
    "stick_ratio": "stick ratio",
    "contact_width_mm": "contact width (mm)",
    "approach_mm": "approach (mm)",
    "shear_mm": "shear (mm)",
}
# Buttons of the view in space: words, label, and the change of the view.
TURNS = (
    ("Reset", "Reset the view", {"to": {"turn": -32, "tilt": 24, "zoom": 1}}),
    ("Front", "View from the front", {"to": {"turn": 0, "tilt": 0, "zoom": 1}}),
    ("Side", "View from the side", {"to": {"turn": -90, "tilt": 0, "zoom": 1}}),
    ("Top", "View from the top", {"to": {"turn": 0, "tilt": 90, "zoom": 1}}),
    ("+", "Zoom in", {"zoom": 1.2}),
    ("−", "Zoom out", {"zoom": 0.8333}),
)
# Drawings of both designs: key, title, how to read it, and the words where there is none.
VIEWS = (
    (
        "contact",
        "Contact",
        "Where the surface is open, sticks and slips: in plane strain over x, a row an increment "
        "of the path, the frame is the chosen increment; in 3-D from above at the chosen "
        "increment, point by point.",
        "No contact is recorded.",
    ),
    (
        "gages",
        "Gages",
        "Every gage along the path (thin), one of them highlighted; the upright line is the chosen "
        "increment. Tension is positive.",
        "No gages are recorded.",
    ),
    (
        "forces",
        "Forces against the friction limits",
        "Tangential over normal force. A path that reaches the straight thin line of its own "
        "friction slips as a whole; the farther right of it, the more force is spent on safety. A "
        "cross: a grip that was not lifted, or slipped as a whole.",
        "No forces are recorded.",
    ),
)
# Files that the page saves: name, words, where it comes from, and how it is changed.
FILES = (
    ("designs.csv", "a row a design: values, metrics, errors, digest, failure", "designs.csv", ""),
    (
        "outcomes.jsonl",
        "a line of JSON a design: everything, contact maps too",
        "outcomes.jsonl",
        "",
    ),
    (
        "increments.csv",
        "a row an increment of each design: motion, forces, stick, gages",
        "increments.csv",
        "",
    ),
    ("grips.csv", "a row a step of each grip: forces, and how it ended", "grips.csv", ""),
    ("outcomes.json", "the same as outcomes.jsonl as one JSON list", "outcomes.jsonl", "list"),
    ("designs_shown.csv", "the rows that the table shows now", "designs.csv", "shown"),
)
GOALS = {"min": "lowest is best", "max": "highest is best"}


@dataclass(frozen=True)
class ColumnView:
    """A heading of the table, ready to show; look: its class; first: shown at first."""

    title: str
    unit: str
    heading: str
    goal: str
    scale: str
    help: str
    meaning: str
    look: str
    first: bool


@dataclass(frozen=True)
class RowView:
    """A design's row, ready to show: cells with their class; missed: why it is not feasible."""

    number: int
    name: str
    standing: str
    missed: Sequence[str]
    cells: Sequence[tuple[str, str]]


def heading_of(column: Column) -> str:
    """Title and unit."""
    return f"{column.title} ({column.unit})" if column.unit else column.title


def chart_widget(table: DesignTable, axes: tuple[int, int]) -> Widget:
    """The chart of two measures, with the choice of both; axes: the columns it begins with."""
    numeric = [(k, each) for k, each in enumerate(table.columns) if each.numeric]
    choices = [
        (key, title, [(k, heading_of(each), k == now) for k, each in numeric])
        for key, title, now in zip("xy", ("across", "up"), axes, strict=True)
    ]
    return widget(TEMPLATES / "chart.html.j2", axes=choices)


def designs_widget(table: DesignTable, designs: Sequence[dict[str, Any]]) -> Widget:
    """The table of all designs; designs: their light data."""
    looks = ["" if each.numeric else "text" for each in table.columns]
    first = set(table.first)
    columns = [_column(each, looks[k], k in first) for k, each in enumerate(table.columns)]
    rows = [
        RowView(
            number,
            designs[number]["name"],
            cells[0],
            designs[number]["missed"],
            list(zip(cells[1:], looks, strict=True)),
        )
        for number, _, cells in table.rows
    ]
    fields = [("design", False), ("standing", False)]
    fields += [(each.title, each.numeric) for each in table.columns]
    filters = [
        (title, "<0.1 or 2..5" if numeric else "part of a word", "<  >  .." if numeric else "has")
        for title, numeric in fields
    ]
    return widget(TEMPLATES / "designs.html.j2", columns=columns, rows=rows, filters=filters)


def _column(column: Column, look: str, first: bool) -> ColumnView:
    goal = GOALS.get(column.goal or "", "")
    return ColumnView(
        column.title,
        f"({column.unit})" if column.unit else "",
        heading_of(column),
        goal if column.objective else "",
        column.scale,
        column.help,
        "; ".join(filter(None, (column.help, goal, column.scale))),
        look,
        first,
    )


def pair_widget() -> Widget:
    """Two designs side by side; the page's scripts fill it."""
    views = {"sides": SIDES, "turns": TURNS, "readings": READINGS, "views": VIEWS}
    return widget(TEMPLATES / "pair.html.j2", **views)


def parallel_widget(table: DesignTable, lines: Sequence[int]) -> Widget:
    """Every design as a line; lines: the columns that are axes at first."""
    axes = [
        (k, heading_of(each), k in lines)
        for k, each in enumerate(table.columns)
        if each.path[0] in ("values", "metrics")
    ]
    return widget(TEMPLATES / "parallel.html.j2", axes=axes)


def downloads_widget() -> Widget:
    """Buttons that save the files in the page."""
    return widget(TEMPLATES / "downloads.html.j2", files=FILES)
