"""A small mold made by hand: a block finger with one plate, its walls, insert and base plate."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from manifold3d import Manifold, Mesh64

from fingerdesign.design.schema import Design
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mold.part import BASE, INSERT, RUBBER, MoldMeshes, PartMesh
from fingerdesign.mold.plan.pieces import BaseHole, Leg, Pin, SidePlan, Slot
from fingerdesign.mold.plan.plan import MoldPlan


@dataclass(frozen=True)
class Made:
    """A plan and its meshes."""

    plan: MoldPlan
    meshes: MoldMeshes

    box = staticmethod(lambda low, high: box(low, high))

    def changed(self, name, change):
        """The same with one part or the rubber changed; its blank and the outline stay."""

        def apply(part):
            solid = Manifold(Mesh64(part.vertices, part.triangles.astype(np.uint64)))
            new = mesh_of(name, change(solid), part.draw, part.order, part.made)
            return replace(new, blank_volume=part.blank_volume)

        every = (*self.meshes.parts, *self.meshes.plates, self.meshes.rubber)
        return self.with_part(next(apply(part) for part in every if part.name == name))

    def with_part(self, new):
        """The same with another part, plate or rubber of a name."""
        meshes = self.meshes
        if new.name == RUBBER:
            return replace(self, meshes=replace(meshes, rubber=new))
        parts = tuple(new if p.name == new.name else p for p in meshes.parts)
        plates = tuple(new if p.name == new.name else p for p in meshes.plates)
        return replace(self, meshes=replace(meshes, parts=parts, plates=plates))

    def planned(self, **changes):
        """The same by a changed plan."""
        return replace(self, plan=replace(self.plan, **changes))


def box(low, high):
    """A box between two corners."""
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    return Manifold.cube(tuple(high - low)).translate(tuple(low))


def mirrored_z(low, high):
    """A box between two corners, and its mirror image in z = 0."""
    return box(low, high), box((*low[:2], -high[2]), (*high[:2], -low[2]))


def upright(x, z, low, high, bottom, top):
    """A cone along y from diameter ``bottom`` at y = low to ``top`` at y = high."""
    cone = Manifold.cylinder(high - low, 0.5 * bottom, 0.5 * top, 128)
    return cone.rotate((-90.0, 0.0, 0.0)).translate((x, low, z))


def mesh_of(name, solid, draw=None, order=9, made="process", blank=None):
    """A solid as a part; its exact volume is that of its triangles."""
    found, volume = solid.to_mesh64(), solid.volume()
    mesh = np.array(found.vert_properties)[:, :3], np.array(found.tri_verts, dtype=np.int64)
    filling = volume if blank is None else blank.volume()
    return PartMesh(name, *mesh, draw, order, made, volume, 0.0, filling)


DESIGN = {
    "design": {"name": "by_hand"},
    "body": {"shape": "block", "width_mm": 20.0, "base_height_mm": 12.0, "depth_mm": 10.0},
    "plates": {"placement": [[0.0, 8.0, 0.0]], "length_mm": 4.0, "thickness_mm": 0.1},
    "mold": {"plate_fixture": "slots", "limits": {"slot_mm": 0.4}},  # its slots are milled finely
}
PIN = Pin((21.0, 12.0, 9.0), (0.0, -1.0, 0.0), 2.4, 2.0, 3.0, 0.1, INSERT, "end_wall_front", False)
HOLES = (
    BaseHole("gate", 0.0, 0.0, 4.0, 5.0),
    *(BaseHole("vent", x, z, 1.0, 1.0) for x in (-9.0, 9.0) for z in (-4.0, 4.0)),
    BaseHole("lock", 5.0, 0.0, 2.0, 3.0),
)


def plan_of(design):
    """The plan that the parts below are made by."""
    legs = tuple(Leg(0, side, 3.0, 0.0, 5.0, 5.0, 13.0, True) for side in ("+z", "-z"))
    slots = {s: (Slot(0, s, 0.0, 8.0, 0.0, 3.2, 0.4),) for s in ("+z", "-z")}
    sides = tuple(
        SidePlan(side, "slots" if side in slots else "wall", 0.0, None, slots.get(side, ()))
        for side in ("+z", "-z", "+x", "-x")
    )
    sizes = {"half_width": 10.0, "half_depth": 5.0, "corner": 5.0, "rim": 12.0, "crest": 12.0}
    sizes |= {"continued": True, "design": design}
    sizes |= {"top": 18.0, "wall_x": 8.0, "wall_z": 8.0, "ear": 6.0, "base": 4.0, "scale": 1.0}
    held = {"frames": plate_frames(design), "legs": legs, "sides": sides, "plugs": ()}
    holes = {"bolts": (), "pins": (PIN,), "base_holes": HOLES, "core_pins": ()}
    return MoldPlan(**sizes, **held, **holes)


@pytest.fixture(scope="session")
def made():
    """The mold of a block 20 x 12 x 10 with one level plate through its depth."""
    design = Design.model_validate(DESIGN)
    front, back = mirrored_z((-18, 0, 5), (18, 12, 13))
    ears = [box((-24, 0, z), (24, 12, z + 8)) for z in (5, -13)]
    slots = mirrored_z((-1.6, 7.8, 4), (1.6, 8.2, 14))
    plate = box((-2, 7.95, -5), (2, 8.05, 5)) + box((-1.5, 7.95, -13), (1.5, 8.05, 13))
    outline = box((-10, 0, -5), (10, 12, 5))
    socket = upright(21, 9, 8.9, 12, 2.2, 2.6)
    pin = upright(21, 9, 9, 12.5, 2.0, 2.4 + 0.4 / 6)
    base = box((-24, -4, -13), (24, 0, 13))
    for hole in HOLES:
        base -= upright(hole.x, hole.z, -4.001, 0.001, hole.outer_diameter, hole.diameter)
    insert = box((-24, 12, -13), (24, 18, 13)) + pin
    parts = (
        mesh_of(INSERT, insert, (0.0, 1.0, 0.0), 1, blank=box((-18, 12, -13), (18, 18, 13))),
        mesh_of("end_wall_front", ears[0] - slots[0] - socket, (0.0, 0.0, 1.0), 2, blank=front),
        mesh_of("end_wall_back", ears[1] - slots[1], (0.0, 0.0, -1.0), 2, blank=back),
        mesh_of("side_wall_right", box((10, 0, -5), (18, 12, 5)), (1.0, 0.0, 0.0), 3),
        mesh_of("side_wall_left", box((-18, 0, -5), (-10, 12, 5)), (-1.0, 0.0, 0.0), 3),
        mesh_of(BASE, base),
    )
    meshes = MoldMeshes(
        parts,
        (mesh_of("plate_0", plate, made="metal"),),
        mesh_of(RUBBER, outline - plate, made="silicone"),
        mesh_of("outline", outline, made="silicone"),
        (-18.0, 0.0, -13.0),
        (18.0, 18.0, 13.0),
    )
    return Made(plan_of(design), meshes)
