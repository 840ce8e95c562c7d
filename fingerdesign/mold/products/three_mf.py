"""3MF: all printed parts in one file that carries its unit.

Importing this module is light; lib3mf (the format's own library) loads when a file is written.
"""

import locale
import math
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import GeometryError
from fingerdesign.mold.part import PartMesh, Point, point
from fingerdesign.mold.solids import areas

GAP_MM = 5.0  # between parts on one bed, and sheets of one drawing
DECIMALS = 6  # nm: finer than single precision, in which the format's library holds vertices
FLAT = 1e-6  # mm; how far from its plane a face may lie
OUTSIDE = 1.5  # how much more a face that is drawn away from the finger counts: its other side
# forms the finger, and prints best when it looks up


@dataclass(frozen=True)
class Posed:
    """A part turned for printing: vertices (n, 3) from its own corner (0, 0, 0), and its place.

    place: where that corner lies on the bed. flat_area: of the face it lies on, mm^2. down: that
    face's outward normal in mold space.
    """

    name: str
    vertices: Array
    triangles: IntArray
    place: tuple[float, float]
    flat_area: float
    down: Point

    @property
    def size(self) -> Point:
        """Extent along x, y, z of the bed."""
        return point(np.ptp(self.vertices, axis=0))


def laid_out(parts: tuple[PartMesh, ...]) -> tuple[Posed, ...]:
    """Each part with its largest flat outer face down, in rows that make about a square.

    Outer: nothing of the part reaches beyond the face's plane. A face that looks away from the
    finger counts half as much again, so that the side that forms it looks up.
    """
    posed = [_posed(part) for part in parts]
    posed.sort(key=lambda each: (-each.size[1], each.name))
    places = in_rows([each.size[:2] for each in posed])
    return tuple(replace(each, place=place) for each, place in zip(posed, places, strict=True))


def in_rows(sizes: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Places (x, y) of the lower left corners of rectangles (width, depth), in the order given: in
    rows from the deepest to the least deep, with gaps, that make about a square.

    >>> in_rows([(2.0, 1.0), (2.0, 3.0), (2.0, 2.0)])
    [(0.0, 8.0), (0.0, 0.0), (7.0, 0.0)]
    """
    area = sum((wide + GAP_MM) * (deep + GAP_MM) for wide, deep in sizes)
    limit = max(1.2 * math.sqrt(area), *(wide for wide, _ in sizes), 0.0)
    places, x, y, row = [(0.0, 0.0)] * len(sizes), 0.0, 0.0, 0.0
    for k in sorted(range(len(sizes)), key=lambda each: -sizes[each][1]):
        wide, deep = sizes[k]
        if x > 0.0 and x + wide > limit:
            x, y, row = 0.0, y + row + GAP_MM, 0.0
        places[k] = x, y
        x, row = x + wide + GAP_MM, max(row, deep)
    return places


def flat_faces(part: PartMesh) -> list[tuple[float, Array]]:
    """(area, outward normal) of the flat faces that a part can lie on: those in its hull's."""
    planes, corners = ConvexHull(part.vertices).equations, part.vertices[part.triangles]
    _, kinds = np.unique(np.round(planes[:, :3], 4) + 0.0, axis=0, return_index=True)
    sizes, found = areas(part.vertices, part.triangles), []
    for plane in planes[kinds]:
        on = np.abs(corners @ plane[:3] + plane[3]).max(axis=1) < FLAT
        if on.any():
            found.append((float(sizes[on].sum()), plane[:3]))
    return sorted(found, key=lambda each: -each[0])


def _posed(part: PartMesh) -> Posed:
    outward = np.array(part.draw if part.draw is not None else (0.0, -1.0, 0.0))
    faces = flat_faces(part) or [(0.0, np.array([0.0, -1.0, 0.0]))]  # none: as it lies in the mold
    area, down = max(faces, key=lambda f: f[0] * (OUTSIDE if f[1] @ outward > 0.999 else 1.0))
    turned = Rotation.align_vectors([0.0, 0.0, -1.0], down)[0].apply(part.vertices)
    if np.ptp(turned[:, 1]) > np.ptp(turned[:, 0]):
        turned = turned[:, [1, 0, 2]] * np.array([-1.0, 1.0, 1.0])
    turned = turned - turned.min(axis=0)
    return Posed(part.name, turned, part.triangles, (0.0, 0.0), area, point(down))


def write_3mf(posed: Sequence[Posed], path: Path, title: str) -> None:
    """Write parts in millimetres at their places on the bed.

    GeometryError where it can't be written to its end: the library does not say so itself.
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
            points, corners = each.vertices.astype(np.float32), each.triangles.astype(np.uint32)
            positions = (lib3mf.Position * len(points)).from_buffer_copy(points.tobytes())
            triangles = (lib3mf.Triangle * len(corners)).from_buffer_copy(corners.tobytes())
            made.SetGeometry(positions, triangles)
            place = np.vstack([np.eye(3), [*each.place, 0.0]]).astype(np.float32)
            model.AddBuildItem(made, lib3mf.Transform.from_buffer_copy(place.tobytes()))
        writer = model.QueryWriter("3mf")
        writer.SetDecimalPrecision(DECIMALS)
        with _locale_kept():
            writer.WriteToFile(str(path))
    except lib3mf.ELib3MFException as error:
        raise GeometryError(f"{path.name} could not be written: {error}") from error
    try:
        with zipfile.ZipFile(path) as archive:
            whole = archive.testzip() is None
    except (OSError, zipfile.BadZipFile):
        whole = False
    if not whole:
        raise GeometryError(f"{path.name} was not written to its end: is the disk full?")


@contextmanager
def _locale_kept() -> Iterator[None]:
    """lib3mf sets the process's locale to "C", in which other code then reads text as ASCII."""
    before = locale.setlocale(locale.LC_ALL)
    try:
        yield
    finally:
        locale.setlocale(locale.LC_ALL, before)
