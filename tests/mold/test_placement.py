"""Plates off their places: the mesh that follows them, and what it does to the gages."""

import json

import numpy as np
import pytest

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.stages import zone_of
from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.errors import MeshError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mesh.moved import moved_frames, moved_mesh
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mold.placement import (
    placement_effect,
    readings,
    scene_for,
    section_plates,
    tolerances,
)
from fingerdesign.mold.plan.planning import plan_mold

SIZES = SectionMesh(
    contact_size_mm=0.1, plate_size_mm=0.1, plate_end_size_mm=0.04, far_size_mm=1.0, gradation=0.3
)
THREE = """
design.name = "three"
[body]
width_mm = 16.0
base_height_mm = 6.0
arc_radius_mm = 20.0
[plates]
count = 3
length_mm = 1.2
pitch_mm = 1.5
cover_mm = 1.2
[gages]
length_mm = 0.6
"""


@pytest.fixture(scope="module")
def three():
    return parse_design(THREE)


@pytest.fixture(scope="module")
def section(three):
    scene = scene_for(three)
    zone = zone_of(Case(three, scene, grips=False), scene)
    frames = plate_frames(three)
    return zone, scene, frames, mesh_section(three, zone.half_width, SIZES, frames)


def alike(x=0.0, y=0.0, turn=0.0):
    """A move of all three plates."""
    return np.tile([x, y, turn], (3, 1))


def test_a_move_carries_the_plates_and_leaves_the_outside(section):
    _, _, frames, mesh = section
    move = alike(0.04, -0.03, 5.0)
    moved, after = moved_mesh(mesh, frames, move), moved_frames(frames, move)
    for before, now in zip(frames, after, strict=True):
        nodes = np.unique(mesh.cells[mesh.regions == before.index + 1])
        assert now.local(moved.points[nodes]) == pytest.approx(before.local(mesh.points[nodes]))
    outside = np.unique(np.concatenate([f.ravel() for f in mesh.facets.values()]))
    assert (moved.points[outside] == mesh.points[outside]).all()
    middles = 0.5 * (moved.points[mesh.cells[:, 0]] + moved.points[mesh.cells[:, 1]])
    inner = ~np.isin(mesh.cells[:, 3], outside)
    assert moved.points[mesh.cells[inner, 3]] == pytest.approx(middles[inner])
    with pytest.raises(MeshError, match="of its area or volume"):  # driven into each other
        moved_mesh(mesh, frames, np.outer([0.9, 0.0, -0.9], [1.0, 0.0, 0.0]))


def test_one_plate_alone_is_carried_too():
    one = parse_design(THREE.replace("count = 3", "count = 1"))
    frames = plate_frames(one)
    mesh = mesh_section(one, 2.0, SIZES, frames)
    moved = moved_mesh(mesh, frames, np.array([[0.04, -0.03, 5.0]]))
    nodes = np.unique(mesh.cells[mesh.regions == 1])
    after = moved_frames(frames, np.array([[0.04, -0.03, 5.0]]))
    assert after[0].local(moved.points[nodes]) == pytest.approx(frames[0].local(mesh.points[nodes]))


def test_the_carried_mesh_reads_what_a_mesh_made_again_does(three, section):
    """Both are of the same moved finger; they differ by the mesh's own error."""
    zone, scene, frames, mesh = section
    right = readings(three, mesh, frames, zone, scene)
    move = alike(y=0.1, turn=4.0)
    after = moved_frames(frames, move)
    carried = readings(three, moved_mesh(mesh, frames, move), after, zone, scene)
    again = mesh_section(three, zone.half_width, SIZES, after)
    fresh = readings(three, again, after, zone, scene)
    scale = np.abs(right).max(axis=1, keepdims=True)
    assert np.abs((carried - right) / scale).max() > 0.08
    assert np.abs((carried - fresh) / scale).max() < 0.015


def test_the_effect_grows_with_the_tolerance_and_is_nil_without(three):
    def effect(tolerance):
        comb = {"mold.comb.tolerance_mm": tolerance, "mold.comb.clearance_mm": 0.0}
        design = with_values(three, comb)
        return placement_effect(design, plan_mold(design), SIZES)

    none, small, large = effect(0.0), effect(0.01), effect(0.02)
    assert none["reason"] is None
    assert none["together"]["worst"] == pytest.approx(0.0, abs=1e-9)
    assert 0.01 < small["tolerance_mm"] < 0.02  # and the bow of a plate whose legs are pushed
    for before, after in zip(small["changes"], large["changes"], strict=True):
        assert 0.0 < before["rms"] <= before["worst"] < 0.3
        assert max(before["rms_alike"], before["rms_opposed"]) <= before["rms"]
        assert after["rms"] == pytest.approx(2.0 * before["rms"], rel=0.15)
    sums = np.sqrt(sum(each["rms"] ** 2 for each in large["changes"]))
    assert large["together"]["rms"] == pytest.approx(sums)
    assert [each["plate"] for each in large["gages"]] == [0, 1, 2]
    assert json.loads(json.dumps(large, allow_nan=False)) == large
    # The insert rests on the combs: its face's form counts, and how true these are cut.
    assert (none["row"]["tolerance_mm"], large["row"]["tolerance_mm"]) == (0.05, 0.07)
    assert [each["largest"] for each in large["row"]["changes"]] == [0.02, 0.07]
    assert 0.0 < none["row"]["together"]["rms"] < none["row"]["together"]["worst"] < 1.0


def test_a_plate_that_is_off_alone_changes_no_more_than_is_reported(three, section):
    zone, scene, frames, mesh = section
    reported = placement_effect(three, plan_mold(three), SIZES)["gages"]
    right = readings(three, mesh, frames, zone, scene)
    most = np.abs(right).max(axis=1)
    off, angle = tolerances(plan_mold(three), 1)
    ways = zip(("along_x", "in_height", "turned"), np.diag([off, off, angle]), strict=True)
    for name, way in ways:
        move = np.outer([0.0, 1.0, 0.0], way)
        after = moved_frames(frames, move)
        found = readings(three, moved_mesh(mesh, frames, move), after, zone, scene)
        alone = (np.abs(found - right)[:, 1] / most).max()
        assert 0.3 * reported[1][name] < alone < 1.1 * reported[1][name]


def test_bent_plates_are_moved_as_they_are():
    bent = THREE.replace("[plates]\n", '[plates]\nfollow = "bent"\nangle_deg = 0.0\n')
    design = parse_design(bent)
    found = placement_effect(design, plan_mold(design), SIZES)
    assert found["reason"] is None
    assert 0.0 < found["together"]["worst"] < 0.5


@pytest.mark.parametrize(
    ("holding", "off", "slope"),
    [
        ("comb", 0.01 + 0.01, 0.01 / 1.22 + 0.02 / 1.2),  # its tolerance, half of its clearance
        ("slots", 0.1 + 0.025, 0.1 / 1.04 + 0.05 / 0.84),  # resin prints; pushed by hand
    ],
)
def test_what_holds_a_plate_says_how_far_it_may_be_off(three, holding, off, slope):
    values = {"mold.plate_fixture": holding, "mold.wire_mm": 0.0, "mold.pour": "closed"}
    design = with_values(three, {**values, "plates.angle_deg": 0.0, "plates.follow": "level"})
    found, angle = tolerances(plan_mold(design), 0)
    assert found == pytest.approx(off)
    assert np.tan(np.radians(angle)) == pytest.approx(slope)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("count = 0", "no plates"),
        ('count = 3\nalong = "z"\nspan_mm = 6.0', "rows along z"),
        ("count = 3\nspan_mm = 2.0\nspan_offset_mm = 2.5", "cuts no plate"),
    ],
)
def test_where_the_section_shows_no_plate_the_reason_is_reported(text, why):
    design = parse_design(THREE.replace("count = 3", text) + "width_mm = 0.5")
    assert why in section_plates(design)[1]
    found = placement_effect(design, None)
    assert why in found["reason"]
    assert why in found["sentences"][0]
