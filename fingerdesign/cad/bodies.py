"""Outlines of bodies: Body -> one CAD solid, without what is bonded into it.

The section of layout/profile.py, drawn along z (arc, block), turned about the line along x through
the dome's centre (dome) or about y (revolved). Its rounded or chamfered edges are pieces of that
section, so every surface is a plane, a cylinder, a cone, a sphere or a circle revolved, with the
radius that the design says: no fillet of the kernel's is among them. Importing this module loads
the CAD kernel.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import cadquery as cq
import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.cad.kernel import (
    Arc,
    Line,
    box,
    extruded,
    flat_face,
    one_solid,
    revolved,
    upper_half,
)
from fingerdesign.design.step import outline_file
from fingerdesign.errors import GeometryError
from fingerdesign.layout.profile import (
    Piece,
    Profile,
    profile_of,
)

if TYPE_CHECKING:
    import cadquery as cq

    from fingerdesign.design.body import Body, StepFile

if TYPE_CHECKING:
    from fingerdesign.design.body import Body


FORWARD = np.array([0.0, 0.0, 1.0])  # of the section plane: arcs run anticlockwise about it


def outline_solid(body: Body, half: bool = False) -> cq.Solid:
    """The solid of a body (of its half z >= 0) before anything is bonded into it.

    GeometryError where the section or the dome cannot exist, or where the kernel fails.
    """
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


def _section(profile: Profile, z: float, bottom: float) -> list[Line | Arc]:
    """The closed section above y = bottom, in the plane at z, anticlockwise."""
    side, height = profile.half_width, profile.side_height
    start, end = np.array([-side, bottom, z]), np.array([side, bottom, z])
    first, last = np.array([side, height, z]), np.array([-side, height, z])
    pieces = _pieces(profile)
    right = [_edge(piece, z) for piece in pieces[:0:-1]]
    left = [_edge(piece, z, mirrored=True) for piece in pieces[1:]]
    top = _edge(pieces[0], z, whole=True)
    return [Line(start, end), Line(end, first), *right, top, *left, Line(last, start)]


def _pieces(profile: Profile) -> list[Piece]:
    """The profile's pieces but those that the kernel takes for points.

    Rounding the edge of a half circle, which meets its sides smoothly, leaves such a piece.
    """
    return [piece for piece in profile.pieces if piece.length > 1e-6]


def _edge(piece: Piece, z: float, mirrored: bool = False, whole: bool = False) -> Line | Arc:
    """A piece from its end to its start; mirrored in x = 0, from start to end; or both in one."""
    sign = -1.0 if mirrored else 1.0
    start, end = (np.array([sign * x, y, z]) for x, y in (piece.end, piece.start))
    if mirrored:
        start, end = end, start
    if whole:
        end = start * [-1.0, 1.0, 1.0]
    if not piece.radius:
        return Line(start, end)
    return Arc(start, end, np.array([sign * piece.x, piece.y, z]), FORWARD, piece.radius)


def _revolved(profile: Profile, half: bool) -> cq.Solid:
    """The section's right half turned about y: all round, or half round over z >= 0."""
    side, height = profile.half_width, profile.side_height
    foot, corner = np.zeros(3), np.array([side, 0.0, 0.0])
    crest, edge = np.array([0.0, profile.crest, 0.0]), np.array([side, height, 0.0])
    outline = [_edge(piece, 0.0) for piece in reversed(_pieces(profile))]
    outer = [Line(foot, corner), Line(corner, edge), *outline, Line(crest, foot)]
    # About -y a point on +x moves toward +z.
    turned = revolved(flat_face(outer), foot, np.array([0.0, -1.0, 0.0]), 180 if half else 360)
    return one_solid(turned.clean(), "body outline") if half else turned


def _dome(body: Body, profile: Profile, half: bool) -> cq.Solid:
    """The section turned about the line along x at y = crest - dome radius, within the depth.

    Half a turn gives what is above the axis, with the sides and the curved faces exact; the end
    planes cut it off. What lies below the axis is a box, joined in the middle of the sides.
    """
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
    section = flat_face(_turned_down(_section(profile, 0.0, axis), axis))
    above = revolved(section, np.array([0.0, axis, 0.0]), np.array([1.0, 0.0, 0.0]), 180.0)
    block = box((-side - 1.0, floor, low_z), (side + 1.0, profile.crest + 1.0, z_end))
    top = one_solid(above.intersect(block), "body outline")
    if floor == 0.0:
        return top
    foot = box((-side, 0.0, low_z), (side, floor, z_end))
    return one_solid(top.fuse(foot).clean(), "body outline")


def _turned_down(section: list[Line | Arc], axis: float) -> list[Line | Arc]:
    """A section at z = 0 turned about the axis into the horizontal plane, toward -z."""

    def turn(place: Array) -> Array:
        return np.array([place[0], axis, axis - place[1]])

    turned: list[Line | Arc] = []
    for part in section:
        if isinstance(part, Line):
            turned.append(Line(turn(part.start), turn(part.end)))
        else:
            up = np.array([0.0, 1.0, 0.0])
            turned.append(Arc(turn(part.start), turn(part.end), turn(part.centre), up, part.radius))
    return turned


def step_outline(step: StepFile) -> cq.Solid:
    """The body's solid, turned and moved, for the CAD kernel (which this loads).

    GeometryError where what was kept cannot be read any more.
    """
    import cadquery as cq

    kept = outline_file(step)
    try:
        shape = cq.Shape.importBrep(str(kept))
        solids: Sequence[cq.Solid] = [shape] if isinstance(shape, cq.Solid) else shape.Solids()
    except Exception as error:  # the kernel throws its own kinds
        raise GeometryError(f"the kept solid {kept.name} cannot be read: {error}") from error
    if len(solids) != 1:
        raise GeometryError(f"the kept solid {kept.name} holds {len(solids)} solids")
    return solids[0]
