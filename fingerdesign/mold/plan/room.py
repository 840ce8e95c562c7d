"""Room for legs: places outside the contact zone and clear of walls where they leave; mm."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.layout.zone import candidate_zone
from fingerdesign.mold.plan.extent import Exits, extent_of
from fingerdesign.mold.plan.limits import Limits
from fingerdesign.mold.plan.plan import Extent, Side

WINDOW_EDGE_MM = 0.1  # the least distance from a slot to its window's edge
_ROUNDING_MM = 1e-9


@dataclass(frozen=True)
class Room:
    """What an insert between legs must leave: mold space.

    zone_x, zone_z   half-extents that it must cover on the contact surface, margin included;
                     infinite where the contact reaches the body's end
    top              height of the block
    wall             least wall, as below a window and beside it
    web              least web between the insert and a slot, or a slot and a wall's upper edge
    draft            tangent of the plug's draft
    """

    extent: Extent
    zone_x: float
    zone_z: float
    top: float
    wall: float
    web: float
    draft: float

    @classmethod
    def of(cls, design: Design, scale: float, limits: Limits) -> Self:
        """That of a design: its contact zone under a plane at the grip's greatest approach."""
        zone = candidate_zone(design, SceneObject(), design.grip.max_approach_mm)
        body, margin = design.body, design.mold.contact_margin_mm
        wide, deep = zone.half_width, zone.half_depth
        extent = extent_of(design, scale)
        return cls(
            extent,
            scale * wide + margin if wide < 0.5 * body.width_mm else math.inf,
            math.inf if deep is None else scale * deep + margin,
            extent.crest + design.mold.insert_mm,
            limits.wall_mm,
            limits.feature_mm,
            math.tan(math.radians(design.mold.draft_deg)),
        )

    def blocked(self, sides: Sequence[Side], openings: Exits, exits: Exits) -> Array:
        """By how much (n,) legs run through a wall that is drawn across them, mm; 0: by nothing.

        Below the rim, end walls lie beyond the corner and side walls between: legs along z must
        leave beyond it, those along x between, by a web. Above it all belongs to the walls of their
        axis. Where the contact surface is continued, end walls begin at the end faces.
        """
        along_z = np.array([side.endswith("z") for side in sides])
        beside = openings.reach + self.web - self.extent.corner
        into = np.where(along_z, self.extent.corner - exits.nearest, beside)
        free = (self.extent.continued & along_z) | (
            self.above(openings) & (openings.bottom >= self.extent.rim + self.web)
        )
        return np.where(free, 0.0, np.maximum(into, 0.0))

    def sunk(self, openings: Exits) -> Array:
        """By how much (n,) slots in walls come too near to the base, mm; 0: they do not."""
        return np.maximum(self.web - openings.bottom, 0.0)

    def framed(self, sides: Sequence[Side], openings: Exits) -> BoolArray:
        """Whether a wall stands below a window around slots (n,), and in side walls beside it."""
        least = self.wall + WINDOW_EDGE_MM
        along_z = np.array([side.endswith("z") for side in sides])
        beside = along_z | (openings.reach <= self.extent.corner - least + _ROUNDING_MM)
        return np.asarray(beside & (openings.bottom >= least - _ROUNDING_MM))

    @property
    def narrowing(self) -> float:
        """By how much the draft narrows a plug from its top to the rim, mm."""
        return (self.top - self.extent.rim) * self.draft

    def zone(self, side: Side) -> float:
        """The half-extent that a plug between legs on ``side`` must cover."""
        return self.zone_x if side.endswith("x") else self.zone_z

    def least_exit(self, side: Side) -> float:
        """How far out legs on ``side`` must leave at least, where the insert ends short of them."""
        return self.zone(side) + self.narrowing + self.web

    def greatest_draft(self, side: Side, nearest: float) -> float | None:
        """The greatest draft, degrees, at which a plug short of an exit covers the contact zone.

        None: none does.
        """
        over = nearest - self.web - self.zone(side)
        if not 0.0 <= over < math.inf:
            return None
        return math.degrees(math.atan2(over, self.top - self.extent.rim))

    def above(self, openings: Exits) -> BoolArray:
        """Whether legs (n,) whose slots leave so are so high that the insert must end short of
        them."""
        if self.extent.continued:
            return np.asarray(openings.surface_margin < self.web - 1e-9)
        return np.asarray(openings.top > self.extent.rim - self.web + 1e-9)

    def lack(self, sides: Sequence[Side], openings: Exits, exits: Exits) -> Array:
        """How much farther out (n,) legs on ``sides`` would have to leave, mm; 0: they leave well.

        ``openings``: of their slots; ``exits``: of the legs themselves.
        """
        least = np.array([self.least_exit(side) for side in sides])
        return np.where(self.above(openings), np.maximum(least - exits.nearest, 0.0), 0.0)
