"""What is bonded into the body: plates (flat or bent, perforated, along x or z) and the core.

A plate's frame says all (layout/frames.py). A perforated flat plate is its holed face drawn through
the thickness; a bent one is an annular sector drawn along its span, out of which straight round
holes are cut along the normal at their middle. Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import cadquery as cq
import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.cad.kernel import (
    Arc,
    Line,
    box,
    circle,
    extruded,
    flat_face,
    one_solid,
    polygon,
    upper_half,
)
from fingerdesign.errors import GeometryError
from fingerdesign.layout.frames import PlateFrame

if TYPE_CHECKING:
    from fingerdesign.design.body import Body


def plate_solid(frame: PlateFrame, half: bool = False) -> cq.Solid:
    """One plate; of one that mirrors in z = 0 also its half z >= 0.

    GeometryError where it lies beyond the surface (its place is not a number), where a half is
    asked of a plate that does not mirror, or where the kernel fails.
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
    """The rigid core's box (of its half z >= 0); GeometryError for a body without one."""
    core = body.core
    if core is None:
        raise GeometryError("the body has no core")
    x = 0.5 * core.width_mm
    z = 0.5 * (core.depth_mm if core.depth_mm is not None else body.depth_mm)
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
    lower, upper = Arc(a, b, centre, -about, radius - v), Arc(c, d, centre, about, radius + v)
    section = flat_face([lower, Line(b, c), upper, Line(d, a)])
    across = frame.to_space(frame.centre, 1.0)[0] - frame.to_space(frame.centre, 0.0)[0]
    return extruded(section, frame.span * across)


@lru_cache(maxsize=32)
def _drilled(frame: PlateFrame) -> cq.Solid:
    """A bent plate about the origin with its holes: drilled once for all plates of a row."""
    drills = [_drill(frame, hole.s, hole.w, hole.radius) for hole in frame.holes]
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


def _drill(frame: PlateFrame, s: float, w: float, radius: float) -> cq.Solid:
    """A cylinder along the normal at (s, w), well beyond the plate's faces."""
    reach = frame.thickness + radius
    start, end = (_place(frame, s, v, w) for v in (-reach, reach))
    way = (end - start) / (2.0 * reach)
    return cq.Solid.makeCylinder(radius, 2.0 * reach, cq.Vector(*start), cq.Vector(*way))


def _place(frame: PlateFrame, s: float, v: float, w: float) -> Array:
    """The point in space, (3,), at a plate's local coordinates."""
    return np.asarray(frame.to_space(frame.from_local(s, v), w)[0])
