"""The mesh's share in the errors of an analysis: estimated, or absent with a reason."""

from dataclasses import replace

import pytest

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.mesh_error import COARSER, absence, estimate, family_mesh
from fingerdesign.analysis.stages import zone_of
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.pipeline import run


def case_of(name="homogeneous", fidelity="plane-strain", **values):
    """A case that estimates the mesh's error, without grips."""
    design = with_values(load_design(name), values)
    return Case(design, None, fidelity, grips=False, fields=False, mesh_error=True)


@pytest.fixture(scope="module")
def found():
    return run(case_of()).result


def test_an_analysis_states_the_error_of_its_mesh(found):
    error = found.mesh_error
    assert found.mesh_error_absent == ""
    assert 0.0 < error.normal_force < 0.003  # of the default mesh; docs/explanation/accuracy.md
    assert 0.0 < error.stick_ratio < 0.02
    assert error.gages == 0.0  # there are none


def test_the_estimate_changes_no_number(found):
    plain = run(replace(case_of(), mesh_error=False)).result
    assert plain.increments == found.increments
    assert plain.mesh_error is None
    assert "analyse" in plain.mesh_error_absent


def test_richardson_s_rule():
    orders = {"normal_force": 1.0, "tangential_force": 2.0, "stick_ratio": 1.0, "gages": 3.0}
    exact = {name: 0.01 * (2.0**order - 1.0) for name, order in orders.items()}
    assert vars(estimate(exact, 2.0, orders)) == pytest.approx(dict.fromkeys(orders, 0.01))
    assert vars(estimate(exact, 1.0, None)) == exact


@pytest.mark.parametrize(
    ("case", "reason"),
    [
        (case_of(fidelity="auto"), "auto"),
        (case_of(fidelity="finite"), "finite strain"),
        (case_of(**{"mesh.element": "P1"}), "linear"),
        (case_of("domed", "3d"), "swept"),
        (case_of(fidelity="3d"), ""),
    ],
)
def test_where_none_is_estimated_the_reason_is_stated(case, reason):
    assert reason in absence(case)
    assert bool(reason) == bool(absence(case))


@pytest.mark.parametrize("values", [{}, {"mesh.layers": 6}])
def test_a_coarser_swept_mesh_is_coarser_in_every_direction(values):
    case = case_of("maeno2000", "3d", **{"mesh.mesher": "sweep"}, **values)
    zone = zone_of(case, case.path_scene)
    fine, coarse = (family_mesh(case, zone, coarser) for coarser in (1.0, COARSER["3d"]))
    assert coarse.notes["layers"] < fine.notes["layers"]
    ratio = (len(fine.cells) / fine.notes["layers"]) / (len(coarse.cells) / coarse.notes["layers"])
    assert ratio > 1.5
