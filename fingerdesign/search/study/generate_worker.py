"""The CAD files of one design, in a process that builds many (runtime/child.py)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, GeometryError


def written(request: dict[str, Any]) -> str:
    """Write the CAD of request["design"] into the folder request["cad"]; JSON {"error": reason or
    ""}."""
    from fingerdesign.cad.export import write_cad
    from fingerdesign.cad.solid import build_solid

    try:
        solid = build_solid(Design.model_validate(request["design"]))
        write_cad(solid, Path(request["cad"]), request["chord_tolerance_mm"])
    except (DesignError, GeometryError) as error:
        return json.dumps({"error": str(error)})
    return json.dumps({"error": ""})
