"""control.html: who lifts what, and with what force, on one page that opens offline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fingerdesign.records.result import GripTrace
from fingerdesign.report.page import rendered
from fingerdesign.report.table import Table
from fingerdesign.trials.figures import (
    Row,
    force_figure,
    map_figure,
    paths_figure,
    success_figure,
    title_of,
)

# What a control study says, as questions with answers; data as in control.json.

TEMPLATES = Path(__file__).parent / "templates"

HELD_SHARE = 0.99  # of the grid: what is asked of the regulator


@dataclass(frozen=True)
class Finding:
    """answer: "yes", "no", "partly" or "best" (the class of its look); words: the evidence."""

    answer: str
    question: str
    words: str


def findings(data: dict[str, Any]) -> list[Finding]:
    """The study's questions, those that it cannot answer left out; none for a lone rival."""
    found = [
        _rule_without_noise(data),
        _regulator_holds(data),
        _regulator_margin(data),
        _regulator_against_rivals(data),
    ]
    answered = [each for each in found if each is not None]
    if answered or len(data["controllers"]) == 1:
        return answered
    return [_best_of(data)]


def _rule_without_noise(data: dict[str, Any]) -> Finding | None:
    row = _at(data, "paper", 0.0)
    if row is None:
        return None
    dropped, grips = row["dropped"], row["grips"]
    margin = row["margin_at_lift"]
    words = f"{dropped} of {grips} grips end in complete slip"
    if margin is not None:
        words += f"; median margin at the lift {margin['median']:.2f}"
    words += f"; {row['crushed']} crush and {row['not_lifted']} are not lifted."
    question = "Without noise, does the paper’s rule keep the whole contact from slipping?"
    return Finding("no" if dropped else "yes", question, words)


def _regulator_holds(data: dict[str, Any]) -> Finding | None:
    noise = data["criteria"]["good_amplifier_microstrain"]
    row = _at(data, "regulator", noise)
    if row is None:
        return None
    held = row["held"]
    requested = f"{100 * HELD_SHARE:g} %"
    words = (
        f"Measured: {held['count']} of {held['of']} grips ({100 * held['rate']:.1f} %), "
        f"{_grid_words(data)}. The 95 % interval of such a count, {100 * held['low']:.1f} to "
        f"{100 * held['high']:.1f} %, "
    )
    enough = held["rate"] >= HELD_SHARE
    if enough and held["low"] < HELD_SHARE:
        words += f"does not exclude less than {requested}."
    elif not enough and held["high"] >= HELD_SHARE:
        words += f"does not exclude {requested}."
    else:
        words += f"lies wholly {'above' if enough else 'below'} {requested}."
    question = (
        f"At {noise:g} microstrain, does the regulator lift {requested} of this grid without "
        "complete slip?"
    )
    return Finding("yes" if enough else "no", question, words)


def _grid_words(data: dict[str, Any]) -> str:
    conditions = data["conditions"]
    parts = [
        f"{len(values)} {name if len(values) > 1 else one} ({_span(values)}{unit})"
        for values, name, one, unit in (
            (conditions["friction_coefficients"], "frictions", "friction", ""),
            (conditions["object_masses_g"], "weights", "weight", " g"),
        )
    ]
    return f"one each on {' by '.join(parts)}"


def _span(values: Sequence[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _regulator_margin(data: dict[str, Any]) -> Finding | None:
    noise = data["criteria"]["good_amplifier_microstrain"]
    row = _at(data, "regulator", noise)
    if row is None or row["margin_at_lift"] is None:
        return None
    low, high = data["criteria"]["human_margin"]
    margin = row["margin_at_lift"]
    words = (
        f"Median {margin['median']:.2f}, middle half {margin['low']:.2f} to {margin['high']:.2f}; "
        f"median peak force {row['peak_ratio']['median']:.2f} times the least."
    )
    question = f"Is its median margin between {low:g} and {high:g}, as people grip?"
    return Finding("yes" if low <= margin["median"] <= high else "no", question, words)


def _regulator_against_rivals(data: dict[str, Any]) -> Finding | None:
    noise = data["criteria"]["good_amplifier_microstrain"]
    own = _at(data, "regulator", noise)
    rivals = {
        each["controller"]: _at(data, each["controller"], noise)
        for each in data["controllers"]
        if each["told"] is None and each["controller"] != "regulator"
    }
    known = {name: row for name, row in rivals.items() if row is not None}
    if own is None or not known:
        return None
    name, best = max(known.items(), key=lambda item: item[1]["success"]["rate"])
    as_good = own["success"]["rate"] >= best["success"]["rate"]
    peak, their_peak = own["peak_ratio"], best["peak_ratio"]
    gentler = peak is not None and (their_peak is None or peak["median"] < their_peak["median"])
    words = (
        f"Best rival that knows no more: {name.replace('_', ' ')}, success "
        f"{100 * best['success']['rate']:.1f} %, {_peak_words(their_peak)}; regulator "
        f"{100 * own['success']['rate']:.1f} %, {_peak_words(peak)}. All have the parameters of "
        "the design’s [grip] table: they are tuned where that is."
    )
    question = "Does it succeed at least as often as the best rival, at a lower peak force?"
    answer = "yes" if as_good and gentler else "partly" if as_good or gentler else "no"
    return Finding(answer, question, words)


def _peak_words(peak: dict[str, Any] | None) -> str:
    if peak is None:
        return "nothing lifted"
    return f"median peak {peak['median']:.2f} times the least force"


def _best_of(data: dict[str, Any]) -> Finding:
    untold = [each for each in data["controllers"] if each["told"] is None]
    best = max(
        untold or data["controllers"], key=lambda each: each["whole_grid"]["success"]["rate"]
    )
    name, rate = best["controller"].replace("_", " "), best["whole_grid"]["success"]["rate"]
    words = f"{name}: {100 * rate:.1f} % over all noises."
    if best["told"] is not None:
        words = f"{name}, which is given {best['told']}: {100 * rate:.1f} % over all noises."
    elif len(untold) < len(data["controllers"]):
        words += " Oracles, which are given friction and weight, are left out."
    return Finding("best", "Which controller succeeds most often?", words)


def _at(data: dict[str, Any], controller: str, noise: float) -> dict[str, Any] | None:
    """A controller's summary at a noise; None where the study has none."""
    for each in data["controllers"]:
        if each["controller"] == controller:
            for row in each["by_noise"]:
                if row["noise_microstrain"] == noise:
                    return dict(row)
    return None


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
        TEMPLATES / "control.html.j2",
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
        reported = [
            f"{_percent(row['success']['rate'])} / {_percent(row['held']['rate'])}"
            for row in each["by_noise"]
        ]
        cells.append((title_of(each["controller"]), *reported))
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
