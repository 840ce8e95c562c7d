"""Open molds: which fingers get one, of how few parts, and that its parts are what was planned.

What is made is checked by others than those that made it: STL files by trimesh, STEP files by the
CAD kernel's own common volumes and distances, drawings by ezdxf.
"""

from dataclasses import replace
from itertools import combinations

import cadquery as cq
import numpy as np
import pytest
import trimesh
from fingerdesign_bench.any_finger.designs import random_design

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.schema import Design
from fingerdesign.design.step import resolved
from fingerdesign.errors import DesignError
from fingerdesign.layout.volume import outline_volume
from fingerdesign.mold.cad.build import build_mold
from fingerdesign.mold.checks.run import run_checks
from fingerdesign.mold.make import mold_meshes
from fingerdesign.mold.part import BASE, INSERT
from fingerdesign.mold.plan.limits import limits_of
from fingerdesign.mold.plan.pieces import RELIEF_MM
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.products.bill import comb_made, hardware
from tests.support.as_planned import as_planned

FRAMES = {"frame_front", "frame_back"}


def parts_of(plan):
    combs = sum(side.comb is not None for side in plan.sides)
    return 2 + (plan.lip > 0.0) + len(plan.walls) + combs


def test_combs_are_etched_where_their_slots_are_wide_enough():
    """Slots of film_tees have 0.1 mm in a sheet of 0.3 mm, those of 0.3 mm plates are wider."""
    thin = plan_mold(load_design("film_tees"))
    assert comb_made(thin) == "laser-cut or wire-cut"
    sides = [
        replace(side, slots=[replace(s, width=0.3) for s in side.slots]) for side in thin.sides
    ]
    assert comb_made(replace(thin, sides=tuple(sides))) == "cut or etched"


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        *(("homogeneous", 4), ("block", 6), ("maeno2000", 6), ("domed", 6), ("narrow", 6)),
        *(("wide", 6), ("sensitive", 6), ("fine_tees", 6), ("tees", 6)),
    ],
)
def test_a_finger_that_allows_it_gets_the_fewest_parts_and_two_bolts(name, parts):
    plan = plan_mold(load_design(name))
    assert (plan.pour, plan.closed_for) == ("open", "")
    assert set(plan.walls) == FRAMES
    assert (parts_of(plan), len(plan.bolts)) == (parts, 2)
    kinds = {"lock", "wires"} if plan.frames else {"lock"}
    kinds = kinds - {"wires"} if plan.design.mold.leads == "leg" else kinds
    assert {hole.kind for hole in plan.base_holes} == kinds
    footprint = plan.half_width * plan.half_depth
    assert footprint < plan.mount_x * plan.mount_z <= 2.0 * footprint
    names = ["bolt", "nut", "washer"]  # of one kind each; then what fastens the mount
    names += ["receiver screw", "threaded insert", "hand screw"] if plan.groove else []
    assert [item["item"] for item in hardware(plan)] == names
    closed = plan_mold(with_values(load_design(name), {"mold.pour": "closed"}))
    assert parts_of(closed) == parts + 3
    assert len(closed.bolts) >= 6


@pytest.mark.parametrize(
    ("name", "word"), [("boned", "core"), ("both_ways", "right and left"), ("pin", "contact")]
)
def test_a_finger_that_needs_a_closed_mold_gets_one_and_the_reason(name, word):
    plan = plan_mold(load_design(name))
    assert plan.pour == "closed"
    assert word in plan.closed_for
    with pytest.raises(DesignError) as error:
        plan_mold(with_values(load_design(name), {"mold.pour": "open"}))
    (fault,) = error.value.faults
    assert fault.key == "mold.pour"
    assert plan.closed_for in fault.bound
    assert "auto" in fault.remedy


@pytest.mark.slow
@pytest.mark.parametrize("seed", [16, 31])
def test_frames_of_a_dome_with_chamfers_are_whole_next_to_their_combs_windows(seed):
    # The kernel's difference of frame and comb was nothing, and a window reached into the flanks.
    design = Design.model_validate(resolved(random_design(seed))[0])
    plan = plan_mold(design)
    assert plan.pour == "open"
    built = build_mold(plan)
    x, y = plan.half_width + 0.02, plan.rim + 0.2  # next to the flank, whose top is an arc
    for name, z in (("frame_front", 0.1), ("frame_back", -0.1)):
        for place in (x, -x):
            assert built.part(name).solid.isInside(cq.Vector(place, y, z))


def test_a_wall_is_left_below_the_inserts_pins_where_frames_end_short_of_the_base():
    design = Design.model_validate(resolved(random_design(78))[0])
    plan = plan_mold(design)
    assert plan.seam > 0.0
    for pin in plan.pins:
        left = pin.root[1] - pin.length - pin.clearance - plan.seam
        assert left >= limits_of(design.mold).wall_mm - 1e-9


@pytest.mark.slow
def test_lugs_of_both_frames_leave_the_mount_its_clearance_and_no_more(made):
    design, plan, meshes, _ = made
    gap = limits_of(design.mold).clearance_mm
    assert len(plan.lugs) == 6
    for axis, half in ((0, plan.mount_x), (2, plan.mount_z)):
        low = max(lug.high[axis] for lug in plan.lugs if lug.high[axis] < -half)
        high = min(lug.low[axis] for lug in plan.lugs if lug.low[axis] > half)
        assert (-half - low, high - half) == pytest.approx((gap, gap))
    part = {part.name: part for part in meshes.parts}
    for name in FRAMES:  # as far below the base's face as lugs are high
        assert part[name].vertices[:, 1].min() == pytest.approx(-2.0, abs=1e-6)
    assert np.ptp(part[BASE].vertices, axis=0)[[0, 2]] == pytest.approx(
        (2 * plan.mount_x, 2 * plan.mount_z)
    )


def test_what_is_too_large_for_an_open_mold_is_closed_or_refused():
    low = with_values(load_design("maeno2000"), {"mold.bolt": "M4", "mold.limits.wall_mm": 1.5})
    with pytest.raises(DesignError, match=r"mold\.bolt = M4"):  # of the closed one
        plan_mold(low)
    thin = with_values(load_design("maeno2000"), {"mold.wall_mm": 3.0})
    with pytest.raises(DesignError, match=r"mold\.wall_mm = 3\.0: must be at least 3\.3"):
        plan_mold(thin)
    assert plan_mold(with_values(thin, {"mold.wall_mm": 3.3})).wall_z == 3.3


SMALL = {"plates.count": 5, "plates.pitch_mm": 1.5}
MADE = {
    "no plates": ("homogeneous", {}),
    "plates, shrinking": ("maeno2000", {**SMALL, "mold.cure": "condensation"}),
    "dowels and slots": (
        "wide",
        {"plates.count": 3, "mold.process": "machined", "mold.plate_fixture": "slots"},
    ),
}


@pytest.fixture(scope="module", params=MADE)
def made(request, tmp_path_factory):
    """An open mold: design, plan, meshes, their folder."""
    name, values = MADE[request.param]
    design, folder = with_values(load_design(name), values), tmp_path_factory.mktemp("open")
    plan = plan_mold(design)
    return design, plan, mold_meshes(plan, folder, 120.0), folder


def test_it_passes_every_check_that_a_closed_one_passes(made):
    _, plan, meshes, _ = made
    assert plan.pour == "open"
    found = [*run_checks(plan, meshes), *as_planned(plan, meshes)]
    assert [check.sentence for check in found if not check.ok] == []
    names = {check.name for check in found}
    assert {"watertight", "volume", "cavity is the finger"} <= names
    assert {"demolding", "vents", "surface backed by parts"} <= names
    drawn = {check.part for check in found if check.name == "demolding"}
    assert drawn >= {INSERT, *FRAMES}


def test_its_stl_files_are_closed_and_hold_their_volumes(made):
    *_, meshes, folder = made
    for part in meshes.parts:
        surface = trimesh.load_mesh(folder / f"{part.name}.stl")
        assert surface.is_watertight
        assert surface.is_winding_consistent
        assert surface.volume == pytest.approx(part.volume, rel=2e-3)  # positive: faces look out
        assert surface.extents == pytest.approx(np.ptp(part.vertices, axis=0), abs=1e-4)


@pytest.mark.slow
def test_its_step_files_touch_but_do_not_overlap_and_enclose_the_finger(made):
    design, plan, meshes, folder = made
    names = [part.name for part in meshes.parts]
    solids = {name: cq.importers.importStep(str(folder / f"{name}.step")).val() for name in names}
    for one, other in combinations(names, 2):
        assert solids[one].intersect(solids[other]).Volume() < 1e-4
    for name in names:
        gap = RELIEF_MM if "outer" in name else 0.0
        away = solids[INSERT].distance(solids[name])
        assert away == pytest.approx(gap, abs=1e-6) or name == BASE
    reach = (2 * plan.reach_x, plan.top, 2 * plan.reach_z)
    inside = cq.Workplane("XY").box(*reach).translate((0, 0.5 * plan.top, 0)).val()
    whole = inside.cut(*(solids[name] for name in names))
    cavity = max(whole.Solids(), key=lambda solid: solid.Volume()).Volume()
    if plan.legs:  # what slots and windows hold belongs to it too
        assert cavity > meshes.rubber.volume
    else:
        assert cavity == pytest.approx(plan.scale**3 * outline_volume(design.body), rel=1e-6)


def test_a_frame_slides_off_comb_and_legs_and_leaves_them(made):
    _, plan, meshes, _ = made
    parts = {part.name: part for part in meshes.parts}
    assert (parts["frame_front"].draw, parts["frame_back"].draw) == ((0, 0, 1), (0, 0, -1))
    assert parts["frame_front"].order == parts["frame_back"].order > parts[INSERT].order
    for side in plan.sides:
        if side.comb:
            comb = parts[side.comb]
            assert comb.order > parts[side.wall].order
            wide, high, _ = np.ptp(comb.vertices, axis=0)
            assert (wide, high) == pytest.approx(
                (2 * plan.half_width, plan.crest), rel=1e-4, abs=2e-2
            )


@pytest.mark.slow
@pytest.mark.parametrize("process", ["sla", "machined"])
def test_frames_of_a_rounded_block_have_no_sliver_next_to_their_windows(process, tmp_path):
    """Where a rounding ends upright, 0.2 micrometres of it stood as a wall of 1.46 mm."""
    design = with_values(load_design("block"), {"mold.process": process})
    plan = plan_mold(design)
    found = run_checks(plan, mold_meshes(plan, tmp_path, 120.0))
    assert [check.sentence for check in found if not check.ok] == []
