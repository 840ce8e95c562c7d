"""Design -> MoldPlan: extent, legs, sides, fasteners, base; each step gives its part or refuses."""

from collections.abc import Iterator
from dataclasses import replace

from fingerdesign.design.schema import Design
from fingerdesign.mold.plan.base import base_holes_of
from fingerdesign.mold.plan.fasteners.columns import fit_of
from fingerdesign.mold.plan.fasteners.core_pins import core_pins_of
from fingerdesign.mold.plan.fasteners.fasteners import fastened, fastener_refusals, with_mount
from fingerdesign.mold.plan.fixture.legs import LEAST_WIDTH_MM, fixture_of
from fingerdesign.mold.plan.fixture.refusals import leg_refusals
from fingerdesign.mold.plan.limits import limit_refusals, limits_of
from fingerdesign.mold.plan.mount import mount_refusals
from fingerdesign.mold.plan.open_pour import open_plan
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.refusals import MoldRefused, Refusal
from fingerdesign.mold.plan.sides import sides_of

# Thinner legs and pins may mend refusals of these keys alone.
_ROOM = {"mold.bolt", "mold.limits.pin_mm", "mold.limits.wall_mm"}
THIN_PINS = 0.75  # of the process's: a printed pin of 1.5 mm breaks sooner, but it bears no load


def plan_mold(design: Design) -> MoldPlan:
    """Plan a sound design's mold; MoldRefused with every reason why there is none.

    The plan is an open mold where ``mold.pour`` and the finger allow it: it has the fewest parts. A
    closed one is cast with the base up, tilted by ``base.TILT_DEG`` toward the first vent, in the
    corner +x +z: this is then the highest place of the rubber. A core that parts the base leaves
    more such places, each with a vent of its own. Legs, then pins, are thin where others leave no
    room for bolts and pins.
    """
    found = _mounted(_try(design))
    refused = set() if isinstance(found, MoldPlan) else {refusal.key for refusal in found}
    for thinner in _thinner(design) if refused and refused <= _ROOM else ():
        thin = _mounted(_try(thinner))
        if isinstance(thin, MoldPlan):
            mold = thinner.mold.model_copy(update={"leg_mm": design.mold.leg_mm})
            return replace(thin, design=design.model_copy(update={"mold": mold}))
    if isinstance(found, MoldPlan):
        return found
    raise MoldRefused(found, design.design.name)


def _mounted(found: MoldPlan | list[Refusal]) -> MoldPlan | list[Refusal]:
    """Return a plan whose mount can be, or its refusals."""
    return (mount_refusals(found) or found) if isinstance(found, MoldPlan) else found


def _thinner(design: Design) -> Iterator[Design]:
    """The design with thin legs, with thin pins, with both, as far as it gives neither."""
    mold = design.mold
    legs: dict[str, object] = {} if mold.leg_mm is not None else {"leg_mm": LEAST_WIDTH_MM}
    thin = mold.limits.model_copy(update={"pin_mm": THIN_PINS * limits_of(mold).pin_mm})
    pins: dict[str, object] = {} if mold.limits.pin_mm is not None else {"limits": thin}
    for changed in filter(None, (legs, pins, legs | pins if legs and pins else {})):
        yield with_mold(design, **changed)


def _try(design: Design) -> MoldPlan | list[Refusal]:
    """Plan an open mold where ``mold.pour`` and the finger allow it, else a closed one."""
    mold, fixture = design.mold, fixture_of(design)
    outline, refusals = sides_of(fixture, leg_refusals(fixture))
    closed_for = "mold.pour asks for it"
    if mold.pour != "closed" and not refusals:
        wrong = limit_refusals(mold, fixture.limits, 0.0, "open")
        opened = open_plan(fixture, outline)
        if isinstance(opened, Refusal):
            return [*wrong, opened]
        if isinstance(opened, MoldPlan) and not wrong:
            return opened
        closed_for = opened if isinstance(opened, str) else ""
        if mold.pour == "open" and not wrong:
            return [Refusal("not_open", "mold.pour", mold.pour, {"why": closed_for})]
    plan, more = _closed_plan(replace(outline, closed_for=closed_for))
    return list({(r.key, r.kind): r for r in (*refusals, *more)}.values()) or plan


def _closed_plan(outline: MoldPlan) -> tuple[MoldPlan, list[Refusal]]:
    """Plan a finger's closed mold from its ``outline`` (legs, sides, plugs): core pins, fasteners,
    base; or refuse what has no room. Fasteners are added where nothing is refused."""
    mold, plan = outline.design.mold, with_mount(outline)
    pins, refused_pins = core_pins_of(plan)
    plan = replace(plan, core_pins=pins)
    fit = fit_of(plan)
    holes, refused_holes = base_holes_of(plan)
    refusals = [
        *limit_refusals(mold, plan.limits, fit.columns.reach, "closed"),
        *refused_pins,
        *refused_holes,
        *fastener_refusals(plan, fit),
    ]
    if refusals:
        return plan, refusals
    if mold.wall_mm is not None:
        fit = replace(fit, columns=replace(fit.columns, wall_z=mold.wall_mm))
    return fastened(replace(plan, base_holes=holes), fit), []


def with_mold(design: Design, **values: object) -> Design:
    """Return the design with other values in its [mold] table."""
    return design.model_copy(update={"mold": design.mold.model_copy(update=values)})
