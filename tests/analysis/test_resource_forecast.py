"""The forecast against real meshers and models, and how it moves with what it rests on."""

import json

import pytest
import tomlkit
from fingerdesign_bench.any_finger.designs import random_design
from fingerdesign_cli.main import main

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.forecast.elements import count_space
from fingerdesign.analysis.forecast.forecast import forecast_case, forecasts
from fingerdesign.analysis.stages import condense, make_mesh, zone_of
from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.checks.starter import find_scene, shipped_path
from fingerdesign.design.scene import SceneObject
from fingerdesign.layout.frames import mirrors_in_z
from fingerdesign.layout.zone import candidate_zone
from fingerdesign.mesh.cache import keep_mesh, mesh_key
from fingerdesign.mesh.sizing import MeshSizes
from fingerdesign.runtime.machine import Machine

MACHINE = Machine(60.0, 110.0, 2)
SWEPT = {"mesh.mesher": "extrude"}
COARSE = SWEPT | {"mesh.contact_size_mm": 0.6, "mesh.plate_size_mm": 0.8, "mesh.layers": 3}
# Tetrahedra that fTetWild made of random designs (bench any-finger): seed -> elements.
MADE = {0: 4720, 3: 28171, 5: 13081, 6: 9148, 12: 13240, 13: 7400, 18: 3847, 23: 10809, 43: 24747}


def shipped(name, values=None):
    design = load_design(shipped_path(name))
    return with_values(design, values) if values else design


@pytest.mark.parametrize(
    ("design", "fidelity"),
    [
        (shipped("homogeneous"), "plane-strain"),
        (shipped("narrow"), "plane-strain"),
        (shipped("boned"), "plane-strain"),
        (shipped("narrow", {"mesh.element": "P1"}), "plane-strain"),
        (shipped("narrow", {"plates.model": "sheet"}), "plane-strain"),
        (shipped("homogeneous", COARSE), "3d"),
        (shipped("narrow", COARSE), "3d"),
        (shipped("narrow", COARSE | {"mesh.element": "P2", "plates.span_mm": 6.0}), "3d"),
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
        (reported.operations, model.condensed.condensation.operations),
    ):
        assert 0.5 < predicted / found < 2.0


@pytest.mark.parametrize("seed", MADE)
def test_tetrahedra_are_predicted_as_they_were_made(seed):
    design = parse_design(tomlkit.dumps(random_design(seed)))
    zone = candidate_zone(design, SceneObject(), 0.02 * design.body.base_height_mm)
    reported = count_space(design, zone, mirrors_in_z(design)).tetrahedra
    assert 0.5 < reported / MADE[seed] < 2.0


@pytest.mark.slow
def test_a_model_of_tetrahedra_is_predicted():
    case = Case(shipped("homogeneous"))
    reported = forecast_case(case, MACHINE)
    zone = zone_of(case, case.path_scene)
    model = condense(case.design, make_mesh(case.design, "3d", zone), zone, case.path_scene)
    assert 0.5 < reported.dofs / model.dofs < 2.0
    assert 0.5 < reported.contact_nodes / model.reduced.nodes < 2.0
    assert 0.4 < reported.operations / model.condensed.condensation.operations < 2.5


@pytest.mark.parametrize(
    ("fidelity", "values", "keys"),
    [
        ("plane-strain", {}, ("section.contact_size_mm", "section.plate_size_mm")),
        ("plane-strain", {}, ("section.plate_end_size_mm", "section.far_size_mm")),
        ("3d", {}, ("contact_size_mm", "plate_size_mm", "far_size_mm")),
        ("3d", SWEPT | {"plates.model": "none"}, ("contact_size_mm", "far_size_mm")),
    ],
)
def test_finer_costs_more(fidelity, values, keys, monkeypatch, tmp_path):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path))
    design = shipped("narrow", values)
    said = design.model_dump()["mesh"]
    for key in keys:
        table = said["section"] if key.startswith("section.") else said
        size = table[key.rpartition(".")[2]]
        sizes = (size, 0.5 * size, 0.25 * size)
        found = [
            forecast_case(Case(with_values(design, {f"mesh.{key}": each}), None, fidelity), MACHINE)
            for each in sizes
        ]
        assert found[0].dofs < found[1].dofs < found[2].dofs
        assert found[0].operations < found[1].operations < found[2].operations
        assert found[0].memory_MB <= found[1].memory_MB <= found[2].memory_MB
        assert found[0].total_s < found[1].total_s < found[2].total_s


def test_more_is_requested_more_is_predicted():
    design = shipped("narrow")
    slow = forecast_case(Case(design, None, "plane-strain"), Machine(30.0, 55.0, 2))
    reported = forecast_case(Case(design, None, "plane-strain"), MACHINE)
    assert slow.total_s == pytest.approx(2.0 * reported.total_s)
    alone = forecast_case(Case(design, find_scene("fundamental"), "plane-strain"), MACHINE)
    assert "grips" in reported.seconds
    assert "grips" not in alone.seconds
    assert alone.total_s < reported.total_s
    swept = shipped("narrow", SWEPT)
    half = forecast_case(Case(swept, find_scene("fundamental"), "3d"), MACHINE)
    whole = forecast_case(Case(swept, find_scene("twist"), "3d"), MACHINE)
    assert half.half
    assert not whole.half
    assert 1.6 < whole.elements / half.elements < 2.2


def test_a_mesh_in_the_cache_is_counted_as_it_is(monkeypatch, tmp_path):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path))
    case = Case(shipped("homogeneous"))
    zone = zone_of(case, case.path_scene)
    before = forecast_case(case, MACHINE)
    swept = with_values(case.design, COARSE)
    mesh = make_mesh(swept, "3d", zone)
    sizes = MeshSizes.of(case.design, zone.half_width, zone.half_depth)
    keep_mesh(mesh_key(case.design, sizes, (zone.half_width, zone.half_depth), True), mesh)
    again = forecast_case(case, Machine(60.0, 110.0, 3))  # not the forecast remembered
    model = condense(case.design, mesh, zone, case.path_scene)
    assert (again.dofs, again.contact_nodes) == (model.dofs, model.reduced.nodes)
    assert again.seconds["mesh"] < 0.2 * before.seconds["mesh"]
    assert "in the cache" in again.words
    assert (before.mesh_kept, again.mesh_kept) == (False, True)


def test_what_cannot_be_analysed_is_not_predicted():
    assert [each.fidelity for each in forecasts(shipped("narrow"))] == ["plane-strain", "3d"]
    assert [each.fidelity for each in forecasts(shipped("both_ways"))] == ["3d"]
    flat = forecasts(shipped("narrow"), find_scene("ball"))
    assert [each.fidelity for each in flat] == ["3d"]


def test_check_shows_the_forecast(capsys):
    assert main(["check", "narrow", "--json"]) == 0
    (report,) = json.loads(capsys.readouterr().out)
    reported = {each["fidelity"]: each for each in report["forecast"]}
    assert set(reported) == {"plane-strain", "3d"}
    for each in reported.values():
        assert each["dofs"] > 10_000
        assert each["memory_MB"] > 100
        assert each["time_s"] == pytest.approx(sum(each["timings_s"].values()), abs=0.1)
    assert main(["check", "narrow"]) == 0
    out = capsys.readouterr().out
    assert "What analyse will take" in out
    assert str(reported["plane-strain"]["dofs"]) in out
