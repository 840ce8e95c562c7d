"""Where legs may leave the finger, and how each side is closed and holds them; numbers, mm.

Legs leave outside the contact zone, beyond the insert. What cannot be held is a fault of
planning.py.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from manifold3d import Manifold

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame, surface_height
from fingerdesign.layout.gaps import FAR_MM, boxes_apart, core_gaps, solids_of
from fingerdesign.layout.zone import candidate_zone
from fingerdesign.mold.plan.extent import Exits, exits_of, extent_of, half_extent
from fingerdesign.mold.plan.plan import (
    SIDES,
    Extent,
    Holding,
    Leg,
    Limits,
    Plug,
    Side,
    SidePlan,
    Slot,
    in_space,
)
from fingerdesign.mold.plan.slots import (
    as_bar,
    core_in_mold,
    leg_bar,
    scale_of,
    sheet_thickness,
    slot_corners,
    slot_of,
    turned_bar,
)

LEAST_GAP_MM = 0.1


def seam_of(limits: Limits) -> float:
    """By how much half frames end short of a base plate that has to lie on their combs, mm: frames
    may come out higher by their tolerance, and the plate bend by its form."""
    return limits.tolerance_mm + limits.form_mm


def _spanned(frames: Iterable[PlateFrame]) -> tuple[PlateFrame, ...]:
    """Frames with some span each: a leg that ends where it starts has none."""
    return tuple(replace(f, high=max(f.high, f.low + 1e-6)) for f in frames)


WINDOW_EDGE_MM = 0.1  # the least between a slot and its window's edge
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

    def wanting(self, sides: Sequence[Side], openings: Exits, exits: Exits) -> Array:
        """How much farther out (n,) legs on ``sides`` would have to leave, mm; 0: they leave well.

        ``openings``: of their slots; ``exits``: of the legs themselves.
        """
        least = np.array([self.least_exit(side) for side in sides])
        return np.where(self.above(openings), np.maximum(least - exits.nearest, 0.0), 0.0)


_FEATHERLESS = 0.8  # cosine of 37 degrees
EDGE_DEG = 30.0  # the sharpest edge of a wall
_SAMPLES = 2001  # along a side, where a wall's edge is looked for
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
        return self._slots(self.on(side), self.holding(side))

    def _slots(self, legs: Iterable[Leg], holding: Holding) -> tuple[Slot, ...]:
        return tuple(slot_of(self.design, holding, self.limits, self.bar(leg), leg) for leg in legs)

    @property
    def least_gap(self) -> float:
        """Least distance of a leg from metal that is not its own, mm.

        That which plates themselves keep where it is less: a leg is in its own plate's plane.
        """
        return min(LEAST_GAP_MM, 0.5 * self.design.plates.thickness_mm)

    def _solids(self, legs: Iterable[Leg]) -> list[Manifold]:
        return solids_of(_spanned(leg_bar(self.by_index[leg.plate], leg) for leg in legs))

    def _near(self, one: list[Manifold], two: list[Manifold]) -> Iterator[tuple[int, int, float]]:
        """Pairs of solids that come nearer than legs may: their numbers, and how near."""
        for i, j in np.argwhere(boxes_apart(one, two) < self.least_gap).tolist():
            yield i, j, float(one[i].min_gap(two[j], FAR_MM))

    def gaps(self) -> Array:
        """Distance (legs,) of each leg to other plates and to the core; infinite where it is
        greater than it must be."""
        found, body = np.full(len(self.legs), np.inf), self.design.body
        if self.legs and body.core is not None:
            depth = body.core.depth_mm if body.core.depth_mm is not None else body.depth_mm
            # A core of full depth ends where the legs do.
            bars = tuple(leg_bar(self.by_index[leg.plate], leg) for leg in self.legs)
            distances = core_gaps(core_in_mold(body.core, self.scale), depth, bars)
            found = np.where(distances < self.least_gap, distances, np.inf)
        for i, j, gap in self._near(self._solids(self.legs), solids_of(_spanned(self.frames))):
            if self.legs[i].plate != self.frames[j].index:  # of which it is a part
                found[i] = min(found[i], gap)
        return found

    def crossings(self) -> list[tuple[Leg, Leg, float]]:
        """Legs of plates along x and of plates along z that come too near: both, and how near."""
        one = [leg for leg in self.legs if leg.side.endswith("z")]
        two = [leg for leg in self.legs if leg.side.endswith("x")]
        near = self._near(self._solids(one), self._solids(two)) if one and two else ()
        return [(one[i], two[j], gap) for i, j, gap in near if gap < self.least_gap - 1e-6]

    def leg_exits(self, legs: Sequence[Leg]) -> Exits:
        """How legs leave the finger."""
        return self._exits(legs, [self.bar(leg) for leg in legs])

    def slot_exits(self, legs: Sequence[Leg], holding: Holding) -> Exits:
        """How the legs' slots leave the finger; those that leave through no flat face, as if at
        the body's extent."""
        bars = list(map(as_bar, map(self.bar, legs), self._slots(legs, holding)))
        return self._exits(legs, bars, followed=False)

    def _exits(
        self, legs: Sequence[Leg], bars: Sequence[PlateFrame], followed: bool = True
    ) -> Exits:
        sides, starts = [leg.side for leg in legs], [leg.start for leg in legs]
        return exits_of(self.design.body, self.scale, bars, sides, starts, followed)

    @cached_property
    def loose(self) -> tuple[Leg, ...]:
        """The legs that are held by slots in walls."""
        return tuple(
            leg for side in SIDES if self.holding(side) == "slots" for leg in self.on(side)
        )

    @cached_property
    def exits(self) -> Exits:
        """How the loose legs leave the finger."""
        return self.leg_exits(self.loose)

    @cached_property
    def openings(self) -> Exits:
        """How the loose legs' slots leave it."""
        return self.slot_exits(self.loose, "slots")

    @cached_property
    def high(self) -> list[tuple[Leg, float]]:
        """The legs that leave so high that the insert must end short of them, each with its
        nearest exit."""
        if not self.loose:
            return []
        each = zip(self.loose, self.exits.nearest, self.room.above(self.openings), strict=True)
        return [(leg, float(nearest)) for leg, nearest, above in each if above]

    def _mouthed(self, slot: Slot) -> Slot:
        """The slot with a mouth, where below it the wall would begin in too sharp an edge: it
        leaves a contact surface that is nearly level."""
        half, web = half_extent(self.design.body, slot.side), self.limits.feature_mm
        lean = math.radians(slot.angle_deg)
        if min(abs(math.sin(lean)), abs(math.cos(lean))) > math.sin(math.radians(EDGE_DEG)):
            return slot  # no side of it is as level as that
        outs = np.linspace(0.0, half, _SAMPLES)
        points = [
            [in_space(slot.side, at / self.scale, 0.0, o) for o in outs] for at, _ in slot.lower
        ]
        x, _, z = np.moveaxis(np.array(points), 2, 0)
        with np.errstate(invalid="ignore"):
            top = self.scale * surface_height(self.design.body, x, z)  # (2, outs); NaN: beyond it
        thick = slot.lower[:, 1:] - np.where(np.isnan(top), -np.inf, top)
        begins, stands = (int((thick > least).argmax(axis=1).max()) for least in (0.0, web))
        run = self.scale * (outs[stands] - outs[begins])
        if not np.isfinite(top[:, stands]).all() or run <= web / math.tan(math.radians(EDGE_DEG)):
            return slot
        return replace(slot, mouth=(self.scale * float(outs[stands]), float(top[:, stands].min())))

    def side(self, side: Side) -> SidePlan:
        """How one side is closed and holds its plates."""
        holding, slots = self.holding(side), self.slots(side)
        if holding == "slots" and self.design.body.step is None:
            high = {leg.plate for leg, _ in self.high if leg.side == side}
            slots = tuple(self._mouthed(s) if s.plate in high else s for s in slots)
        window = self._window(side, slots) if holding == "comb" else None
        return SidePlan(side, holding, sheet_thickness(self.design, holding), window, slots)

    def _window(self, side: Side, slots: tuple[Slot, ...]) -> tuple[float, float, float]:
        """The opening behind a comb, around all of its slots; walls below it, and in side walls
        beside it, stay as thick as they must be."""
        corners = slot_corners(slots).reshape(-1, 2)
        (low, bottom), (high, _) = corners.min(axis=0), corners.max(axis=0)
        most = self.room.extent.corner - self.room.wall if side.endswith("x") else np.inf
        return (
            float(max(low - _WINDOW_MM, min(-most, low))),
            float(min(high + _WINDOW_MM, max(most, high))),
            float(max(bottom - _WINDOW_MM, min(self.room.wall + seam_of(self.limits), bottom))),
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
