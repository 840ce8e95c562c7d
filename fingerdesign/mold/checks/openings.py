"""The openings that a mold's plan makes in the cavity's wall: slots and round holes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.mold.plan import CorePin, MoldPlan, Slot


def across(side: str, points: Array) -> tuple[Array, Array]:
    """Coordinates (place, distance outward) of points (n, 3) as seen from a side."""
    sign = 1.0 if side[0] == "+" else -1.0
    if side.endswith("z"):
        return points[:, 0], sign * points[:, 2]
    return points[:, 2], sign * points[:, 0]


def from_slot(slot: Slot, points: Array) -> Array:
    """How far points (n, 3) on a slot's side lie beyond it and its relief, mm; negative: within.
    NaN for points of the other half of the mold."""
    place, out = across(slot.side, points)
    angle = np.radians(slot.angle_deg)
    dx, dy = place - slot.place, points[:, 1] - slot.y
    along = np.abs(dx * np.cos(angle) + dy * np.sin(angle)) - 0.5 * slot.length
    over = np.abs(dy * np.cos(angle) - dx * np.sin(angle)) - 0.5 * slot.width
    beyond = np.hypot(np.maximum(along, 0.0), np.maximum(over, 0.0))
    beyond = beyond + np.minimum(np.maximum(along, over), 0.0)
    if slot.relief:
        x, y = slot.relief_centre
        beyond = np.minimum(beyond, np.hypot(place - x, points[:, 1] - y) - 0.5 * slot.relief)
    return np.asarray(np.where(out > 0.0, beyond, np.nan))


def from_pin(pin: CorePin, points: Array) -> Array:
    """How far points (n, 3) lie beyond a core pin's hole, mm; NaN for the other half."""
    place, out = across(pin.side, points)
    beyond = np.hypot(place - pin.place, points[:, 1] - pin.y) - 0.5 * pin.diameter
    return np.asarray(np.where(out > 0.0, beyond, np.nan))


def planned(
    plan: MoldPlan, points: Array, clearance_mm: float, slack_mm: float
) -> NDArray[np.bool_]:
    """Whether points (n, 3) lie in an opening of the plan, or within ``slack_mm`` of one; core pins
    have a clearance all round."""
    open_ = np.zeros(len(points), dtype=bool)
    below = points[:, 1] < slack_mm
    for hole in plan.base_holes:
        radius = 0.5 * max(hole.diameter, hole.outer_diameter) + slack_mm
        open_ |= below & (np.hypot(points[:, 0] - hole.x, points[:, 2] - hole.z) <= radius)
    for side in plan.sides:
        for slot in side.slots:  # a jig's are shifted; NaN compares false
            open_ |= from_slot(slot, points) <= slack_mm + side.shift
    for pin in plan.core_pins:
        open_ |= from_pin(pin, points) <= clearance_mm + slack_mm
    return open_
