"""What is cast into the finger, as solids in mold space: plates with their legs, and the core.

A flat plate with legs is one holed face drawn through its thickness. A bent plate's legs are
pieces of the same bent sheet, joined to it. Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import cadquery as cq
import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.cad.kernel import box, circle, extruded, flat_face, one_solid, polygon
from fingerdesign.cad.plates import core_solid, plate_solid
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.plan.frames import core_in_mold
from fingerdesign.mold.plan.plan import Leg, MoldPlan

if TYPE_CHECKING:
    from fingerdesign.design.body import Body


_NEAR = 1e-9
_BEYOND_MM = 1.0  # how far a tool reaches out of what it cuts


def cut_plate(frame: PlateFrame, legs: tuple[Leg, ...]) -> cq.Solid:
    """A plate as it is cut from sheet and lies in the mold: its span with its legs, one solid.

    GeometryError where the kernel fails, or where a leg does not touch its plate.
    """
    own = [leg for leg in legs if leg.plate == frame.index and leg.tip > leg.start + _NEAR]
    what = f"plate {frame.index} with its legs"
    if frame.bend_radius is None:
        return _flat(frame, own)
    if not own:
        return plate_solid(frame)
    pieces = [_bent_leg(frame, leg) for leg in own]
    return one_solid(plate_solid(frame).fuse(*pieces).clean(), what)


def cut_plates(plan: MoldPlan) -> tuple[cq.Solid, ...]:
    """Every plate with its legs, in the order of the plan's frames."""
    return tuple(cut_plate(frame, plan.legs) for frame in plan.frames)


def core_block(body: Body, scale: float) -> cq.Solid:
    """The core in mold space, before its holes; GeometryError for a body without one."""
    return core_solid(_body_in_mold(body, scale))


def core_room(body: Body, scale: float, half_depth: float) -> cq.Solid:
    """What the core takes from the rubber: itself, drawn out of the faces that it reaches."""
    moved = _body_in_mold(body, scale)
    bounds = core_solid(moved).BoundingBox()
    core = moved.core
    assert core is not None
    low = 0.0 if core.bottom_mm == 0.0 else core.bottom_mm
    floor = low - _BEYOND_MM if low == 0.0 else low
    z = 0.5 * (core.depth_mm if core.depth_mm is not None else body.depth_mm)
    if z > half_depth - 1e-6:
        z += _BEYOND_MM
    x = 0.5 * core.width_mm
    return box((-x, floor, -z), (x, min(low + core.height_mm, bounds.ymax + 1.0), z))


def _body_in_mold(body: Body, scale: float) -> Body:
    core = None if body.core is None else core_in_mold(body.core, scale)
    return body.model_copy(update={"core": core})


def _flat(frame: PlateFrame, legs: list[Leg]) -> cq.Solid:
    """The holed outline of plate and legs, drawn from the lower to the upper side."""
    outline = flat_outline(frame, legs)
    v = 0.5 * frame.thickness
    corners = [frame.to_space(frame.from_local(s, -v), w)[0] for s, w in outline]
    upward = frame.direction(frame.normal)
    turn = float(np.sign(_area(outline)))
    first, second = frame.direction(frame.axis), _span_direction(frame)
    face_normal = turn * np.cross(first, second)
    holes = [
        circle(frame.to_space(frame.from_local(h.s, -v), h.w)[0], -face_normal, h.radius)
        for h in frame.holes
    ]
    return extruded(flat_face(polygon(corners), holes), frame.thickness * upward)


def flat_outline(frame: PlateFrame, legs: list[Leg]) -> list[tuple[float, float]]:
    """Corners (s along the plate, w across the row) of plate and legs, anticlockwise, without
    those that lie on a straight line."""
    half = 0.5 * frame.length
    ways = {leg.side[0]: leg for leg in legs}
    corners = [(-half, frame.low)]
    if "-" in ways:
        corners += _leg_corners(ways["-"], frame.low, -1.0)
    corners += [(half, frame.low), (half, frame.high)]
    if "+" in ways:
        corners += _leg_corners(ways["+"], frame.high, 1.0)
    corners.append((-half, frame.high))
    return _without_idle(corners)


def _leg_corners(leg: Leg, end: float, sign: float) -> list[tuple[float, float]]:
    """Four corners of a leg, going from -s to +s at the low end, from +s to -s at the high one."""
    near, far = leg.offset + 0.5 * sign * leg.width, leg.offset - 0.5 * sign * leg.width
    tip = sign * leg.tip
    return [(near, end), (near, tip), (far, tip), (far, end)]


def _without_idle(corners: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """A closed polygon without double corners and those between neighbours in one line."""
    kept = list(corners)
    while True:
        for k, here in enumerate(kept):
            before, after = kept[k - 1], kept[(k + 1) % len(kept)]
            one = (here[0] - before[0], here[1] - before[1])
            two = (after[0] - here[0], after[1] - here[1])
            if abs(one[0] * two[1] - one[1] * two[0]) < _NEAR:
                del kept[k]
                break
        else:
            return kept


def _area(corners: list[tuple[float, float]]) -> float:
    x, y = np.array(corners).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def _span_direction(frame: PlateFrame) -> Array:
    """Unit direction in space along which the span grows."""
    ends = [frame.to_space(frame.centre, across)[0] for across in (0.0, 1.0)]
    return np.asarray(ends[1] - ends[0])


def _bent_leg(frame: PlateFrame, leg: Leg) -> cq.Solid:
    """A leg of a bent plate: a strip of the same bent sheet beyond the plate's end."""
    radius = float(frame.bend_radius or 0.0)
    place, y = frame.from_local(leg.offset, 0.0)[0]
    ends = sorted((leg.start, leg.tip)) if leg.side[0] == "+" else sorted((-leg.tip, -leg.start))
    strip = replace(
        frame,
        place=float(place),
        y=float(y),
        angle_deg=frame.angle_deg - float(np.degrees(leg.offset / radius)),
        length=leg.width,
        low=ends[0],
        high=ends[1],
        holes=(),
    )
    return plate_solid(strip)
