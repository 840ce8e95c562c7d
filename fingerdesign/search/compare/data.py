"""What the comparison page carries as JSON: a light part of every design, a heavy one of each.

The light part (metrics, values, validity) is read when the page opens; the heavy one (the design,
traces, contact maps, shapes) only when a design is looked at or everything is downloaded.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from itertools import groupby
from typing import Any

from fingerdesign.errors import all_shown
from fingerdesign.records.outcome import GripOutcome, Numbers, Outcome, Traces
from fingerdesign.search.compare.facts import StudyFacts, why_not
from fingerdesign.search.compare.geometry import packed_geometry
from fingerdesign.search.compare.recommend import Recommendation

# A design's path and grips as the comparison page draws them: few digits, status run by run.
#
# For drawing alone: what the page offers for download is the outcome's own numbers.

DIGITS = 4  # significant: a drawing is a thousand points wide


def packed_traces(traces: Traces) -> dict[str, Any]:
    """The keys of Traces, JSON-ready, numbers to DIGITS significant digits.

    status: of each increment its characters run by run, "3.12#2/" for 3 open, 12 stick, 2 slip.
    """
    found: dict[str, Any] = {
        name: rounded(getattr(traces, name))
        for name in (
            *("approach_mm", "shear_mm", "normal_force_N", "tangential_force_N", "stick_ratio"),
            *("contact_width_mm", "gage_x_mm", "contact_x_mm", "contact_z_mm"),
        )
    }
    found["gages"] = [rounded(readings) for readings in traces.gages]
    found["status"] = [runs(row) for row in traces.status]
    return found


def packed_grips(grips: Iterable[GripOutcome]) -> list[dict[str, Any]]:
    """What the page shows of each grip, JSON-ready; the path to DIGITS significant digits."""
    return [
        {
            "controller": grip.controller,
            "friction_coefficient": grip.friction_coefficient,
            "object_mass_g": grip.object_mass_g,
            "lifted": grip.lifted,
            "gross_slip": grip.gross_slip,
            "safety_margin": _number(grip.safety_margin),
            "peak_normal_force_N": _number(grip.peak_normal_force_N),
            "normal_force_N": rounded(grip.normal_force_N),
            "tangential_force_N": rounded(grip.tangential_force_N),
        }
        for grip in grips
    ]


def rounded(values: Numbers | Sequence[float | None]) -> list[float | int | None]:
    """To DIGITS significant digits, whole numbers without a point; what is no number is None.

    >>> rounded((1.23456, None, 120.0, 0.0, float("nan")))
    [1.235, None, 120, 0, None]
    """
    return [_number(value) for value in values]


def runs(status: str) -> str:
    """A row of characters as runs, each its length and the character.

    >>> runs("..##/"), runs("")
    ('2.2#1/', '')
    """
    return "".join(f"{len(list(group))}{character}" for character, group in groupby(status))


def unrolled(text: str) -> str:
    """What :func:`runs` was given.

    >>> unrolled("2.2#1/")
    '..##/'
    """
    return "".join(character * int(count) for count, character in re.findall(r"(\d+)(\D)", text))


def _number(value: float | None) -> float | int | None:
    if value is None or not math.isfinite(value):
        return None
    near = float(f"{value:.{DIGITS}g}")
    return int(near) if near == int(near) else near


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
