"""Which faces of a CAD solid join without an edge, and where a face's middle is; in the worker.

Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_EDGE
from OCP.TopoDS import TopoDS

from fingerdesign.arrays import Array
from fingerdesign.design.cad_faces import CadFace
from fingerdesign.design.quadrics import Plane
from fingerdesign.geometry.step_border import edge_samples, triple
from fingerdesign.geometry.step_shape import parts

SMOOTH_DEG = 12.0  # over an edge of 1 mm that is 0.1 mm, ten times a mesher's envelope


def middle(face: Any, area: float) -> Array:
    """The point of a face nearest to its centroid, (3,)."""
    found = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, found)
    apart = BRepExtrema_DistShapeShape(
        BRepBuilderAPI_MakeVertex(found.CentreOfMass()).Vertex(), face
    )
    return triple(apart.PointOnShape2(1) if apart.NbSolution() else found.CentreOfMass())


def groups(solid: Any, faces: Sequence[Any], found: Sequence[CadFace]) -> list[int]:
    """A number for each face; equal for faces that join smoothly or lie in one plane."""
    label = list(range(len(faces)))

    def root(number: int) -> int:
        while label[number] != number:
            number = label[number]
        return number

    def join(first: int, second: int) -> None:
        first, second = sorted((root(first), root(second)))
        label[second] = first

    owners: dict[int, list[tuple[Any, int]]] = {}
    for number, face in enumerate(faces):
        for edge in parts(face, TopAbs_EDGE):
            bucket = owners.setdefault(hash(edge), [])
            bucket += [(edge, number)]
    for bucket in owners.values():
        for k, (edge, first) in enumerate(bucket):
            for other, second in bucket[k + 1 :]:
                apart = first != second and root(first) != root(second)
                if apart and edge.IsSame(other) and _smooth(edge, found[first], found[second]):
                    join(first, second)
    flat = [number for number, face in enumerate(found) if isinstance(face.shape, Plane)]
    for k, first in enumerate(flat):
        for second in flat[k + 1 :]:
            if _coplanar(found[first], found[second]):
                join(first, second)
    return [root(number) for number in range(len(faces))]


def _smooth(edge: Any, first: CadFace, second: CadFace) -> bool:
    """Whether two faces turn by less than SMOOTH_DEG all along an edge."""
    places = edge_samples(BRepAdaptor_Curve(TopoDS.Edge_s(edge)), 8)[0][1:-1]
    turn = np.einsum("ij,ij->i", first.normal(places), second.normal(places))
    return bool(turn.min() > np.cos(np.radians(SMOOTH_DEG)))


def _coplanar(first: CadFace, second: CadFace) -> bool:
    a, b = first.shape, second.shape
    assert isinstance(a, Plane)
    assert isinstance(b, Plane)
    one, other = first.sign * a.direction, second.sign * b.direction
    flush = abs(first.sign * a.offset - second.sign * b.offset) < 1e-6
    return bool(one @ other > 1.0 - 1e-12 and flush)
