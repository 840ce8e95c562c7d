"""One sentence of advice, made from the numbers.

Readings fall into three groups: forces, contact (its width and stick ratio) and gages. A group is
good where its greatest error over the path, at equal motion and at equal force, is at most KEEP,
and bad above LIMIT.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fingerdesign.validate.assumptions import Kind
    from fingerdesign.validate.comparison import Comparison
    from fingerdesign.validate.gages import AlongZ


# Errors in words: the same on the page, in the terminal and in advice.

MANY = 10.0  # from here on no percents
NONE = "–"  # prescribed, or nothing that could differ


def times(error: float) -> str:
    """For what is no matter of percents.

    >>> times(2612.3)
    '2,612 times'
    """
    return f"{error:,.0f} times"


def percent_cell(error: float) -> str:
    """A table's cell under "%".

    >>> percent_cell(0.259), percent_cell(1.615), percent_cell(2612.3)
    ('25.90', '162', '2,612 times')
    """
    if error >= MANY:
        return times(error)
    hundred = 100.0 * error
    return f"{hundred:.0f}" if hundred >= 99.5 else f"{hundred:.2f}"


def spread_cell(quantity: str, found: Mapping[str, float] | None) -> str:
    """The greatest error, the median in brackets.

    >>> spread_cell("gage", {"greatest": 0.259, "median": 0.257}), spread_cell("gage", None)
    ('25.90 (25.70)', '–')
    """
    if found is None:
        return NONE
    if quantity == "stick_ratio":
        return f"{found['greatest']:.3f} ({found['median']:.3f})"
    return f"{percent_cell(found['greatest'])} ({percent_cell(found['median'])})"


KEEP, LIMIT = 0.02, 0.10
GROUPS = {
    "forces": ("normal_force", "tangential_force"),
    "contact": ("contact_width", "stick_ratio"),
    "gages": ("gage",),
}
WORDS = {
    "normal_force": "F_n",
    "tangential_force": "F_t",
    "contact_width": "contact width",
    "stick_ratio": "stick ratio",
    "gage": "gage strain",
}
_WORTH = 1.5  # a saving below this factor is none: seconds vary as much between runs

Verdict = Literal["keep", "limited", "drop", "measure"]


@dataclass(frozen=True)
class Worst:
    """The greatest error of a group: of which quantity, where ("motion" or "force"), and its size.

    elsewhere: the greatest at the other of the two; None where that was not compared.
    """

    group: str
    quantity: str
    where: str
    error: float
    elsewhere: float | None

    @property
    def text(self) -> str:
        """For a sentence: "F_n 28 % at equal motion"."""
        return f"{WORDS[self.quantity]} {percent(self.error)} at equal {self.where}"


@dataclass(frozen=True)
class Advice:
    """A verdict and its sentence."""

    verdict: Verdict
    sentence: str


def percent(error: float) -> str:
    """Two digits: "0.31 %"; what rounds to nothing, or is no matter of percents, says so.

    >>> percent(0.0031), percent(0.284), percent(1.37), percent(1e-7), percent(5167.0)
    ('0.31 %', '28 %', '137 %', 'below 0.01 %', '5,167 times itself')
    """
    if error < 1e-4:
        return "below 0.01 %"
    if error >= MANY:
        return f"{times(error)} itself"
    hundred = 100.0 * error
    return f"{hundred:.0f} %" if hundred >= 9.95 else f"{hundred:.2g} %"


def factor_text(factor: float) -> str:
    """Two digits, no exponents."""
    return f"{factor:.0f}" if factor >= 9.95 else f"{factor:.2g}"


def seconds_text(seconds: float) -> str:
    """Two digits, no exponents.

    >>> seconds_text(0.031), seconds_text(1.26), seconds_text(141.0)
    ('0.031 s', '1.3 s', '141 s')
    """
    return f"{seconds:.0f} s" if seconds >= 9.95 else f"{seconds:.2g} s"


def worst_of(comparisons: Sequence[Comparison], gages: bool = True) -> list[Worst]:
    """The worst of each group over all comparisons; gages are left out where there are none."""
    found = []
    for group, quantities in GROUPS.items():
        if group == "gages" and not gages:
            continue
        every = [
            (error, quantity, where)
            for comparison in comparisons
            for where, side in (("motion", comparison.motion), ("force", comparison.force))
            if side is not None
            for quantity in quantities
            if (error := side.greatest(quantity)) is not None
        ]
        if not every:
            continue
        error, quantity, where = max(
            every, key=lambda item: round(item[0], 9)
        )  # the first of equals
        other = [item[0] for item in every if item[2] != where]
        found.append(Worst(group, quantity, where, error, max(other, default=None)))
    return found


def advise(kind: Kind, comparisons: Sequence[Comparison], gages: bool = True) -> Advice:
    """What to do about an assumption that these comparisons tell of."""
    worst = worst_of(comparisons, gages)
    if kind == "reading":
        worst = [each for each in worst if each.group == "gages"]
    if not worst:
        raise ValueError("nothing was compared, so there is nothing to advise")
    if kind == "reading":
        return _reading(worst[0].error)
    verdict = _verdict(worst, kind)
    sentence = _value_words(worst, verdict) if kind == "value" else _model_words(worst, verdict)
    return Advice(verdict, sentence + (f"; {_saving(comparisons)}." if kind == "model" else "."))


def _reading(error: float) -> Advice:
    """How a gage is read: one model tells both, so that nothing is saved."""
    reported = f"gage strains are off by up to {percent(error)}"
    if error <= KEEP:
        return Advice(
            "keep", f"Keep: {reported}; reading them as they are costs nothing more, though."
        )
    if error <= LIMIT:
        return Advice(
            "limited", f"Keep where it will do: {reported}; reading them as they are is free."
        )
    return Advice("drop", f"Drop it: {reported}; reading them as they are costs nothing more.")


def _verdict(worst: Sequence[Worst], kind: Kind) -> Verdict:
    most = max(each.error for each in worst)
    if most <= KEEP:
        return "keep"
    if kind == "value":
        return "measure"
    least = min(each.error for each in worst)
    return "drop" if least > LIMIT else "limited"


def off_middle(along_z: AlongZ) -> str:
    """A sentence on gages that do not lie in the middle of the depth."""
    place, side = along_z.z_mm[-1], along_z.sides[-1]
    error = percent(side.greatest("gage") or 0.0)
    return f"Gages at z = {place:.3g} mm read up to {error} otherwise than those in the middle."


def _model_words(worst: Sequence[Worst], verdict: Verdict) -> str:
    most = max(worst, key=lambda each: each.error)
    if verdict == "keep":
        return f"Keep: it costs {percent(most.error)} at the most ({_place(most)})"
    if verdict == "drop":
        return f"Drop it: {_list(worst)}"
    good = [each for each in worst if each.error <= KEEP]
    fair = [each for each in worst if KEEP < each.error <= LIMIT]
    bad = [each for each in worst if each.error > LIMIT]
    parts = []
    if good:
        parts.append(f"Keep for {_names(good)} ({_list(good)})")
    if fair:
        parts.append(f"{_first('keep', parts)} for {_names(fair)} where {_list(fair)} will do")
    if bad:
        parts.append(f"{_first('drop', parts)} it for {_names(bad)} ({_list(bad)})")
    return "; ".join(parts)


def _value_words(worst: Sequence[Worst], verdict: Verdict) -> str:
    most = max(worst, key=lambda each: each.error)
    if verdict == "keep":
        return f"No need to measure it: at the most {percent(most.error)} ({_place(most)})"
    open_ = [each for each in worst if each.error > KEEP]
    words = f"Measure it before trusting {_names(open_)} ({_list(open_)})"
    idle = [each for each in worst if each.error <= KEEP]
    words += f"; it hardly moves the {_names(idle)} ({_list(idle)})" if idle else ""
    one_way = [
        each
        for each in open_
        if each.elsewhere is not None and each.elsewhere <= KEEP and each.group != "forces"
    ]  # that forces are equal at equal force says nothing
    for where in ("motion", "force"):
        named = [each for each in one_way if each.where == where]
        other = "force" if where == "motion" else "motion"
        if named:
            words += f"; where the {other} is given, it hardly moves the {_names(named)}"
    return words


def _saving(comparisons: Sequence[Comparison]) -> str:
    """What is saved, in words and seconds, by the comparison that costs most."""
    most = max(comparisons, key=lambda each: each.better.seconds)
    cheap, dear = most.assumed.seconds, most.better.seconds
    factor = dear / max(cheap, 1e-9)
    seconds = f"{seconds_text(cheap)} instead of {seconds_text(dear)}"
    if factor < _WORTH:
        return f"it saves nothing ({seconds})"
    return f"it saves a factor {factor_text(factor)} ({seconds})"


def _place(worst: Worst) -> str:
    return f"{WORDS[worst.quantity]}, equal {worst.where}"


def _list(every: Sequence[Worst]) -> str:
    return ", ".join(each.text for each in every)


def _names(every: Sequence[Worst]) -> str:
    *first, last = [each.group for each in every]
    return f"{', '.join(first)} and {last}" if first else last


def _first(word: str, before: Sequence[str]) -> str:
    return word if before else word.capitalize()
