"""Openings that hold the plates' legs: their sizes by how a side holds, the webs between them.

Numbers only; mm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.gaps import pair_distances
from fingerdesign.design.layout import Array, PlateFrame
from fingerdesign.mold.frames import turned_bar
from fingerdesign.mold.plan import Holding, Leg, Side, Slot

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.profiles import Limits

_LEAST_SHIM_MM = 0.02  # the thinnest shim stock; less is left as play


def least_web(design: Design, holding: Holding, limits: Limits) -> float:
    """Least web between slots, and from a slot to an edge, mm: the sheet's or the process's."""
    return design.mold.comb.web_mm if holding == "comb" else limits.feature_mm


def least_slot(design: Design, holding: Holding, limits: Limits) -> float:
    """Least width of a slot, mm: the sheet's or the process's."""
    return design.mold.comb.slot_mm if holding == "comb" else limits.slot_mm


def sheets_thickness(design: Design, holding: Holding, limits: Limits) -> float:
    """Thickness of one sheet of a comb or jig, mm; 0 without one."""
    if holding == "comb":
        return design.mold.comb.sheet_mm
    return limits.wall_mm if holding == "jig" else 0.0


def opening_sizes(
    design: Design, holding: Holding, limits: Limits, bar: PlateFrame
) -> tuple[float, float]:
    """Length and width of the slot of a leg whose section ``bar`` just holds, mm."""
    fit, wire = design.mold.comb.clearance_mm, design.mold.wire_mm
    play = fit if holding == "comb" else 2.0 * limits.clearance_mm
    width = max(bar.thickness + play, least_slot(design, holding, limits))
    # A lead lies in the play that a process needs anyway.
    return bar.length + max(play, fit + wire), width


def slot_of(design: Design, holding: Holding, limits: Limits, frame: PlateFrame, leg: Leg) -> Slot:
    """The slot of a leg; its part for the leads lies on the side away from the contact surface."""
    bar = turned_bar(frame, leg.width, leg.offset)
    return slot_of_bar(design, holding, limits, bar, leg)


def slot_of_bar(
    design: Design, holding: Holding, limits: Limits, bar: PlateFrame, leg: Leg
) -> Slot:
    """The slot of a leg whose section ``bar`` just holds."""
    length, width = opening_sizes(design, holding, limits, bar)
    wire = design.mold.wire_mm
    # Down along the plate; along its axis where it lies level.
    way = -1.0 if bar.axis[1] > 1e-9 else 1.0
    place, y = bar.centre + 0.5 * wire * way * bar.axis
    play = width - bar.thickness
    filled = holding == "slots" and play >= _LEAST_SHIM_MM
    shim = play if filled else 0.0
    return Slot(
        leg.plate, leg.side, float(place), float(y), bar.angle_deg, length, width, wire, shim
    )


def as_bar(bar: PlateFrame, slot: Slot) -> PlateFrame:
    """A leg's bar in section, widened to its slot."""
    return replace(bar, place=slot.place, y=slot.y, length=slot.length, thickness=slot.width)


def slot_corners(slots: Sequence[Slot]) -> Array:
    """Corners (n, 4, 2) of slots in their side's plane (place, y), anticlockwise."""
    values = np.array([[o.place, o.y, o.angle_deg, o.length, o.width] for o in slots])
    place, y, angle, length, width = values.reshape(-1, 5).T[..., None]
    s = 0.5 * length * np.array([-1.0, 1.0, 1.0, -1.0])
    v = 0.5 * width * np.array([-1.0, -1.0, 1.0, 1.0])
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.stack([place + s * cosine - v * sine, y + s * sine + v * cosine], axis=-1)


def webs(slots: Sequence[Slot]) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Every pair of slots (first, second) of one side, and the distance between them, mm."""
    first, second = np.triu_indices(len(slots), 1)
    if not len(first):
        return first, second, np.zeros(0)
    corners = slot_corners(slots)
    low, high = corners.min(axis=1), corners.max(axis=1)
    apart = np.maximum(low[second] - high[first], low[first] - high[second])
    distance = np.linalg.norm(np.maximum(apart, 0.0), axis=1)
    near = np.flatnonzero(distance < 2.0)  # a bound from below: enough for those far apart
    distance[near] = pair_distances(corners[first[near]], corners[second[near]])
    return first, second, distance


def on_side(legs: Sequence[Leg], side: Side) -> tuple[Leg, ...]:
    """The legs that leave on one side."""
    return tuple(leg for leg in legs if leg.side == side)


def holding_of(design: Design, legs: Sequence[Leg]) -> Holding:
    """How a side holds its legs: as asked where all leave through one flat face, else by slots."""
    if not legs:
        return "wall"
    return design.mold.plate_fixture if all(leg.flat for leg in legs) else "slots"
