"""Outlines of bodies: Body -> one CAD solid, without what is bonded into it.

The section of layout/profile.py, drawn along z (arc, block), turned about the line along x through
the dome's centre (dome) or about y (revolved). Its rounded or chamfered edges are pieces of that
section, so every surface is a plane, a cylinder, a cone, a sphere or a circle revolved, with the
design's radius: no fillet of the kernel's is among them. What is bonded into the body
is drawn by its plate's frame (layout/frames.py): a perforated flat plate is its holed face drawn
through the thickness; a bent one is an annular sector drawn along its span, out of which straight
round holes are cut along the normal at their middle. Importing this module loads the CAD kernel.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import cadquery as cq
import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.cad.kernel import (
    arc,
    box,
    circle,
    extruded,
    flat_face,
    line,
    one_solid,
    polygon,
    revolved,
    upper_half,
)
from fingerdesign.design.body import Body, StepFile
from fingerdesign.design.step import outline_file
from fingerdesign.errors import GeometryError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.outline import Piece, Profile
from fingerdesign.layout.profile import profile_of

FORWARD = np.array([0.0, 0.0, 1.0])  # of the section plane: arcs run anticlockwise about it


def plate_solid(frame: PlateFrame, half: bool = False) -> cq.Solid:
    """One plate; of one that mirrors in z = 0 also its half z >= 0.

    GeometryError where it lies beyond the surface (its place is not a number), where a half is
    requested of a plate that does not mirror, or where the kernel fails.
    """
    what = f"plate {frame.index}"
    if not np.all(np.isfinite(frame.corners())):
        raise GeometryError(f"{what} lies beyond the contact surface: it has no place")
    if half and not frame.mirrors_in_z:
        raise GeometryError(f"{what} does not mirror in z = 0: build the whole finger")
    if half and frame.along == "x" and all(abs(hole.w) > hole.radius for hole in frame.holes):
        holes = tuple(hole for hole in frame.holes if hole.w > 0.0)
        return _whole(replace(frame, low=0.0, holes=holes))
    return upper_half(_whole(frame), what) if half else _whole(frame)


def core_solid(body: Body, half: bool = False) -> cq.Solid:
    """The box of a body's rigid core (of its half z >= 0)."""
    core = body.core
    assert core is not None
    x, z = 0.5 * core.width_mm, 0.5 * body.core_depth_mm
    top = core.bottom_mm + core.height_mm
    return box((-x, core.bottom_mm, 0.0 if half else -z), (x, top, z))


def _whole(frame: PlateFrame) -> cq.Solid:
    radius = frame.bend_radius
    if radius is None:
        return _flat(frame)
    if not 0.5 * frame.thickness < radius or not 0.5 * frame.length < np.pi * radius:
        raise GeometryError(
            f"plate {frame.index}: it cannot be bent to a radius of {radius:.4g} mm"
        )
    return _moved_there(frame) if frame.holes else _bent(frame)


def _flat(frame: PlateFrame) -> cq.Solid:
    s, v = 0.5 * frame.length, 0.5 * frame.thickness
    corners = [
        _place(frame, end, -v, w)
        for end, w in ((-s, frame.low), (s, frame.low), (s, frame.high), (-s, frame.high))
    ]
    upward = frame.direction(frame.normal)
    # Both ends of the span are seen along the same normal: the face's own.
    face_normal = np.cross(corners[1] - corners[0], corners[3] - corners[0])
    holes = [
        circle(_place(frame, hole.s, -v, hole.w), -face_normal, hole.radius) for hole in frame.holes
    ]
    return extruded(flat_face(polygon(corners), holes), frame.thickness * upward)


def _bent(frame: PlateFrame) -> cq.Solid:
    radius = float(frame.bend_radius or 0.0)
    s, v = 0.5 * frame.length, 0.5 * frame.thickness
    centre = frame.to_space(frame.from_local(0.0, -radius), frame.low)[0]
    # About this direction, going from -s to +s is clockwise: the centre lies below.
    about = np.cross(frame.direction(frame.axis), frame.direction(frame.normal))
    a, b, c, d = (
        _place(frame, end, side, frame.low) for end, side in ((-s, -v), (s, -v), (s, v), (-s, v))
    )
    lower, upper = arc(a, b, centre, -about, radius - v), arc(c, d, centre, about, radius + v)
    section = flat_face([lower, line(b, c), upper, line(d, a)])
    across = frame.to_space(frame.centre, 1.0)[0] - frame.to_space(frame.centre, 0.0)[0]
    return extruded(section, frame.span * across)


@lru_cache(maxsize=32)
def _drilled(frame: PlateFrame) -> cq.Solid:
    """A bent plate about the origin with its holes: drilled once for all plates of a row."""
    drills = []
    for hole in frame.holes:  # cylinders along the normal, well beyond the plate's faces
        reach = frame.thickness + hole.radius
        start, end = (_place(frame, hole.s, v, hole.w) for v in (-reach, reach))
        way, place = cq.Vector(*((end - start) / (2.0 * reach))), cq.Vector(*start)
        drills.append(cq.Solid.makeCylinder(hole.radius, 2.0 * reach, place, way))
    return one_solid(_bent(frame).cut(*drills), "a bent plate with its holes")


def _moved_there(frame: PlateFrame) -> cq.Solid:
    """A drilled bent plate, moved from the origin to its place."""
    holes = tuple(replace(hole, w=round(hole.w - frame.middle, 12)) for hole in frame.holes)
    half = round(0.5 * frame.span, 12)
    middle = replace(frame, index=0, place=0.0, y=0.0, angle_deg=0.0, low=-half, high=half)
    plate = _drilled(replace(middle, holes=holes))
    first, second = (frame.direction(np.eye(2)[k]) for k in (0, 1))
    turned = plate.rotate(cq.Vector(0, 0, 0), cq.Vector(*np.cross(first, second)), frame.angle_deg)
    return turned.translate(cq.Vector(*frame.to_space(frame.centre, frame.middle)[0]))


def _place(frame: PlateFrame, s: float, v: float, w: float) -> Array:
    """The point in space, (3,), at a plate's local coordinates."""
    return np.asarray(frame.to_space(frame.from_local(s, v), w)[0])


def outline_solid(body: Body, half: bool = False) -> cq.Solid:
    """The solid of a body (of its half z >= 0) before anything is bonded into it. GeometryError
    where the section or the dome cannot exist, or where the kernel fails."""
    if body.step is not None:
        whole = step_outline(body.step)
        return upper_half(whole, "body.step") if half else whole
    own: cq.Solid | None = body.kind.solid(body, half)
    if own is not None:
        return own
    try:
        profile = profile_of(body)
    except ValueError as error:
        raise GeometryError(f"body: {error}") from error
    if not profile.side_height > 0.0:
        raise GeometryError(
            f"body.edge_radius_mm = {body.edge_radius_mm}: the edge would reach below the base"
        )
    if body.straight:
        low = 0.0 if half else -0.5 * body.depth_mm
        section = flat_face(_section(profile, low, 0.0))
        return extruded(section, FORWARD * (0.5 * body.depth_mm - low))
    if body.kind.turned:
        return _revolved(profile, half)
    return _dome(body, profile, half)


def _section(profile: Profile, z: float, bottom: float) -> list[cq.Edge]:
    """The closed section above y = bottom, in the plane at z, anticlockwise."""
    side, height = profile.half_width, profile.side_height
    start, end = np.array([-side, bottom, z]), np.array([side, bottom, z])
    first, last = np.array([side, height, z]), np.array([-side, height, z])
    pieces = _pieces(profile)
    right = [_edge(piece, z) for piece in pieces[:0:-1]]
    left = [_edge(piece, z, mirrored=True) for piece in pieces[1:]]
    top = _edge(pieces[0], z, whole=True)
    return [line(start, end), line(end, first), *right, top, *left, line(last, start)]


def _pieces(profile: Profile) -> list[Piece]:
    """The profile's pieces but those that the kernel takes for points. Rounding the edge of a half
    circle, which meets its sides smoothly, leaves such a piece."""
    return [piece for piece in profile.pieces if piece.length > 1e-6]


def _edge(piece: Piece, z: float, mirrored: bool = False, whole: bool = False) -> cq.Edge:
    """A piece from its end to its start; mirrored in x = 0, from start to end; or both in one."""
    sign = -1.0 if mirrored else 1.0
    ends = (piece.start, piece.end) if mirrored else (piece.end, piece.start)
    start, end = (np.array([sign * x, y, z]) for x, y in ends)
    if whole:
        end = start * [-1.0, 1.0, 1.0]
    if not piece.radius:
        return line(start, end)
    return arc(start, end, np.array([sign * piece.x, piece.y, z]), FORWARD, piece.radius)


def _revolved(profile: Profile, half: bool) -> cq.Solid:
    """The section's right half turned about y: all round, or half round over z >= 0."""
    side, height = profile.half_width, profile.side_height
    foot, corner = np.zeros(3), np.array([side, 0.0, 0.0])
    crest, edge = np.array([0.0, profile.crest, 0.0]), np.array([side, height, 0.0])
    outline = [_edge(piece, 0.0) for piece in reversed(_pieces(profile))]
    outer = [line(foot, corner), line(corner, edge), *outline, line(crest, foot)]
    # About -y a point on +x moves toward +z.
    turned = revolved(flat_face(outer), foot, np.array([0.0, -1.0, 0.0]), 180 if half else 360)
    return one_solid(turned.clean(), "body outline") if half else turned


def _dome(body: Body, profile: Profile, half: bool) -> cq.Solid:
    """The section turned about the line along x at y = crest - dome radius, within the depth. Half
    a turn gives what is above the axis, with the sides and the curved faces exact; the end planes
    cut it off. What lies below the axis is a box, joined in the middle of the sides."""
    dome, z_end = float(body.dome_radius_mm or 0.0), 0.5 * body.depth_mm
    axis = profile.crest - dome
    reach = profile.side_height - axis  # the least radius of revolution, at the sides
    if not reach > z_end or not axis + np.sqrt(reach**2 - z_end**2) > 0.0:
        raise GeometryError(
            f"body.dome_radius_mm = {dome} is too small: at the sides the dome would end inside "
            f"the depth or below the base"
        )
    lowest = axis + float(np.sqrt(reach**2 - z_end**2))
    floor = 0.5 * (max(axis, 0.0) + lowest) if axis > 0.0 else 0.0
    low_z, side = 0.0 if half else -z_end, profile.half_width
    # Turned from the horizontal through the vertical: all that lies above the axis.
    section = flat_face(_section(profile, 0.0, axis))
    level = section.rotate(cq.Vector(0.0, axis, 0.0), cq.Vector(1.0, axis, 0.0), -90.0)
    above = revolved(level, np.array([0.0, axis, 0.0]), np.array([1.0, 0.0, 0.0]), 180.0)
    block = box((-side - 1.0, floor, low_z), (side + 1.0, profile.crest + 1.0, z_end))
    top = one_solid(above.intersect(block), "body outline")
    if floor == 0.0:
        return top
    foot = box((-side, 0.0, low_z), (side, floor, z_end))
    return one_solid(top.fuse(foot).clean(), "body outline")


def step_outline(step: StepFile) -> cq.Solid:
    """The body's solid, turned and moved. GeometryError where the stored solid cannot be read."""
    stored = outline_file(step)
    try:
        shape = cq.Shape.importBrep(str(stored))
        solids: Sequence[cq.Solid] = [shape] if isinstance(shape, cq.Solid) else shape.Solids()
    except Exception as error:  # the kernel throws its own kinds
        raise GeometryError(f"the stored solid {stored.name} cannot be read: {error}") from error
    if len(solids) != 1:
        raise GeometryError(f"the stored solid {stored.name} holds {len(solids)} solids")
    return solids[0]
