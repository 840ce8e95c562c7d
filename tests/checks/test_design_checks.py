"""Bodies and plates: what is sound, which one key is blamed, and that its remedy mends it."""

import re
import time
from copy import deepcopy

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fingerdesign.checks.design import design_faults, is_sound
from fingerdesign.checks.load import judge_data, load_design, parse_design, with_values
from fingerdesign.checks.meshing import plane_strain_faults, tetwild_faults
from fingerdesign.checks.spacing import LEAST_GAP
from fingerdesign.design.io import design_data
from fingerdesign.design.keys import set_value
from fingerdesign.design.schema import Body, Design
from fingerdesign.errors import DesignError
from fingerdesign.layout.bodies import surface_height
from fingerdesign.layout.clearance import LEAST_CLEARANCE_MM, surface_clearances
from tests.support.faults import faults_of

QUICK = settings(max_examples=25, derandomize=True, deadline=None)
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


def test_a_design_whose_mesh_file_is_absent_is_not_sound(tmp_path):
    assert keys(mesh={"mesher": "file", "file": str(tmp_path / "absent.msh")}) == ["mesh.file"]


def remedy_value(fault, words):
    return float(re.search(re.escape(words) + r" ([-0-9.]+)", fault.remedy).group(1))


@pytest.mark.parametrize("name", BODIES)
@QUICK
@given(st.floats(-9.9, 9.9), st.floats(-4.9, 4.9), st.floats(0.1, 24))
def test_depth_below_the_surface_is_the_distance_to_its_points(name, x, z, y):
    body = Body(**BODIES[name])
    if body.shape == "revolved":
        assume(np.hypot(x, z) < 9.9)
    point = np.array([[x, y, z]])
    clear = surface_clearances(body, point)[0]
    deep = 10 if body.shape == "revolved" else 5
    grid = np.meshgrid(np.linspace(-10, 10, 401), np.linspace(-deep, deep, 201), indexing="ij")
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


def test_plates_of_a_pin_stay_in_its_round_section():
    pin = {"shape": "revolved", "width_mm": 16.0, "arc_radius_mm": 12.0}
    plates = {"count": 5, "cover_mm": 3.0}
    assert keys(body=pin, plates=plates) == ["plates.span_mm"]
    (fault,) = design_faults(design_of(body=pin, plates=plates))
    span = remedy_value(fault, "set plates.span_mm to at most")
    assert keys(body=pin, plates=plates | {"span_mm": span}) == []
    assert keys(body=pin, plates=plates | {"span_mm": span + 0.01}) != []


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ({"edge_radius_mm": 10.0}, "body.edge_radius_mm"),
        ({"shape": "block", "edge_radius_mm": 9.9, "base_height_mm": 5.0}, "body.edge_radius_mm"),
        ({"arc_radius_mm": 10.0, "edge_radius_mm": 1.0}, "body.edge_radius_mm"),
        ({"edge": "chamfer", "edge_radius_mm": 10.0}, "body.edge_radius_mm"),
        ({"core": {"width_mm": 30.0}}, "body.core.width_mm"),
        ({"core": {"depth_mm": 11.0}}, "body.core.depth_mm"),
        ({"core": {"bottom_mm": 0.05}}, "body.core.bottom_mm"),
        ({"core": {"width_mm": 20.0, "bottom_mm": 2.0}}, "body.core.bottom_mm"),
        ({"core": {"height_mm": 12.6}}, "body.core.height_mm"),
        ({"shape": "block", "core": {"height_mm": 9.95}}, "body.core.height_mm"),
        ({"shape": "revolved", "core": {"width_mm": 8.0}}, "body.core.depth_mm"),
        ({"shape": "revolved", "core": {"width_mm": 19, "depth_mm": 8}}, "body.core.width_mm"),
        ({"shape": "dome", "dome_radius_mm": 7.0, "edge_radius_mm": 1.0}, "body.dome_radius_mm"),
        ({"core": {"width_mm": 20.0}}, None),
        ({"core": {"depth_mm": 10.0, "height_mm": 5.0}}, None),
        ({"core": {"bottom_mm": 1.0, "depth_mm": 6.0}}, None),
        ({"shape": "revolved", "core": {"width_mm": 8.0, "depth_mm": 8.0}}, None),
        ({"shape": "dome", "dome_radius_mm": 25.0, "edge_radius_mm": 2.0}, None),
        ({"shape": "block", "edge_radius_mm": 5.0, "edge": "chamfer"}, None),
        ({"arc_radius_mm": 10.0, "edge_radius_mm": 1.0, "edge": "chamfer"}, None),
    ],
)
def test_bodies_that_can_and_cannot_be(body, expected):
    assert keys(body=body, plates={"count": 0}) == [expected] * (expected is not None)


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


def test_following_the_remedy_of_a_wide_pitch_of_holes_leaves_a_hole():
    plates = {"hole_diameter_mm": 0.6, "span_mm": 4.0, "hole_pitch_mm": 3.0}
    (fault,) = design_faults(design_of(plates=plates, gages={"length_mm": 0.2}))
    assert fault.remedy == "lower it to at most 2.2"  # 4 mm less 1.5 diameters at either end
    plates |= {"hole_pitch_mm": 2.2}
    assert design_faults(design_of(plates=plates, gages={"length_mm": 0.2})) == []


def test_the_plate_farthest_out_of_a_round_section_is_named():
    body = {"shape": "revolved", "width_mm": 12.0}
    plates = {"count": 3, "pitch_mm": 4.5, "offset_mm": 1.0, "span_mm": 6.0, "cover_mm": 3.0}
    bounds = [fault.bound for fault in design_faults(design_of(body=body, plates=plates))]
    assert any("plate 2 reaches" in bound for bound in bounds), bounds


@pytest.mark.slow
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
    value = remedy_value(found[0], "raise plates.cover_mm to at least")
    assert with_values(design, {"plates.cover_mm": value})
    with pytest.raises(DesignError, match="cover_mm"):
        with_values(design, {"plates.cover_mm": value - 0.01})


def test_the_core_in_the_plates_way_may_be_lowered():
    plates = {"count": 5, "cover_mm": 4.0}
    found = design_faults(design_of(body={"core": {"height_mm": 9.0}}, plates=plates))
    assert [fault.key for fault in found] == ["plates.cover_mm"]
    height = remedy_value(found[0], "body.core.height_mm to at most")
    assert keys(body={"core": {"height_mm": height}}, plates=plates) == []


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ("{ cover_mm = -1 }, { pitch_mm = -1 }", {"rows[0].cover_mm", "rows[1].pitch_mm"}),
        ("{ cover_mm = 6.0 }, { cover_mm = 8.0, pitch_mm = 0.05 }", {"rows[1].pitch_mm"}),
        ("{ cuont = 3 }", {"rows[0].cuont"}),
    ],
)
def test_faults_of_several_rows_at_once(rows, expected):
    found = faults_of(f'design.name = "a"\nplates.rows = [{rows}]')
    assert set(found) == {f"plates.{key}" for key in expected}


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


@pytest.mark.parametrize("count", [40, 90])
def test_too_many_plates_are_too_many_where_no_pitch_fits_them(count):
    """The pitch that keeps 90 plates inside the sides would let them cross."""
    design = design_of(plates={"count": count, "pitch_mm": 1.0, "cover_mm": 3.0})
    (words,) = {each.remedy for each in design_faults(design) if "inside |x|" in each.bound}
    assert "lower plates.count to at most" in words
    assert "inward" not in words


@pytest.mark.parametrize("name", ["maeno2000", "domed", "pin"])
def test_remedies_that_are_followed_together_need_no_second_round(name):
    data = design_data(load_design(name))
    data["plates"] |= {"cover_mm": 0.05, "pitch_mm": 0.2}
    faults = judge_data(data).faults
    assert {fault.key for fault in faults} == {"plates.cover_mm", "plates.pitch_mm"}
    for fault in faults:
        key, value = next(iter(fault.mends.items()))
        set_value(data, key, value)
        assert f"{value:g}" in fault.remedy
    assert not judge_data(data).faults


def test_a_remedy_that_would_bring_another_fault_is_not_reported():
    (fault,) = design_faults(design_of(body={"base_height_mm": 0.5}, plates={"cover_mm": 0.5}))
    assert fault.key == "plates.cover_mm"
    assert "raise plates.cover_mm" not in fault.remedy


ROWS = {"rows": [{"along": "z", "count": 3, "cover_mm": 6.0}]}
OVER = {"span_mm": 2.0, "placement": [(0, 8, 45, -2.0), (0, 8, -45, 2.0)]}
DOME = {"shape": "dome", "dome_radius_mm": 25.0, "depth_mm": 14.0}


@pytest.mark.parametrize(
    ("tables", "expected"),
    [
        ({}, []),
        ({"body": DOME, "plates": {"span_mm": 8.0}}, []),
        ({"body": {"arc_radius_mm": 9.9}}, ["body.arc_radius_mm"]),
        ({"body": DOME | {"dome_radius_mm": 8.0}}, ["body.dome_radius_mm"]),
        ({"plates": {"cover_mm": 0.5}}, ["plates.cover_mm"]),
        ({"plates": {"cover_mm": 12.0}}, ["plates.cover_mm"]),
        ({"plates": {"pitch_mm": 1.4}}, ["plates.pitch_mm"]),
        ({"plates": {"pitch_mm": 0.1}}, ["plates.pitch_mm"]),
        ({"plates": {"pitch_mm": 200.0}}, ["plates.pitch_mm"]),
        ({"plates": {"length_mm": 0.39}, "gages": {"length_mm": 0.2}}, ["plates.length_mm"]),
        ({"plates": {"span_mm": 10.1}}, ["plates.span_mm"]),
        ({"plates": {"span_mm": 9.9}}, ["plates.span_mm"]),
        ({"gages": {"length_mm": 2.1}}, ["gages.length_mm"]),
        ({"gages": {"width_mm": 10.1}}, ["gages.width_mm"]),
        ({"gages": {"z_mm": -4.6}}, ["gages.z_mm"]),
        ({"plates": {"span_mm": 4.0}, "gages": {"z_mm": 1.6}}, ["gages.z_mm"]),
        ({"plates": {"count": 1, "length_mm": 40.0, "angle_deg": 0.0}}, ["plates.length_mm"]),
        ({"plates": {"placement": [(0, 10, 45), (0.1, 10, -45)]}}, ["plates.placement[1]"]),
        ({"plates": {"placement": [(0, 12.5, 45)]}}, ["plates.placement[0]"]),
        ({"plates": {"placement": [(0, 0.5, 45)]}}, ["plates.placement[0]"]),
        ({"plates": {"placement": [(9.8, 5, 45)]}}, ["plates.placement[0]"]),
        ({"mesh": {"mesher": "sweep"}, "plates": {"span_mm": 8.0}}, []),
        ({"mesh": {"mesher": "sweep"}, "plates": {"hole_diameter_mm": 0.6}}, ["mesh.mesher"]),
        ({"mesh": {"mesher": "sweep"}, "plates": ROWS}, ["mesh.mesher"]),
        ({"mesh": {"mesher": "sweep"}, "plates": OVER}, ["mesh.mesher"]),
        ({"mesh": {"mesher": "sweep"}, "body": DOME, "plates": {"span_mm": 8}}, ["mesh.mesher"]),
        ({"plates": {"count": 0, "cover_mm": 0.5}, "gages": {"length_mm": 50.0}}, []),
        ({"mesh": {"contact_size_mm": 3.0}}, ["mesh.contact_size_mm"]),
        ({"mesh": {"section": {"contact_size_mm": 3.0}}}, ["mesh.section.contact_size_mm"]),
        ({"plates": FINITE | {"span_offset_mm": 2.5, "stagger_mm": 0.5}}, []),
        ({"plates": FINITE | {"offset_mm": -2.0}}, []),
        ({"plates": ALONG_Z | {"span_mm": 12.0, "angle_deg": 0.0, "pitch_mm": 2.5}}, []),
        ({"plates": {"follow": "turned"}}, []),
        ({"plates": {"follow": "bent", "angle_deg": 0.0, "count": 3, "pitch_mm": 3.0}}, []),
        ({"plates": {"hole_diameter_mm": 0.6}}, []),
        ({"plates": {"rows": [{"cover_mm": 5.0}, {"cover_mm": 8.0, "follow": "turned"}]}}, []),
        ({"plates": {"count": 5, "rows": [ALONG_Z]}}, []),
        ({"plates": {"span_mm": 4.0, "placement": [(0, 8, 45, 2.5), (0, 8, 45, -2.5)]}}, []),
        ({"plates": {"model": "sheet", "span_mm": 6.0}}, []),
        *(
            ({"body": BODIES["deep"], "plates": {"count": 3, "cover_mm": cover}}, fault)
            for cover, fault in ((5.0, []), (29.0, []), (29.5, ["plates.cover_mm"]))
        ),
        # The dome thins the cover at the plates' ends.
        ({"body": {"depth_mm": 14.0}, "plates": {"cover_mm": 1.6, "span_mm": 13.0}}, []),
        ({"body": DOME, "plates": {"cover_mm": 1.6, "span_mm": 13.0}}, ["plates.cover_mm"]),
        ({"body": DOME, "plates": {"cover_mm": 1.6, "span_mm": 4.0}}, []),
    ],
)
def test_one_cause_is_one_fault_on_its_key(tables, expected):
    assert keys(**tables) == expected


def test_plates_are_at_the_surface_and_at_each_other_to_a_micrometre():
    # One flat plate under the crest: its upper corners at +-1 mm are nearest to the arc.
    exact = 20.0 - np.sqrt((20.0 - LEAST_CLEARANCE_MM) ** 2 - 1.0) + 0.05
    for off, expected in ((1e-3, []), (-1e-3, ["plates.cover_mm"])):
        plates = {"count": 1, "angle_deg": 0.0, "cover_mm": exact + off}
        assert keys(plates=plates) == expected
    for off, expected in ((1e-6, []), (-1e-6, ["plates.placement[1]"])):
        apart = 0.1 + LEAST_GAP * 0.1 + off
        assert keys(plates={"placement": [(0, 8, 90), (apart, 8, 90)]}) == expected


@pytest.mark.slow
@QUICK
@given(st.floats(0.02, 0.14), st.floats(30, 150))
def test_following_the_pitch_remedy_ends_the_fault(pitch, angle):
    plates = {"count": 7, "pitch_mm": pitch, "angle_deg": angle, "cover_mm": 3.0}
    found = design_faults(design_of(plates=plates))
    assume(found)
    value = remedy_value(found[0], "plates.pitch_mm to at least")
    assert keys(plates=plates | {"pitch_mm": value}) == []
    assert keys(plates=plates | {"pitch_mm": value - 0.01}) == ["plates.pitch_mm"]


@pytest.mark.parametrize(
    ("key", "words", "tables"),
    [
        ("width_mm", "body.width_mm to at least", {"plates": {"pitch_mm": 1.4}}),
        ("pitch_mm", "lower it to at most", {"plates": {"pitch_mm": 1.4}}),
        ("base_height_mm", "body.base_height_mm to at least", {"plates": {"cover_mm": 12.0}}),
        ("cover_mm", "plates.cover_mm to at most", {"plates": {"cover_mm": 12.0}}),
        ("dome_radius_mm", "raise it to at least", {"body": DOME | {"dome_radius_mm": 8.0}}),
    ],
)
def test_other_remedies_end_their_fault(key, words, tables):
    (fault,) = design_faults(design_of(**tables))
    value = remedy_value(fault, words)
    table = "plates" if key in ("pitch_mm", "cover_mm") else "body"
    mended = {**tables, table: {**tables.get(table, {}), key: value}}
    left = keys(**mended)
    assert fault.key not in left


@pytest.mark.slow
@QUICK
@given(st.floats(-60, 60), st.floats(0.3, 2.5), st.floats(0.2, 4.0))
def test_a_mirrored_finger_is_as_sound(angle, pitch, cover):
    def of(degrees):
        return keys(plates={"count": 6, "angle_deg": degrees, "pitch_mm": pitch, "cover_mm": cover})

    assert of(angle) == of(-angle)


def test_many_plates_are_judged_fast():
    start = time.perf_counter()
    assert "plates.pitch_mm" in keys(plates={"count": 500, "pitch_mm": 0.01})
    assert time.perf_counter() - start < 5.0  # half a second here; no CAD kernel, no 14 lines


def test_a_length_of_slide_without_inertia_is_refused_not_passed_over():
    found = faults_of('design.name = "a"\ngrip.plant = "lift"\ngrip.drop_mm = 5.0\n')
    assert list(found) == ["grip.drop_mm"]
    assert "grip.inertia = true" in found["grip.drop_mm"].remedy
    parse_design('design.name = "a"\ngrip.drop_mm = 10.0\n')
    lift = 'grip.plant = "lift"\ngrip.inertia = true'
    parse_design(f'design.name = "a"\n{lift}\ngrip.drop_mm = 5.0\n')


@pytest.mark.parametrize("value", ["1e-308", "5e-324", "1e-20"])
@pytest.mark.parametrize(
    "key", ["grip.object_mass_g", "grip.friction_coefficients", "grip.max_approach_mm"]
)
def test_values_next_to_zero_are_refused(key, value):
    value = f"[{value}]" if key.endswith("coefficients") else value
    with pytest.raises(DesignError, match="at least"):
        parse_design(f'design.name = "a"\n{key} = {value}\n')


NONE = {"count": 0}
CHAMFER = {"edge": "chamfer", "base_height_mm": 5.0}
CORED = {"shape": "revolved", "core": {"width_mm": 19.0, "depth_mm": 8.0}}
BENT = {"follow": "bent", "angle_deg": 0.0, "count": 1, "length_mm": 10.0, "cover_mm": 15.0}
SMALL_GAGE = {"length_mm": 0.2, "width_mm": 0.05}
DEEP = {"height_mm": 11.6, "bottom_mm": 1.0}
ROWED = {"rows": [{"cover_mm": 5.0, "length_mm": 1.0, "span_mm": 1.0}]}
WIDE = {"hole_diameter_mm": 0.6, "hole_pitch_mm": 1.5}
SHIFTED = {"count": 5, "span_mm": 4.0}
COVERED = {"body": {"core": {"height_mm": 9.0}}, "plates": {"count": 5, "cover_mm": 4.0}}
SLOW = {"actuator_lag_s": 6.0, "delay_samples": 50}
# Of a fault: the design, the key to change, the last value that mends, and one just beyond.
MENDS = [
    ({"body": {"arc_radius_mm": 9.0}}, "body.width_mm", 18.0, 18.002),
    ({"body": {"core": DEEP}}, "body.core.height_mm", 11.173, 11.175),
    ({"plates": {"pitch_mm": 1.4}}, "plates.count", 14, 15),
    ({"plates": WIDE | {"hole_diameter_mm": 1.9}}, "plates.hole_diameter_mm", 1.8, 1.802),
    ({"body": CORED}, "body.core.width_mm", 18.111, 18.113),
    ({"body": CHAMFER | {"edge_radius_mm": 9.99}}, "body.edge_radius_mm", 4.9, 4.902),
    ({"body": CHAMFER | {"edge_radius_mm": 9.0}}, "body.base_height_mm", 9.1, 9.098),
    ({"plates": {"length_mm": 0.39}}, "plates.thickness_mm", 0.097, 0.098),
    ({"body": {"base_height_mm": 20.0}, "plates": BENT}, "plates.cover_mm", 13.633, 13.635),
    ({"plates": WIDE, "gages": {"length_mm": 0.2}}, "plates.hole_pitch_mm", 1.6, 1.598),
    ({"plates": ROWED, "gages": {"width_mm": 1.2}}, "plates.rows[0].span_mm", 1.2, 1.198),
    ({"plates": ROWED, "gages": {"length_mm": 1.5}}, "plates.rows[0].length_mm", 1.5, 1.498),
    ({"plates": {"span_mm": 4.0}, "gages": {"z_mm": 1.6}}, "gages.z_mm", 1.5, 1.502),
    ({"plates": SHIFTED | {"offset_mm": -8.0}}, "plates.offset_mm", -7.157, -7.159),
    (COVERED, "plates.cover_mm", 2.736, 2.738),
    ({"grip": {"hardware": {"stage_step_mm": 0.01}}}, "grip.hardware.stage_step_mm", 15e-4, 16e-4),
    ({"grip": {"hardware": SLOW}}, "grip.hardware.actuator_lag_s", 5.0, 5.01),
    ({"grip": {"plant": "lift", "warming_K": -150.0}}, "grip.warming_K", -66.6, -66.8),
]


@pytest.mark.parametrize(("tables", "key", "mends", "fails"), MENDS)
def test_a_remedy_is_the_last_value_that_mends(tables, key, mends, fails):
    data = {"gages": SMALL_GAGE} | ({"plates": NONE} if list(tables) == ["body"] else {})
    data = deepcopy(data | tables)
    (fault,) = design_faults(design_of(**data))
    if "warming" not in key:
        assert f"{mends:g}" in f"{fault.bound} {fault.remedy}"
    for value, there in ((mends, False), (fails, True)):
        set_value(data, key, value)
        assert (fault.key in keys(**data)) == there


def test_of_a_range_of_masses_the_heaviest_sets_the_travel_the_lightest_steps_and_forces():
    def grip(masses):
        return parse_design(f'design.name = "a"\ngrip.object_mass_g = {masses}').grip

    light, heavy, both = grip("100.0"), grip("500.0"), grip("[100.0, 500.0]")
    assert both.max_approach_mm == heavy.max_approach_mm > light.max_approach_mm
    assert both.fundamental_approach_mm == heavy.fundamental_approach_mm
    for key in ("preload_mm", "approach_step_mm", "shear_step_mm", "curve_per_N", "hold_force_N"):
        own, alone, other = (getattr(each, key) for each in (both, light, heavy))
        assert own == pytest.approx(alone, rel=0.01)  # of three digits
        assert abs(other / own - 1.0) > 0.2
