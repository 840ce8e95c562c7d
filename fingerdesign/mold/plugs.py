"""The insert's block, narrowed by plugs, and what the walls take beyond them. Loads the CAD kernel.

A plug's sides lean by the draft: they are planes through |x| or |z| = ``at_surface`` at the rim's
height and ``at_top`` at the block's top.
"""

from __future__ import annotations

import cadquery as cq
import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.geometry.kernel import box, one_solid
from fingerdesign.mold.flat_sides import direction, prism_of
from fingerdesign.mold.part import INSERT
from fingerdesign.mold.plan import MoldPlan, Plug, Side


def seam(plan: MoldPlan, plug: Plug, height: float) -> float:
    """|x| or |z| of the plug's sides at a height, mm."""
    share = (height - plan.rim) / (plan.top - plan.rim)
    return plug.at_surface + share * (plug.at_top - plug.at_surface)


def insert_block(plan: MoldPlan, floor: float) -> cq.Solid:
    """The insert's share of the block above ``floor``, finger and walls not yet taken out."""
    low, high = (-plan.reach_x, floor, -plan.reach_z), (plan.reach_x, plan.top, plan.reach_z)
    whole = box(low, high)
    for plug in plan.plugs:
        near, far = (seam(plan, plug, height) for height in (floor, plan.top))
        way = direction("+x" if plug.axis == "x" else "+z")
        section = [
            place * way + height * np.array([0.0, 1.0, 0.0])
            for place, height in ((-near, floor), (near, floor), (far, plan.top), (-far, plan.top))
        ]
        whole = one_solid(whole.intersect(_across(plan, way, section)), INSERT)
    return whole


def beyond_plug(plan: MoldPlan, side: Side, floor: float) -> cq.Solid:
    """What of the block above ``floor`` lies beyond the plug on a side of its axis.

    The corners beyond two plugs are the end walls', which are drawn first.
    """
    plug = next(each for each in plan.plugs if side.endswith(each.axis))
    way = direction(side)
    # Side walls end where their lower part does: farther out there is nothing to stand on.
    reach = plan.half_width + plan.wall_x if plug.axis == "x" else plan.reach_z
    near, far = (seam(plan, plug, height) for height in (floor, plan.top))
    corners = ((near, floor), (reach, floor), (reach, plan.top), (far, plan.top))
    section = [place * way + height * np.array([0.0, 1.0, 0.0]) for place, height in corners]
    piece = _across(plan, way, section)
    others = [each for each in plan.plugs if each.axis == "z"] if plug.axis == "x" else []
    for other in others:
        ends = [beyond_plug(plan, end, floor) for end in ("+z", "-z")]
        piece = one_solid(piece.cut(*ends), f"the corners beyond the plug along {other.axis}")
    return piece


def _across(plan: MoldPlan, way: Array, section: list[Array]) -> cq.Solid:
    """The prism of a section over all of the block across ``way``."""
    reach = plan.reach_z if way[0] else plan.reach_x
    across = np.array([abs(way[2]), 0.0, abs(way[0])])
    return prism_of([corner - reach * across for corner in section], 2.0 * reach * across)
