"""--fidelity auto end to end, on a small finger: what a result says of its ladder."""

import json

import pytest

from fingerdesign import parse_design, parse_scene
from fingerdesign.analysis.case import Case
from fingerdesign.analysis.page.tables import ladder_table
from fingerdesign.errors import DesignError
from fingerdesign.pipeline import run
from fingerdesign.records.result import Result

SMALL = """
design.name = "small"
body.width_mm = 10.0
body.depth_mm = 4.0
body.base_height_mm = 4.0
body.arc_radius_mm = 12.0
plates.count = 1
plates.length_mm = 1.5
plates.thickness_mm = 0.2
"""
SCENE = "[object]\n[path]\nincrements_mm = [[0.1, 0.0], [0.1, 0.02], [0.1, 0.04]]"


@pytest.fixture(scope="module")
def found():
    design, scene = parse_design(SMALL), parse_scene(SCENE)
    return run(Case(design, scene, "auto", tolerance=0.2, fields=False)), design


def test_the_result_says_what_was_tried(found):
    analysis, design = found
    result = analysis.result
    ladder = result.ladder
    assert ladder.tolerance == 0.2
    assert ladder.reached == (max(ladder.error_estimates.values()) <= 0.2)
    assert ladder.models[-1].name == ladder.chosen
    assert result.fidelity == ("3d" if "3-D" in ladder.chosen else "plane-strain")
    assert result.model.dofs == ladder.models[-1].dofs
    assert any("--fidelity auto" in reason for reason in result.model.reasons)
    assert result.parameters["mesh.mesher"] == design.mesh.mesher  # the design as it was given
    again = Result.from_json(result.to_json())
    assert again.ladder == ladder
    assert json.loads(result.to_json())["ladder"]["models"][0]["why"]


def test_its_time_is_that_of_all_models(found):
    result = found[0].result
    spent = sum(each.seconds for each in result.ladder.models)
    stages = ("mesh", "assemble", "condense", "increments")
    assert sum(result.timings_s[stage] for stage in stages) >= 0.99 * spent


def test_the_report_has_a_row_a_model(found):
    result = found[0].result
    table = ladder_table(result)
    assert len(table.rows) == len(result.ladder.models)
    assert "20 %" in table.caption


def test_a_wrong_tolerance_is_refused_before_work():
    with pytest.raises(DesignError, match="--tolerance = 3"):
        run(Case(parse_design(SMALL), parse_scene(SCENE), "auto", tolerance=3.0))
