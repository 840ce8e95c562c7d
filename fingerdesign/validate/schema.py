"""The JSON schema of validate.json, shipped as fingerdesign/data/validate.schema.json.

``python -m fingerdesign.validate.schema`` writes the shipped copy anew.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fingerdesign.analysis.fidelity.readings import QUANTITIES
from fingerdesign.validate.assumptions import ASSUMPTIONS
from fingerdesign.validate.record import SCHEMA_VERSION

SHIPPED = Path(__file__).resolve().parent.parent / "data" / "validate.schema.json"

_TEXT: dict[str, Any] = {"type": "string"}
_COUNT = {"type": "integer", "minimum": 0}
_SIZE = {"type": "number", "minimum": 0}
_NUMBERS = {"type": "array", "items": {"type": "number"}}


def validation_schema() -> dict[str, Any]:
    """The schema: all keys are there, no others."""
    spread = _object(
        {"greatest": _SIZE, "median": _SIZE},
        "parts of one, over the path; null: prescribed, or cannot differ",
    )
    side = _object(
        {
            "rows": _COUNT,
            "rows_left_out": _COUNT,
            "note": _TEXT,
            "errors": _object(dict.fromkeys(QUANTITIES, _or_null(spread))),
            "gages": {"type": "array", "items": _SIZE, "description": "greatest of each gage"},
        },
        "null where it cannot be had",
    )
    answer = _object(
        {
            "model": _TEXT,
            "dimension": {"enum": [2, 3]},
            "dofs": _COUNT,
            "seconds": _SIZE,
            "normal_force_N": _NUMBERS,
            "tangential_force_N": _NUMBERS,
            "contact_width_mm": _NUMBERS,
            "stick_ratio": _NUMBERS,
            "gages_microstrain": {"type": "array", "items": _NUMBERS},
        }
    )
    comparison = _object(
        {
            "label": _TEXT,
            "assumed": answer,
            "better": answer,
            "equal_motion": _or_null(side),
            "equal_force": _or_null(side),
            "missing": {"type": "array", "items": _TEXT},
        }
    )
    place = _object({"z_mm": _SIZE, "greatest": _SIZE, "median": _SIZE, "gages": _NUMBERS})
    row = _object(
        {
            "assumption": {"enum": [each.key for each in ASSUMPTIONS]},
            "title": _TEXT,
            "assumed": _TEXT,
            "better": _TEXT,
            "kind": {"enum": ["model", "value", "reading"]},
            "tested": {"type": "boolean"},
            "reason": _or_null({**_TEXT, "description": "why it was not tested"}),
            "seconds": _or_null(_SIZE),
            "better_seconds": _or_null(_SIZE),
            "saving": _or_null(_SIZE),
            "equal_motion": _or_null(side),
            "equal_force": _or_null(side),
            "verdict": {"enum": ["keep", "limited", "drop", "measure", "not tested"]},
            "advice": _TEXT,
            "comparisons": {"type": "array", "items": comparison},
            "along_z": _or_null({"type": "array", "items": place}),
        }
    )
    whole = _object(
        {
            "schema_version": {"const": SCHEMA_VERSION},
            "design": _TEXT,
            "scene": _TEXT,
            "digest": _TEXT,
            "status": {"enum": ["ok", "failed"], "description": "failed: see failure"},
            "failure": _or_null({**_TEXT, "description": "a model failed and no row was told"}),
            "deep": {"type": "boolean"},
            "gages": _COUNT,
            "thresholds": _object({"keep": _SIZE, "limit": _SIZE}),
            "assumptions": {"type": "array", "items": row},
            "seconds": _SIZE,
            "peak_memory_MB": _SIZE,
            "versions": {"type": "object", "additionalProperties": _TEXT},
        }
    )
    dialect = "https://json-schema.org/draft/2020-12/schema"
    title = "What each modelling assumption costs (fingerdesign validate)"
    return {"$schema": dialect, **whole, "title": title}


def schema_text() -> str:
    """The schema the way it is shipped."""
    return json.dumps(validation_schema(), indent=2) + "\n"


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
