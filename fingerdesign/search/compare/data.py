"""What the comparison page carries as JSON: a light part of every design, a heavy one of each.

The light part (metrics, values, validity) is read when the page opens; the heavy one (the design,
traces, contact maps, shapes) only when a design is looked at or everything is downloaded.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

from fingerdesign.errors import all_shown
from fingerdesign.records.outcome import Outcome
from fingerdesign.search.compare.facts import StudyFacts, why_not
from fingerdesign.search.compare.figures import (
    contact_figure,
    forces_figure,
    gages_figure,
    looks,
    rounded,
    runs,
    shape_figure,
)
from fingerdesign.search.compare.geometry import packed_geometry
from fingerdesign.search.compare.recommend import Recommendation

READINGS = {
    "normal_force_N": "normal force (N)",
    "tangential_force_N": "tangential force (N)",
    "stick_ratio": "stick ratio",
    "contact_width_mm": "contact width (mm)",
    "approach_mm": "approach (mm)",
    "shear_mm": "shear (mm)",
}
_FIDELITY = {
    "plane-strain": "plane strain",
    "3d": "three dimensions",
    "auto": "chosen by tolerance",
}
_HEAVY = frozenset({"design", "traces", "grips", "schema_version"})


def page_data(
    outcomes: Sequence[Outcome],
    facts: StudyFacts,
    found: Recommendation,
    references: Sequence[int] = (),
) -> dict[str, Any]:
    """The light part: the study, how charts look, and every design in order.

    references: numbers of the designs that a search was to beat.
    """
    feasible, front = set(found.feasible), set(found.front)
    return {
        "looks": looks(),
        "study": {
            "name": all_shown(facts.name),
            "recommended": found.chosen,
            "pair": _pair(outcomes, found),
        },
        "designs": [
            _light(outcome)
            | {
                "feasible": number in feasible,
                "front": number in front,
                "kind": _kind(number, found, references),
                "marks": [
                    mark
                    for mark, holds in (
                        ("the reference", number in references),
                        ("recommended", number == found.chosen),
                        ("not feasible", number not in feasible),
                    )
                    if holds
                ],
                "missed": all_shown(list(missed)),
                "notes": all_shown(
                    [
                        *([f"not feasible, {'; '.join(missed)}."] if missed else []),
                        *(f"mind, {warning}" for warning in outcome.warnings),
                    ]
                ),
            }
            for number, outcome in enumerate(outcomes)
            for missed in [why_not(outcome, facts.objectives, facts.constraints)]
        ],
    }


def _kind(number: int, found: Recommendation, references: Sequence[int]) -> str:
    """How the chart of two measures shows a design that is not on their front."""
    if number in references:
        return "reference"
    if number == found.chosen:
        return "star"
    return "in" if number in found.feasible else "out"


def _pair(outcomes: Sequence[Outcome], found: Recommendation) -> list[int | None]:
    """The two that are chosen at first: the recommended design and the runner-up."""
    good = [number for number, outcome in enumerate(outcomes) if outcome.status == "ok"]
    first = next(iter(good), None) if found.chosen is None else found.chosen
    others = (number for number in good if number != first)
    second = next(others, None) if found.runner_up is None else found.runner_up
    return [first, second]


def detail(outcome: Outcome, frictions: Mapping[float, int]) -> dict[str, Any]:
    """The heavy part of one design, as it is drawn.

    For drawing alone: what the page offers for download is the outcome's own numbers.
    status: of each increment its characters run by run, "3.12#2/" for 3 open, 12 stick, 2 slip.
    """
    traces = outcome.traces
    geometry = packed_geometry(outcome.design, traces)
    found: dict[str, Any] = all_shown(
        {
            "size": geometry["size"],
            "words": f"{geometry['words']} {geometry['note']}".strip(),
            "figures": {
                "shape": shape_figure(geometry, bool(traces.contact_z_mm)),
                "contact": contact_figure(traces),
                "gages": gages_figure(traces),
                "forces": forces_figure(outcome, frictions),
            },
            "readings": {key: rounded(getattr(traces, key)) for key in READINGS},
            "count": max(len(traces.normal_force_N), len(traces.gages), len(traces.status)),
            "status": [runs(row) for row in traces.status],
            "belief": _belief(outcome),
            "mind": [*outcome.validity.sentences, *outcome.warnings],
        }
    )
    return found


def _belief(outcome: Outcome) -> list[tuple[str, str]]:
    """How far the numbers may be believed: what, and how far."""
    flat, mesh = outcome.validity.plane_strain_error, outcome.validity.mesh_error
    return [
        ("Computed in", _FIDELITY.get(outcome.fidelity, outcome.fidelity or "not known")),
        (
            "Plane strain overstates the normal force by",
            "not used" if outcome.fidelity == "3d" else _percent(flat),
        ),
        ("Error from the mesh", _percent(mesh)),
    ]


def _percent(share: float | None) -> str:
    return "not estimated" if share is None else f"{100 * share:.2g} %"


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
