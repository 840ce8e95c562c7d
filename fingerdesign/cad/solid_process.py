"""The CAD kernel at work in a process of its own: a finger's triangles, a finger's CAD files.

The kernel is native code, and its work grows with the design: 15 plates take 0.1 s, 200 take 2 s,
200 with 38 holes each a minute, and a STEP file may hold anything. So it runs under a time limit
where it can harm nobody. (Code that needs the CadQuery solid itself calls ``solid.build_solid``.)
Importing this module loads no CAD kernel.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, GeometryError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.runtime.isolate import ProcessError, call, concurrently

TIME_LIMIT_S = 120.0  # thirty times what 200 plates take
CHORD_MM = 0.01
_TRIANGLES = "fingerdesign.cad.export:build_triangles"
_WRITE = "fingerdesign.cad.export:build_and_write"


def finger_triangles(
    design: Design, chord_mm: float, half: bool, frames: tuple[PlateFrame, ...]
) -> tuple[tuple[Array, IntArray], tuple[Array, IntArray]]:
    """Build a finger (its half z >= 0) and triangulate it; arguments as of ``build_solid``.

    Vertices (n, 3), mm, and triangles of elastomer, plates and core, faces that they share once;
    then those of the closed outside alone, wound outward.
    GeometryError where it cannot be built, or where the kernel crashes or exceeds the time limit.
    """
    with _as_geometry_errors(design):
        whole = call(_TRIANGLES, design, chord_mm, half, frames, time_s=TIME_LIMIT_S)
    return whole[:2], whole[2:]


def write_finger_cad(design: Design, folder: Path | str) -> dict[str, Path]:
    """Build a finger and write its STEP and STL files as ``export.write_cad`` does, in a process.

    Returns the paths by file name. Errors as of ``finger_triangles``.
    """
    target = Path(folder).resolve()
    with finger_cad_concurrently(design, target) as wait:
        return {name: target / name for name in wait()}


@contextmanager
def finger_cad_concurrently(design: Design, folder: Path) -> Iterator[Callable[[], Any]]:
    """Write the CAD files concurrently with the block: the yielded function waits for them."""
    target = folder.resolve()
    with concurrently(_WRITE, design, target, CHORD_MM, time_s=TIME_LIMIT_S) as wait:
        yield _as_geometry_errors(design)(wait)


@contextmanager
def _as_geometry_errors(design: Design) -> Iterator[None]:
    """Errors of the kernel's process as GeometryError."""
    try:
        yield
    except DesignError as error:
        raise GeometryError(str(error)) from error
    except ProcessError as error:
        why = f"the CAD kernel did not build {design.design.name}: {error}"
        raise GeometryError(why) from error
