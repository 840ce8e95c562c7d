"""Flat patterns of the plates: one for each different plate, as it is cut from sheet.

A pattern is drawn in (s, w): s along the plate's axis from its centre (of a bent plate along its
mid-surface), w across it, along +z or +x, from the middle of its span; mm.
"""

from dataclasses import dataclass
from itertools import count, product
from string import ascii_uppercase
from typing import Literal

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.plan.pieces import Leg
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.slots import end_of

Face = Literal["upper", "lower"]
_ALIKE = 3  # digits of a millimetre by which plates are distinguished
_IDLE_MM2 = 1e-9  # between a corner and its neighbours


@dataclass(frozen=True, eq=False)
class FlatPattern:
    """One kind of plate.

    name         "plate_A", "plate_B", ...
    plates       numbers of the plates that are cut so
    outline      polygon (n, 2) of what is cut, legs in full, anticlockwise
    holes        (s, w, radius) of each round hole
    faces, gage  that carry gages, and the rectangle (4, 2) that these average over
    bend_radius  of the mid-surface after cutting, its centre on the lower side; None: flat
    thickness, material   of the sheet
    seen         the face that a reader of (s to the right, w up) looks on
    """

    name: str
    plates: tuple[int, ...]
    outline: Array
    holes: tuple[tuple[float, float, float], ...]
    faces: tuple[Face, ...]
    gage: Array
    bend_radius: float | None
    thickness: float
    material: str
    seen: Face

    @property
    def count(self) -> int:
        """The number that is needed."""
        return len(self.plates)


def flat_patterns(plan: MoldPlan) -> tuple[FlatPattern, ...]:
    """One pattern for each different plate of a mold, in the order of their first plates."""
    gages = plan.design.gages
    faces: tuple[Face, ...] = ("upper", "lower") if gages.face == "both" else (gages.face,)
    s, w = 0.5 * gages.length_mm, 0.5 * gages.width_mm
    low, high = gages.z_mm - w, gages.z_mm + w
    gage = np.array([[-s, low], [s, low], [s, high], [-s, high]])
    kinds: dict[tuple[object, ...], list[PlateFrame]] = {}
    for frame in plan.frames:
        kinds.setdefault(_kind(frame, plan.legs_by_plate.get(frame.index, ())), []).append(frame)
    letters = ("".join(each) for k in count(1) for each in product(ascii_uppercase, repeat=k))
    return tuple(
        FlatPattern(
            f"plate_{name}",
            tuple(frame.index for frame in (first, *others)),
            outline_of(first, plan.legs_by_plate.get(first.index, ())),
            tuple((hole.s, hole.w - first.middle, hole.radius) for hole in first.holes),
            faces,
            gage,
            first.bend_radius,
            first.thickness,
            plan.design.plates.material,
            # Seen from above, s and w turn anticlockwise for plates along z only.
            "lower" if first.along == "x" else "upper",
        )
        for name, (first, *others) in zip(letters, kinds.values(), strict=False)
    )


def outline_of(frame: PlateFrame, legs: tuple[Leg, ...]) -> Array:
    """The polygon (n, 2) of one plate with its legs, in (s, w), anticlockwise, without double
    corners and those that lie between their neighbours in one line."""
    s, w = 0.5 * frame.length, 0.5 * frame.span
    sides: dict[str, list[tuple[float, float]]] = {"+": [], "-": []}
    for leg in legs:
        low, high = leg.offset - 0.5 * leg.width, leg.offset + 0.5 * leg.width
        out = w + leg.tip - leg.start
        sides[leg.side[0]] = [(low, w), (low, out), (high, out), (high, w)]
    lower = [(a, -b) for a, b in sides["-"]]
    points = np.array([(-s, -w), *lower, (s, -w), (s, w), *reversed(sides["+"]), (-s, w)])
    while True:
        one, two = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
        idle = np.flatnonzero(np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) < _IDLE_MM2)
        if not len(idle):
            return points
        points = np.delete(points, idle[0], axis=0)


def _kind(frame: PlateFrame, legs: tuple[Leg, ...]) -> tuple[object, ...]:
    """The facts that plates which are cut alike have in common."""
    numbers = [frame.length, frame.thickness, frame.span, frame.bend_radius or 0.0]
    for hole in frame.holes:
        numbers += [hole.s, hole.w - frame.middle, hole.radius]
    for leg in legs:
        numbers += [leg.width, leg.offset, leg.tip - end_of(frame, leg.side)]
    sides = (leg.side for leg in legs)
    return (frame.along, *sides, *(round(number, _ALIKE) + 0.0 for number in numbers))
