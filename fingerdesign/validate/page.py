"""validate.html: table, chart and advice on one page that opens offline."""

from collections.abc import Iterable, Sequence

import numpy as np

from fingerdesign.records.verdict import Status, Verdict, VerdictView
from fingerdesign.report import style
from fingerdesign.report.page import (
    Bullets,
    Page,
    Section,
    Text,
    caption_drawing,
    page_html,
    texts_of,
)
from fingerdesign.report.style import Axes, Axis, Canvas
from fingerdesign.report.table import Table
from fingerdesign.validate.advice import GROUPS, NONE, TEMPLATES, WORDS, spread_cell
from fingerdesign.validate.record import Row, Thresholds, Validation

FLOOR = 1e-4  # of one: smaller errors are drawn there
_BESIDE = 1.16
_TICKS = {1e-4: "≤0.01 %", 1e-3: "0.1 %", 1e-2: "1 %", 0.1: "10 %", 1.0: "100 %", 10.0: "×10"}
STATUS: dict[str, Status] = {
    "keep": "pass",
    "limited": "warning",
    "drop": "fail",
    "measure": "warning",
    "not tested": "note",
}
PAGE = texts_of(TEMPLATES / "page.toml")["page"]
SIDES = {"equal_motion": "At equal motion", "equal_force": "At equal force"}
QUANTITIES = {
    "normal_force": "F_n %",
    "tangential_force": "F_t %",
    "contact_width": "contact width %",
    "stick_ratio": "stick ratio",
    "gage": "gages %",
}
Tested = list[tuple[int, Row]]


def _title(group: str) -> str:
    return f"{group}: width, stick ratio" if group == "contact" else group


def _tested(of: Validation) -> Tested:
    return [(number, row) for number, row in enumerate(of.assumptions, start=1) if row.tested]


def chart_figure(of: Validation) -> style.ReportFigure:
    """Error against cost, log-log: one panel a group of readings, one number an assumption."""
    rows = [
        (number, row, {_title(group): _greatest(row, SIDES, GROUPS[group]) for group in GROUPS})
        for number, row in _tested(of)
    ]
    with style.house_style():
        return caption_drawing(_chart(of), WORDS, "chart", rows=rows)


def chart_png(of: Validation) -> bytes:
    """The chart as a PNG on paper's colour, with the names of the numbers."""
    with style.house_style():
        return style.to_png(_chart(of))


def _chart(of: Validation) -> Canvas:
    figure = style.canvas(9.6, 4.6)
    tested = _tested(of)
    panels = style.small_multiples(figure, len(GROUPS), len(GROUPS), sharex=True, sharey=True)
    for axes, (group, quantities) in zip(panels, GROUPS.items(), strict=True):
        _panel(axes, tested, quantities, of.thresholds)
        axes.set_title(_title(group))
        axes.set_xlabel("seconds")
    panels[0].set_ylabel("greatest error")
    _error_axis(panels[0])
    _seconds_axis(panels[0])
    _legend(figure, tested)
    return figure


def _panel(axes: Axes, tested: Tested, quantities: Iterable[str], thresholds: Thresholds) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for value in (thresholds.keep, thresholds.limit):
        axes.axhline(value, color=style.MUTED, lw=0.8, ls=(0, (4, 3)), zorder=1)
    for (number, row), x in zip(tested, _places(tested), strict=True):
        colour, _, marker = style.SERIES[(number - 1) % len(style.SERIES)]
        drawn = []
        for side, filled in (("equal_motion", True), ("equal_force", False)):
            error = _greatest(row, (side,), quantities)
            if error is None:
                continue
            y = max(error, FLOOR)
            drawn.append(y)
            if row.better_seconds is not None:
                ends = [x, max(x, row.better_seconds)]
                axes.plot(ends, [y, y], color=style.GRID, lw=1.2, zorder=2)
            face = colour if filled else style.PAPER
            axes.plot(x, y, marker, mfc=face, mec=colour, zorder=3)
        if drawn:
            text = axes.annotate(str(number), (x, max(drawn)), (0, 5), textcoords="offset points")
            text.set(ha="center", fontsize=8.5, color=style.INK, zorder=4)


def _places(tested: Tested) -> list[float]:
    """Seconds of each, side by side where one model serves several."""
    seconds = [row.seconds or 0.0 for _, row in tested]
    placed = []
    for index, own in enumerate(seconds):
        like = [other for other, value in enumerate(seconds) if value == own]
        placed.append(own * _BESIDE ** (like.index(index) - 0.5 * (len(like) - 1)))
    return placed


def _error_axis(axes: Axes) -> None:
    low, high = FLOOR * 0.7, max(axes.get_ylim()[1], 1.5)
    ticks = {**_TICKS, **{10.0**p: f"×{10**p:,}" for p in range(2, 9)}}
    _ticks(axes.yaxis, {tick: words for tick, words in ticks.items() if low <= tick <= high})
    axes.set_ylim(low, high)


def _seconds_axis(axes: Axes) -> None:
    low, high = axes.get_xlim()
    low, high = 0.7 * low, 1.2 * high  # room for the numbers
    decades = np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    every = [step * 10.0**power for power in decades for step in (1.0, 2.0, 5.0)]
    inside = [tick for tick in every if low <= tick <= high]
    if len(inside) > 6:
        inside = [tick for tick in inside if np.isclose(np.log10(tick) % 1.0, (0.0, 1.0)).any()]
    _ticks(axes.xaxis, {tick: f"{tick:g}" for tick in inside})
    axes.set_xlim(low, high)


def _ticks(axis: Axis, words: dict[float, str]) -> None:
    """These alone; after them the axis's limits, which they widen."""
    axis.set_ticks(list(words), list(words.values()))
    axis.set_ticks([], minor=True)


def _legend(figure: Canvas, tested: Tested) -> None:
    from matplotlib.lines import Line2D

    handles = []
    for number, row in tested:
        colour, _, marker = style.SERIES[(number - 1) % len(style.SERIES)]
        words = f"{number} {row.title}"
        handles.append(Line2D([], [], color=colour, marker=marker, ls="none", label=words))
    for words, face in ("filled: equal motion", style.MUTED), ("hollow: equal force", style.PAPER):
        dot = Line2D([], [], color=style.MUTED, marker="o", mfc=face, ls="none", label=words)
        handles.append(dot)
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=3)


def _greatest(row: Row, sides: Iterable[str], quantities: Iterable[str]) -> float | None:
    """The greatest error of the quantities at the sides; None where there is none."""
    every = (row.greatest(side, quantity) for side in sides for quantity in quantities)
    return max((error for error in every if error is not None), default=None)


def validate_html(of: Validation) -> str:
    """The page of a validation: the chart and a tile for each assumption come first."""
    rows = of.assumptions
    tiles = tuple(
        Verdict(STATUS[row.verdict], f"{number} {row.title}", "", count=row.verdict)
        for number, row in enumerate(rows, start=1)
    )
    thresholds = {"keep": 100 * of.thresholds.keep, "limit": 100 * of.thresholds.limit}
    advice = Bullets(
        [f"{k} {row.title} ({row.assumed}): {row.advice}" for k, row in enumerate(rows, 1)]
    )
    errors = [*(_errors_table(rows, side) for side in SIDES), _cost_table(rows)]
    note, files, finite = (Text(PAGE[each], "quiet") for each in ("dash", "files", "finite"))
    versions = ", ".join(f"{name} {each}" for name, each in of.versions.items())
    tried = any(row.assumption == "small_strain" for row in rows)
    digest = Text(f"Digest {of.digest}. Versions: {versions or 'not recorded'}.")
    return page_html(
        Page(
            title=f"{of.design}: cost of each assumption",
            heading=f"{of.design}: cost of each assumption",
            lead=f"scene {of.scene} · {of.seconds:.0f} s · {of.peak_memory_MB:.0f} MB",
            first=chart_figure(of) if _tested(of) else Text(PAGE["nothing"]),
            view=VerdictView(of.design, "", of.seconds, tiles),
            sections=[
                Section("advice", "Advice", [advice, Text(PAGE["rule"].format(**thresholds))]),
                Section("errors", "Numbers", [*errors, note]),
            ],
            record=[digest, files, *([finite] if tried and not of.deep else [])],
        )
    )


def _errors_table(rows: Sequence[Row], at: str) -> Table:
    columns = ("", "assumption", *QUANTITIES.values(), "rows", "left out")
    cells = []
    for number, row in enumerate(rows, start=1):
        found = [NONE] * (len(QUANTITIES) + 2)
        if (side := getattr(row, at)) is not None:
            found = [spread_cell(name, side.spread(name)) for name in QUANTITIES]
            found += [str(side.rows), str(side.rows_left_out)]
        cells.append((str(number), row.title, *found))
    caption = f"{SIDES[at]}: greatest error over the path (median)"
    return Table(at, caption, columns, tuple(cells), frozenset({1}))


def _cost_table(rows: Sequence[Row]) -> Table:
    columns = ("", "assumption", "what is assumed", "the better model", "s", "better s", "saving")
    cells = []
    for number, row in enumerate(rows, start=1):
        costs = ((row.seconds, 2), (row.better_seconds, 2), (row.saving, 1))
        found = [NONE if value is None else f"{value:.{digits}f}" for value, digits in costs]
        cells.append((str(number), row.title, row.assumed, row.better, *found))
    return Table("costs", "What it saves", columns, tuple(cells), frozenset({1, 2, 3}))
