"""The whole system factored at each iteration has the condensed one's answers."""

import numpy as np
import pytest
from fingerdesign_bench.speed.full_solve import FullSystem, as_increment
from fingerdesign_bench.speed.precision_run import ROWS, Method, run_once, sized

from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.design.scene import SceneObject
from fingerdesign.errors import SolverError
from fingerdesign.fem.model import build_model
from fingerdesign.layout.frames import crest_height
from fingerdesign.layout.zone import candidate_zone
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.shapes.objects import Plane


def both(kind, size, plates="none"):
    design = sized(Method(kind, "P2", plates=plates), size)
    zone = candidate_zone(design, SceneObject(), ROWS[-1][0]).half_width
    mesh = mesh_section(design, zone) if kind == "plane strain" else extrude(design, zone)
    model = build_model(design, mesh, zone)
    problem = contact_problem(model.reduced, Plane(crest_height(design.body)), 0.5)
    return model, problem


@pytest.mark.parametrize(
    ("kind", "size", "plates"),
    [
        ("plane strain", 0.3, "none"),
        ("plane strain", 0.4, "solid"),
        ("extruded", 1.0, "none"),
    ],
)
def test_full_and_condensed_agree(kind, size, plates):
    model, problem = both(kind, size, plates)
    path = [Motion(*row) for row in ROWS]
    condensed = [step.increment for step in follow(problem, path)]
    full = list(FullSystem(model.condensed, problem, 5.0).follow(path))
    for one, other in zip(condensed, full, strict=True):
        scale = np.abs(one.multiplier).max()
        assert np.abs(one.multiplier - other.multiplier).max() <= 1e-8 * scale
        increment = as_increment(problem, other)
        assert increment.certificate.laws <= 1e-8
        assert (increment.status == one.status).all()
    displaced = model.displacement_fields(np.array([condensed[-1].force]))[0].reshape(-1)
    assert np.abs(displaced - full[-1].displacement).max() <= 1e-8 * np.abs(displaced).max()


def test_a_plain_newton_that_cycles_says_so(monkeypatch):
    monkeypatch.setattr("fingerdesign_bench.speed.full_solve._FACTOR", 50.0)
    model, problem = both("plane strain", 0.2)
    with pytest.raises(SolverError, match="did not converge in 40 iterations at approach"):
        list(FullSystem(model.condensed, problem, 5.0).follow([Motion(*row) for row in ROWS]))


def test_stages_of_a_full_run_leave_condensing_out():
    run = run_once(Method("plane strain", "P2", plates="none", solve="full"), 0.4)
    assert run.seconds["condense"] == 0.0
    assert run.seconds["increments"] > 0.0
