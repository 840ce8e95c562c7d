"""What a machine cannot hold is refused before the work, and only that."""

import pytest

from fingerdesign.case import Case
from fingerdesign.design.io import load_design, with_values
from fingerdesign.design.starter import shipped_path
from fingerdesign.errors import DesignError
from fingerdesign.pipeline import refuse
from fingerdesign.resources import limits, machine
from fingerdesign.resources.forecast import forecast_case


@pytest.fixture
def case():
    design = load_design(shipped_path("narrow"))
    return Case(with_values(design, {"mesh.mesher": "extrude"}))


def _free(monkeypatch, megabytes):
    monkeypatch.setattr(machine, "available_memory_MB", lambda: megabytes)


def test_more_than_is_free_is_refused_with_key_and_remedy(case, monkeypatch):
    needed = forecast_case(case).memory_MB
    assert needed > 600.0
    _free(monkeypatch, needed + limits.LEFT_MB + 1.0)
    refuse(case, case.path_scene)
    _free(monkeypatch, needed + limits.LEFT_MB - 1.0)
    with pytest.raises(DesignError) as caught:
        refuse(case, case.path_scene)
    (fault,) = caught.value.faults
    assert fault.key == "mesh.layers"  # thin plates set the section's sizes here
    assert f"{needed:.0f} MB" in fault.bound
    assert "--go-on" in fault.remedy
    assert "plane-strain" in fault.remedy
    coarser = with_values(case.design, {fault.key: int(str(fault.value)) // 2})
    less = forecast_case(Case(coarser)).memory_MB
    assert less < 0.6 * needed
    assert f"lower it (at 4 about {less:.0f} MB)" in fault.remedy


def test_the_size_that_saves_most_is_named(monkeypatch):
    _free(monkeypatch, 900.0)
    fine = {"mesh.far_size_mm": 0.6, "mesh.contact_size_mm": 0.6}
    bulky = Case(with_values(load_design(shipped_path("homogeneous")), fine))
    (fault,) = limits.memory_faults(bulky)
    assert fault.key == "mesh.far_size_mm"
    assert fault.remedy.startswith("raise it (at 1.2 about ")


def test_told_to_go_on_it_is_not_refused(case, monkeypatch):
    _free(monkeypatch, 1.0)
    refuse(Case(case.design, go_on=True), case.path_scene)


def test_where_coarser_meshes_do_not_help_none_is_advised(case, monkeypatch):
    _free(monkeypatch, 900.0)
    monkeypatch.setattr(limits, "_HELPS", 0.1)
    (fault,) = limits.memory_faults(case)
    assert fault.remedy.startswith("free some memory")


def test_small_models_are_never_refused(monkeypatch):
    _free(monkeypatch, 1.0)
    flat = Case(load_design(shipped_path("narrow")), fidelity="plane-strain")
    assert limits.memory_faults(flat) == []


def test_a_system_that_does_not_tell_refuses_nothing(case, monkeypatch):
    _free(monkeypatch, None)
    assert limits.memory_faults(case) == []
    assert limits.too_large(forecast_case(case)) == ""
