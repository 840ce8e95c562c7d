"""Triangles of CAD faces at an absolute chord tolerance, with shared vertices.

CadQuery's own ``tessellate`` and ``exportStl`` take *relative* tolerances (0.01 gave a chord error
of 0.043 mm) and reuse whatever triangulation a shape carries, so the kernel is called directly, on
a copy. Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from collections.abc import Iterable

import cadquery as cq
import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.TopAbs import TopAbs_FACE, TopAbs_Orientation
from OCP.TopExp import TopExp
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Compound
from OCP.TopTools import TopTools_IndexedMapOfShape

from fingerdesign.errors import GeometryError

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def triangulate(
    shapes: Iterable[cq.Shape], chord_tolerance_mm: float, angle_rad: float = 0.3
) -> tuple[Array, IntArray]:
    """Triangulate shapes together: faces that they share come once, and fit their neighbours.

    Returns vertices (n, 3) without duplicates and triangles (t, 3), counter-clockwise from outside
    the shape that a face was first met in. GeometryError where the kernel yields no triangles.
    """
    if not (np.isfinite(chord_tolerance_mm) and chord_tolerance_mm > 0.0):
        raise GeometryError(f"chord tolerance {chord_tolerance_mm} mm must be above 0")
    builder, compound = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(compound)
    for shape in shapes:
        builder.Add(compound, shape.wrapped)
    fresh = BRepBuilderAPI_Copy(compound, True, False).Shape()
    BRepMesh_IncrementalMesh(fresh, chord_tolerance_mm, False, angle_rad, False)
    faces = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(fresh, TopAbs_FACE, faces)
    vertices, triangles, count = [], [], 0
    for number in range(1, faces.Extent() + 1):
        face = TopoDS.Face_s(faces.FindKey(number))
        place = TopLoc_Location()
        patch = BRep_Tool.Triangulation_s(face, place)
        if patch is None or patch.NbTriangles() == 0:
            raise GeometryError(f"the CAD kernel made no triangles for face {number}")
        move = place.Transformation()
        nodes = [patch.Node(i).Transformed(move) for i in range(1, patch.NbNodes() + 1)]
        vertices.append(np.array([(p.X(), p.Y(), p.Z()) for p in nodes]))
        corners = [patch.Triangle(i).Get() for i in range(1, patch.NbTriangles() + 1)]
        own = np.array(corners, dtype=np.int64) - 1 + count
        reversed_face = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
        triangles.append(own[:, ::-1] if reversed_face else own)
        count += len(nodes)
    return merge_vertices(np.vstack(vertices), np.vstack(triangles))


def merge_vertices(
    vertices: Array, triangles: IntArray, tolerance_mm: float = 1e-7
) -> tuple[Array, IntArray]:
    """Make vertices closer than about ``tolerance_mm`` one; triangles that collapse are dropped."""
    low = vertices.min(axis=0)
    # Two offset roundings: a pair split by one grid's cell border is whole in the other's.
    labels = np.arange(len(vertices))
    for shift in (0.0, 0.5):
        cells = np.floor((vertices - low) / tolerance_mm + shift).astype(np.int64)
        _, inverse = np.unique(cells, axis=0, return_inverse=True)
        inverse = inverse.reshape(-1)
        least = np.full(inverse.max() + 1, len(vertices))
        np.minimum.at(least, inverse, labels)
        labels = least[inverse]
        labels = labels[labels]
    kept, renumbered = np.unique(labels, return_inverse=True)
    merged = renumbered.reshape(-1)[triangles]
    distinct = (
        (merged[:, 0] != merged[:, 1])
        & (merged[:, 1] != merged[:, 2])
        & (merged[:, 2] != merged[:, 0])
    )
    return vertices[kept], merged[distinct]
