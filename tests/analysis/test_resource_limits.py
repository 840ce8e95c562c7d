"""What a machine cannot hold is refused before the work, and only that."""

import re
import time
from dataclasses import replace

import numpy as np
import pytest
import tomlkit
from fingerdesign_bench.any_finger.designs import random_design

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.forecast import limits
from fingerdesign.analysis.forecast.counts import count_space
from fingerdesign.analysis.forecast.forecast import forecast_case, forecasts
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.stages import condense, make_mesh, zone_of
from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.shipped import load_scene
from fingerdesign.errors import DesignError
from fingerdesign.fem.factor import has_pardiso
from fingerdesign.fem.mirror import MirroredCondensation
from fingerdesign.layout.rows import mirrors_in_z
from fingerdesign.layout.zone import candidate_zone
from fingerdesign.mesh.cache import mesh_key, store_mesh
from fingerdesign.mesh.sizing import MeshSizes
from fingerdesign.mesh.types import in_tetrahedra
from fingerdesign.runtime import machine
from fingerdesign.runtime.machine import Machine

MACHINE = Machine(60.0, 110.0, 2)
SWEPT = {"mesh.mesher": "sweep"}
COARSE = SWEPT | {"mesh.contact_size_mm": 0.6, "mesh.plate_size_mm": 0.8, "mesh.layers": 3}


def shipped(name, values=None):
    design = load_design(name)
    return with_values(design, values) if values else design


@pytest.fixture
def case():
    return Case(shipped("narrow", SWEPT | {"mesh.layers": 16}))


def _free(monkeypatch, megabytes):
    monkeypatch.setattr(machine, "available_memory_MB", lambda: megabytes)


def test_more_than_is_free_is_refused_with_key_and_remedy(case, monkeypatch):
    needed = forecast_case(case).memory_MB
    assert needed > 2000.0
    _free(monkeypatch, needed + limits.LEFT_MB + 1.0)
    refuse(case, case.path_scene)
    _free(monkeypatch, needed + limits.LEFT_MB - 1.0)
    refuse(replace(case, go_on=True), case.path_scene)
    with pytest.raises(DesignError) as caught:
        refuse(case, case.path_scene)
    (fault,) = caught.value.faults
    assert fault.key == "mesh.layers"  # thin plates set the section's sizes here
    assert f"{needed:.0f} MB" in fault.bound
    assert "--go-on" in fault.remedy
    assert "plane-strain" in fault.remedy
    coarser = with_values(case.design, {fault.key: int(float(str(fault.value))) // 2})
    less = forecast_case(Case(coarser)).memory_MB
    assert less < 0.6 * needed
    assert f"lower it (at 8 about {less:.0f} MB)" in fault.remedy


def test_small_models_are_never_refused_nor_any_where_memory_is_unknown(case, monkeypatch):
    _free(monkeypatch, 1.0)
    assert limits.memory_faults(Case(shipped("narrow"), fidelity="plane-strain")) == []
    _free(monkeypatch, None)  # a system that does not tell
    assert limits.memory_faults(case) == []
    assert limits.too_large(forecast_case(case)) == ""


BULKY = {"mesh.far_size_mm": 0.6, "mesh.contact_size_mm": 0.6}
FINE = {"mesh.contact_size_mm": 0.1, "mesh.plate_size_mm": 0.1, "mesh.far_size_mm": 0.2}
ASTRONOMIC = {"mesh.contact_size_mm": 0.01, "mesh.plate_size_mm": 0.01, "mesh.far_size_mm": 0.02}
ONE = r"(?:raise|lower) it \(at (?P<one>[\d.]+) about"
ALL = (
    r"no one key suffices: raise mesh.contact.* and mesh.*mm (?P<times>\d+) times each"
    r"(?:, and lower mesh.layers to (?P<layers>\d+))? \(about \d+ MB\), or take "
    r"--fidelity plane-strain or --fidelity auto or --go-on"
)


@pytest.mark.parametrize(
    ("free", "name", "values", "key", "form"),
    [
        (900.0, "homogeneous", BULKY, "mesh.far_size_mm", ONE),  # that saves most
        (4000.0, "narrow", SWEPT | {"mesh.layers": 100}, "mesh.layers", ONE),
        (3000.0, "homogeneous", FINE | SWEPT | {"mesh.layers": 200}, "mesh.contact_size_mm", ALL),
        (8000.0, "homogeneous", ASTRONOMIC, "mesh.contact_size_mm", ALL),
        (8000.0, "homogeneous", ASTRONOMIC | SWEPT, "mesh.contact_size_mm", ALL),
    ],
)
def test_what_is_refused_at_once_names_what_would_fit(free, name, values, key, form, monkeypatch):
    _free(monkeypatch, free)
    design = shipped(name, values)
    start = time.process_time()
    (fault,) = limits.memory_faults(Case(design))
    assert time.process_time() - start < 6.0  # 1.5 s, where nothing else runs
    assert fault.key == key
    reported = re.match(form, fault.remedy)
    assert reported is not None, fault.remedy
    if form == ONE:
        coarser = {key: float(reported["one"])}
    else:
        sizes = {k: value for k, value in values.items() if k.endswith("_mm")}
        assert all(k in fault.remedy for k in sizes)
        coarser = {k: value * int(reported["times"]) for k, value in sizes.items()}
        layers = int(reported["layers"] or 0)
        coarser |= {"mesh.layers": layers} if layers else {}
    if "mesh.layers" in coarser:
        coarser["mesh.layers"] = int(coarser["mesh.layers"])
    assert limits.memory_faults(Case(with_values(design, coarser))) == []


# Tetrahedra that fTetWild made of random designs: seed -> elements.
MADE = {0: 4534, 3: 24645, 5: 9312, 6: 7036, 12: 10441, 13: 6299, 18: 3458, 23: 8496, 43: 26602}


@pytest.mark.parametrize(
    ("design", "fidelity"),
    [
        (shipped("homogeneous"), "plane-strain"),
        (shipped("narrow"), "plane-strain"),
        (shipped("boned"), "plane-strain"),
        (shipped("narrow", {"mesh.element": "P1"}), "plane-strain"),
        (shipped("narrow", {"plates.model": "sheet"}), "plane-strain"),
        (shipped("homogeneous", COARSE), "3d"),
        pytest.param(
            *(shipped("narrow", COARSE | {"mesh.element": "P2", "plates.span_mm": 6.0}), "3d"),
            marks=pytest.mark.slow,
        ),
        pytest.param(
            *(shipped("homogeneous", {"mesh.contact_size_mm": 0.6}), "3d"),  # tetrahedra
            marks=pytest.mark.slow,
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else value.design.name,
)
def test_dofs_and_contact_nodes_are_predicted(design, fidelity):
    case = Case(design, None, fidelity)
    reported = forecast_case(case, MACHINE)
    zone = zone_of(case, case.path_scene)
    mesh = make_mesh(design, fidelity, zone, case.symmetric)
    model = condense(design, mesh, zone, case.path_scene)
    assert reported.element == model.element
    for predicted, found in (
        (reported.elements, len(mesh.cells)),
        (reported.dofs, model.dofs),
        (reported.contact_nodes, model.reduced.nodes),
    ):
        assert 0.5 < predicted / found < 2.0
    free = fidelity == "3d" and design.mesh.mesher == "tetwild"
    low, high = (0.4, 2.5) if free else (0.5, 2.0)
    if not has_pardiso():  # SuperLU's order is another, and so is its count
        low, high = 0.3, 3.0
    assert low < reported.operations / model.condensed.factors()[1].operations < high


def test_a_whole_finger_that_mirrors_is_predicted_by_its_halves():
    coarser = COARSE | {"mesh.layers": 2, "mesh.far_size_mm": 4.0}
    case = Case(shipped("homogeneous", coarser), load_scene("twist"), "3d")
    reported = forecast_case(case, MACHINE)
    zone = zone_of(case, case.path_scene)
    model = condense(case.design, make_mesh(case.design, "3d", zone, False), zone, case.path_scene)
    factors = model.condensed.factors()[1]
    assert isinstance(factors, MirroredCondensation)
    assert 0.5 < reported.operations / factors.operations < 2.0


@pytest.mark.parametrize("seed", MADE)
def test_tetrahedra_are_predicted_as_they_were_made(seed):
    design = parse_design(tomlkit.dumps(random_design(seed)))
    zone = candidate_zone(design, SceneObject(), 0.02 * design.body.base_height_mm)
    reported = count_space(design, zone, mirrors_in_z(design))[0]
    assert 0.5 < reported / MADE[seed] < 2.0


@pytest.mark.parametrize(
    ("fidelity", "values", "keys"),
    [
        ("plane-strain", {}, ("section.contact_size_mm", "section.plate_size_mm")),
        ("plane-strain", {}, ("section.plate_end_size_mm", "section.far_size_mm")),
        ("3d", {}, ("contact_size_mm", "plate_size_mm", "far_size_mm")),
        ("3d", SWEPT | {"plates.model": "none"}, ("contact_size_mm", "far_size_mm")),
    ],
)
def test_finer_costs_more(fidelity, values, keys, own_cache):
    design = shipped("narrow", values)
    tables = design.model_dump()["mesh"]
    for key in keys:
        table = tables["section"] if key.startswith("section.") else tables
        size = table[key.rpartition(".")[2]]
        costs = []
        for share in (1.0, 0.5, 0.25):
            finer = with_values(design, {f"mesh.{key}": share * size})
            found = forecast_case(Case(finer, None, fidelity), MACHINE)
            mesh = found.seconds["mesh"]
            costs.append([found.dofs, found.operations, found.total_s, mesh, found.memory_MB])
        rises = np.diff(costs, axis=0)
        assert (rises[:, :4] > 0).all()
        assert (rises[:, 4] >= 0).all()


def test_more_is_requested_more_is_predicted():
    design = shipped("narrow")
    slow = forecast_case(Case(design, None, "plane-strain"), Machine(30.0, 55.0, 2))
    reported = forecast_case(Case(design, None, "plane-strain"), MACHINE)
    assert slow.total_s == pytest.approx(2.0 * reported.total_s)
    alone = forecast_case(Case(design, load_scene("fundamental"), "plane-strain"), MACHINE)
    assert "grips" in reported.seconds
    assert "grips" not in alone.seconds
    assert alone.total_s < reported.total_s
    # A grip has as many moves as its stage's travel takes, or as its steps allow.
    longer = Case(shipped("narrow", {"grip.max_steps": 2000}), None, "plane-strain")
    shorter = Case(shipped("narrow", {"grip.max_steps": 10}), None, "plane-strain")
    grips = [forecast_case(each, MACHINE).seconds["grips"] for each in (longer, shorter)]
    assert grips[0] == reported.seconds["grips"] > 3.0 * grips[1]
    swept = shipped("narrow", SWEPT)
    gripped, slowly = (
        forecast_case(Case(swept, None, "3d"), machine)
        for machine in (MACHINE, Machine(30.0, 55.0, 2))
    )
    assert slowly.seconds == pytest.approx({k: 2.0 * v for k, v in gripped.seconds.items()})
    half = forecast_case(Case(swept, load_scene("fundamental"), "3d"), MACHINE)
    whole = forecast_case(Case(swept, load_scene("twist"), "3d"), MACHINE)
    assert half.half
    assert not whole.half
    assert 1.6 < whole.elements / half.elements < 2.2


def test_a_mesh_in_the_cache_is_counted_as_it_is(own_cache):
    case = Case(shipped("homogeneous"))
    zone = zone_of(case, case.path_scene)
    before = forecast_case(case, MACHINE)
    swept = with_values(case.design, COARSE)
    mesh = in_tetrahedra(make_mesh(swept, "3d", zone))  # as those that are cached
    sizes = MeshSizes.of(case.design, zone)
    store_mesh(mesh_key(case.design, sizes, zone, True), mesh)
    again = forecast_case(case, Machine(60.0, 110.0, 3))  # not the forecast remembered
    model = condense(case.design, mesh, zone, case.path_scene)
    assert (again.dofs, again.contact_nodes) == (model.dofs, model.reduced.nodes)
    assert again.seconds["mesh"] < 0.2 * before.seconds["mesh"]
    assert "in the cache" in again.words
    assert (before.mesh_kept, again.mesh_kept) == (False, True)


def test_what_cannot_be_analysed_is_not_predicted():
    assert [each.fidelity for each in forecasts(shipped("narrow"))] == ["plane-strain", "3d"]
    assert [each.fidelity for each in forecasts(shipped("both_ways"))] == ["3d"]
    flat = forecasts(shipped("narrow"), load_scene("ball"))
    assert [each.fidelity for each in flat] == ["3d"]


def test_a_changed_copy_that_nobody_judged_is_refused():
    plates = shipped("narrow").plates.model_copy(update={"cover_mm": -1.0})
    case = Case(shipped("narrow").model_copy(update={"plates": plates}), fidelity="plane-strain")
    with pytest.raises(DesignError, match=r"plates\.cover_mm = -1"):
        refuse(case, case.path_scene)
