"""Plans of molds: what shipped designs get, what is refused and how."""

import pytest

from fingerdesign.checks.load import with_values
from fingerdesign.checks.starter import find_design
from fingerdesign.errors import DesignError
from fingerdesign.mold.plan.planning import mold_faults, plan_mold


def changed(name="narrow", **values):
    keys = {key.replace("__", "."): value for key, value in values.items()}
    return with_values(find_design(name), {f"mold.{key}": value for key, value in keys.items()})


def keys(design):
    return [fault.key for fault in mold_faults(design)]


@pytest.mark.parametrize("name", ["narrow", "homogeneous", "boned", "domed"])
def test_a_shipped_design_has_a_mold(name):
    plan = plan_mold(find_design(name))
    assert {hole.kind for hole in plan.base_holes} >= {"gate", "riser", "vent", "lock"}
    assert {bolt.axis for bolt in plan.bolts} == {"y", "z"}
    assert plan.top == pytest.approx(plan.crest + 6.0)


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"wall_mm": 5.0}, "mold.wall_mm"),
        ({"draft_deg": 30.0}, "mold.draft_deg"),
        ({"insert_mm": 0.6}, "mold.insert_mm"),
        ({"base_mm": 0.6}, "mold.base_mm"),
        ({"gate_mm": 0.5}, "mold.gate_mm"),
        ({"vent_mm": 0.5}, "mold.vent_mm"),
        ({"lock_mm": 0.5}, "mold.lock_mm"),
        ({"bolt": "M4", "limits__wall_mm": 2.0}, "mold.bolt"),
        ({"limits__wall_mm": 8.0}, "mold.limits.wall_mm"),
        ({"limits__feature_mm": 1.5}, "mold.limits.feature_mm"),
        ({"limits__clearance_mm": 0.6}, "mold.limits.clearance_mm"),
    ],
)
def test_what_cannot_be_made_is_refused_with_key_bound_and_remedy(values, key):
    design = with_values(changed(**values), {"plates.count": 3})
    found = {fault.key: fault for fault in mold_faults(design)}
    assert key in found
    assert found[key].remedy
    assert "->" not in str(found[key])
    assert any(character.isdigit() for character in found[key].bound)


TINY = {
    "body.width_mm": 8.0,
    "body.depth_mm": 4.0,
    "body.base_height_mm": 4.0,
    "body.edge_radius_mm": 0.5,
    "plates.count": 1,
    "plates.cover_mm": 1.5,
    "plates.angle_deg": 0.0,
}


@pytest.mark.parametrize(
    ("name", "values", "key"),
    [
        ("block", TINY, "mold.bolt"),
        ("block", {"plates.count": 1, "mold.limits.pin_mm": 20.0}, "mold.limits.wall_mm"),
        ("block", {**TINY, "mold.limits.hole_mm": 1.6}, "mold.gate_mm"),
    ],
)
def test_a_remedy_of_room_has_numbers_and_works(name, values, key):
    design = with_values(find_design(name), values)
    fault = next(fault for fault in mold_faults(design) if fault.key == key)
    start = "one of these mends it: "
    assert fault.remedy.startswith(start)
    assert "at most 0:" not in fault.bound
    for change in fault.remedy.removeprefix(start).split("; "):
        items = (item.split(" = ") for item in change.split(", "))
        changes = {k: v.strip("'") if "'" in v else float(v) for k, v in items}
        assert key not in keys(with_values(design, changes))


@pytest.mark.parametrize(("pin", "fault"), [(0.2, ["mold.limits.pin_mm"]), (0.54, [])])
def test_a_pin_thinner_than_sockets_and_tips_need_is_refused(pin, fault):
    assert keys(with_values(find_design("block"), {"mold.limits.pin_mm": pin})) == fault


@pytest.mark.parametrize(
    ("limit", "value"), [("feature_mm", 1.5), ("wall_mm", 0.3), ("feature_mm", 5.0)]
)
def test_the_limit_that_was_given_is_the_one_refused(limit, value):
    design = with_values(find_design("block"), {f"mold.limits.{limit}": value})
    assert set(keys(design)) == {f"mold.limits.{limit}"}


def test_every_fault_is_reported_at_once():
    with pytest.raises(DesignError) as caught:
        plan_mold(changed(wall_mm=5.0, draft_deg=30.0, gate_mm=0.5))
    assert {f.key for f in caught.value.faults} == {
        "mold.wall_mm",
        "mold.draft_deg",
        "mold.gate_mm",
    }


def test_a_wall_as_thick_as_the_bound_says_is_taken():
    (fault,) = mold_faults(changed(wall_mm=5.0))
    least = float(fault.bound.split()[2].rstrip(":"))
    assert plan_mold(changed(wall_mm=least)).wall_z == least
    assert keys(changed(wall_mm=least - 0.01)) == ["mold.wall_mm"]


def test_a_draft_as_great_as_the_bound_says_is_taken():
    (fault,) = mold_faults(changed(draft_deg=30.0))
    most = float(fault.bound.split()[2].rstrip(":"))
    assert min(pin.tip_diameter for pin in plan_mold(changed(draft_deg=most)).pins) >= 0.4
    assert keys(changed(draft_deg=most + 0.05)) == ["mold.draft_deg"]


def test_shrinkage_enlarges_the_outline_not_the_plates():
    plain, tin = plan_mold(changed()), plan_mold(changed(cure="condensation"))
    assert tin.half_width == pytest.approx(plain.half_width / 0.98)
    assert tin.rim == pytest.approx(plain.rim / 0.98)
    assert [f.length for f in tin.frames] == [f.length for f in plain.frames]
