"""The process that reads STEP files: ``python -m fingerdesign.cad.step_worker FOLDER``.

In FOLDER it finds request.json, {"file": the path, "name": what to call it, "rules": [body.step]},
and leaves facts.npz (the faces as numpy computes with them, extents, volume) and outline.brep (the
solid, turned and moved), or fault.json with what is wrong with the file. Native code: it runs here,
alone, under the time limit of whoever started it.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.cad.step_rules import check_body, check_mirror, named, on_base, picks
from fingerdesign.errors import DesignError
from fingerdesign.runtime.process import MACHINE_FAILED, die_with_parent
from fingerdesign.shapes.faces import arrays_of, renamed


def main(arguments: Sequence[str]) -> int:
    """Read one file; 0 also where it is refused; ``MACHINE_FAILED`` for lack of disk or memory."""
    die_with_parent()
    try:
        answer(Path(arguments[0]))
    except (OSError, MemoryError) as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return MACHINE_FAILED
    return 0


def answer(folder: Path) -> None:
    """Answer the request in a folder."""
    request = json.loads((folder / "request.json").read_text("utf-8"))
    try:
        digest_step(request, folder)
    except DesignError as error:
        fault = error.faults[0]
        words = [fault.key, fault.value, fault.bound, fault.remedy]
        (folder / "fault.json").write_text(json.dumps(words), "utf-8")


def digest_step(request: dict[str, Any], folder: Path) -> None:
    """Read, turn, name, move, describe, keep. Raises DesignError for a file that will not do."""
    from OCP.BRepTools import BRepTools
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopoDS import TopoDS

    from fingerdesign.cad.step_read import describe, groups, middle
    from fingerdesign.cad.step_shape import TURNS, extent, moved, parts, read_solid, volume_of

    name, rules = request["name"], request["rules"]
    solid = moved(read_solid(request["file"], name), TURNS[rules["up"]], np.zeros(3))
    low, high = extent(solid)
    found = [describe(TopoDS.Face_s(face), name) for face in parts(solid, TopAbs_FACE)]
    shift = -on_base(found, low, rules)
    if rules["centre"]:
        sideways = -0.5 * (low + high) * np.array([1.0, 0.0, 1.0])
        # The kernel's extents are good to 1e-7: a body modelled about its middle stays exact.
        shift += np.where(np.abs(sideways) > 1e-6, sideways, 0.0)
    if shift.any():
        solid = moved(solid, TURNS["y"], shift)
        low, high = low + shift, high + shift
    faces = [TopoDS.Face_s(face) for face in parts(solid, TopAbs_FACE)]
    found = [describe(face, name) for face in faces]
    middles = np.array([middle(face, each.area) for face, each in zip(faces, found, strict=True)])
    normals = np.array(
        [each.normal(where[None])[0] for each, where in zip(found, middles, strict=True)]
    )
    base, contact = picks(found, middles, normals, rules)
    names = named(found, base, contact, low, high)
    joined = groups(solid, faces, found)
    found = [renamed(*row) for row in zip(found, names, joined, strict=True)]
    check_body(found, low, high, name)
    if rules["mirrors_in_z"]:
        check_mirror(found, name)
    about, arrays = arrays_of(found)
    outline = folder / "outline.brep"
    if not BRepTools.Write_s(solid, str(outline)):
        raise OSError("the CAD kernel could not write outline.brep")
    words = {"faces": about, "volume": volume_of(solid), "low": list(low), "high": list(high)}
    words["outline"] = hashlib.sha256(outline.read_bytes()).hexdigest()
    np.savez_compressed(
        folder / "facts.npz",
        about=np.array(json.dumps(words)),
        **arrays,  # type: ignore[arg-type]
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
