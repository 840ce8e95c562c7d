"""An optimisation in sentences: who beats the reference, and what each objective depends on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fingerdesign.errors import shown
from fingerdesign.records.verdict import Status, Verdict
from fingerdesign.search.compare.table import name_and_unit
from fingerdesign.search.optimise.confirm import Judged, Optimised, many
from fingerdesign.search.optimise.sensitivity import LEAST, Sensitivity

MOST_NAMED = 3
_PLACES = {"plane-strain": "in plane strain", "3d": "in 3-D"}


def _title(metric: str) -> str:
    return name_and_unit(metric)[0]


def _place(found: Optimised) -> str:
    """The most thorough model in words: "in 3-D"."""
    fidelity = found.fidelity or found.search.study.study.fidelity
    return _PLACES.get(fidelity, f"by {fidelity}")


def tile(found: Optimised) -> Verdict:
    """The comparison with the reference as a verdict."""
    deep, at = found.thorough_reference, _place(found)
    if deep is None:
        count = f"{len(found.dominating)} of {len(found.judged)} trials"
        good: Status = "warning" if found.needs_confirming else "pass"
        where = f"{at}, not confirmed" if found.needs_confirming else at
        if found.dominating and all(found.judged[k - 1].fails for k in found.dominating):
            good, where = "warning", f"{at}, but all fail verdicts"
        return Verdict(
            good if found.dominating else "fail", "better than the reference", count, where
        )
    if deep.failure:
        return Verdict("fail", "better than the reference", "unknown: the reference failed", at)
    count = f"{len(found.standing)} of {len(found.confirmed)} confirmed"
    return Verdict("pass" if found.standing else "fail", "better than the reference", count, at)


def reference_sentences(found: Optimised) -> Iterator[str]:
    """Who dominates the reference and by how much, by both models."""
    deep, at = found.thorough_reference, _place(found)
    if deep is None:
        known = [(found.judged[number - 1], number in found.front) for number in found.dominating]
        known.sort(key=lambda each: (each[0].fails > 0, not each[1]))
        best = [own for own, _ in known]
        for own in best[:MOST_NAMED]:
            yield _dominates(found, own, found.reference, at)
        yield from _more(len(best) - MOST_NAMED)
        if not best:
            yield f"No trial dominates the reference, {shown(found.reference.name)}, {at}."
        if found.needs_confirming:
            yield "No more thorough model confirmed this."
    elif deep.failure:
        failure = shown(deep.failure)
        yield f"Nothing could be confirmed: the reference failed {at}: {failure}"
    elif found.standing:
        for each in found.standing[:MOST_NAMED]:
            before = _against(found, each.quick, found.reference)
            yield f"{_dominates(found, each.thorough, deep, at)} The search had seen {before}."
        yield from _more(len(found.standing) - MOST_NAMED)
    else:
        yield from _none_stands(found, deep, at)


def _none_stands(found: Optimised, deep: Judged, at: str) -> Iterator[str]:
    """No confirmed finger dominates the reference."""
    count = len(found.confirmed)
    none = f"None of the {count} fingers analysed again {at} dominates"
    if count == 1:
        none = f"The one finger analysed again {at} does not dominate"
    yield f"{none} the reference, {shown(deep.name)}, there."
    for each in found.confirmed[:MOST_NAMED]:
        if not each.thorough.failure:
            yield f"{shown(each.thorough.name)}: {_against(found, each.thorough, deep)}."


def _dominates(found: Optimised, own: Judged, reference: Judged, at: str) -> str:
    every = ", better in every objective" if own.better_in_all(reference) else ""
    fails = f" But it fails {many(own.fails, 'verdict', 'verdicts')}." if own.fails else ""
    return (
        f"{shown(own.name)} dominates the reference, {shown(reference.name)}, {at}{every}: "
        f"{_against(found, own, reference)}.{fails}"
    )


def _against(found: Optimised, own: Judged, other: Judged) -> str:
    """Each objective of two fingers: "stick error 0.05 against 0.1 (50 % lower)"."""
    return ", ".join(
        f"{_title(each.metric)} "
        + _compared(own.metrics.get(each.metric), other.metrics.get(each.metric), each.direction)
        for each in found.search.study.objectives
    )


def _compared(own: float | None, other: float | None, goal: str) -> str:
    if own is None or other is None:
        return "unknown"
    if own == other:
        return f"{own:.4g} as there"
    percent = f"{100 * abs(own - other) / abs(other):.3g} % " if other else ""
    worse = ", worse" if (own < other) != (goal == "min") else ""
    return f"{own:.4g} against {other:.4g} ({percent}{'lower' if own < other else 'higher'}{worse})"


def _more(count: int) -> Iterator[str]:
    if count > 0:
        yield "One more dominates it too." if count == 1 else f"{count} more dominate it too."


def _depends(found: Sensitivity) -> str:
    """The key that an objective depends on most."""
    first = max(found.effects, key=lambda effect: effect.share)
    way = ""
    if first.direction is not None:
        way = ", rising with it" if first.direction > 0 else ", falling with it"
    return (
        f"{_title(found.metric).capitalize()} depends most on {shown(first.parameter)} "
        f"({100 * first.share:.0f} % of its variance{way}): see the table of the search."
    )


def sensitivity_sentences(found: Sequence[Sensitivity]) -> Iterator[str]:
    """The key that each objective depends on most, or why it is not known."""
    unknown = [each for each in found if each.explained is None or not each.effects]
    yield from (_depends(each) for each in found if each not in unknown)
    if few := [each for each in unknown if each.count < LEAST]:
        least = min(each.count for each in few)
        have = f"{many(least, 'trial has', 'trials have')} {'it' if len(few) == 1 else 'both'}"
        if len(few) > 2:
            have = f"{many(least, 'trial has', 'trials have')} all of them"
        yield (f"It is not known on which keys {_depend(few)}: {have}, {LEAST} are needed.")
    if level := [each for each in unknown if each.count >= LEAST]:
        yield f"It is not known on which keys {_depend(level)}: all trials have the same value."


def _depend(some: Sequence[Sensitivity]) -> str:
    *first, last = (_title(each.metric) for each in some)
    return f"{', '.join(first)} and {last} depend" if first else f"{last} depends"


def shares_caption(found: Sequence[Sensitivity]) -> str:
    """The caption of the table of shares, with how far each may be believed."""
    known = ". ".join(each.words for each in found)
    return (
        f"What each objective depends on. {known}. Share: of the variance that goes with the "
        "parameter, alone or with others; direction: rank correlation, above 0 rising"
    )
