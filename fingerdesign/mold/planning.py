"""Design -> MoldPlan: every number of a mold, or every reason why there is none.

Cast with the base up, tilted by ``base_plan.TILT_DEG`` toward the first vent of ``base_holes``, in
the corner +x +z: ``base_plan.pour_up`` points up. The highest place of the rubber is then that
corner of the base (of a round base: its rim there); a backing core that parts the base leaves more
such places, each with a vent of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fingerdesign.errors import DesignError, Fault
from fingerdesign.mold.base_plan import base_holes_of
from fingerdesign.mold.columns import Columns, columns_of
from fingerdesign.mold.core_pins import core_pins_of
from fingerdesign.mold.extent import Extent, extent_of, seam_height
from fingerdesign.mold.fastener_faults import fastener_faults, limit_faults
from fingerdesign.mold.fasteners import fasteners_of
from fingerdesign.mold.fixture import sides_of
from fingerdesign.mold.frames import frames_in_mold, scale_of
from fingerdesign.mold.legs import legs_of
from fingerdesign.mold.plan import SIDES, BaseHole, CorePin, Leg, MoldPlan, Plug, Side, SidePlan
from fingerdesign.mold.profiles import Limits, limits_of
from fingerdesign.mold.remedies import with_remedies
from fingerdesign.mold.walls import Walls, pin_height, z_bolt_height

if TYPE_CHECKING:
    from fingerdesign.design.layout import PlateFrame
    from fingerdesign.design.schema import Design

AUTO_BOLTS = ("M3", "M2.5", "M2")
CORNERS = (1.0, 0.85, 0.7, 0.5)  # of the outermost |z| at which end and side walls may meet


@dataclass(frozen=True)
class _Draft:
    """A plan before its fasteners."""

    scale: float
    limits: Limits
    extent: Extent
    frames: tuple[PlateFrame, ...]
    legs: tuple[Leg, ...]
    sides: tuple[SidePlan, ...]
    plugs: tuple[Plug, ...]
    core_pins: tuple[CorePin, ...]
    base_holes: tuple[BaseHole, ...]
    walls: Walls
    columns: Columns


def plan_mold(design: Design) -> MoldPlan:
    """The plan of a sound design's mold.

    Up while casting is ``base_plan.pour_up(plan)``: the base up, tilted so that the first vent's
    corner is the highest place of the rubber. Raises DesignError with every fault.
    """
    draft, faults = _drafted(design)
    if faults:
        raise DesignError(_with_remedies(design, faults), design.design.name)
    fasteners = fasteners_of(draft.walls, draft.columns)
    extent, columns = draft.extent, draft.columns
    return MoldPlan(
        scale=draft.scale,
        frames=draft.frames,
        legs=draft.legs,
        sides=draft.sides,
        plugs=draft.plugs,
        half_width=extent.half_width,
        half_depth=extent.half_depth,
        corner=extent.corner,
        rim=extent.rim,
        crest=extent.crest,
        top=draft.walls.top,
        wall_x=columns.wall_x,
        wall_z=columns.wall_z,
        ear=columns.ear,
        base=draft.walls.base,
        bolts=fasteners.bolts,
        pins=fasteners.pins,
        keys=fasteners.keys,
        base_holes=draft.base_holes,
        core_pins=draft.core_pins,
    )


def mold_faults(design: Design) -> list[Fault]:
    """Every fault that keeps a sound design's mold from being made; empty where it can be."""
    return _with_remedies(design, _drafted(design)[1])


def _with_remedies(design: Design, faults: list[Fault]) -> list[Fault]:
    def planned(changed: Design) -> list[Fault]:
        return _drafted(changed)[1]

    return with_remedies(design, limits_of(design.mold), faults, planned)


def _drafted(design: Design) -> tuple[_Draft, list[Fault]]:
    mold = design.mold
    limits, scale = limits_of(mold), scale_of(design)
    extent = extent_of(design, scale)
    frames = frames_in_mold(design, scale)
    legs = legs_of(design, scale, limits)
    extent = _parted(design, extent, frames, legs, limits)
    sides, plugs, unheld = sides_of(design, frames, legs, limits, extent.corner)
    core_pins, no_pins = core_pins_of(design, scale, sides, limits)
    holes, no_room = base_holes_of(design, extent, scale, limits)

    def seam(x: float, z: float) -> float:
        return seam_height(design, extent, scale, x, z)

    tips: dict[Side, float] = {
        side: max((leg.tip for leg in legs if leg.side == side), default=0.0) for side in SIDES
    }
    walls = Walls(
        extent=extent,
        sides=sides,
        plugs=plugs,
        core_pins=core_pins,
        tips=tips,
        seam=seam,
        top=extent.crest + mold.insert_mm,
        base=mold.base_mm,
        draft_deg=mold.draft_deg,
        dowels=limits.dowels,
    )
    columns = _columns(walls, limits, mold.bolt)
    faults = [
        *limit_faults(mold, limits, columns.reach),
        *unheld,
        *no_pins,
        *no_room,
        *fastener_faults(mold, limits, walls, columns),
    ]
    if mold.wall_mm is not None:
        columns = columns.thicker(mold.wall_mm)
    draft = _Draft(
        scale, limits, extent, frames, legs, sides, plugs, core_pins, holes, walls, columns
    )
    return draft, list({str(fault): fault for fault in faults}.values())


def _parted(
    design: Design,
    extent: Extent,
    frames: tuple[PlateFrame, ...],
    legs: tuple[Leg, ...],
    limits: Limits,
) -> Extent:
    """The extent with end and side walls parted where legs leave through the right ones: a round
    or tapering body may be parted at any of several |z|."""
    if extent.continued or not legs:
        return extent
    best, least = extent, -1
    for share in CORNERS:
        trial = replace(extent, corner=share * extent.corner)
        wrong = len(sides_of(design, frames, legs, limits, trial.corner)[2])
        if not wrong:
            return trial
        if least < 0 or wrong < least:
            best, least = trial, wrong
    return best


def _columns(walls: Walls, limits: Limits, bolt: str) -> Columns:
    """Columns for the given bolts, or for the largest of ``AUTO_BOLTS`` that fit along z."""
    thick = {p.side: p.sheet * {"comb": 1, "jig": 2}.get(p.holding, 0) for p in walls.sides}
    sheets, beside = max(thick["+z"], thick["-z"]), max(thick["+x"], thick["-x"])
    ends = [planned for planned in walls.sides if planned.side.endswith("z")]
    open_ends = [planned.side for planned in ends if planned.window is not None]
    tips = max((walls.tips[side] for side in open_ends), default=0.0)
    bar, plugged = walls.plug("x") is not None, walls.plug("z") is not None

    def of(size: str, wide: bool) -> Columns:
        return columns_of(walls.extent, limits, size, sheets, beside, tips, bar, wide)

    sizes = AUTO_BOLTS if bolt == "auto" else (bolt,)
    size = next((s for s in sizes if z_bolt_height(walls, of(s, plugged)) is not None), sizes[-1])
    low = pin_height(walls, of(size, plugged)) is None and not bar
    return of(size, plugged or low)
