"""MoldPlan -> Built: exact solids of a closed mold in mold space, mm.

The outline is the body's own solid, scaled: its surfaces keep their kinds. Importing this module
loads the CAD kernel.
"""

from dataclasses import dataclass

import cadquery as cq
import numpy as np
from numpy.typing import NDArray
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepGProp import BRepGProp_Face
from OCP.BRepTools import BRepTools
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Trsf, gp_Vec
from OCP.TopAbs import TopAbs_IN

from fingerdesign.arrays import Array
from fingerdesign.cad.bodies import outline_solid
from fingerdesign.cad.kernel import box, one_solid
from fingerdesign.errors import GeometryError
from fingerdesign.mold.cad.features import BEYOND_MM, Features, cut_plates, features_of
from fingerdesign.mold.cad.parting import FlatSide, parted, seam, sides_followed
from fingerdesign.mold.part import (
    BASE,
    BASE_FRAME,
    CORE,
    INSERT,
    RUBBER,
    Made,
    MoldParts,
    Point,
    point,
)
from fingerdesign.mold.plan.pieces import ENDS, FLANKS, SIDES, Side, direction
from fingerdesign.mold.plan.plan import MoldPlan

# Parts come off in this order; base and core stay with the finger.
INSERT_ORDER, END_ORDER, SIDE_ORDER, STAYS = 0, 1, 3, 9
OUTLINE = "outline"
AGAINST = -1e-6  # normal . draw below which a face looks against the draw
SAMPLES = 15  # along each of a face's parameters
_ORDER: tuple[Side, ...] = (*FLANKS, *ENDS)  # the corners are the end walls'
_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Undercut:
    """A face (its number in the body, from 1) that looks against the draw of the part that forms
    it, that is, which lies against it; the place where it does most."""

    face: int
    part: str
    place: Point


def undercuts(outline: cq.Solid, plan: MoldPlan) -> tuple[Undercut, ...]:
    """All faces of an outline in mold space that a planned part could not be drawn off from."""
    flat = sides_followed(outline, plan)
    found = []
    for number, face in enumerate(outline.Faces(), start=1):
        points, normals = samples(face)
        names, draws = formed_by(points, normals, plan, flat)
        along = np.einsum("ij,ij->i", normals, draws)
        for name in sorted({str(name) for name in names}):
            rows = np.flatnonzero((names == name) & (along < AGAINST))
            if len(rows):
                worst = rows[np.argmin(along[rows])]
                found.append(Undercut(number, name, point(points[worst])))
    return tuple(found)


def refuse_undercuts(outline: cq.Solid, plan: MoldPlan) -> None:
    """GeometryError that names every undercut face, its place and the part that it would hold."""
    of = "body.step" if plan.design.body.step is not None else "the body"
    faces = [
        f"face {each.face} of {of} at ({', '.join(f'{value:.2f}' for value in each.place)}) mm "
        f"holds {each.part}"
        for each in undercuts(outline, plan)
    ]
    if faces:
        raise GeometryError(
            f"the mold cannot be opened: {'; '.join(faces)}. Give the body no faces that look back "
            f"toward its base or its middle, or cast it in another way"
        )


def formed_by(
    points: Array, normals: Array, plan: MoldPlan, flat: dict[Side, FlatSide] | None
) -> tuple[NDArray[np.str_], Array]:
    """The part (n,) that forms the outline at points (n, 3) with outward normals (n, 3), and its
    draw (n, 3); "" and no draw on the base. flat: the sides that the parting follows, or None."""
    names = np.full(len(points), INSERT, dtype="<U40")
    draws = np.tile(_UP, (len(points), 1))
    lower = points[:, 1] < plan.rim
    if flat is not None:
        lower = np.any([face.holds(points, normals) for face in flat.values()], axis=0)
    beyond = {"x": np.zeros(len(points), bool), "z": np.zeros(len(points), bool)}
    for plug in plan.plugs:
        place = np.abs(points[:, 0 if plug.axis == "x" else 2])
        edge = np.array([seam(plan, plug, float(y)) for y in points[:, 1]])
        beyond[plug.axis] = place > edge
    for side in _ORDER if plan.pour == "closed" else ENDS:
        away = direction(side)
        outside = points @ away
        if plan.pour == "open":
            mine = lower & (outside > 0.0)
        elif flat is not None:
            mine = flat[side].holds(points, normals)
        elif side.endswith("z"):
            mine = lower & (outside > plan.corner)
        else:
            mine = lower & (np.abs(points[:, 2]) <= plan.corner) & (outside > 0.0)
        upper = beyond[side[1]] & (outside > 0.0) & ~lower
        names[mine | upper], draws[mine | upper] = plan.by_side[side].wall, away
    base = (points[:, 1] < 1e-5) & (normals[:, 1] < -1.0 + 1e-9)
    names[base], draws[base] = "", 0.0
    return names, draws


def samples(face: cq.Face) -> tuple[Array, Array]:
    """Points (n, 3) within a face and its outward unit normals there (n, 3)."""
    surface, within = BRepGProp_Face(face.wrapped), BRepTopAdaptor_FClass2d(face.wrapped, 1e-7)
    u_low, u_high, v_low, v_high = BRepTools.UVBounds_s(face.wrapped)
    shares = (np.arange(SAMPLES) + 0.5) / SAMPLES
    points, normals = [], []
    for u in (u_low + shares * (u_high - u_low)).tolist():
        for v in (v_low + shares * (v_high - v_low)).tolist():
            where, normal = gp_Pnt(), gp_Vec()
            surface.Normal(u, v, where, normal)
            # Not at a pole.
            if within.Perform(gp_Pnt2d(u, v)) == TopAbs_IN and normal.Magnitude() > 1e-12:
                points.append(where.Coord())
                normals.append(normal.Normalized().Coord())
    return np.array(points).reshape(-1, 3), np.array(normals).reshape(-1, 3)


@dataclass(frozen=True)
class BuiltPart:
    """A part's solid with its name, draw, order and making as of ``PartMesh``; ``blank``: what of
    it fills the block before its features; None: the same solid."""

    name: str
    solid: cq.Solid
    draw: Point | None
    order: int
    made: Made
    blank: cq.Solid | None = None


Built = MoldParts[BuiltPart]


def build_mold(plan: MoldPlan) -> Built:
    """Build every part of a mold.

    GeometryError where a part could not be drawn off (undercut faces are named), where a part would
    come out in pieces, or where the kernel fails.
    """
    try:
        outline = enlarged(outline_solid(plan.design.body), plan.scale)
        refuse_undercuts(outline, plan)
        parts = _parts(plan, parted(outline, plan), features_of(plan))
        plates = cut_plates(plan)
        rubber = _rubber(plan, outline, plates)
    except GeometryError:
        raise
    except Exception as error:  # the kernel throws its own kinds
        raise GeometryError(
            f"the CAD kernel failed to build the mold of {plan.design.design.name}: {error}"
        ) from error
    return Built(
        parts,
        tuple(
            BuiltPart(f"plate_{frame.index}", plate, None, STAYS, "metal")
            for frame, plate in zip(plan.frames, plates, strict=True)
        ),
        BuiltPart(RUBBER, rubber, None, STAYS, "silicone"),
        BuiltPart(OUTLINE, outline, None, STAYS, "silicone"),
        *plan.block,
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
    plan: MoldPlan, blanks: dict[str, tuple[cq.Solid, cq.Solid]], features: Features
) -> tuple[BuiltPart, ...]:
    """Every part that is made, its features worked into its blank."""
    formed: list[tuple[str, Point | None, int, Made]]
    formed = [(INSERT, (0.0, 1.0, 0.0), INSERT_ORDER, "process")]
    for side in SIDES if plan.pour == "closed" else ENDS:
        planned, draw = plan.by_side[side], point(direction(side))
        order = SIDE_ORDER if side.endswith("x") else END_ORDER
        formed.append((planned.wall, draw, order, "process"))
        if planned.comb:  # it comes off after the wall behind it
            formed.append((planned.comb, draw, order + 1, "sheet"))
        if planned.outer_comb:
            formed.append((planned.outer_comb, draw, INSERT_ORDER, "sheet"))
    base = box((-plan.mount_x, -plan.base, -plan.mount_z), (plan.mount_x, 0.0, plan.mount_z))
    blanks = {**blanks, BASE: (base, base)}
    formed.append((BASE, None, STAYS, "process"))
    if plan.lip > 0.0:
        blanks[BASE_FRAME] = (base_frame(plan),) * 2
        formed.append((BASE_FRAME, (0.0, -1.0, 0.0), INSERT_ORDER, "process"))
    if plan.core is not None:
        blanks[CORE] = (box(*(corner.tolist() for corner in plan.core)),) * 2
        formed.append((CORE, None, STAYS, "metal"))
    found = []
    for name, way, order, made in formed:
        blank, filling = blanks[name]
        found.append(BuiltPart(name, _worked(blank, features, name), way, order, made, filling))
    return tuple(found)


def base_frame(plan: MoldPlan) -> cq.Solid:
    """Make the part that presses a closed mold's base plate to the walls: a plate with a recess for
    it, a little less deep than it is thick, and open behind the finger, where it is poured."""
    limits, back = plan.limits, -plan.base - plan.lip
    x, z = plan.mount_x + limits.clearance_mm, plan.mount_z + limits.clearance_mm
    whole = box(
        (-plan.reach_x, back, -plan.reach_z), (plan.reach_x, -limits.tolerance_mm, plan.reach_z)
    )
    recess = box((-x, -plan.base, -z), (x, BEYOND_MM, z))
    x, z = plan.half_width, plan.half_depth
    return one_solid(whole.cut(recess, box((-x, back - BEYOND_MM, -z), (x, 0.0, z))), BASE_FRAME)


def _worked(blank: cq.Solid, features: Features, name: str) -> cq.Solid:
    """A blank with its features: what is added first, then all that is cut, each in one go."""
    solid, added = blank, features.added[name]
    if added:
        solid = one_solid(solid.fuse(*added).clean(), name)
    bounds = solid.BoundingBox().wrapped
    cut = [tool for tool in features.cut[name] if not bounds.IsOut(tool.BoundingBox().wrapped)]
    return one_solid(solid.cut(*cut).clean(), name) if cut else solid


def _rubber(plan: MoldPlan, outline: cq.Solid, plates: tuple[cq.Solid, ...]) -> cq.Solid:
    """The outline without plates and core, which is drawn out of the faces that it reaches."""
    tools, corners = list(plates), plan.core
    if corners is not None:
        low, high = corners
        low[1] -= BEYOND_MM if low[1] == 0.0 else 0.0
        if high[2] > plan.half_depth - 1e-6:
            low[2], high[2] = low[2] - BEYOND_MM, high[2] + BEYOND_MM
        tools.append(box(low.tolist(), high.tolist()))
    return one_solid(outline.cut(*tools), RUBBER) if tools else outline
