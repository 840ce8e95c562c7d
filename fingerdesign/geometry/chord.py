"""How far triangles lie from the CAD face they stand for. Importing this loads the CAD kernel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
from OCP.gp import gp_Pnt, gp_Pnt2d
from OCP.ShapeAnalysis import ShapeAnalysis_Surface
from OCP.TopoDS import TopoDS_Face

from fingerdesign.arrays import Array, IntArray

# Shares of a triangle's corners at which its distance to the face is looked at.
LOOKS = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [1 / 3, 1 / 3, 1 / 3]])
# The kernel keeps the chord on these: it is 0, or curved in one direction only.
SIMPLE = (GeomAbs_SurfaceType.GeomAbs_Plane, GeomAbs_SurfaceType.GeomAbs_Cylinder)


@dataclass(frozen=True)
class Patch:
    """A face with its triangles (t, 3) of points (n, 3), and their parameters (n, 2) on it."""

    face: TopoDS_Face
    points: Array
    triangles: IntArray
    parameters: Array | None


def keeps_chord(patch: Patch, tolerance_mm: float) -> bool:
    """Whether the triangles' edges and middles lie within a tolerance of the face.

    At the same parameters the face is at least as far as its nearest point (much farther at the
    poles of a sphere), so only places that look too far are projected onto it.
    """
    surface = BRepAdaptor_Surface(patch.face)
    if surface.GetType() in SIMPLE:
        return True
    flat = np.einsum("lk,tkd->tld", LOOKS, patch.points[patch.triangles])
    suspects = np.ones(flat.shape[:2], dtype=bool)
    if patch.parameters is not None:
        uv = np.einsum("lk,tkd->tld", LOOKS, patch.parameters[patch.triangles])
        on = np.array([surface.Value(u, v).Coord() for u, v in uv.reshape(-1, 2).tolist()])
        suspects = np.linalg.norm(on.reshape(flat.shape) - flat, axis=2) > tolerance_mm
    whole = BRep_Tool.Surface_s(patch.face)
    for place in flat[suspects].tolist():
        foot = GeomAPI_ProjectPointOnSurf(gp_Pnt(*place), whole)
        if foot.NbPoints() == 0 or foot.LowerDistance() > tolerance_mm:
            return False
    return True


def largest_chord(patch: Patch) -> float:
    """The greatest distance, mm, of the triangles' edges and middles to the face.

    Each place's foot is looked for from its parameters on, by the kernel's Newton iteration; of a
    cylinder the distance is known.
    """
    adaptor = BRepAdaptor_Surface(patch.face)
    if adaptor.GetType() == GeomAbs_SurfaceType.GeomAbs_Plane:
        return 0.0
    places = np.einsum("lk,tkd->tld", LOOKS, patch.points[patch.triangles]).reshape(-1, 3)
    if adaptor.GetType() == GeomAbs_SurfaceType.GeomAbs_Cylinder:
        cylinder = adaptor.Cylinder()
        axis = np.array(cylinder.Axis().Direction().Coord())
        from_axis = np.cross(places - cylinder.Location().Coord(), axis)
        return float(np.abs(np.linalg.norm(from_axis, axis=1) - cylinder.Radius()).max())
    surface = ShapeAnalysis_Surface(BRep_Tool.Surface_s(patch.face))
    if patch.parameters is None:
        starts = [surface.ValueOfUV(gp_Pnt(*place), 1e-9) for place in places.tolist()]
    else:
        uv = np.einsum("lk,tkd->tld", LOOKS, patch.parameters[patch.triangles]).reshape(-1, 2)
        starts = [gp_Pnt2d(u, v) for u, v in uv.tolist()]
    most = 0.0
    for start, place in zip(starts, places.tolist(), strict=True):
        where = gp_Pnt(*place)
        surface.NextValueOfUV(start, where, 1e-9)
        most = max(most, float(surface.Gap()))
    return most
