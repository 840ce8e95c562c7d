"""The plan of a mold: every number that its parts are built from, before any CAD.

Mold space: the finger's axes (base plane y = 0, contact surface toward +y, plates along z), the
elastomer's outline enlarged by ``scale`` for its shrinkage about the origin; metal is not enlarged.
Lengths in mm. Cast with the base up: gravity points along +y.

Parts of an open mold: the contact insert above the contact surface (drawn along +y), two half
frames that meet at z = 0 (drawn along +-z), where plates leave the finger through a flat face a
comb in the end of each and another on its outer face, and the base plate below y = 0, which is
pressed on last and stays on the finger as its mount. A closed one has two end walls (drawn along
+-z) and two side walls between them (drawn along +-x) instead of the frames, and openings in its
base plate.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import get_args

import numpy as np

from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.volume import outline_volume
from fingerdesign.mold.part import INSERT
from fingerdesign.mold.plan import pieces
from fingerdesign.mold.plan.limits import SPARE_MM, Limits, limits_of
from fingerdesign.mold.plan.pieces import BaseHole, Leg, Side, SidePlan, Slot

GROOVE_MM = (1.0, 1.2)  # of the mount: deep, high
LEAST_GROOVE_MM = 0.4


@dataclass(frozen=True)
class Extent:
    """The enlarged outline in numbers, mm.

    half_width, half_depth   of its footprint
    corner        end walls hold |z| > corner, side walls what is between (half_depth of a body
                  with flat ends; less where it is round or narrows)
    rim           height up to which the walls reach where the contact surface meets them lowest
    crest         its greatest height
    continued     whether the walls continue the contact surface outward; else they end at the rim
    """

    half_width: float
    half_depth: float
    corner: float
    rim: float
    crest: float
    continued: bool


@dataclass(frozen=True)
class MoldPlan(Extent):
    """All of a mold.

    design        the finger that is cast
    scale         the outline's enlargement, 1 / (1 - shrinkage)
    frames        the plates in mold space: middles moved with the rubber, metal not enlarged
    top, base     height of the insert's far face; thickness of the base plate
    wall_x, wall_z, ear   thickness of side and end walls; how much farther than the side walls the
                  end walls, the insert and the base plate reach along x
    pour          "open": two half frames, filled from above; "closed": four walls, gate and vents
    closed_for    why it is not an open one, where that was looked into; else ""
    seam          by how much half frames end short of the base plate, which lies on the combs
    mount_x, mount_z   half sizes of the base plate, which stays on the finger as its mount
    lip           thickness of a closed mold's base frame below that plate
    """

    design: Design
    scale: float
    frames: tuple[PlateFrame, ...]
    legs: tuple[Leg, ...]
    sides: tuple[SidePlan, ...]
    plugs: tuple[pieces.Plug, ...]
    top: float
    base: float
    base_holes: tuple[BaseHole, ...] = ()
    core_pins: tuple[pieces.CorePin, ...] = ()
    wall_x: float = 0.0
    wall_z: float = 0.0
    ear: float = 0.0
    bolts: tuple[pieces.Bolt, ...] = ()
    pins: tuple[pieces.Pin, ...] = ()
    lugs: tuple[pieces.Lug, ...] = ()
    mount_x: float = 0.0
    mount_z: float = 0.0
    lip: float = 0.0
    pour: pieces.Pour = "closed"
    closed_for: str = ""
    seam: float = 0.0

    @cached_property
    def limits(self) -> Limits:
        """Sizes that the process can make."""
        return limits_of(self.design.mold)

    @cached_property
    def holes(self) -> dict[pieces.HoleKind, list[BaseHole]]:
        """The base plate's holes by their kind."""
        return {k: [h for h in self.base_holes if h.kind == k] for k in get_args(pieces.HoleKind)}

    @cached_property
    def groove(self) -> tuple[float, float, float] | None:
        """Depth, y low and y high, mm, of the grooves along z in the base plate's flanks, by which
        a hand holds the finger: outside of it, with a wall all round; None without room."""
        wall = self.limits.wall_mm + SPARE_MM
        far = max((abs(hole.x) + hole.radius for hole in self.base_holes), default=0.0)
        ledge = self.mount_x - self.half_width - SPARE_MM
        depth = min(GROOVE_MM[0], ledge, self.mount_x - far - wall)
        high = min(GROOVE_MM[1], self.base - 2.0 * wall)
        if depth < LEAST_GROOVE_MM or high < LEAST_GROOVE_MM:
            return None
        return depth, wall - self.base, wall - self.base + high

    @cached_property
    def pry(self) -> bool:
        """True where the insert has notches to pry it off: no bolt or pin of it is near them."""
        deep, high, half = pieces.PRY_MM
        wall = self.limits.wall_mm
        places = [(b.first, b.second, b.diameter) for b in self.bolts if b.axis == "y"]
        places += [(p.root[0], p.root[2], p.diameter) for p in self.pins if p.on == INSERT]
        return self.top - self.crest > high + wall and all(
            abs(x) + 0.5 * wide + wall < self.reach_x - deep or abs(z) - 0.5 * wide - wall > half
            for x, z, wide in places
        )

    @property
    def core(self) -> pieces.Box | None:
        """Corners (3,) of the core, mm; None without one."""
        body = self.design.body
        if body.core is None:
            return None
        core = pieces.core_in_mold(body.core, self.scale)
        low = np.array([-0.5 * core.width_mm, core.bottom_mm, -0.5 * body.core_depth_mm])
        return low, np.array([-low[0], core.bottom_mm + core.height_mm, -low[2]])

    @property
    def walls(self) -> tuple[str, ...]:
        """The names of what surrounds the finger: two half frames, or four walls."""
        return tuple(side.wall for side in self.sides if side.framed or self.pour == "closed")

    @property
    def reach_x(self) -> float:
        """|x| of the block's faces: insert and end walls."""
        return self.half_width + self.wall_x + self.ear

    @property
    def block_x(self) -> float:
        """|x| of the faces of the block that is filled: side walls end, and the ears begin."""
        return self.half_width + self.wall_x

    @property
    def block(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Corners of the block that outline and blanks fill; base plate and ears are left out."""
        high = (self.block_x, self.top, self.reach_z)
        return (-high[0], 0.0, -high[2]), high

    @property
    def reach_z(self) -> float:
        """|z| of the block's faces."""
        return self.half_depth + self.wall_z

    def reach(self, side: Side) -> float:
        """Distance of the block's face on a side from the mid-plane."""
        return self.reach_x if side.endswith("x") else self.reach_z

    def half(self, side: Side) -> float:
        """Distance of the outline's end on a side from the mid-plane."""
        return self.half_width if side.endswith("x") else self.half_depth

    def wall(self, side: Side) -> float:
        """Thickness of a side's wall."""
        return self.wall_x if side.endswith("x") else self.wall_z

    @cached_property
    def by_side(self) -> dict[Side, SidePlan]:
        """The plan of each side."""
        return {each.side: each for each in self.sides}

    @cached_property
    def plug_widths(self) -> dict[str, float]:
        """Half-width of the insert along each axis at which a plug narrows it."""
        return {plug.axis: plug.at_surface for plug in self.plugs}

    @cached_property
    def tips(self) -> dict[Side, float]:
        """Reach of the farthest leg on each side that has any."""
        legs = sorted(self.legs, key=lambda leg: leg.tip)
        return {leg.side: leg.tip for leg in legs}

    @cached_property
    def legs_by_plate(self) -> dict[int, tuple[Leg, ...]]:
        """The legs of each plate that has any."""
        plates = dict.fromkeys(leg.plate for leg in self.legs)
        return {k: tuple(leg for leg in self.legs if leg.plate == k) for k in plates}

    @cached_property
    def leg_slots(self) -> tuple[tuple[SidePlan, Slot, float], ...]:
        """Every slot with its side, and the width of the leg in it."""
        widths = {(leg.plate, leg.side): leg.width for leg in self.legs}
        slots = ((side, slot) for side in self.sides for slot in side.slots)
        return tuple((side, slot, widths[slot.plate, side.side]) for side, slot in slots)

    @cached_property
    def held_at(self) -> dict[int, list[Side]]:
        """The sides that hold each plate that has legs, in their order."""
        found: dict[int, list[Side]] = {}
        for side, slot, _ in self.leg_slots:
            found.setdefault(slot.plate, []).append(side.side)
        return found

    @property
    def thickness(self) -> dict[int, float]:
        """Thickness of each plate, by its number."""
        return {frame.index: frame.thickness for frame in self.frames}

    @property
    def legs_volume(self) -> float:
        """Volume of the legs that stay in the rubber, from the plates' ends to the exits, mm^3.

        At most: where a leg leaves through a slanted face, to its farthest point.
        """
        thick = self.thickness
        return sum(leg.width * thick[leg.plate] * (leg.exit - leg.start) for leg in self.legs)

    @property
    def legs_share(self) -> float:
        """The legs' volume over that of the finger's outline in mold space, 0 to 1."""
        return self.legs_volume / (self.scale**3 * outline_volume(self.design.body))


def spacer_height(plan: MoldPlan) -> float:
    """Height of the spacers under a frame or wall on the bench, mm: legs reach so far out of it,
    without the outer comb; 0 where none do."""
    return round(max(plan.tips.get("-z", 0.0) - plan.reach("-z"), 0.0), 2)
