"""What a machine cannot hold is refused before the work, and only that."""

import re
import time

import pytest

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.forecast import elements, limits
from fingerdesign.analysis.forecast.elements import count_section, count_space
from fingerdesign.analysis.forecast.forecast import forecast_case
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.stages import zone_of
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.checks.starter import shipped_path
from fingerdesign.errors import DesignError
from fingerdesign.runtime import machine


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


def test_reported_to_go_on_it_is_not_refused(case, monkeypatch):
    _free(monkeypatch, 1.0)
    refuse(Case(case.design, go_on=True), case.path_scene)


def test_where_coarser_meshes_do_not_help_none_is_advised(case, monkeypatch):
    _free(monkeypatch, 900.0)
    monkeypatch.setattr(limits, "_fits", lambda found, free: False)
    (fault,) = limits.memory_faults(case)
    assert fault.remedy == (
        "no coarser mesh of it fits: free some memory, or take --fidelity auto or --go-on to try "
        "all the same"
    )


ASTRONOMIC = {"mesh.contact_size_mm": 0.01, "mesh.plate_size_mm": 0.01, "mesh.far_size_mm": 0.02}


@pytest.mark.parametrize("mesher", ["tetwild", "extrude"])
def test_an_astronomic_mesh_is_refused_at_once_with_what_would_fit(mesher, monkeypatch):
    _free(monkeypatch, 8000.0)
    design = load_design(shipped_path("homogeneous"))
    huge = Case(with_values(design, ASTRONOMIC | {"mesh.mesher": mesher}))
    start = time.process_time()
    (fault,) = limits.memory_faults(huge)
    assert time.process_time() - start < 6.0  # 1.5 s, where nothing runs beside
    assert fault.key == "mesh.contact_size_mm"
    reported = re.search(
        r"no one key suffices: raise (.*) and (.*) (\d+) times each \(about (\d+) MB\), or take "
        r"--fidelity plane-strain or --fidelity auto or --go-on",
        fault.remedy,
    )
    assert reported is not None
    keys = [*reported[1].split(", "), reported[2]]
    assert set(keys) == set(ASTRONOMIC)
    coarser = {key: ASTRONOMIC[key] * int(reported[3]) for key in keys}
    assert limits.memory_faults(Case(with_values(huge.design, coarser))) == []


def test_one_key_is_changed_as_far_as_it_takes(case, monkeypatch):
    _free(monkeypatch, 4000.0)
    many = Case(with_values(case.design, {"mesh.layers": 100}))
    (fault,) = limits.memory_faults(many)
    reported = re.match(r"lower it \(at (\d+) about", fault.remedy)
    assert reported is not None
    assert int(reported[1]) < 50
    fewer = with_values(many.design, {"mesh.layers": int(reported[1])})
    assert limits.memory_faults(Case(fewer)) == []


def test_sizes_and_layers_together_are_named_where_neither_suffices(monkeypatch):
    _free(monkeypatch, 3000.0)
    design = load_design(shipped_path("homogeneous"))
    fine = {"mesh.contact_size_mm": 0.1, "mesh.plate_size_mm": 0.1, "mesh.far_size_mm": 0.2}
    many = with_values(design, fine | {"mesh.mesher": "extrude", "mesh.layers": 200})
    (fault,) = limits.memory_faults(Case(many))
    reported = re.search(
        r"suffices: .* (\d+) times each(?:, and lower mesh.layers to (\d+))? \(", fault.remedy
    )
    assert reported is not None
    values = {key: value * int(reported[1]) for key, value in fine.items()}
    values |= {"mesh.layers": int(reported[2] or 200)}
    assert limits.memory_faults(Case(with_values(many, values))) == []


def test_counts_of_some_cells_are_those_of_all(monkeypatch):
    design = with_values(load_design(shipped_path("narrow")), {"mesh.contact_size_mm": 0.05})
    case = Case(design)
    zone = zone_of(case, case.path_scene)
    space = count_space(design, zone, True).tetrahedra
    flat = count_section(design, zone.half_width, design.mesh.section).triangles
    monkeypatch.setattr(elements, "_MOST_CELLS", 20_000)
    monkeypatch.setattr(elements, "_SECTION_CELLS", 1_000)
    assert count_space(design, zone, True).tetrahedra == pytest.approx(space, rel=0.05)
    few = count_section(design, zone.half_width, design.mesh.section).triangles
    assert few == pytest.approx(flat, rel=0.05)
    assert few != flat


def test_small_models_are_never_refused(monkeypatch):
    _free(monkeypatch, 1.0)
    flat = Case(load_design(shipped_path("narrow")), fidelity="plane-strain")
    assert limits.memory_faults(flat) == []


def test_a_system_that_does_not_tell_refuses_nothing(case, monkeypatch):
    _free(monkeypatch, None)
    assert limits.memory_faults(case) == []
    assert limits.too_large(forecast_case(case)) == ""
