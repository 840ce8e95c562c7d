"""How far an outcome may be believed: plane strain's forecast, the ladder's estimate."""

from dataclasses import replace

import pytest

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import with_values
from fingerdesign.checks.starter import find_design
from fingerdesign.records.result import LadderSummary, MeshSummary, ModelSummary, Result
from fingerdesign.search.run.evaluate import validity_of
from fingerdesign.validate.plane_strain import plane_strain_error

DESIGN = find_design("maeno2000")
MODEL = ModelSummary(2, "t", 10, 5, False)
MESH = MeshSummary("m", 3, 30.0, 0.0, None)


def judged(design=DESIGN, dimension=2, ladder=None, fidelity="plane-strain"):
    model = replace(MODEL, dimension=dimension)
    result = Result("a", "s", "d", {}, "3d", model=model, mesh=MESH, ladder=ladder)
    return validity_of(Case(design, fidelity=fidelity), Analysis(result))


def test_plane_strain_has_a_forecast():
    found = judged()
    case = Case(DESIGN)
    assert found.plane_strain_error == pytest.approx(
        plane_strain_error(DESIGN, case.path_scene).errors["normal_force"]
    )
    assert "overstates F_n" in found.sentences[0]
    assert found.mesh_error is None


def test_space_has_none():
    found = judged(dimension=3, fidelity="3d")
    assert (found.plane_strain_error, found.mesh_error) == (None, None)
    assert "no estimate" in found.sentences[0]


def test_a_body_that_no_section_shows_has_none_and_says_so():
    found = judged(with_values(find_design("domed"), {"plates.count": 0}))
    assert found.plane_strain_error is None
    assert "body.shape" in found.sentences[0]


def test_the_ladder_reports_its_worst():
    errors = {"normal_force": 0.01, "stick_ratio": 0.04}
    ladder = LadderSummary(0.02, False, "fine", errors, "no more memory", ())
    found = judged(dimension=3, ladder=ladder, fidelity="auto")
    assert found.mesh_error == 0.04
    assert "no more memory" in " ".join(found.sentences)


def test_a_ladder_without_estimates_has_no_error():
    ladder = LadderSummary(0.02, True, "only", {}, "", ())
    assert judged(dimension=3, ladder=ladder).mesh_error is None
