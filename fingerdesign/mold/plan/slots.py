"""Openings that hold the plates' legs: their sizes by how a side holds, the webs between them.

Numbers only; mm.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import cos, degrees, radians, sin

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mold.plan.limits import Limits
from fingerdesign.mold.plan.pieces import ENDS, FLANKS, Holding, Leg, Side, Slot, slot_corners

_LEAST_PLAY_MM = 0.005  # with less a plate cannot be pushed in


def scale_of(design: Design) -> float:
    """The outline's enlargement that the rubber's linear shrinkage s takes back: 1 / (1 - s)."""
    return 1.0 / (1.0 - design.mold.shrinkage_used)


def frames_in_mold(design: Design, scale: float) -> tuple[PlateFrame, ...]:
    """The plates in mold space: middles times ``scale``, sizes, bends and holes unchanged; mm.

    Rubber shrinks toward the origin as it cures and carries the plates' middles with it.
    """
    found = []
    for frame in plate_frames(design):
        shift = (scale - 1.0) * frame.middle
        holes = tuple(replace(hole, w=hole.w + shift) for hole in frame.holes)
        place, y = scale * frame.place, scale * frame.y
        low, high = frame.low + shift, frame.high + shift
        found.append(replace(frame, place=place, y=y, low=low, high=high, holes=holes))
    return tuple(found)


def sides_of_plate(frame: PlateFrame) -> tuple[Side, Side]:
    """The sides at which a plate's legs leave: +-z of a plate along x, +-x of one along z."""
    return ENDS if frame.along == "x" else FLANKS


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
        angle, length, thickness = frame.angle_deg, width, frame.thickness
        turn = radians(angle)
        place, y = frame.place + offset * cos(turn), frame.y + offset * sin(turn)
    else:
        half = 0.5 * width / radius
        outer, inner = radius + 0.5 * frame.thickness, radius - 0.5 * frame.thickness
        foot = inner * cos(half)
        place, y = map(float, frame.from_local(offset, 0.5 * (outer + foot) - radius)[0])
        angle = frame.angle_deg - degrees(offset / radius)
        length, thickness = 2.0 * outer * sin(half), outer - foot
    ends = frame.low, frame.high
    return PlateFrame(frame.index, place, y, angle, length, thickness, *ends, frame.along)


def leg_bar(frame: PlateFrame, leg: Leg) -> PlateFrame:
    """The bar that just holds a leg, from its start to its exit, as a frame."""
    bar, end = turned_bar(frame, leg.width, leg.offset), max(leg.exit, leg.start)
    low, high = (leg.start, end) if leg.side[0] == "+" else (-end, -leg.start)
    return replace(bar, low=low, high=high)


def least_web(design: Design, holding: Holding, limits: Limits) -> float:
    """Least web between slots, and from a slot to an edge, mm: the sheet's or the process's."""
    return design.mold.comb.web_mm if holding == "comb" else limits.feature_mm


def least_slot(design: Design, holding: Holding, limits: Limits) -> float:
    """Least width of a slot, mm: the sheet's or the process's."""
    return design.mold.comb.slot_mm if holding == "comb" else limits.slot_mm


def sheet_thickness(design: Design, holding: Holding) -> float:
    """Thickness of a comb's sheet, mm; 0 without one."""
    return design.mold.comb.sheet_mm if holding == "comb" else 0.0


def slot_of(design: Design, holding: Holding, limits: Limits, bar: PlateFrame, leg: Leg) -> Slot:
    """The slot of a leg whose section ``bar`` just holds. A wall's slot is far wider than the leg,
    which lies in it against the face and the end toward the contact surface; a comb's has the leg
    in its middle."""
    play = design.mold.comb.clearance_mm if holding == "comb" else 2.0 * limits.clearance_mm
    play = max(play, _LEAST_PLAY_MM)
    least = least_slot(design, holding, limits)
    length, width = max(bar.length + play, least), max(bar.thickness + play, least)
    slot = Slot(leg.plate, leg.side, float(bar.place), float(bar.y), bar.angle_deg, length, width)
    return moved(slot, bar, -1.0) if holding == "slots" else slot


def ways(slots: Sequence[Slot]) -> tuple[Array, Array]:
    """Unit vectors (n, 2) that legs are pushed along: across each slot toward the contact surface,
    and along it, too; toward -x or -z where it lies level."""
    across, along = zip(*map(_way, slots), strict=True)
    return np.array(across), np.array(along)


def _way(slot: Slot) -> tuple[tuple[float, float], tuple[float, float]]:
    """The two unit vectors of :func:`ways` for one slot."""
    c, s = cos(radians(slot.angle_deg)), sin(radians(slot.angle_deg))
    return (s, -c) if c < -1e-9 else (-s, c), (-c, -s) if s <= 1e-9 else (c, s)


def moved(slot: Slot, bar: PlateFrame, sign: float) -> Slot:
    """The slot by all of its play to one side of its leg's ``bar``: with -1 the leg, pushed along
    ``ways``, is in its place against a face and an end; with 1 the slot's other ones push it.
    """
    across, along = _way(slot)
    wide, long = 0.5 * sign * (slot.width - bar.thickness), 0.5 * sign * (slot.length - bar.length)
    place, y = (
        centre + wide * a + long * b
        for centre, a, b in zip((bar.place, bar.y), across, along, strict=True)
    )
    return replace(slot, place=place, y=y)


def as_bar(bar: PlateFrame, slot: Slot) -> PlateFrame:
    """A leg's bar in section, widened to its slot."""
    return replace(bar, place=slot.place, y=slot.y, length=slot.length, thickness=slot.width)


def webs(slots: Sequence[Slot]) -> tuple[IntArray, IntArray, Array]:
    """Pairs of slots (first, second) of a side, and their distances, mm; 0: they overlap."""
    pairs = np.triu_indices(len(slots), 1)
    if not len(pairs[0]):
        return *pairs, np.zeros(0)
    corners = slot_corners(slots)
    middle, half = corners.mean(axis=1), 0.5 * np.array([[s.length, s.width] for s in slots])
    axes = (corners[:, [1, 3]] - corners[:, [0]]) / (2.0 * half[..., None])

    def distances(one: IntArray, other: IntArray) -> tuple[Array, BoolArray]:
        """Distances of the others' corners from the rectangles of ``one``, and True where an edge
        of ``one`` parts the two rectangles."""
        local = (corners[other] - middle[one][:, None]) @ axes[one].transpose(0, 2, 1)
        out = np.linalg.norm(np.maximum(np.abs(local) - half[one][:, None], 0.0), axis=2)
        low, high = local.min(axis=1), local.max(axis=1)
        parted = ((low > half[one]) | (high < -half[one])).any(axis=1)
        return out.min(axis=1), parted

    first, parted = distances(*pairs)
    second, parted_too = distances(*pairs[::-1])
    return *pairs, np.where(parted | parted_too, np.minimum(first, second), 0.0)
