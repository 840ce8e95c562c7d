"""Faces of a CAD solid -> faces that numpy computes with; runs in the worker.

Planes, cylinders, cones, spheres and tori (also circles revolved) keep their closed form; every
other surface becomes a NURBS surface, held against the kernel's own. Importing this module loads
the CAD kernel.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepGProp import BRepGProp, BRepGProp_Face
from OCP.BRepTools import BRepTools
from OCP.Geom import Geom_BSplineSurface, Geom_RectangularTrimmedSurface
from OCP.GeomAbs import (
    GeomAbs_C2,
    GeomAbs_Circle,
    GeomAbs_Cone,
    GeomAbs_Cylinder,
    GeomAbs_Plane,
    GeomAbs_Sphere,
    GeomAbs_SurfaceOfRevolution,
    GeomAbs_Torus,
)
from OCP.GeomAdaptor import GeomAdaptor_Surface
from OCP.GeomConvert import GeomConvert, GeomConvert_ApproxSurface
from OCP.gp import gp_Pnt, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.ShapeUpgrade import ShapeUpgrade_ShapeConvertToBezier
from OCP.TopAbs import TopAbs_FACE

from fingerdesign.arrays import Array
from fingerdesign.design.cad_faces import CadFace
from fingerdesign.design.nurbs import Nurbs
from fingerdesign.design.quadrics import Cone, Plane, Shape, Sphere, Torus
from fingerdesign.geometry.step_border import border_of, triple
from fingerdesign.geometry.step_shape import INTEGRALS, box_of, parts, refused

NURBS_MISFIT_MM = 1e-6  # between a surface and the NURBS made of it; exact but for offset surfaces
FLAT_MM = 1e-7  # CAD files give places to that


def describe(face: Any, name: str) -> CadFace:
    """One face; its name and group are still to be said. ``name``: the file's, for faults."""
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    shape = shape_of(BRep_Tool.Surface_s(face), (u0, u1, v0, v1), name)
    place, outward = gp_Pnt(), gp_Vec()
    # Off the middle, where a symmetric surface may have a pole.
    BRepGProp_Face(face).Normal(u0 + 0.437 * (u1 - u0), v0 + 0.437 * (v1 - v0), place, outward)
    natural = shape.normal(triple(place)[None])[0]
    sign = 1.0 if float(natural @ triple(outward)) > 0.0 else -1.0
    area = _area(face, isinstance(shape, Nurbs))
    low, high = box_of(face)
    return CadFace(shape, sign, border_of(face, shape, sign), "", -1, area, low, high)


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
    if kind == GeomAbs_Plane:
        direction = triple(seen.Plane().Axis().Direction())
        return Plane(direction, float(direction @ triple(seen.Plane().Location())))
    if kind == GeomAbs_Sphere:
        return Sphere(triple(seen.Sphere().Location()), seen.Sphere().Radius())
    if kind == GeomAbs_Cylinder:
        form = seen.Cylinder()
        return Cone(triple(form.Location()), triple(form.Axis().Direction()), form.Radius())
    if kind == GeomAbs_Cone:
        form = seen.Cone()
        slope = float(np.tan(form.SemiAngle()))
        axis = triple(form.Axis().Direction())
        middle = form.RefRadius() + 0.5 * (bounds[2] + bounds[3]) * float(np.sin(form.SemiAngle()))
        if middle < 0.0:  # the half beyond the apex
            return Cone(triple(form.Location()), axis, -form.RefRadius(), -slope)
        return Cone(triple(form.Location()), axis, form.RefRadius(), slope)
    place = _inner_point(surface, bounds)
    if kind == GeomAbs_Torus:
        form = seen.Torus()
        axis, centre = triple(form.Axis().Direction()), triple(form.Location())
        return _torus(centre, axis, form.MajorRadius(), form.MinorRadius(), place)
    if kind == GeomAbs_SurfaceOfRevolution and seen.BasisCurve().GetType() == GeomAbs_Circle:
        found = _circle_revolved(seen, place)
        if found is not None:
            return found
    return _nurbs(surface, bounds, name)


def _inner_point(surface: Any, bounds: tuple[float, float, float, float]) -> Array:
    u0, u1, v0, v1 = bounds
    return triple(surface.Value(u0 + 0.437 * (u1 - u0), v0 + 0.437 * (v1 - v0)))


def _torus(centre: Array, axis: Array, major: float, minor: float, place: Array) -> Torus:
    """The torus part that a point of the face lies on: of a spindle the outer or the inner."""
    both = [Torus(centre, axis, reach, minor) for reach in (major, -major)]
    return min(both, key=lambda torus: abs(float(torus.distance(place[None])[0])))


def _circle_revolved(seen: Any, place: Array) -> Torus | None:
    """A torus, where the circle's plane holds the axis."""
    circle, line = seen.BasisCurve().Circle(), seen.AxeOfRevolution()
    axis, origin = triple(line.Direction()), triple(line.Location())
    middle, across = triple(circle.Location()), triple(circle.Axis().Direction())
    offset = middle - origin
    radial = offset - float(offset @ axis) * axis
    size = 1.0 + float(np.linalg.norm(offset))
    if abs(float(across @ axis)) > 1e-10 or abs(float(across @ radial)) > 1e-9 * size:
        return None
    centre = origin + float(offset @ axis) * axis
    return _torus(centre, axis, float(np.linalg.norm(radial)), circle.Radius(), place)


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
    rows, columns = made.NbUPoles(), made.NbVPoles()
    poles = np.array(
        [[triple(made.Pole(i + 1, j + 1)) for j in range(columns)] for i in range(rows)]
    )
    weights = np.array(
        [[made.Weight(i + 1, j + 1) for j in range(columns)] for i in range(rows)], dtype=float
    )
    knots = []
    for count, knot, times in (
        (made.NbUKnots(), made.UKnot, made.UMultiplicity),
        (made.NbVKnots(), made.VKnot, made.VMultiplicity),
    ):
        knots.append(np.concatenate([[knot(k)] * times(k) for k in range(1, count + 1)]))
    ends = np.array([knots[0][[0, -1]], knots[1][[0, -1]]])
    wanted = np.clip(np.array(bounds).reshape(2, 2), ends[:, :1], ends[:, 1:])
    whole = np.abs(wanted - ends).max(axis=1) < 1e-9 * np.ptp(ends, axis=1)
    closed = (
        bool(whole[0] and np.allclose(poles[0], poles[-1], atol=1e-9)),
        bool(whole[1] and np.allclose(poles[:, 0], poles[:, -1], atol=1e-9)),
    )
    (a, b), (c, d) = wanted.tolist()
    return Nurbs(
        (made.UDegree(), made.VDegree()), knots[0], knots[1], poles, weights, (a, b, c, d), closed
    )


def _misfit(found: Nurbs, surface: Any, bounds: tuple[float, float, float, float]) -> float:
    """Greatest distance of points of a surface from the NURBS made of it, mm."""
    u0, u1, v0, v1 = bounds
    share = np.linspace(0.01, 0.99, 12)
    places = np.array(
        [
            triple(surface.Value(u0 + s * (u1 - u0), v0 + t * (v1 - v0)))
            for s in share
            for t in share
        ]
    )
    return float(np.linalg.norm(places - found.foot(places)[1], axis=1).max())
