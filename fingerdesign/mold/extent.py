"""How far a finger reaches in mold space, and how high its walls may be: numbers only, mm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.layout import crest_height, surface_height
from fingerdesign.mold.exits import flat_sided, half_extent, rim_height

if TYPE_CHECKING:
    from fingerdesign.design.body_table import Body
    from fingerdesign.design.schema import Design

_PLACES = 40  # to either side at which a STEP body is looked at
_HEIGHTS = 5
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
    from fingerdesign.design.cad_faces import nearest
    from fingerdesign.design.step_facts import step_facts

    assert body.step is not None
    faces = step_facts(body.step).faces
    heights = np.linspace(1e-3, 1.0 - 1e-3, _HEIGHTS) * rim
    shares = np.linspace(-1.0, 1.0, 2 * _PLACES + 1)

    def reach(places: Array, most: float) -> float:
        """How far lines of places (lines, heights, shares, 3) stay inside, both ways."""
        outside = nearest(faces, places.reshape(-1, 3))[1].reshape(places.shape[:-1]) > -1e-9
        far = np.where(outside, np.abs(shares), np.inf).min()
        return most * min(1.0, float(far) - 1.0 / _PLACES)

    grid = np.zeros((1, _HEIGHTS, len(shares), 3))
    grid[..., 1] = heights[:, None]
    grid[..., 0] = half_width * shares
    wide = reach(grid, half_width)
    grid = np.zeros((3, _HEIGHTS, len(shares), 3))
    grid[..., 0] = _SHARE * wide * np.array([-1.0, 0.0, 1.0])[:, None, None]
    grid[..., 1] = heights[:, None]
    grid[..., 2] = half_depth * shares
    return _WITHIN * reach(grid, half_depth)


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
