"""A hand-made mold of boxes: the finger is a block, so that files and notes owe nothing to CAD."""

import numpy as np
import pytest

from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import plate_frames
from fingerdesign.mold.part import MoldMeshes, PartMesh
from fingerdesign.mold.plan.plan import BaseHole, Bolt, Leg, MoldPlan, Pin, SidePlan, Slot

CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
BOX = np.array(
    [
        *([0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4]),
        *([1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]),
    ]
)


def block_design(**mold):
    """A block of 20 x 12 x 10 with three level plates."""
    body = {"shape": "block", "width_mm": 20.0, "base_height_mm": 12.0, "depth_mm": 10.0}
    return Design.model_validate(
        {
            "design": {"name": "block_by_hand"},
            "body": {**body, "material": "dragon_skin_20"},
            "plates": {"count": 3, "angle_deg": 0.0, "pitch_mm": 5.0, "cover_mm": 2.0},
            "mold": mold,
        }
    )


def box(name, low, high, draw, order=9, made="process"):
    low, high = np.array(low, float), np.array(high, float)
    points, volume = CORNERS * (high - low) + low, float(np.prod(high - low))
    return PartMesh(name, points, BOX, draw, order, made, volume, 0.0, points, BOX, volume)


def block_plan(design, holding="comb"):
    """Its plan; the plates leave at +z and -z."""
    frames = plate_frames(design)
    legs, sides = [], []
    shim = 0.2 if holding == "slots" else 0.0
    for side in ("+z", "-z"):
        slots = []
        for frame in frames:
            legs.append(Leg(frame.index, side, 1.2, 0.0, 5.0, 5.0, 8.3, True))
            slots.append(Slot(frame.index, side, frame.place, frame.y, 0.0, 1.4, 0.12, 0.2, shim))
        sides.append(SidePlan(side, holding, 0.3, 0.0, (-8.0, 8.0, 8.0), tuple(slots)))
    sides += [SidePlan(side, "wall", 0.0, 0.0, None, ()) for side in ("+x", "-x")]
    bolts = [Bolt("z", x, 6.0, -15.0, 15.0, "M3", 3.4) for x in (-14.0, 14.0)]
    bolts += [Bolt("y", x, z, -4.0, 18.0, "M3", 3.4) for x in (-18.0, 18.0) for z in (-10.0, 10.0)]
    holes = (
        BaseHole("gate", -6.0, 0.0, 4.0, 5.0),
        BaseHole("riser", 6.0, 0.0, 3.0, 3.0),
        BaseHole("vent", 9.0, 4.0, 1.0, 1.0),
        BaseHole("vent", -9.0, -4.0, 1.0, 1.0),
        BaseHole("lock", 0.0, 3.0, 2.0, 3.0),
    )
    pin = Pin(
        *((-14.0, 3.0, 5.0), (0.0, 0.0, 1.0), 2.0, 1.6, 3.0, 0.1),
        *("side_wall_left", "end_wall_front", design.mold.process == "machined"),
    )
    return MoldPlan(
        **{"scale": 1.0 / (1.0 - design.mold.shrinkage_used), "frames": frames},
        **{"legs": tuple(legs), "sides": tuple(sides), "plugs": ()},
        **{"half_width": 10.0, "half_depth": 5.0, "corner": 5.0, "rim": 12.0, "crest": 12.0},
        **{"top": 18.0, "wall_x": 8.0, "wall_z": 10.0, "ear": 2.0, "base": 4.0},
        **{"bolts": tuple(bolts), "pins": (pin,), "keys": (), "base_holes": holes},
        **{"core_pins": ()},
    )


def block_meshes(plan):
    """Its parts as boxes; combs have no slots."""
    parts = (
        box("contact_insert", (-20, 12, -15), (20, 18, 15), (0.0, 1.0, 0.0), 0),
        box("end_wall_front", (-20, 0, 5.3), (20, 12, 15), (0.0, 0.0, 1.0), 1),
        box("end_wall_back", (-20, 0, -15), (20, 12, -5.3), (0.0, 0.0, -1.0), 1),
        box("comb_front", (-10, 0, 5), (10, 12, 5.3), (0.0, 0.0, 1.0), 2, "sheet"),
        box("comb_back", (-10, 0, -5.3), (10, 12, -5), (0.0, 0.0, -1.0), 2, "sheet"),
        box("side_wall_right", (10, 0, -5), (18, 12, 5), (1.0, 0.0, 0.0), 3),
        box("side_wall_left", (-18, 0, -5), (-10, 12, 5), (-1.0, 0.0, 0.0), 3),
        box("base_plate", (-20, -4, -15), (20, 0, 15), None),
    )
    plates = []
    for frame in plan.frames:
        low, high = (frame.x - 1.0, frame.y - 0.05, -8.3), (frame.x + 1.0, frame.y + 0.05, 8.3)
        plates.append(box(f"plate_{frame.index}", low, high, None, 9, "metal"))
    rubber = box("rubber", (-10, 0, -5), (10, 12, 5), None, 9, "silicone")
    low, high = (-18.0, 0.0, -15.0), (18.0, 18.0, 15.0)
    return MoldMeshes(parts, tuple(plates), rubber, rubber, low, high)


@pytest.fixture
def hand_made():
    """``hand_made(holding="comb", **mold)``: design, plan and meshes of the block."""

    def make(holding="comb", **mold):
        design = block_design(**mold)
        plan = block_plan(design, holding)
        return design, plan, block_meshes(plan)

    return make
