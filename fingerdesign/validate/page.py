"""validate.html: table, chart and advice on one page that opens offline."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.report.page import rendered
from fingerdesign.report.style import (
    GRID,
    INK,
    MUTED,
    PAPER,
    SERIES,
    ReportFigure,
    canvas,
    house_style,
    small_multiples,
    to_svg,
)
from fingerdesign.report.table import Table
from fingerdesign.validate.advice import NONE, percent_cell, spread_cell

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas


# Figures of a validation: error against cost, and gages along z. Data as in validate.json.

TEMPLATES = Path(__file__).parent / "templates"

GROUPS = {
    "forces": ("normal_force", "tangential_force"),
    "contact: width, stick ratio": ("contact_width", "stick_ratio"),
    "gages": ("gage",),
}
FLOOR = 1e-4  # of one: smaller errors are drawn there
_BESIDE = 1.16
_TICKS = {1e-4: "≤0.01 %", 1e-3: "0.1 %", 1e-2: "1 %", 0.1: "10 %", 1.0: "100 %", 10.0: "×10"}


def chart_figure(data: dict[str, Any]) -> ReportFigure:
    """Error against cost, log-log: one panel a group of readings, one number an assumption."""
    tested = _tested(data)
    with house_style():
        figure = _chart(data)
        alternative = "Greatest errors and seconds. " + " ".join(
            f"{number} {row['title']}: "
            + ", ".join(f"{group} {_most(row, group)}" for group in GROUPS)
            + f"; {_seconds(row)}."
            for number, row in tested
        )
        image = to_svg(figure, "chart", alternative)
    return ReportFigure(
        "chart",
        "Error against cost",
        image,
        "Each number is an assumption of the table. Across: seconds of the model that makes it "
        "(side by side where one model serves several), with a line from there to the better "
        "one's. Up: the greatest error over the path, filled at equal motion, hollow at equal "
        "force (where forces are prescribed, so not drawn). What stands low and has a long line to "
        "its right is worth keeping. Dashed: the thresholds of the advice.",
        alternative,
    )


def chart_png(data: dict[str, Any]) -> bytes:
    """The chart as a PNG on paper's colour, with the names of the numbers."""
    with house_style():
        figure = _chart(data)
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=150, facecolor=PAPER, metadata={"Software": None})
    return stream.getvalue()


def along_z_figure(data: dict[str, Any]) -> ReportFigure | None:
    """How far gages off the middle read otherwise; None where that was not reported."""
    rows = [row for row in data["assumptions"] if row["along_z"]]
    if not rows:
        return None
    profile = rows[0]["along_z"]
    z = [place["z_mm"] for place in profile]
    with house_style():
        figure = canvas(7.2, 2.9)
        axes = figure.subplots()
        for (which, words), (colour, dashes, marker) in zip(
            (("greatest", "greatest over path and gages"), ("median", "median")),
            SERIES,
            strict=False,
        ):
            values = [100.0 * place[which] for place in profile]
            axes.plot(z, values, color=colour, ls=dashes, marker=marker, label=words)
        axes.set_xlabel("gage's middle from its plate's middle, along z (mm)")
        axes.set_ylabel("against the middle (%)")
        axes.set_ylim(bottom=0.0)
        axes.legend()
        alternative = "Gage readings off the middle. " + "; ".join(
            f"z = {place['z_mm']:g} mm: greatest {100 * place['greatest']:.2g} %, median "
            f"{100 * place['median']:.2g} %"
            for place in profile
        )
        image = to_svg(figure, "along-z", alternative)
    return ReportFigure(
        "along-z",
        "Gages along z",
        image,
        "The same gages, moved along their plates: in plane strain nothing depends on z. Relative "
        "to the largest reading of each row in the middle.",
        alternative,
    )


def _chart(data: dict[str, Any]) -> Canvas:
    figure = canvas(9.6, 4.6)
    tested = _tested(data)
    panels = small_multiples(figure, len(GROUPS), len(GROUPS), sharex=True, sharey=True)
    for axes, (group, quantities) in zip(panels, GROUPS.items(), strict=True):
        _panel(axes, tested, quantities, data["thresholds"])
        axes.set_title(group)
        axes.set_xlabel("seconds")
    panels[0].set_ylabel("greatest error")
    _error_axis(panels[0])
    _seconds_axis(panels[0])
    _legend(figure, tested)
    return figure


def _panel(
    axes: Axes,
    tested: list[tuple[int, dict[str, Any]]],
    quantities: tuple[str, ...],
    thresholds: dict[str, float],
) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for value in thresholds.values():
        axes.axhline(value, color=MUTED, lw=0.8, ls=(0, (4, 3)), zorder=1)
    for (number, row), x in zip(tested, _places(tested), strict=True):
        colour, _, marker = SERIES[(number - 1) % len(SERIES)]
        drawn = []
        for side, filled in (("equal_motion", True), ("equal_force", False)):
            error = _greatest(row, side, quantities)
            if error is None:
                continue
            y = max(error, FLOOR)
            drawn.append(y)
            if row["better_seconds"] is not None:
                ends = [x, max(x, row["better_seconds"])]
                axes.plot(ends, [y, y], color=GRID, lw=1.2, zorder=2)
            axes.plot(
                x,
                y,
                marker=marker,
                ls="none",
                mfc=colour if filled else PAPER,
                mec=colour,
                zorder=3,
            )
        if drawn:
            axes.annotate(
                str(number),
                (x, max(drawn)),
                (0, 5),
                textcoords="offset points",
                ha="center",
                fontsize=8.5,
                color=INK,
                zorder=4,
            )


def _places(tested: list[tuple[int, dict[str, Any]]]) -> list[float]:
    """Seconds of each, side by side where one model serves several."""
    seconds = [float(row["seconds"]) for _, row in tested]
    placed = []
    for index, own in enumerate(seconds):
        like = [other for other, value in enumerate(seconds) if value == own]
        placed.append(own * _BESIDE ** (like.index(index) - 0.5 * (len(like) - 1)))
    return placed


def _error_axis(axes: Axes) -> None:
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low, high = FLOOR * 0.7, max(axes.get_ylim()[1], 1.5)
    axes.set_ylim(low, high)
    ticks = {**_TICKS, **{10.0**p: f"×{10**p:,}" for p in range(2, 9)}}
    axes.yaxis.set_major_locator(FixedLocator([t for t in ticks if low <= t <= high]))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(
        FuncFormatter(lambda y, _: next((w for t, w in ticks.items() if np.isclose(t, y)), ""))
    )


def _seconds_axis(axes: Axes) -> None:
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low, high = axes.get_xlim()
    low, high = 0.7 * low, 1.2 * high  # room for the numbers
    axes.set_xlim(low, high)
    decades = np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    every = [step * 10.0**power for power in decades for step in (1.0, 2.0, 5.0)]
    inside = [tick for tick in every if low <= tick <= high]
    if len(inside) > 6:
        inside = [tick for tick in inside if np.isclose(np.log10(tick) % 1.0, (0.0, 1.0)).any()]
    axes.xaxis.set_major_locator(FixedLocator(inside))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))


def _legend(figure: Canvas, tested: list[tuple[int, dict[str, Any]]]) -> None:
    from matplotlib.lines import Line2D

    handles = []
    for number, row in tested:
        colour, _, marker = SERIES[(number - 1) % len(SERIES)]
        words = f"{number} {row['title']}"
        handles.append(Line2D([], [], color=colour, marker=marker, ls="none", label=words))
    for words, filled in (("filled: equal motion", True), ("hollow: equal force", False)):
        face = MUTED if filled else PAPER
        handles.append(Line2D([], [], color=MUTED, marker="o", mfc=face, ls="none", label=words))
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=3)


def _seconds(row: dict[str, Any]) -> str:
    words = f"{row['seconds']:.2g} s"
    better = row["better_seconds"]
    return words if better is None else f"{words} against {better:.2g} s"


def _tested(data: dict[str, Any]) -> list[tuple[int, dict[str, Any]]]:
    rows = enumerate(data["assumptions"], start=1)
    return [(number, row) for number, row in rows if row["tested"]]


def _greatest(row: dict[str, Any], side: str, quantities: tuple[str, ...]) -> float | None:
    found = row[side]
    if found is None:
        return None
    reported = (found["errors"][quantity] for quantity in quantities)
    return max((float(each["greatest"]) for each in reported if each is not None), default=None)


def _most(row: dict[str, Any], group: str) -> str:
    both = (_greatest(row, side, GROUPS[group]) for side in ("equal_motion", "equal_force"))
    most = max((error for error in both if error is not None), default=None)
    return "untold" if most is None else f"{most:.2g}"


ANSWERS = {
    "keep": "yes",
    "limited": "partly",
    "drop": "no",
    "measure": "partly",
    "not tested": "untold",
}
SIDES = {"equal_motion": "At equal motion", "equal_force": "At equal force"}
QUANTITIES = {
    "normal_force": "F_n %",
    "tangential_force": "F_t %",
    "contact_width": "contact width %",
    "stick_ratio": "stick ratio",
    "gage": "gages %",
}


def validate_html(data: dict[str, Any]) -> str:
    """The page, from what validate.json holds."""
    rows = data["assumptions"]
    profile = along_z_figure(data)
    tested = any(row["tested"] for row in rows)
    return rendered(
        TEMPLATES / "validate.html.j2",
        data=data,
        answers=ANSWERS,
        chart=chart_figure(data) if tested else None,
        profile=profile,
        tables=[_errors_table(rows, side) for side in SIDES],
        costs=_cost_table(rows),
        comparisons=_comparison_table(rows),
        gages=[table for side in SIDES if (table := _gage_table(rows, side)).rows],
    )


def _errors_table(rows: list[dict[str, Any]], side: str) -> Table:
    columns = ["", "assumption", *QUANTITIES.values(), "rows", "left out"]
    cells = []
    for number, row in enumerate(rows, start=1):
        found = row[side]
        if found is None:
            missing = [NONE] * (len(QUANTITIES) + 2)
            cells.append((str(number), row["title"], *missing))
            continue
        errors = [spread_cell(name, found["errors"][name]) for name in QUANTITIES]
        counts = (str(found["rows"]), str(found["rows_left_out"]))
        cells.append((str(number), row["title"], *errors, *counts))
    caption = f"{SIDES[side]}: greatest error over the path (median)"
    return Table(side, caption, tuple(columns), tuple(cells), frozenset({1}))


def _cost_table(rows: list[dict[str, Any]]) -> Table:
    cells = []
    for number, row in enumerate(rows, start=1):
        seconds = [row["seconds"], row["better_seconds"]]
        reported = [NONE if value is None else f"{value:.2f}" for value in seconds]
        saving = NONE if row["saving"] is None else f"{row['saving']:.1f}"
        words = (row["assumed"], row["better"])
        cells.append((str(number), row["title"], *words, *reported, saving))
    columns = ("", "assumption", "what is assumed", "the better model", "s", "better s", "saving")
    return Table("costs", "What it saves", columns, tuple(cells), frozenset({1, 2, 3}))


def _comparison_table(rows: list[dict[str, Any]]) -> Table:
    cells = []
    for number, row in enumerate(rows, start=1):
        for each in row["comparisons"]:
            models = [each["assumed"], each["better"]]
            sizes = " / ".join(f"{model['dofs']:,}" for model in models)
            names = (each["label"], models[0]["model"], models[1]["model"])
            notes = [each[side]["note"] for side in SIDES if each[side] and each[side]["note"]]
            cells.append((str(number), *names, sizes, "; ".join([*notes, *each["missing"]])))
    columns = ("", "compared", "model", "held against", "equations", "left out, or missing")
    return Table("comparisons", "What was compared", columns, tuple(cells), frozenset({1, 2, 3, 5}))


def _gage_table(rows: list[dict[str, Any]], side: str) -> Table:
    """The greatest error of each gage; gages down, assumptions across."""
    reported = [
        (number, row[side]["gages"])
        for number, row in enumerate(rows, start=1)
        if row[side] is not None and row[side]["gages"]
    ]
    count = len(reported[0][1]) if reported else 0
    cells = tuple(
        (str(gage), *(percent_cell(gages[gage]) for _, gages in reported)) for gage in range(count)
    )
    columns = ("gage", *(str(number) for number, _ in reported))
    caption = f"{SIDES[side]}: greatest error of each gage by assumption, % of the row's largest"
    return Table(f"gages-{side}", caption, columns, cells)
