"""One sentence of advice, made from the numbers.

Readings fall into three groups: forces, contact (its width and stick ratio) and gages. A group is
good where its greatest error over the path, at equal motion and at equal force, is at most KEEP,
and bad above LIMIT.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fingerdesign.report.page import paragraphs
from fingerdesign.validate.record import THRESHOLDS, ComparisonData, Kind, Spread, Verdict

TEMPLATES = Path(__file__).parent / "templates"
WORDS = TEMPLATES / "words.txt.j2"
KEEP, LIMIT = THRESHOLDS.keep, THRESHOLDS.limit
GROUPS = {
    "forces": {"normal_force": "F_n", "tangential_force": "F_t"},
    "contact": {"contact_width": "contact width", "stick_ratio": "stick ratio"},
    "gages": {"gage": "gage strain"},
}
_WORTH = 1.5  # a saving below this factor is none: seconds vary as much between runs

MANY = 10.0  # from here on no percents
NONE = "–"  # prescribed, or nothing that could differ


def percent_cell(error: float) -> str:
    """A table's cell under "%".

    >>> percent_cell(0.259), percent_cell(1.615), percent_cell(2612.3)
    ('25.90', '162', '2,612 times')
    """
    if error >= MANY:
        return f"{error:,.0f} times"
    hundred = 100.0 * error
    return f"{hundred:.0f}" if hundred >= 99.5 else f"{hundred:.2f}"


def spread_cell(quantity: str, found: Spread | None) -> str:
    """The greatest error, the median in brackets: "25.90 (25.70)"."""
    if found is None:
        return NONE
    if quantity == "stick_ratio":
        return f"{found.greatest:.3f} ({found.median:.3f})"
    return f"{percent_cell(found.greatest)} ({percent_cell(found.median)})"


@dataclass(frozen=True)
class Worst:
    """The greatest error of a group: of which quantity, where ("motion" or "force"), and its size.

    elsewhere: the greatest at the other of the two; None where that was not compared.
    """

    group: str
    name: str
    where: str
    error: float
    elsewhere: float | None


def worst_of(comparisons: Sequence[ComparisonData], gages: bool = True) -> list[Worst]:
    """The worst of each group over all comparisons; gages are left out where there are none."""
    found = []
    for group, quantities in GROUPS.items():
        every = [
            (spread.greatest, name, where)
            for each in comparisons
            for where, side in (("motion", each.equal_motion), ("force", each.equal_force))
            if side is not None and (gages or group != "gages")
            for quantity, name in quantities.items()
            if (spread := side.spread(quantity)) is not None
        ]
        if every:
            error, name, where = max(every, key=lambda item: round(item[0], 9))  # first of equals
            other = [item[0] for item in every if item[2] != where]
            found.append(Worst(group, name, where, error, max(other, default=None)))
    return found


def advise(
    kind: Kind, comparisons: Sequence[ComparisonData], gages: bool = True
) -> tuple[Verdict, str]:
    """Advice on an assumption from its comparisons: a verdict, its sentence."""
    worst = worst_of(comparisons, gages)
    if kind == "reading":
        worst = [each for each in worst if each.group == "gages"]
    if not worst:
        raise ValueError("nothing was compared, so there is nothing to advise")
    good, dear = _split(worst, KEEP)
    fair, bad = _split(dear, LIMIT)
    verdict: Verdict = "keep" if good == worst else "drop" if bad == worst else "limited"
    if kind == "value" and dear:
        verdict = "measure"
    dearest = max(comparisons, key=lambda each: each.better.seconds)
    # good: up to KEEP; fair: up to LIMIT; bad: above; dear: fair or bad.
    of: dict[str, Any] = {
        "verdict": verdict,
        "most": max(worst, key=lambda each: each.error),
        "good": good,
        "dear": dear,
        "fair": fair,
        "bad": bad,
        "one_way": _one_way(dear),
        "seconds": (dearest.assumed.seconds, dearest.better.seconds),
        "worth": _WORTH,
    }
    return verdict, paragraphs(WORDS, kind, of=of)[0]


def _split(worst: Sequence[Worst], bound: float) -> tuple[list[Worst], list[Worst]]:
    """Errors up to a bound, and those above it."""
    good = [each for each in worst if each.error <= bound]
    return good, [each for each in worst if each.error > bound]


def _one_way(dear: Sequence[Worst]) -> dict[str, list[Worst]]:
    """Errors at equal motion, and at equal force, that are small at the other of the two.

    Forces are left out: they are equal at equal force, whatever the model.
    """
    small = [each for each in dear if each.elsewhere is not None and each.elsewhere <= KEEP]
    found = [each for each in small if each.group != "forces"]
    return {at: [each for each in found if each.where == at] for at in ("motion", "force")}
