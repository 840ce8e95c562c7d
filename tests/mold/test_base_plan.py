"""The base's holes: vents at the highest places, room between all, what shrinks or is reported."""

from itertools import combinations

import numpy as np
import pytest
from fingerdesign_bench.any_finger.designs import random_design

from fingerdesign.checks.load import with_values
from fingerdesign.checks.starter import find_design
from fingerdesign.design.schema import Design
from fingerdesign.design.step_file import resolved
from fingerdesign.mold.plan.base import base_holes_of, core_box, pour_up
from fingerdesign.mold.plan.extent import extent_of
from fingerdesign.mold.plan.plan import limits_of
from fingerdesign.mold.plan.planning import mold_faults, plan_mold


def drawn(seed):
    return Design.model_validate(resolved(random_design(seed)).data)


def changed(name, values):
    return with_values(find_design(name), values)


def placed(design):
    extent = extent_of(design, 1.0)
    return extent, *base_holes_of(design, extent, 1.0, limits_of(design.mold))


DESIGNS = {
    "block": lambda: find_design("block"),
    "pin": lambda: find_design("pin"),
    "narrow": lambda: find_design("narrow"),
    "round, backed": lambda: drawn(87),
    "parted by a core": lambda: drawn(8),
    "step": lambda: drawn(4),
}


@pytest.mark.parametrize("name", DESIGNS)
def test_holes_are_within_the_base_and_apart(name):
    design = DESIGNS[name]()
    extent, holes, faults = placed(design)
    assert not faults
    limits, box = limits_of(design.mold), core_box(design, 1.0)
    kinds = [hole.kind for hole in holes]
    assert kinds[0] == "vent"
    assert kinds.count("vent") >= 2
    assert {"gate", "riser"} <= set(kinds)
    for one, other in combinations(holes, 2):
        gap = np.hypot(one.x - other.x, one.z - other.z)
        gap -= 0.5 * (one.outer_diameter + other.outer_diameter)
        assert gap >= limits.wall_mm - 1e-9
    for hole in holes:
        radius = 0.5 * hole.outer_diameter
        assert hole.diameter >= limits.hole_mm
        if design.body.shape == "revolved":
            assert np.hypot(hole.x, hole.z) + radius <= extent.half_width
        assert abs(hole.x) + radius <= extent.half_width
        assert abs(hole.z) + radius <= extent.half_depth
        if hole.kind == "lock":
            assert hole.outer_diameter > hole.diameter
        if box is not None and box[0][1] == 0.0:
            out = np.maximum(np.abs([hole.x, hole.z]) - box[1][[0, 2]], 0.0)
            assert (np.hypot(*out) >= radius) != (hole.kind == "screw")


@pytest.mark.parametrize("name", ["block", "narrow", "pin"])
def test_the_first_vent_is_where_the_tilted_base_is_highest(name):
    plan = plan_mold(find_design(name))
    up, first = pour_up(plan), plan.base_holes[0]
    assert up[1] == pytest.approx(-np.cos(np.radians(5.0)))
    grid = np.linspace(-1.0, 1.0, 41)
    x, z = (plan.half_width * grid[:, None], plan.half_depth * grid[None, :])
    if name == "pin":
        x, z = np.where(np.hypot(x, z) <= plan.half_width, 1.0, 0.0) * np.broadcast_arrays(x, z)
    highest = float((up[0] * x + up[2] * z).max())
    assert highest - (up[0] * first.x + up[2] * first.z) <= np.sin(np.radians(5.0)) * 1.2


def test_each_part_of_a_parted_base_has_a_vent_at_its_highest_place():
    design = drawn(8)
    assert design.body.core.depth_mm is None
    _, holes, _ = placed(design)
    up = np.array([1.0, 1.0])
    half, deep = 0.5 * design.body.core.width_mm, 0.5 * design.body.depth_mm
    vents = np.array([[hole.x, hole.z] for hole in holes if hole.kind == "vent"])
    left = vents[vents[:, 0] < -half]
    assert (np.array([-half, deep]) - left).min(axis=0) == pytest.approx([0.6, 0.6], abs=0.25)
    assert float((left @ up).max()) == pytest.approx(-half + deep - 1.2, abs=0.5)


def test_gate_and_riser_share_a_small_base():
    gate, riser = (
        next(hole for hole in plan_mold(find_design("narrow")).base_holes if hole.kind == kind)
        for kind in ("gate", "riser")
    )
    assert 0.5 * gate.diameter <= riser.diameter <= gate.diameter < 4.0


def test_a_base_without_room_is_refused_by_key():
    design = changed(
        "homogeneous",
        {"body.core": {"width_mm": 17.5, "depth_mm": 7.5, "height_mm": 3.0}, "mold.process": "fdm"},
    )
    assert "mold.gate_mm" in [fault.key for fault in mold_faults(design)]


def test_a_backing_is_screwed_and_a_bone_is_pinned():
    backed = changed("boned", {"body.core.bottom_mm": 0.0})
    plan = plan_mold(backed)
    screws = [hole for hole in plan.base_holes if hole.kind == "screw"]
    assert len(screws) == 2
    assert not plan.core_pins
    boned = plan_mold(find_design("boned"))
    assert len({pin.side for pin in boned.core_pins}) == 2
    for pin in boned.core_pins:
        assert 1.0 < pin.y < 5.0
        assert pin.tip + pin.depth == pytest.approx(4.5)


def test_a_core_too_thin_for_pins_is_refused():
    faults = mold_faults(changed("boned", {"body.core.height_mm": 1.2}))
    assert [fault.key for fault in faults] == ["body.core.height_mm"]
    least = float(faults[0].bound.split()[2])
    assert not mold_faults(changed("boned", {"body.core.height_mm": least}))
