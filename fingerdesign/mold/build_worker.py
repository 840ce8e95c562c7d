"""The process that builds molds: ``python -m fingerdesign.mold.build_worker FOLDER``.

In FOLDER it finds request.json, {"design", "plan", "folder": for the CAD files}, and leaves
meshes.npz and meshes.json, or error.txt with the sentence of a GeometryError. It ends with
MACHINE_FAILED where the disk or the memory is full.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from fingerdesign.process import MACHINE_FAILED, die_with_parent


def main(arguments: Sequence[str]) -> int:
    """Answer one request; 0 also where the mold cannot be built."""
    die_with_parent()
    try:
        _answer(Path(arguments[0]))
    except (OSError, MemoryError) as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return MACHINE_FAILED
    return 0


def _answer(home: Path) -> None:
    request = json.loads((home / "request.json").read_text("utf-8"))
    from fingerdesign.design.schema import Design
    from fingerdesign.errors import DesignError, GeometryError
    from fingerdesign.mold.build import build_mold
    from fingerdesign.mold.built import plan_from, save_meshes
    from fingerdesign.mold.cad_files import all_meshed, write_files

    try:
        design, plan = Design.model_validate(request["design"]), plan_from(request["plan"])
        built = build_mold(design, plan)
        meshes = all_meshed(built, design.mold.chord_mm)
        write_files(design, plan, built, meshes, Path(request["folder"]))
        save_meshes(meshes, home)
    except (DesignError, GeometryError) as error:
        (home / "error.txt").write_text(str(error), "utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
