"""Legs of plates: how wide they are and where along the plate they stand, so that they can be held.

Wide tabs on plates that reach the finger's end, thin legs on those embedded in it. They are moved
along the plate and narrowed until they leave the finger outside its contact zone, clear of other
plates, and their slots keep the webs; what cannot be had is a fault of fixture_faults.py. Numbers
only.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.design.layout import PlateFrame
from fingerdesign.design.volume import outline_volume
from fingerdesign.mold import slots
from fingerdesign.mold.frames import frames_in_mold
from fingerdesign.mold.leg_search import Search
from fingerdesign.mold.plan import Leg, MoldPlan

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.profiles import Limits

_SHARES = (1.0, 0.8, 0.6, 0.45, 0.3, 0.0)  # of the way from the least width to the most
# Of the way from the plate's centre to its end: the first ones are tried for all, then every one.
_COARSE = (0.0, 0.5, -0.5, 1.0, -1.0)
_FINE = (*_COARSE, 0.25, -0.25, 0.75, -0.75)
# How legs stand along a row: neighbours on either side of their plates' centres; or fanned out
# from one end of the row to the other.
_ZIGZAGS: tuple[tuple[float, float], ...] = ((0.0, 0.0), (0.5, 0.0), (1.0, 0.0))
_FANS: tuple[tuple[float, float], ...] = ((0.0, 1.0), (0.0, -1.0), (0.0, 0.5), (0.0, -0.5))
_GOOD = 1e-2  # sides held by slots where a comb was asked for: no fault


def legs_of(design: Design, scale: float, limits: Limits, thorough: bool = True) -> tuple[Leg, ...]:
    """The legs of every plate, two each, plate by plate: the best that can be had.

    ``scale``: the outline's enlargement; ``limits``: of the mold's process. What still is wrong
    with them (webs, crossings, exits in the contact zone) is told by ``fixture.sides_of``.
    Not ``thorough``: only the likeliest widths and places are tried.
    """
    frames = frames_in_mold(design, scale)
    if not frames:
        return ()
    search = Search(design, scale, limits, frames)
    best: tuple[Leg, ...] = ()
    least = np.inf
    shares: tuple[float, ...] = _SHARES if search.full.any() else _SHARES[:1]
    rounds: list[tuple[tuple[float, ...], tuple[tuple[float, float], ...]]]
    rounds = [(_COARSE, _ZIGZAGS), (_FINE, _FANS)]
    if not thorough:
        shares, rounds = tuple(dict.fromkeys((shares[0], shares[-1]))), rounds[:1]
    for places, patterns in rounds:
        for share in shares:
            trials = {place: search.trial(share, place) for place in places}
            for pattern in patterns:
                legs, wrong = search.choose(trials, pattern)
                if wrong < least:
                    best, least = legs, wrong
            if least == 0.0:
                break
        if least < _GOOD:
            break
    return _with_tips(design, limits, best, frames)


def _with_tips(
    design: Design, limits: Limits, legs: tuple[Leg, ...], frames: tuple[PlateFrame, ...]
) -> tuple[Leg, ...]:
    """The legs with their tips: past the face and its sheets by a tab; of plates that are alike the
    longest leg's length, so that they are cut alike."""
    tips = []
    for leg in legs:
        holding = slots.holding_of(design, slots.on_side(legs, leg.side))
        sheets = slots.sheets_thickness(design, holding, limits) * (2 if holding == "jig" else 1)
        tips.append(leg.exit + sheets + design.mold.tab_mm)
    by_index = {frame.index: frame for frame in frames}
    longest: dict[tuple[object, ...], float] = {}

    def kind(leg: Leg) -> tuple[object, ...]:
        frame = by_index[leg.plate]
        sizes = (frame.length, frame.span, frame.bend_radius, leg.width, leg.offset)
        return (leg.side, frame.along, *(None if s is None else round(s, 6) for s in sizes))

    for leg, tip in zip(legs, tips, strict=True):
        longest[kind(leg)] = max(longest.get(kind(leg), 0.0), tip - leg.start)
    return tuple(replace(leg, tip=leg.start + longest[kind(leg)]) for leg in legs)


def legs_volume(plan: MoldPlan) -> float:
    """Volume of the legs that stay in the rubber, from the plates' ends to the exits, mm^3.

    At most: where a leg leaves through a slanted face, to its farthest point.
    """
    thick = {frame.index: frame.thickness for frame in plan.frames}
    return sum(leg.width * thick[leg.plate] * (leg.exit - leg.start) for leg in plan.legs)


def legs_share(design: Design, plan: MoldPlan) -> float:
    """The legs' volume over that of the finger's outline in mold space, 0 to 1."""
    return legs_volume(plan) / (plan.scale**3 * outline_volume(design.body))
