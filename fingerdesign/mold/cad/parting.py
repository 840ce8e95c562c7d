"""The block around the finger, split into blanks: parts before pins, holes, slots and windows.

Where all four sides are flat, the walls are those faces drawn outward, and the insert is what of
the block is above them; else the walls are what of the block lies below the contact surface's
lowest place (``plan.rim``): end walls beyond |z| = ``plan.corner``, side walls between. A plug
narrows the insert; the walls of its axis take what is beyond. Of an open mold, half frames are what
of all four walls lies on either side of z = 0. Importing this loads the CAD kernel.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cadquery as cq
import numpy as np
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeVertex,
    BRepBuilderAPI_MakeWire,
)
from OCP.TopTools import TopTools_ListOfShape

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.cad.kernel import box, extruded, flat_face, one_solid, polygon
from fingerdesign.errors import GeometryError
from fingerdesign.mold.part import INSERT, OUTER, Point
from fingerdesign.mold.plan.pieces import (
    ENDS,
    FLANKS,
    SIDES,
    Plug,
    Side,
    SidePlan,
    across,
    direction,
    in_space,
    wall_name,
)
from fingerdesign.mold.plan.plan import MoldPlan

TAB_MM = (6.0, 4.0)  # at both ends of an outer comb: its reach, and its height
NEAR = 1e-6  # mm: that close, a face lies in a plane of the outline's box


@dataclass(frozen=True)
class FlatSide:
    """One flat side of an outline, normal to the side: drawn outward as it is, it makes walls
    whose tops meet the contact surface along its border.

    top   its edges to the contact surface, those that are not at y = 0 nor at its ends
    height_low, height_high   of its upper corners along the other horizontal axis, mm
    """

    side: Side
    face: cq.Face
    top: tuple[cq.Edge, ...]
    height_low: float
    height_high: float

    @property
    def away(self) -> float:
        """Distance of the face from the mid-plane, mm."""
        return float(np.array(self.face.Center().toTuple()) @ direction(self.side))

    def drawn(self, reach: float, start: float, end: float) -> cq.Solid:
        """The face drawn outward between two distances from the mid-plane; at an end, widened to
        +-``reach``, level with its upper corners there."""
        face = self.face if self.side.endswith("x") else self._widened(reach)
        way, first = direction(self.side), start - self.away
        moved = face.translate(cq.Vector(*(first * way))) if abs(first) > 1e-12 else face
        return extruded(moved, (end - start) * way)

    def strips(self, reach: float, start: float, end: float) -> tuple[cq.Solid, cq.Solid]:
        """Make what :meth:`drawn` of an end has beyond the face itself: a box to the left, one to
        the right, out to +-``reach``."""
        corners = [vertex.toTuple() for edge in self.top for vertex in edge.Vertices()]
        places = np.array(corners) @ across(self.side)
        low, high = float(places.min()), float(places.max())
        return (
            slab(self.side, (-reach, 0.0, start), (low, self.height_low, end)),
            slab(self.side, (high, 0.0, start), (reach, self.height_high, end)),
        )

    def holds(self, points: Array, normals: Array) -> BoolArray:
        """Test if points (n, 3) of the outline with normals (n, 3) lie on the face, (n,)."""
        way = direction(self.side)
        return np.asarray((points @ way > self.away - 1e-5) & (normals @ way > 1.0 - 1e-9))

    def _widened(self, reach: float) -> cq.Face:
        """The face within the ground, its own top and the steps out to +-reach."""
        corners = [v for edge in self.top for v in edge.Vertices()]
        order = np.argsort(np.array([v.toTuple() for v in corners]) @ across(self.side))
        steps = ((-reach, self.height_low), (-reach, 0.0), (reach, 0.0), (reach, self.height_high))
        places = [cq.Vector(*in_space(self.side, *step, self.away)).toPnt() for step in steps]
        chain = [
            corners[order[0]].wrapped,
            *(BRepBuilderAPI_MakeVertex(place).Vertex() for place in places),
            corners[order[-1]].wrapped,
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
    corners = np.array([vertex.toTuple() for vertex in outline.Vertices()])
    found: dict[Side, FlatSide] = {}
    flat = [face for face in outline.Faces() if face.geomType() == "PLANE"]
    normals = [np.array(face.normalAt().toTuple()) for face in flat]
    for side in SIDES:
        faces = [f for f, n in zip(flat, normals, strict=True) if n @ direction(side) > 1.0 - 1e-12]
        if len(faces) != 1 or faces[0].innerWires():
            return None
        own = _flat_side(side, faces[0], corners @ across(side))
        if own is None or abs(own.away - (corners @ direction(side)).max()) > NEAR:
            return None
        found[side] = own
    return found


def _flat_side(side: Side, face: cq.Face, places: Array) -> FlatSide | None:
    """The side of an outline whose corners lie at ``places`` along it."""
    top: list[cq.Edge] = []
    bounds, heights = (places.min(), places.max()), [-np.inf, -np.inf]
    for edge in face.outerWire().Edges():
        ends = np.array([vertex.toTuple() for vertex in edge.Vertices()])
        straight = edge.geomType() == "LINE"
        if straight and np.all(np.abs(ends[:, 1]) < NEAR):
            continue
        for k, bound in enumerate(bounds):
            if straight and np.all(np.abs(ends @ across(side) - bound) < NEAR):
                heights[k] = max(heights[k], float(ends[:, 1].max()))
                break
        else:
            top.append(edge)
    if not top or not np.all(np.isfinite(heights)):
        return None
    return FlatSide(side, face, tuple(top), *heights)


def prism_of(corners: Sequence[Array] | Array, vector: Array) -> cq.Solid:
    """The prism of a flat polygon (n, 3), moved by ``vector``."""
    return extruded(flat_face(polygon(corners)), vector)


def block(one: Sequence[float] | Array, other: Sequence[float] | Array) -> cq.Solid:
    """The box between two opposite corners, in any order."""
    return box(np.minimum(one, other).tolist(), np.maximum(one, other).tolist())


def slab(side: Side, near: Point, far: Point) -> cq.Solid:
    """The box between two corners (place along a side, height, distance outward)."""
    return block(in_space(side, *near), in_space(side, *far))


def seam(plan: MoldPlan, plug: Plug, height: float) -> float:
    """|x| or |z| at a height, mm, of a plug's sides, which lean by the draft: planes through
    ``at_surface`` at the rim's height and ``at_top`` at the block's top."""
    share = (height - plan.rim) / (plan.top - plan.rim)
    return plug.at_surface + share * (plug.at_top - plug.at_surface)


def insert_block(plan: MoldPlan, floor: float) -> cq.Solid:
    """The insert's share of the block above ``floor``, finger and walls not yet taken out."""
    low, high = (-plan.reach_x, floor, -plan.reach_z), (plan.reach_x, plan.top, plan.reach_z)
    whole = box(low, high)
    for plug in plan.plugs:
        near, far = (seam(plan, plug, height) for height in (floor, plan.top))
        section = ((-near, floor), (near, floor), (far, plan.top), (-far, plan.top))
        across_it = _across(plan, "+x" if plug.axis == "x" else "+z", section)
        whole = one_solid(whole.intersect(across_it), INSERT)
    return whole


def beyond_plug(plan: MoldPlan, side: Side, floor: float) -> cq.Solid:
    """Cut what of the block above ``floor`` lies beyond the plug on a side of its axis.

    The corners beyond two plugs are the end walls', which are drawn first.
    """
    plug = next(each for each in plan.plugs if side.endswith(each.axis))
    # Side walls end where their lower part does: farther out there is nothing to stand on.
    reach = plan.block_x if plug.axis == "x" else plan.reach_z
    near, far = (seam(plan, plug, height) for height in (floor, plan.top))
    section = ((near, floor), (reach, floor), (reach, plan.top), (far, plan.top))
    piece = _across(plan, side, section)
    others = [each for each in plan.plugs if each.axis == "z"] if plug.axis == "x" else []
    for other in others:
        ends = [beyond_plug(plan, end, floor) for end in ("+z", "-z")]
        piece = one_solid(piece.cut(*ends), f"the corners beyond the plug along {other.axis}")
    return piece


def _across(plan: MoldPlan, side: Side, section: Sequence[tuple[float, float]]) -> cq.Solid:
    """The prism of a section (distance outward, height) over all of the block along a side."""
    reach = plan.reach_z if side.endswith("x") else plan.reach_x
    corners = [in_space(side, -reach, height, out) for out, height in section]
    return prism_of(corners, 2.0 * reach * across(side))


def sides_followed(outline: cq.Solid, plan: MoldPlan) -> dict[Side, FlatSide] | None:
    """The outline's four flat sides; None where the mold's parting cannot follow them."""
    return flat_sides(outline) if plan.corner > plan.half_depth - 1e-6 else None


def parted(outline: cq.Solid, plan: MoldPlan) -> dict[str, tuple[cq.Solid, cq.Solid]]:
    """Split the block around ``outline``, which is in mold space: by part name the blank that
    features are worked into, and what of it is within the filled block, which leaves out the ears.

    GeometryError where the kernel fails, or makes a part of several pieces.
    """
    flat = sides_followed(outline, plan)
    floor, around = plan.rim, list[cq.Solid]()
    if flat is not None:
        floor = min(min(each.height_low, each.height_high) for each in flat.values())
        around = [
            face.drawn(plan.reach_x, face.away, plan.reach(side)) for side, face in flat.items()
        ]
    blocks: dict[str, cq.Solid] = {}
    sides, make = (SIDES, _layers) if plan.pour == "closed" else (ENDS, _framed)
    for side in sides:
        blocks |= make(outline, plan, side, flat)
    above = insert_block(plan, floor).cut(outline, *around)
    blocks[INSERT] = one_solid(above.clean(), INSERT)
    for side in [side for plug in plan.plugs for side in SIDES if side.endswith(plug.axis)]:
        name = wall_name(side)
        upper = beyond_plug(plan, side, floor).cut(outline, *around)
        blocks[name] = one_solid(blocks[name].fuse(upper).clean(), name)
    filled = box(*plan.block)
    return {
        name: (part, part if name.endswith(OUTER) else _within(part, filled, name))
        for name, part in blocks.items()
    }


def _layers(
    outline: cq.Solid, plan: MoldPlan, side: Side, flat: dict[Side, FlatSide] | None
) -> dict[str, cq.Solid]:
    """The comb of a side, and its wall behind it.

    Where sides are not ``flat``, the wall is what of the block below the rim is outside of the
    outline; a comb is possible where the side happens to be flat up to the rim.
    """
    planned, flank = plan.by_side[side], side.endswith("x")
    end = plan.block_x if flank else plan.reach_z
    if flat is not None:
        layers = _bounds(planned, flat[side].away, flat[side].away, end)
        return {part: flat[side].drawn(plan.reach_x, *ends) for part, ends in layers.items()}
    if planned.comb and not flank and plan.corner < plan.half_depth - 1e-6:
        raise GeometryError(f"{planned.comb}: the finger's {side} side is not one flat face")
    inner, reach = (plan.half_width, plan.corner) if flank else (plan.corner, plan.reach_x)
    found = {}
    layers = _bounds(planned, inner, 0.0 if flank else inner, end)
    for part, (start, stop) in layers.items():
        piece = slab(side, (-reach, 0.0, start), (reach, plan.rim, stop))
        found[part] = one_solid(piece if planned.comb else piece.cut(outline), part)
    return found


def _bounds(
    planned: SidePlan, inner: float, wall: float, end: float
) -> dict[str, tuple[float, float]]:
    """Distances between which a side's comb and wall lie; a wall without one begins at ``wall``."""
    name = wall_name(planned.side)
    if not planned.comb:
        return {name: (wall, end)}
    behind = inner + planned.sheet
    return {planned.comb: (inner, behind), name: (behind, end)}


def _framed(
    outline: cq.Solid, plan: MoldPlan, end: Side, flat: dict[Side, FlatSide] | None
) -> dict[str, cq.Solid]:
    """A half frame of an open mold, and its comb: as large as the finger's end face, in the frame's
    end, so that the frame slides off it and off the plates' legs."""
    planned, reach, deep = plan.by_side[end], plan.reach_x, plan.reach_z
    name, comb = planned.wall, planned.comb
    half = slab(end, (-reach, 0.0, 0.0), (reach, plan.rim if flat is None else plan.top, deep))
    if flat is None:
        if comb:
            raise GeometryError(f"{comb}: the finger's {end} side is not one flat face")
        return {name: one_solid(half.cut(outline), name)}
    own = flat[end]
    behind = own.away + planned.sheet if comb else own.away
    whole = own.drawn(reach, behind, deep)
    flanks = [flat[side].drawn(reach, flat[side].away, reach).intersect(half) for side in FLANKS]
    found = {}
    if comb:
        found[comb] = extruded(own.face, planned.sheet * direction(end))
        # Not cut out: of curves that two solids share, the kernel's difference may be nothing.
        flanks += own.strips(reach, own.away, behind)
    if planned.outer and planned.outer_comb:
        outer = planned.outer
        far = (outer.half, outer.high, deep + planned.sheet)
        sheet = slab(end, (-outer.half, outer.low, deep), far)
        middle = 0.5 * (outer.low + outer.high)
        low, high = middle - 0.5 * TAB_MM[1], middle + 0.5 * TAB_MM[1]
        reach = outer.half + TAB_MM[0]
        tabs = slab(end, (-reach, low, deep), (reach, high, deep + planned.sheet))
        found[planned.outer_comb] = one_solid(sheet.fuse(tabs).clean(), planned.outer_comb)
    return {**found, name: one_solid(whole.fuse(*flanks).clean(), name)}


def _within(part: cq.Solid, filled: cq.Solid, name: str) -> cq.Solid:
    """Cut a part to the filled block; itself where it has no ears."""
    bounds = part.BoundingBox()
    reach = filled.BoundingBox().xmax
    if max(-bounds.xmin, bounds.xmax) < reach + 1e-6:
        return part
    return one_solid(part.intersect(filled), name)
