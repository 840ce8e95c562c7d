"""validate.html: table, chart and advice on one page that opens offline."""

from __future__ import annotations

from typing import Any

from fingerdesign.report.figures_validate import along_z_figure, chart_figure
from fingerdesign.report.html import rendered
from fingerdesign.report.tables import Table
from fingerdesign.validate.words import NONE, percent_cell, spread_cell

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
        "validate.html.j2",
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
        told = [NONE if value is None else f"{value:.2f}" for value in seconds]
        saving = NONE if row["saving"] is None else f"{row['saving']:.1f}"
        words = (row["assumed"], row["better"])
        cells.append((str(number), row["title"], *words, *told, saving))
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
    told = [
        (number, row[side]["gages"])
        for number, row in enumerate(rows, start=1)
        if row[side] is not None and row[side]["gages"]
    ]
    count = len(told[0][1]) if told else 0
    cells = tuple(
        (str(gage), *(percent_cell(gages[gage]) for _, gages in told)) for gage in range(count)
    )
    columns = ("gage", *(str(number) for number, _ in told))
    caption = f"{SIDES[side]}: greatest error of each gage by assumption, % of the row's largest"
    return Table(f"gages-{side}", caption, columns, cells)
