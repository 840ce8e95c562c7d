"""Findings of a control study: what it asks, the answers as verdicts, and their numbers."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

from fingerdesign.records.statistics import Share, Spread
from fingerdesign.records.verdict import Status, Verdict
from fingerdesign.trials.record import ControlData, ControllerData
from fingerdesign.trials.summary import NoiseSummary

HELD_SHARE = 0.99  # The regulator is to hold this fraction of the grid.


@dataclass(frozen=True)
class Finding:
    """A question of the study, the verdict in short, and the numbers in a sentence."""

    verdict: Verdict
    question: str
    detail: str


def findings(data: ControlData) -> list[Finding]:
    """Answers to the study's questions that it can give: the best controller first; none for a
    lone rival."""
    noise = data["criteria"]["good_amplifier_microstrain"]
    own = _row(data, "regulator", noise)
    found = [
        *([_best(data)] if len(data["controllers"]) > 1 else []),
        *_paper(_row(data, "paper", 0.0)),
        *(_regulator(data, own, noise) if own is not None else ()),
    ]
    rival = _rival(data, noise)
    if own is not None and rival is not None:
        found.append(_against(own, *rival))
    return found


def _row(data: ControlData, name: str, noise: float) -> NoiseSummary | None:
    own = (each["by_noise"] for each in data["controllers"] if each["controller"] == name)
    return next((row for row in chain(*own) if row.noise_microstrain == noise), None)


def words(name: str) -> str:
    """The name of a controller or a fault in words."""
    return name.replace("_", " ")


def rate_of(share: Share) -> float:
    """The rate of a share; 0 of no cases."""
    return share.rate or 0.0


def percent(rate: float) -> str:
    """A rate in percent with one decimal."""
    return f"{100.0 * rate:.1f} %"


def _peak(spread: Spread | None) -> str:
    if spread is None:
        return "nothing lifted"
    return f"median peak {spread.median:.2f} times the least force"


def _gentlest(data: ControllerData) -> tuple[float, float]:
    """The failures of a controller and its median peak force: the best has the least."""
    whole = data["whole_grid"]
    peak = math.inf if whole.peak_ratio is None else whole.peak_ratio.median
    return 1.0 - rate_of(whole.success), peak


def _ranked(data: ControlData) -> tuple[ControllerData, list[str], bool]:
    """The best of the controllers that are given nothing of the object, or of all where there is
    none; others that succeed as often, in words; and True where some are left out."""
    every = data["controllers"]
    blind = [each for each in every if not each["told"]]
    best, *others = sorted(blind or every, key=_gentlest)
    fails = _gentlest(best)[0]
    alike = [words(each["controller"]) for each in others if _gentlest(each)[0] == fails]
    return best, alike, 0 < len(blind) < len(every)


def _best(data: ControlData) -> Finding:
    """The best controller, and those that are as good but for their force."""
    best, alike, left_out = _ranked(data)
    all_, name = best["whole_grid"], words(best["controller"])
    given = f", which is given {best['told']}" if best["told"] else ""
    noises = ", ".join(map(str, data["conditions"]["noises_microstrain"]))
    success = percent(rate_of(all_.success))
    detail = (
        f"{name}{given}: {success} of {all_.grips} grips at all noises ({noises} microstrain); "
        f"{all_.dropped} dropped, {all_.crushed} crushed, {all_.not_lifted} not lifted."
    )
    if alike:
        detail += f" As often, at a peak force that is no lower: {', '.join(alike)}."
    if left_out:
        detail += " Oracles, which are given friction and weight, are left out."
    tied = f", as of {len(alike)} more" if alike else ""
    verdict = Verdict("note", "best controller", name, count=f"{success} success{tied}")
    return Finding(verdict, "Which controller succeeds most often?", detail)


def _paper(paper: NoiseSummary | None) -> Iterator[Finding]:
    if paper is None:
        return
    clean: Status = "warning" if paper.success.count < paper.grips else "pass"
    dropped = f"{paper.dropped} of {paper.grips}"
    margin = paper.margin_at_lift
    median = f"; median margin at the lift {margin.median:.2f}" if margin else ""
    yield Finding(
        Verdict("fail" if paper.dropped else clean, "paper’s rule", f"{dropped} slip completely"),
        "Without noise, does the paper’s rule keep the whole contact from slipping?",
        f"{dropped} grips end in complete slip{median}; {paper.crushed} crush and "
        f"{paper.not_lifted} are not lifted.",
    )


def _regulator(data: ControlData, own: NoiseSummary, noise: float) -> Iterator[Finding]:
    """The regulator's share of held grips, and how tightly it holds."""
    held, aim = own.held, f"{100.0 * HELD_SHARE:g} %"
    rate, axes = rate_of(held), data["conditions"]
    frictions = _axis(axes["friction_coefficients"], "friction")
    more = "--plants, --lifts" if own.fingers else "--friction, --mass-g"
    where = f"one each on {frictions} by {_axis(axes['object_masses_g'], 'mass', ' g')}"
    if own.fingers:
        where = f"by {own.fingers} drawn fingers, which the interval is over"
    yield Finding(
        Verdict(_decided(held), "regulator lifts", percent(rate), f"target {aim}"),
        f"At {noise:g} microstrain, does the regulator lift {aim} of this grid without complete "
        "slip?",
        f"Measured: {held.count} of {held.of} grips ({percent(rate)}), {where}. The 95 % interval "
        f"of such a count, {_interval(held, aim, more)}.",
    )
    if own.margin_at_lift is None or own.peak_ratio is None:
        return
    margin, (least, most) = own.margin_at_lift, data["criteria"]["human_margin"]
    inside: Status = "pass" if least <= margin.median <= most else "fail"
    yield Finding(
        Verdict(inside, "regulator’s margin", f"{margin.median:.2f}", f"{least:g} to {most:g}"),
        f"Is its median margin between {least:g} and {most:g}, as people grip?",
        f"Median {margin.median:.2f}, middle half {margin.low:.2f} to {margin.high:.2f}; median "
        f"peak force {own.peak_ratio.median:.2f} times the least.",
    )


def _decided(held: Share) -> Status:
    """The status of a share of held grips; a warning where more grips decide."""
    if (held.low or 0.0) < HELD_SHARE <= (held.high or 0.0):
        return "warning"
    return "pass" if rate_of(held) >= HELD_SHARE else "fail"


def _interval(held: Share, aim: str, more: str) -> str:
    """The ends of a share's interval, and what they say of the target; more: options that give more
    grips."""
    low, high, enough = held.low or 0.0, held.high or 0.0, rate_of(held) >= HELD_SHARE
    if enough and low < HELD_SHARE:
        certain = f"begins below {aim}: more grips decide ({more})"
    elif not enough and high >= HELD_SHARE:
        certain = f"reaches {aim}: more grips decide ({more})"
    else:
        certain = f"lies wholly {'above' if enough else 'below'} {aim}"
    return f"{100.0 * low:.1f} to {percent(high)}, {certain}"


def _axis(values: Sequence[float], name: str, unit: str = "") -> str:
    """An axis of the grid: "10 frictions (0.2 to 0.8)"."""
    low, high = min(values), max(values)
    span = f"{low:g} to {high:g}" if low != high else f"{low:g}"
    plural = "" if len(values) < 2 else "es" if name.endswith("s") else "s"
    return f"{len(values)} {name}{plural} ({span}{unit})"


def _rival(data: ControlData, noise: float) -> tuple[str, NoiseSummary] | None:
    """The best controller at a noise that is given no more than the regulator: name, grips."""
    found = [
        (name, own)
        for name in (each["controller"] for each in data["controllers"] if each["told"] is None)
        if name != "regulator" and (own := _row(data, name, noise)) is not None
    ]
    return max(found, key=lambda pair: rate_of(pair[1].success), default=None)


def _against(own: NoiseSummary, controller: str, rival: NoiseSummary) -> Finding:
    """The regulator compared with its best rival."""
    name, rate = words(controller), rate_of(own.success)
    as_good = rate >= rate_of(rival.success)
    gentler = own.peak_ratio is not None and (
        rival.peak_ratio is None or own.peak_ratio.median < rival.peak_ratio.median
    )
    marks: tuple[Status, ...] = ("fail", "warning", "pass")
    known = f"{name} {percent(rate_of(rival.success))}"
    return Finding(
        Verdict(marks[as_good + gentler], "regulator’s success", percent(rate), known),
        "Does it succeed at least as often as the best rival, at a lower peak force?",
        f"Best rival that knows no more: {name}, success {percent(rate_of(rival.success))}, "
        f"{_peak(rival.peak_ratio)}; regulator {percent(rate)}, {_peak(own.peak_ratio)}. "
        "All have the parameters of the design’s [grip] table: they are tuned where that is.",
    )
