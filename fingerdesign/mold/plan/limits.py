"""Sizes that a process can make and densities of the rubbers: the numbers a plan starts from."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from fingerdesign.design.mold import Mold
from fingerdesign.design.schema import Design

# A planned wall is this much thicker than the least wall: round holes are measured as triangles.
SPARE_MM = 0.05
# The place of an edge that wire erosion cuts is held to 0.01 mm in two or three passes and to
# 0.005 mm in four to six, as shops report; lasers that cut solder stencils hold the former.
_CUT_MM, _FINE_CUT_MM = 0.01, 0.005
# Densities are typical of makers' data sheets of the cured rubber; fillers change them by some %.
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


@dataclass(frozen=True)
class Limits:
    """Sizes that a process can make, mm; ``name``: "sla", "fdm" or "machined".

    wall_mm       least wall without support
    feature_mm    least web, rib or tip
    hole_mm       least diameter of a round hole
    slot_mm       least width of a slot
    clearance_mm  all round, between parts that slide into each other
    pin_mm        least diameter of a pin at its root
    tolerance_mm  of a place, to either side
    form_mm       of a face over the finger's width, to either side, where it rests on another
    """

    name: str
    wall_mm: float
    feature_mm: float
    hole_mm: float
    slot_mm: float
    clearance_mm: float
    pin_mm: float
    tolerance_mm: float
    form_mm: float

    @property
    def dowels(self) -> bool:
        """True where pins are straight steel dowels in drilled holes, not part of the part."""
        return self.name == "machined"

    @property
    def seam_mm(self) -> float:
        """Distance by which half frames end short of a base plate that has to lie on their combs:
        frames may come out higher by their tolerance, and the plate may bend by its form."""
        return self.tolerance_mm + self.form_mm


# Profiles are what makers of desktop machines and job shops commonly advise (assumed, without one
# source: cut a test piece). Order: wall, feature, hole, slot, clearance, pin, tolerance, form.
# A slot goes through a wall of a centimetre: if it is narrower than half a millimetre (two strands
# of a filament print), resin, strands or chips stay in it. Wire erosion makes finer ones.
PROFILES: Mapping[str, Limits] = MappingProxyType(
    {
        "sla": Limits("sla", 1.0, 0.4, 0.8, 0.5, 0.1, 2.0, 0.1, 0.05),  # desktop resin printers
        "fdm": Limits("fdm", 1.6, 0.8, 1.5, 0.8, 0.2, 3.0, 0.2, 0.1),  # 0.4 mm nozzle
        # milled aluminium
        "machined": Limits("machined", 1.5, 0.5, 0.8, 0.5, 0.02, 3.0, 0.03, 0.01),
    }
)


def limits_of(mold: Mold) -> Limits:
    """Return the process's profile, with what ``[mold.limits]`` gives instead.

    >>> from fingerdesign.design.mold import Mold
    >>> limits_of(Mold(process="fdm", limits={"slot_mm": 0.5})).slot_mm
    0.5
    """
    given = mold.limits.model_dump(exclude_none=True)
    return replace(PROFILES[mold.process], **given)


def comb_tolerance(mold: Mold) -> float:
    """Tolerance of the place of a comb's edge, mm: the given one, or what the process suggests."""
    if mold.comb.tolerance_mm is not None:
        return mold.comb.tolerance_mm
    return _FINE_CUT_MM if mold.process == "machined" else _CUT_MM


def density_of(design: Design) -> float:
    """Density of the rubber, g/cm^3: given, typical of its name, or of any silicone."""
    if design.mold.density_g_cm3 is not None:
        return design.mold.density_g_cm3
    return DENSITIES_G_CM3.get(design.body.material, _ANY_SILICONE_G_CM3)
