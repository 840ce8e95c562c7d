"""One condensed model serves the path, every friction and the grips; fields on demand."""

import pytest
from fingerdesign_cli.main import main

from fingerdesign import pipeline
from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.checks.starter import shipped_path
from fingerdesign.errors import DesignError, Fault
from fingerdesign.fem import factor
from fingerdesign.fem.model import FiniteElementModel

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


def test_one_factorisation_serves_frictions_and_grips(counted):
    design = with_values(load_design(shipped_path("narrow")), COARSE)
    analysis = pipeline.run(Case(design, None, "plane-strain", fields=False))
    assert len(analysis.slip_studies) >= 5  # friction coefficients
    assert len(analysis.result.grips) == 2
    assert counted == {"factored": 1, "fields": 0}
    assert analysis.fields is None


def test_fields_are_recovered_where_they_are_requested_for(counted):
    design = with_values(load_design(shipped_path("narrow")), COARSE)
    case = Case(design, fundamental_scene(), "plane-strain", grips=False)
    assert pipeline.run(case).fields is not None
    assert counted == {"factored": 1, "fields": 1}


def test_analyse_can_be_reported_to_leave_fields_out(monkeypatch, tmp_path):
    cases = []

    def stop(case, out, report):
        cases.append(case)
        raise DesignError([Fault("test", 0, "ended here", "none")])

    monkeypatch.setattr("fingerdesign.pipeline.analyse_into", stop)
    for more in ([], ["--no-fields", "--go-on"]):
        assert main(["analyse", "narrow", "--out", str(tmp_path), "-q", *more]) == 2
    assert [(case.fields, case.go_on) for case in cases] == [(True, False), (False, True)]
