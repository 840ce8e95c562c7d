"""Analyses at finite strain: small loads, how Newton ends, what is refused, what is chosen."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import fingerdesign.fem.finite.row as row_module
from fingerdesign import parse_design, parse_scene
from fingerdesign.analysis.case import Case
from fingerdesign.analysis.finite_path import finite_readings
from fingerdesign.analysis.forecast.forecast import impossible
from fingerdesign.checks.load import with_values
from fingerdesign.errors import DesignError
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.pipeline import analyse, run
from tests.fem.test_finite_path import FINGER

COARSE = {
    "mesh.mesher": "sweep",
    "mesh.section.contact_size_mm": 0.3,
    "mesh.section.plate_size_mm": 0.6,
    "mesh.section.plate_end_size_mm": 0.2,
    "mesh.section.gradation": 0.5,
}


def scene_of(rows, more=""):
    return parse_scene(
        f"[object]\nfriction_coefficient = 0.5\n[path]\nincrements_mm = {rows}\n{more}"
    )


@pytest.fixture(scope="module")
def design():
    return with_values(parse_design(FINGER), COARSE)


@pytest.mark.slow
def test_small_loads_read_as_at_small_strain(design):
    """To a thousandth of each one's largest , one micrometre deep."""
    scene = scene_of([[0.001, 0.0], [0.001, 0.0003]], "substeps = 1")  # as at finite strain
    finite, small = (analyse(design, scene, each) for each in ("finite", "3d"))
    assert (finite.fidelity, small.fidelity) == ("finite", "3d")
    for one, other in zip(finite.increments, small.increments, strict=True):
        assert one.normal_force_N == pytest.approx(other.normal_force_N, rel=1e-3)
        assert one.tangential_force_N == pytest.approx(
            other.tangential_force_N, abs=1e-3 * small.increments[-1].tangential_force_N
        )
        assert one.stick_ratio == pytest.approx(other.stick_ratio, abs=5e-3)
    readings = np.array([[gage.reading for gage in row.gages] for row in finite.increments])
    others = np.array([[gage.reading for gage in row.gages] for row in small.increments])
    assert np.abs(readings - others).max() < 1e-3 * np.abs(others).max()
    assert any("finite strain" in reason for reason in finite.model.reasons)


def test_newton_ends_quadratically(design, calls_of, monkeypatch):
    """With a new tangent each time, residuals are squared until rounding."""
    monkeypatch.setattr(row_module, "_NEAR", 0.0)
    rows = calls_of(row_module.Follower, "row")
    plain = with_values(design, {"plates.placement": None, "plates.count": 0})
    zone = Zone(3.0)
    finite_readings(plain, extrude(plain, zone, True), zone, scene_of([[0.2, 0.0], [0.2, 0.05]]))
    for _, row in rows:
        steps = [pair for pair in pairwise(row.residuals) if 1e-6 < pair[0] < 0.1]
        assert steps
        for before, after in steps:
            assert after < 3.0 * before**2 + 1e-9


@pytest.mark.slow
def test_auto_goes_on_to_it_where_the_finger_is_pressed_deep(design):
    """A tenth of the height and more; where it knows not how, the result says what to take."""
    case = Case(design, scene_of([[0.6, 0.0]]), "auto", fields=True, tolerance=0.5)
    found = run(case)
    assert found.result.fidelity == "finite"
    assert found.result.ladder is not None
    assert not any("not small" in warning for warning in found.result.warnings)
    assert any("not small" in reason for reason in found.result.model.reasons)
    assert np.isfinite(found.fields.displacement).all()
    small = run(replace(case, fidelity="3d", fields=False)).result
    assert any("--fidelity finite" in warning for warning in small.warnings)
    assert small.increments[-1].normal_force_N < 0.97 * found.result.increments[-1].normal_force_N


@pytest.mark.parametrize(
    ("values", "rows", "more", "key"),
    [
        ({"plates.model": "sheet"}, [[0.1, 0.0]], "", "plates.model"),
        ({}, [[0.1, 0.0, 0.0, 1.0]], "", "path.increments_mm"),
        ({}, [[0.1, 0.0]], "[readout]\npoints_mm = [[0.0, 3.0, 0.0]]\n", "readout.points_mm"),
    ],
)
def test_what_it_does_not_know_is_refused_before_any_work(design, values, rows, more, key):
    case = Case(with_values(design, values), scene_of(rows, more), "finite")
    assert key in [fault.key for fault in impossible(case, case.path_scene)]
    with pytest.raises(DesignError, match=key):
        run(case)
