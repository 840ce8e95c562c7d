"""The comparison in sentences: which finger, why, what is given up, and what to mind."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from fingerdesign.errors import shown
from fingerdesign.records.outcome import Outcome
from fingerdesign.report.table import Table
from fingerdesign.search.compare.facts import StudyFacts, Wanted
from fingerdesign.search.compare.recommend import Recommendation
from fingerdesign.search.compare.table import NONE, name_and_unit

LARGE_ERROR = 0.1  # of plane strain: beyond it the order of designs may change
_ENDS = {"min": "lowest", "max": "highest"}
MOST_NAMES = 3  # in a sentence
_FIDELITY = {"plane-strain": "in plane strain", "3d": "in 3-D"}


@dataclass(frozen=True)
class Summary:
    """What heads the page. recommended: name, "" where there is none; table: its objectives."""

    counts: str
    recommended: str
    why: str
    given_up: tuple[str, ...]
    mind: tuple[str, ...]
    table: Table | None


def summary(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> Summary:
    """The page's head, from what is recommended."""
    counts = _counts(outcomes, facts, found)
    if found.chosen is None:
        return Summary(counts, "", _why_none(outcomes, facts, found), (), (), None)
    chosen = outcomes[found.chosen]
    return Summary(
        counts,
        shown(chosen.name),
        _why(outcomes, facts, found),
        tuple(_given_up(outcomes, facts, found)),
        tuple(_mind(outcomes, facts, found)),
        _table(outcomes, facts, found),
    )


def _counts(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> str:
    failed = sum(outcome.status == "failed" for outcome in outcomes)
    said = f"{_many(len(outcomes), 'design')}: {len(outcomes) - failed} analysed, {failed} failed."
    if facts.constraints:
        bounds = " and ".join(shown(each.words) for each in facts.constraints)
        meeting = len(_meeting(outcomes, facts))
        said += f" {meeting} {'meets' if meeting == 1 else 'meet'} the constraints ({bounds})."
    said += "".join(f" {each}" for each in _left_out(outcomes, facts))
    if found.front:
        of = f"{len(found.front)} of {len(found.group)}"
        verb = "is" if len(found.front) == 1 else "are"
        where = _FIDELITY.get(found.fidelity, found.fidelity)
        said += (
            f" {of} (scene {shown(found.scene)}, {where}) {verb} on the Pareto front of "
            f"{_list([_goal(each) for each in facts.objectives])}: no other is at least as good in "
            "every objective and better in one."
        )
    return said


def _meeting(outcomes: Sequence[Outcome], facts: StudyFacts) -> list[Outcome]:
    """The analysed ones that meet every constraint."""
    return [
        outcome
        for outcome in outcomes
        if outcome.status == "ok" and all(bound.holds(outcome) for bound in facts.constraints)
    ]


def _left_out(outcomes: Sequence[Outcome], facts: StudyFacts) -> list[str]:
    """For each objective the designs that have no value of it, and so were not compared."""
    said = []
    for wanted in facts.objectives:
        names = [
            shown(outcome.name)
            for outcome in outcomes
            if outcome.status == "ok" and outcome.metrics.get(wanted.metric) is None
        ]
        if names:
            one = len(names) == 1
            lack, were = ("lacks", "was") if one else ("lack", "were")
            said.append(
                f"{_many(len(names), 'design')} {lack} {shown(wanted.metric)} and {were} left out "
                f"({_some(names)})."
            )
    return said


def _settled(
    outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation
) -> list[tuple[Wanted, float]]:
    """The objectives that are the same for all that were compared, and their value."""
    values = [
        (wanted, {_value(outcomes[number], wanted) for number in found.group})
        for wanted in facts.objectives
    ]
    return [(wanted, each.pop()) for wanted, each in values if len(each) == 1]


def _why_none(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> str:
    good = [outcome for outcome in outcomes if outcome.status == "ok"]
    if not good:
        return "No finger is recommended: no design was analysed."
    if not facts.objectives:
        return "No finger is recommended: nothing says what is wanted. Name objectives."
    missed = Counter[str]()
    for outcome in good:
        missed.update(b.words for b in facts.constraints if not b.holds(outcome))
        missed.update(
            f"a value of {each.metric}"
            for each in facts.objectives
            if outcome.metrics.get(each.metric) is None
        )
    parts = [f"{shown(words)} ({many} of {len(good)} miss it)" for words, many in missed.items()]
    return f"No finger is recommended: no design has all of {_list(parts)}."


def _why(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> str:
    if len(found.group) == 1:
        many = sum(outcome.status == "ok" for outcome in outcomes)
        only = "that could be compared"
        if many > 1 and len(_meeting(outcomes, facts)) == 1 and facts.constraints:
            only = "that meets the constraints"
        return f"It is the only one {only}: take it for what it is."
    settled = _settled(outcomes, facts, found)
    if len(settled) == len(facts.objectives):
        return (
            f"All {len(found.group)} are alike in every objective, so that nothing decides: it is "
            "but the first of them."
        )
    same = "".join(
        f" All have the same {_words(wanted)}, {_number(value)}: it decides nothing."
        for wanted, value in settled
    )
    if len(found.front) == 1:
        return f"No other is better in any objective, and each is worse in one.{same}"
    alike = ""
    if found.alike:
        names = _some([shown(outcomes[number].name) for number in found.alike])
        alike = f" {names} would do as well by that measure."
    leads = [
        _goal(wanted)
        for wanted, best in zip(facts.objectives, found.best, strict=True)
        if best == found.chosen
        and sum(
            _value(outcomes[number], wanted) == _value(outcomes[best], wanted)
            for number in found.group
        )
        == 1
    ]
    leading = f" It leads in {_list(leads)}." if leads else ""
    return (
        "Of the front it is the one nearest to the best in every objective at once, each scaled by "
        f"its range over the front, none weighing more than another.{alike}{leading}{same}"
    )


def _given_up(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> list[str]:
    """For each objective in which another of the front is better: which, and by how much."""
    assert found.chosen is not None
    said = []
    for wanted, best in zip(facts.objectives, found.best, strict=True):
        own = _value(outcomes[found.chosen], wanted)
        other = _value(outcomes[best], wanted)
        if own == other:
            continue
        share = f" ({100 * abs(own / other - 1):.0f} % {_side(own, other)})" if other else ""
        rivals = ", ".join(
            f"{_words(each)} {_number(_value(outcomes[best], each))}"
            for each in facts.objectives
            if each != wanted
        )
        instead = f", at {rivals}" if rivals else ""
        said.append(
            f"{_words(wanted)}: {_number(own)}{share}, where {shown(outcomes[best].name)} has "
            f"{_number(other)}{instead}."
        )
    return said


def _mind(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> list[str]:
    assert found.chosen is not None
    chosen = outcomes[found.chosen]
    said = []
    if facts.assumed_objectives:
        wanted = _list([_goal(each) for each in facts.objectives])
        said.append(f"Nobody said what is wanted: {wanted} are the program's own choice.")
    error = chosen.validity.plane_strain_error
    if chosen.fidelity == "plane-strain" and (error is None or abs(error) > LARGE_ERROR):
        how = "unknown here" if error is None else f"about {100 * error:.0f} % in the normal force"
        said.append(f"It was analysed in plane strain, whose error is {how}: confirm it in 3-D.")
    mesh = chosen.validity.mesh_error
    if mesh is not None and mesh > LARGE_ERROR:
        said.append(f"Its model is estimated to be off by {100 * mesh:.0f} %: refine it.")
    groups = Counter((o.scene, o.fidelity) for o in outcomes if o.status == "ok")
    if len(groups) > 1:
        said.append(
            "Designs of other scenes or fidelities stand in the table too; they were not compared "
            "with it, as their numbers are not alike."
        )
    failed = sum(outcome.status == "failed" for outcome in outcomes)
    if failed > LARGE_ERROR * len(outcomes):
        said.append(f"{_many(failed, 'design')} failed: a better one may be among them.")
    return said + [f"Warned of: {shown(warning)}" for warning in chosen.warnings]


def _table(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> Table:
    assert found.chosen is not None
    rows = []
    for wanted, best in zip(facts.objectives, found.best, strict=True):
        values = [_value(outcomes[number], wanted) for number in found.group]
        own = _value(outcomes[found.chosen], wanted)
        ahead = sum(v < own if wanted.goal == "min" else v > own for v in values)
        rows.append(
            (
                _goal(wanted),
                _number(own),
                _place(ahead, values.count(own), len(values)),
                _number(_value(outcomes[best], wanted)),
                _number(statistics.median(values)),
            )
        )
    columns = ("objective", shown(outcomes[found.chosen].name), "place", "best", "median of all")
    return Table("objectives", "The objectives", columns, tuple(rows), frozenset({0}))


def _place(ahead: int, level: int, many: int) -> str:
    if level == many > 1:
        return "the same for all"
    return f"{ahead + 1} of {many}{f', with {level - 1} more' if level > 1 else ''}"


def _value(outcome: Outcome, wanted: Wanted) -> float:
    value = outcome.metrics[wanted.metric]
    assert value is not None  # it is feasible
    return value


def _words(wanted: Wanted) -> str:
    title, unit = name_and_unit(wanted.metric)
    return f"{title} ({unit})" if unit else title


def _goal(wanted: Wanted) -> str:
    return f"{_ENDS[wanted.goal]} {_words(wanted)}"


def _side(own: float, other: float) -> str:
    return "more" if own > other else "less"


def _number(value: float | None) -> str:
    return NONE if value is None else f"{value:.4g}"


def _many(count: int, word: str) -> str:
    return f"{count} {word}{'' if count == 1 else 's'}"


def _some(names: Sequence[str]) -> str:
    """The first of many names, and how many more."""
    more = len(names) - MOST_NAMES
    return _list(names) if more <= 0 else f"{', '.join(names[:MOST_NAMES])} and {more} more"


def _list(parts: Sequence[str]) -> str:
    if len(parts) < 2:
        return "".join(parts)
    return f"{', '.join(parts[:-1])} and {parts[-1]}"
