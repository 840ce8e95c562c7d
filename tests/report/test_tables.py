"""Tables hold the numbers of a result."""

from dataclasses import replace

import pytest

from fingerdesign.analysis.page.tables import (
    design_table,
    foreseen_table,
    grip_table,
    increment_table,
    leaves_section,
    model_table,
    points_table,
    work_table,
)
from fingerdesign.records.result import PointStrain
from fingerdesign.report.table import column_texts


def with_parts(result, name, changes):
    """The result with the studies, grips or increments of a name changed, each by its own keys."""
    parts = zip(getattr(result, name), changes, strict=False)
    return replace(result, **{name: tuple(replace(part, **keys) for part, keys in parts)})


def with_keys(result, **keys):
    return replace(result, parameters=result.parameters | keys)


@pytest.mark.parametrize(
    ("changes", "key", "listed"),
    [
        ({}, "body.arc_radius_mm", True),
        ({"body.shape": "step"}, "body.arc_radius_mm", False),
        ({}, "body.edge", False),
        ({"body.edge_radius_mm": 1.0}, "body.edge", True),
    ],
)
def test_keys_that_do_nothing_are_not_listed(plane_strain, changes, key, listed):
    idle = {"body.edge": "round", "body.edge_radius_mm": None}
    table = design_table(with_keys(plane_strain.result, **idle | changes))
    assert (key in {row[0] for row in table.rows}) is listed


def test_noise_is_zero_and_a_column_has_one_format(plane_strain):
    noise = {"tangential_force_N": -6e-16, "normal_force_N": -4e-17}
    changes = [{"tangential_force_N": 2e-4, "peak_pressure_MPa": -0.0}, noise, {}]
    cells = increment_table(with_parts(plane_strain.result, "increments", changes)).rows
    assert [row[4] for row in cells] == ["0.000", "0.000", "1.900"]
    assert [row[3] for row in cells] == ["3.000", "0.000", "9.000"]
    assert cells[0][8] == "0.000"
    assert [column_texts([1e-6], scale=scale)[0] for scale in (0.0, 1e4)] == ["0.000001", "0.000"]


def with_scene(result, **changes):
    """Strains at two points, no load at the end, and a scene's keys."""
    strain = PointStrain(1.25, -2.0, 0.0, 1e-14, -3.0, 0.5)
    rows = [{"points": (strain, strain)} for _ in result.increments]
    rows[-1]["normal_force_N"] = 1e-15
    scene = {
        "scene.object.friction_coefficient": 0.5,
        "scene.path.increments_mm": [[0.1, 0.0], [0.1, 0.1]],
        "scene.readout.points_mm": [[-4.0, 6.0, 0.0], [0.0, 6.25, 0.0]],
    }
    return with_keys(with_parts(result, "increments", rows), **scene | changes)


def test_what_leaves_the_section_has_columns_of_its_own(plane_strain):
    result = plane_strain.result
    row = result.increments[-1]
    assert not leaves_section([replace(row, force_z_N=1e-3 * row.normal_force_N)])  # the mesh's
    assert leaves_section([replace(row, force_z_N=0.1 * row.normal_force_N)])
    assert "twist (degrees)" not in increment_table(result).columns
    table = increment_table(with_parts(result, "increments", [{"twist_deg": 0.5}] * 8))
    assert table.columns[-3] == "twist (degrees)"
    assert all(len(row) == len(table.columns) for row in table.rows)


def test_strain_at_points_is_that_under_load(plane_strain):
    assert points_table(plane_strain.result).rows == ()
    table = points_table(with_scene(plane_strain.result))
    assert "at increment 7 (the last under load)" in table.caption
    where = ("2", "0.000", "6.250", "0.000")
    assert table.rows[1] == (*where, "1.2", "-2.0", "0.0", "0.0", "-3.0", "0.5")
    unknown = points_table(with_scene(plane_strain.result, **{"scene.readout.points_mm": None}))
    assert unknown.rows[0][:4] == ("1", "–", "–", "–")


def test_tables_have_a_cell_for_every_column_and_a_dash_for_no_value(plane_strain, solid):
    result = plane_strain.result
    work = work_table(result, "1.00 s", "8.00 s")
    for table in (
        work,
        *(make(result) for make in (increment_table, grip_table, model_table, design_table)),
    ):
        assert table.rows
        assert {len(row) for row in table.rows} == {len(table.columns)}
    assert model_table(solid.result).rows[0] == ("dimension", "3-D")
    assert model_table(result).rows[0] == ("dimension", "2-D, plane strain")
    assert ("this page", "1.00 s") in work.rows
    changed = with_parts(result, "increments", [{"stick_ratio": None}])
    changed = with_parts(changed, "grips", [{"safety_margin": None, "slips_without_rule": None}])
    assert increment_table(changed).rows[0][6] == "–"
    assert grip_table(changed).rows[0][6:8] == ("not tried", "–")
    counted = grip_table(changed).columns  # The rule's figure counts from first contact on.
    assert "steps after the preload" in counted


def test_warnings_of_slip_are_a_row_a_grip(plane_strain):
    assert foreseen_table(plane_strain.result) is None
    warned = {"alarms": 3, "false_alarms": 1, "samples": 50, "stick_error_samples": 40}
    slip = {"slip_warning": "standing", "lead_s": 0.05, "lead_force_share": 0.9}
    grips = [warned | slip | {"stick_error": 0.1}, warned | {"stick_error": 0.2}, {}]
    rows = foreseen_table(with_parts(plane_strain.result, "grips", grips)).rows
    assert rows[0][3:] == ("warned of", "0.050", "90", "3", "1", "50", "0.100", "40")
    assert rows[2][3:] == ("–", "–", "–", "–", "–", "0", "–", "0")
