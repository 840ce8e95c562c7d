"""control.html: who lifts what, and with what force, on one page that opens offline."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fingerdesign.report.control_words import findings
from fingerdesign.report.figures_control import (
    Row,
    force_figure,
    map_figure,
    paths_figure,
    success_figure,
    title_of,
)
from fingerdesign.report.html import rendered
from fingerdesign.report.tables import Table
from fingerdesign.results import GripTrace

NONE = "–"


def control_html(
    data: dict[str, Any], rows: Sequence[Row], traces: Sequence[GripTrace], noise: float
) -> str:
    """The page, from what control.json and grips.csv hold; ``noise``: the one that is drawn."""
    figures = [
        success_figure(data),
        force_figure(data, rows, noise),
        map_figure(data, rows, noise),
        paths_figure(traces, noise),
    ]
    tugged = data["conditions"]["tug"]
    return rendered(
        "control.html.j2",
        data=data,
        findings=findings(data),
        figures=figures,
        main=_main_table(data, noise),
        forces=_force_table(data, noise),
        by_noise=[_noise_table(data), _margin_table(data)],
        tug=None if tugged is None else _tug_table(data),
        conditions=_conditions_table(data),
    )


def _main_table(data: dict[str, Any], noise: float) -> Table:
    columns = (
        *("controller", "told", "success %", "95 %", "held %", "dropped", "crushed"),
        *("not lifted", "failed"),
    )
    cells = []
    for each in data["controllers"]:
        row = _row_at(each, noise)
        cells.append(
            (
                title_of(each["controller"]),
                "μ, m" if each["told"] else NONE,
                _percent(row["success"]["rate"]),
                _interval(row["success"]),
                _percent(row["held"]["rate"]),
                *(str(row[why]) for why in ("dropped", "crushed", "not_lifted", "failed")),
            )
        )
    caption = f"At {noise:g} microstrain: who lifts, of all grips"
    return Table("controllers", caption, columns, tuple(cells), frozenset({0, 1}))


def _force_table(data: dict[str, Any], noise: float) -> Table:
    columns = ("controller", "margin at lift", "middle half", "peak", "least stick", "slip mm")
    cells = []
    for each in data["controllers"]:
        row = _row_at(each, noise)
        margin = row["margin_at_lift"]
        cells.append(
            (
                title_of(each["controller"]),
                _median(margin, 2),
                NONE if margin is None else f"{margin['low']:.2f} to {margin['high']:.2f}",
                _median(row["peak_ratio"], 2),
                _median(row["minimum_stick_ratio"], 2),
                _median(row["slip_distance_mm"], 3),
                _median(row["steps"], 0),
            )
        )
    caption = f"At {noise:g} microstrain: how, medians of the grips that have the value"
    return Table("forces", caption, (*columns, "steps"), tuple(cells), frozenset({0}))


def _row_at(controller: dict[str, Any], noise: float) -> dict[str, Any]:
    return next(row for row in controller["by_noise"] if row["noise_microstrain"] == noise)


def _margin_table(data: dict[str, Any]) -> Table:
    cells = [
        (
            title_of(each["controller"]),
            *(_median(row["margin_at_lift"], 2) for row in each["by_noise"]),
        )
        for each in data["controllers"]
    ]
    columns = ("controller", *(f"{noise:g}" for noise in data["conditions"]["noises_microstrain"]))
    caption = "By noise (microstrain): median margin at lift"
    return Table("margins", caption, columns, tuple(cells), frozenset({0}))


def _noise_table(data: dict[str, Any]) -> Table:
    noises = data["conditions"]["noises_microstrain"]
    cells = []
    for each in data["controllers"]:
        told = [
            f"{_percent(row['success']['rate'])} / {_percent(row['held']['rate'])}"
            for row in each["by_noise"]
        ]
        cells.append((title_of(each["controller"]), *told))
    columns = ("controller", *(f"{noise:g}" for noise in noises))
    caption = "By noise (microstrain): success % / held %"
    return Table("noise", caption, columns, tuple(cells), frozenset({0}))


def _tug_table(data: dict[str, Any]) -> Table:
    rate = data["hardware"]["sample_rate_Hz"]
    cells = []
    for each in data["controllers"]:
        row = each["tugged"]
        reaction = row["reaction_steps"]
        times = [
            NONE if reaction is None else f"{1000 * reaction[which] / rate:.0f}"
            for which in ("median", "high", "most")
        ]
        answered = row["answered"]
        cells.append(
            (
                title_of(each["controller"]),
                _percent(row["held"]["rate"]),
                _interval(row["held"]),
                f"{answered['count']} of {answered['of']}",
                *times,
                _median(row["peak_ratio"], 2),
            )
        )
    columns = (
        *("controller", "held %", "95 %", "answered"),
        *("reaction ms", "three in four", "slowest", "peak"),
    )
    tug = data["conditions"]["tug"]
    caption = (
        f"Tugged with {100 * tug['share']:g} % of the weight: risen in {tug['rise_s']:g} s, held "
        f"for {tug['stay_s']:g} s, at {tug['noise_microstrain']:g} microstrain"
    )
    return Table("tug", caption, columns, tuple(cells), frozenset({0}))


def _conditions_table(data: dict[str, Any]) -> Table:
    conditions, model = data["conditions"], data["model"]
    rows = [
        ("friction coefficients", _list(conditions["friction_coefficients"])),
        ("weights (g)", _list(conditions["object_masses_g"])),
        ("gage noise (microstrain)", _list(conditions["noises_microstrain"])),
        ("held on after the lift (s)", f"{conditions['hold_s']:g}"),
        ("seed", str(conditions["seed"])),
        *((name.replace("_", " "), _plain(value)) for name, value in data["hardware"].items()),
        *((name.replace("_", " "), _plain(value)) for name, value in model.items()),
    ]
    return Table("conditions", "Conditions", ("what", "value"), tuple(rows), frozenset({0, 1}))


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _plain(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return _list(value) or "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _percent(rate: float | None) -> str:
    return NONE if rate is None else f"{100 * rate:.1f}"


def _interval(share: dict[str, Any]) -> str:
    if share["low"] is None:
        return NONE
    return f"{100 * share['low']:.1f} to {100 * share['high']:.1f}"


def _median(spread: dict[str, Any] | None, decimals: int) -> str:
    return NONE if spread is None else f"{spread['median']:.{decimals}f}"
