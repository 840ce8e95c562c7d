"""What a process holds, and how heavy silicones are: typical values; measure yours.

The limits are what makers of desktop machines and job shops commonly advise for walls, holes and
fits (no one source; assumed): print or cut a test piece and give yours in ``[mold.limits]``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fingerdesign.design.mold import Mold
    from fingerdesign.design.schema import Design


@dataclass(frozen=True)
class Limits:
    """What a process can make, mm.

    name          "sla", "fdm" or "machined"
    wall_mm       least wall that stands by itself
    feature_mm    least web, rib or tip
    hole_mm       least diameter of a round hole
    slot_mm       least width of a slot
    clearance_mm  all round, between parts that slide into each other
    pin_mm        least diameter of a pin at its root
    tolerance_mm  of a place, to either side
    """

    name: str
    wall_mm: float
    feature_mm: float
    hole_mm: float
    slot_mm: float
    clearance_mm: float
    pin_mm: float
    tolerance_mm: float

    @property
    def dowels(self) -> bool:
        """Whether pins are straight steel dowels in drilled holes, not part of the part."""
        return self.name == "machined"


# wall, feature, hole, slot, clearance, pin, tolerance
PROFILES: Mapping[str, Limits] = MappingProxyType(
    {
        "sla": Limits("sla", 1.0, 0.4, 0.8, 0.3, 0.1, 2.0, 0.1),  # desktop resin printers
        "fdm": Limits("fdm", 1.6, 0.8, 1.5, 0.6, 0.2, 3.0, 0.2),  # 0.4 mm nozzle: two lines a web
        "machined": Limits("machined", 1.5, 0.5, 0.8, 0.4, 0.02, 3.0, 0.03),  # milled aluminium
    }
)

# Typical of makers' data sheets of the cured rubber; fillers move them by some percent.
DENSITIES_G_CM3: Mapping[str, float] = MappingProxyType(
    {
        "silicone": 1.1,
        "dragon_skin_20": 1.08,
        "dragon_skin_30": 1.08,
        "sylgard_184": 1.03,
        "polyurethane_60a": 1.04,
    }
)
_ANY_SILICONE_G_CM3 = 1.1


def limits_of(mold: Mold) -> Limits:
    """The process's profile, with what ``[mold.limits]`` gives instead.

    >>> from fingerdesign.design.mold import Mold
    >>> limits_of(Mold(process="fdm", limits={"slot_mm": 0.5})).slot_mm
    0.5
    """
    given = mold.limits.model_dump(exclude_none=True)
    return replace(PROFILES[mold.process], **given)


def density_of(design: Design) -> float:
    """Density of the rubber, g/cm^3: given, typical of its name, or of any silicone."""
    if design.mold.density_g_cm3 is not None:
        return design.mold.density_g_cm3
    return DENSITIES_G_CM3.get(design.body.material, _ANY_SILICONE_G_CM3)
