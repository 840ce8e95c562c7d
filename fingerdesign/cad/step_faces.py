"""Faces of a STEP body in numbers that numpy computes with: surface, border, area, neighbours.

Planes, cylinders, cones and spheres keep their closed form; every other surface becomes a NURBS
surface, compared with the kernel's own. Importing this module loads the CAD kernel.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations, product
from typing import Any

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepGProp import BRepGProp, BRepGProp_Face
from OCP.BRepTools import BRepTools
from OCP.GCPnts import GCPnts_AbscissaPoint
from OCP.Geom import Geom_BSplineSurface, Geom_RectangularTrimmedSurface
from OCP.GeomAbs import GeomAbs_C2, GeomAbs_Line
from OCP.GeomAbs import GeomAbs_SurfaceType as Kind
from OCP.GeomAdaptor import GeomAdaptor_Surface
from OCP.GeomConvert import GeomConvert, GeomConvert_ApproxSurface
from OCP.gp import gp_Pnt, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.ShapeUpgrade import ShapeUpgrade_ShapeConvertToBezier
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS
from OCP.TopTools import TopTools_IndexedMapOfShape
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fingerdesign.arrays import Array
from fingerdesign.cad.step_rules import refused
from fingerdesign.shapes.faces import Border, CadFace
from fingerdesign.shapes.nurbs import Nurbs
from fingerdesign.shapes.quadrics import Cone, Plane, Shape, Sphere, unit

INTEGRALS = 1e-10  # relative error of volumes and areas
PIECES = 600  # of a face's border
LEAST_PIECES = 24  # of a curved edge: 1e-7 mm on a quarter circle of 0.5 mm
SMOOTH_DEG = 12.0  # over an edge of 1 mm that is 0.1 mm, ten times a mesher's envelope
NURBS_MISFIT_MM = 1e-6  # between a surface and the NURBS made of it; exact but for offset surfaces
FLAT_MM = 1e-7  # CAD files give places to that


def parts(shape: Any, kind: Any, *outside_of: Any) -> Iterator[Any]:
    """Sub-shapes of a kind (not those within another kind), with their orientation."""
    explorer = TopExp_Explorer(shape, kind, *outside_of)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def volume_of(solid: Any) -> float:
    """Volume, mm^3."""
    found = GProp_GProps()
    # Gauss-Kronrod: the kernel's plain rule is 6e-6 off below a spline, and believes itself.
    BRepGProp.VolumePropertiesGK_s(solid, found, INTEGRALS, False, True, False, False, False)
    return float(found.Mass())


def box_of(shape: Any) -> tuple[Array, Array]:
    """Corners (3,) of a box that holds a shape, 1e-7 mm wider than it."""
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    values = np.array(box.Get())
    return values[:3], values[3:]


def triple(place: Any) -> Array:
    """The numbers of a kernel's point or direction."""
    return np.array([place.X(), place.Y(), place.Z()])


def _bounding(face: Any) -> Iterator[tuple[Any, Any, float]]:
    """Yield the edges that bound a face, with their curves and lengths: no seam, where the face
    goes on, and no pole."""
    for part in parts(face, TopAbs_EDGE):
        edge = TopoDS.Edge_s(part)
        directed = edge.Orientation() in (TopAbs_FORWARD, TopAbs_REVERSED)
        if directed and not (BRep_Tool.Degenerated_s(edge) or BRep_Tool.IsClosed_s(edge, face)):
            curve = BRepAdaptor_Curve(edge)
            yield edge, curve, float(GCPnts_AbscissaPoint.Length_s(curve))


def border_of(face: Any, shape: Shape, sign: float) -> Border:
    """The edges that bound a face, in pieces."""
    edges = list(_bounding(face))
    if not edges:
        return Border(*(np.zeros((0, 3)) for _ in range(6)))
    total = sum(length for *_, length in edges)
    pieces = []
    for edge, curve, length in edges:
        straight = curve.GetType() == GeomAbs_Line
        number = max(int(np.ceil(PIECES * length / total)), 2 if straight else LEAST_PIECES)
        places, slopes = edge_samples(curve, number)
        if edge.Orientation() == TopAbs_REVERSED:
            places, slopes = places[::-1], -slopes[::-1]
        pieces.append((places[:-1], places[1:], slopes[:-1], slopes[1:]))
    start, end, leaving, arriving = map(np.concatenate, zip(*pieces, strict=True))
    # The face lies to the left of its edges, seen from outside.
    inward = [
        unit(np.cross(sign * shape.normal(places), slopes))
        for places, slopes in ((start, leaving), (end, arriving))
    ]
    return Border(start, end, leaving, arriving, *inward)


def edge_samples(curve: Any, number: int) -> tuple[Array, Array]:
    """Places and derivatives (by pieces) at the ends of ``number`` pieces, (number + 1, 3)."""
    first, last = curve.FirstParameter(), curve.LastParameter()
    step = (last - first) / number
    places, slopes = np.empty((number + 1, 3)), np.empty((number + 1, 3))
    for k in range(number + 1):
        place, slope = gp_Pnt(), gp_Vec()
        curve.D1(first + k * step, place, slope)
        places[k], slopes[k] = triple(place), step * triple(slope)
    return places, slopes


def middle(face: Any) -> Array:
    """The point of a face nearest to its centroid, (3,)."""
    found = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, found)
    centroid = found.CentreOfMass()
    apart = BRepExtrema_DistShapeShape(BRepBuilderAPI_MakeVertex(centroid).Vertex(), face)
    return triple(apart.PointOnShape2(1) if apart.NbSolution() else centroid)


def _neighbours(faces: Sequence[Any]) -> Iterator[tuple[Any, int, int]]:
    """Yield the edges that two faces share, with the faces' numbers."""
    edges = TopTools_IndexedMapOfShape()  # by what they are, in any orientation
    owners: dict[int, list[int]] = {}
    for number, face in enumerate(faces):
        for edge in parts(face, TopAbs_EDGE):
            owners.setdefault(edges.Add(edge), []).append(number)
    for edge, own in owners.items():
        yield from ((edges.FindKey(edge), a, b) for a, b in combinations(own, 2) if a != b)


def groups(faces: Sequence[Any], found: Sequence[CadFace]) -> list[int]:
    """A number for each face; equal for faces that join smoothly or lie in one plane."""
    pairs = _neighbours(faces)
    joined = [(a, b) for edge, a, b in pairs if _smooth(edge, found[a], found[b])]
    flat = [number for number, face in enumerate(found) if isinstance(face.shape, Plane)]
    joined += [pair for pair in combinations(flat, 2) if _coplanar(*(found[k] for k in pair))]
    graph = coo_array((np.ones(len(joined)), np.reshape(joined, (-1, 2)).T), (len(faces),) * 2)
    return [int(label) for label in connected_components(graph, directed=False)[1]]


def _smooth(edge: Any, first: CadFace, second: CadFace) -> bool:
    """True where two faces turn by less than SMOOTH_DEG all along an edge."""
    places = edge_samples(BRepAdaptor_Curve(TopoDS.Edge_s(edge)), 8)[0][1:-1]
    turn = np.einsum("ij,ij->i", first.normal(places), second.normal(places))
    return bool(turn.min() > np.cos(np.radians(SMOOTH_DEG)))


def _coplanar(first: CadFace, second: CadFace) -> bool:
    """True where two flat faces lie in one plane and face the same way."""
    origin = np.zeros((1, 3))
    turn = float((first.normal(origin) @ second.normal(origin).T)[0, 0])
    flush = abs(float((first.distance(origin) - second.distance(origin))[0])) < 1e-6
    return turn > 1.0 - 1e-12 and flush


def describe(face: Any, name: str) -> CadFace:
    """One face; its name and group are not yet set. ``name``: the file's, for faults."""
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    shape = shape_of(BRep_Tool.Surface_s(face), (u0, u1, v0, v1), name)
    place, outward = gp_Pnt(), gp_Vec()
    # Off the middle, where a symmetric surface may have a pole.
    BRepGProp_Face(face).Normal(u0 + 0.437 * (u1 - u0), v0 + 0.437 * (v1 - v0), place, outward)
    natural = shape.normal(triple(place)[None])[0]
    sign = 1.0 if float(natural @ triple(outward)) > 0.0 else -1.0
    area = _area(face, isinstance(shape, Nurbs))
    low, high = box_of(face)
    border = border_of(face, shape, sign)
    return CadFace("", shape, sign, border=border, area=area, low=low, high=high)


def _area(face: Any, spline: bool) -> float:
    """Area of a face, mm^2. The kernel's rule is 1e-4 off across the knots of a spline: there the
    face is cut into Bezier patches."""
    patches = [face]
    if spline:
        cut = ShapeUpgrade_ShapeConvertToBezier(face)
        cut.Set2dConversion(True)
        cut.Set3dConversion(True)
        cut.SetSurfaceConversion(True)
        cut.SetExtrusionMode(True)
        cut.SetRevolutionMode(True)
        if cut.Perform():
            patches = list(parts(cut.Result(), TopAbs_FACE))
    total = 0.0
    for patch in patches:
        found = GProp_GProps()
        BRepGProp.SurfaceProperties_s(patch, found, INTEGRALS, False)
        total += float(found.Mass())
    return total


def shape_of(surface: Any, bounds: tuple[float, float, float, float], name: str) -> Shape:
    """The surface under a face, whose part within ``bounds`` (u0, u1, v0, v1) is needed."""
    seen = GeomAdaptor_Surface(surface)
    kind = seen.GetType()
    if kind == Kind.GeomAbs_Plane:
        direction = triple(seen.Plane().Axis().Direction())
        return Plane(direction, float(direction @ triple(seen.Plane().Location())))
    if kind == Kind.GeomAbs_Sphere:
        return Sphere(triple(seen.Sphere().Location()), seen.Sphere().Radius())
    if kind == Kind.GeomAbs_Cylinder:
        form = seen.Cylinder()
        return Cone(triple(form.Location()), triple(form.Axis().Direction()), form.Radius())
    if kind == Kind.GeomAbs_Cone:
        form = seen.Cone()
        slope = float(np.tan(form.SemiAngle()))
        axis = triple(form.Axis().Direction())
        middle = form.RefRadius() + 0.5 * (bounds[2] + bounds[3]) * float(np.sin(form.SemiAngle()))
        if middle < 0.0:  # the half beyond the apex
            return Cone(triple(form.Location()), axis, -form.RefRadius(), -slope)
        return Cone(triple(form.Location()), axis, form.RefRadius(), slope)
    return _nurbs(surface, bounds, name)


def _nurbs(surface: Any, bounds: tuple[float, float, float, float], name: str) -> Nurbs | Plane:
    """The NURBS form of any surface, or the plane that it is. DesignError where it misses it."""
    u0, u1, v0, v1 = bounds
    part = surface
    if not isinstance(surface, Geom_BSplineSurface):
        part = Geom_RectangularTrimmedSurface(surface, u0, u1, v0, v1, True, True)
    made = GeomConvert.SurfaceToBSplineSurface_s(part)
    found = _as_arrays(made, bounds)
    plane = _plane_of(found)
    if plane is not None:
        return plane
    if _misfit(found, surface, bounds) > NURBS_MISFIT_MM:
        close = GeomConvert_ApproxSurface(
            part, 0.1 * NURBS_MISFIT_MM, GeomAbs_C2, GeomAbs_C2, 14, 14, 400, 0
        )
        if close.HasResult():
            found = _as_arrays(close.Surface(), bounds)
    misfit = _misfit(found, surface, bounds)
    if misfit > NURBS_MISFIT_MM:
        kind = type(surface).__name__.removeprefix("Geom_")
        raise refused(
            "file",
            name,
            f"of surfaces that NURBS render within {NURBS_MISFIT_MM:g} mm",
            f"one ({kind}) is missed by {misfit:.1e} mm; convert it into NURBS in your CAD",
        )
    return found


def _plane_of(found: Nurbs) -> Plane | None:
    """The plane that all poles lie in; some CAD programs write every face as a spline."""
    poles = found.poles.reshape(-1, 3)
    middle = poles.mean(axis=0)
    direction = np.linalg.svd(poles - middle, full_matrices=False)[2][2]
    if np.abs((poles - middle) @ direction).max() > FLAT_MM:
        return None
    return Plane(direction, float(direction @ middle))


def _as_arrays(made: Any, bounds: tuple[float, float, float, float]) -> Nurbs:
    if made.IsUPeriodic() or made.IsVPeriodic():
        made = made.Copy()
        made.Segment(*bounds)  # SetUNotPeriodic left knots that do not fit the poles
    rows, columns = range(1, made.NbUPoles() + 1), range(1, made.NbVPoles() + 1)
    poles = np.array([[triple(made.Pole(i, j)) for j in columns] for i in rows])
    weights = np.array([[made.Weight(i, j) for j in columns] for i in rows], dtype=float)
    knots = []
    for count, knot, times in (
        (made.NbUKnots(), made.UKnot, made.UMultiplicity),
        (made.NbVKnots(), made.VKnot, made.VMultiplicity),
    ):
        knots.append(np.concatenate([[knot(k)] * times(k) for k in range(1, count + 1)]))
    ends = np.array([knots[0][[0, -1]], knots[1][[0, -1]]])
    inner = np.clip(np.array(bounds).reshape(2, 2), ends[:, :1], ends[:, 1:])
    whole = np.abs(inner - ends).max(axis=1) < 1e-9 * np.ptp(ends, axis=1)
    closed = (
        bool(whole[0] and np.allclose(poles[0], poles[-1], atol=1e-9)),
        bool(whole[1] and np.allclose(poles[:, 0], poles[:, -1], atol=1e-9)),
    )
    (a, b), (c, d) = inner.tolist()
    return Nurbs(
        (made.UDegree(), made.VDegree()), knots[0], knots[1], poles, weights, (a, b, c, d), closed
    )


def _misfit(found: Nurbs, surface: Any, bounds: tuple[float, float, float, float]) -> float:
    """Greatest distance of points of a surface from the NURBS made of it, mm."""
    u0, u1, v0, v1 = bounds
    share = np.linspace(0.01, 0.99, 12)
    by_u, by_v = u0 + share * (u1 - u0), v0 + share * (v1 - v0)
    places = np.array([triple(surface.Value(u, v)) for u, v in product(by_u, by_v)])
    return float(np.linalg.norm(places - found.foot(places)[1], axis=1).max())
