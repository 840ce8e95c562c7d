"""CAD files of a finger: STEP assembly, and watertight STL at an absolute chord tolerance.

Every file is written aside and renamed, after its content has been checked. Importing this module
loads the CAD kernel.
"""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import cadquery as cq
import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.cad.kernel import volume_of
from fingerdesign.cad.solid import Solid, build_solid
from fingerdesign.cad.triangles import triangulate
from fingerdesign.design.schema import Design
from fingerdesign.errors import GeometryError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.volume import enclosed_volume
from fingerdesign.runtime.files import whole_file

Rgba = tuple[float, float, float, float]

SILICONE_GREY: Rgba = (0.80, 0.84, 0.88, 0.45)
BRONZE: Rgba = (0.72, 0.45, 0.20, 1.0)
BONE: Rgba = (0.93, 0.90, 0.80, 1.0)


def write_step(solid: Solid, path: Path | str) -> Path:
    """Write a STEP assembly of named parts ("body", "plate_0", ..., "core"). STEP stores the
    shapes, not that parts share faces."""
    parts = [("body", solid.body, SILICONE_GREY)]
    parts += [(f"plate_{index}", plate, BRONZE) for index, plate in enumerate(solid.plates)]
    parts += [] if solid.core is None else [("core", solid.core, BONE)]
    return _aside(path, lambda aside: write_assembly("finger", parts, aside))


def write_assembly(name: str, parts: Iterable[tuple[str, cq.Solid, Rgba]], path: Path) -> None:
    """Write named and coloured solids as one STEP assembly."""
    assembly = cq.Assembly(name=name)
    for part, solid, colour in parts:
        assembly.add(solid, name=part, color=cq.Color(*colour))
    assembly.export(str(path), "STEP")
    check_whole_step(path)


def check_whole_step(path: Path) -> None:
    """GeometryError for a STEP file that was cut short: the kernel does not report a full disk."""
    with path.open("rb") as stream:
        stream.seek(max(0, path.stat().st_size - 100))
        if not stream.read().rstrip().endswith(b"END-ISO-10303-21;"):
            raise GeometryError(f"{path.name} was not written to its end: is the disk full?")


def write_stl(shapes: Sequence[cq.Shape], path: Path | str, chord_tolerance_mm: float) -> Path:
    """Write solids that do not touch each other as one watertight binary STL.

    The surface stays within ``chord_tolerance_mm`` of the CAD's. GeometryError where it would not
    be watertight, is wound inconsistently, or has another volume than the CAD.
    """
    if not shapes:
        raise GeometryError(f"{Path(path).name}: there is no solid to write")
    vertices, triangles = triangulate(shapes, chord_tolerance_mm)
    volume = sum(volume_of(shape) for shape in shapes)
    area = sum(shape.Area() for shape in shapes)
    return write_triangles(vertices, triangles, path, volume, chord_tolerance_mm * area)


def write_triangles(
    vertices: Array, triangles: IntArray, path: Path | str, volume: float, slack: float
) -> Path:
    """Write triangles as one binary STL; vertices (n, 3) in mm.

    GeometryError where they are not watertight, are wound inconsistently, or enclose another volume
    than ``volume`` by more than ``slack``, both in mm^3.
    """
    # STL holds single precision: what is checked is what is written.
    vertices = vertices.astype(np.float32).astype(np.float64)
    check_watertight(Path(path).name, vertices, triangles)
    found = enclosed_volume(vertices, triangles)
    if abs(found - volume) > slack:
        raise GeometryError(
            f"{Path(path).name}: its triangles enclose {found:.6g} mm^3, the CAD {volume:.6g} mm^3"
        )
    return _aside(path, lambda aside: aside.write_bytes(_binary_stl(vertices, triangles)))


def write_cad(
    solid: Solid, folder: Path | str, chord_tolerance_mm: float = 0.01
) -> dict[str, Path]:
    """Write finger.step, finger.stl (the outside), body.stl and, where there are any, plates.stl
    and core.stl: parts that touch each other are files of their own.

    Returns the paths by file name.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    files = {"finger.step": write_step(solid, folder / "finger.step")}
    parts: dict[str, Sequence[cq.Shape]] = {
        "finger.stl": [solid.outline],
        "body.stl": [solid.body],
        "plates.stl": solid.plates,
        "core.stl": [] if solid.core is None else [solid.core],
    }
    for name, shapes in parts.items():
        if shapes:
            files[name] = write_stl(shapes, folder / name, chord_tolerance_mm)
    return files


def build_triangles(
    design: Design,
    chord_tolerance_mm: float,
    half: bool = False,
    frames: tuple[PlateFrame, ...] | None = None,
) -> tuple[Array, IntArray, Array, IntArray]:
    """Build a finger (its half z >= 0) and triangulate it: vertices and triangles of its parts, and
    those of its outside alone."""
    solid = build_solid(design, half, frames)
    return (
        *triangulate(solid.parts, chord_tolerance_mm),
        *triangulate([solid.outline], chord_tolerance_mm),
    )


def build_and_write(
    design: Design, folder: Path | str, chord_tolerance_mm: float = 0.01
) -> tuple[str, ...]:
    """Build a finger and write its CAD files as :func:`write_cad`; their names."""
    return tuple(write_cad(build_solid(design), folder, chord_tolerance_mm))


def check_watertight(what: str, vertices: Array, triangles: IntArray) -> None:
    """GeometryError unless each edge has two triangles, one running it in each direction."""
    if len(np.unique(vertices, axis=0)) != len(vertices):
        raise GeometryError(f"{what}: vertices fall together in single precision")
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, uses = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    if np.any(uses != 2):
        raise GeometryError(
            f"{what}: {int((uses != 2).sum())} edges do not have exactly two triangles"
        )
    if len(np.unique(edges, axis=0)) != len(edges):
        raise GeometryError(f"{what}: neighbouring triangles are wound against each other")


def _binary_stl(vertices: Array, triangles: IntArray) -> bytes:
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records = np.zeros(len(triangles), dtype=record)
    records["normal"], records["corners"] = normals, corners
    header = b"binary STL by fingerdesign, units mm".ljust(80, b" ")
    return header + len(triangles).to_bytes(4, "little") + bytes(records.tobytes())


def _aside(path: Path | str, write: Callable[[Path], object]) -> Path:
    path = Path(path)
    try:
        with whole_file(path) as aside:
            write(aside)
            if not aside.is_file() or aside.stat().st_size == 0:
                raise GeometryError(f"{path}: the CAD kernel wrote nothing")
    except OSError as error:
        raise GeometryError(f"{path} could not be written: {error}") from error
    return path
