"""One condensed model serves the path, every friction and the grips; fields on demand."""

import json

import pytest
from fingerdesign_cli.main import main

from fingerdesign import parse_design, parse_scene, pipeline
from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.page.tables import ladder_table
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.checks.starter import shipped_path
from fingerdesign.errors import DesignError, Fault
from fingerdesign.fem import factor
from fingerdesign.fem.model import FiniteElementModel
from fingerdesign.pipeline import run
from fingerdesign.records.result import Result

COARSE = {
    "mesh.section.contact_size_mm": 0.15,
    "mesh.section.plate_size_mm": 0.2,
    "mesh.section.plate_end_size_mm": 0.1,
    "mesh.section.far_size_mm": 2.0,
    "grip.friction_coefficients": [0.3, 0.8],
}


@pytest.fixture
def counted(monkeypatch):
    """How often a stiffness was factored, and displacements recovered."""
    calls = {"factored": 0, "fields": 0}
    condense = factor.Condensation.__init__
    recover = FiniteElementModel.displacement_fields

    def counting_condense(self, *given):
        calls["factored"] += 1
        condense(self, *given)

    def counting_recover(self, forces):
        calls["fields"] += 1
        return recover(self, forces)

    monkeypatch.setattr(factor.Condensation, "__init__", counting_condense)
    monkeypatch.setattr(FiniteElementModel, "displacement_fields", counting_recover)
    return calls


@pytest.mark.parametrize("scene", [None, fundamental_scene()])
def test_one_factorisation_serves_frictions_grips_and_fields(counted, scene):
    design = with_values(load_design(shipped_path("narrow")), COARSE)
    analysis = pipeline.run(Case(design, scene, "plane-strain", fields=scene is not None))
    assert counted == {"factored": 1, "fields": int(scene is not None)}
    assert (analysis.fields is None) == (scene is None)
    assert len(analysis.result.grips) == (2 if scene is None else 0)
    assert (len(analysis.slip_studies) >= 5) == (scene is None)  # friction coefficients


def test_analyse_can_be_reported_to_leave_fields_out(monkeypatch, tmp_path):
    cases = []

    def stop(case, out, report):
        cases.append(case)
        raise DesignError([Fault("test", 0, "ended here", "none")])

    monkeypatch.setattr("fingerdesign.pipeline.analyse_into", stop)
    for more in ([], ["--no-fields", "--go-on"]):
        assert main(["analyse", "narrow", "--out", str(tmp_path), "-q", *more]) == 2
    assert [(case.fields, case.go_on) for case in cases] == [(True, False), (False, True)]


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
SHORT = "[object]\n[path]\nincrements_mm = [[0.1, 0.0], [0.1, 0.02], [0.1, 0.04]]"


@pytest.fixture(scope="module")
def climbed():
    design, scene = parse_design(SMALL), parse_scene(SHORT)
    return run(Case(design, scene, "auto", tolerance=0.2, fields=False)), design


def test_the_result_says_what_was_tried(climbed):
    analysis, design = climbed
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
    spent = sum(each.seconds for each in ladder.models)
    stages = ("mesh", "assemble", "condense", "increments")
    assert sum(result.timings_s[stage] for stage in stages) >= 0.99 * spent
    table = ladder_table(result)
    assert len(table.rows) == len(ladder.models)
    assert "20 %" in table.caption


def test_a_wrong_tolerance_is_refused_before_work():
    with pytest.raises(DesignError, match="--tolerance = 3"):
        run(Case(parse_design(SMALL), parse_scene(SHORT), "auto", tolerance=3.0))
