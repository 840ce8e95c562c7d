"""An optimisation's answer in sentences: who beats the reference, by how much, and what decides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from fingerdesign.report.compare_table import metric_title
from fingerdesign.sweep.plain_text import shown

if TYPE_CHECKING:
    from fingerdesign.sweep.confirm import Confirmation, Judged
    from fingerdesign.sweep.optimise_folder import Optimised

MOST_NAMED = 3
_MODEL = {"plane-strain": "in plane strain", "3d": "in 3-D"}


def verdict(found: Optimised) -> tuple[str, ...]:
    """Who dominates the reference and by how much, by both models; what the objectives hang on."""
    told = found.confirmation
    goals = {each.metric: each.direction for each in found.search.study.objectives}
    if told.thorough_reference is None:
        said = _quick(found, goals)
    else:
        said = _confirmed(told, told.thorough_reference, goals)
    return (*said, *_sensitivity(found))


def _quick(found: Optimised, goals: Mapping[str, str]) -> list[str]:
    """By the search's own model alone."""
    from fingerdesign.sweep.confirm import judged

    told, study = found.confirmation, found.search.study
    where = _where(study.study.fidelity)
    by_number = {each.number: each for each in found.tried}
    first = (*(n for n in told.front if n in told.dominating), *told.dominating)
    best = list(dict.fromkeys(first))
    fingers = [
        judged(study, by_number[n].outcomes[0].name, by_number[n].outcomes)
        for n in best[:MOST_NAMED]
    ]
    said = [_beats(own, told.reference, goals, where) for own in fingers]
    said += _more(len(best) - len(fingers))
    if not best:
        said.append(f"No trial dominates the reference, {shown(told.reference.name)}, {where}.")
    return [*said, "No more thorough model confirmed this."]


def _confirmed(told: Confirmation, deep: Judged, goals: Mapping[str, str]) -> list[str]:
    """By the thorough model, with the quick one's numbers beside."""
    where = _where(told.fidelity)
    if deep.failure:
        return [f"Nothing could be confirmed: the reference failed {where}: {shown(deep.failure)}"]
    said = []
    for each in told.standing[:MOST_NAMED]:
        quick = _against(each.quick, told.reference, goals)
        said.append(f"{_beats(each.thorough, deep, goals, where)} The search had seen {quick}.")
    said += _more(len(told.standing) - MOST_NAMED)
    if not told.standing:
        many = len(told.confirmed)
        of = "The one finger" if many == 1 else f"None of the {many} fingers"
        verb = "does not dominate" if many == 1 else "dominates"
        said.append(f"{of} analysed again {where} {verb} the reference, {shown(deep.name)}, there.")
        said += [
            f"{shown(each.thorough.name)}: {_against(each.thorough, deep, goals)}."
            for each in told.confirmed[:MOST_NAMED]
            if not each.thorough.failure
        ]
    return said


def _beats(own: Judged, reference: Judged, goals: Mapping[str, str], where: str) -> str:
    how = ", better in every objective" if own.better_in_all(reference) else ""
    return (
        f"{shown(own.name)} dominates the reference, {shown(reference.name)}, {where}{how}: "
        f"{_against(own, reference, goals)}."
    )


def _against(own: Judged, reference: Judged, goals: Mapping[str, str]) -> str:
    """As "stick error 0.05 against 0.1 (50 % lower)", of each objective."""
    return ", ".join(
        _one(metric, own.metrics.get(metric), reference.metrics.get(metric), goal)
        for metric, goal in goals.items()
    )


def _one(metric: str, own: float | None, other: float | None, goal: str) -> str:
    title = metric_title(metric)
    if own is None or other is None:
        return f"{title} unknown"
    if own == other:
        return f"{title} {own:.4g} as there"
    way = "lower" if own < other else "higher"
    much = f"{100 * abs(own - other) / abs(other):.3g} % {way}" if other else way
    worse = "" if (own < other) == (goal == "min") else ", worse"
    return f"{title} {own:.4g} against {other:.4g} ({much}{worse})"


def _sensitivity(found: Optimised) -> list[str]:
    """What each objective hangs on most, or why that is not known."""
    from fingerdesign.sweep.sensitivity import LEAST

    said = []
    unknown = []
    for each in found.sensitivities:
        if each.explained is None or not each.effects:
            unknown.append(each)
            continue
        first = max(each.effects, key=lambda effect: effect.share)
        way = ""
        if first.direction is not None:
            way = ", rising with it" if first.direction > 0 else ", falling with it"
        said.append(
            f"{metric_title(each.metric).capitalize()} hangs most on {shown(first.parameter)} "
            f"({100 * first.share:.0f} % of its variance{way}): see the table of the search."
        )
    few = [each for each in unknown if each.count < LEAST]
    if few:
        names = _and([metric_title(each.metric) for each in few])
        counts = min(each.count for each in few)
        trials = "1 trial is" if counts == 1 else f"{counts} trials are"
        said.append(f"What {names} hangs on is not told: {trials} too few, {LEAST} are needed.")
    level = [each for each in unknown if each.count >= LEAST]
    if level:
        names = _and([metric_title(each.metric) for each in level])
        said.append(f"What {names} hangs on is not told: it is the same in all trials.")
    return said


def _more(count: int) -> list[str]:
    if count <= 0:
        return []
    return ["One more dominates it too." if count == 1 else f"{count} more dominate it too."]


def _where(fidelity: str) -> str:
    return _MODEL.get(fidelity, f"by {fidelity}")


def _and(parts: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))
