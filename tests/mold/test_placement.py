"""Plates off their places: what it does to the gages."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.stages import zone_of
from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mold.placement import (
    place_slopes,
    placement_effect,
    row_tolerances,
    scene_for,
    section_plates,
    tolerances,
)
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.products.notes import percent, placement_worst

SIZES = SectionMesh(
    contact_size_mm=0.1, plate_size_mm=0.1, plate_end_size_mm=0.04, far_size_mm=1.0, gradation=0.3
)
UNITS = ((0, "mm"), (0, "mm"), (1, "degrees"))  # of changes, with their tolerance
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
    case = Case(three, scene_for(three), "plane-strain", grips=False, fields=False)
    zone = zone_of(case, case.path_scene)
    frames = plate_frames(three)
    return case, zone, frames, place_slopes(case, frames, zone, SIZES)


def moved(frames, move):
    """Plates after a move (k, 3): along x and y, mm, and by an angle, degrees."""
    return tuple(
        replace(frame, place=frame.place + x, y=frame.y + y, angle_deg=frame.angle_deg + turn)
        for frame, (x, y, turn) in zip(frames, move, strict=True)
    )


def test_slopes_say_what_a_mesh_of_the_moved_finger_reads(section):
    """By as much as two meshes of one finger differ, 0.015 of the largest (measured before)."""
    case, zone, frames, found = section
    move = np.array([[0.02, 0.03, -1.5], [-0.02, 0.03, 1.5], [0.02, 0.03, -1.5]])
    fresh = place_slopes(case, moved(frames, move), zone, SIZES).readings.reading
    right = found.readings.reading
    scale = np.abs(right).max(axis=1, keepdims=True)
    changed, linear = (fresh - right) / scale, found.reading @ move.T.ravel() / scale
    assert np.abs(changed).max() > 0.08
    assert np.abs(linear - changed).max() < 0.015


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


@pytest.fixture(scope="module")
def reported(three):
    return placement_effect(three, plan_mold(three), SIZES)


def test_the_spread_is_that_of_fingers_drawn_by_the_linear_model(three, section, reported):
    _, _, frames, found = section
    plan, chance = plan_mold(three), np.random.default_rng(3)
    off = np.array([tolerances(plan, frame.index) for frame in frames])[:, [0, 0, 1]].T
    ways = chance.uniform(-1.0, 1.0, (4000, *off.shape)) * off
    ways[:, :2] += chance.uniform(-1.0, 1.0, (4000, 2, 1)) * np.array(row_tolerances(plan))[:, None]
    most = np.abs(found.readings.reading).max(axis=1)[:, None]
    drawn = np.einsum("rgp,np->nrg", found.reading, ways.reshape(4000, -1)) / most
    assert reported["std"] == pytest.approx(np.sqrt(drawn.var(axis=0).mean()), rel=0.04)
    assert f"by up to {percent(placement_worst(reported))} " in reported["sentences"][0]
    assert any(f"scatter by {percent(reported['std'])}" in each for each in reported["sentences"])


def test_a_plate_that_is_off_alone_changes_no_more_than_is_reported(three, section, reported):
    _, _, _, found = section
    most = np.abs(found.readings.reading).max(axis=1)
    off, angle = tolerances(plan_mold(three), 1)
    for k, (name, way) in enumerate(
        zip(("along_x", "in_height", "turned"), (off, off, angle), strict=True)
    ):
        alone = (np.abs(way * found.reading[:, 1, 3 * k + 1]) / most).max()
        assert 0.3 * reported["gages"][1][name] < alone < 1.1 * reported["gages"][1][name]


def test_each_number_of_the_effect_is_the_worst_or_the_mean_of_the_plates_own(three, reported):
    gages, changes = reported["gages"], reported["changes"]
    for each in (*changes, {**reported["together"], "name": "together"}):
        own = [gage[each["name"]] for gage in gages]
        assert each["worst"] == pytest.approx(max(own))
        assert each["worst_plate"] == int(np.argmax(own))
    plan = plan_mold(three)
    off = np.max([tolerances(plan, k) for k in range(3)], axis=0)
    largest = [(each["largest"], each["unit"]) for each in changes]
    assert largest == [(pytest.approx(off[k], abs=1e-6), u) for k, u in UNITS]
    assert (reported["tolerance_mm"], reported["angle_deg"]) == pytest.approx(tuple(off), abs=1e-6)
    assert [gage["x_mm"] for gage in gages] == [-1.5, 0.0, 1.5]
    crest = 6.0 + 20.0 - np.sqrt(20.0**2 - 8.0**2)
    assert gages[1]["surface_mm"] == pytest.approx(crest - plate_frames(three)[1].y, abs=1e-4)
    # The fundamental case's share of the height; half of it first, then sheared in two steps.
    motions = 0.1 / 8.22 * crest * np.array([[0.5, 0.0], [1.0, 0.0], [1.0, 0.4], [1.0, 0.8]])
    assert np.array(reported["increments_mm"]) == pytest.approx(motions, abs=1e-5)


@pytest.mark.slow
def test_the_effect_in_space_is_as_large(three, reported):
    """Half a model in 3-D, with gages' leads: as large as in plane strain, within a factor of two
    (free ends and leads)."""
    leads = "[gages.leads]\ndiameter_mm = 0.02\n"
    coarse = {"mesh.contact_size_mm": 1.2, "mesh.plate_size_mm": 0.8}
    design = with_values(parse_design(THREE + leads), coarse)
    found = placement_effect(design, plan_mold(design), fidelity="3d")
    assert found["reason"] is None
    assert found["fidelity"] == "3d"
    assert 0.5 < found["together"]["rms"] / reported["together"]["rms"] < 2.0


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
        ("count = 3\nspan_mm = 2.0\nspan_offset_mm = -1.0", "cuts no plate"),  # it ends there
    ],
)
def test_where_the_section_shows_no_plate_the_reason_is_reported(text, why):
    design = parse_design(THREE.replace("count = 3", text) + "width_mm = 0.5")
    assert why in section_plates(design)[1]
    found = placement_effect(design, None)
    assert why in found["reason"]
    assert why in found["sentences"][0]
