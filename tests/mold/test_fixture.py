"""Fixtures: slots and their webs, windows, plugs; and what is refused, with its key and bound."""

from dataclasses import replace

import numpy as np
import pytest
from fingerdesign_bench.any_finger.designs import random_design

from fingerdesign.design.schema import Design
from fingerdesign.design.step import resolved
from fingerdesign.layout.bodies import surface_height
from fingerdesign.mold.plan.fixture.legs import fixture_of
from fingerdesign.mold.plan.fixture.refusals import leg_refusals
from fingerdesign.mold.plan.pieces import Slot, in_space, slot_corners
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.plan.refusals import MoldRefused
from fingerdesign.mold.plan.remedies import remedied
from fingerdesign.mold.plan.sides import blocked, sides_of
from fingerdesign.mold.plan.slots import frames_in_mold, webs
from tests.support.as_planned import plan_checks
from tests.support.molds import keys, made, shipped

SHIPPED = ("block", "boned", "both_ways", "domed", "homogeneous", "maeno2000", "narrow", "pin")


def with_mold(design, **keys):
    table = design.mold.model_validate({**design.mold.model_dump(exclude_none=True), **keys})
    return design.model_copy(update={"mold": table})


def planned(design):
    fixture = fixture_of(design)
    outline, refusals = sides_of(fixture, leg_refusals(fixture))
    faults = list(remedied(design, MoldRefused(refusals, "")).faults)
    return outline.by_side, outline.plugs, faults


def test_a_comb_has_slots_of_the_sheet_and_a_window_around_them():
    sides, plugs, _ = planned(shipped("maeno2000"))
    front = sides["+z"]
    assert (front.holding, front.sheet, plugs) == ("comb", 0.3, ())
    assert len(front.slots) == 15
    assert sides["+x"].holding == "wall"
    assert sides["+x"].window is None
    slot = front.slots[7]
    assert slot.width == pytest.approx(0.12)
    assert slot.length == pytest.approx(0.9 + 0.02)
    low, high, bottom = front.window
    corners = slot_corners(front.slots)
    assert low < corners[..., 0].min()
    assert high > corners[..., 0].max()
    assert 0.0 < bottom < corners[..., 1].min()


def test_a_comb_s_clearance_reaches_no_mold_without_a_comb():
    wide = {"comb": {"clearance_mm": 1.0}}
    assert planned(with_mold(shipped("pin"), plate_fixture="slots", **wide))[2] == []
    (fault,) = planned(with_mold(few(), **wide))[2]
    assert (fault.key, fault.value) == ("mold.comb.clearance_mm", 1.0)


@pytest.mark.parametrize(
    ("name", "mold", "width"),
    [
        ("maeno2000", {"comb": {"slot_mm": 0.2}}, 0.2),  # the least slot of the comb
        ("wide", {"plate_fixture": "slots"}, 0.5),
    ],
)
def test_slots_are_as_wide_as_what_holds_needs(name, mold, width):
    sides, _, faults = planned(with_mold(shipped(name), **mold))
    assert faults == []
    for slot in sides["-z"].slots:
        assert slot.width == pytest.approx(width)


def test_a_leg_in_its_place_stands_against_its_wall_s_slot():
    """Its face and its end toward the contact surface are those of the slot."""
    fixture = fixture_of(with_mold(shipped("wide"), plate_fixture="slots"))
    for leg, slot in zip(fixture.on("+z"), fixture.slots("+z"), strict=True):
        bar, angle = fixture.bar(leg), np.radians(slot.angle_deg)
        along = np.array([np.cos(angle), np.sin(angle)])
        off = np.array([bar.place - slot.place, bar.y - slot.y])
        assert bar.thickness < slot.width
        assert off @ along == pytest.approx(0.5 * (slot.length - bar.length))
        across = off @ [-along[1], along[0]]
        assert across == pytest.approx(0.5 * (slot.width - bar.thickness))


def test_a_bent_plate_s_slot_is_wider_by_its_sagitta():
    design = shipped("boned")
    sides, _, _ = planned(design)
    radius = frames_in_mold(design, 1.0)[2].bend_radius
    half = 0.5 * next(leg.width for leg in fixture_of(design).legs if leg.plate == 2) / radius
    sagitta = (radius - 0.075) * (1.0 - np.cos(half))
    assert sides["+z"].slots[2].width == pytest.approx(0.15 + sagitta + 0.02, abs=1e-6)


def test_a_round_body_gets_slots_and_a_plug_whatever_was_requested():
    design = shipped("pin")
    sides, plugs, _ = planned(design)
    assert sides["+z"].holding == sides["-z"].holding == "slots"
    assert [plug.axis for plug in plugs] == ["z"]
    crest = 10.0 + 12.0 - np.sqrt(12.0**2 - 8.0**2)
    height = crest + 6.0 - design.body.kind.lowest(design.body)
    lean = height * np.tan(np.radians(2.0))
    assert plugs[0].at_top - plugs[0].at_surface == pytest.approx(lean)


def test_a_draft_that_eats_the_contact_surface_is_refused_with_its_bound():
    def faults(draft):
        return planned(with_mold(shipped("pin"), draft_deg=draft))[2]

    (fault,) = faults(30.0)
    assert fault.key == "mold.draft_deg"
    most = float(fault.bound.split("at most ")[1].split(",")[0])
    assert 2.0 < most < 30.0
    assert faults(most) == []
    assert faults(most + 0.3) != []


def few(count=3, **keys):
    """A row of short plates below an arc."""
    plates = {"count": count, "pitch_mm": 0.75, "length_mm": 1.0, "cover_mm": 0.75, **keys}
    return made({"width_mm": 22.0, "base_height_mm": 7.0, "arc_radius_mm": 50.0}, plates)


ROUND = {"shape": "revolved", "width_mm": 16.0, "arc_radius_mm": 12.0}
HIGH = {"count": 1, "span_mm": 3.0, "cover_mm": 0.6, "angle_deg": 0.0, "length_mm": 1.0}
SLOTS = {"plate_fixture": "slots"}
FDM_SLOTS = SLOTS | {"process": "fdm"}


@pytest.mark.parametrize(
    ("design", "mold", "key", "bound"),
    [
        (few(cover_mm=2.0, pitch_mm=0.5), SLOTS, "pitch_mm", "mold.limits.feature_mm = 0.4 mm"),
        (few(1, cover_mm=0.6), FDM_SLOTS, "cover_mm", "0.8 mm below the contact surface"),
        (made(ROUND, HIGH), {}, "cover_mm", "the contact zone"),
    ],
)
def test_what_cannot_be_held_is_refused_with_the_value_that_can(design, mold, key, bound):
    design = with_mold(design, **mold)
    (fault,) = planned(design)[2]
    assert fault.key == f"plates.{key}"
    assert bound in fault.bound
    assert key != "pitch_mm" or "mold.plate_fixture = 'comb'" in fault.remedy
    value = float(fault.remedy.split("at least ")[1].split(",")[0].split(" ")[0])
    assert fault.value < value < fault.value + 3.0
    plates = design.plates.model_copy(update={key: value})
    assert planned(design.model_copy(update={"plates": plates}))[2] == []


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"comb": {"slot_mm": 1.0}}, "comb.slot_mm"),
        ({"comb": {"web_mm": 1.0}}, "comb.web_mm"),
        (
            {"plate_fixture": "slots", "limits": {"slot_mm": 2.0, "feature_mm": 0.1}},
            "limits.slot_mm",
        ),
    ],
)
def test_slots_and_webs_that_the_file_demands_are_refused_by_their_own_key(given, key):
    fault = planned(with_mold(few(), **given))[2][0]
    assert fault.key == f"mold.{key}"
    most = float(fault.bound.split("at most ")[1].split(",")[0])
    assert 0.0 < most < float(fault.value)


def test_legs_wider_than_a_plate_or_through_a_wall_drawn_across_them_are_refused():
    assert "mold.leg_mm" in keys(planned(with_mold(few(span_mm=6.0), leg_mm=5.0))[2])
    fixture = fixture_of(shipped("pin", plates__cover_mm=6.0))
    assert blocked(fixture, replace(fixture.room.extent, corner=2.0)) == []
    (refusal,) = blocked(fixture, replace(fixture.room.extent, corner=7.9))
    assert refusal.key == "plates.pitch_mm"
    assert refusal.numbers["other"] == "side"


def slot(place, y, angle=0.0, length=2.0, width=0.4):
    return Slot(0, "+z", place, y, angle, length, width)


# Before the corner of a level slot at the origin: that one's edges do not part the two.
LEANING = slot(1.0 + 0.5 * np.sqrt(0.5), 0.2 + 0.5 * np.sqrt(0.5), 135)


@pytest.mark.parametrize(
    ("slots", "expected"),
    [
        ([slot(0, 0)], np.inf),
        ([slot(0, 0), slot(0, 1)], 0.6),
        ([slot(0, 0), slot(3, 1)], np.hypot(1.0, 0.6)),
        ([slot(0, 0), slot(1.0, 0.1)], 0.0),
        ([slot(0, 0, 45), slot(1, 0, 45)], np.sqrt(0.5) - 0.4),
        ([slot(0, 0), slot(0, 2, 90)], 0.8),
        ([slot(0, 0), slot(0, 0, 90)], 0.0),
        ([slot(0, 5), slot(0, 0), slot(40, 0), slot(0, 1)], 0.6),
        ([slot(0, 0), LEANING], 0.3),
        ([LEANING, slot(0, 0)], 0.3),
    ],
)
def test_webs_are_true_distances_between_rectangles(slots, expected):
    assert webs(slots)[2].min(initial=np.inf) == pytest.approx(expected)


@pytest.mark.parametrize("name", [*SHIPPED, "fine_tees", "sensitive", "tees", "wide"])
@pytest.mark.parametrize("pour", ["auto", "closed"])
def test_plans_of_shipped_designs_can_be_cut(name, pour):
    """No slot or web is less than what makes it holds, outer combs' neither."""
    design = shipped(name, mold__pour=pour)
    checks = plan_checks(plan_mold(design))
    assert [check.sentence for check in checks if not check.ok] == []
    assert bool(checks) is (name != "homogeneous")


def test_a_slot_without_clearance_lets_its_plate_in_all_the_same():
    for how in (
        {"comb": {"clearance_mm": 0.0}},
        SLOTS | {"limits": {"clearance_mm": 0.0, "slot_mm": 0.3}},
    ):
        fixture = fixture_of(with_mold(few(), **how))
        assert leg_refusals(fixture) == []
        for leg, slot in zip(fixture.on("-z"), fixture.slots("-z"), strict=True):
            assert min(slot.length - leg.width, slot.width - 0.1) >= 0.005 - 1e-9


def test_no_wall_ends_in_a_feather_edge_below_a_slot_near_the_crest():
    """A level plate's slot leaves a dome at 25 degrees."""
    design = Design.model_validate(resolved(random_design(77))[0])
    plan = plan_mold(design)
    slots = [slot for side in plan.sides for slot in side.slots]
    assert any(slot.mouth for slot in slots)
    for slot in slots:
        ends = slot.lower
        if slot.mouth is None:
            continue
        out, low = slot.mouth

        def left(out, slot=slot, ends=ends):
            """Thickness of the wall below both ends of the slot's lowest side."""
            x, _, z = np.transpose([in_space(slot.side, place, 0.0, out) for place, _ in ends])
            return ends[:, 1] - plan.scale * surface_height(design.body, x, z)

        assert left(out).min() >= 0.4 - 0.01  # a feature of 'sla'
        assert left(0.97 * out).min() < 0.4
        assert (ends[:, 1] - left(out)).min() == pytest.approx(low, abs=1e-2)  # all of it is cut
    assert {
        slot.mouth for side in plan_mold(shipped("maeno2000")).sides for slot in side.slots
    } == {None}
