"""Where legs may leave the finger, and how each side is closed and holds them; numbers, mm.

Legs leave outside the contact zone, beyond the insert. What cannot be held is a fault of
fixture_faults.py.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

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
from fingerdesign.mold.plan.extent import Exits, exits_of, extent_of, flat_sided, rim_height
from fingerdesign.mold.plan.plan import SIDES, Holding, Leg, Limits, Plug, Side, SidePlan, Slot
from fingerdesign.mold.plan.slots import (
    as_bar,
    as_relief,
    core_in_mold,
    leg_bar,
    openings_corners,
    scale_of,
    sheets_thickness,
    slot_of,
    turned_bar,
)

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
        distances = core_gaps(core_in_mold(core, scale_of(design)), depth, bars)
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
    a, b = (
        solids_of(_spanned(tuple(leg_bar(along[leg.plate], leg, leg.exit) for leg in some)))
        for some in (one, two)
    )
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


_FEATHERLESS = 0.8  # cosine of 37 degrees
_WINDOW_MM = 0.5  # beside and below the slots: room for leads, and to see


@dataclass(frozen=True)
class Fixture:
    """A design's plates with their legs in mold space, and how the mold's sides hold them."""

    design: Design
    limits: Limits
    frames: tuple[PlateFrame, ...]
    legs: tuple[Leg, ...] = ()

    @cached_property
    def scale(self) -> float:
        """The outline's enlargement."""
        return scale_of(self.design)

    @cached_property
    def room(self) -> Room:
        """Where legs may leave."""
        return Room.of(self.design, self.scale, self.limits)

    @cached_property
    def by_index(self) -> dict[int, PlateFrame]:
        """The plates by their numbers."""
        return {frame.index: frame for frame in self.frames}

    def on(self, side: Side) -> tuple[Leg, ...]:
        """The legs that leave on one side."""
        return tuple(leg for leg in self.legs if leg.side == side)

    def holding(self, side: Side) -> Holding:
        """How a side holds its legs: as asked where all leave through one flat face, else by
        slots."""
        legs = self.on(side)
        if not legs:
            return "wall"
        return self.design.mold.plate_fixture if all(leg.flat for leg in legs) else "slots"

    def bar(self, leg: Leg) -> PlateFrame:
        """The bar that just holds a leg's section."""
        return turned_bar(self.by_index[leg.plate], leg.width, leg.offset)

    def slots(self, side: Side) -> tuple[Slot, ...]:
        """The slots of one side, in the legs' order."""
        holding = self.holding(side)
        return tuple(
            slot_of(self.design, holding, self.limits, self.bar(leg), leg) for leg in self.on(side)
        )

    @cached_property
    def loose(self) -> tuple[Leg, ...]:
        """The legs that are held by slots in walls."""
        return tuple(
            leg for side in SIDES if self.holding(side) == "slots" for leg in self.on(side)
        )

    @cached_property
    def exits(self) -> Exits:
        """How the loose legs leave the finger."""
        bars = [self.bar(leg) for leg in self.loose]
        return leg_exits(self.design, self.loose, bars)

    @cached_property
    def openings(self) -> Exits:
        """How the loose legs' slots leave it."""
        bars = [self.bar(leg) for leg in self.loose]
        return slot_exits(self.design, "slots", self.limits, self.loose, bars)

    @cached_property
    def high(self) -> list[tuple[Leg, float]]:
        """The legs that leave so high that the insert must end short of them, each with its
        nearest exit."""
        if not self.loose:
            return []
        above = self.room.above(self.openings)
        nearest = self.exits.nearest
        return [(leg, float(nearest[k])) for k, leg in enumerate(self.loose) if above[k]]

    def side(self, side: Side) -> SidePlan:
        """How one side is closed and holds its plates."""
        holding, slots = self.holding(side), self.slots(side)
        shift = 0.0
        if holding == "jig":
            shift = min(
                0.5 * (slot.width - self.bar(leg).thickness)
                for slot, leg in zip(slots, self.on(side), strict=True)
            )
        sheet = sheets_thickness(self.design, holding, self.limits)
        window = self._window(side, slots) if holding in ("comb", "jig") else None
        return SidePlan(side, holding, sheet, shift, window, slots)

    def _window(self, side: Side, slots: tuple[Slot, ...]) -> tuple[float, float, float]:
        """The opening behind a comb or jig, around all of its slots; walls below it, and in side
        walls beside it, stay as thick as they must be."""
        corners = openings_corners(slots).reshape(-1, 2)
        (low, bottom), (high, _) = corners.min(axis=0), corners.max(axis=0)
        most = self.room.corner - self.room.wall if side.endswith("x") else np.inf
        return (
            float(max(low - _WINDOW_MM, min(-most, low))),
            float(min(high + _WINDOW_MM, max(most, high))),
            float(max(bottom - _WINDOW_MM, min(self.room.wall, bottom))),
        )

    @property
    def plugs(self) -> tuple[Plug, ...]:
        """The insert's plugs: as wide as the legs beside them allow, narrowed by the draft."""
        plugs = []
        for axis in ("x", "z"):
            nearest = [out for leg, out in self.high if leg.side.endswith(axis)]
            if nearest:
                seam = self._seam(axis) + self.room.narrowing
                top = min(min(nearest) - self.room.web, seam)
                plugs.append(Plug(axis, top - self.room.narrowing, top))
        return tuple(plugs)

    def _seam(self, axis: str) -> float:
        """How far out the seam of a plug may lie on the contact surface, mm.

        On a revolved body's border it would meet the upright side at the angle whose sine is the
        rest: farther out than this the insert ends there in a feather edge.
        """
        body = self.design.body
        if not body.kind.turned:
            return math.inf
        zone = self.room.zone_x if axis == "x" else self.room.zone_z
        return max(_FEATHERLESS * 0.5 * body.width_mm * self.scale, zone)


def leg_exits(design: Design, legs: Sequence[Leg], bars: Sequence[PlateFrame]) -> Exits:
    """How legs leave the finger; ``bars`` just hold their sections."""
    sides, starts = [leg.side for leg in legs], [leg.start for leg in legs]
    return exits_of(design.body, scale_of(design), bars, sides, starts)


def slot_exits(
    design: Design,
    holding: Holding,
    limits: Limits,
    legs: Sequence[Leg],
    bars: Sequence[PlateFrame],
) -> Exits:
    """How the legs' slots leave the finger, with their reliefs."""
    sides, starts = [leg.side for leg in legs], [leg.start for leg in legs]
    both = list(zip(legs, bars, strict=True))
    cut = [(bar, slot_of(design, holding, limits, bar, leg)) for leg, bar in both]
    openings = [as_bar(bar, slot) for bar, slot in cut]
    body, scale = design.body, scale_of(design)
    found = exits_of(body, scale, openings, sides, starts, follow=False)
    if design.mold.wire_mm <= 0.0:
        return found
    reliefs = [as_relief(bar, slot) for bar, slot in cut]
    return found.with_others(exits_of(body, scale, reliefs, sides, starts, follow=False))
