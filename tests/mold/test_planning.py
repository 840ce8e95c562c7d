"""Plans of molds: the [mold] table, what shipped designs get, holes of the base, refusals."""

import re
from itertools import combinations

import numpy as np
import pytest

from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.design.mold import Mold
from fingerdesign.mold.checks.venting import beyond_openings, pour_turn, upward
from fingerdesign.mold.plan import remedies
from fingerdesign.mold.plan.base import base_holes_of
from fingerdesign.mold.plan.extent import extent_of
from fingerdesign.mold.plan.limits import PROFILES, limits_of
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.plan.refusals import MoldRefused
from fingerdesign.mold.products.casting import density_of
from tests.support.molds import drawn, keys, made, mold_faults, mold_remedies, shipped


def parsed(line=""):
    return parse_design(f'design.name = "a"\n{line}')


def narrow(**values):
    return shipped("narrow", **{f"mold.{key}": value for key, value in values.items()})


def test_each_process_has_a_profile_of_its_own_numbers_which_given_limits_replace():
    for name, profile in PROFILES.items():
        limits = limits_of(parsed(f'mold.process = "{name}"').mold)
        assert tuple(vars(limits).values()) == (name, *profile)
        assert 0 < limits.feature_mm <= limits.wall_mm
        assert 0 < limits.clearance_mm < limits.slot_mm <= limits.hole_mm < limits.pin_mm
    limits = limits_of(parsed('mold.process = "fdm"\nmold.limits.slot_mm = 0.45').mold)
    assert (limits.slot_mm, limits.hole_mm) == (0.45, limits_of(Mold(process="fdm")).hole_mm)


def test_shrinkage_follows_the_cure_and_density_the_material_unless_given():
    tin = 'mold.cure = "condensation"'
    for line, share in (("", 0.0), (tin, 0.02), (f"{tin}\nmold.shrinkage = 0.005", 0.005)):
        assert parsed(line).mold.shrinkage_used == share
    dragon = 'body.material = "dragon_skin_30"'
    for line, density in (("", 1.1), (dragon, 1.08), ("mold.density_g_cm3 = 1.2", 1.2)):
        assert density_of(parsed(line)) == density


@pytest.mark.parametrize(
    "values",
    [
        {"wall_mm": 5.0},
        {"draft_deg": 30.0},
        {"insert_mm": 0.6},
        {"base_mm": 0.6},
        {"gate_mm": 0.5},
        {"vent_mm": 0.5},
        {"lock_mm": 0.5},
        {"bolt": "M4", "limits.wall_mm": 2.0},
        {"limits.wall_mm": 8.0},
        {"limits.feature_mm": 1.5},
        {"limits.clearance_mm": 0.6},
    ],
)
def test_what_cannot_be_made_is_refused_with_key_bound_and_remedy(values):
    faults = mold_faults(with_values(narrow(**values), {"plates.count": 3}))
    fault = next(fault for fault in faults if fault.key == f"mold.{next(iter(values))}")
    assert fault.remedy
    assert "->" not in str(fault)
    assert any(character.isdigit() for character in fault.bound)


TINY = {
    "body.width_mm": 8.0,
    "body.depth_mm": 4.0,
    "body.base_height_mm": 4.0,
    "body.edge_radius_mm": 0.5,
    "plates.count": 1,
    "plates.cover_mm": 1.5,
    "plates.angle_deg": 0.0,
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "key"),
    [
        (TINY, "mold.bolt"),
        ({"plates.count": 1, "mold.limits.pin_mm": 20.0}, "mold.limits.wall_mm"),
        ({**TINY, "mold.limits.hole_mm": 1.6}, "mold.gate_mm"),
    ],
)
def test_a_remedy_of_room_has_numbers_and_works(values, key):
    design = shipped("block", **values)
    fault = next(fault for fault in mold_remedies(design) if fault.key == key)
    start = "one of these mends it: "
    assert fault.remedy.startswith(start)
    assert "at most 0:" not in fault.bound
    for change in fault.remedy.removeprefix(start).split("; "):
        items = (item.split(" = ") for item in change.split(", "))
        changes = {k: v.strip("'") if "'" in v else float(v) for k, v in items}
        assert key not in keys(mold_faults(with_values(design, changes)))


def test_every_fault_is_reported_at_once():
    faults = mold_faults(narrow(wall_mm=5.0, draft_deg=30.0, gate_mm=0.5))
    assert set(keys(faults)) == {"mold.wall_mm", "mold.draft_deg", "mold.gate_mm"}


@pytest.mark.parametrize(
    ("key", "value", "beyond"), [("wall_mm", 5.0, -0.01), ("draft_deg", 30.0, 0.05)]
)
def test_a_value_at_the_bound_that_is_reported_is_taken(key, value, beyond):
    (fault,) = mold_faults(narrow(**{key: value}))
    bound = float(fault.bound.split()[2].rstrip(":"))
    plan = plan_mold(narrow(**{key: bound}))
    assert min(pin.tip_diameter for pin in plan.pins) >= 0.4
    assert key != "wall_mm" or plan.wall_z == bound
    assert keys(mold_faults(narrow(**{key: bound + beyond}))) == [f"mold.{key}"]


DESIGNS = {"round, backed": 87, "parted by a core": 8, "step": 4}


def bare(design):
    """A plan of nothing but the outline, at the finger's own size."""
    nothing = {
        "design": design,
        "frames": (),
        "legs": (),
        "sides": (),
        "plugs": (),
        "top": 0.0,
        "base": 4.0,
    }
    nothing |= {"mount_x": np.inf, "mount_z": np.inf}
    return MoldPlan(**vars(extent_of(design, 1.0)), scale=1.0, **nothing)


@pytest.mark.parametrize("which", ["block", "pin", "narrow", *DESIGNS])
def test_holes_are_within_the_base_and_apart(which):
    design = drawn(DESIGNS[which]) if which in DESIGNS else shipped(which)
    limits, extent = limits_of(design.mold), bare(design)
    core = extent.core
    holes, faults = base_holes_of(extent)
    assert not faults
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
        if core is not None and core[0][1] == 0.0:
            out = np.maximum(np.abs([hole.x, hole.z]) - core[1][[0, 2]], 0.0)
            assert (np.hypot(*out) >= radius) != (hole.kind == "screw")


@pytest.mark.parametrize("name", ["block", "narrow", "pin"])
def test_the_first_vent_is_where_the_tilted_base_is_highest(name):
    plan = plan_mold(shipped(name))
    up, first = upward(pour_turn(plan)), plan.base_holes[0]
    assert up[1] == pytest.approx(-np.cos(np.radians(5.0)))
    grid = np.linspace(-1.0, 1.0, 41)
    x, z = (plan.half_width * grid[:, None], plan.half_depth * grid[None, :])
    if name == "pin":
        x, z = np.where(np.hypot(x, z) <= plan.half_width, 1.0, 0.0) * np.broadcast_arrays(x, z)
    highest = float((up[0] * x + up[2] * z).max())
    assert highest - (up[0] * first.x + up[2] * first.z) <= np.sin(np.radians(5.0)) * 1.2


def test_each_part_of_a_parted_base_has_a_vent_at_its_highest_place():
    design = drawn(DESIGNS["parted by a core"])
    assert design.body.core.depth_mm is None
    holes, _ = base_holes_of(bare(design))
    half, deep = 0.5 * design.body.core.width_mm, 0.5 * design.body.depth_mm
    vents = np.array([[hole.x, hole.z] for hole in holes if hole.kind == "vent"])
    left = vents[vents[:, 0] < -half]
    assert (np.array([-half, deep]) - left).min(axis=0) == pytest.approx([0.6, 0.6], abs=0.25)
    assert left.sum(axis=1).max() == pytest.approx(-half + deep - 1.2, abs=0.5)


def test_gate_and_riser_share_a_small_base_or_are_refused():
    plan = plan_mold(narrow())
    widths = {hole.kind: hole.diameter for hole in plan.base_holes}
    assert set(widths) == {"gate", "riser", "vent", "lock", "wires"}
    assert plan.top == pytest.approx(plan.crest + 6.0)
    assert 0.5 * widths["gate"] <= widths["riser"] <= widths["gate"] < 4.0
    core = {"width_mm": 17.5, "depth_mm": 7.5, "height_mm": 3.0}
    design = shipped("homogeneous", body__core=core, mold__process="fdm")
    assert "mold.gate_mm" in keys(mold_faults(design))


def test_air_leaves_by_the_edge_of_an_opening_but_not_by_the_wires():
    plan = plan_mold(narrow())
    by_kind = {hole.kind: hole for hole in plan.base_holes}
    gate, wires = by_kind["gate"], by_kind["wires"]
    edge = 0.5 * gate.diameter + 0.1
    points = np.array([[edge, 0.0, 0.0], [edge, 0.2, 0.0], [0.0, 0.3, 0.0]])
    points += [gate.x, 0.0, gate.z]
    assert beyond_openings(plan, points) == pytest.approx([0.1, np.hypot(0.1, 0.2), 0.3])
    assert beyond_openings(plan, np.array([[wires.x, 0.0, wires.z]]))[0] > 0.1


@pytest.mark.parametrize("pour", ["open", "closed"])
def test_all_leads_leave_through_the_base_at_the_front(pour):
    plan = plan_mold(shipped("maeno2000", mold__pour=pour))
    (hole,) = (hole for hole in plan.base_holes if hole.kind == "wires")
    # Half of it is wire; it and its pocket lie below the finger, with a wall to its edge.
    assert hole.diameter**2 == pytest.approx(2.0 * 15 * 0.3**2)
    assert hole.x == 0.0
    assert 3.0 < hole.z < plan.half_depth - 0.5 * hole.outer_diameter
    assert plan.base - hole.pocket >= 1.0
    none = plan_mold(shipped("maeno2000", mold__pour=pour, mold__wire_mm=0.0))
    assert "wires" not in {hole.kind for hole in none.base_holes}
    thick = plan_mold(shipped("maeno2000", mold__pour=pour, mold__wire_mm=0.9))
    holes = [hole for hole in thick.base_holes if hole.kind == "wires"]
    assert len(holes) > 1
    assert sum(hole.diameter**2 for hole in holes) >= 2.0 * 15 * 0.9**2 - 1e-9
    faults = mold_faults(shipped("maeno2000", mold__pour=pour, mold__wire_mm=3.0))
    assert "mold.wire_mm" in keys(faults)


def test_a_backing_is_screwed_and_a_bone_is_pinned_unless_it_is_too_thin():
    plan = plan_mold(shipped("boned", body__core__bottom_mm=0.0))
    assert [hole.kind for hole in plan.base_holes].count("screw") == 2
    assert not plan.core_pins
    boned = plan_mold(shipped("boned"))
    assert len({pin.side for pin in boned.core_pins}) == 2
    for pin in boned.core_pins:
        assert 1.0 < pin.y < 5.0
        assert pin.tip + pin.depth == pytest.approx(4.5)
    (fault,) = mold_faults(shipped("boned", body__core__height_mm=1.0))
    assert fault.key == "body.core.height_mm"
    least = float(fault.bound.split()[2])
    assert not mold_faults(shipped("boned", body__core__height_mm=least))


def test_a_low_core_s_pins_are_raised_until_a_wall_is_below_them():
    plan = plan_mold(drawn(125))  # pinned in its core's middle, 0.89 mm of wall are left
    low, high = plan.core
    for pin in plan.core_pins:
        assert pin.y > 0.5 * (low[1] + high[1]) + 0.01
        below = pin.y - 0.5 * pin.diameter - pin.clearance
        assert below >= plan.limits.wall_mm
        assert 2.0 * (high[1] - pin.y) > pin.diameter


@pytest.mark.slow
def test_pins_are_thinner_where_the_process_s_own_have_no_room():
    design = drawn(149)
    plan = plan_mold(design)
    assert {pin.diameter for pin in plan.pins} == {1.5, 2.0}
    assert plan.design.mold.leg_mm is None
    limits = design.mold.limits.model_copy(update={"pin_mm": 2.0})
    given = design.model_copy(update={"mold": design.mold.model_copy(update={"limits": limits})})
    assert "mold.limits.pin_mm" in {fault.key for fault in mold_faults(given)}


@pytest.mark.parametrize("design", ["narrow", "block", 48], ids=str)
def test_the_leads_channel_runs_to_the_front_with_a_wall_to_every_hole(design):
    plan = plan_mold(shipped(design) if isinstance(design, str) else drawn(design))
    (hole,) = (hole for hole in plan.base_holes if hole.kind == "wires")
    assert bool(hole.pocket) == isinstance(design, str)  # the random one has no room for it
    for other in plan.base_holes if hole.pocket else ():
        if other is not hole:
            near = np.hypot(other.x - hole.x, min(other.z - hole.z, 0.0))
            radii = 0.5 * (hole.diameter + max(other.diameter, other.outer_diameter))
            assert near - radii >= 1.0 - 1e-9


def test_what_mends_leads_without_room_is_named_and_does():
    thick = shipped("maeno2000", mold__pour="open", mold__wire_mm=3.0)
    (fault,) = mold_remedies(thick)
    assert "vents" not in fault.bound
    found = re.findall(r"(mold\.wire_mm|body\.\w+) = ([\d.]+)", fault.remedy)
    assert "mold.wire_mm" in dict(found)
    for key, value in found:
        assert not mold_faults(with_values(thick, {key: float(value)}))


def test_holes_that_nobody_requested_are_as_large_as_the_least_and_an_open_mold_has_no_gate():
    values = {"mold__limits__hole_mm": 4.5, "mold__wire_mm": 0.0}
    holes = plan_mold(shipped("maeno2000", mold__pour="open", **values)).base_holes
    assert {(hole.kind, hole.diameter) for hole in holes} == {("lock", 4.5)}
    requested = shipped("maeno2000", mold__pour="open", mold__gate_mm=1.0, **values)
    assert not mold_faults(requested)
    closed = shipped("maeno2000", mold__gate_mm=1.0, mold__lock_mm=1.0, **values)
    assert {"mold.gate_mm", "mold.lock_mm"} <= set(keys(mold_faults(closed)))


@pytest.mark.parametrize("size", [60.0, 200.0])
def test_round_end_walls_stand_beyond_the_finger(size):
    body = {"shape": "revolved", "width_mm": size, "base_height_mm": 0.4 * size}
    plan = plan_mold(made({**body, "arc_radius_mm": 0.6 * size}, {"count": 0}))
    assert plan.corner < plan.half_depth - 8.0
    assert plan.reach_z > plan.half_depth + limits_of(Mold()).wall_mm


@pytest.mark.parametrize("name", ["block", "maeno2000", "pin", "sensitive", "wide"])
def test_the_gate_stands_clear_of_the_plates_and_away_from_the_first_vent(name):
    plan = plan_mold(shipped(name))
    gate = next(hole for hole in plan.base_holes if hole.kind == "gate")
    vent = next(hole for hole in plan.base_holes if hole.kind == "vent")
    for frame in plan.frames:
        turn = np.radians(frame.angle_deg)
        half = 0.5 * (frame.length * abs(np.cos(turn)) + frame.thickness * abs(np.sin(turn)))
        place, across = (gate.x, gate.z) if frame.along == "x" else (gate.z, gate.x)
        apart = max(abs(place - frame.place) - half, abs(across - frame.middle) - 0.5 * frame.span)
        assert apart >= 0.5 * gate.diameter - 1e-3
    assert (gate.x - vent.x) ** 2 + (gate.z - vent.z) ** 2 > plan.half_width**2


def test_remedies_take_a_fixed_number_of_plans(calls_of):
    """A limit of plans, not of time: what is refused does not depend on it, nor on the machine."""
    design = shipped("block", **TINY)
    with pytest.raises(MoldRefused) as refused:
        plan_mold(design)
    plans = calls_of(remedies, "plan_mold")
    found = remedies.remedied(design, refused.value)
    assert 0 < len(plans) <= remedies.PLANS
    assert [f.key for f in found.faults] == [f.key for f in refused.value.faults]
    assert all(fault.remedy for fault in found.faults)
