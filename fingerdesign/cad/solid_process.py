"""The CAD kernel at work in a process of its own: a finger's triangles, a finger's CAD files.

The kernel is native code, and its work grows with the design: 15 plates take 0.1 s, 200 take 2 s,
200 with 38 holes each a minute, and a STEP file may hold anything. So it runs under a time limit
where it can harm nobody. (Code that needs the CadQuery solid itself calls ``solid.build_solid``.)
CAD files are cached by what decides them, which grips and sizes of the mesh do not: the kernel
takes longer than an analysis of a cached model.
Importing this module loads no CAD kernel.
"""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.grip import Grip
from fingerdesign.design.mesh import MeshOptions
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, GeometryError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.runtime.cache import Cache, code_digest
from fingerdesign.runtime.files import write_whole
from fingerdesign.runtime.isolate import ProcessError, call, concurrently
from fingerdesign.runtime.registry import has_plugins
from fingerdesign.version import versions

TIME_LIMIT_S = 120.0  # thirty times what 200 plates take
CHORD_MM = 0.01
_MOST, _MOST_MB = 100, 300.0  # cached fingers; one of 15 plates takes 0.5 MB
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
    Returns the paths by file name. Errors as of ``finger_triangles``."""
    target = Path(folder).resolve()
    with finger_cad_concurrently(design, target) as wait:
        return {name: target / name for name in wait()}


@contextmanager
def finger_cad_concurrently(design: Design, folder: Path) -> Iterator[Callable[[], Any]]:
    """Write the CAD files, cached ones or concurrently with the block; the yielded function waits
    for them and returns their names."""
    target = folder.resolve()
    with _as_geometry_errors(design):
        key = _key(design)
    if (cached := _cached(key, target)) is not None:
        yield lambda: cached
        return
    with concurrently(_WRITE, design, target, CHORD_MM, time_s=TIME_LIMIT_S) as wait:

        def written() -> Any:
            names = wait()
            if key is not None:
                _files().put_files(key, [target / name for name in names])
            return names

        yield _as_geometry_errors(design)(written)


def _key(design: Design) -> str | None:
    """The name of the finger's files in the cache; None where what decides them is not all known,
    as with kinds from outside the package."""
    if has_plugins():
        return None
    meta = design.design.model_copy(update={"name": "finger"})
    others = {"design": meta, "grip": Grip(), "mesh": MeshOptions(), "assumed": ()}
    code = code_digest(Path(__file__).resolve().parents[1])
    parts = f"{design.model_copy(update=others).digest()} {CHORD_MM} {code} {versions()}"
    return hashlib.sha256(parts.encode()).hexdigest() + ".zip"


def _cached(key: str | None, target: Path) -> list[str] | None:
    """Write the cached files into a folder; their names, None where there are none."""
    if key is None or (contents := _files().files(key)) is None:
        return None
    target.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        write_whole(target / name, content)
    return list(contents)


def _files() -> Cache:
    return Cache("cad", _MOST, most_MB=_MOST_MB)


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
