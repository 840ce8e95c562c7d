"""Geometry faults: found, blamed on one key, and gone once the remedy is followed."""

import random
import re
import time

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fingerdesign.checks.design import design_faults
from fingerdesign.checks.load import judge_data
from fingerdesign.checks.spacing import LEAST_GAP
from fingerdesign.design.schema import Design
from fingerdesign.layout.clearance import LEAST_CLEARANCE_MM

QUICK = settings(max_examples=40, derandomize=True, deadline=None)


def design_of(**tables):
    return Design.model_validate({"design": {"name": "a"}, **tables})


def keys(**tables):
    return [fault.key for fault in design_faults(design_of(**tables))]


ROWS = {"rows": [{"along": "z", "count": 3, "cover_mm": 6.0}]}
OVER = {"span_mm": 2.0, "placement": [(0, 8, 45, -2.0), (0, 8, -45, 2.0)]}
DOME = {"shape": "dome", "dome_radius_mm": 25.0, "depth_mm": 14.0}


def test_the_default_finger_is_sound():
    assert keys() == []
    assert keys(body=DOME, plates={"span_mm": 8.0}) == []


@pytest.mark.parametrize(
    ("tables", "expected"),
    [
        ({"body": {"arc_radius_mm": 9.9}}, ["body.arc_radius_mm"]),
        ({"body": DOME | {"dome_radius_mm": 8.0}}, ["body.dome_radius_mm"]),
        ({"plates": {"cover_mm": 0.5}}, ["plates.cover_mm"]),
        ({"plates": {"cover_mm": 12.0}}, ["plates.cover_mm"]),
        ({"plates": {"pitch_mm": 1.4}}, ["plates.pitch_mm"]),
        ({"plates": {"pitch_mm": 0.1}}, ["plates.pitch_mm"]),
        ({"plates": {"pitch_mm": 0.0707 * 2}}, ["plates.pitch_mm"]),
        ({"plates": {"pitch_mm": 200.0}}, ["plates.pitch_mm"]),
        ({"plates": {"length_mm": 0.39}, "gages": {"length_mm": 0.2}}, ["plates.length_mm"]),
        ({"plates": {"span_mm": 10.1}}, ["plates.span_mm"]),
        ({"plates": {"span_mm": 9.9}}, ["plates.span_mm"]),
        ({"gages": {"length_mm": 2.1}}, ["gages.length_mm"]),
        ({"gages": {"width_mm": 10.1}}, ["gages.width_mm"]),
        ({"gages": {"z_mm": 4.6}}, ["gages.z_mm"]),
        ({"gages": {"z_mm": -4.6}}, ["gages.z_mm"]),
        ({"plates": {"span_mm": 4.0}, "gages": {"z_mm": 1.6}}, ["gages.z_mm"]),
        ({"plates": {"count": 1, "length_mm": 40.0, "angle_deg": 0.0}}, ["plates.length_mm"]),
        ({"plates": {"placement": [(0, 10, 45), (0.1, 10, -45)]}}, ["plates.placement[1]"]),
        ({"plates": {"placement": [(0, 12.5, 45)]}}, ["plates.placement[0]"]),
        ({"plates": {"placement": [(0, 0.5, 45)]}}, ["plates.placement[0]"]),
        ({"plates": {"placement": [(9.8, 5, 45)]}}, ["plates.placement[0]"]),
        ({"mesh": {"mesher": "extrude"}, "plates": {"span_mm": 8.0}}, []),
        ({"mesh": {"mesher": "extrude"}, "plates": {"hole_diameter_mm": 0.6}}, ["mesh.mesher"]),
        ({"mesh": {"mesher": "extrude"}, "plates": ROWS}, ["mesh.mesher"]),
        ({"mesh": {"mesher": "extrude"}, "plates": OVER}, ["mesh.mesher"]),
        ({"mesh": {"mesher": "extrude"}, "body": DOME, "plates": {"span_mm": 8}}, ["mesh.mesher"]),
        ({"mesh": {"contact_size_mm": 3.0}}, ["mesh.contact_size_mm"]),
        ({"mesh": {"section": {"contact_size_mm": 3.0}}}, ["mesh.section.contact_size_mm"]),
    ],
)
def test_one_cause_is_one_fault_on_its_key(tables, expected):
    assert keys(**tables) == expected


def test_gages_and_plates_do_not_matter_where_there_are_none():
    assert keys(plates={"count": 0, "cover_mm": 0.5}, gages={"length_mm": 50.0}) == []


def test_plates_at_the_surface_are_distinguished_from_plates_below_it_by_a_micrometre():
    def cover(value):
        return keys(plates={"count": 1, "angle_deg": 0.0, "cover_mm": value})

    # One flat plate under the crest: its upper corners at +-1 mm are nearest to the arc.
    exact = 20.0 - np.sqrt((20.0 - LEAST_CLEARANCE_MM) ** 2 - 1.0) + 0.05
    assert cover(exact + 1e-3) == []
    assert cover(exact - 1e-3) == ["plates.cover_mm"]


def test_the_dome_thins_the_cover_at_the_plates_ends():
    plates = {"cover_mm": 1.6, "span_mm": 13.0}
    assert keys(body={"depth_mm": 14.0}, plates=plates) == []
    assert keys(body=DOME, plates=plates) == ["plates.cover_mm"]
    assert keys(body=DOME, plates=plates | {"span_mm": 4.0}) == []


def test_plates_side_by_side_are_distinguished_by_half_a_thickness():
    def placed(distance):
        return keys(plates={"placement": [(0, 8, 90), (0.1 + distance, 8, 90)]})

    assert placed(LEAST_GAP * 0.1 + 1e-6) == []
    assert placed(LEAST_GAP * 0.1 - 1e-6) == ["plates.placement[1]"]


def remedy_value(fault, words):
    found = re.search(re.escape(words) + r" ([-0-9.]+)", fault.remedy)
    return float(found.group(1)) if found else None


@QUICK
@given(st.floats(0.05, 2.0), st.floats(-90, 90), st.booleans())
def test_following_the_cover_remedy_ends_the_fault(cover, angle, dome):
    tables = {"body": DOME} if dome else {}
    plates = {"count": 5, "pitch_mm": 3.0, "angle_deg": angle, "cover_mm": cover}
    found = [f for f in design_faults(design_of(plates=plates, **tables)) if "cover" in f.key]
    assume(found)
    value = remedy_value(found[0], "plates.cover_mm to at least")
    assert keys(plates=plates | {"cover_mm": value}, **tables) == []
    assert "plates.cover_mm" in keys(plates=plates | {"cover_mm": value - 0.01}, **tables)


@QUICK
@given(st.floats(0.02, 0.14), st.floats(30, 150))
def test_following_the_pitch_remedy_ends_the_fault(pitch, angle):
    plates = {"count": 7, "pitch_mm": pitch, "angle_deg": angle, "cover_mm": 3.0}
    found = design_faults(design_of(plates=plates))
    assume(found)
    value = remedy_value(found[0], "plates.pitch_mm to at least")
    assert value is not None
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


TRIED = {
    "body": {"width_mm": (2, 40), "arc_radius_mm": (2, 40), "base_height_mm": (1, 20)}
    | {"depth_mm": (1, 20)},
    "plates": {"pitch_mm": (0.05, 3), "cover_mm": (0.1, 15), "length_mm": (0.1, 4)}
    | {"thickness_mm": (0.01, 0.5), "angle_deg": (-90, 90), "span_mm": (0.5, 20)},
    "gages": {"length_mm": (0.1, 4), "width_mm": (0.1, 12), "z_mm": (-5, 5)},
}


def reported(data):
    return {fault.key for fault in judge_data(data).faults}


def test_a_faulty_key_comes_before_any_geometry():
    chance = random.Random(1)
    for _ in range(400):
        data = {"design": {"name": "a"}} | {
            table: {
                key: chance.uniform(*span) for key, span in keys.items() if chance.random() < 0.6
            }
            for table, keys in TRIED.items()
        }
        if chance.random() < 0.4:
            data["body"] |= {"shape": "dome", "dome_radius_mm": chance.uniform(5, 40)}
        assert all("." in key for key in reported(data))  # judged, whatever is in it
        table = chance.choice(list(TRIED))
        key = chance.choice(list(TRIED[table]))
        data[table][key] = -1e9
        assert reported(data) == {f"{table}.{key}"}
