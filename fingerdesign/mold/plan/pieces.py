"""Pieces of a mold's plan: its sides, and legs, slots, combs, bolts, pins, lugs and holes on them.

Mold space as of plan.py, lengths in mm. A side is named by its outward normal; a place is x on the
sides +-z, z on the sides +-x.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.body import Core
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.gaps import flat_corners
from fingerdesign.mold.part import OUTER

Box = tuple[Array, Array]  # low and high corners (3,)
Side = Literal["+z", "-z", "+x", "-x"]
ENDS: tuple[Side, Side] = ("+z", "-z")
FLANKS: tuple[Side, Side] = ("+x", "-x")
SIDES: tuple[Side, ...] = (*ENDS, *FLANKS)
WORDS: Mapping[Side, str] = {"+z": "front", "-z": "back", "+x": "right", "-x": "left"}
Holding = Literal["wall", "comb", "slots"]
Pour = Literal["open", "closed"]
HoleKind = Literal["gate", "riser", "vent", "lock", "screw", "wires"]
RELIEF_MM = 0.3  # of the insert's ends under outer combs, which would clamp it
PRY_MM = (2.5, 2.0, 3.0)  # a notch's depth and height, and half its length


def wall_name(side: Side) -> str:
    """The part that closes a side: end_wall_front (+z), ..._back, side_wall_right (+x), ..._left.

    >>> wall_name("-x")
    'side_wall_left'
    """
    return f"{'end' if side.endswith('z') else 'side'}_wall_{WORDS[side]}"


def direction(side: Side) -> Array:
    """The outward unit normal (3,) of a side."""
    return in_space(side, 0.0, 0.0, 1.0)


def across(side: Side) -> Array:
    """The level unit vector (3,) along a side, +x or +z."""
    return in_space(side, 1.0, 0.0)


def in_space(side: Side, place: float, y: float, out: float = 0.0) -> Array:
    """The point (3,) at a place along a side and a height, ``out`` from the mid-plane."""
    out = out if side[0] == "+" else -out
    return np.array([place, y, out] if side.endswith("z") else [out, y, place])


def core_in_mold(core: Core, scale: float) -> Core:
    """The core in mold space: its middle moves with the rubber, one on the base stays there."""
    if core.bottom_mm == 0.0:
        return core
    middle = scale * (core.bottom_mm + 0.5 * core.height_mm)
    return core.model_copy(update={"bottom_mm": middle - 0.5 * core.height_mm})


@dataclass(frozen=True)
class Leg:
    """The piece of a plate that reaches out of the finger at one end, to be held there.

    In the plate's frame: ``width`` along its axis, centred ``offset`` from its centre, as thick as
    the plate; from ``start`` (the plate's end) past ``exit`` (the farthest place where it passes
    the finger's surface) to ``tip``, all distances from the mid-plane along ``side``'s direction.
    flat: it leaves through a flat face of the finger that is normal to the side.
    """

    plate: int
    side: Side
    width: float
    offset: float
    start: float
    exit: float
    tip: float
    flat: bool


@dataclass(frozen=True)
class Slot:
    """The opening in a comb or wall for one leg, a rectangle drawn through it along the side.

    Centre (``place``, ``y``): place is x for sides +-z, z for sides +-x. ``length`` along the
    direction ``angle_deg`` (as of a plate's frame), ``width`` across it. mouth: (out, y), how far
    from the mid-plane and down to what height all below the slot is cut, where the wall would end
    there in an edge too sharp to be made.
    """

    plate: int
    side: Side
    place: float
    y: float
    angle_deg: float
    length: float
    width: float
    mouth: tuple[float, float] | None = None

    @property
    def lower(self) -> Array:
        """The two ends (2, 2) of its lowest side, which is its long or its short one: places and
        heights, from low to high places."""
        angle = math.radians(self.angle_deg)
        sine, cosine = math.sin(angle), math.cos(angle)
        along, across = np.array([cosine, sine]), np.array([-sine, cosine])
        long, short = 0.5 * self.length * along, 0.5 * self.width * across
        level, down = (long, short) if abs(cosine) > abs(sine) else (short, long)
        level, down = level * np.copysign(1.0, level[0]), down * np.copysign(1.0, -down[1])
        return np.asarray(np.array([self.place, self.y]) + down + np.array([-level, level]))


def slot_corners(slots: Sequence[Slot]) -> Array:
    """Corners (n, 4, 2) of slots in their side's plane (place, y), anticlockwise."""
    sizes = ((s.plate, s.place, s.y, s.angle_deg, s.length, s.width, 0.0, 1.0) for s in slots)
    return flat_corners(tuple(PlateFrame(*each) for each in sizes))


@dataclass(frozen=True)
class OuterComb:
    """A second comb on a half frame's outer face, some millimetres from the first. It is slid along
    ``push`` (place, y), a unit vector, until it holds each leg against one face and one end of its
    slot in the first: then no play counts, and a leg's bending is the spring that keeps it there.

    slots    as they stand when it holds the legs; wider than these toward ``push``
    half, low, high   of its rectangle: |place|, and heights
    """

    slots: tuple[Slot, ...]
    push: tuple[float, float]
    half: float
    low: float
    high: float


@dataclass(frozen=True)
class SidePlan:
    """The plan of one side: how it is closed and how it holds plates.

    holding "wall": no plate leaves here. "comb": a sheet of ``sheet`` thickness is the finger's
    face, backed by the wall. "slots": the wall itself has slots, through all of its thickness.
    ``window``: (place low, place high, y low) of the opening behind a comb, open toward the insert
    and outward; None without one. framed: the wall is a half frame of an open mold. outer: the
    second comb on it, None without one.
    """

    side: Side
    holding: Holding
    sheet: float
    window: tuple[float, float, float] | None
    slots: tuple[Slot, ...]
    framed: bool = False
    outer: OuterComb | None = None

    @property
    def openings(self) -> Array:
        """Rectangles (n, 4) of the window, or of the slots: low, high, bottom, top; infinite at the
        top of a window, which is open to the wall's top."""
        if self.window is not None:
            return np.array([[*self.window, np.inf]])
        corners = slot_corners(self.slots)
        return np.hstack([corners.min(axis=1), corners.max(axis=1)])[:, [0, 2, 1, 3]]

    @property
    def wall(self) -> str:
        """The name of the wall, or of the half frame (frame_front, frame_back), of the side."""
        return f"frame_{WORDS[self.side]}" if self.framed else wall_name(self.side)

    @property
    def comb(self) -> str | None:
        """The comb's name; None without one."""
        return f"comb_{WORDS[self.side]}" if self.holding == "comb" else None

    @property
    def outer_comb(self) -> str | None:
        """The second comb's name; None without one."""
        return f"comb_{WORDS[self.side]}{OUTER}" if self.outer else None

    @property
    def holder(self) -> str:
        """The part that has the slots: the comb, else the wall."""
        return self.comb or self.wall


@dataclass(frozen=True)
class Plug:
    """An insert narrower than the finger: it ends at |x| or |z| = ``at_surface`` on the contact
    surface and widens by the draft to ``at_top`` at the block's top; what is beyond belongs to
    the walls of that axis."""

    axis: Literal["x", "z"]
    at_surface: float
    at_top: float


@dataclass(frozen=True)
class Bolt:
    """A straight through hole: axis "y" or "z", its place in the other two, from ``low`` to
    ``high``; ``size`` as "M3", ``diameter`` of the clearance hole."""

    axis: Literal["y", "z"]
    first: float
    second: float
    low: float
    high: float
    size: str
    diameter: float

    def at(self, distance: float) -> Array:
        """The point (3,) of its axis at a distance along it."""
        return np.insert([self.first, self.second], 1 if self.axis == "y" else 2, distance)


@dataclass(frozen=True)
class Pin:
    """A tapered pin and its socket.

    Root centre ``root``, unit ``direction`` along which it reaches out of ``on`` (a part's name)
    into the socket of ``into``; ``diameter`` at the root, ``tip_diameter`` at ``length``; the
    socket is larger by ``clearance`` all round and deeper by it. dowel: both parts have a hole of
    a straight steel pin instead, half the length each, with the clearance in ``into`` alone.
    """

    root: tuple[float, float, float]
    direction: tuple[float, float, float]
    diameter: float
    tip_diameter: float
    length: float
    clearance: float
    on: str
    into: str
    dowel: bool


@dataclass(frozen=True)
class Lug:
    """A box from ``low`` to ``high`` (three coordinates each) that extends the half frame ``on``
    beyond y = 0, next to the base plate, which it places."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    on: str


@dataclass(frozen=True)
class BaseHole:
    """A hole through the base plate at (x, z). kind: "gate" (silicone is poured in), "riser",
    "vent", "lock" (silicone or primer holds the finger; wider outside, an undercut), "screw" (to
    the core), "wires" (the gages' leads). ``diameter`` at y = 0, ``outer_diameter`` at the plate's
    back; of "wires" that of a pocket there, ``pocket`` deep, in which the leads are knotted and
    potted, with a channel out to the plate's front edge."""

    kind: HoleKind
    x: float
    z: float
    diameter: float
    outer_diameter: float
    pocket: float = 0.0

    @property
    def radius(self) -> float:
        """Radius of its wider end."""
        return 0.5 * max(self.diameter, self.outer_diameter)


@dataclass(frozen=True)
class CorePin:
    """A straight pin through a wall that holds the core while the rubber cures; drawn with it.

    At (place, y) on ``side``; ``diameter``; from the wall's outside to ``tip`` (distance from the
    mid-plane), ``depth`` of it inside the core; ``clearance`` all round in the wall."""

    side: Side
    place: float
    y: float
    diameter: float
    tip: float
    depth: float
    clearance: float
