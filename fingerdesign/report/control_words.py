"""What a control study says, as questions with answers; data as in control.json."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

HELD_SHARE = 0.99  # of the grid: what is asked of the regulator


@dataclass(frozen=True)
class Finding:
    """answer: "yes", "no", "partly" or "untold" (the class of its look); words: the evidence."""

    answer: str
    question: str
    words: str


def findings(data: dict[str, Any]) -> list[Finding]:
    """The study's questions, those that it cannot answer left out."""
    found = [
        _rule_without_noise(data),
        _regulator_holds(data),
        _regulator_margin(data),
        _regulator_against_rivals(data),
    ]
    return [each for each in found if each is not None] or [_best_of(data)]


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
    words = (
        f"{held['count']} of {held['of']} ({100 * held['rate']:.1f} %; 95 % interval "
        f"{100 * held['low']:.1f} to {100 * held['high']:.1f} %)."
    )
    question = (
        f"At {noise:g} microstrain, does the regulator lift {100 * HELD_SHARE:g} % without "
        "complete slip?"
    )
    return Finding("yes" if held["rate"] >= HELD_SHARE else "no", question, words)


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
        f"{100 * own['success']['rate']:.1f} %, {_peak_words(peak)}."
    )
    question = "Does it succeed at least as often as the best rival, at a lower peak force?"
    answer = "yes" if as_good and gentler else "partly" if as_good or gentler else "no"
    return Finding(answer, question, words)


def _peak_words(peak: dict[str, Any] | None) -> str:
    if peak is None:
        return "nothing lifted"
    return f"median peak {peak['median']:.2f} times the least force"


def _best_of(data: dict[str, Any]) -> Finding:
    rows = {
        each["controller"]: each["whole_grid"]["success"]["rate"] for each in data["controllers"]
    }
    name, rate = max(rows.items(), key=lambda item: item[1])
    words = f"{name.replace('_', ' ')}: {100 * rate:.1f} % over all noises."
    return Finding("untold", "Which controller succeeds most often?", words)


def _at(data: dict[str, Any], controller: str, noise: float) -> dict[str, Any] | None:
    """A controller's summary at a noise; None where the study has none."""
    for each in data["controllers"]:
        if each["controller"] == controller:
            for row in each["by_noise"]:
                if row["noise_microstrain"] == noise:
                    return dict(row)
    return None
