"""How much silicone to mix for one finger."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.mold.part import MoldMeshes
from fingerdesign.mold.plan import BaseHole, MoldPlan
from fingerdesign.mold.profiles import density_of

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


@dataclass(frozen=True)
class Silicone:
    """Volumes in mm^3: the finger's rubber as cast, what stands in locks, in gate, risers and
    vents, and the flash around plates in their slots; ``excess`` is the share mixed beyond."""

    rubber: float
    locks: float
    openings: float
    flash: float
    excess: float
    density_g_cm3: float

    @property
    def mixed_cm3(self) -> float:
        """Volume to mix, cm^3."""
        filled = self.rubber + self.locks + self.openings + self.flash
        return 1e-3 * filled * (1.0 + self.excess)

    @property
    def mass_g(self) -> float:
        """Mass to mix, both components together, g."""
        return self.mixed_cm3 * self.density_g_cm3

    @property
    def sentence(self) -> str:
        """The amount in words."""
        return (
            f"mix {self.mixed_cm3:.2f} cm³ ({self.mass_g:.1f} g at {self.density_g_cm3:g} "
            f"g/cm³): {1e-3 * self.rubber:.2f} cm³ of finger, "
            f"{1e-3 * (self.locks + self.openings + self.flash):.2f} cm³ in locks, gate, risers, "
            f"vents and flash, and {100.0 * self.excess:.0f} % to spare"
        )


def silicone_of(design: Design, plan: MoldPlan, meshes: MoldMeshes) -> Silicone:
    """What rubber, base holes and slots hold; plates without rubber between leave no flash."""
    filled = dict.fromkeys(("gate", "riser", "vent", "lock"), 0.0)
    for hole in plan.base_holes:
        if hole.kind in filled:
            filled[hole.kind] += _cone(hole, plan.base)
    locks = filled.pop("lock")
    return Silicone(
        meshes.rubber.volume,
        locks,
        sum(filled.values()),
        _flash(plan),
        design.mold.excess,
        density_of(design),
    )


def _cone(hole: BaseHole, base: float) -> float:
    d, outer = hole.diameter, hole.outer_diameter
    return float(np.pi * base * (d**2 + d * outer + outer**2) / 12.0)


def _flash(plan: MoldPlan) -> float:
    """Slots less the legs in them, as deep as what holds them: sheets, or the whole wall."""
    thick = {frame.index: frame.thickness for frame in plan.frames}
    legs = {(leg.plate, leg.side): leg for leg in plan.legs}
    whole = 0.0
    for side in plan.sides:
        wall = plan.wall_z if side.side.endswith("z") else plan.wall_x
        deep = {"comb": side.sheet, "jig": 2.0 * side.sheet}.get(side.holding, wall)
        for slot in side.slots:
            leg = legs[slot.plate, side.side]
            metal = leg.width * (thick[slot.plate] + slot.shim)
            hole = 0.25 * np.pi * (slot.relief**2 - slot.wire**2) if slot.relief else 0.0
            whole += (max(0.0, slot.length * slot.width - metal) + hole) * deep
    return float(whole)
