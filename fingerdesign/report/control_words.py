"""What a control study says, as questions with answers; data as in control.json."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

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
    asked = f"{100 * HELD_SHARE:g} %"
    words = (
        f"Measured: {held['count']} of {held['of']} grips ({100 * held['rate']:.1f} %), "
        f"{_grid_words(data)}. The 95 % interval of such a count, {100 * held['low']:.1f} to "
        f"{100 * held['high']:.1f} %, "
    )
    enough = held["rate"] >= HELD_SHARE
    if enough and held["low"] < HELD_SHARE:
        words += f"does not exclude less than {asked}."
    elif not enough and held["high"] >= HELD_SHARE:
        words += f"does not exclude {asked}."
    else:
        words += f"lies wholly {'above' if enough else 'below'} {asked}."
    question = (
        f"At {noise:g} microstrain, does the regulator lift {asked} of this grid without complete "
        "slip?"
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
        words = f"{name}, which is told {best['told']}: {100 * rate:.1f} % over all noises."
    elif len(untold) < len(data["controllers"]):
        words += " Oracles, which are told friction and weight, are left out."
    return Finding("best", "Which controller succeeds most often?", words)


def _at(data: dict[str, Any], controller: str, noise: float) -> dict[str, Any] | None:
    """A controller's summary at a noise; None where the study has none."""
    for each in data["controllers"]:
        if each["controller"] == controller:
            for row in each["by_noise"]:
                if row["noise_microstrain"] == noise:
                    return dict(row)
    return None
