"""What the comparison page carries as JSON: a light part of every design, a heavy one of each.

The light part (metrics, values, validity) is read when the page opens; the heavy one (the design,
traces, contact maps, shapes) only when a design is looked at or everything is downloaded.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, fields
from typing import Any

from fingerdesign.sweep.outcome import Outcome
from fingerdesign.sweep.plain_text import all_shown
from fingerdesign.sweep.recommend import Recommendation
from fingerdesign.sweep.study_facts import StudyFacts, why_not

_HEAVY = frozenset({"design", "traces", "grips", "schema_version"})


def page_data(
    outcomes: Sequence[Outcome], facts: StudyFacts, found: Recommendation
) -> dict[str, Any]:
    """The light part: the study, its metrics and parameters, and every design in order."""
    feasible, front = set(found.feasible), set(found.front)
    return {
        "study": {
            "name": all_shown(facts.name),
            "objectives": all_shown([asdict(each) for each in facts.objectives]),
            "constraints": all_shown({each.metric: each.words for each in facts.constraints}),
            "recommended": found.chosen,
            "runner_up": found.runner_up,
            "record": all_shown(facts.record),
        },
        "metrics": all_shown([asdict(each) for each in facts.metrics]),
        "parameters": all_shown(parameters_of(outcomes)),
        "designs": [
            _light(outcome)
            | {
                "feasible": number in feasible,
                "front": number in front,
                "missed": all_shown(list(why_not(outcome, facts.objectives, facts.constraints))),
            }
            for number, outcome in enumerate(outcomes)
        ],
    }


def detail(outcome: Outcome) -> dict[str, Any]:
    """The heavy part of one design, as it is drawn."""
    from fingerdesign.report.compare_geometry import packed_geometry
    from fingerdesign.report.compare_traces import packed_grips, packed_traces

    design = all_shown(outcome.design)
    return {
        "design": design,
        "traces": packed_traces(outcome.traces),
        "grips": all_shown(packed_grips(outcome.grips)),
        "geometry": all_shown(packed_geometry(outcome.design)),
    }


def parameters_of(outcomes: Sequence[Outcome]) -> list[str]:
    """Every studied key, in the order met."""
    return list(dict.fromkeys(key for outcome in outcomes for key in outcome.values))


def script_json(value: Any) -> str:
    """JSON that can stand in a <script> element: nothing in it ends the element or opens another.

    >>> script_json({"name": "</script>"})
    '{"name":"\\\\u003c/script\\\\u003e"}'
    """
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))  # ASCII alone
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _light(outcome: Outcome) -> dict[str, Any]:
    kept = {
        item.name: getattr(outcome, item.name)
        for item in fields(outcome)
        if item.name not in _HEAVY
    }
    kept["failure"] = None if outcome.failure is None else asdict(outcome.failure)
    kept["validity"] = asdict(outcome.validity)
    cleaned: dict[str, Any] = all_shown(kept)
    return cleaned
