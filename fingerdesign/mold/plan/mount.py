"""Numbers of the mount's receiver: holes in its back, and its profile; mm."""

import math

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.refusals import Refusal

FLOOR_MM, SIDE_MM = 6.0, 3.0
TROUGH_MM = (1.6, 4.0)  # wide along z and deep: a leg with its connector's contacts
INSERT_HOLE_MM, INSERT_DEEP_MM = 4.0, 5.0  # of a heat-set insert M3
STOP_SCREW_MM = 2.5  # tapped M3
ISO_CIRCLE_MM, ISO_HOLE_MM, ISO_DISC_MM = 50.0, 6.6, 63.0  # ISO 9409-1-50-4-M6
HEAD_MM = 10.0  # diameter of the head of an M6 screw, ISO 4762
_WALL_MM = 1.0  # around holes


def flange_holes(plan: MoldPlan) -> list[tuple[float, float, float]]:
    """(x, z, diameter) of the holes in the receiver's back."""
    if plan.design.mold.mount == "iso9409":
        at = 0.5 * ISO_CIRCLE_MM * math.sqrt(0.5)
        return [(sx * at, sz * at, ISO_HOLE_MM) for sx in (-1.0, 1.0) for sz in (-1.0, 1.0)]
    at = max(0.6 * plan.mount_x, 0.5 * INSERT_HOLE_MM + _WALL_MM)
    return [(sx * at, 0.0, INSERT_HOLE_MM) for sx in (-1.0, 1.0)]


def mount_refusals(plan: MoldPlan) -> list[Refusal]:
    """Refuse a flange whose screws' heads would be where the base plate or its trough is."""
    if plan.design.mold.mount != "iso9409" or plan.groove is None:
        return []
    at, front = 0.5 * ISO_CIRCLE_MM * math.sqrt(0.5), plan.mount_z + 0.5 + TROUGH_MM[0]
    away = math.hypot(max(at - plan.mount_x, 0.0), max(at - front, 0.0))
    if away >= 0.5 * HEAD_MM + _WALL_MM:
        return []
    numbers = {"x": 2.0 * plan.mount_x, "z": 2.0 * plan.mount_z}
    return [Refusal("screws_below", "mold.mount", "iso9409", numbers)]


def rail_profile(plan: MoldPlan) -> Array:
    """Corners (n, 2) of the base plate's section across z, with the grooves that hold it."""
    assert plan.groove is not None
    depth, low, high = plan.groove
    x, back = plan.mount_x, -plan.base
    right = [(x, back), (x, low), (x - depth, low), (x - depth, high), (x, high), (x, 0.0)]
    return np.array([*right, *((-a, b) for a, b in reversed(right))])
