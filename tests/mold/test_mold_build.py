"""The mold's CAD: exact solids that fill the block, come off, and hold what the plan says."""

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

from fingerdesign.cad.bodies import outline_solid
from fingerdesign.cad.export import check_watertight
from fingerdesign.cad.from_python import with_body
from fingerdesign.cad.kernel import volume_of
from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.errors import GeometryError
from fingerdesign.layout.volume import core_volume, outline_volume, plate_volume
from fingerdesign.mold.cad.build import build_mold, undercuts
from fingerdesign.mold.cad.features import cut_plates
from fingerdesign.mold.cad.write import meshed
from fingerdesign.mold.checks.run import run_checks
from fingerdesign.mold.make import mold_meshes
from fingerdesign.mold.part import BASE, BASE_FRAME, CORE, INSERT
from fingerdesign.mold.plan.pieces import SIDES, Plug, SidePlan, in_space, wall_name
from fingerdesign.mold.plan.planning import plan_mold
from tests.support.as_planned import as_planned
from tests.support.molds import CLOSED, shipped

BENT = 'follow = "bent"\nangle_deg = 0.0\n'
HOLES = "hole_diameter_mm = 0.4\nhole_pitch_mm = 1.5\nspan_mm = 5.0\n"
DOME = 'shape = "dome"\ndome_radius_mm = 9.0'
ARC = "arc_radius_mm = 8.0\n"
SMALL = """
design.name = "small"
[body]
width_mm = 10.0
base_height_mm = 8.0
depth_mm = 8.0
{body}
[plates]
count = 3
pitch_mm = 2.0
thickness_mm = 0.2
length_mm = 1.2
cover_mm = 1.4
{plates}
[gages]
length_mm = 0.5
width_mm = 0.5
"""


def design_of(body="", plates="", **values):
    body = body if "block" in body else ARC + body
    design = parse_design(SMALL.format(body=body, plates=plates))
    return with_values(design, {**CLOSED, **{f"mold.{k}": v for k, v in values.items()}})


def built_of(design, **changes):
    plan = replace(plan_mold(design), **changes)
    return plan, build_mold(plan)


def round_design():
    """A sphere-ended pin without plates."""
    return shipped("pin", plates__count=0, plates__span_mm=None)


@pytest.fixture(scope="module")
def usual():
    """A small arc with three plates held by combs."""
    return built_of(design_of())


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The same made by the worker: design, plan, meshes and their files."""
    design, folder = design_of(), tmp_path_factory.mktemp("mold")
    plan = plan_mold(design)
    return design, plan, mold_meshes(plan, folder), folder


def part(built, name):
    return next(each for each in built.parts if each.name == name)


def solid(built, name):
    return part(built, name).solid


def unfilled(built):
    """Block less outline and blanks, as a share of the outline."""
    block = float(np.prod(np.array(built.high) - np.array(built.low)))
    parts = [p for p in built.parts if p.name not in (BASE, BASE_FRAME, CORE)]
    filled = sum(volume_of(p.solid if p.blank is None else p.blank) for p in parts)
    outline = volume_of(built.outline.solid)
    return (block - filled - outline) / outline


def holds(solid, point):
    return solid.isInside(tuple(float(value) for value in point), 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "body", ["edge_radius_mm = 1.0", 'shape = "block"\nedge = "chamfer"\nedge_radius_mm = 1.0']
)
def test_parts_and_finger_fill_the_block(body):
    _, built = built_of(design_of(body, "span_mm = 4.0"))
    assert abs(unfilled(built)) < 1e-8
    assert all(each.solid.isValid() for each in built.parts)


def test_a_round_finger_has_level_seams_and_its_parts_fill_the_block():
    plan, built = built_of(round_design())
    assert abs(unfilled(built)) < 1e-8
    assert solid(built, INSERT).BoundingBox().ymin < plan.rim + 1e-6
    near = (plan.half_width + 2.0, 0.5 * plan.rim)
    front, right = (part(built, wall_name(side)).blank for side in ("+z", "+x"))
    assert holds(front, (*near, plan.corner + 0.01))
    assert holds(right, (*near, plan.corner - 0.01))
    assert not holds(front, (near[0], plan.rim + 0.01, plan.corner + 0.01))


def test_the_contact_surface_goes_on_outward_in_the_seams(usual):
    plan, built = usual
    assert abs(unfilled(built)) < 1e-8
    wall = part(built, wall_name("+z")).blank
    beyond = plan.half_depth + 0.5 * plan.wall_z
    for x in (0.0, 2.0, 4.5, 5.5):
        crest = 8.0 + np.sqrt(64.0 - min(x * x, 25.0)) - np.sqrt(64.0 - 25.0)
        assert holds(wall, (x, crest - 0.01, beyond))
        assert not holds(wall, (x, crest + 0.01, beyond))


def legs_volume(legs, thickness):
    return sum(leg.width * (leg.tip - leg.start) * thickness for leg in legs)


def test_shrinkage_enlarges_the_rubber_and_leaves_the_metal_as_it_is():
    core = "[body.core]\nwidth_mm = 4.0\nheight_mm = 2.0\ndepth_mm = 4.0"
    design = design_of(core, shrinkage=0.02)
    plan, built = built_of(design)
    outline = volume_of(built.outline.solid)
    assert outline == pytest.approx(outline_volume(design.body) / 0.98**3, rel=1e-9)
    plates, legs = sum(map(plate_volume, plan.frames)), legs_volume(plan.legs, 0.2)
    found = sum(volume_of(plate.solid) for plate in built.plates)
    assert found == pytest.approx(plates + legs, rel=1e-9)
    gone = outline - volume_of(built.rubber.solid) - plates - core_volume(design)
    assert 0.0 <= gone < 1.001 * legs


@pytest.mark.parametrize("plates", ["angle_deg = 45.0", BENT, HOLES, BENT + HOLES])
def test_a_plate_with_its_legs_is_one_piece_of_the_sum_of_volumes(plates):
    plan = plan_mold(design_of("", plates))
    for frame, plate in zip(plan.frames, cut_plates(plan), strict=True):
        legs = plan.legs_by_plate.get(frame.index, ())
        assert len(legs) == 2
        volume = plate_volume(frame) + legs_volume(legs, frame.thickness)
        assert volume_of(plate) == pytest.approx(volume, rel=1e-6)
        assert plate.BoundingBox().zmax == pytest.approx(max(leg.tip for leg in legs), abs=1e-5)


def test_a_comb_is_the_finger_s_end_and_its_slots_let_the_plates_through(usual):
    plan, built = usual
    comb, wall = part(built, "comb_front"), part(built, wall_name("+z"))
    assert comb.made == "sheet"
    assert comb.order > wall.order
    bounds = comb.solid.BoundingBox()
    assert (bounds.zmin, bounds.zmax) == pytest.approx((4.0, 4.3), abs=1e-6)
    for slot in plan.by_side["+z"].slots:
        assert not holds(comb.solid, (slot.place, slot.y, plan.half_depth + 0.15))
    low, high, bottom = plan.by_side["+z"].window
    middle = plan.half_depth + 0.5 * plan.wall_z
    for height, held in ((0.1, False), (-0.1, True)):
        assert holds(wall.solid, (0.5 * (low + high), bottom + height, middle)) is held


def test_the_base_plate_s_holes_have_their_sizes(usual):
    plan, built = usual
    volume = 4.0 * plan.mount_x * plan.mount_z * plan.base
    for hole in plan.base_holes:
        d, outer = hole.diameter, hole.outer_diameter
        if hole.kind == "wires":  # a hole, a pocket, and a channel from the pocket's edge on
            volume -= 0.25 * np.pi * (d**2 * (plan.base - hole.pocket) + outer**2 * hole.pocket)
            t = np.arcsin(d / outer)
            within = 0.25 * outer**2 * (t + 0.5 * np.sin(2.0 * t))  # of the channel, half the disc
            volume -= hole.pocket * (d * (plan.mount_z - hole.z) - within)
            continue
        volume -= np.pi * plan.base * (d**2 + d * outer + outer**2) / 12.0
    if plan.groove is not None:  # in both flanks
        depth, low, high = plan.groove
        volume -= 4.0 * depth * (high - low) * plan.mount_z
    assert volume_of(solid(built, BASE)) == pytest.approx(volume, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("process", ["sla", "machined"])
def test_a_built_mold_passes_every_check(process, written):
    """Pins, bolts and holes as planned, in triangles that keep the chord."""
    design, plan, meshes, _ = written
    if process == "machined":
        design = design_of(process=process)
        plan, built = built_of(design)
        meshes = built.each(lambda part: meshed(part, design.mold.chord_mm))
    found = [*run_checks(plan, meshes), *as_planned(plan, meshes)]
    assert [check.sentence for check in found if not check.ok] == []
    assert "demolding" in {check.name for check in found}
    for pin in plan.pins if process == "machined" else ():  # dowels are holes in both parts
        root, way = np.array(pin.root), np.array(pin.direction)
        assert pin.dowel
        assert not holds(solid(built, pin.on), root - 0.45 * pin.length * way)
        assert holds(solid(built, pin.on), root - 0.55 * pin.length * way)
    for mesh in (*meshes.parts, *meshes.plates, meshes.rubber, meshes.outline):
        assert np.array_equal(mesh.vertices, mesh.vertices.astype(np.float32))
        check_watertight(mesh.name, mesh.vertices, mesh.triangles)
    assert [mesh.name for mesh in meshes.plates] == ["plate_0", "plate_1", "plate_2"]


@pytest.mark.slow
def test_a_backing_gets_pilot_holes_and_a_bone_holes_for_its_pins():
    core = "[body.core]\nwidth_mm = 5.0\nheight_mm = 3.0\ndepth_mm = {depth}\nbottom_mm = {bottom}"
    design = design_of(core.format(depth=5.0, bottom=0.0))
    plan, built = built_of(design)
    screws = [hole for hole in plan.base_holes if hole.kind == "screw"]
    assert screws
    for hole in screws:
        assert not holds(solid(built, CORE), (hole.x, 0.5, hole.z))
        assert holds(solid(built, CORE), (hole.x, 2.9, hole.z))
    plan, built = built_of(design_of(core.format(depth=5.0, bottom=1.0)))
    assert plan.core_pins
    for pin in plan.core_pins:
        for name, out in ((CORE, pin.tip + 0.5 * pin.depth), (pin.side, plan.reach_z - 0.5)):
            name = CORE if name == CORE else wall_name(pin.side)
            assert not holds(solid(built, name), in_space(pin.side, pin.place, pin.y, out))


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["x", "z"])
@pytest.mark.parametrize("shape", ["dome", "revolved"])
def test_beyond_a_plug_the_walls_reach_the_block_s_top(shape, axis):
    design = design_of(DOME, "span_mm = 4.0") if shape == "dome" else round_design()
    sides = tuple(SidePlan(side, "wall", 0.0, None, ()) for side in SIDES)
    bare = {"bolts": (), "pins": (), "sides": sides}
    plan, built = built_of(design, plugs=(Plug(axis, 2.5, 3.5),), **bare)
    assert abs(unfilled(built)) < 1e-7
    insert, side = solid(built, INSERT), f"+{axis}"
    for height in (plan.top - 1e-3, plan.crest):
        edge = 2.5 + (height - plan.rim) / (plan.top - plan.rim)
        for out, held in ((edge - 0.05, insert), (edge + 0.05, solid(built, wall_name(side)))):
            assert holds(held, in_space(side, 0.3, height, out))


def test_the_worker_writes_a_file_of_each_part_and_each_different_plate(written):
    *_, meshes, folder = written
    names = {part.name for part in meshes.parts} | {"plate_A"}
    assert names >= {INSERT, BASE, "comb_front", "comb_back", *map(wall_name, SIDES)}
    files = {f"{name}.{kind}" for name in names for kind in ("stl", "step")} | {"assembly.step"}
    assert {path.name for path in folder.iterdir()} >= files
    stl = (folder / f"{INSERT}.stl").read_bytes()
    assert int.from_bytes(stl[80:84], "little") == len(meshes.part(INSERT).triangles)
    text = (folder / "assembly.step").read_text("latin-1")
    assert all(f"'{name}'" in text for name in (INSERT, "comb_back", "plate_0", "rubber"))


def test_a_kernel_that_takes_too_long_is_ended(tmp_path):
    design = design_of()
    with pytest.raises(GeometryError, match=r"did not finish in 0.1 s"):
        mold_meshes(plan_mold(design), tmp_path, time_limit_s=0.1)


def along_z(*corners):
    """A prism over all of the depth through corners (x, y)."""
    return cq.Workplane("XY", origin=(0, 0, -20)).polyline(corners).close().extrude(40.0)


DOVETAIL = ((-1, 10), (1, 10), (2, 8), (-2, 8))
GROOVE = ((-2, 10), (2, 10), (1, 8), (-1, 8))  # widens upward
ACROSS = cq.Workplane("YZ", origin=(-20, 4, 0)).circle(1.5).extrude(40.0)  # a hole along x


@pytest.mark.parametrize(("tool", "held"), [(along_z(*DOVETAIL), INSERT), (ACROSS, "")])
def test_faces_that_would_hold_a_part_are_named_and_refused(tool, held):
    design, plan = cut_by(tool)
    faces = undercuts(outline_solid(design.body), plan)
    with pytest.raises(GeometryError, match=rf"face {faces[0].face} of body.step at \(.*{held}"):
        build_mold(plan)
    if held == INSERT:
        assert [each.part for each in faces] == [INSERT] * 2
        places = np.abs([each.place[:2] for each in faces])
        assert np.all((places > [1.0, 8.0]) & (places < [2.0, 10.0]))


def cut_by(tool):
    """A box with something cut out of it, and its plan."""

    def make():
        return cq.Workplane("XY").box(16.0, 10.0, 12.0).translate((0, 5.0, 0)).cut(tool)

    plain = parse_design('design.name = "cut"\nplates.count = 0\nmold.pour = "closed"')
    design = with_body(plain, make, mirrors_in_z=True)
    return design, plan_mold(design)


def test_what_widens_upward_holds_no_part():
    design, plan = cut_by(along_z(*GROOVE))
    assert undercuts(outline_solid(design.body), plan) == ()
