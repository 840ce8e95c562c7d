"""Faces of the finger that a mold part could not be drawn off from, by their normals.

A part forms a face of the outline if it lies against it; it comes off along its draw where no
normal there looks against the draw. (What stands in the way further out is for the checks of the
meshes.) Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cadquery as cq
import numpy as np
from numpy.typing import NDArray
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepTools import BRepTools
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Vec
from OCP.TopAbs import TopAbs_IN, TopAbs_Orientation

from fingerdesign.arrays import Array
from fingerdesign.errors import GeometryError
from fingerdesign.mold.flat_sides import FlatSide, direction
from fingerdesign.mold.part import INSERT, wall_name
from fingerdesign.mold.parting import sides_followed
from fingerdesign.mold.plan import MoldPlan, Side
from fingerdesign.mold.plugs import seam

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


AGAINST = -1e-6  # normal . draw below which a face looks against the draw
SAMPLES = 15  # along each of a face's parameters
_ORDER: tuple[Side, ...] = ("+x", "-x", "+z", "-z")  # the corners are the end walls'
_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Undercut:
    """A face (its number in the body, from 1) that looks against the draw of the part that forms
    it; the place where it does most, and normal . draw there."""

    face: int
    part: str
    place: tuple[float, float, float]
    against: float


def undercuts(outline: cq.Solid, plan: MoldPlan) -> tuple[Undercut, ...]:
    """All faces of an outline in mold space that a planned part could not be drawn off from."""
    flat = sides_followed(outline, plan)
    found = []
    for number, face in enumerate(outline.Faces(), start=1):
        points, normals = samples(face)
        names, draws = formed_by(points, normals, plan, flat)
        along = np.einsum("ij,ij->i", normals, draws)
        for name in sorted({str(name) for name in names}):
            rows = np.flatnonzero((names == name) & (along < AGAINST))
            if len(rows):
                worst = rows[np.argmin(along[rows])]
                x, y, z = (float(value) for value in points[worst])
                found.append(Undercut(number, name, (x, y, z), float(along[worst])))
    return tuple(found)


def refuse_undercuts(design: Design, outline: cq.Solid, plan: MoldPlan) -> None:
    """GeometryError that names every undercut face, its place and the part that it would hold."""
    found = undercuts(outline, plan)
    if not found:
        return
    of = "body.step" if design.body.step is not None else "the body"
    said = [
        f"face {each.face} of {of} at ({each.place[0]:.2f}, {each.place[1]:.2f}, "
        f"{each.place[2]:.2f}) mm holds {each.part}"
        for each in found
    ]
    raise GeometryError(
        f"the mold cannot be opened: {'; '.join(said)}. Give the body no faces that look back "
        f"toward its base or its middle, or cast it in another way"
    )


def formed_by(
    points: Array, normals: Array, plan: MoldPlan, flat: dict[Side, FlatSide] | None
) -> tuple[NDArray[np.str_], Array]:
    """The part (n,) that forms the outline at points (n, 3) with outward normals (n, 3), and its
    draw (n, 3); "" and no draw on the base. flat: the sides that the parting follows, or None."""
    names = np.full(len(points), INSERT, dtype="<U40")
    draws = np.tile(_UP, (len(points), 1))
    lower = points[:, 1] < plan.rim
    if flat is not None:
        lower = np.any([face.holds(points, normals) for face in flat.values()], axis=0)
    beyond = {"x": np.zeros(len(points), bool), "z": np.zeros(len(points), bool)}
    for plug in plan.plugs:
        place = np.abs(points[:, 0 if plug.axis == "x" else 2])
        edge = np.array([seam(plan, plug, float(y)) for y in points[:, 1]])
        beyond[plug.axis] = place > edge
    for side in _ORDER:
        away = direction(side)
        outside = points @ away
        if flat is not None:
            mine = flat[side].holds(points, normals)
        elif side.endswith("z"):
            mine = lower & (outside > plan.corner)
        else:
            mine = lower & (np.abs(points[:, 2]) <= plan.corner) & (outside > 0.0)
        upper = beyond[side[1]] & (outside > 0.0) & ~lower
        names[mine | upper], draws[mine | upper] = wall_name(side), away
    base = (points[:, 1] < 1e-5) & (normals[:, 1] < -1.0 + 1e-9)
    names[base], draws[base] = "", 0.0
    return names, draws


def samples(face: cq.Face) -> tuple[Array, Array]:
    """Points (n, 3) within a face and its outward unit normals there (n, 3)."""
    surface, within = BRepAdaptor_Surface(face.wrapped), BRepTopAdaptor_FClass2d(face.wrapped, 1e-7)
    u_low, u_high, v_low, v_high = BRepTools.UVBounds_s(face.wrapped)
    shares = (np.arange(SAMPLES) + 0.5) / SAMPLES
    sign = -1.0 if face.wrapped.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else 1.0
    points, normals = [], []
    for u in u_low + shares * (u_high - u_low):
        for v in v_low + shares * (v_high - v_low):
            if within.Perform(gp_Pnt2d(float(u), float(v))) != TopAbs_IN:
                continue
            where, along_u, along_v = gp_Pnt(), gp_Vec(), gp_Vec()
            surface.D1(float(u), float(v), where, along_u, along_v)
            normal = sign * np.cross(along_u.Coord(), along_v.Coord())
            size = float(np.linalg.norm(normal))
            if size > 1e-12:  # not at a pole
                points.append(where.Coord())
                normals.append(normal / size)
    return np.array(points).reshape(-1, 3), np.array(normals).reshape(-1, 3)
