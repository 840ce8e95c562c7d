"""The process that builds solids: ``python -m fingerdesign.cad.solid_worker FOLDER``.

In FOLDER it finds request.json, {"design", "chord_tolerance_mm", and "half" and "frames", or "cad":
the folder for CAD files}, and leaves out.npz (triangles) or files.json (names of what it wrote), or
error.txt with the sentence of a GeometryError.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.cad.solid_process import frames_of
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, GeometryError
from fingerdesign.runtime.process import die_with_parent


def main(arguments: Sequence[str]) -> int:
    """Answer one request; 0 also where the design cannot be built."""
    die_with_parent()
    folder = Path(arguments[0])
    request = json.loads((folder / "request.json").read_text("utf-8"))
    try:
        answer(request, folder)
    except (DesignError, GeometryError) as error:
        (folder / "error.txt").write_text(str(error), "utf-8")
    return 0


def answer(request: dict[str, Any], folder: Path) -> None:
    """Build what is asked for and leave it in the folder."""
    from fingerdesign.cad.export import write_cad
    from fingerdesign.cad.solid import build_solid
    from fingerdesign.cad.tessellation import triangulate

    design, chord = Design.model_validate(request["design"]), request["chord_tolerance_mm"]
    if "cad" in request:
        files = write_cad(build_solid(design), request["cad"], chord)
        (folder / "files.json").write_text(json.dumps(list(files)), "utf-8")
        return
    plates = request.get("frames")
    frames = None if plates is None else frames_of(plates)
    solid = build_solid(design, request["half"], frames)
    vertices, triangles = triangulate(solid.parts, chord)
    outer_vertices, outer_triangles = triangulate([solid.outline], chord)
    np.savez(
        folder / "out.npz",
        vertices=vertices,
        triangles=triangles,
        outer_vertices=outer_vertices,
        outer_triangles=outer_triangles,
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
