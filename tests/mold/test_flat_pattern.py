"""Flat patterns: kinds of plates, areas against the plates', gage places, volume of legs."""

import numpy as np
import pytest

from fingerdesign import load_design
from fingerdesign.mold.plan.fixture_faults import fixture_faults, with_walls
from fingerdesign.mold.plan.legs import fixture_of, legs_share, legs_volume
from fingerdesign.mold.plan.plan import SIDES, MoldPlan
from fingerdesign.mold.products.drawing import polygon_area
from fingerdesign.mold.products.flat_pattern import flat_patterns


def plan_of(design):
    fixture = fixture_of(design)
    assert with_walls(fixture, fixture_faults(fixture)) == []
    plates = (fixture.frames, fixture.legs, tuple(fixture.side(side) for side in SIDES))
    half = (0.5 * design.body.width_mm, 0.5 * design.body.depth_mm)
    sizes = (*half, half[1], 10.0, 12.0, 18.0, 10.0, 10.0, 8.0, 4.0)
    return MoldPlan(fixture.scale, *plates, fixture.plugs, *sizes, (), (), (), (), ())


def test_like_plates_are_cut_alike():
    design = load_design("designs/maeno2000.toml")
    (only,) = flat_patterns(design, plan_of(design))
    assert only.name == "plate_A"
    assert only.count == 15
    assert only.plates == tuple(range(15))
    assert only.bend_radius is None
    assert only.seen == "lower"
    length = only.outline.max(axis=0) - only.outline.min(axis=0)
    assert length == pytest.approx([0.9, 10.0 + 2 * 3.3])
    assert polygon_area(only.outline) == pytest.approx(0.9 * 10.0 + 2 * 0.54 * 3.3)


def test_bent_perforated_plates_keep_their_holes_and_their_bend():
    design = load_design("designs/boned.toml")
    plan = plan_of(design)
    found = flat_patterns(design, plan)
    assert sorted(plate for each in found for plate in each.plates) == [0, 1, 2, 3, 4]
    for pattern in found:
        frame = plan.frames[pattern.plates[0]]
        assert pattern.bend_radius == frame.bend_radius
        assert pattern.material == "spring_steel"
        assert [w for _, w, _ in pattern.holes] == pytest.approx([-1.0, 1.0])
        legs = [leg for leg in plan.legs if leg.plate == frame.index]
        area = frame.length * 6.0 + sum(leg.width * (leg.tip - leg.start) for leg in legs)
        assert polygon_area(pattern.outline) == pytest.approx(area)
        x, y = pattern.outline.T
        assert 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)) > 0.0


def test_plates_along_z_are_another_kind_seen_from_above():
    design = load_design("designs/both_ways.toml")
    found = flat_patterns(design, plan_of(design))
    assert {pattern.seen for pattern in found} == {"lower", "upper"}
    assert len({pattern.name for pattern in found}) == len(found)


def test_gages_are_marked_on_the_faces_that_carry_them():
    design = load_design("designs/maeno2000.toml")
    gages = design.gages.model_copy(update={"z_mm": 0.5, "face": "upper"})
    moved = design.model_copy(update={"gages": gages})
    (mark,) = flat_patterns(moved, plan_of(moved))[0].gages
    assert mark.face == "upper"
    assert mark.corners.mean(axis=0) == pytest.approx([0.0, 0.5])
    assert np.ptp(mark.corners, axis=0) == pytest.approx([0.5, 1.0])
    both = flat_patterns(design, plan_of(design))[0].gages
    assert [each.face for each in both] == ["upper", "lower"]


def test_legs_displace_little_rubber():
    full, thin = load_design("designs/maeno2000.toml"), load_design("designs/domed.toml")
    assert legs_volume(plan_of(full)) == 0.0
    assert legs_volume(plan_of(thin)) == pytest.approx(26 * 0.3 * 0.1 * 3.0)
    assert 1e-4 < legs_share(thin, plan_of(thin)) < 1e-2
