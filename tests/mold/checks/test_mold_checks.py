"""A mold made by hand passes every check; each fault put into it fails the check that names it."""

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

from fingerdesign.mold.checks.assembly import assemble, from_slot, planned
from fingerdesign.mold.checks.run import part_checks, run_checks
from fingerdesign.mold.checks.venting import beyond_openings, high_points
from fingerdesign.mold.checks.walls import clearance_checks
from fingerdesign.mold.part import BASE, INSERT, RUBBER
from fingerdesign.mold.plan.pieces import Bolt, OuterComb, Slot
from fingerdesign.mold.products.casting import silicone_of
from fingerdesign.mold.solids import curved_area, solid_of
from tests.support.as_planned import as_planned
from tests.support.molds import BOX, CORNERS, box, meshed


def run(made):
    return run_checks(made.plan, made.meshes)


def failed(made):
    """Sentences of the checks that fail, by name, and part where they have one."""
    found = (check for check in run(made) if not check.ok)
    return {f"{c.name}: {c.part}" if c.part else c.name: c.sentence for c in found}


def missed(made):
    """Sentences of what is planned but not made, by name."""
    found = as_planned(made.plan, made.meshes)
    return {check.name: check.sentence for check in found if not check.ok}


def test_the_mold_passes_every_check_and_checks_are_repeatable(made):
    assert missed(made) == {}
    first, second = run(made), run(made)
    assert first == second
    assert [check.sentence for check in first if not check.ok] == []
    (found,) = [check for check in first if check.name == "vents"]
    assert "x, z = -0.71, -0.71" in found.sentence  # it is tilted toward the first vent's corner


def test_a_part_with_a_triangle_less_is_reported_and_nothing_is_cut(made):
    part = made.meshes.part("side_wall_left")
    part = replace(part, triangles=part.triangles[1:])
    found = failed(made.with_part(part))
    assert {"watertight: side_wall_left", "solids"} <= set(found)
    assert "side_wall_left" in found["solids"]
    assert not any(name.startswith("demolding") for name in found)


def test_parts_that_overlap_are_named(made):
    part = made.meshes.part(INSERT)
    moved = replace(part, vertices=part.vertices + np.array([0.0, -0.2, 0.0]))
    sentence = failed(made.with_part(moved))[f"demolding: {INSERT}"]
    assert "overlaps end_wall" in sentence or "overlaps rubber" in sentence


@pytest.mark.slow
def test_a_cavity_of_another_finger_or_block(made):
    found = failed(replace(made, meshes=replace(made.meshes, high=(18.0, 18.5, 13.0))))
    assert "cavity is the finger" in found
    wall = made.meshes.part("end_wall_front")  # the kernel left half a cubic millimetre too much
    assert "cavity is the finger" in failed(
        made.with_part(replace(wall, blank_volume=wall.blank_volume + 0.5))
    )
    body = made.plan.design.body.model_copy(update={"width_mm": 20.1})
    other = made.planned(design=made.plan.design.model_copy(update={"body": body}))
    # The cavity for a shrinkage of 2 % is no cavity for none: its cube is 6 % off.
    for wrong in (other, made.planned(scale=1.0 / 0.98)):
        assert "cavity is the finger" in failed(wrong)


def test_a_hole_in_a_wall_is_found_where_no_opening_is_planned(made):
    drilled = made.changed("side_wall_right", lambda wall: wall - made.box((9, 4, -1), (20, 6, 1)))
    sentence = failed(drilled)["surface backed by parts"]
    assert any(f"at (10.00, {height}" in sentence for height in ("4.8", "4.9", "5.0", "5.1"))


def test_a_thin_wall_is_measured(made):
    thin = made.changed("side_wall_left", lambda wall: wall - made.box((-19, 3, -3), (-10.9, 9, 3)))
    assert "least wall 0.900 mm" in failed(thin)["least wall: side_wall_left"]


def test_a_pins_tip_may_be_a_feature_and_no_thinner(made):
    def tipped(tip):
        hole = made.box((19.5, 8.9, 7.5), (22.5, 12.0, 10.5))
        pin = made.box((20.5, 9, 9 - tip / 2), (21.5, 12.1, 9 + tip / 2))
        return made.changed(INSERT, lambda insert: insert - hole + pin)

    assert f"least wall: {INSERT}" not in failed(tipped(0.5))
    assert f"least pin: {INSERT}" not in failed(tipped(0.5))
    assert "0.300 mm" in failed(tipped(0.3))[f"least pin: {INSERT}"]


def test_what_is_planned_but_not_there_is_found(made):
    filled = made.changed(BASE, lambda base: base + made.box((4, -3, -1), (6, -2, 1)))
    assert "lock at (5.00, 0.00)" in missed(filled)["planned openings"]
    stuck = made.changed("end_wall_back", lambda wall: wall + made.box((0, 7, -9), (1, 9, -8)))
    assert "slot of plate 0, side -z, in end_wall_back" in missed(stuck)["planned openings"]
    lock = replace(made.plan.base_holes[-1], outer_diameter=3.1)
    holes = (*made.plan.base_holes[:-1], lock)  # its undercut is less than planned
    assert "lock" in missed(made.planned(base_holes=holes))["planned openings"]
    bolt = Bolt("y", 21.0, -9.0, -4.0, 18.0, "M2", 2.4)
    assert "bolt 1 (M2 along y)" in missed(made.planned(bolts=(bolt,)))["planned openings"]
    gone = made.changed(INSERT, lambda insert: insert - made.box((19, 8, 7), (23, 12, 11)))
    assert f"pin 1 on {INSERT}" in missed(gone)["pins and lugs"]
    fewer = replace(made, meshes=replace(made.meshes, plates=()))
    assert "plate_0" in missed(fewer)["plates"]


def test_a_thin_web_next_to_a_slot_is_held_to_the_least_feature(made):
    def second_slot(gap):
        low = 8.2 + gap
        return lambda wall: wall - made.box((-1.6, low, -14), (1.6, low + 0.4, -4))

    name = "least web: end_wall_back"
    assert "0.300 mm" in failed(made.changed("end_wall_back", second_slot(0.3)))[name]
    assert name not in failed(made.changed("end_wall_back", second_slot(0.5)))


def test_a_tight_socket(made):
    (pin,) = made.plan.pins
    tight = made.planned(pins=(replace(pin, clearance=0.11),))
    assert "in end_wall_front" in missed(tight)["planned openings"]


def test_an_undercut_is_named_with_its_obstacle(made):
    bump = made.box((9.9, 5, -2), (10.4, 7, 2))
    cut = made.changed("side_wall_right", lambda wall: wall + made.box((10, 5, -2), (10.2, 7, 2)))
    cut = cut.changed(RUBBER, lambda rubber: rubber + bump)
    cut = cut.changed("side_wall_right", lambda wall: wall - bump)
    assert failed(cut).keys() & {"demolding: side_wall_right"} == set()  # a bump along the draw
    hook = made.box((10.2, 3, -2), (10.4, 5.5, 2))
    cut = cut.changed(RUBBER, lambda rubber: rubber + hook)
    cut = cut.changed("side_wall_right", lambda wall: wall - hook)
    assert "overlaps rubber" in failed(cut)["demolding: side_wall_right"]


def test_parts_of_one_order_and_draw_move_together(made):
    moved = made.changed("side_wall_left", lambda wall: made.box((18, 0, -5), (20, 12, 5)))
    for order, stuck in ((3, False), (4, True)):
        outer = replace(moved.meshes.part("side_wall_left"), draw=(1.0, 0.0, 0.0), order=order)
        assert ("demolding: side_wall_right" in failed(moved.with_part(outer))) is stuck


def test_a_thin_hook_far_out_is_met(made):
    """The plate's leg ends in a barb 0.1 mm thick beyond the wall."""
    barb = made.box((-1.5, 7.95, -13.5), (1.5, 8.5, -13.4)) + made.box(
        (-1.5, 7.95, -13.5), (1.5, 8.05, -12.9)
    )
    found = failed(made.changed("plate_0", lambda plate: plate + barb))
    assert "plate_0" in found["demolding: end_wall_back"]


def test_without_vents_air_stays_at_the_base(made):
    gate_only = tuple(hole for hole in made.plan.base_holes if hole.kind == "gate")
    found = failed(made.planned(base_holes=gate_only))
    assert "air stays at" in found[f"vents: {BASE}"]


def test_a_level_plate_lets_air_go_when_tilted(made):
    assembly = assemble(made.plan, made.meshes)
    heights = [point.place[1] for point in high_points(assembly)]
    assert max(heights) == pytest.approx(0.0)  # all air is at the base, none under the plate


def test_limits_of_the_plan_and_its_slots(made):
    side = made.plan.by_side["+z"]
    slot = side.slots[0]
    near = replace(slot, y=8.5, angle_deg=3.0)
    slots = (replace(slot, width=0.104), near)
    small = made.planned(sides=(replace(side, slots=slots), *made.plan.sides[1:]))
    names = {f"{what}, side +z" for what in ("planned slots", "planned webs", "room of plates")}
    assert names <= set(missed(small))


@pytest.mark.parametrize(("gap", "ok"), [(0.31, True), (0.28, False)])
def test_an_outer_comb_that_the_insert_would_clamp_is_found(made, gap, ok):
    side = replace(made.plan.by_side["+z"], outer=OuterComb((), (0.0, 1.0), 12.0, 2.0, 18.0))
    plan = replace(made.plan, sides=(side, *made.plan.sides[1:]))
    comb = box("comb_front_outer", (-12, 2, 13 + gap), (12, 18, 13.3 + gap))
    meshes = replace(made.meshes, parts=(*made.meshes.parts, comb))
    (check,) = clearance_checks(assemble(plan, meshes))
    assert (check.ok, check.measured, check.bound) == (ok, pytest.approx(gap), 0.3)


def test_high_points_are_measured_from_the_edge_of_the_nearest_opening(made):
    """The vent at (9, 4) is 1 mm wide, the slot 3.2 x 0.4 mm at (0, 8) on the faces z = -+5."""
    points = np.array([[9.0, 0.0, 0.5], [-9.0, 0.3, -4.9], [0.0, 8.2, 4.0], [3.6, 8.0, -5.0]])
    beyond = beyond_openings(made.plan, points)
    assert beyond == pytest.approx([3.0, np.hypot(0.4, 0.3), 1.0, 2.0])


def test_places_in_planned_openings_need_no_part_behind_them(made):
    """A lock is 3 mm wide outside; the slot's long half is 1.6, its short one 0.2 mm."""
    there = [[6.5, -0.1, 0.0], [1.6, 8.2, 6.0], [1.6, 8.2, -6.0], [0.0, 8.0, 6.0]]
    away = [[6.6, -0.1, 0.0], [1.7, 8.0, 6.0], [0.0, 8.3, 6.0], [6.0, 0.1, 0.0]]
    assert planned(made.plan, np.array(there), 0.05).tolist() == [True] * 4
    assert planned(made.plan, np.array(away), 0.05).tolist() == [False] * 4
    seamed = replace(made.plan, seam=0.15)
    ends = np.array([[10.0, 0.19, 5.0], [10.0, 0.21, 5.0]])
    assert planned(seamed, ends, 0.05).tolist() == [True, False]


def test_a_slot_is_turned_as_its_plate_and_its_mouth_is_open_below_it_up_to_its_depth():
    """Along 30 degrees 2 mm long, 0.4 wide; below it, up to 4 mm out, open down to y = 6."""
    slot = Slot(0, "+z", 1.0, 8.0, 30.0, 2.0, 0.4)
    along, across = np.array([0.75**0.5, 0.5, 0.0]), np.array([-0.5, 0.75**0.5, 0.0])
    places = [1.5 * along, -1.5 * along, 0.5 * across, -0.1 * across, 1.3 * along + 0.6 * across]
    points = np.array([1.0, 8.0, 5.0]) + np.array(places)
    assert from_slot(slot, points) == pytest.approx([0.5, 0.5, 0.3, -0.1, 0.5])
    assert np.isnan(from_slot(slot, points * [1.0, 1.0, -1.0])).all()
    mouthed = replace(slot, angle_deg=0.0, mouth=(4.0, 6.0))
    below = np.array([[1.0, 6.5, 3.5], [1.0, 5.75, 3.5], [1.0, 6.5, 4.25], [1.0, 9.0, 3.5]])
    assert from_slot(mouthed, below) == pytest.approx([-0.5, 0.25, 0.25, 0.8])


def test_silicone_to_mix(made):
    found = silicone_of(made.plan, made.meshes)
    locks, openings = np.pi * 4 * (4 + 6 + 9) / 12, np.pi * 4 * (16 + 20 + 25) / 12 + np.pi * 4
    sizes = (2396.0, locks, openings, 2 * 8 * (3.2 * 0.4 - 3.0 * 0.1))
    names = ("finger_cm3", "locks_cm3", "gate_risers_vents_cm3", "flash_cm3")
    volumes = [found[name] for name in names]
    assert volumes == pytest.approx(1e-3 * np.array(sizes))
    assert found["mixed_cm3"] == pytest.approx(1.15 * sum(volumes))
    assert found["mass_g"] == pytest.approx(1.1 * found["mixed_cm3"])
    assert f"{found['mass_g']:.1f} g" in found["sentence"]


def part(points=CORNERS, triangles=BOX, exact=1.0, **changes):
    return replace(meshed("part", points, triangles, volume=exact), **changes)


def unsound(part_):
    solid = solid_of(part_.vertices, part_.triangles)
    return {check.name for check in part_checks(part_, solid, 0.01) if not check.ok}


TURNED = np.vstack([BOX[:1, ::-1], BOX[1:]])
TOUCHING = np.vstack([CORNERS, CORNERS[[k for k in range(8) if k != 0]] + 1.0])
OTHER = np.where(BOX == 0, 6, BOX + 7)  # another cube at the corner (1, 1, 1)
HOLLOW = np.vstack([CORNERS, 0.25 + 0.5 * CORNERS])


@pytest.mark.parametrize(
    ("faulty", "names"),
    [
        (part(), set()),
        (part(triangles=BOX[:, ::-1]), {"volume"}),  # inside out
        (part(TOUCHING, np.vstack([BOX, OTHER]), 2.0), {"watertight"}),
        (part(HOLLOW, np.vstack([BOX, BOX[:, ::-1] + 8]), 0.875), {"watertight"}),
        (part(HOLLOW, np.vstack([BOX, BOX[:, ::-1] + 8]), 0.875, made="silicone"), set()),
        (part(triangles=BOX[1:]), {"watertight", "volume"}),
        (part(triangles=TURNED), {"watertight", "volume"}),
        (part(exact=1.002, chord=0.01), {"volume"}),
        (part(exact=1.0005, chord=0.01), {"volume"}),  # flat faces have no chord to blame
        (part(chord=0.02), {"chord"}),
    ],
)
def test_each_fault_of_triangles_is_found_by_its_own_check(faulty, names):
    assert unsound(faulty) == names


def test_only_curved_faces_count_as_curved():
    assert curved_area(CORNERS, BOX) == 0.0
    found = Manifold.cylinder(10.0, 2.0, 2.0, 64).to_mesh64()
    vertices, triangles = np.array(found.vert_properties), np.array(found.tri_verts, dtype=int)
    assert curved_area(vertices, triangles) == pytest.approx(40.0 * np.pi, rel=1e-2)
