"""The CAD kernel at work in a process of its own: a finger's triangles, a finger's CAD files.

The kernel is native code, and its work grows with the design: 15 plates take 0.1 s, 200 take 2 s,
200 with 38 holes each a minute, and a STEP file may hold anything. So it runs under a time limit
where it can harm nobody. (Whoever holds the CadQuery solid itself calls ``solid.build_solid``.)
Importing this module loads no CAD kernel.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import GeometryError
from fingerdesign.layout.frames import Hole, PlateFrame
from fingerdesign.runtime.process import ProcessError, run_module

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


WORKER = "fingerdesign.cad.solid_worker"
TIME_LIMIT_S = 120.0  # thirty times what 200 plates take


@dataclass(frozen=True)
class FingerTriangles:
    """A finger's faces as triangles at one chord tolerance; vertices (n, 3) in mm.

    vertices, triangles              of elastomer, plates and core: faces that they share come once
    outer_vertices, outer_triangles  of the closed outside alone, wound outward
    """

    vertices: Array
    triangles: IntArray
    outer_vertices: Array
    outer_triangles: IntArray


def finger_triangles(
    design: Design,
    chord_tolerance_mm: float,
    half: bool = False,
    frames: tuple[PlateFrame, ...] | None = None,
    time_limit_s: float = TIME_LIMIT_S,
) -> FingerTriangles:
    """Build a finger (its half z >= 0) and triangulate it; arguments as of ``build_solid``.

    GeometryError where it cannot be built, or where the kernel crashes or exceeds the time limit;
    then the request is kept, and the message says where.
    """
    request: dict[str, Any] = {"half": half, "chord_tolerance_mm": chord_tolerance_mm}
    if frames is not None:
        request["frames"] = [asdict(frame) for frame in frames]
    with _answered(design, request, time_limit_s) as folder, np.load(folder / "out.npz") as data:
        return FingerTriangles(*(data[name] for name in FingerTriangles.__dataclass_fields__))


def write_finger_cad(
    design: Design,
    folder: Path | str,
    chord_tolerance_mm: float = 0.01,
    time_limit_s: float = TIME_LIMIT_S,
) -> dict[str, Path]:
    """Build a finger and write its STEP and STL files as ``export.write_cad`` does, in a process.

    Returns the paths by file name. Errors as of ``finger_triangles``.
    """
    target = Path(folder).resolve()
    request = {"cad": str(target), "chord_tolerance_mm": chord_tolerance_mm}
    with _answered(design, request, time_limit_s) as home:
        names = json.loads((home / "files.json").read_text("utf-8"))
    return {name: target / name for name in names}


def frames_of(plates: list[dict[str, Any]]) -> tuple[PlateFrame, ...]:
    """Frames from their fields, as a request holds them."""
    return tuple(
        PlateFrame(**{**plate, "holes": tuple(Hole(**hole) for hole in plate["holes"])})
        for plate in plates
    )


@contextmanager
def _answered(design: Design, request: dict[str, Any], time_limit_s: float) -> Iterator[Path]:
    """The folder in which the worker has answered; removed afterwards, unless the kernel failed."""
    folder = Path(tempfile.mkdtemp(prefix="fingerdesign-solid-"))
    whole = {"design": design.model_dump(mode="json"), **request}
    try:
        (folder / "request.json").write_text(json.dumps(whole), "utf-8")
        run_module(WORKER, [str(folder)], folder, time_limit_s)
        refused = folder / "error.txt"
        if refused.exists():
            raise GeometryError(refused.read_text("utf-8"))
        yield folder
    except ProcessError as error:  # the request stays for whoever looks into it
        raise GeometryError(
            f"the CAD kernel did not build {design.design.name}: {error}; the request is kept as "
            f"{folder / 'request.json'}"
        ) from error
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    shutil.rmtree(folder, ignore_errors=True)
