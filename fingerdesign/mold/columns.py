"""Where fasteners stand beside the finger: columns beyond its side, depths beyond its corner; mm.

Going out along x: the z-bolts (x1), then the tapered pins along z and the y-bolts (x2), then the
insert's pins and the base's keys (x3). Going out along z from the corner: the pins along z, then
the y-bolts and the insert's pins. Between any two, and to every face, the process's wall is left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from fingerdesign.mold.extent import Extent
from fingerdesign.mold.profiles import Limits

# Clearance holes of the medium series (ISO 273), mm; M2.5 in the table of the same series.
CLEARANCE_HOLES = {"M2": 2.4, "M2.5": 2.9, "M3": 3.4, "M4": 4.5}
SPARE_MM = 0.05  # beyond the least wall: round holes are measured as triangles
SLENDER = 1.5  # a pin's length, in diameters


@dataclass(frozen=True)
class Columns:
    """Places and sizes, mm.

    gap          wall that is left everywhere; hole: diameter of a bolt's clearance hole
    small, big   diameters of the pins: one of each kind is small, so that parts fit one way only
    clearance    of a pin in its socket, all round
    reach        of a pin along z into its socket, sheets that it passes included
    x1, x2, x3   of the columns; ``deep``: |z| of the y-bolts and of the insert's pins
    bar_bolt, bar_pin   |z| of those of an insert that is narrowed along x
    wall_x, ear, wall_z   what the walls need
    """

    size: str
    gap: float
    hole: float
    small: float
    big: float
    clearance: float
    reach: float
    x1: float
    x2: float
    x3: float
    deep: float
    bar_bolt: float
    bar_pin: float
    wall_x: float
    ear: float
    wall_z: float

    def thicker(self, wall_z: float) -> Columns:
        """The same with end walls as thick as asked."""
        return replace(self, wall_z=wall_z)

    @property
    def radius(self) -> float:
        """Of a bolt's hole."""
        return 0.5 * self.hole

    @property
    def socket(self) -> float:
        """Radius of the larger sockets."""
        return 0.5 * self.big + self.clearance

    @property
    def rise(self) -> float:
        """Height of wall that a bolt along z needs."""
        return self.hole + 2.0 * self.gap


def pin_sizes(limits: Limits) -> tuple[float, float]:
    """Diameters of the small and the big pins: a big one does not enter a small one's socket."""
    step = 1.0 if limits.dowels else max(0.5, 4.0 * limits.clearance_mm)
    return limits.pin_mm, limits.pin_mm + step


def pin_length(diameter: float, sheets: float, limits: Limits, corner: float) -> float:
    """How far a pin along z reaches beyond the side wall's end; a dowel reaches as far into it."""
    length = SLENDER * diameter + sheets
    return min(length, corner - limits.wall_mm) if limits.dowels else length


def columns_of(
    extent: Extent,
    limits: Limits,
    size: str,
    sheets: float,
    beside: float = 0.0,
    tips: float = 0.0,
    bar: bool = False,
    wide: bool = False,
) -> Columns:
    """The columns for bolts of a size.

    ``sheets``: thickness of the combs or jigs of an end, ``beside``: of a flank; ``tips``: how far
    plates reach out of open windows at the ends, 0: there are none; ``bar``: the insert is narrowed
    along x, its bolts and pins stand beyond the finger's ends; ``wide``: it has pins in the side
    walls, which reach as far as the end walls.
    """
    gap, hole = limits.wall_mm + SPARE_MM, CLEARANCE_HOLES[size]
    small, big = pin_sizes(limits)
    socket, radius = 0.5 * big + limits.clearance_mm, 0.5 * hole
    reach = pin_length(big, sheets, limits, extent.corner)
    most = max(radius, socket)
    x1 = extent.half_width + beside + gap + radius
    x2 = x1 + radius + gap + most
    x3 = x2 + most + gap + socket
    deep = extent.corner + reach + limits.clearance_mm + gap + most
    bar_bolt = max(extent.half_depth + sheets, tips) + gap + radius
    bar_pin = bar_bolt + radius + gap + socket
    reach_x, side_x = x3 + socket + gap, x2 + most + gap
    reach_z = max(deep + most + gap, bar_pin + socket + gap if bar else 0.0)
    side_x = reach_x if wide else side_x
    return Columns(
        size=size,
        gap=gap,
        hole=hole,
        small=small,
        big=big,
        clearance=limits.clearance_mm,
        reach=reach,
        x1=x1,
        x2=x2,
        x3=x3,
        deep=deep,
        bar_bolt=bar_bolt,
        bar_pin=bar_pin,
        wall_x=side_x - extent.half_width,
        ear=reach_x - side_x,
        wall_z=reach_z - extent.half_depth,
    )


def tip_of(diameter: float, length: float, draft_deg: float) -> float:
    """Diameter of a tapered pin's tip, mm."""
    return diameter - 2.0 * length * math.tan(math.radians(draft_deg))


def most_draft(diameter: float, length: float, least: float) -> float:
    """The draft at which a tapered pin's tip, or a rib's edge, is still ``least`` wide, degrees."""
    return math.degrees(math.atan(max(diameter - least, 0.0) / (2.0 * length)))
