"""How far a finger reaches in mold space, and how high its walls may be: numbers only, mm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.design.layout import crest_height, surface_height
from fingerdesign.mold.exits import flat_sided, half_extent, rim_height

if TYPE_CHECKING:
    from fingerdesign.design.body_table import Body
    from fingerdesign.design.schema import Design
    from fingerdesign.design.step_facts import StepFacts

_PLACES = 65  # along z at which a STEP body is looked at
_HEIGHTS = 9
_SHARE = 0.7  # of the half-width that must be left at the corner: that of a circle at 45 degrees
_WITHIN = 0.98  # of the corner found: walls that end on the body's surface would end in a point


@dataclass(frozen=True)
class Extent:
    """The enlarged outline's half sizes, mm; ``corner``, ``rim``, ``crest`` as of a MoldPlan.

    continued   whether the walls continue the contact surface outward; else they end at the rim
    """

    half_width: float
    half_depth: float
    corner: float
    rim: float
    crest: float
    continued: bool


def extent_of(design: Design, scale: float) -> Extent:
    """The extent of a design's outline, enlarged by ``scale``."""
    body = design.body
    half_width = max(half_extent(body, "+x"), half_extent(body, "-x"))
    half_depth = max(half_extent(body, "+z"), half_extent(body, "-z"))
    continued, rim = flat_sided(body), rim_height(body)
    corner = half_depth
    if body.shape == "revolved":
        corner = half_depth / np.sqrt(2.0)
    elif not continued:
        corner = _corner(body, half_width, half_depth, rim)
    return Extent(
        half_width=scale * half_width,
        half_depth=scale * half_depth,
        corner=scale * float(corner),
        rim=scale * rim,
        crest=scale * float(crest_height(body)),
        continued=continued,
    )


def _corner(body: Body, half_width: float, half_depth: float, rim: float) -> float:
    """|z| up to which a STEP body, at every height below the rim, parts left from right."""
    from fingerdesign.design.step_facts import step_facts

    assert body.step is not None
    facts = step_facts(body.step)
    heights = np.linspace(0.0, rim, _HEIGHTS) * (1.0 - 2e-3) + 1e-3 * rim
    wide = min(_reach(facts, height, half_width, "x") for height in heights)
    deep = min(
        _reach(facts, height, half_depth, "z", sign * _SHARE * wide)
        for height in heights
        for sign in (-1.0, 0.0, 1.0)
    )
    return _WITHIN * deep


def _reach(facts: StepFacts, height: float, most: float, axis: str, aside: float = 0.0) -> float:
    """How far from the mid-plane a body reaches to both sides along x or z at a height, mm."""
    from fingerdesign.design.cad_faces import nearest

    shares = np.linspace(0.0, 1.0, _PLACES)
    reaches = []
    for sign in (1.0, -1.0):
        out = sign * most * shares
        across = np.full(_PLACES, aside)
        x, z = (out, across) if axis == "x" else (across, out)
        points = np.column_stack([x, np.full(_PLACES, height), z])
        outside = np.flatnonzero(nearest(facts.faces, points)[1] > -1e-9)
        last = int(outside[0]) - 1 if len(outside) else _PLACES - 1
        reaches.append(most * float(shares[max(last, 0)]))
    return min(reaches)


def seam_height(design: Design, extent: Extent, scale: float, x: float, z: float) -> float:
    """Height of the walls' top at (x, z) beside the finger, in mold space, mm."""
    if not extent.continued:
        return extent.rim
    inside = 1.0 - 1e-9
    place = (
        float(np.clip(x, -extent.half_width, extent.half_width)) / scale * inside,
        float(np.clip(z, -extent.half_depth, extent.half_depth)) / scale * inside,
    )
    return scale * float(surface_height(design.body, *place))
