"""Legs: widths, exits of bodies whose shape is known, gaps to other metal, volume in the rubber."""

from dataclasses import replace

import numpy as np
import pytest
from fingerdesign_bench.any_finger.step_samples import sample_step

from fingerdesign.design.schema import Design
from fingerdesign.design.step import resolved
from fingerdesign.layout.frames import Hole, PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mold.plan.extent import exits_of, flat_sided
from fingerdesign.mold.plan.fixture.fixture import Fixture
from fingerdesign.mold.plan.fixture.legs import fixture_of, meets_hole
from fingerdesign.mold.plan.fixture.refusals import leg_refusals
from fingerdesign.mold.plan.limits import limits_of
from fingerdesign.mold.plan.pieces import Leg, core_in_mold
from fingerdesign.mold.plan.slots import frames_in_mold, scale_of, turned_bar
from tests.support.molds import made, shipped


def legs(design):
    return fixture_of(design).legs


def test_legs_are_as_wide_as_their_plates_and_half_of_it_where_they_stay_in_the_rubber():
    found = legs(shipped("maeno2000"))
    assert len(found) == 30
    for leg in found:
        assert leg.flat
        assert leg.start == leg.exit == 5.0
        assert leg.width == pytest.approx(0.9)
        assert leg.tip == pytest.approx(5.0 + 0.3 + 3.0)  # a tab beyond the comb
    found = legs(shipped("domed"))
    assert {(leg.width, leg.start, leg.exit, leg.flat) for leg in found} == {(1.0, 4.0, 7.0, True)}
    for name in ("maeno2000", "domed"):  # a given width means the same for both
        assert {leg.width for leg in legs(shipped(name, mold__leg_mm=0.4))} == {0.4}
    assert {1.0 < leg.width <= 2.0 for leg in legs(shipped("domed", mold__leg_mm=5.0))} == {True}


def test_legs_that_are_narrower_than_their_traces_are_refused():
    """Six traces of 0.05 mm, three a face with gaps as wide: 0.25 mm."""
    assert leg_refusals(fixture_of(shipped("film_tees", mold__leg_mm=0.25))) == []
    (refusal,) = leg_refusals(fixture_of(shipped("film_tees", mold__leg_mm=0.24)))
    assert (refusal.key, refusal.value) == ("mold.leg_mm", 0.24)
    assert "6 traces of a plate, 0.25 mm next to each other" in str(refusal.fault)
    wires = shipped("film_tees", mold__leg_mm=0.24, mold__leads="wires")
    assert leg_refusals(fixture_of(wires)) == []


@pytest.mark.parametrize(
    ("plates", "sides", "starts"),
    [
        ({"count": 0}, set(), []),
        ({"model": "none", "count": 1}, {"+z", "-z"}, [5.0, 5.0]),
        ({"along": "z", "count": 3, "span_mm": 6.0, "pitch_mm": 2.5}, {"+x", "-x"}, [3.0] * 6),
        (
            {"placement": [[-2.0, 8.0, 30.0], [2.0, 6.0, -40.0, 1.0]], "span_mm": 5.0},
            {"+z", "-z"},
            [2.5, 2.5, 3.5, 1.5],
        ),
    ],
)
def test_legs_leave_where_the_plates_end(plates, sides, starts):
    found = legs(made({"shape": "block"}, plates))
    assert {leg.side for leg in found} == sides
    assert [leg.start for leg in found] == pytest.approx(starts)
    assert {leg.exit for leg in found} <= {10.0 if "+x" in sides else 5.0}


def test_exits_of_a_pin_are_those_of_its_sphere_and_below_its_rim_of_its_cylinder():
    design = shipped("pin")
    frame = frames_in_mold(design, 1.0)[3]
    crest = 10.0 + 12.0 - np.sqrt(12.0**2 - 8.0**2)
    for leg in (leg for leg in legs(design) if leg.plate == 3):
        x, y = turned_bar(frame, leg.width, leg.offset).corners().T
        out = np.sqrt(12.0**2 - (y - (crest - 12.0)) ** 2 - x**2)
        assert not leg.flat
        assert leg.exit == pytest.approx(out.max(), abs=1e-3)
    bar = PlateFrame(0, 3.0, 4.0, 90.0, 1.0, 1e-9, -2.0, 2.0)
    found = exits_of(design.body, 1.0, [bar], ["+z"], [2.0])
    for exits in (found.nearest, found.farthest):
        assert exits[0] == pytest.approx(np.sqrt(64.0 - 9.0), abs=1e-6)


def test_margins_of_an_arc_are_the_distances_to_its_border():
    body = made({"width_mm": 20.0, "base_height_mm": 10.0, "arc_radius_mm": 20.0}).body
    crest = 10.0 + 20.0 - np.sqrt(300.0)
    small = PlateFrame(0, 0.0, crest - 1.5, 0.0, 1e-6, 1e-6, -2.0, 2.0)
    low = replace(small, y=0.3)
    near = replace(small, place=9.5, y=6.0)
    found = exits_of(body, 1.0, [small, low, near], ["+z", "-z", "+z"], [2.0] * 3)
    assert found.face_margin == pytest.approx([1.5, 0.3, 0.5], abs=1e-5)
    assert body.kind.lowest(body) == 10.0
    assert flat_sided(body)


def test_shrinkage_moves_middles_and_exits_but_keeps_sizes():
    design = made({"shape": "block"}, {"span_mm": 6.0}, {"shrinkage": 0.02})
    scale = scale_of(design)
    assert scale == pytest.approx(1.0 / 0.98)
    before, after = plate_frames(design)[0], frames_in_mold(design, scale)[0]
    assert after.place == pytest.approx(scale * before.place)
    assert (after.span, after.length) == (pytest.approx(6.0), before.length)
    assert {round(leg.exit, 9) for leg in legs(design)} == {round(5.0 * scale, 9)}
    # A full plate of a shrinking rubber has tabs still.
    for leg in legs(made({"shape": "block"}, {"count": 3}, {"cure": "condensation"})):
        assert leg.width == pytest.approx(2.0)
        assert leg.exit - leg.start == pytest.approx(5.0 / 0.98 - 5.0)
    # A core moves with the rubber unless it rests on the base.
    core = made({"core": {"height_mm": 2.0, "bottom_mm": 3.0}}).body.core
    for bottom, moved in ((3.0, 4.0 * 1.02 - 1.0), (0.0, 0.0)):
        found = core_in_mold(core.model_copy(update={"bottom_mm": bottom}), 1.02)
        assert found.bottom_mm == pytest.approx(moved)


def test_the_bar_of_a_bent_strip_holds_it_just():
    frame = PlateFrame(0, 1.0, 8.0, 20.0, 4.0, 0.2, -3.0, 3.0, bend_radius=5.0)
    bar = turned_bar(frame, 2.0, 0.7)
    s = np.linspace(0.7 - 1.0, 0.7 + 1.0, 101)
    points = np.vstack([frame.from_local(s, v) for v in (-0.1, 0.1)])
    inside = bar.local(points)
    assert np.abs(inside[:, 0]).max() == pytest.approx(0.5 * bar.length, abs=1e-9)
    assert inside[:, 1].max() == pytest.approx(0.5 * bar.thickness, abs=1e-6)
    assert inside[:, 1].min() == pytest.approx(-0.5 * bar.thickness, abs=1e-9)


def test_gaps_of_legs_to_other_plates_and_the_core():
    design = made(
        {"shape": "block", "core": {"width_mm": 4.0, "height_mm": 3.0, "bottom_mm": 1.83}},
        {"count": 1, "thickness_mm": 0.2},
    )
    own = PlateFrame(0, 0.0, 5.0, 0.0, 2.0, 0.2, -2.0, 2.0)
    beyond = PlateFrame(1, 0.0, 5.24, 0.0, 2.0, 0.2, 3.0, 4.0)
    leg = Leg(0, "+z", 0.4, 0.0, 2.0, 5.0, 8.0, True)
    for frames, gap in (((own, beyond), 0.04), ((own,), 0.07)):
        fixture = Fixture(design, limits_of(design.mold), frames, (leg,))
        assert fixture.gaps()[0] == pytest.approx(gap)


@pytest.mark.parametrize(("y", "count"), [(5.1, 1), (6.0, 0)])
def test_legs_of_crossing_rows_that_meet_are_found(y, count):
    one = PlateFrame(0, 0.0, 5.0, 0.0, 2.0, 0.2, -2.0, 2.0)
    two = PlateFrame(1, 3.0, y, 0.0, 2.0, 0.2, -4.0, -2.0, along="z")
    first = Leg(0, "+z", 0.4, 0.0, 2.0, 5.0, 8.0, True)
    second = replace(first, plate=1, side="+x", start=-2.0)
    design = made(plates={"thickness_mm": 0.2})
    fixture = Fixture(design, limits_of(design.mold), (one, two), (first, second))
    assert len(fixture.crossings()) == count


def test_a_leg_does_not_stand_on_a_hole():
    frame = PlateFrame(0, 0.0, 5.0, 0.0, 2.0, 0.1, -2.0, 2.0, holes=(Hole(0.0, 1.6, 0.35),))
    leg = Leg(0, "+z", 0.4, 0.0, 2.0, 5.0, 8.0, True)
    assert meets_hole(frame, leg)
    assert not meets_hole(frame, replace(leg, offset=0.7))
    assert not meets_hole(frame, replace(leg, side="-z"))


def step_body(kind, *sizes):
    data = {"shape": "step", "step": {"file": str(sample_step(kind, *sizes))}}
    found, _ = resolved({"design": {"name": "t"}, "body": data, "plates": {"count": 0}})
    return Design.model_validate(found).body


@pytest.mark.parametrize("scale", [1.0, 1.0 / 0.98])
def test_exits_of_a_tapering_step_body_are_those_of_its_leaning_faces(scale):
    body = step_body("tip", 12.0, 14.0, 8.0, 1.0)
    bar = PlateFrame(0, 0.0, scale * 4.0, 90.0, scale * 1.0, 0.1, -2.0, 2.0)
    out = exits_of(body, scale, [bar], ["-z"], [2.0])
    lean = 0.2 * 7.0 / 8.0  # the half-depth falls from 7 to 5.6 over the height
    assert out.nearest[0] == pytest.approx(scale * (7.0 - lean * 4.5), abs=2e-3)
    assert out.farthest[0] == pytest.approx(scale * (7.0 - lean * 3.5), abs=2e-3)
    assert out.face_margin[0] == -np.inf
    assert not flat_sided(body)


def test_exits_of_a_step_body_s_flat_end_are_reported_with_their_margins():
    body = step_body("filleted", 8.0, 14.0, 10.0, 1.5)
    low = PlateFrame(0, 1.0, 8.0, 0.0, 1e-6, 1e-6, -2.0, 2.0)
    out = exits_of(body, 1.0, [low, replace(low, y=9.0)], ["+z", "+z"], [2.0, 2.0])
    assert flat_sided(body)
    assert out.face_margin[0] == pytest.approx(0.5, abs=1e-5)
    # The rounding's radius is 1.5, its axis 1.5 below the top and behind the end.
    assert out.nearest == pytest.approx([7.0, 5.5 + np.sqrt(1.5**2 - 0.5**2)], abs=1e-3)
