"""The JSON schema of mold_report.json, shipped as fingerdesign/data/mold.schema.json.

``python -m fingerdesign.mold.schema`` writes the shipped copy anew.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fingerdesign.mold.plan.plan import SIDES
from fingerdesign.mold.record import SCHEMA_VERSION

SHIPPED = Path(__file__).resolve().parent.parent / "data" / "mold.schema.json"

_TEXT: dict[str, Any] = {"type": "string"}
_COUNT = {"type": "integer", "minimum": 0}
_NUMBER = {"type": "number"}
_SIZE = {"type": "number", "minimum": 0}
_TEXTS = {"type": "array", "items": _TEXT}
_VECTOR = {"type": "array", "items": _NUMBER, "minItems": 3, "maxItems": 3}
_SIDE = {"enum": list(SIDES)}


def mold_schema() -> dict[str, Any]:
    """The schema: all keys are there, no others."""
    whole = _object(
        {
            "schema_version": {"const": SCHEMA_VERSION},
            "design": _TEXT,
            "digest": {**_TEXT, "description": "of finger, [mold] table and program"},
            "design_digest": {**_TEXT, "description": "of the finger alone, as in results"},
            "status": {"enum": ["ok", "failed"], "description": "failed: see failure"},
            "failure": _or_null({**_TEXT, "description": "what could not be built or failed"}),
            "process": _process(),
            "shrinkage": {**_SIZE, "description": "linear, of the rubber, share"},
            "scale": {**_SIZE, "description": "of the cavity over the finger"},
            "parts": _many(_part()),
            "plates": _many(_pattern()),
            "placements": _many(_placed()),
            "fixture": _many(_fixture()),
            "base": _base(),
            "checks": _many(_check()),
            "silicone": _or_null(_silicone()),
            "placement": _or_null(_placement()),
            "warnings": _TEXTS,
            "notes": _many(_object({"title": _TEXT, "steps": _TEXTS})),
            "bill": _many(_item()),
            "files": {**_TEXTS, "description": "names beside the record"},
            "timings_s": {"type": "object", "additionalProperties": _SIZE},
            "seconds": _SIZE,
            "peak_memory_MB": _SIZE,
            "versions": {"type": "object", "additionalProperties": _TEXT},
        }
    )
    dialect = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": dialect, **whole, "title": "A finger's mold (fingerdesign mold)"}


def schema_text() -> str:
    """The schema the way it is shipped."""
    return json.dumps(mold_schema(), indent=2) + "\n"


def _process() -> dict[str, Any]:
    limits = ("wall_mm", "feature_mm", "hole_mm", "slot_mm", "clearance_mm", "pin_mm")
    return _object(
        {
            "name": {"enum": ["sla", "fdm", "machined"]},
            "cure": {"enum": ["platinum", "condensation"]},
            "plate_fixture": {"enum": ["comb", "jig", "slots"]},
            "draft_deg": _SIZE,
            "chord_mm": _SIZE,
            "limits": _object(dict.fromkeys((*limits, "tolerance_mm"), _SIZE)),
            "comb": {"type": "object", "additionalProperties": _SIZE},
        }
    )


def _part() -> dict[str, Any]:
    printed = _object({"down": _VECTOR, "flat_area_mm2": _SIZE, "size_mm": _VECTOR})
    return _object(
        {
            "number": _COUNT,
            "name": _TEXT,
            "made": {"enum": ["process", "sheet", "metal", "silicone"]},
            "draw": _or_null({**_VECTOR, "description": "null: it stays with the finger"}),
            "order": {"type": "integer", "description": "lower ones are taken off before"},
            "size_mm": _VECTOR,
            "volume_mm3": _SIZE,
            "vertices": _COUNT,
            "triangles": _COUNT,
            "chord_mm": {**_SIZE, "description": "greatest distance to the exact surface"},
            "print": _or_null({**printed, "description": "as it lies in mold.3mf"}),
            "files": _TEXTS,
        }
    )


def _pattern() -> dict[str, Any]:
    return _object(
        {
            "name": _TEXT,
            "plates": {"type": "array", "items": _COUNT},
            "count": _COUNT,
            "material": _TEXT,
            "thickness_mm": _SIZE,
            "width_mm": _SIZE,
            "length_mm": {**_SIZE, "description": "with legs"},
            "bend_radius_mm": _or_null(_SIZE),
            "files": _TEXTS,
        }
    )


def _placed() -> dict[str, Any]:
    return _object(
        {
            "plate": _COUNT,
            "pattern": _TEXT,
            "x_mm": _NUMBER,
            "y_mm": _NUMBER,
            "z_mm": _NUMBER,
            "along": {"enum": ["x", "z"]},
            "angle_deg": _NUMBER,
            "span_mm": _SIZE,
            "held_at": {"type": "array", "items": _SIDE},
        }
    )


def _fixture() -> dict[str, Any]:
    return _object(
        {
            "side": _SIDE,
            "holding": {"enum": ["wall", "comb", "jig", "slots"]},
            "slots": _COUNT,
            "narrowest_slot_mm": _or_null(_SIZE),
            "shim_mm": _SIZE,
            "sheet_mm": _or_null(_SIZE),
            "shift_mm": _or_null(_NUMBER),
        }
    )


def _base() -> dict[str, Any]:
    """The base plate: seen from its back, x to the right, z up."""
    sizes = ("half_x_mm", "half_z_mm", "finger_half_x_mm", "finger_half_z_mm")
    hole = {
        "kind": {"enum": ["gate", "riser", "vent", "lock", "screw"]},
        "x_mm": _NUMBER,
        "z_mm": _NUMBER,
        "diameter_mm": {**_SIZE, "description": "inside, at the finger"},
        "outer_diameter_mm": {**_SIZE, "description": "at the plate's back"},
    }
    return _object({**dict.fromkeys(sizes, _SIZE), "holes": _many(_object(hole))})


def _check() -> dict[str, Any]:
    return _object(
        {
            "name": _TEXT,
            "part": {**_TEXT, "description": "empty: the mold as a whole"},
            "ok": {"type": "boolean"},
            "measured": _or_null(_NUMBER),
            "bound": _or_null(_NUMBER),
            "unit": _TEXT,
            "sentence": _TEXT,
        }
    )


def _silicone() -> dict[str, Any]:
    volumes = ("finger_cm3", "locks_cm3", "gate_risers_vents_cm3", "flash_cm3", "mixed_cm3")
    others = ("excess", "density_g_cm3", "mass_g")
    return _object({**dict.fromkeys((*volumes, *others), _SIZE), "sentence": _TEXT})


def _placement() -> dict[str, Any]:
    """Its numbers are there where ``reason`` is null."""
    return {
        "type": "object",
        "properties": {"reason": _or_null(_TEXT), "sentences": _TEXTS},
        "required": ["reason", "sentences"],
    }


def _item() -> dict[str, Any]:
    texts = ("item", "made", "material", "size", "files")
    return _object({**dict.fromkeys(texts, _TEXT), "count": _COUNT, "mass_g": _or_null(_SIZE)})


def _object(properties: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


def _many(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


def _or_null(schema: dict[str, Any]) -> dict[str, Any]:
    return {"anyOf": [schema, {"type": "null"}]}


if __name__ == "__main__":
    SHIPPED.write_text(schema_text(), encoding="utf-8")
