"""The CAD files of one design, in a process that builds many (sweep/child.py)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def written(request: dict[str, Any]) -> str:
    """Write the CAD of request["design"] into the folder request["cad"]; JSON {"error": reason or
    ""}."""
    from fingerdesign.design.schema import Design
    from fingerdesign.errors import DesignError, GeometryError
    from fingerdesign.geometry.export import write_cad
    from fingerdesign.geometry.solid import build_solid

    try:
        solid = build_solid(Design.model_validate(request["design"]))
        files = write_cad(solid, Path(request["cad"]), request["chord_tolerance_mm"])
        check_whole(files["finger.step"])
    except (DesignError, GeometryError) as error:
        return json.dumps({"error": str(error)})
    return json.dumps({"error": ""})


def check_whole(step: Path) -> None:
    """GeometryError for a STEP file that was cut short: the kernel does not say that a disk is
    full."""
    from fingerdesign.errors import GeometryError

    with step.open("rb") as stream:
        stream.seek(max(0, step.stat().st_size - 100))
        if not stream.read().rstrip().endswith(b"END-ISO-10303-21;"):
            raise GeometryError(f"{step.name} was not written to its end: is the disk full?")
