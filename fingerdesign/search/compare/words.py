"""The comparison in sentences: which finger, why, what is given up, and what to mind."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fingerdesign.errors import shown
from fingerdesign.records.outcome import Outcome
from fingerdesign.report.page import macros
from fingerdesign.report.table import Table
from fingerdesign.search.compare.facts import StudyFacts, Wanted
from fingerdesign.search.compare.recommend import Recommendation
from fingerdesign.search.compare.table import NONE, name_and_unit

_SENTENCES = Path(__file__).parent / "templates" / "words.txt.j2"
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


def _say(name: str, *values: Any) -> str:
    """A sentence of the template."""
    return str(getattr(macros(_SENTENCES), name)(*values))


def _counts(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> str:
    failed = sum(outcome.status == "failed" for outcome in outcomes)
    said = [_say("counted", len(outcomes), failed)]
    if facts.constraints:
        bounds = [shown(each.words) for each in facts.constraints]
        said.append(_say("meeting", len(_meeting(outcomes, facts)), bounds))
    said += _left_out(outcomes, facts)
    if found.front:
        where = _FIDELITY.get(found.fidelity, found.fidelity)
        goals = [_goal(each) for each in facts.objectives]
        count = len(found.front), len(found.group)
        said.append(_say("front", *count, shown(found.scene), where, goals))
    return " ".join(said)


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
            said.append(_say("left_out", len(names), shown(wanted.metric), _some(names)))
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
        return _say("none_analysed")
    if not facts.objectives:
        return _say("none_wanted")
    missed = Counter[str]()
    for outcome in good:
        missed.update(b.words for b in facts.constraints if not b.holds(outcome))
        missed.update(
            f"a value of {each.metric}"
            for each in facts.objectives
            if outcome.metrics.get(each.metric) is None
        )
    return _say(
        "none_has",
        [_say("missed", shown(words), many, len(good)) for words, many in missed.items()],
    )


def _why(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> str:
    if len(found.group) == 1:
        many = sum(outcome.status == "ok" for outcome in outcomes)
        alone = many > 1 and len(_meeting(outcomes, facts)) == 1 and bool(facts.constraints)
        return _say("only", alone)
    settled = _settled(outcomes, facts, found)
    if len(settled) == len(facts.objectives):
        return _say("level", len(found.group))
    same = [_say("same", _words(wanted), _number(value)) for wanted, value in settled]
    if len(found.front) == 1:
        return " ".join([_say("best"), *same])
    said = [_say("nearest")]
    if found.alike:
        said.append(_say("alike", _some([shown(outcomes[k].name) for k in found.alike])))
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
    if leads:
        said.append(_say("leads", leads))
    return " ".join([*said, *same])


def _given_up(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> list[str]:
    """For each objective in which another of the front is better: which, and by how much."""
    assert found.chosen is not None
    said = []
    for wanted, best in zip(facts.objectives, found.best, strict=True):
        own = _value(outcomes[found.chosen], wanted)
        other = _value(outcomes[best], wanted)
        if own == other:
            continue
        share = 100 * abs(own / other - 1) if other else None
        rivals = ", ".join(
            f"{_words(each)} {_number(_value(outcomes[best], each))}"
            for each in facts.objectives
            if each != wanted
        )
        rival = shown(outcomes[best].name), _number(other), rivals
        said.append(
            _say("given_up", _words(wanted), _number(own), share, _side(own, other), *rival)
        )
    return said


def _mind(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> list[str]:
    assert found.chosen is not None
    chosen = outcomes[found.chosen]
    said = []
    if facts.assumed_objectives:
        said.append(_say("assumed", [_goal(each) for each in facts.objectives]))
    error = chosen.validity.plane_strain_error
    if chosen.fidelity == "plane-strain" and (error is None or abs(error) > LARGE_ERROR):
        said.append(_say("flat", error))
    mesh = chosen.validity.mesh_error
    if mesh is not None and mesh > LARGE_ERROR:
        said.append(_say("coarse", mesh))
    if len(Counter((o.scene, o.fidelity) for o in outcomes if o.status == "ok")) > 1:
        said.append(_say("groups"))
    failed = sum(outcome.status == "failed" for outcome in outcomes)
    if failed > LARGE_ERROR * len(outcomes):
        said.append(_say("failures", failed))
    return said + [_say("warned", shown(warning)) for warning in chosen.warnings]


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


def _some(names: Sequence[str]) -> str:
    """The first of many names, and how many more."""
    more = len(names) - MOST_NAMES
    if more > 0:
        return f"{', '.join(names[:MOST_NAMES])} and {more} more"
    return _say("listed", names)
