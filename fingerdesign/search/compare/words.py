"""The comparison in sentences: which finger, why, what is given up, and what to mind."""

import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fingerdesign.errors import shown
from fingerdesign.records.outcome import Outcome
from fingerdesign.report.page import sentences
from fingerdesign.report.table import Table
from fingerdesign.search.compare.recommend import Recommendation, StudyFacts, Wanted
from fingerdesign.search.compare.table import name_and_unit

WORDS = Path(__file__).parent / "templates" / "words.txt.j2"
LARGE_ERROR = 0.1  # of plane strain: beyond it the order of designs may change
_ENDS = {"min": "lowest", "max": "highest"}
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
    of = _counted(outcomes, facts, found)
    counts = " ".join(sentences(WORDS, "counts", of))
    if found.chosen is None:
        return Summary(counts, "", " ".join(sentences(WORDS, "why_none", of)), (), (), None)
    chosen = outcomes[found.chosen]
    objectives = [
        _objective(outcomes, facts, found, wanted, best)
        for wanted, best in zip(facts.objectives, found.best, strict=True)
    ]
    believed = chosen.validity
    warnings = [shown(warning) for warning in chosen.warnings]
    errors = believed.plane_strain_error, believed.mesh_error, LARGE_ERROR
    return Summary(
        counts,
        shown(chosen.name),
        " ".join(sentences(WORDS, "why", of, objectives)),
        sentences(WORDS, "given_up", objectives),
        sentences(WORDS, "mind", of | {"fidelity": chosen.fidelity}, *errors, warnings),
        _table(shown(chosen.name), objectives),
    )


def _counted(
    outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation
) -> dict[str, Any]:
    """What the sentences count: designs, those that meet what is asked, and those that lack it."""
    good = [outcome for outcome in outcomes if outcome.status == "ok"]
    lacking = {
        each.metric: [shown(o.name) for o in good if o.metrics.get(each.metric) is None]
        for each in facts.objectives
    }
    missed = Counter[str]()
    for each in good:
        missed.update(shown(b.words) for b in facts.constraints if not b.holds(each))
        missed.update(f"a value of {shown(m)}" for m in lacking if each.metrics.get(m) is None)
    return {
        "all": len(outcomes),
        "failed": len(outcomes) - len(good),
        "bounds": [shown(each.words) for each in facts.constraints],
        "meeting": sum(all(bound.holds(each) for bound in facts.constraints) for each in good),
        "lacking": {shown(metric): names for metric, names in lacking.items()},
        "missed": missed,
        "goals": [_goal(each) for each in facts.objectives],
        "assumed": facts.assumed_objectives,
        "kinds": len({(each.scene, each.fidelity) for each in good}),
        "front": len(found.front),
        "group": len(found.group),
        "scene": shown(found.scene),
        "where": _FIDELITY.get(found.fidelity, found.fidelity),
        "alike": [shown(outcomes[number].name) for number in found.alike],
    }


def _objective(
    outcomes: Sequence[Outcome],
    facts: StudyFacts,
    found: Recommendation,
    wanted: Wanted,
    best: int,
) -> dict[str, Any]:
    """An objective: the chosen one's value and place, and those of the front's best in it."""
    assert found.chosen is not None
    own, other = _value(outcomes[found.chosen], wanted), _value(outcomes[best], wanted)
    values = [_value(outcomes[number], wanted) for number in found.group]
    ahead = sum(value < own if wanted.goal == "min" else value > own for value in values)
    return {
        "goal": _goal(wanted),
        "words": _words(wanted),
        "own": own,
        "place": _place(ahead, values.count(own), len(values)),
        "best": other,
        "best_name": shown(outcomes[best].name),
        "rivals": {_words(each): _value(outcomes[best], each) for each in facts.objectives},
        "median": statistics.median(values),
        "settled": len(set(values)) == 1,
        "leads": best == found.chosen and values.count(other) == 1,
    }


def _table(name: str, objectives: Sequence[dict[str, Any]]) -> Table:
    def row(each: dict[str, Any]) -> tuple[str, ...]:
        own, best, median = (f"{each[key]:.4g}" for key in ("own", "best", "median"))
        return each["goal"], own, each["place"], best, median

    columns = ("objective", name, "place", "best", "median of all")
    rows = tuple(map(row, objectives))
    return Table("objectives", "The objectives", columns, rows, frozenset({0}))


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
