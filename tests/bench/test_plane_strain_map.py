"""The plane-strain map: look-up between models, the shipped table, its rule, the estimate."""

import json

import numpy as np
import pytest
from fingerdesign_bench.studies.plane_strain_table import (
    PRESSED,
    SHEARED,
    row_errors,
    table_of,
    write_table,
)

from fingerdesign import parse_design, parse_scene, with_values
from fingerdesign.errors import DesignError
from fingerdesign.validate.plane_strain import QUANTITIES, map_of, plane_strain_error

FINGER = parse_design(
    """
    design.name = "known"
    body.width_mm = 20.0
    body.base_height_mm = 10.0
    body.arc_radius_mm = 20.0
    plates.count = 0
    materials.silicone.poissons_ratio = 0.49
    """
)


def readings(force, width, gages):
    rows = len(gages)
    return {
        "normal_force": [force] * rows,
        "tangential_force": [0.5 * force] * rows,
        "contact_width": [width] * rows,
        "stick_ratio": [0.8] * rows,
        "gages": gages,
    }


def record(poisson, span, depth, scale, name=""):
    """A model whose errors are ``scale`` at the first approach, twice that at the second."""
    rows = []
    for k, half in enumerate((1.0, 2.0)):
        truth = readings(10.0, 2.0 * half, [[[100.0, -50.0]]] * 4)
        moved = readings(10.0 * (1.0 + (k + 1) * scale), 2.0 * half, [[[100.0, -45.0]]] * 4)
        rows.append({"approach_mm": 0.1, "space": truth, "motion": moved, "force": None})
    return {
        "name": name,
        "values": {},
        "radius_mm": 20.0,
        "depth_mm": depth,
        "width_mm": 20.0,
        "height_mm": 10.0,
        "poissons_ratio": poisson,
        "span_share": span,
        "dofs": 1,
        "rows": rows,
    }


@pytest.fixture(scope="module")
def made():
    return table_of(
        [
            record(nu, span, depth, nu * (1.0 + span) / depth)
            for nu in (0.3, 0.5)
            for span in (0.0, 1.0)
            for depth in (10.0, 40.0)
        ]
    )


def test_errors_are_plane_strain_against_space():
    truth = readings(10.0, 4.0, [[[0.0, 0.0]], [[100.0, -50.0]], [[1.0, 1.0]], [[200.0, 0.0]]])
    moved = readings(12.0, 5.0, [[[9.0, 9.0]], [[110.0, -50.0]], [[9.0, 9.0]], [[200.0, -10.0]]])
    found = row_errors({"space": truth, "motion": moved, "force": None})
    assert found["normal_force"] == pytest.approx(0.2)
    assert found["contact_width"] == pytest.approx(0.25)
    assert found["stick_ratio"] == 0.0
    assert found["gage_face"] == pytest.approx(0.1)  # pressed: 10 of 100; sheared: 10 of 200
    assert found["gage_both"] == pytest.approx(0.2)  # pressed: 5 of 25
    assert found["force_gage_both"] is None
    assert set(found) == set(QUANTITIES)
    assert (PRESSED, SHEARED) == (1, 3)


def test_a_finger_without_plates_has_no_gage_error():
    bare = readings(10.0, 4.0, np.zeros((4, 0, 2)).tolist())
    found = row_errors({"space": bare, "motion": bare, "force": bare})
    assert found["gage_both"] is None
    assert found["normal_force"] == 0.0


def test_the_map_holds_at_its_points_and_goes_straight_between(made):
    chart = map_of(made)
    at = chart.error("normal_force", 0.5, 1.0, 4.0, 0.1)
    assert at == pytest.approx(0.5 * 2.0 / 40.0)
    assert chart.error("normal_force", 0.5, 1.0, 4.0, 0.2) == pytest.approx(2.0 * at)
    assert chart.error("normal_force", 0.4, 0.0, 1.0, 0.1) == pytest.approx(0.04)
    assert chart.error("normal_force", 0.3, 0.5, 1.0, 0.1) == pytest.approx(0.045)
    middle = chart.error("normal_force", 0.3, 0.0, 2.0, 0.1)
    assert middle == pytest.approx(0.5 * (0.03 + 0.0075))
    assert np.isnan(chart.error("force_gage_both", 0.3, 0.0, 2.0, 0.1))


def test_beyond_the_map_its_border_holds_and_is_reported(made):
    chart = map_of(made)
    assert chart.error("normal_force", 0.3, 0.0, 40.0, 0.1) == pytest.approx(0.0075)
    assert chart.inside(0.3, 0.0, 2.0, 0.15)
    for place in ((0.2, 0, 2, 0.15), (0.3, 0, 8, 0.15), (0.3, 0, 2, 0.5), (0.3, 0, 2, 0.01)):
        assert not chart.inside(*place)


def test_a_grid_with_a_hole_is_no_map(made):
    with pytest.raises(ValueError, match="no full grid"):
        map_of(made | {"points": made["points"][1:]})


def test_a_table_goes_through_its_file(made, tmp_path):
    path = write_table(made | {"rules": {"a": 1.0}}, tmp_path / "table.json")
    assert json.loads(path.read_text("utf-8")) == made | {"rules": {"a": 1.0}}


def test_the_estimate_reads_a_designs_ratios(made):
    chart = map_of(made)
    crest = 10.0 + 20.0 - np.sqrt(300.0)
    design = with_values(FINGER, {"body.depth_mm": 2.0 * crest})
    found = plane_strain_error(design, half_width=0.15 * crest, chart=chart)
    assert found.ratios["depth_over_height"] == pytest.approx(2.0)
    assert found.ratios["span_over_depth"] == 0.0
    assert found.errors["normal_force"] == pytest.approx(
        chart.error("normal_force", 0.49, 0.0, 2.0, 0.15)
    )
    assert "gage" not in found.errors
    assert found.inside
    beyond = plane_strain_error(design, half_width=0.9 * crest, chart=chart)
    assert not beyond.inside
    assert "sketch" in beyond.words
    assert beyond.most("normal_force") > found.most("normal_force")
    assert found.least("normal_force") <= found.errors["normal_force"]


def test_bodies_and_objects_that_no_section_shows_have_no_estimate():
    dome = with_values(FINGER, {"body.shape": "dome", "body.dome_radius_mm": 25.0})
    with pytest.raises(DesignError, match=r"body\.shape"):
        plane_strain_error(dome, half_width=1.0)
    ball = parse_scene(
        'object.shape = "sphere"\nobject.radius_mm = 5\npath.increments_mm=[[0.1,0]]'
    )
    with pytest.raises(DesignError, match=r"object\.shape"):
        plane_strain_error(FINGER, ball)
    with pytest.raises(ValueError, match="scene or a half_width"):
        plane_strain_error(FINGER)
