"""Every body and plate kind: what is sound, which key is blamed, and that its remedy mends it."""

import re

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fingerdesign.checks.design import (
    design_faults,
    is_sound,
    plane_strain_faults,
    tetwild_faults,
)
from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.design.schema import Body, Design
from fingerdesign.errors import DesignError
from fingerdesign.layout.clearance import surface_clearances
from fingerdesign.layout.frames import surface_height

QUICK = settings(max_examples=60, derandomize=True, deadline=None)
BODIES = {
    "arc": {},
    "deep": {"arc_radius_mm": 10.0, "base_height_mm": 20.0},
    "block": {"shape": "block"},
    "rounded": {"edge_radius_mm": 3.0},
    "chamfered": {"shape": "block", "edge_radius_mm": 3.0, "edge": "chamfer"},
    "dome": {"shape": "dome", "dome_radius_mm": 12.0, "edge_radius_mm": 1.0},
    "revolved": {"shape": "revolved", "edge_radius_mm": 2.0},
}


def design_of(**tables):
    return Design.model_validate({"design": {"name": "a"}, **tables})


def keys(**tables):
    design = design_of(**tables)
    found = [fault.key for fault in design_faults(design)]
    assert is_sound(design) == (not found)
    return found


def reported(lines):
    with pytest.raises(DesignError) as caught:
        parse_design(f'design.name = "a"\n{lines}')
    return {fault.key: fault for fault in caught.value.faults}


@pytest.mark.parametrize("name", BODIES)
@QUICK
@given(st.floats(-9.9, 9.9), st.floats(-4.9, 4.9), st.floats(0.1, 24))
def test_depth_below_the_surface_is_the_distance_to_its_points(name, x, z, y):
    body = Body(**BODIES[name])
    if body.shape == "revolved":
        assume(np.hypot(x, z) < 9.9)
    point = np.array([[x, y, z]])
    clear = surface_clearances(body, point)[0]
    grid = np.meshgrid(np.linspace(-10, 10, 401), np.linspace(-5, 5, 101), indexing="ij")
    if body.shape == "revolved":
        grid = np.meshgrid(np.linspace(-10, 10, 401), np.linspace(-10, 10, 401), indexing="ij")
    with np.errstate(invalid="ignore"):
        heights = surface_height(body, *grid)
    points = np.stack([grid[0], heights, grid[1]], axis=-1).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    nearest = float(np.linalg.norm(points - point, axis=1).min())
    assert (clear > 0) == (y < surface_height(body, x, z))
    if body.shape == "dome" and nearest > abs(clear) + 0.05:
        assert abs(z) + abs(clear) > 4.5  # continued beyond the end faces: never too great
    elif clear > 0:
        assert abs(nearest - clear) < 0.2 * (1 + (abs(x) > 9.0) * 3)  # steep at the sides: sparse
        assert clear <= nearest + 1e-9


def test_a_plate_below_the_centre_of_a_half_circle_is_inside():
    body = {"arc_radius_mm": 10.0, "base_height_mm": 20.0}
    for cover in (5.0, 15.0, 25.0, 29.0):
        assert keys(body=body, plates={"count": 3, "cover_mm": cover}) == []
    assert keys(body=body, plates={"count": 3, "cover_mm": 29.5}) == ["plates.cover_mm"]


def test_plates_of_a_pin_stay_in_its_round_section():
    pin = {"shape": "revolved", "width_mm": 16.0, "arc_radius_mm": 12.0}
    plates = {"count": 5, "cover_mm": 3.0}
    assert keys(body=pin, plates=plates) == ["plates.span_mm"]
    (fault,) = design_faults(design_of(body=pin, plates=plates))
    span = float(re.search(r"set plates.span_mm to at most ([0-9.]+)", fault.remedy).group(1))
    assert keys(body=pin, plates=plates | {"span_mm": span}) == []
    assert keys(body=pin, plates=plates | {"span_mm": span + 0.01}) != []


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ({"edge_radius_mm": 10.0}, "body.edge_radius_mm"),
        ({"shape": "block", "edge_radius_mm": 9.9, "base_height_mm": 5.0}, "body.edge_radius_mm"),
        ({"arc_radius_mm": 10.0, "edge_radius_mm": 1.0}, "body.edge_radius_mm"),
        ({"edge": "chamfer", "edge_radius_mm": 10.0}, "body.edge_radius_mm"),
        ({"core": {"width_mm": 19.9}}, "body.core.width_mm"),
        ({"core": {"width_mm": 30.0}}, "body.core.width_mm"),
        ({"core": {"depth_mm": 11.0}}, "body.core.depth_mm"),
        ({"core": {"bottom_mm": 0.05}}, "body.core.bottom_mm"),
        ({"core": {"width_mm": 20.0, "bottom_mm": 2.0}}, "body.core.bottom_mm"),
        ({"core": {"height_mm": 12.6}}, "body.core.height_mm"),
        ({"shape": "block", "core": {"height_mm": 9.95}}, "body.core.height_mm"),
        ({"shape": "revolved", "core": {"width_mm": 8.0}}, "body.core.depth_mm"),
        (
            {"shape": "revolved", "core": {"width_mm": 19.0, "depth_mm": 8.0}},
            "body.core.width_mm",
        ),
        ({"shape": "dome", "dome_radius_mm": 7.0, "edge_radius_mm": 1.0}, "body.dome_radius_mm"),
    ],
)
def test_bodies_that_cannot_be(body, expected):
    assert keys(body=body, plates={"count": 0}) == [expected]


@pytest.mark.parametrize(
    "body",
    [
        {"core": {"width_mm": 20.0}},
        {"core": {"depth_mm": 10.0, "height_mm": 5.0}},
        {"core": {"bottom_mm": 1.0, "depth_mm": 6.0}},
        {"shape": "revolved", "core": {"width_mm": 8.0, "depth_mm": 8.0}},
        {"shape": "dome", "dome_radius_mm": 25.0, "edge_radius_mm": 2.0},
        {"shape": "block", "edge_radius_mm": 5.0, "edge": "chamfer"},
        {"arc_radius_mm": 10.0, "edge_radius_mm": 1.0, "edge": "chamfer"},
    ],
)
def test_bodies_that_can_be(body):
    assert keys(body=body, plates={"count": 0}) == []


FINITE = {"count": 5, "span_mm": 4.0}
ALONG_Z = {"along": "z", "count": 3, "cover_mm": 4.5}


@pytest.mark.parametrize(
    ("plates", "expected"),
    [
        (FINITE | {"span_offset_mm": 3.5}, "plates.span_offset_mm"),
        (FINITE | {"stagger_mm": 6.5}, "plates.stagger_mm"),
        ({"count": 5, "stagger_mm": 1.0}, "plates.stagger_mm"),
        (FINITE | {"offset_mm": 8.0}, "plates.offset_mm"),
        (FINITE | {"along": "z", "cover_mm": 4.0, "pitch_mm": 3.0}, "plates.pitch_mm"),
        (ALONG_Z | {"span_mm": 20.1}, "plates.span_mm"),
        ({"follow": "bent", "count": 3}, "plates.angle_deg"),
        ({"follow": "turned", "pitch_mm": 3.0}, "plates.pitch_mm"),
        ({"follow": "bent", "angle_deg": 0.0, "count": 3, "pitch_mm": 1.5}, "plates.pitch_mm"),
        ({"hole_diameter_mm": 1.9}, "plates.hole_diameter_mm"),
        ({"hole_diameter_mm": 0.6, "hole_pitch_mm": 0.65}, "plates.hole_pitch_mm"),
        ({"hole_diameter_mm": 0.6, "hole_pitch_mm": 1.5}, "plates.hole_pitch_mm"),
        ({"hole_diameter_mm": 0.6, "span_mm": 2.0}, "plates.hole_pitch_mm"),
        ({"rows": [{"cover_mm": 2.5}]}, "plates.rows[0].cover_mm"),
        ({"rows": [{}]}, "plates.rows[0].cover_mm"),
        ({"rows": [{"cover_mm": 5.0, "pitch_mm": 2.0}]}, "plates.rows[0].pitch_mm"),
        ({"rows": [{"cover_mm": 13.0}]}, "plates.rows[0].cover_mm"),
        ({"rows": [{"cover_mm": 5.0, "length_mm": 0.3}]}, "plates.rows[0].length_mm"),
        ({"count": 5, "rows": [ALONG_Z | {"cover_mm": 3.5}]}, "plates.rows[0].cover_mm"),
        ({"span_mm": 4.0, "placement": [(0, 8, 45, 3.5)]}, "plates.placement[0]"),
        ({"model": "sheet", "hole_diameter_mm": 0.6}, "plates.model"),
    ],
)
def test_plates_that_cannot_be_are_blamed_on_their_own_key(plates, expected):
    found = keys(plates=plates, gages={"length_mm": 0.2})
    assert set(found) == {expected}


@pytest.mark.parametrize(
    "plates",
    [
        FINITE | {"span_offset_mm": 2.5, "stagger_mm": 0.5},
        FINITE | {"offset_mm": -2.0},
        ALONG_Z | {"span_mm": 12.0, "angle_deg": 0.0, "pitch_mm": 2.5},
        {"follow": "turned"},
        {"follow": "bent", "angle_deg": 0.0, "count": 3, "pitch_mm": 3.0},
        {"hole_diameter_mm": 0.6},
        {"rows": [{"cover_mm": 5.0}, {"cover_mm": 8.0, "follow": "turned"}]},
        {"count": 5, "rows": [ALONG_Z]},
        {"span_mm": 4.0, "placement": [(0, 8, 45, 2.5), (0, 8, 45, -2.5)]},
        {"model": "sheet", "span_mm": 6.0},
    ],
)
def test_plates_that_can_be(plates):
    assert keys(plates=plates) == []


@QUICK
@given(
    st.sampled_from(["arc", "block", "rounded", "chamfered", "dome"]),
    st.floats(0.05, 3.0),
    st.sampled_from(["level", "turned"]),
    st.floats(-80, 80),
)
def test_following_the_cover_remedy_mends_every_body(name, cover, follow, angle):
    body = BODIES[name]
    plates = {"count": 5, "pitch_mm": 3.4, "angle_deg": angle, "follow": follow, "span_mm": 6.0}
    design = design_of(body=body, plates=plates | {"cover_mm": cover})
    found = [fault for fault in design_faults(design) if fault.key == "plates.cover_mm"]
    assume(found)
    value = re.search(r"raise plates.cover_mm to at least ([0-9.]+)", found[0].remedy)
    assert value is not None
    assert with_values(design, {"plates.cover_mm": float(value.group(1))})


def test_a_remedy_that_would_bring_another_fault_is_not_reported():
    (fault,) = design_faults(design_of(body={"base_height_mm": 0.5}, plates={"cover_mm": 0.5}))
    assert fault.key == "plates.cover_mm"
    assert "raise plates.cover_mm" not in fault.remedy


def test_the_core_in_the_plates_way_may_be_lowered():
    plates = {"count": 5, "cover_mm": 4.0}
    found = design_faults(design_of(body={"core": {"height_mm": 9.0}}, plates=plates))
    assert [fault.key for fault in found] == ["plates.cover_mm"]
    height = float(re.search(r"body.core.height_mm to at most ([0-9.]+)", found[0].remedy).group(1))
    assert keys(body={"core": {"height_mm": height}}, plates=plates) == []


def test_faults_of_several_rows_at_once():
    lines = "plates.rows = [{ cover_mm = -1 }, { cover_mm = 8.0, pitch_mm = -1 }]"
    assert set(reported(lines)) == {"plates.rows[0].cover_mm", "plates.rows[1].pitch_mm"}
    lines = "plates.rows = [{ cover_mm = 6.0 }, { cover_mm = 8.0, pitch_mm = 0.05 }]"
    assert set(reported(lines)) == {"plates.rows[1].pitch_mm"}
    assert set(reported("plates.rows = [{ cuont = 3 }]")) == {"plates.rows[0].cuont"}


def test_what_plane_strain_cannot_show():
    assert plane_strain_faults(design_of()) == []
    across = plane_strain_faults(design_of(plates={"count": 5, "rows": [ALONG_Z]}))
    assert [fault.key for fault in across] == ["plates.rows[0].along"]
    missed = design_of(plates=FINITE | {"span_mm": 2.0, "stagger_mm": 4.0})
    assert [fault.key for fault in plane_strain_faults(missed)] == ["plates.stagger_mm"]


def test_a_sheet_in_the_symmetry_plane_needs_the_whole_finger():
    upright = {"along": "z", "angle_deg": 90.0, "count": 1, "cover_mm": 4.0, "span_mm": 8.0}
    design = design_of(plates=upright | {"model": "sheet"})
    assert design_faults(design) == []
    assert tetwild_faults(design, symmetric=False) == []
    assert [fault.key for fault in tetwild_faults(design, symmetric=True)] == ["plates.model"]


def test_rows_are_set_and_changed_by_their_keys():
    design = with_values(parse_design('design.name = "a"'), {"plates.rows[0].cover_mm": 5.0})
    assert design.plates.number == 30
    moved = with_values(design, {"plates.rows[0].cover_mm": 6.0, "body.core.width_mm": 4.0})
    assert (moved.plates.rows[0].cover_mm, moved.body.core.width_mm) == (6.0, 4.0)
    assert with_values(moved, {"plates.rows[0]": None}).plates.number == 15
    for wrong in ("plates.rows[2].cover_mm", "plates.rows.cover_mm", "plates.count[0]"):
        with pytest.raises(DesignError) as caught:
            with_values(design, {wrong: 1.0})
        assert caught.value.faults[0].key.startswith("plates")


def test_rows_that_leave_the_surface_are_refused_not_searched_for_ever():
    """A place beyond the surface has no height: no remedy can be sought there."""
    rows = [{"along": "z", "follow": "bent", "angle_deg": 0.0, "pitch_mm": 9.0, "count": 5}]
    found = keys(plates={"follow": "turned", "pitch_mm": 9.0, "rows": rows})
    assert {"plates.pitch_mm", "plates.rows[0].pitch_mm"} <= set(found)
