"""Where legs may leave the finger: outside the contact zone, beyond the insert; numbers, mm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.design.step import step_facts
from fingerdesign.layout.frames import PlateFrame, crest_height
from fingerdesign.layout.gaps import FAR_MM, boxes_apart, core_gaps, solids_of
from fingerdesign.layout.zone import candidate_zone
from fingerdesign.mold.plan.extent import Exits, extent_of, flat_sided, rim_height
from fingerdesign.mold.plan.plan import Leg, Limits, Side
from fingerdesign.mold.plan.slots import core_in_mold, leg_bar

# How far legs lie from other plates, from other legs and from the core; numbers only, mm.

LEAST_GAP_MM = 0.1
_NEAR = 2.0  # mm: farther pairs are distinguished by their boxes alone


def least_gap_mm(design: Design) -> float:
    """Least distance of a leg from metal that is not its own, mm.

    That which plates themselves keep where it is less: a leg is in its own plate's plane.
    """
    return min(LEAST_GAP_MM, 0.5 * design.plates.thickness_mm)


def leg_gaps(
    design: Design,
    scale: float,
    legs: tuple[Leg, ...],
    bars: tuple[PlateFrame, ...],
    frames: tuple[PlateFrame, ...],
) -> Array:
    """Least distance (legs,) of each leg's ``bar`` to other plates and to the core."""
    found = np.full(len(legs), np.inf)
    if not legs:
        return found
    core = design.body.core
    if core is not None:
        depth = core.depth_mm if core.depth_mm is not None else design.body.depth_mm
        # A core of full depth ends where the legs do.
        distances = core_gaps(core_in_mold(core, scale), depth, bars)
        found = np.where(np.isnan(distances), np.inf, distances)
    owners = np.array([leg.plate for leg in legs])
    plates = np.array([frame.index for frame in frames])
    solids, others = solids_of(_spanned(bars)), solids_of(_spanned(frames))
    apart = boxes_apart(solids, others)
    apart[owners[:, None] == plates] = np.inf  # its own plate's, which it is a part of
    rows = zip(solids, apart, found, strict=True)
    return np.array([_least(solid, others, row, most) for solid, row, most in rows])


def crossing_legs(
    design: Design, legs: tuple[Leg, ...], frames: tuple[PlateFrame, ...]
) -> list[tuple[Leg, Leg, float]]:
    """Legs of plates along x and of plates along z that come too near: both, and how near."""
    along = {frame.index: frame for frame in frames}
    one = [leg for leg in legs if leg.side.endswith("z")]
    two = [leg for leg in legs if leg.side.endswith("x")]
    if not one or not two:
        return []
    first = tuple(leg_bar(along[leg.plate], leg, leg.exit) for leg in one)
    second = tuple(leg_bar(along[leg.plate], leg, leg.exit) for leg in two)
    a, b = solids_of(_spanned(first)), solids_of(_spanned(second))
    least = least_gap_mm(design) - 1e-6
    near = np.argwhere(boxes_apart(a, b) < least)
    found = [(one[i], two[j], float(a[i].min_gap(b[j], FAR_MM))) for i, j in near]
    return [each for each in found if each[2] < least]


def _least(solid: Manifold, others: list[Manifold], apart: Array, most: float) -> float:
    """The least distance of a solid from others, ``apart`` (n,) by their boxes; ``most``: more."""
    least = most
    for k in np.argsort(apart):
        if apart[k] >= min(least, _NEAR):
            break
        least = min(least, float(solid.min_gap(others[k], min(least, FAR_MM))))
    return least


def _spanned(frames: tuple[PlateFrame, ...]) -> tuple[PlateFrame, ...]:
    """Frames with some span each: a leg that ends where it starts has none."""
    return tuple(replace(f, high=max(f.high, f.low + 1e-6)) for f in frames)


WINDOW_EDGE_MM = 0.1  # the least between a slot and its window's edge
_ROUNDING_MM = 1e-9


@dataclass(frozen=True)
class Room:
    """What an insert between legs must leave: mold space.

    zone_x, zone_z   half-extents that it must cover on the contact surface, margin included;
                     infinite where the contact reaches the body's end
    rim, top         heights of the contact surface's lowest border and of the block
    corner           |z| at which end and side walls meet below the rim
    wall             least wall, as below a window and beside it
    web              least web between the insert and a slot, or a slot and a wall's upper edge
    draft            tangent of the plug's draft
    continued        whether the contact surface is continued outward beside flat sides
    """

    zone_x: float
    zone_z: float
    rim: float
    top: float
    corner: float
    wall: float
    web: float
    draft: float
    continued: bool

    @classmethod
    def of(cls, design: Design, scale: float, limits: Limits) -> Room:
        """That of a design: its contact zone under a plane at the grip's greatest approach."""
        zone = candidate_zone(design, SceneObject(), design.grip.max_approach_mm)
        body, margin = design.body, design.mold.contact_margin_mm
        wide, deep = zone.half_width, zone.half_depth
        return cls(
            scale * wide + margin if wide < 0.5 * body.width_mm else math.inf,
            math.inf if deep is None else scale * deep + margin,
            scale * rim_height(body),
            scale * float(crest_height(body)) + design.mold.insert_mm,
            _corner(design, scale),
            limits.wall_mm,
            limits.feature_mm,
            math.tan(math.radians(design.mold.draft_deg)),
            flat_sided(body),
        )

    def blocked(self, sides: Sequence[Side], openings: Exits, exits: Exits) -> Array:
        """By how much (n,) legs run through a wall that is drawn across them, mm; 0: by nothing.

        Below the rim, end walls lie beyond the corner and side walls between: legs along z must
        leave beyond it, those along x between, by a web. Above it all belongs to the walls of their
        axis. Where the contact surface is continued, end walls begin at the end faces.
        """
        along_z = np.array([side.endswith("z") for side in sides])
        beside = openings.reach + self.web - self.corner
        into = np.where(along_z, self.corner - exits.nearest, beside)
        free = (self.continued & along_z) | (
            self.above(openings) & (openings.bottom >= self.rim + self.web)
        )
        return np.where(free, 0.0, np.maximum(into, 0.0))

    def sunk(self, openings: Exits) -> Array:
        """By how much (n,) slots in walls come too near to the base, mm; 0: they do not."""
        return np.maximum(self.web - openings.bottom, 0.0)

    def framed(self, sides: Sequence[Side], openings: Exits) -> NDArray[np.bool_]:
        """Whether a wall stands below a window around slots (n,), and in side walls beside it."""
        least = self.wall + WINDOW_EDGE_MM
        along_z = np.array([side.endswith("z") for side in sides])
        beside = along_z | (openings.reach <= self.corner - least + _ROUNDING_MM)
        return np.asarray(beside & (openings.bottom >= least - _ROUNDING_MM))

    @property
    def narrowing(self) -> float:
        """By how much the draft narrows a plug from its top to the rim, mm."""
        return (self.top - self.rim) * self.draft

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
        return math.degrees(math.atan2(over, self.top - self.rim))

    def above(self, openings: Exits) -> NDArray[np.bool_]:
        """Whether legs (n,) whose slots leave so are so high that the insert must end short of
        them."""
        if self.continued:
            return np.asarray(openings.surface_margin < self.web - 1e-9)
        return np.asarray(openings.top > self.rim - self.web + 1e-9)

    def wanting(self, sides: Sequence[Side], openings: Exits, exits: Exits) -> Array:
        """How much farther out (n,) legs on ``sides`` would have to leave, mm; 0: they leave well.

        ``openings``: of their slots; ``exits``: of the legs themselves.
        """
        least = np.array([self.least_exit(side) for side in sides])
        return np.where(self.above(openings), np.maximum(least - exits.nearest, 0.0), 0.0)


def _corner(design: Design, scale: float) -> float:
    step = design.body.step
    if step is None:
        return extent_of(design, scale).corner
    return _step_corner(design, scale, step_facts(step).digest)


@lru_cache(maxsize=64)
def _step_corner(design: Design, scale: float, digest: str) -> float:
    """That of a STEP body, which takes 0.1 s; ``digest``: of the file as it is now."""
    return extent_of(design, scale).corner
