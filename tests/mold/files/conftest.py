"""A planned mold whose parts are boxes: files and notes owe nothing to CAD."""

import pytest

from fingerdesign.design.schema import Design
from fingerdesign.mold.part import MoldMeshes
from fingerdesign.mold.plan.planning import plan_mold
from tests.support.molds import box


def block_design(**mold):
    """A block of 20 x 12 x 10 with three level plates."""
    body = {"shape": "block", "width_mm": 20.0, "base_height_mm": 12.0, "depth_mm": 10.0}
    return Design.model_validate(
        {
            "design": {"name": "block_by_hand"},
            "body": {**body, "material": "dragon_skin_20"},
            "plates": {"count": 3, "angle_deg": 0.0, "pitch_mm": 5.0, "cover_mm": 2.0},
            "mold": {"pour": "closed", **mold},
        }
    )


def block_meshes(plan):
    """Its parts as boxes; combs have no slots."""
    (_, low, back), (side, top, front) = plan.block
    x = plan.reach_x
    parts = [box("contact_insert", (-x, 12, back), (x, top, front), (0.0, 1.0, 0.0), 0)]
    parts += [
        box("end_wall_front", (-x, low, 5.3), (x, 12, front), (0.0, 0.0, 1.0), 1),
        box("end_wall_back", (-x, low, back), (x, 12, -5.3), (0.0, 0.0, -1.0), 1),
    ]
    for way, planned in zip((1.0, -1.0), plan.sides[:2], strict=True):
        if planned.comb:
            (low, high), draw = sorted((5.0 * way, 5.3 * way)), (0.0, 0.0, way)
            parts.append(box(planned.comb, (-10, 0, low), (10, 12, high), draw, 2, "sheet"))
    parts += [
        box("side_wall_right", (10, 0, -5), (side, 12, 5), (1.0, 0.0, 0.0), 3),
        box("side_wall_left", (-side, 0, -5), (-10, 12, 5), (-1.0, 0.0, 0.0), 3),
        box("base_plate", (-11, -4, -6), (11, 0, 6)),
        box("base_frame", (-x, -6, back), (x, -4, front), (0.0, -1.0, 0.0), 0),
    ]
    plates = [
        box(
            f"plate_{f.index}",
            (f.x - 1, f.y - 0.05, -8.3),
            (f.x + 1, f.y + 0.05, 8.3),
            made="metal",
        )
        for f in plan.frames
    ]
    rubber = box("rubber", (-10, 0, -5), (10, 12, 5), made="silicone")
    coupon = (box("coupon", (0, 0, 0), (32, 36, 10)), box("coupon_cell", (0, 0, 0), (9, 9, 9)))
    return MoldMeshes(tuple(parts), tuple(plates), rubber, rubber, *plan.block, coupon)


@pytest.fixture(scope="session")
def hand_made():
    """``hand_made(plate_fixture="comb", **mold)``: design, plan and meshes of the block."""
    known = {}

    def make(plate_fixture="comb", **mold):
        key = (plate_fixture, *mold.items())
        if key not in known:
            design = block_design(plate_fixture=plate_fixture, **mold)
            plan = plan_mold(design)
            known[key] = design, plan, block_meshes(plan)
        return known[key]

    return make
