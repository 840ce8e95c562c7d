"""The flat sides of an outline, and the prisms that go out from them. Loads the CAD kernel.

A mold whose body has four flat sides continues the contact surface outward: each side's face is
drawn outward as it is, so the walls' tops meet the contact surface along its border, exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import cadquery as cq
import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeVertex,
    BRepBuilderAPI_MakeWire,
)
from OCP.TopTools import TopTools_ListOfShape

from fingerdesign.arrays import Array
from fingerdesign.cad.kernel import extruded, flat_face, point, polygon
from fingerdesign.errors import GeometryError
from fingerdesign.mold.plan.plan import SIDES, Side

NEAR = 1e-6  # mm: that close, a face lies in a plane of the outline's box
AXIS = {"x": 0, "z": 2}


def direction(side: Side) -> Array:
    """The outward unit normal (3,) of a side."""
    found = np.zeros(3)
    found[AXIS[side[1]]] = 1.0 if side[0] == "+" else -1.0
    return found


@dataclass(frozen=True)
class FlatSide:
    """One flat side of an outline.

    face            of the outline, normal to the side
    top             its edges to the contact surface, those that are not at y = 0 nor at its ends
    low, high       its extent along the other horizontal axis, mm
    height_low, height_high   of its upper corners there, mm
    """

    side: Side
    face: cq.Face
    top: tuple[cq.Edge, ...]
    low: float
    high: float
    height_low: float
    height_high: float

    @property
    def away(self) -> float:
        """Distance of the face from the mid-plane, mm."""
        return float(np.array(self.face.Center().toTuple()) @ direction(self.side))

    def prism(self, start: float, end: float) -> cq.Solid:
        """The face drawn outward between two distances from the mid-plane."""
        return self._drawn(self.face, start, end)

    def widened(self, reach: float, start: float, end: float) -> cq.Solid:
        """The same of the face widened to +-``reach``, level with its upper corners there."""
        return self._drawn(self._widened(reach), start, end)

    def holds(self, points: Array, normals: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) of the outline with normals (n, 3) lie on the face, (n,)."""
        way = direction(self.side)
        return np.asarray((points @ way > self.away - 1e-5) & (normals @ way > 1.0 - 1e-9))

    def _drawn(self, face: cq.Face, start: float, end: float) -> cq.Solid:
        way, first = direction(self.side), start - self.away
        moved = face.translate(cq.Vector(*(first * way))) if abs(first) > 1e-12 else face
        return extruded(moved, (end - start) * way)

    def _widened(self, reach: float) -> cq.Face:
        """The face within the ground, its own top and the steps out to +-reach."""
        away = AXIS[self.side[1]]
        across = 2 - away
        plane = float(self.face.Center().toTuple()[away])

        def vertex(place: float, height: float) -> Any:
            where = np.zeros(3)
            where[away], where[across], where[1] = plane, place, height
            return BRepBuilderAPI_MakeVertex(point(where)).Vertex()

        corners = [v for edge in self.top for v in edge.Vertices()]
        left = min(corners, key=lambda v: float(v.toTuple()[across])).wrapped
        right = max(corners, key=lambda v: float(v.toTuple()[across])).wrapped
        chain = [
            left,
            vertex(-reach, self.height_low),
            vertex(-reach, 0.0),
            vertex(reach, 0.0),
            vertex(reach, self.height_high),
            right,
        ]
        edges = TopTools_ListOfShape()
        for edge in self.top:
            edges.Append(edge.wrapped)
        for a, b in pairwise(chain):
            edges.Append(BRepBuilderAPI_MakeEdge(a, b).Edge())
        wire = BRepBuilderAPI_MakeWire()
        wire.Add(edges)
        made = BRepBuilderAPI_MakeFace(wire.Wire(), True) if wire.IsDone() else None
        if made is None or not made.IsDone():
            raise GeometryError(f"the CAD kernel could not widen the finger's {self.side} face")
        return cq.Face(made.Face())


def flat_sides(outline: cq.Solid) -> dict[Side, FlatSide] | None:
    """The four sides of an outline, each one flat face from y = 0 up; None where one is not.

    A side is flat where exactly one face is normal to it, without holes, at the outline's extent,
    with upright ends at the extents of the other axis: then these meet its neighbours.
    """
    extent = _extent(outline)
    found: dict[Side, FlatSide] = {}
    for side in SIDES:
        away = AXIS[side[1]]
        faces = [face for face in outline.Faces() if _looks(face, direction(side))]
        if len(faces) != 1 or faces[0].innerWires():
            return None
        most = extent[1][away] if side[0] == "+" else extent[0][away]
        if abs(float(faces[0].Center().toTuple()[away]) - most) > NEAR:
            return None
        across = 2 - away
        flat = _flat_side(side, faces[0], extent[0][across], extent[1][across], across)
        if flat is None:
            return None
        found[side] = flat
    return found


def _flat_side(side: Side, face: cq.Face, low: float, high: float, across: int) -> FlatSide | None:
    top: list[cq.Edge] = []
    heights = {low: -np.inf, high: -np.inf}
    for edge in face.outerWire().Edges():
        ends = np.array([vertex.toTuple() for vertex in edge.Vertices()])
        straight = edge.geomType() == "LINE"
        if straight and np.all(np.abs(ends[:, 1]) < NEAR):
            continue
        for end in (low, high):
            if straight and np.all(np.abs(ends[:, across] - end) < NEAR):
                heights[end] = max(heights[end], float(ends[:, 1].max()))
                break
        else:
            top.append(edge)
    if not top or not all(np.isfinite(height) for height in heights.values()):
        return None
    return FlatSide(side, face, tuple(top), low, high, heights[low], heights[high])


def _looks(face: cq.Face, way: Array) -> bool:
    if face.geomType() != "PLANE":
        return False
    normal = np.array(face.normalAt().toTuple())
    return bool(normal @ way > 1.0 - 1e-12)


def _extent(solid: cq.Solid) -> tuple[Array, Array]:
    """Least and greatest coordinates (3,) of a solid's vertices."""
    places = np.array(
        [
            (p.X(), p.Y(), p.Z())
            for p in (BRep_Tool.Pnt_s(vertex.wrapped) for vertex in solid.Vertices())
        ]
    )
    return places.min(axis=0), places.max(axis=0)


def prism_of(corners: Sequence[Array] | Array, vector: Array) -> cq.Solid:
    """The prism of a flat polygon (n, 3), moved by ``vector``."""
    return extruded(flat_face(polygon(corners)), vector)
