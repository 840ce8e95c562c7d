"""Openings for plates' legs as solids: slots in combs, jigs and walls, windows behind sheets.

Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import cadquery as cq
import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.geometry.kernel import box, extruded, flat_face, polygon
from fingerdesign.mold.flat_sides import AXIS, direction
from fingerdesign.mold.part import comb_names, wall_name
from fingerdesign.mold.plan import MoldPlan, Side, SidePlan, Slot

STEEP = 0.5  # fall of a wall's top, mm per mm, from which its edge at a window is cut level
_BEYOND_MM = 1.0  # how far a tool reaches out of what it cuts
_UP = np.array([0.0, 1.0, 0.0])


def slot_tools(plan: MoldPlan, planned: SidePlan) -> Iterator[tuple[str, cq.Solid]]:
    """What is cut for the slots of a side: names of parts, and a tool for each.

    The slots of a jig's inner sheet lie toward the plates' upper side by its shift, those of the
    outer one toward the lower: so, level with each other, the sheets clamp the plates.
    """
    side = planned.side
    sheets = comb_names(side, planned.holding)
    reach = (plan.reach_x if side.endswith("x") else plan.reach_z) + _BEYOND_MM
    for slot in planned.slots:
        if not sheets:
            yield from ((wall_name(side), tool) for tool in _opening_tools(slot, 0.0, reach))
        for k, name in enumerate(sheets):
            shift = planned.shift * (1.0 - 2.0 * k) if len(sheets) > 1 else 0.0
            yield from ((name, tool) for tool in _opening_tools(slot, shift, reach))


def jig_moves(plan: MoldPlan, clearance: float) -> Iterator[tuple[str, Array]]:
    """How the pins' holes in the sheets of jigs are moved: (sheet, vector).

    By the pins' clearance, against the sheet's own shift: the pins then bear on the holes' sides
    and keep the sheets from slipping back, however loose they are.
    """
    for planned in plan.sides:
        if planned.holding == "jig" and planned.slots:
            upward = upper_side(planned.slots[0])
            for k, name in enumerate(comb_names(planned.side, planned.holding)):
                yield name, -clearance * (1.0 - 2.0 * k) * upward


def _opening_tools(slot: Slot, shift: float, reach: float) -> Iterator[cq.Solid]:
    """A slot's rectangle, and the round relief for the leads at its end."""
    yield slot_solid(slot, shift, reach)
    if slot.relief:
        away, across = direction(slot.side), np.eye(3)[2 - AXIS[slot.side[1]]]
        place, y = slot.relief_centre
        foot = place * across + y * _UP + shift * upper_side(slot)
        yield cq.Solid.makeCylinder(0.5 * slot.relief, reach, cq.Vector(*foot), cq.Vector(*away))


def upper_side(slot: Slot) -> Array:
    """Unit vector across a slot, toward the upper side of its plate."""
    across = np.eye(3)[2 - AXIS[slot.side[1]]]
    angle = np.radians(slot.angle_deg)
    return np.asarray(-np.sin(angle) * across + np.cos(angle) * _UP)


def slot_solid(slot: Slot, shift: float, reach: float) -> cq.Solid:
    """A slot's rectangle, moved by ``shift`` toward the upper side, drawn out from the mid-plane:
    it is cut out of one part alone."""
    away, across = direction(slot.side), np.eye(3)[2 - AXIS[slot.side[1]]]
    angle = np.radians(slot.angle_deg)
    along = np.cos(angle) * across + np.sin(angle) * _UP
    upward = upper_side(slot)
    centre = slot.place * across + slot.y * _UP + shift * upward
    s, v = 0.5 * slot.length * along, 0.5 * slot.width * upward
    corners = [centre - s - v, centre + s - v, centre + s + v, centre - s + v]
    return extruded(flat_face(polygon(corners)), reach * away)


def window_tools(
    plan: MoldPlan, planned: SidePlan, seam: Callable[[float], float], land: float
) -> Iterator[cq.Solid]:
    """The window in the wall behind sheets, open toward the insert and outward.

    Where the wall's top, of height ``seam(place)``, falls off steeply beside the window, it is cut
    level over ``land`` mm, so that no feather edge is left there.
    """
    if planned.window is None:
        return
    low, high, bottom = planned.window
    yield _opening(plan, planned.side, low, high, bottom)
    for edge, sign in ((low, -1.0), (high, 1.0)):
        foot = seam(edge + sign * land)
        if seam(edge) - foot > STEEP * land and foot > bottom:
            ends = sorted((edge, edge + sign * land))
            yield _opening(plan, planned.side, ends[0], ends[1], foot)


def _opening(plan: MoldPlan, side: Side, low: float, high: float, bottom: float) -> cq.Solid:
    """The box above ``bottom`` between two places, from the mid-plane out of the block."""
    away, across = direction(side), np.eye(3)[2 - AXIS[side[1]]]
    reach = plan.reach_x if side.endswith("x") else plan.reach_z
    one = low * across + bottom * _UP
    other = (reach + _BEYOND_MM) * away + high * across + (plan.top + _BEYOND_MM) * _UP
    return box(np.minimum(one, other).tolist(), np.maximum(one, other).tolist())
