"""Legs of plates: their widths and their places along the plate, chosen so that they can be held.

Legs are as wide as possible, for a wide leg holds its plate's angle, and half as wide on plates
that end inside the finger, where they stay in the rubber. They are moved along the plate and
narrowed until they leave the finger outside its contact zone, clear of other plates, and until
their slots keep the webs. leg_refusals.py refuses what is not reached.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.plan import slots
from fingerdesign.mold.plan.extent import half_extent
from fingerdesign.mold.plan.fixture import Fixture
from fingerdesign.mold.plan.limits import limits_of
from fingerdesign.mold.plan.plan import SIDES, Holding, Leg, Side
from fingerdesign.mold.plan.slots import end_of, frames_in_mold, scale_of, sides_of_plate

LEAST_WIDTH_MM = 0.3  # a thinner strip of thin metal buckles when the rubber is poured
# A leg that stays in the rubber is at most this fraction of its plate's length: half the width
# turns twice as far in its slot, the whole displaces twice the rubber.
_EMBEDDED = 0.5
# Penalties rank what is wrong with legs; _LACK is for each millimetre of web that lacks.
_CROSSED, _LEFT, _NOT_FLAT, _LACK = 1000.0, 100.0, 1e-5, 100.0
CLOSE = 1e-6  # mm; rounding
SLOTS: Holding = "slots"
_SHARES = (1.0, 0.8, 0.6, 0.45, 0.3, 0.0)  # of the way from the least width to the most
# Places are fractions of the way from the plate's centre to its end. The coarse ones are tried for
# all widths first, then every one.
_COARSE = (0.0, 0.5, -0.5, 1.0, -1.0)
_FINE = (*_COARSE, 0.25, -0.25, 0.75, -0.75)
# Legs of a row are placed in a pattern: neighbours on either side of their plates' centres, or
# fanned out from one end of the row to the other.
_ZIGZAGS: tuple[tuple[float, float], ...] = ((0.0, 0.0), (0.5, 0.0), (1.0, 0.0))
_FANS: tuple[tuple[float, float], ...] = ((0.0, 1.0), (0.0, -1.0), (0.0, 0.5), (0.0, -0.5))
_GOOD = 1e-2  # sides held by slots where a comb was requested: no fault


# A stance is every plate end's leg at one width and place, and its penalty by how it is held.
Stance = tuple[tuple[Leg, ...], dict[Holding, Array]]


class Search(Fixture):
    """A search for legs: plates in mold space, and what their process can make."""

    @cached_property
    def ends(self) -> tuple[tuple[PlateFrame, Side], ...]:
        """The two ends of every plate."""
        return tuple((frame, side) for frame in self.frames for side in sides_of_plate(frame))

    @cached_property
    def full(self) -> BoolArray:
        """True for each plate end that lies in the finger's end, (ends,)."""
        body = self.design.body
        found = []
        for frame, side in self.ends:
            shift = (1.0 - 1.0 / self.scale) * frame.middle * (1.0 if side[0] == "+" else -1.0)
            found.append(end_of(frame, side) - shift > half_extent(body, side) - 1e-6)
        return np.array(found, dtype=bool)

    def width(self, frame: PlateFrame, full: bool, share: float) -> float:
        """A leg's width, ``share`` of the way from the least to the most."""
        most, given = frame.length, self.design.mold.leg_mm
        least = min(most, max(2.0 * frame.thickness, LEAST_WIDTH_MM))
        if given is not None:
            most = min(most, given)
        elif not full:
            most *= _EMBEDDED
        return min(least, most) + share * max(most - least, 0.0)

    def stances(self, share: float, places: Sequence[float]) -> dict[float, Stance]:
        """All legs at one width and each of several places, worked out together."""
        requested = self.design.mold.plate_fixture
        drafts = []
        for place in places:
            for (frame, side), full in zip(self.ends, self.full, strict=True):
                width = round(self.width(frame, bool(full), share), 4)
                offset = round(place * 0.5 * (frame.length - width), 4)
                start = end_of(frame, side)
                drafts.append(Leg(frame.index, side, width, offset, start, start, start, False))
        sides = [leg.side for leg in drafts]
        exits = self.leg_exits(drafts)
        openings = {way: self.slot_exits(drafts, way) for way in {requested, SLOTS}}
        web = slots.least_web(self.design, requested, self.limits)
        flat = openings[requested].face_margin >= web - CLOSE
        if requested != SLOTS:
            flat &= self.room.framed(sides, openings[requested])
        legs = []
        for k, leg in enumerate(drafts):
            out = float(max(exits.farthest[k], leg.start))
            legs.append(replace(leg, exit=out, tip=out, flat=bool(flat[k])))
        crossed = replace(self, legs=tuple(legs)).gaps() < self.least_gap - CLOSE
        crossed |= np.array([meets_hole(self.by_index[leg.plate], leg) for leg in legs])
        wrong = _CROSSED * crossed  # meets other metal, or a hole of its own plate
        short = self.room.lack(sides, openings[SLOTS], exits)
        short = np.where(np.isfinite(short), short, 1e3 - exits.nearest)
        short += self.room.blocked(sides, openings[SLOTS], exits)
        short += self.room.sunk(openings[SLOTS])
        penalty = {SLOTS: wrong + _LEFT * ((short > CLOSE) + short)}
        if requested != SLOTS:
            penalty[requested] = wrong + _NOT_FLAT * ~flat
        found = {}
        for place in places:
            here, legs = tuple(legs[: len(self.ends)]), legs[len(self.ends) :]
            found[place] = here, {way: each[: len(here)] for way, each in penalty.items()}
            penalty = {way: each[len(here) :] for way, each in penalty.items()}
        return found

    @cached_property
    def ranks(self) -> dict[int, tuple[int, float]]:
        """Each plate's number in its row, and its rank there from -1 to 1."""
        found = {}
        for row in self.rows:
            last = 0.5 * (len(row.frames) - 1)
            for k, frame in enumerate(row.frames):
                found[frame.index] = (k, (k - last) / last if last else 0.0)
        return found

    def choose(
        self, stances: dict[float, Stance], pattern: tuple[float, float]
    ) -> tuple[tuple[Leg, ...], float]:
        """The best place of each leg, near to a pattern's; and what is wrong in the end."""
        requested = self.design.mold.plate_fixture
        legs, wrong = self._chosen(stances, pattern, dict.fromkeys(SIDES, requested))
        chosen = replace(self, legs=legs)
        ways = {side: chosen.holding(side) for side in SIDES}
        if SLOTS in ways.values():
            legs, wrong = self._chosen(stances, pattern, ways)
            chosen = replace(self, legs=legs)
        return legs, wrong + wrong_between(chosen)

    def _chosen(
        self,
        stances: dict[float, Stance],
        pattern: tuple[float, float],
        ways: dict[Side, Holding],
    ) -> tuple[tuple[Leg, ...], float]:
        chosen, total = [], 0.0
        for k, (frame, side) in enumerate(self.ends):
            way = SLOTS if ways[side] == "wall" else ways[side]
            number, rank = self.ranks[frame.index]
            target = pattern[0] * (-1.0 if number % 2 else 1.0) + pattern[1] * rank
            wrong, _, best = min(
                (float(penalty[way][k]), abs(place - target), place)
                for place, (_, penalty) in stances.items()
            )
            chosen.append(stances[best][0][k])
            total += wrong
            total += 0.0 if chosen[-1].flat else _NOT_FLAT
        return tuple(chosen), total


def wrong_between(fixture: Fixture) -> float:
    """Penalty of what is wrong between legs: webs that lack some width, legs that cross."""
    wrong = _CROSSED * len(fixture.crossings())
    for side in SIDES:
        web = slots.least_web(fixture.design, fixture.holding(side), fixture.limits)
        lack = web - slots.webs(fixture.slots(side))[2]
        wrong += float((0.1 + _LACK * lack[lack > CLOSE]).sum())
    return wrong


def meets_hole(frame: PlateFrame, leg: Leg) -> bool:
    """True where a hole at the plate's end leaves the leg no solid metal to begin on."""
    end = frame.high if leg.side[0] == "+" else frame.low
    for hole in frame.holes:
        apart = max(abs(hole.s - leg.offset) - 0.5 * leg.width, 0.0)
        if np.hypot(apart, hole.w - end) - hole.radius < frame.thickness:
            return True
    return False


def fixture_of(design: Design, thorough: bool = True) -> Fixture:
    """Find the best legs of all plates, in mold space, two each, plate by plate.

    Not ``thorough``: only the likeliest widths and places are tried.
    """
    limits = limits_of(design.mold)
    search = Search(design, limits, frames_in_mold(design, scale_of(design)))
    if not search.frames:
        return search
    best: tuple[Leg, ...] = ()
    least = np.inf
    shares: tuple[float, ...] = _SHARES
    rounds: list[tuple[tuple[float, ...], tuple[tuple[float, float], ...]]]
    rounds = [(_COARSE, _ZIGZAGS), (_FINE, _FANS)]
    if not thorough:
        shares, rounds = tuple(dict.fromkeys((shares[0], shares[-1]))), rounds[:1]
    known: dict[float, dict[float, Stance]] = {share: {} for share in shares}
    for places, patterns in rounds:
        for share in shares:
            stances = known[share]
            stances |= search.stances(share, [each for each in places if each not in stances])
            for pattern in patterns:
                legs, wrong = search.choose(stances, pattern)
                if wrong < least:
                    best, least = legs, wrong
            if least == 0.0:
                break
        if least < _GOOD:
            break
    return _with_tips(Fixture(design, limits, search.frames, best))


def _with_tips(fixture: Fixture) -> Fixture:
    """The legs with their tips: past the face and its sheets by a tab; of plates that are alike the
    longest leg's length, so that they are cut alike."""
    design = fixture.design

    def length(leg: Leg) -> float:
        holding = fixture.holding(leg.side)
        thick = slots.sheet_thickness(design, holding)
        return leg.exit + thick + design.mold.tab_mm - leg.start

    def kind(leg: Leg) -> tuple[object, ...]:
        frame = fixture.by_index[leg.plate]
        sizes = (frame.length, frame.span, frame.bend_radius, leg.width, leg.offset)
        return (leg.side, frame.along, *(None if s is None else round(s, 6) for s in sizes))

    longest: dict[tuple[object, ...], float] = {}
    for leg in fixture.legs:
        longest[kind(leg)] = max(longest.get(kind(leg), 0.0), length(leg))
    legs = (replace(leg, tip=leg.start + longest[kind(leg)]) for leg in fixture.legs)
    return replace(fixture, legs=tuple(legs))
