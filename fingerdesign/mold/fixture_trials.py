"""What of a design's legs and slots is worst, and changed designs that are tried for remedies."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.design.checks import is_sound
from fingerdesign.design.faults import at_least
from fingerdesign.design.layout import PlateFrame
from fingerdesign.design.plate_rows import PlateRow, plate_rows, with_key
from fingerdesign.mold import slots
from fingerdesign.mold.fixture import legs_above, slots_on
from fingerdesign.mold.frames import frames_in_mold, scale_of
from fingerdesign.mold.leg_room import Room
from fingerdesign.mold.plan import SIDES, Holding, Leg

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.profiles import Limits

CLOSE = 2e-6  # mm; rounding
TRIALS = 9  # halvings: a pitch to some hundredths of a millimetre

Frames = tuple[PlateFrame, ...]
Legs = tuple[Leg, ...]
Web = tuple[Holding, int, int, float, float]  # how they are held, two plates, web, least web


def row_of(design: Design, plate: int) -> PlateRow:
    """The row that a plate stands in; KeyError for a number that no plate has."""
    for row in plate_rows(design):
        if any(frame.index == plate for frame in row.frames):
            return row
    raise KeyError(plate)


def again(design: Design, limits: Limits, thorough: bool = False) -> tuple[Frames, Legs]:
    """Plates and legs, in mold space, of a changed design."""
    from fingerdesign.mold.legs import legs_of

    scale = scale_of(design)
    return frames_in_mold(design, scale), legs_of(design, scale, limits, thorough)


def least_value(
    design: Design, key: str, low: float, high: float, holds: Callable[[Design], bool]
) -> float | None:
    """About the least value of a key in (low, high] from which a sound design ``holds``."""

    def does(value: float) -> bool:
        trial = with_key(design, key, value)
        return trial is not None and holds(trial)

    found = next((v for v in np.linspace(low, high, 9)[1:] if does(float(v))), None)
    if found is None:
        return None
    under, over = float(found) - (high - low) / 8.0, float(found)
    for _ in range(TRIALS - 3):
        middle = 0.5 * (under + over)
        under, over = (under, middle) if does(middle) else (middle, over)
    over = float(at_least(over))
    trial = with_key(design, key, over)
    return over if trial is not None and holds(trial) and is_sound(trial) else None


def worst_exit(
    design: Design, frames: Frames, legs: Legs, limits: Limits
) -> tuple[Leg, Room, float] | None:
    """The leg that leaves most too near to the contact zone, its nearest exit; None: none does."""
    room, above = legs_above(design, frames, legs, limits)
    worst: tuple[float, Leg, float] | None = None
    for leg, nearest in above:
        short = room.least_exit(leg.side) - nearest
        if short > CLOSE and (worst is None or short > worst[0]):
            worst = (short, leg, nearest)
    return None if worst is None else (worst[1], room, worst[2])


def worst_web(design: Design, frames: Frames, legs: Legs, limits: Limits) -> Web | None:
    """The two slots that lack most of a web; None: all webs are held."""
    worst: Web | None = None
    for side in SIDES:
        openings = slots_on(design, frames, legs, limits, side)
        holding = slots.holding_of(design, slots.on_side(legs, side))
        web = slots.least_web(design, holding, limits)
        first, second, distance = slots.webs(openings)
        if not len(distance):
            continue
        k = int(np.argmin(distance))
        lack = web - distance[k]
        if lack > CLOSE and (worst is None or lack > worst[4] - worst[3]):
            one, two = openings[first[k]].plate, openings[second[k]].plate
            worst = (holding, one, two, float(distance[k]), web)
    return worst
