"""A casting: the facts of a built mold that notes, bill, files and record share, and its rubber."""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from typing_extensions import TypedDict

from fingerdesign.design.schema import Design
from fingerdesign.design.stock import GageType
from fingerdesign.layout.fitting import GageFit
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.materials import MATERIALS, gent_shore_a
from fingerdesign.mold.part import MOUNT, SPACER, MoldMeshes
from fingerdesign.mold.plan.patterns import FlatPattern, flat_patterns
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.products.three_mf import Posed, laid_out
from fingerdesign.mold.profile import cell_plates
from fingerdesign.records.base import Size, closed

TEMPLATES = Path(__file__).parents[1] / "templates"
_ELASTOMERS = ("dragon_skin_20", "dragon_skin_30", "sylgard_184")
_LIKE = 1.25  # ratio of moduli: batches of one silicone differ as much
# Densities and mixing ratios by the material's name, then mixing as is usual of a cure.
_RUBBERS = tomllib.loads((TEMPLATES / "rubbers.toml").read_text(encoding="utf-8"))
DENSITIES_G_CM3: Mapping[str, float] = MappingProxyType(_RUBBERS["density_g_cm3"])
_ANY_SILICONE_G_CM3 = 1.1


@dataclass(frozen=True)
class Mixing:
    """Parts A and B by mass; how long it can be poured; how it cures. source: of the numbers;
    known: they are the material's own, not what is usual of its cure."""

    part_a: float
    part_b: float
    pot_life: str
    cure: str
    source: str
    known: bool = True

    def shares(self, mass_g: float) -> tuple[float, float]:
        """Masses of A and B, g, that make ``mass_g``.

        >>> Mixing(10.0, 1.0, "", "", "").shares(11.0)
        (10.0, 1.0)
        """
        whole = self.part_a + self.part_b
        return mass_g * self.part_a / whole, mass_g * self.part_b / whole


@closed
class SiliconeData(TypedDict):
    """Amount that has to be mixed, and what it consists of."""

    finger_cm3: Size
    locks_cm3: Size
    gate_risers_vents_cm3: Size
    flash_cm3: Size
    excess: Size
    mixed_cm3: Size
    density_g_cm3: Size
    mass_g: Size
    sentence: str


def silicone_of(plan: MoldPlan, meshes: MoldMeshes) -> SiliconeData:
    """Sum up what rubber, base holes and slots take; plates without rubber between leave no
    flash."""
    locks, openings = 0.0, 0.0
    for hole in plan.base_holes:
        d, outer = hole.diameter, hole.outer_diameter
        cone = math.pi * plan.base * (d**2 + d * outer + outer**2) / 12.0
        locks += cone if hole.kind == "lock" else 0.0
        openings += cone if hole.kind in ("gate", "riser", "vent") else 0.0
    volumes = 1e-3 * np.array([meshes.rubber.volume, locks, openings, _flash(plan)])
    finger, locks, openings, flash = volumes.tolist()
    where = "locks and flash" if plan.pour == "open" else "locks, gate, risers, vents and flash"
    excess, density = plan.design.mold.excess, density_of(plan.design)
    mixed = sum(volumes.tolist()) * (1.0 + excess)
    return {
        "finger_cm3": finger,
        "locks_cm3": locks,
        "gate_risers_vents_cm3": openings,
        "flash_cm3": flash,
        "excess": excess,
        "mixed_cm3": mixed,
        "density_g_cm3": density,
        "mass_g": mixed * density,
        "sentence": f"mix {mixed:.2f} cm³ ({mixed * density:.1f} g at {density:g} g/cm³): "
        f"{finger:.2f} cm³ of finger, {locks + openings + flash:.2f} cm³ in {where}, "
        f"and {100.0 * excess:.0f} % to spare",
    }


def _flash(plan: MoldPlan) -> float:
    """Slots less the legs in them, as deep as what holds them: sheets, or the whole wall."""
    return sum(
        max(0.0, slot.length * slot.width - width * plan.thickness[slot.plate])
        * (side.sheet or plan.wall(side.side))
        for side, slot, width in plan.leg_slots
    )


def mixing_of(material: str, cure: str) -> Mixing:
    """Find how a material is mixed, or what is usual of its cure: the notes then ask to compare it
    with the data sheet."""
    usual = "polyurethane" if material.startswith("polyurethane") else cure
    own = _RUBBERS["mixing"].get(material)
    return Mixing(**(own or _RUBBERS["usual"][usual]), known=own is not None)


def rubber_words(design: Design) -> str:
    """Describe what to buy for the body: its name, or the hardness that its modulus asks for and a
    silicone of that modulus where one is known."""
    name, modulus = design.body.material, design.material_of("body").youngs_modulus_MPa
    if name in _RUBBERS["mixing"]:
        return name.replace("_", " ")
    ratios = {each: MATERIALS[each].youngs_modulus_MPa / modulus for each in _ELASTOMERS}
    away, like = min((abs(math.log(ratio)), each) for each, ratio in ratios.items())
    such = f" (such as {like})" if away < math.log(_LIKE) else ""
    words = f"{name} of {modulus:g} MPa, Shore A {gent_shore_a(modulus):.0f} or so{such}"
    return words.replace("_", " ")


def density_of(design: Design) -> float:
    """Density of the rubber, g/cm^3: given, typical of its name, or of any silicone."""
    if design.mold.density_g_cm3 is not None:
        return design.mold.density_g_cm3
    return DENSITIES_G_CM3.get(design.body.material, _ANY_SILICONE_G_CM3)


@dataclass(frozen=True)
class Casting:
    """A built mold and what is cast in it.

    patterns   of the different plates; silicone: how much is mixed; mixing: of what
    fit        of a gage type to the plates; None without plates
    trial      the plates of the coupon's cell, which are cut once more
    posed      parts, and pieces of the coupon, as they lie on the printer's bed
    """

    plan: MoldPlan
    meshes: MoldMeshes
    fit: GageFit | None
    patterns: tuple[FlatPattern, ...]
    silicone: SiliconeData
    mixing: Mixing
    trial: tuple[PlateFrame, ...]
    posed: tuple[Posed, ...]
    coupon: tuple[Posed, ...]

    @property
    def design(self) -> Design:
        """The finger that is cast."""
        return self.plan.design

    @property
    def gage(self) -> GageType | None:
        """The type of gage to order; None: there is none for these plates."""
        return None if self.fit is None else self.fit.found


def casting_of(plan: MoldPlan, meshes: MoldMeshes, fit: GageFit | None) -> Casting:
    """Find the facts of a built mold; ``fit``: of a gage type to its plates."""
    more = [piece for piece in meshes.coupon if piece.name in (MOUNT, SPACER)]
    pieces = [piece for piece in meshes.coupon if piece not in more]
    parts, coupon = (
        laid_out(tuple(part for part in some if part.made == "process"))
        for some in ((*meshes.parts, *more), pieces)
    )
    silicone = silicone_of(plan, meshes)
    mixing = mixing_of(plan.design.body.material, plan.design.mold.cure)
    cast = flat_patterns(plan), silicone, mixing, cell_plates(plan)
    return Casting(plan, meshes, fit, *cast, parts, coupon)
