"""Second combs, on the outer faces of an open mold's frames: they take all play out of the first.

A leg in one slot is off by the slot's play, and turns by that play over its width: this was nine
tenths of the error of placement. A second sheet, the frame's thickness farther out, is slid until
its slots push each leg against one face and one end of the slot in the first; the legs bend a
little and so are their own springs, which no slot's tolerance can leave unloaded. What is left is
how true that face is cut. Numbers only, mm.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fingerdesign.design.schema import Design
from fingerdesign.mold.plan.fixture import Fixture
from fingerdesign.mold.plan.limits import comb_tolerance
from fingerdesign.mold.plan.plan import Leg, MoldPlan, OuterComb, SidePlan, Slot, slot_corners
from fingerdesign.mold.plan.slots import least_web, moved, ways, webs

# By how much an outer slot is wider and longer than the inner one: legs are threaded through all of
# them at once, and the sheet is slid by it. The first that leaves webs is taken.
ROOMS_MM = (0.15, 0.1, 0.07, 0.05, 0.03, 0.02, 0.01)
# Of a slide along the face's normal and along the slot, the least share of it that pushes a leg:
# below a quarter, friction (steel on bronze, 0.2 or so) holds what should slide.
LEAST_PUSH = 0.25
STRIP_MM = 1.0  # of an outer comb, around its slots and bolts
_TURNS = 72


def with_outer_combs(fixture: Fixture, plan: MoldPlan, reach: float) -> MoldPlan:
    """Add outer combs on every side whose legs one slide can push, and let legs reach through them;
    ``reach``: |x| up to which the combs lie below the bolts' washers."""
    design, limits = fixture.design, plan.limits
    sides = tuple(_side(fixture, plan, side, reach) for side in plan.sides)
    tips = {s.side: plan.reach(s.side) + s.sheet + design.mold.tab_mm for s in sides if s.outer}
    legs = tuple(replace(leg, tip=tips.get(leg.side, leg.tip)) for leg in plan.legs)
    seam = limits.seam_mm
    lows = [side.window[2] for side in sides if side.window]
    lows += [bolt.second - 0.5 * bolt.diameter for bolt in plan.bolts]
    walls = min(lows, default=0.0) - seam >= limits.wall_mm - 1e-9  # what is left below them
    both = sum(side.outer is not None for side in sides) == 2
    return replace(plan, sides=sides, legs=legs, seam=seam if both and walls else 0.0)


def bow(design: Design, plan: MoldPlan, side: SidePlan) -> float:
    """How far the middle of a plate bends off its place, mm, where outer combs push its legs.

    Every leg is pushed where the slide goes on by twice the tolerance e of an edge beyond the first
    touch. A bar held at L between the inner combs and pushed a beyond them bends in its middle by
    e L^2 / (8 a (L / 2 + a / 3)).
    """
    if side.outer is None:
        return 0.0
    long, beyond = 2.0 * plan.half_depth, plan.wall(side.side)
    pushed = 2.0 * comb_tolerance(design.mold)
    return pushed * long**2 / (8.0 * beyond * (0.5 * long + beyond / 3.0))


def _side(fixture: Fixture, plan: MoldPlan, side: SidePlan, reach: float) -> SidePlan:
    legs = fixture.on(side.side)
    if side.holding != "comb" or not legs:
        return side
    push = push_of(side.slots)
    if push is None:
        return side
    web = least_web(fixture.design, "comb", fixture.limits) - 1e-9
    pairs = list(zip(legs, side.slots, strict=True))
    inner = tuple(moved(slot, fixture.bar(leg), -1.0) for leg, slot in pairs)
    if webs(inner)[2].min(initial=math.inf) < web:
        return side
    for room in ROOMS_MM:
        outer = tuple(_wider(fixture, leg, slot, room) for leg, slot in pairs)
        if webs(outer)[2].min(initial=math.inf) >= web:
            corners = slot_corners(outer).reshape(-1, 2)
            (left, low), (right, high) = corners.min(axis=0), corners.max(axis=0)
            bolts = [(abs(b.first), b.second, 0.5 * b.diameter + room) for b in plan.bolts]
            half = max(-left, right, reach, *(x + edge for x, _, edge in bolts))
            low = min(low, *(y - edge for _, y, edge in bolts))
            high = max(high, *(y + edge for _, y, edge in bolts))
            low = max(float(low) - STRIP_MM, 0.0)
            size = (float(half) + STRIP_MM, low, float(high) + STRIP_MM)
            return replace(side, slots=inner, outer=OuterComb(outer, push, *size))
    return side


def push_of(slots: Sequence[Slot]) -> tuple[float, float] | None:
    """The slide (unit vector) that pushes all legs best onto one face and one end of their slots;
    None where it would not move one of them."""
    turn = 2.0 * np.pi * np.arange(_TURNS) / _TURNS
    slides = np.column_stack([np.cos(turn), np.sin(turn)])
    shares = np.vstack([each @ slides.T for each in ways(slots)]).min(axis=0)
    best = int(np.argmax(np.round(shares, 9)))
    if shares[best] < LEAST_PUSH:
        return None
    x, y = np.round(slides[best], 9) + 0.0
    return float(x), float(y)


def _wider(fixture: Fixture, leg: Leg, slot: Slot, room: float) -> Slot:
    """The outer slot: where the slide ends, its faces behind the leg touch that."""
    larger = replace(slot, width=slot.width + room, length=slot.length + room)
    return moved(larger, fixture.bar(leg), 1.0)
