"""Sizes that a process can make: the numbers that a plan starts from."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

from fingerdesign.design.mold import Mold
from fingerdesign.mold.plan.refusals import Refusal

# A planned wall is this much thicker than the least wall: round holes are measured as triangles.
SPARE_MM = 0.05
SLENDER = 1.5  # a pin's length, in diameters
# The place of an edge that wire erosion cuts is held to 0.01 mm in two or three passes and to
# 0.005 mm in four to six, as shops report; lasers that cut solder stencils hold the former.
_CUT_MM, _FINE_CUT_MM = 0.01, 0.005
# Profiles are what makers of desktop machines and job shops commonly advise (assumed, without one
# source: cut a test piece). Order: wall, feature, hole, slot, clearance, pin, tolerance, form.
# A slot goes through a wall of a centimetre: if it is narrower than half a millimetre (two strands
# of a filament print), resin, strands or chips stay in it. Wire erosion makes finer ones.
PROFILES: Mapping[str, Sequence[float]] = MappingProxyType(
    {
        "sla": (1.0, 0.4, 0.8, 0.5, 0.1, 2.0, 0.1, 0.05),  # desktop resin printers
        "fdm": (1.6, 0.8, 1.5, 0.8, 0.2, 3.0, 0.2, 0.1),  # 0.4 mm nozzle
        "machined": (1.5, 0.5, 0.8, 0.5, 0.02, 3.0, 0.03, 0.01),  # milled aluminium
    }
)


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


def limits_of(mold: Mold) -> Limits:
    """Return the process's profile, with what ``[mold.limits]`` gives instead.

    >>> from fingerdesign.design.mold import Mold
    >>> limits_of(Mold(process="fdm", limits={"slot_mm": 0.5})).slot_mm
    0.5
    """
    given = mold.limits.model_dump(exclude_none=True)
    return replace(Limits(mold.process, *PROFILES[mold.process]), **given)


def comb_tolerance(mold: Mold) -> float:
    """Tolerance of the place of a comb's edge, mm: the given one, or what the process suggests."""
    if mold.comb.tolerance_mm is not None:
        return mold.comb.tolerance_mm
    return _FINE_CUT_MM if mold.process == "machined" else _CUT_MM


def limit_refusals(mold: Mold, limits: Limits, reach: float, pour: str) -> list[Refusal]:
    """Refuse limits that contradict each other, plates of the mold below the process's wall, and
    holes that are given below its hole; pins reach as far as ``reach`` into their sockets."""
    found = _contradictions(mold, limits, reach)
    walls, holes = ("insert_mm", "base_mm"), ("lock_mm", "gate_mm", "vent_mm")
    for key in (*walls, *(holes if pour == "closed" else holes[:1])):
        size, usual = getattr(mold, key), Mold.model_fields[key].default
        least = limits.wall_mm if key in walls else limits.hole_mm
        if size is not None and size < least and (key in walls or size != usual):
            kind = "thin_wall" if key in walls else "narrow_hole"
            found.append(Refusal(kind, f"mold.{key}", size, {"limits": limits}))
    return found


def _contradictions(mold: Mold, limits: Limits, reach: float) -> list[Refusal]:
    """Refuse limits that contradict each other: of two the one that is given."""
    given, thick = mold.limits.model_dump(exclude_none=True), _least_pin(mold, limits, reach)
    of, found = "mold.limits.", list[Refusal]()
    if limits.feature_mm > limits.wall_mm:
        if "feature_mm" in given or "wall_mm" not in given:
            blamed = Refusal("thick_web", f"{of}feature_mm", limits.feature_mm, {"limits": limits})
        else:
            blamed = Refusal("thin_wall_limit", f"{of}wall_mm", limits.wall_mm, {"limits": limits})
        found.append(blamed)
    if limits.pin_mm < thick and "pin_mm" in given:
        numbers = {"limits": limits, "thick": thick, "draft": mold.draft_deg}
        found.append(Refusal("thin_pins", f"{of}pin_mm", limits.pin_mm, numbers))
    if limits.clearance_mm > 0.25 * limits.pin_mm and "pin_mm" not in given:
        most = {"most": 0.25 * limits.pin_mm}
        found.append(Refusal("wide_sockets", f"{of}clearance_mm", limits.clearance_mm, most))
    return found


def _least_pin(mold: Mold, limits: Limits, reach: float) -> float:
    """Least diameter of the small pins, mm: four clearances, and a tip that can be made.

    Pins get shorter as they get thinner: ``reach`` moves with the big pins' diameter.
    """
    least = 4.0 * limits.clearance_mm
    if limits.dowels:
        return max(least, limits.feature_mm)
    lean = 2.0 * math.tan(math.radians(mold.draft_deg))
    slope = 1.0 - SLENDER * lean
    if slope <= 0.0:  # no diameter helps: the draft itself is refused
        return least
    rest = max(reach - SLENDER * limits.pin_mm, 0.0)
    return max(least, (limits.feature_mm + lean * rest) / slope)
