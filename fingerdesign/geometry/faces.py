"""Names of a finger's faces: base, contact, side, end, symmetry, plate_0, ..., core.

The faces of the plain outline are named, where every one is whole; what the fuse made of each keeps
its name. Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import cadquery as cq
import numpy as np
from OCP.BOPTools import BOPTools_AlgoTools3D
from OCP.gp import gp_Pnt, gp_Pnt2d
from OCP.IntTools import IntTools_Context

from fingerdesign.errors import GeometryError

if TYPE_CHECKING:
    from fingerdesign.design.body_table import Body, StepFile
    from fingerdesign.geometry.fuse import Fused

FACE_NAMES = ("base", "contact", "side", "end", "symmetry")
NEAR_MM = 1e-5  # positions of flat faces are exact to the kernel's 1e-7


def named_faces(
    body: Body, outline: cq.Solid, parts: Fused, half: bool
) -> dict[str, tuple[cq.Face, ...]]:
    """The outside of body, plates and core by name, and all faces of each plate and the core.

    GeometryError where the outline lacks a face that its shape must have.
    """
    whole = outline.Faces()
    names = step_face_names(body.step, whole, half) if body.step is not None else None
    names = names or [face_name(body, face, half) for face in whole]
    wanted = face_names(body, half) if body.step is None else ("base", "contact", *names)
    named: dict[str, list[cq.Face]] = {name: [] for name in wanted}
    for name, pieces in zip(names, parts.outer, strict=True):
        if name not in named:
            raise GeometryError(f"a face of the body was taken for its {name!r} face: it has none")
        named[name] += pieces
    for name, faces in named.items():
        if not faces:
            raise GeometryError(f"no face of the body was recognised as its {name!r} face")
    inserts = {name: solid.Faces() for name, solid in parts.inserts.items()}
    return {name: tuple(faces) for name, faces in (named | inserts).items()}


def face_names(body: Body, half: bool) -> tuple[str, ...]:
    """The names that the outside of a parametric body has."""
    lacking = set() if half else {"symmetry"}
    if body.shape == "revolved":
        lacking.add("end")
    return tuple(name for name in FACE_NAMES if name not in lacking)


def face_name(body: Body, face: cq.Face, half: bool) -> str:
    """Name of one face of a parametric body's outline; what is none of the others is contact."""
    if face.geomType() == "CYLINDER" and body.shape == "revolved":
        return "side"
    if face.geomType() != "PLANE":
        return "contact"
    bounds = face.BoundingBox(1e-7)
    if bounds.ylen < NEAR_MM and abs(bounds.ymin) < NEAR_MM:
        return "base"
    if half and _in_symmetry_plane(face):
        return "symmetry"
    if bounds.xlen < NEAR_MM and abs(abs(bounds.xmin) - 0.5 * body.width_mm) < NEAR_MM:
        return "side"
    if bounds.zlen < NEAR_MM and abs(abs(bounds.zmin) - 0.5 * body.depth_mm) < NEAR_MM:
        return "end"
    return "contact"


def step_face_names(step: StepFile, faces: list[cq.Face], half: bool) -> list[str]:
    """Names of the faces of a STEP body's outline (of its half), as the rules of its table say.

    Each goes by a place in its middle, where exactly one of the file's faces is near.
    """
    from fingerdesign.design.step_facts import step_facts

    places = []
    for face in faces:
        place, uv = gp_Pnt(), gp_Pnt2d()
        if BOPTools_AlgoTools3D.PointInFace_s(face.wrapped, place, uv, IntTools_Context()) != 0:
            raise GeometryError("the CAD kernel found no place within a face of body.step")
        places.append(place.Coord())
    names = [str(name) for name in step_facts(step).names(np.array(places))]
    cut = [half and _in_symmetry_plane(face) for face in faces]
    return ["symmetry" if own else name for own, name in zip(cut, names, strict=True)]


def _in_symmetry_plane(face: cq.Face) -> bool:
    bounds = face.BoundingBox(1e-7)
    return bool(face.geomType() == "PLANE" and bounds.zlen < NEAR_MM and abs(bounds.zmin) < NEAR_MM)
