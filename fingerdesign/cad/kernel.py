"""Lines, arcs, faces and solids in the CAD kernel, built from exact centres and radii.

CadQuery's own arcs go through three points, which loses digits where an arc is flat; here a circle
keeps its centre and radius. Lengths in mm. Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cadquery as cq
import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace
from OCP.BRepGProp import BRepGProp_Domain, BRepGProp_Face, BRepGProp_Vinert
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism, BRepPrimAPI_MakeRevol
from OCP.gp import gp_Ax1, gp_Ax2, gp_Circ, gp_Dir, gp_Pnt, gp_Vec

from fingerdesign.arrays import Array
from fingerdesign.cad.step_shape import volume_of as by_gauss_kronrod
from fingerdesign.errors import GeometryError

_SPLINES = ("BSPLINE", "BEZIER", "EXTRUSION", "OFFSET", "OTHER")  # kinds of faces


@dataclass(frozen=True)
class Arc:
    """A circular edge from start to end, anticlockwise about ``direction``; points in space."""

    start: Array
    end: Array
    centre: Array
    direction: Array
    radius: float


@dataclass(frozen=True)
class Line:
    """A straight edge from start to end; points in space."""

    start: Array
    end: Array


def point(where: Array) -> gp_Pnt:
    """The kernel's point."""
    return gp_Pnt(*(float(value) for value in where))


def polygon(points: Sequence[Array] | Array) -> list[Line | Arc]:
    """The closed polygon through ``points`` (n, 3)."""
    corners = [np.asarray(corner, dtype=float) for corner in points]
    return [Line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]


def flat_face(outer: Sequence[Line | Arc], circles: Sequence[gp_Circ] = ()) -> cq.Face:
    """The flat face within a closed chain of edges, without the discs of ``circles``."""
    edges = [_edge(part) for part in outer]
    made = BRepBuilderAPI_MakeFace(cq.Wire.assembleEdges(edges).wrapped, True)
    for circle in circles:
        hole = cq.Wire.assembleEdges([cq.Edge(BRepBuilderAPI_MakeEdge(circle).Edge())])
        made.Add(hole.wrapped)
    if not made.IsDone():
        raise GeometryError("the CAD kernel made no flat face of a section")
    return cq.Face(made.Face())


def circle(centre: Array, direction: Array, radius: float) -> gp_Circ:
    """The full circle anticlockwise about ``direction``."""
    return gp_Circ(gp_Ax2(point(centre), gp_Dir(*(float(d) for d in direction))), radius)


def extruded(face: cq.Face, vector: Array) -> cq.Solid:
    """The solid that a flat face sweeps when moved by ``vector``."""
    prism = BRepPrimAPI_MakePrism(face.wrapped, gp_Vec(*(float(v) for v in vector)))
    return one_solid(cq.Shape.cast(prism.Shape()), "an extruded section")


def revolved(face: cq.Face, origin: Array, direction: Array, angle_deg: float) -> cq.Solid:
    """The solid that a flat face sweeps when turned about an axis, by the right-hand rule."""
    axis = gp_Ax1(point(origin), gp_Dir(*(float(d) for d in direction)))
    if angle_deg >= 360.0:
        turned = BRepPrimAPI_MakeRevol(face.wrapped, axis)
    else:
        turned = BRepPrimAPI_MakeRevol(face.wrapped, axis, float(np.radians(angle_deg)))
    return one_solid(cq.Shape.cast(turned.Shape()), "a revolved section")


def box(low: Sequence[float], high: Sequence[float]) -> cq.Solid:
    """The box between two corners."""
    sizes = [float(b) - float(a) for a, b in zip(low, high, strict=True)]
    return cq.Solid.makeBox(*sizes, pnt=cq.Vector(*(float(a) for a in low)))


def upper_half(solid: cq.Solid, what: str) -> cq.Solid:
    """The part z >= 0 of a solid."""
    bounds = solid.BoundingBox()
    low = (bounds.xmin - 1.0, bounds.ymin - 1.0, 0.0)
    high = (bounds.xmax + 1.0, bounds.ymax + 1.0, bounds.zmax + 1.0)
    return one_solid(solid.intersect(box(low, high)), f"{what}, z >= 0")


def volume_of(solid: cq.Shape) -> float:
    """Volume, mm^3, good to 1e-9 of it: what each face encloses with the origin, summed.

    The kernel's fixed integration is exact on faces bounded by lines and circles; where other
    curves trim them (domes, drilled holes) it is off by up to 1e-5, and the adaptive one within
    3e-10. That one, in turn, may be off by 1e-5 on a whole torus. Both are off by up to 2e-4 below
    a spline that a STEP file brings: its whole solid is integrated by Gauss-Kronrod's rule.
    """
    if any(face.geomType() in _SPLINES for face in solid.Faces()):
        return by_gauss_kronrod(solid.wrapped)
    origin, whole = gp_Pnt(0.0, 0.0, 0.0), 0.0
    for face in solid.Faces():
        surface, domain = BRepGProp_Face(face.wrapped), BRepGProp_Domain(face.wrapped)
        if all(edge.geomType() in ("LINE", "CIRCLE") for edge in face.Edges()):
            whole += BRepGProp_Vinert(surface, domain, origin).Mass()
        else:
            whole += BRepGProp_Vinert(surface, domain, origin, 1e-10).Mass()
    return float(whole)


def one_solid(shape: cq.Shape, what: str) -> cq.Solid:
    """The single valid solid in ``shape``, wound outward; GeometryError for none or several."""
    solids = shape.Solids()
    if len(solids) != 1 or not solids[0].isValid():
        raise GeometryError(f"{what}: the CAD kernel made {len(solids)} solids, or an invalid one")
    return solids[0] if solids[0].Volume() > 0.0 else cq.Solid(solids[0].wrapped.Reversed())


def _edge(part: Line | Arc) -> cq.Edge:
    if isinstance(part, Line):
        made = BRepBuilderAPI_MakeEdge(point(part.start), point(part.end))
    else:
        round_ = circle(part.centre, part.direction, part.radius)
        made = BRepBuilderAPI_MakeEdge(round_, point(part.start), point(part.end))
    if not made.IsDone():
        raise GeometryError("the CAD kernel made no edge between two points of a section")
    return cq.Edge(made.Edge())
