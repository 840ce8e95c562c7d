"""The closed mold: four walls, a gate and vents, for a finger that an open one cannot make."""

from dataclasses import replace

from fingerdesign.design.schema import Design
from fingerdesign.mold.plan.base import base_holes_of
from fingerdesign.mold.plan.fasteners.columns import fit_of
from fingerdesign.mold.plan.fasteners.core_pins import core_pins_of
from fingerdesign.mold.plan.fasteners.fasteners import fastened, with_mount
from fingerdesign.mold.plan.fasteners.refusals import fastener_refusals, limit_refusals
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.refusals import Refusal
from fingerdesign.mold.plan.slots import core_box


def closed_plan(design: Design, outline: MoldPlan) -> tuple[MoldPlan, list[Refusal]]:
    """Plan a finger's closed mold from its ``outline`` (legs, sides, plugs): core pins, fasteners,
    base; or refuse what has no room. Fasteners are added where nothing is refused."""
    mold, box = design.mold, core_box(design, outline.scale)
    plan = with_mount(design.body, outline)
    pins, refused_pins = core_pins_of(design, plan, box)
    plan = replace(plan, core_pins=pins)
    fit = fit_of(plan, mold)
    holes, refused_holes = base_holes_of(design, plan, box)
    refusals = [
        *limit_refusals(mold, plan.limits, fit.columns.reach, "closed"),
        *refused_pins,
        *refused_holes,
        *fastener_refusals(mold, plan, fit),
    ]
    if refusals:
        return plan, refusals
    if mold.wall_mm is not None:
        fit = replace(fit, columns=replace(fit.columns, wall_z=mold.wall_mm))
    return fastened(design.body, replace(plan, base_holes=holes), fit), []
