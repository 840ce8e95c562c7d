"""3MF: all printed parts in one file that carries its unit, written and read back.

Importing this module is light; lib3mf (the format's own library) loads when a file is written.
"""

from __future__ import annotations

import locale
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import GeometryError
from fingerdesign.mold.print_pose import Posed

DECIMALS = 6  # nm: finer than single precision, in which the format's library holds vertices


@dataclass(frozen=True)
class Held:
    """What a 3MF file was found to hold of one part; volume in mm^3."""

    name: str
    vertices: int
    triangles: int
    volume: float


def write_3mf(posed: Sequence[Posed], path: Path, title: str) -> tuple[Held, ...]:
    """Write parts in millimetres at their places on the bed, and hold the file against them.

    GeometryError where it can't be written, or holds another unit, other names, counts or volumes
    than were given.
    """
    import lib3mf

    try:
        wrapper = lib3mf.get_wrapper()
        model = wrapper.CreateModel()
        model.SetUnit(lib3mf.ModelUnit.MilliMeter)
        model.GetMetaDataGroup().AddMetaData("", "Title", title, "xs:string", True)
        for each in posed:
            made = model.AddMeshObject()
            made.SetName(each.name)
            made.SetGeometry(*_buffers(lib3mf, each))
            model.AddBuildItem(made, _moved(lib3mf, each.place))
        writer = model.QueryWriter("3mf")
        writer.SetDecimalPrecision(DECIMALS)
        with _locale_kept():
            writer.WriteToFile(str(path))
    except lib3mf.ELib3MFException as error:
        raise GeometryError(f"{path.name} could not be written: {error}") from error
    held = read_3mf(path)
    _compare(path.name, posed, held)
    return held


def read_3mf(path: Path) -> tuple[Held, ...]:
    """What a file holds, in the order of its build items; GeometryError unless it is in mm."""
    import lib3mf

    try:
        model = lib3mf.get_wrapper().CreateModel()
        reader = model.QueryReader("3mf")
        reader.SetStrictModeActive(True)
        with _locale_kept():
            reader.ReadFromFile(str(path))
    except lib3mf.ELib3MFException as error:
        raise GeometryError(f"{path.name} could not be read back: {error}") from error
    if model.GetUnit() != lib3mf.ModelUnit.MilliMeter:
        raise GeometryError(f"{path.name}: its unit is not the millimetre")
    items = model.GetBuildItems()
    held = []
    while items.MoveNext():
        mesh = items.GetCurrent().GetObjectResource()
        vertices = _array(mesh.GetVertices(), np.float32).astype(np.float64)
        triangles = _array(mesh.GetTriangleIndices(), np.uint32).astype(np.int64)
        if not mesh.IsManifoldAndOriented():
            raise GeometryError(f"{path.name}: {mesh.GetName()} is not one closed surface there")
        volume = _volume(vertices, triangles)
        held.append(Held(mesh.GetName(), len(vertices), len(triangles), volume))
    return tuple(held)


@contextmanager
def _locale_kept() -> Iterator[None]:
    """lib3mf sets the process's locale to "C", in which other code then reads text as ASCII."""
    before = locale.setlocale(locale.LC_ALL)
    try:
        yield
    finally:
        locale.setlocale(locale.LC_ALL, before)


def _compare(name: str, posed: Sequence[Posed], held: Sequence[Held]) -> None:
    wanted = [(each.name, len(each.vertices), len(each.triangles)) for each in posed]
    found = [(each.name, each.vertices, each.triangles) for each in held]
    if wanted != found:
        raise GeometryError(f"{name} holds {found}, and was given {wanted}")
    for part, back in zip(posed, held, strict=True):
        volume = _volume(part.vertices, part.triangles)
        # Single precision: each face is off by its size times 1e-7 at most.
        if abs(back.volume - volume) > 1e-5 * abs(volume) + 1e-9:
            raise GeometryError(
                f"{name}: {part.name} has {back.volume:.8g} mm^3, and was given {volume:.8g} mm^3"
            )


def _volume(vertices: Array, triangles: IntArray) -> float:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _buffers(lib3mf: Any, posed: Posed) -> tuple[Any, Any]:
    points = np.ascontiguousarray(posed.vertices, dtype=np.float32)
    corners = np.ascontiguousarray(posed.triangles, dtype=np.uint32)
    positions = (lib3mf.Position * len(points)).from_buffer_copy(points.tobytes())
    return positions, (lib3mf.Triangle * len(corners)).from_buffer_copy(corners.tobytes())


def _array(structures: Sequence[Any], kind: Any) -> NDArray[Any]:
    """lib3mf's list of three-number structures as an array (n, 3)."""
    raw = b"".join(bytes(each) for each in structures)
    return np.frombuffer(raw, dtype=kind).reshape(-1, 3)


def _moved(lib3mf: Any, place: tuple[float, float]) -> Any:
    rows = np.vstack([np.eye(3), [*place, 0.0]]).astype(np.float32)
    return lib3mf.Transform.from_buffer_copy(rows.tobytes())
