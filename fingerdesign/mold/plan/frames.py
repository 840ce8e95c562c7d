"""Where plates and their legs lie in mold space, as frames: numbers only.

Rubber shrinks toward the origin as it cures, and carries the plates' middles with it;
metal does not. So in the mold middles are farther out by ``scale``, and plates keep their size.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.layout.frames import PlateFrame, plate_frames
from fingerdesign.mold.plan.plan import Leg, Side

if TYPE_CHECKING:
    from fingerdesign.design.body import Core
    from fingerdesign.design.schema import Design


def scale_of(design: Design) -> float:
    """The outline's enlargement that the rubber's linear shrinkage s takes back: 1 / (1 - s)."""
    return 1.0 / (1.0 - design.mold.shrinkage_used)


def frames_in_mold(design: Design, scale: float) -> tuple[PlateFrame, ...]:
    """The plates in mold space: middles times ``scale``, sizes, bends and holes unchanged; mm."""
    found = []
    for frame in plate_frames(design):
        shift = (scale - 1.0) * frame.middle
        holes = tuple(replace(hole, w=hole.w + shift) for hole in frame.holes)
        found.append(
            replace(
                frame,
                place=scale * frame.place,
                y=scale * frame.y,
                low=frame.low + shift,
                high=frame.high + shift,
                holes=holes,
            )
        )
    return tuple(found)


def core_in_mold(core: Core, scale: float) -> Core:
    """The core in mold space: its middle moves with the rubber, one on the base stays there."""
    if core.bottom_mm == 0.0:
        return core
    middle = scale * (core.bottom_mm + 0.5 * core.height_mm)
    return core.model_copy(update={"bottom_mm": middle - 0.5 * core.height_mm})


def sides_of_plate(frame: PlateFrame) -> tuple[Side, Side]:
    """The sides at which a plate's legs leave: +-z of a plate along x, +-x of one along z."""
    return ("+z", "-z") if frame.along == "x" else ("+x", "-x")


def end_of(frame: PlateFrame, side: Side) -> float:
    """Distance of the plate's end on ``side`` from the mid-plane, along the side's direction."""
    return frame.high if side[0] == "+" else -frame.low


def turned_bar(frame: PlateFrame, width: float, offset: float) -> PlateFrame:
    """The straight bar that just holds a strip of the plate, in section, with the plate's span.

    The strip is ``width`` wide along the plate, centred ``offset`` from its centre. A bent plate's
    strip is curved: the bar is thicker by its sagitta and turned along its tangent.
    """
    radius = frame.bend_radius
    if radius is None:
        place, y = frame.from_local(offset, 0.0)[0]
        angle, length, thickness = frame.angle_deg, width, frame.thickness
    else:
        half = 0.5 * width / radius
        outer, inner = radius + 0.5 * frame.thickness, radius - 0.5 * frame.thickness
        foot = inner * float(np.cos(half))
        place, y = frame.from_local(offset, 0.5 * (outer + foot) - radius)[0]
        angle = frame.angle_deg - float(np.degrees(offset / radius))
        length, thickness = 2.0 * outer * float(np.sin(half)), outer - foot
    return replace(
        frame,
        place=float(place),
        y=float(y),
        angle_deg=angle,
        length=length,
        thickness=thickness,
        bend_radius=None,
        holes=(),
    )


def leg_bar(frame: PlateFrame, leg: Leg, until: float | None = None) -> PlateFrame:
    """The bar that just holds a leg, from its start to ``until`` (absent: its tip), as a frame."""
    bar = turned_bar(frame, leg.width, leg.offset)
    end = max(leg.tip if until is None else until, leg.start)
    low, high = (leg.start, end) if leg.side[0] == "+" else (-end, -leg.start)
    return replace(bar, low=low, high=high)
