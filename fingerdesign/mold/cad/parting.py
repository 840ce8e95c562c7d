"""The block around the finger, split into blanks: parts before pins, holes, slots and windows.

Where all four sides are flat, the walls are those faces drawn outward, and the insert is what of
the block is above them; else the walls are what of the block lies below the contact surface's
lowest place (``plan.rim``): end walls beyond |z| = ``plan.corner``, side walls between. A plug
narrows the insert; the walls of its axis take what is beyond. Importing this loads the CAD kernel.
"""

from __future__ import annotations

from dataclasses import dataclass

import cadquery as cq
import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.cad.kernel import box, one_solid
from fingerdesign.errors import GeometryError
from fingerdesign.mold.cad.flat_sides import FlatSide, direction, flat_sides, prism_of
from fingerdesign.mold.part import INSERT, comb_names, wall_name
from fingerdesign.mold.plan.plan import SIDES, MoldPlan, Plug, Side

# The insert's block, narrowed by plugs, and what the walls take beyond them. Loads the CAD kernel.
#
# A plug's sides lean by the draft: they are planes through |x| or |z| = ``at_surface`` at the rim's
# height and ``at_top`` at the block's top.


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


@dataclass(frozen=True)
class Blank:
    """A part before its features. ``part``: what they are worked into; ``filling``: what of it is
    within the filled block, which leaves out the ears."""

    part: cq.Solid
    filling: cq.Solid


@dataclass(frozen=True)
class Parting:
    """An outline in mold space, and the blanks by part name.

    low, high  corners of the block that outline and fillings fill: |x| <= half_width + wall_x
    """

    outline: cq.Solid
    blanks: dict[str, Blank]
    low: tuple[float, float, float]
    high: tuple[float, float, float]


def block_x(plan: MoldPlan) -> float:
    """|x| of the filled block's faces, where the side walls end and the ears begin."""
    return plan.half_width + plan.wall_x


def sides_followed(outline: cq.Solid, plan: MoldPlan) -> dict[Side, FlatSide] | None:
    """The outline's four flat sides; None where the mold's parting cannot follow them."""
    return flat_sides(outline) if plan.corner > plan.half_depth - 1e-6 else None


def parted(outline: cq.Solid, plan: MoldPlan) -> Parting:
    """Split the block around ``outline``, which is in mold space.

    GeometryError where the kernel fails, or makes a part of several pieces.
    """
    flat = sides_followed(outline, plan)
    blocks: dict[str, cq.Solid] = {}
    if flat is not None:
        floor = min(min(each.height_low, each.height_high) for each in flat.values())
        around = {side: _beside(face, plan) for side, face in flat.items()}
        for side, face in flat.items():
            blocks |= _layers(plan, side, face)
    else:
        floor, around = plan.rim, {}
        for side in SIDES:
            blocks |= _below(outline, plan, side)
    above = insert_block(plan, floor).cut(outline, *around.values())
    blocks[INSERT] = one_solid(above.clean(), INSERT)
    for plug in plan.plugs:
        for side in SIDES:
            if side.endswith(plug.axis):
                upper = beyond_plug(plan, side, floor).cut(outline, *around.values())
                name = wall_name(side)
                blocks[name] = one_solid(blocks[name].fuse(upper).clean(), name)
    high = (block_x(plan), plan.top, plan.reach_z)
    low = (-high[0], 0.0, -high[2])
    filled = box(low, high)
    blanks = {name: Blank(part, _within(part, filled, name)) for name, part in blocks.items()}
    return Parting(outline, blanks, low, high)


def _beside(face: FlatSide, plan: MoldPlan) -> cq.Solid:
    """All that lies beside a flat side, out to the block's faces and the ears."""
    if face.side.endswith("x"):
        return face.prism(face.away, plan.reach_x)
    return face.widened(plan.reach_x, face.away, plan.reach_z)


def _layers(plan: MoldPlan, side: Side, face: FlatSide) -> dict[str, cq.Solid]:
    """The sheets of a flat side, and its wall behind them."""
    planned = plan.side(side)
    names = comb_names(side, planned.holding)
    bounds = [face.away + k * planned.sheet for k in range(len(names) + 1)]
    layers = list(zip(names, bounds, bounds[1:], strict=False))
    reach = block_x(plan) if side.endswith("x") else plan.reach_z
    layers.append((wall_name(side), bounds[-1], reach))
    found = {}
    for name, start, end in layers:
        if side.endswith("x"):
            found[name] = face.prism(start, end)
        else:
            found[name] = face.widened(plan.reach_x, start, end)
    return found


def _below(outline: cq.Solid, plan: MoldPlan, side: Side) -> dict[str, cq.Solid]:
    """The wall of a side as what of the block below the rim is outside of the outline.

    Sheets are possible where the side happens to be flat up to the rim.
    """
    planned, across = plan.side(side), side.endswith("x")
    face = plan.half_width if across else plan.corner
    names = comb_names(side, planned.holding)
    if names and not across and plan.corner < plan.half_depth - 1e-6:
        raise GeometryError(f"{names[0]}: the finger's {side} side is not one flat face")
    bounds = [face + k * planned.sheet for k in range(len(names) + 1)]
    first = bounds[-1] if names else (0.0 if across else plan.corner)
    layers = [(wall_name(side), first, block_x(plan) if across else plan.reach_z)]
    layers += zip(names, bounds, bounds[1:], strict=False)
    found = {}
    for name, start, end in layers:
        piece = _slab(side, start, end, plan.corner if across else plan.reach_x, plan.rim)
        found[name] = one_solid(piece if names else piece.cut(outline), name)
    return found


def _slab(side: Side, start: float, end: float, reach: float, top: float) -> cq.Solid:
    """The box from ``start`` to ``end`` outward on a side, +-``reach`` across, 0 to ``top``."""
    away = direction(side)
    across = reach * (1.0 - abs(away))
    one, other = start * away + across, end * away - across
    low, high = [min(a, b) for a, b in zip(one, other, strict=True)], []
    high = [max(a, b) for a, b in zip(one, other, strict=True)]
    low[1], high[1] = 0.0, top
    return box(low, high)


def _within(part: cq.Solid, filled: cq.Solid, name: str) -> cq.Solid:
    """What of a part is in the filled block; itself where it has no ears."""
    bounds = part.BoundingBox()
    reach = filled.BoundingBox().xmax
    if max(-bounds.xmin, bounds.xmax) < reach + 1e-6:
        return part
    return one_solid(part.intersect(filled), name)
