"""The comparison in sentences: which finger, why, what is given up, and what to mind."""

import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.errors import shown
from fingerdesign.records.outcome import Outcome
from fingerdesign.records.verdict import Status, Verdict
from fingerdesign.report.page import sentences
from fingerdesign.report.table import Table, value_text
from fingerdesign.search.compare.recommend import (
    SHOWN,
    Objective,
    Recommendation,
    StudyFacts,
    differs,
    failed_verdicts,
    fails_purpose,
    passes,
    uncertainty,
)
from fingerdesign.search.compare.table import NONE, name_and_unit
from fingerdesign.search.study.metrics import METRICS, Metric

WORDS = Path(__file__).parent / "templates" / "words.txt.j2"
LARGE_ERROR = 0.1  # of plane strain: beyond it the order of designs may change
_ENDS = {"min": "lowest", "max": "highest"}
_FIDELITY = {"plane-strain": "in plane strain", "3d": "in 3-D", "finite": "at finite strain"}


@dataclass(frozen=True)
class Summary:
    """Head of the page.

    lead: the counts in short; verdicts: tiles of the first screen; recommended: name, "" where
    there is none; values: its values of what was varied, by their keys; table: its objectives.
    """

    lead: str
    counts: str
    verdicts: tuple[Verdict, ...]
    recommended: str
    why: str
    given_up: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    values: Mapping[str, str] = field(default_factory=dict)
    table: Table | None = None

    @property
    def words(self) -> str:
        """The recommended design and the reasons, or why there is none."""
        return f"Recommended: {self.recommended}. {self.why}" if self.recommended else self.why


def summary(outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation) -> Summary:
    """The page's head, from what is recommended."""
    of = _counted(outcomes, facts, found)
    counts = " ".join(sentences(WORDS, "counts", of))
    if facts.best_of:
        counts = f"{facts.best_of} outcomes, of which the best are compared. {counts}"
    lead = f"{of['all'] - of['failed']} of {of['all']} designs analysed"
    if facts.best_of:
        lead += f" · the best of {facts.best_of}"
    if found.group:
        lead += f" · scene {of['scene']} · {of['where']}"
    failed = [Verdict("warning", "failures", f"{of['failed']} of {of['all']} designs failed")]
    failed = failed if of["failed"] else []
    missing = tuple(map(shown, facts.missing))
    if found.chosen is None:
        why = " ".join(sentences(WORDS, "why_none", of))
        none = Verdict("fail", "no finger is recommended", "no design meets all that is required")
        return Summary(lead, counts, (none, *failed), "", why, warnings=missing)
    chosen = outcomes[found.chosen]
    objectives = [
        _objective(outcomes, facts, found, objective, best)
        for objective, best in zip(facts.objectives, found.best, strict=True)
    ]
    name = shown(chosen.name)
    warnings = [shown(warning) for warning in chosen.warnings]
    of |= {"fidelity": chosen.fidelity, "large": LARGE_ERROR}
    status: Status = "fail" if of["fails"] else "pass"
    tiles = [Verdict(status, "recommended", name, count=_rivals(found))]
    if facts.constraints:
        met = f"{of['meeting']} of {of['all'] - of['failed']} designs"
        tiles.append(Verdict("note", "meet the constraints", ", ".join(of["bounds"]), count=met))
    return Summary(
        lead,
        counts,
        (*tiles, *map(_tile, objectives), *failed),
        name,
        " ".join(sentences(WORDS, "why", of, objectives)),
        sentences(WORDS, "given_up", objectives),
        (*missing, *sentences(WORDS, "warnings_of", name, of, chosen.validity, warnings)),
        {shown(k): shown(value_text(v)) for k, v in chosen.values.items() if v is not None},
        _table(name, objectives),
    )


def _rivals(found: Recommendation) -> str:
    """Count those that the recommended one was chosen from."""
    group = len(found.group)
    if found.failing:
        return f"{group} of {group + len(found.failing)} feasible pass all verdicts"
    return f"{len(found.front)} of {group} on the front"


def _tile(each: dict[str, Any]) -> Verdict:
    """An objective of the recommended finger: a pass where others are compared and none is better;
    the best of those that fail verdicts, where that is better still."""
    own = f"{each['own']:.4g}"
    unsure = f" ± {each['unsure']:.2g}" if each["unsure"] else ""
    best = f"best {each['best']:.4g}" if each["better"] else ""
    if each["failing"] is not None:
        best = f"{each['failing']:.4g} fails verdicts"
    status: Status = "note" if best or each["count"] == 1 else "pass"
    return Verdict(status, each["words"], own + unsure, best, each["place"])


def _counted(
    outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation
) -> dict[str, Any]:
    """Count the designs that failed, meet the constraints, or lack a value."""
    good = [outcome for outcome in outcomes if outcome.status == "ok"]
    chosen = [] if found.chosen is None else [outcomes[found.chosen]]
    return _missed(good, facts) | {
        "failing": [shown(outcome.name) for outcome in good if failed_verdicts(outcome)],
        "passing": any(map(passes, good)),
        "fails": sum(map(failed_verdicts, chosen)),
        "all": len(outcomes),
        "failed": len(outcomes) - len(good),
        "bounds": [shown(each.words) for each in facts.constraints],
        "goals": [_goal(each) for each in facts.objectives],
        "assumed": facts.assumed_objectives,
        "kinds": len({(each.scene, each.fidelity) for each in good}),
        "front": len(found.front),
        "group": len(found.group),
        "scene": shown(found.scene),
        "where": _FIDELITY.get(found.fidelity, found.fidelity),
        "alike": [shown(outcomes[number].name) for number in found.alike],
        "same": [shown(outcomes[number].name) for number in found.same],
    }


def _missed(good: Sequence[Outcome], facts: StudyFacts) -> dict[str, Any]:
    """Count the designs that meet the constraints, and name what the others lack."""
    missed, bounded = Counter[str](), [bound.metric for bound in facts.constraints]
    metrics = dict.fromkeys(each.metric for each in facts.objectives)
    lacking: dict[str, list[str]] = {shown(metric): [] for metric in metrics}
    meeting, purposeless = 0, list[str]()
    for each in good:
        broken = [shown(b.words) for b in facts.constraints if b.broken_by(each)]
        absent = [metric for metric in metrics if each.metrics.get(metric) is None]
        meeting += not broken
        missed.update(broken)
        missed.update(f"a value of {shown(metric)}" for metric in absent)
        lacks = list(fails_purpose(each, bounded))
        missed.update(lacks)
        if lacks:
            purposeless.append(shown(each.name))
        for metric in map(shown, absent):
            lacking[metric].append(shown(each.name))
    return {"meeting": meeting, "lacking": lacking, "missed": missed, "purposeless": purposeless}


def _objective(
    outcomes: Sequence[Outcome],
    facts: StudyFacts,
    found: Recommendation,
    objective: Objective,
    best: int,
) -> dict[str, Any]:
    """An objective: the chosen one's value and place, and those of the front's best in it."""
    assert found.chosen is not None
    numbers = (found.chosen, best, *found.group)
    (own, other, *rest), deviation = (
        np.array([of(outcomes[number], objective.metric) for number in numbers])
        for of in (_metric, uncertainty)
    )
    values, unsure = np.array(rest), deviation[2:]
    differ = differs(values, unsure, own, deviation[0])
    ahead = int((differ & (values < own if objective.goal == "min" else values > own)).sum())
    metric = METRICS.get(objective.metric, Metric(objective.metric))
    end = min if objective.goal == "min" else max
    failing = end((_metric(outcomes[k], objective.metric) for k in found.failing), default=other)
    return {
        "goal": _goal(objective),
        "words": _words(objective),
        "own": own,
        "unsure": SHOWN * deviation[0],
        "place": _place(ahead, int((~differ).sum()), len(values), len(set(rest)) == 1),
        "best": other,
        "failing": failing if other != failing == end(failing, other) else None,
        "better": bool(differs(other, deviation[1], own, deviation[0])),
        "best_name": shown(outcomes[best].name),
        "rivals": {_words(each): _metric(outcomes[best], each.metric) for each in facts.objectives},
        "median": statistics.median(rest),
        "count": len(rest),
        "alike": len(set(rest)) == 1,
        "settled": not differs(values[:, None], unsure[:, None], values, unsure).any(),
        "leads": best == found.chosen and int((~differ).sum()) == 1,
        "grade": metric.grade(own) if metric.better == objective.goal else "",
    }


def _table(name: str, objectives: Sequence[dict[str, Any]]) -> Table:
    def row(each: dict[str, Any]) -> tuple[str, ...]:
        own, best, median = (f"{each[key]:.4g}" for key in ("own", "best", "median"))
        give = f" ± {each['unsure']:.2g}" if each["unsure"] else ""
        words = each["goal"], own + give, each["grade"] or NONE, each["place"], best, median
        return words[:width]

    count = objectives[0]["count"] if objectives else 0
    columns = ("objective", name, "on its scale", "place", "best", f"median of {count}")
    width = len(columns) if count > 1 else 3  # alone it is its own best and median
    rows = tuple(map(row, objectives))
    return Table("objectives", "The objectives", columns[:width], rows, frozenset({0}))


def _place(ahead: int, level: int, many: int, alike: bool) -> str:
    if many == 1:
        return "no other to compare"
    if level == many:
        return "the same for all" if alike else "no difference shown"
    return f"{ahead + 1} of {many}{f', with {level - 1} more' if level > 1 else ''}"


def _metric(outcome: Outcome, name: str) -> float:
    value = outcome.metrics[name]
    assert value is not None  # it is feasible
    return value


def _words(objective: Objective) -> str:
    title, unit = name_and_unit(objective.metric)
    return f"{title} ({unit})" if unit else title


def _goal(objective: Objective) -> str:
    return f"{_ENDS[objective.goal]} {_words(objective)}"
