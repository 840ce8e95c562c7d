"""Lines, arcs, faces and solids in CadQuery, built from exact centres and radii.

CadQuery's own arcs go through three points, which loses digits where an arc is flat; here a circle
has its exact centre and radius. Lengths in mm. Importing this module loads the CAD kernel.
"""

from collections.abc import Sequence

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.BRepGProp import BRepGProp_Domain, BRepGProp_Face, BRepGProp_Vinert
from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Pnt

from fingerdesign.arrays import Array
from fingerdesign.cad.step_faces import volume_of as by_gauss_kronrod
from fingerdesign.errors import GeometryError

_SPLINES = ("BSPLINE", "BEZIER", "EXTRUSION", "OFFSET", "OTHER")  # kinds of faces


def line(start: Array, end: Array) -> cq.Edge:
    """The straight edge from start to end, (3,)."""
    return cq.Edge.makeLine(cq.Vector(*start), cq.Vector(*end))


def arc(start: Array, end: Array, centre: Array, direction: Array, radius: float) -> cq.Edge:
    """The circular edge from start to end, anticlockwise about ``direction``."""
    round_ = gp_Circ(gp_Ax2(gp_Pnt(*centre), gp_Dir(*direction)), radius)
    made = BRepBuilderAPI_MakeEdge(round_, gp_Pnt(*start), gp_Pnt(*end))
    if not made.IsDone():
        raise GeometryError("the CAD kernel made no edge between two points of a section")
    return cq.Edge(made.Edge())


def polygon(points: Sequence[Array] | Array) -> list[cq.Edge]:
    """The closed polygon through ``points`` (n, 3)."""
    return [line(a, b) for a, b in zip(points, [*points[1:], points[0]], strict=True)]


def circle(centre: Array, direction: Array, radius: float) -> cq.Edge:
    """The full circle anticlockwise about ``direction``."""
    return cq.Edge.makeCircle(radius, cq.Vector(*centre), cq.Vector(*direction))


def flat_face(outer: Sequence[cq.Edge], circles: Sequence[cq.Edge] = ()) -> cq.Face:
    """The flat face within a closed chain of edges, without the discs of ``circles``."""
    wires = [cq.Wire.assembleEdges(edges) for edges in (outer, *([each] for each in circles))]
    return cq.Face.makeFromWires(wires[0], wires[1:])


def extruded(face: cq.Face, vector: Array) -> cq.Solid:
    """The solid that a flat face sweeps when moved by ``vector``."""
    return one_solid(cq.Solid.extrudeLinear(face, cq.Vector(*vector)), "an extruded section")


def revolved(face: cq.Face, origin: Array, direction: Array, angle_deg: float) -> cq.Solid:
    """The solid that a flat face sweeps when turned about an axis, by the right-hand rule."""
    ends = cq.Vector(*origin), cq.Vector(*(origin + direction))
    return one_solid(cq.Solid.revolve(face, angle_deg, *ends), "a revolved section")


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
