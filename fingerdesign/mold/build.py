"""MoldPlan -> Built: every part of a mold as an exact solid, closed, in mold space.

The outline is the body's own solid, scaled: its surfaces keep their kinds. Importing this module
loads the CAD kernel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.gp import gp_Pnt, gp_Trsf

from fingerdesign.errors import GeometryError
from fingerdesign.geometry.bodies import outline_solid
from fingerdesign.geometry.kernel import box, one_solid
from fingerdesign.mold.features import Features, features_of
from fingerdesign.mold.part import BASE, CORE, INSERT, RUBBER, Made, comb_names, wall_name
from fingerdesign.mold.parting import Blank, Parting, parted
from fingerdesign.mold.plan import SIDES, MoldPlan
from fingerdesign.mold.plate_blanks import core_block, core_room, cut_plates
from fingerdesign.mold.undercuts import refuse_undercuts

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

Direction = tuple[float, float, float]

# Parts come off in this order; base and core stay with the finger.
INSERT_ORDER, END_ORDER, SIDE_ORDER, STAYS = 0, 1, 3, 9
OUTLINE = "outline"


@dataclass(frozen=True)
class BuiltPart:
    """A part's solid with its name, draw, order and making as of ``PartMesh``; ``blank``: what of
    it fills the block before its features; None: the same solid."""

    name: str
    solid: cq.Solid
    draw: Direction | None
    order: int
    made: Made
    blank: cq.Solid | None = None


@dataclass(frozen=True)
class Built:
    """All solids of a mold, as of ``MoldMeshes``."""

    parts: tuple[BuiltPart, ...]
    plates: tuple[BuiltPart, ...]
    rubber: BuiltPart
    outline: BuiltPart
    low: Direction
    high: Direction


def build_mold(design: Design, plan: MoldPlan) -> Built:
    """Build every part of a mold.

    GeometryError where a part could not be drawn off (undercut faces are named), where a part would
    come out in pieces, or where the kernel fails.
    """
    try:
        outline = enlarged(outline_solid(design.body), plan.scale)
        refuse_undercuts(design, outline, plan)
        parting = parted(outline, plan)
        parts = _parts(design, plan, parting, features_of(design, plan))
        plates = cut_plates(plan)
        rubber = _rubber(design, plan, outline, plates)
    except GeometryError:
        raise
    except Exception as error:  # the kernel throws its own kinds
        raise GeometryError(
            f"the CAD kernel failed to build the mold of {design.design.name}: {error}"
        ) from error
    return Built(
        parts,
        tuple(
            BuiltPart(f"plate_{frame.index}", plate, None, STAYS, "metal")
            for frame, plate in zip(plan.frames, plates, strict=True)
        ),
        BuiltPart(RUBBER, rubber, None, STAYS, "silicone"),
        BuiltPart(OUTLINE, outline, None, STAYS, "silicone"),
        parting.low,
        parting.high,
    )


def enlarged(outline: cq.Solid, scale: float) -> cq.Solid:
    """A solid scaled about the origin; surfaces keep their kinds."""
    if scale == 1.0:
        return outline
    larger = gp_Trsf()
    larger.SetScale(gp_Pnt(0.0, 0.0, 0.0), scale)
    made = BRepBuilderAPI_Transform(outline.wrapped, larger, True).Shape()
    return one_solid(cq.Shape.cast(made), "the enlarged outline")


def _parts(
    design: Design, plan: MoldPlan, parting: Parting, features: Features
) -> tuple[BuiltPart, ...]:
    found = [_formed(parting, features, INSERT, (0.0, 1.0, 0.0), INSERT_ORDER, "process")]
    for side in SIDES:
        sign = 1.0 if side[0] == "+" else -1.0
        draw = (sign, 0.0, 0.0) if side.endswith("x") else (0.0, 0.0, sign)
        order = SIDE_ORDER if side.endswith("x") else END_ORDER
        found.append(_formed(parting, features, wall_name(side), draw, order, "process"))
        holding = plan.side(side).holding
        made: Made = "sheet" if holding == "comb" else "process"
        # Sheets come off after the wall behind them, those of a jig together.
        found.extend(
            _formed(parting, features, name, draw, order + 1, made)
            for name in comb_names(side, holding)
        )
    base = box((-plan.reach_x, -plan.base, -plan.reach_z), (plan.reach_x, 0.0, plan.reach_z))
    found.append(BuiltPart(BASE, _worked(base, features, BASE), None, STAYS, "process", base))
    if design.body.core is not None:
        core = core_block(design.body, plan.scale)
        found.append(BuiltPart(CORE, _worked(core, features, CORE), None, STAYS, "metal", core))
    return tuple(found)


def _formed(
    parting: Parting, features: Features, name: str, draw: Direction, order: int, made: Made
) -> BuiltPart:
    blank: Blank = parting.blanks[name]
    return BuiltPart(name, _worked(blank.part, features, name), draw, order, made, blank.filling)


def _worked(blank: cq.Solid, features: Features, name: str) -> cq.Solid:
    """A blank with its features: what is added first, then all that is cut, each in one go."""
    solid = blank
    added = features.added.get(name, [])
    if added:
        solid = one_solid(solid.fuse(*added).clean(), name)
    bounds = solid.BoundingBox()
    cut = [tool for tool in features.cut.get(name, []) if _meet(bounds, tool.BoundingBox())]
    return one_solid(solid.cut(*cut).clean(), name) if cut else solid


def _meet(one: cq.BoundBox, other: cq.BoundBox) -> bool:
    """Whether two boxes overlap."""
    return bool(
        one.xmin < other.xmax
        and other.xmin < one.xmax
        and one.ymin < other.ymax
        and other.ymin < one.ymax
        and one.zmin < other.zmax
        and other.zmin < one.zmax
    )


def _rubber(
    design: Design, plan: MoldPlan, outline: cq.Solid, plates: tuple[cq.Solid, ...]
) -> cq.Solid:
    tools = list(plates)
    if design.body.core is not None:
        tools.append(core_room(design.body, plan.scale, plan.half_depth))
    return one_solid(outline.cut(*tools), RUBBER) if tools else outline
