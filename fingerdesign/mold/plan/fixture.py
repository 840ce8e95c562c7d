"""Plates with their legs in mold space, and how each side of the mold holds them; mm."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from manifold3d import Manifold

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame, PlateRow, plate_rows
from fingerdesign.layout.gaps import FAR_MM, boxes_apart, core_gaps, solids_of
from fingerdesign.mold.plan.extent import Exits, exits_of
from fingerdesign.mold.plan.limits import Limits
from fingerdesign.mold.plan.plan import SIDES, Holding, Leg, Side, Slot
from fingerdesign.mold.plan.room import Room
from fingerdesign.mold.plan.slots import (
    as_bar,
    core_in_mold,
    leg_bar,
    scale_of,
    slot_of,
    turned_bar,
)

LEAST_GAP_MM = 0.1


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

    @cached_property
    def rows(self) -> tuple[PlateRow, ...]:
        """The rows of plates in the design."""
        return plate_rows(self.design)

    def row(self, plate: int) -> PlateRow:
        """The row that a plate belongs to."""
        return next(row for row in self.rows if plate in (frame.index for frame in row.frames))

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


def _spanned(frames: Iterable[PlateFrame]) -> tuple[PlateFrame, ...]:
    """Frames with some span each: a leg that ends where it starts has none."""
    return tuple(replace(f, high=max(f.high, f.low + 1e-6)) for f in frames)
