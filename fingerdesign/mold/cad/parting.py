"""The block around the finger, split into blanks: parts before pins, holes, slots and windows.

Where all four sides are flat, the walls are those faces drawn outward, and the insert is what of
the block is above them; else the walls are what of the block lies below the contact surface's
lowest place (``plan.rim``): end walls beyond |z| = ``plan.corner``, side walls between. A plug
narrows the insert; the walls of its axis take what is beyond. Importing this loads the CAD kernel.
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
from fingerdesign.cad.kernel import box, extruded, flat_face, one_solid, point, polygon
from fingerdesign.errors import GeometryError
from fingerdesign.mold.part import INSERT, comb_names, wall_name
from fingerdesign.mold.plan.plan import SIDES, MoldPlan, Plug, Side

# The flat sides of an outline, and the prisms that go out from them. Loads the CAD kernel.
#
# A mold whose body has four flat sides continues the contact surface outward: each side's face is
# drawn outward as it is, so the walls' tops meet the contact surface along its border, exactly.

NEAR = 1e-6  # mm: that close, a face lies in a plane of the outline's box
AXIS = {"x": 0, "z": 2}


def direction(side: Side) -> Array:
    """The outward unit normal (3,) of a side."""
    found = np.zeros(3)
    found[AXIS[side[1]]] = 1.0 if side[0] == "+" else -1.0
    return found


def across(side: Side) -> Array:
    """The level unit vector (3,) along a side, +x or +z."""
    return np.asarray(np.eye(3)[2 - AXIS[side[1]]])


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


# The insert's block, narrowed by plugs, and what the walls take beyond them. Loads the CAD kernel.
#
# A plug's sides lean by the draft: they are planes through |x| or |z| = ``at_surface`` at the rim's
# height and ``at_top`` at the block's top.


def seam(plan: MoldPlan, plug: Plug, height: float) -> float:
    """|x| or |z| of the plug's sides at a height, mm."""
    share = (height - plan.rim) / (plan.top - plan.rim)
    return plug.at_surface + share * (plug.at_top - plug.at_surface)


def insert_block(plan: MoldPlan, floor: float) -> cq.Solid:
    """The insert's share of the block above ``floor``, finger and walls not yet taken out."""
    low, high = (-plan.reach_x, floor, -plan.reach_z), (plan.reach_x, plan.top, plan.reach_z)
    whole = box(low, high)
    for plug in plan.plugs:
        near, far = (seam(plan, plug, height) for height in (floor, plan.top))
        way = direction("+x" if plug.axis == "x" else "+z")
        section = [
            place * way + height * np.array([0.0, 1.0, 0.0])
            for place, height in ((-near, floor), (near, floor), (far, plan.top), (-far, plan.top))
        ]
        whole = one_solid(whole.intersect(_across(plan, way, section)), INSERT)
    return whole


def beyond_plug(plan: MoldPlan, side: Side, floor: float) -> cq.Solid:
    """What of the block above ``floor`` lies beyond the plug on a side of its axis.

    The corners beyond two plugs are the end walls', which are drawn first.
    """
    plug = next(each for each in plan.plugs if side.endswith(each.axis))
    way = direction(side)
    # Side walls end where their lower part does: farther out there is nothing to stand on.
    reach = plan.half_width + plan.wall_x if plug.axis == "x" else plan.reach_z
    near, far = (seam(plan, plug, height) for height in (floor, plan.top))
    corners = ((near, floor), (reach, floor), (reach, plan.top), (far, plan.top))
    section = [place * way + height * np.array([0.0, 1.0, 0.0]) for place, height in corners]
    piece = _across(plan, way, section)
    others = [each for each in plan.plugs if each.axis == "z"] if plug.axis == "x" else []
    for other in others:
        ends = [beyond_plug(plan, end, floor) for end in ("+z", "-z")]
        piece = one_solid(piece.cut(*ends), f"the corners beyond the plug along {other.axis}")
    return piece


def _across(plan: MoldPlan, way: Array, section: list[Array]) -> cq.Solid:
    """The prism of a section over all of the block across ``way``."""
    reach = plan.reach_z if way[0] else plan.reach_x
    across = np.array([abs(way[2]), 0.0, abs(way[0])])
    return prism_of([corner - reach * across for corner in section], 2.0 * reach * across)


@dataclass(frozen=True)
class Blank:
    """A part before its features. ``part``: what they are worked into; ``filling``: what of it is
    within the filled block, which leaves out the ears."""

    part: cq.Solid
    filling: cq.Solid


@dataclass(frozen=True)
class Parting:
    """An outline in mold space, and the blanks by part name.

    low, high  corners of the block that outline and fillings fill: |x| <= half_width + wall_x
    """

    outline: cq.Solid
    blanks: dict[str, Blank]
    low: tuple[float, float, float]
    high: tuple[float, float, float]


def block_x(plan: MoldPlan) -> float:
    """|x| of the filled block's faces, where the side walls end and the ears begin."""
    return plan.half_width + plan.wall_x


def sides_followed(outline: cq.Solid, plan: MoldPlan) -> dict[Side, FlatSide] | None:
    """The outline's four flat sides; None where the mold's parting cannot follow them."""
    return flat_sides(outline) if plan.corner > plan.half_depth - 1e-6 else None


def parted(outline: cq.Solid, plan: MoldPlan) -> Parting:
    """Split the block around ``outline``, which is in mold space.

    GeometryError where the kernel fails, or makes a part of several pieces.
    """
    flat = sides_followed(outline, plan)
    blocks: dict[str, cq.Solid] = {}
    if flat is not None:
        floor = min(min(each.height_low, each.height_high) for each in flat.values())
        around = {side: _beside(face, plan) for side, face in flat.items()}
        for side, face in flat.items():
            blocks |= _layers(plan, side, face)
    else:
        floor, around = plan.rim, {}
        for side in SIDES:
            blocks |= _below(outline, plan, side)
    above = insert_block(plan, floor).cut(outline, *around.values())
    blocks[INSERT] = one_solid(above.clean(), INSERT)
    for plug in plan.plugs:
        for side in SIDES:
            if side.endswith(plug.axis):
                upper = beyond_plug(plan, side, floor).cut(outline, *around.values())
                name = wall_name(side)
                blocks[name] = one_solid(blocks[name].fuse(upper).clean(), name)
    high = (block_x(plan), plan.top, plan.reach_z)
    low = (-high[0], 0.0, -high[2])
    filled = box(low, high)
    blanks = {name: Blank(part, _within(part, filled, name)) for name, part in blocks.items()}
    return Parting(outline, blanks, low, high)


def _beside(face: FlatSide, plan: MoldPlan) -> cq.Solid:
    """All that lies beside a flat side, out to the block's faces and the ears."""
    if face.side.endswith("x"):
        return face.prism(face.away, plan.reach_x)
    return face.widened(plan.reach_x, face.away, plan.reach_z)


def _layers(plan: MoldPlan, side: Side, face: FlatSide) -> dict[str, cq.Solid]:
    """The sheets of a flat side, and its wall behind them."""
    planned = plan.side(side)
    names = comb_names(side, planned.holding)
    bounds = [face.away + k * planned.sheet for k in range(len(names) + 1)]
    layers = list(zip(names, bounds, bounds[1:], strict=False))
    reach = block_x(plan) if side.endswith("x") else plan.reach_z
    layers.append((wall_name(side), bounds[-1], reach))
    found = {}
    for name, start, end in layers:
        if side.endswith("x"):
            found[name] = face.prism(start, end)
        else:
            found[name] = face.widened(plan.reach_x, start, end)
    return found


def _below(outline: cq.Solid, plan: MoldPlan, side: Side) -> dict[str, cq.Solid]:
    """The wall of a side as what of the block below the rim is outside of the outline.

    Sheets are possible where the side happens to be flat up to the rim.
    """
    planned, across = plan.side(side), side.endswith("x")
    face = plan.half_width if across else plan.corner
    names = comb_names(side, planned.holding)
    if names and not across and plan.corner < plan.half_depth - 1e-6:
        raise GeometryError(f"{names[0]}: the finger's {side} side is not one flat face")
    bounds = [face + k * planned.sheet for k in range(len(names) + 1)]
    first = bounds[-1] if names else (0.0 if across else plan.corner)
    layers = [(wall_name(side), first, block_x(plan) if across else plan.reach_z)]
    layers += zip(names, bounds, bounds[1:], strict=False)
    found = {}
    for name, start, end in layers:
        piece = _slab(side, start, end, plan.corner if across else plan.reach_x, plan.rim)
        found[name] = one_solid(piece if names else piece.cut(outline), name)
    return found


def _slab(side: Side, start: float, end: float, reach: float, top: float) -> cq.Solid:
    """The box from ``start`` to ``end`` outward on a side, +-``reach`` across, 0 to ``top``."""
    away = direction(side)
    across = reach * (1.0 - abs(away))
    one, other = start * away + across, end * away - across
    low, high = [min(a, b) for a, b in zip(one, other, strict=True)], []
    high = [max(a, b) for a, b in zip(one, other, strict=True)]
    low[1], high[1] = 0.0, top
    return box(low, high)


def _within(part: cq.Solid, filled: cq.Solid, name: str) -> cq.Solid:
    """What of a part is in the filled block; itself where it has no ears."""
    bounds = part.BoundingBox()
    reach = filled.BoundingBox().xmax
    if max(-bounds.xmin, bounds.xmax) < reach + 1e-6:
        return part
    return one_solid(part.intersect(filled), name)
