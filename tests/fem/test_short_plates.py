"""Plates that end inside an extruded finger: half and whole agree, sheets and solids do, and span
tells."""

import numpy as np
import pytest

from fingerdesign import analyse, parse_design, parse_scene, with_values

DESIGN = parse_design(
    """
    design.name = "short"
    body.width_mm = 8.0
    body.base_height_mm = 4.0
    body.arc_radius_mm = 8.0
    body.depth_mm = 5.0
    plates.count = 1
    plates.length_mm = 2.0
    plates.cover_mm = 1.5
    plates.thickness_mm = 0.2
    plates.span_mm = 2.5
    mesh.mesher = "extrude"
    mesh.layers = 3
    mesh.contact_size_mm = 0.7
    mesh.plate_size_mm = 0.7
    mesh.far_size_mm = 2.5
    """
)
SCENE = parse_scene("path.increments_mm = [[0.1, 0.0], [0.1, 0.03]]")
SIDEWAYS = parse_scene("path.increments_mm = [[0.1, 0.0], [0.1, 0.03, 1e-9]]")


def answers(values, scene=SCENE):
    """F_n, F_t and the two faces' strains of the last increment."""
    result = analyse(with_values(DESIGN, values), scene, "3d")
    last = result.increments[-1]
    gage = last.gages[0]
    return np.array([last.normal_force_N, last.tangential_force_N, gage.upper, gage.lower])


@pytest.fixture(scope="module")
def half():
    return answers({})


def test_half_and_whole_agree(half):
    """A path that hardly leaves the mirror plane takes the whole finger."""
    assert answers({}, SIDEWAYS) == pytest.approx(half, rel=1e-5)


def test_sheets_and_solids_agree(half):
    sheet = answers({"plates.model": "sheet"})
    assert sheet[:2] == pytest.approx(half[:2], rel=5e-3)
    assert np.abs(sheet[2:] - half[2:]).max() < 0.05 * np.abs(half[2:]).max()


def test_a_short_plate_stiffens_less_than_a_long_one_and_more_than_none(half):
    full = answers({"plates.span_mm": 5.0})
    none = answers({"plates.model": "none"})
    assert none[0] < half[0] < full[0]
