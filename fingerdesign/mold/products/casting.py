"""A casting: the facts of a built mold that notes, bill, files and record share."""

from dataclasses import dataclass

from fingerdesign.design.schema import Design
from fingerdesign.layout.fitting import GageFit, gage_fit
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.part import MoldMeshes
from fingerdesign.mold.plan.patterns import FlatPattern, flat_patterns
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.products.silicone import SiliconeData, silicone_of
from fingerdesign.mold.profile import cell_plates


@dataclass(frozen=True)
class Casting:
    """A built mold and what is cast in it.

    patterns   of the different plates; silicone: what is mixed
    fit        of a gage type to the plates; None without plates
    trial      the plates of the coupon's cell, which are cut once more
    """

    design: Design
    plan: MoldPlan
    meshes: MoldMeshes
    patterns: tuple[FlatPattern, ...]
    silicone: SiliconeData
    fit: GageFit | None
    trial: tuple[PlateFrame, ...]


def casting_of(design: Design, plan: MoldPlan, meshes: MoldMeshes) -> Casting:
    """Find the facts of a built mold."""
    return Casting(
        design,
        plan,
        meshes,
        flat_patterns(design, plan),
        silicone_of(design, plan, meshes),
        gage_fit(design),
        cell_plates(plan),
    )
