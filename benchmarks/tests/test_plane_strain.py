"""bench plane-strain: the study's file and run, the map with its rule, what is written."""

from dataclasses import replace

import numpy as np
import pytest
from fingerdesign_bench.plane_strain import run as plane_strain
from fingerdesign_bench.plane_strain.chart import draw_map
from fingerdesign_bench.plane_strain.file import parse_study, points_of, read_study, shipped_study
from fingerdesign_bench.plane_strain.judge import FINER, checks_of, judged, mesh_errors, uncertainty
from fingerdesign_bench.plane_strain.rule import Rule, fitted
from fingerdesign_bench.plane_strain.run import READ, compare, key_of, models_of, run_study
from fingerdesign_bench.plane_strain.table import PRESSED, SHEARED, half_width, row_errors, table_of

from fingerdesign.errors import DesignError
from fingerdesign.layout.layers import layered
from fingerdesign.validate.plane_strain import QUANTITIES, map_of

RULE = Rule("normal_force", 0.0, 3.0, 1.2, 0.3, 0.9)
SMALL = """
[study]
name = "small"
base = "maeno2000"
[fixed]
"body.width_mm" = 20.0
"body.base_height_mm" = 10.0
"body.arc_radius_mm" = 20.0
"plates.count" = 1
"plates.length_mm" = 2.0
"plates.cover_mm" = 2.0
"gages.length_mm" = 1.0
[parameters]
"body.depth_mm" = [10.0, 40.0]
"plates.span_mm / body.depth_mm" = [0.0, 1.0]
[scene]
approach_mm = [0.4]
[mesh]
contact_size_mm = 0.6
plate_size_mm = 1.0
far_size_mm = 4.0
gradation = 0.6
end_layer_mm = 1.0
[[also]]
name = "rough"
"scene.friction_coefficient" = 1.0
"mesh.contact_size_mm" = 0.7
"body.base_height_mm" = 12.0
"""


def readings(force, width, gages):
    numbers = (force, 0.5 * force, width, 0.8)
    rows = [[each] * len(gages) for each in numbers]
    return dict(zip(READ, (*rows, gages), strict=True))


def record(poisson, span, depth, scale):
    """A model whose errors are ``scale`` at the first approach, twice that at the second."""
    rows = []
    for k, half in enumerate((1.0, 2.0)):
        truth = readings(10.0, 2.0 * half, [[[100.0, -50.0]]] * 4)
        moved = readings(10.0 * (1.0 + (k + 1) * scale), 2.0 * half, [[[100.0, -45.0]]] * 4)
        rows.append({"approach_mm": 0.1, "space": truth, "motion": moved, "force": None})
    sizes = {"radius_mm": 20.0, "depth_mm": depth, "width_mm": 20.0, "height_mm": 10.0}
    facts = {"poissons_ratio": poisson, "span_share": span, "dofs": 1, "rows": rows}
    return {"name": "", "values": {}, **sizes, **facts}


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


def model(poisson, span, depth, name="", more=1.0):
    """A model whose every error follows RULE, times ``more``."""
    rows = []
    for width in (0.06, 0.12, 0.3):
        error = more * float(RULE.error(poisson, depth, width))
        rows.append({"half_width_over_height": width} | dict.fromkeys(QUANTITIES, error))
    place = {"poissons_ratio": poisson, "span_over_depth": span, "depth_over_height": depth}
    shape = {"radius_over_height": 1.6, "width_over_height": 1.6, "dofs": 1}
    return {"name": name, **place, **shape, "rows": rows}


@pytest.fixture
def table():
    grid = [
        model(nu, span, depth)
        for nu in (0.3, 0.45, 0.49)
        for span in (0.0, 1.0)
        for depth in (0.4, 0.8, 1.6, 3.2)
    ]
    also = [
        model(0.49, 1.0, 0.8, FINER, 1.05),
        *(model(0.49, 1.0, 0.8, f"other {k}", 1.0 + 0.1 * k) for k in range(5)),
    ]
    return {"points": grid, "also": also}


def test_the_fit_finds_the_rule_that_made_the_errors(table):
    found = fitted(map_of(table), "normal_force", 0.0)
    assert found.factor == pytest.approx(3.0, rel=0.05)
    assert found.poisson == pytest.approx(1.2, abs=0.02)
    assert found.width == pytest.approx(0.3, abs=0.01)
    assert found.depth == pytest.approx(0.9, rel=0.05)
    assert found.typical < found.off < 2e-3


def test_how_sure_a_look_up_is_comes_from_the_one_off_models(table):
    chart = map_of(table)
    largest = float(RULE.error(0.49, 0.8, 0.3))
    assert mesh_errors(chart)["normal_force"] == pytest.approx(0.05 * largest, rel=1e-6)
    found = uncertainty(chart)["gage_face"]
    assert found["absolute"] == pytest.approx(max(0.01, 0.05 * largest), rel=0.01)
    assert 0.2 < found["relative"] < 0.4  # nine of ten, the meshes' part taken off


@pytest.mark.slow
def test_what_is_judged_and_drawn(table, tmp_path):
    chart, rules = judged(table)
    assert set(chart.table) == {"points", "also", "rules", "uncertainty"}
    assert draw_map(chart, tmp_path / "map.png").read_bytes()[:4] == b"\x89PNG"
    names = [check.name for check in checks_of(chart, rules)]
    assert any("finer" in name for name in names)
    assert any("no plates" in name for name in names)


def test_the_shipped_study_is_a_grid_of_sound_designs():
    study = read_study(shipped_study())
    points = list(points_of(study))
    grid = [point for point in points if not point.name]
    assert len(grid) == np.prod([len(values) for values in study.parameters.values()]) >= 48
    assert len({key_of(point) for point in points}) == len(points)
    assert len(list(points_of(study, quick=True))) == 8
    assert all(layered(point.design) for point in grid)


def test_a_span_is_a_share_of_the_depth_and_none_leaves_plates_out():
    for point in points_of(parse_study(SMALL), quick=True):
        plates, depth = point.design.plates, point.design.body.depth_mm
        share = point.values["plates.span_mm / body.depth_mm"]
        assert plates.model == ("none" if share == 0.0 else "solid")
        assert plates.span_mm == pytest.approx(depth * (share or 1.0))


def test_layers_follow_the_depth_and_both_models_have_one_section():
    shallow, *_, deep, _ = points_of(parse_study(SMALL))
    assert shallow.design.body.depth_mm == 10.0
    assert 3 <= shallow.layers < deep.layers
    flat, solid = models_of(deep)
    assert flat.sizes == solid.sizes
    assert flat.element == solid.element == "mixed"
    assert solid.layers == deep.layers


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("[10.0, 40.0]", "[inf]", "parameters"),
        ("[10.0, 40.0]", "[9.0, 9.0]", "parameters.body.depth_mm"),
        ("[10.0, 40.0]", str([10.0 + 0.01 * k for k in range(3000)]), "at most 2000 models"),
        ("[0.4]", "[]", "scene.approach_mm"),
        ('_mm" = 0.7', '_mm" = -1.0', "contact_size_mm"),
        ('name = "rough"', "", "also.name"),
        ("s.span_mm / b", "s.span_mm / B", "Body.depth_mm"),
        ("[study]", "[study", "file"),
    ],
)
def test_a_fault_names_its_key(old, new, key):
    with pytest.raises(DesignError, match=key):
        list(points_of(parse_study(SMALL.replace(old, new))))


def test_the_mesh_is_part_of_a_records_key(tmp_path, monkeypatch):
    points = list(points_of(parse_study(SMALL)))
    made = []
    monkeypatch.setattr(plane_strain, "compare", lambda at: made.append(at) or {"rows": [1]})
    run_study(points[:2], tmp_path / "some.sqlite", lambda message: None)
    found = run_study(points, tmp_path / "some.sqlite", lambda message: None)
    assert len(made) == len(points)
    assert [record["values"] for record in found] == [point.values for point in points]
    other = points[0].mesh.model_copy(update={"gradation": 0.7})
    assert key_of(replace(points[0], mesh=other)) != key_of(points[0])


def test_plane_strain_overstates_by_what_was_known():
    """R = 20, nu = 0.49, approach 0.4, depth 10, no plates: 31 %; a coarse mesh does for it."""
    point = next(iter(points_of(parse_study(SMALL))))
    record = compare(point)
    (row,) = record["rows"]
    found = row_errors(row)
    assert found["normal_force"] == pytest.approx(0.31, abs=0.02)
    assert 0.05 < found["tangential_force"] < 0.2
    assert abs(found["force_contact_width"]) < 0.5 * found["contact_width"]
    assert half_width(row) == pytest.approx(2.45, abs=0.15)
    assert record["height_mm"] == pytest.approx(12.68, abs=0.01)
    assert record["span_share"] == 0.0


@pytest.mark.slow
def test_plane_strain_is_nearer_where_the_finger_is_deep():
    """Depth 40: 12 % without plates; plates of full span halve that."""
    _, _, bare, plated, _ = points_of(parse_study(SMALL))
    assert bare.design.body.depth_mm == plated.design.body.depth_mm == 40.0
    errors = [row_errors(compare(point)["rows"][0]) for point in (bare, plated)]
    assert errors[0]["normal_force"] == pytest.approx(0.12, abs=0.02)
    assert errors[1]["normal_force"] < errors[0]["normal_force"]
