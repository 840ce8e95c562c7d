"""The mesh's share in the errors of an analysis: estimated, or absent with a reason."""

from concurrent.futures import Future
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.fidelity.choice import Choice
from fingerdesign.analysis.mesh_error import (
    COARSER,
    ORDERS,
    Second,
    absence,
    estimate,
    family_mesh,
    mesh_error,
)
from fingerdesign.analysis.path import follow_path, problem_at_touch
from fingerdesign.analysis.stages import zone_of
from fingerdesign.analysis.work import Followed
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.io import parse_scene
from fingerdesign.layout.bodies import crest_height
from fingerdesign.pipeline import run
from tests.support.half_space import half_plane


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


def test_errors_are_of_the_same_path_on_the_second_model_by_its_orders():
    case, scene = case_of(), parse_scene("path.increments_mm = [[0.02, 0.001]]")
    model = half_plane(1.0, 41, 20.0)
    points = np.add(model.points, [0.0, float(crest_height(case.design.body))])
    model = replace(model, points=points, surface=replace(model.surface, points=points))
    (made := Future()).set_result(SimpleNamespace(reduced=model))
    stiffer = replace(model, compliance=0.9 * model.compliance)
    problem = problem_at_touch(stiffer, scene.object, case.design.body)
    steps = follow_path(problem, scene, case.design)
    followed, orders = Followed(Choice(case, None, None, []), problem, steps), ORDERS["3d"]
    whole, shares = (
        vars(mesh_error(Second(case, made, 2.0, each), followed, scene)) for each in (None, orders)
    )
    assert whole["normal_force"] > 0.01
    expected = {name: each / (2.0 ** orders[name] - 1.0) for name, each in whole.items()}
    assert shares == pytest.approx(expected)
    assert mesh_error("why", followed, scene) == "why"
    finite = replace(followed, chosen=followed.chosen.at_finite_strain(""))
    assert "finite" in mesh_error(Second(case, made), finite, scene)
