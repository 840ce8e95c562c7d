"""The JSON schema of control.json, shipped as fingerdesign/data/control.schema.json.

``python -m fingerdesign.trials.schema`` writes the shipped copy anew.
"""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

from fingerdesign.control.metrics import Spread
from fingerdesign.control.plants.hardware import Hardware
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials.grid import Tug
from fingerdesign.trials.record import SCHEMA_VERSION
from fingerdesign.trials.run import VARIED

SHIPPED = Path(__file__).resolve().parent.parent / "data" / "control.schema.json"

_TEXT: dict[str, Any] = {"type": "string"}
_COUNT = {"type": "integer", "minimum": 0}
_SIZE = {"type": "number", "minimum": 0}
_SIZES = {"type": "array", "items": _SIZE}
_RATE = {"type": "number", "minimum": 0, "maximum": 1}


def control_schema() -> dict[str, Any]:
    """The schema: all keys are there, no others."""
    whole = _object(
        {
            "schema_version": {"const": SCHEMA_VERSION},
            "design": _TEXT,
            "digest": _TEXT,
            "status": {"const": "ok"},
            "grips": _COUNT,
            "criteria": _object(
                {
                    "most_force_ratio": _SIZE,
                    "human_margin": {**_SIZES, "minItems": 2, "maxItems": 2},
                    "good_amplifier_microstrain": _SIZE,
                }
            ),
            "conditions": _conditions(),
            "hardware": _hardware(),
            "model": _model(),
            "controllers": {"type": "array", "items": _controller()},
            "seconds": _object(dict.fromkeys(("model", "teaching", "grips", "whole"), _SIZE)),
            "workers": _COUNT,
            "peak_memory_MB": _SIZE,
            "warnings": {"type": "array", "items": _TEXT},
            "versions": {"type": "object", "additionalProperties": _TEXT},
        }
    )
    dialect = "https://json-schema.org/draft/2020-12/schema"
    title = "Controllers over friction, weight and noise (fingerdesign study-control)"
    return {"$schema": dialect, **whole, "title": title}


def schema_text() -> str:
    """The schema the way it is shipped."""
    return json.dumps(control_schema(), indent=2) + "\n"


def _conditions() -> dict[str, Any]:
    tug = {each.name: _SIZE for each in fields(Tug)} | {"noise_microstrain": _SIZE}
    return _object(
        {
            "friction_coefficients": _SIZES,
            "object_masses_g": _SIZES,
            "noises_microstrain": {**_SIZES, "description": "standard deviation of a sample"},
            "seed": _COUNT,
            "hold_s": {**_SIZE, "description": "held on after the lift"},
            "tug": _or_null(_object(tug, "null: no grip is tugged")),
        }
    )


def _hardware() -> dict[str, Any]:
    found = {each.name: _SIZE for each in fields(Hardware) if each.name != VARIED}
    return _object({**found, "dead_gages": {"type": "array", "items": _COUNT}})


def _model() -> dict[str, Any]:
    sizes = ("contact_size_mm", "preload_mm", "max_approach_mm")
    return _object(
        {
            "fidelity": {"const": "plane-strain"},
            "contact_nodes": _COUNT,
            "gages": _COUNT,
            "face": {"enum": ["upper", "lower", "both"]},
            "opposite": {"enum": ["mirror", "bare"]},
            **dict.fromkeys(sizes, _SIZE),
            "largest_bench_force_N": {**_SIZE, "description": "at max_approach_mm, without shear"},
            "preload_force_N": _SIZE,
        }
    )


def _controller() -> dict[str, Any]:
    summary = _summary()
    by_noise = {"noise_microstrain": _SIZE, **summary}
    return _object(
        {
            "controller": {"enum": list(CONTROLLERS.names())},
            "told": _or_null({**_TEXT, "description": "of the object; null: nothing"}),
            "whole_grid": _object(summary, "all noises together, tugged grips apart"),
            "by_noise": {"type": "array", "items": _object(by_noise)},
            "tugged": _or_null(_object(summary)),
        }
    )


def _summary() -> dict[str, Any]:
    rate = _or_null(_RATE)
    share = _object(
        {"count": _COUNT, "of": _COUNT, "rate": rate, "low": rate, "high": rate},
        "low, high: Wilson's 95 % interval; null of nothing",
    )
    parts = {each.name: _COUNT if each.name == "count" else _SIZE for each in fields(Spread)}
    spread = _or_null(_object(parts, "low, high: quartiles; null: no grip has the value"))
    counts = ("grips", "dropped", "crushed", "not_lifted", "failed")
    spreads = ("margin_at_lift", "peak_ratio", "peak_normal_force_N", "minimum_stick_ratio")
    return {
        **dict.fromkeys(counts, _COUNT),
        **dict.fromkeys(("success", "held", "answered"), share),
        **dict.fromkeys((*spreads, "slip_distance_mm", "steps", "reaction_steps"), spread),
    }


def _object(properties: dict[str, Any], words: str = "") -> dict[str, Any]:
    made = {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }
    return {**made, "description": words} if words else made


def _or_null(schema: dict[str, Any]) -> dict[str, Any]:
    return {"anyOf": [schema, {"type": "null"}]}


if __name__ == "__main__":
    SHIPPED.write_text(schema_text(), encoding="utf-8")
