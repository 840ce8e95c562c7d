"""bench speed and the frame of all benches: records, power laws, targets, what is written."""

import json
from dataclasses import replace

import pytest
from fingerdesign_bench.check import Check, Shown
from fingerdesign_bench.cli.bench import run_parts
from fingerdesign_bench.machine import busy, caption, machine
from fingerdesign_bench.speed import speed as bench
from fingerdesign_bench.speed.coupling import QUICK, Coupled, coupled
from fingerdesign_bench.speed.growth import Size, fit
from fingerdesign_bench.speed.speed import PLANE, SPACE, measure_speed, run_case, target_checks
from fingerdesign_bench.speed.speed_worker import timed_grip, timed_path

from fingerdesign.errors import SolverError


def size(kind=PLANE, dofs=1000, nodes=10, **given):
    parts = dict.fromkeys(("mesh_s", "assemble_s", "condense_s"), 0.1)
    model = {"model_s": 1e-5 * dofs**1.5, "increment_s": 1e-6 * nodes**2, "worst_increment_s": 1.0}
    whole = {"total_s": 0.5, "cold_s": 0.6, "memory_MB": 0.01 * dofs, "base_MB": 100.0}
    return Size(kind=kind, dofs=dofs, contact_nodes=nodes, **(parts | model | whole | given))


grips = {PLANE: {"contact_nodes": 100, "runs": [{"per_200": 0.5}, {"per_200": 0.3}]}}
planes = [size(dofs=n) for n in (1000, 5000, 33000)]
spaces = [size(SPACE, n, 500, increment_s=0.05) for n in (1e3, 1e4, 5e4, 100_000, 200_000)]


@pytest.mark.slow
def test_a_case_in_a_process_of_its_own():
    case = {"fidelity": "plane-strain", "contact": 0.4, "far": 2.0, "layers": 1, "runs": 2}
    found = run_case(timed_path, case)
    assert found["memory_MB"] >= found["base_MB"] > 10
    assert len(found["runs"]) == 2
    run = found["runs"][0]
    assert len(run["increments_s"]) == 16
    assert run["total_s"] >= run["model_s"] >= run["mesh_s"] + run["assemble_s"] + run["condense_s"]
    with pytest.raises(SolverError, match="failed: KeyError: 'contact'"):
        run_case(timed_path, {"fidelity": "plane-strain", "runs": 1})


@pytest.mark.slow
def test_a_grip_has_200_moves_or_more():
    values = {"mesh.section.contact_size_mm": 0.4, "mesh.section.plate_size_mm": 0.4}
    found = run_case(timed_grip, {"fidelity": "plane-strain", "runs": 1, "values": values})
    run = found["runs"][0]
    assert run["moves"] >= 200
    assert run["per_200"] == pytest.approx(run["seconds"] * 200 / run["moves"])


@pytest.mark.slow
def test_pads_in_mujoco_are_measured_against_their_targets():
    pytest.importorskip("mujoco", reason="pip install 'fingerdesign[mujoco]' brings it")
    found = Coupled(**run_case(coupled, {**QUICK, "seconds": 0.2}))
    step, wrench, _, mass = found.checks()
    assert found.contact_nodes > 100
    assert step.measured == found.step_ms > 0.0
    assert found.parts >= 1.0
    assert wrench.holds
    assert mass.holds
    title, headings, (row,) = found.table()
    assert str(found.contact_nodes) in title
    assert len(headings) == len(row)
    missed = replace(found, drift=0.02, mass=1.3).checks()
    assert [check.holds for check in missed][2:] == [False, False]


def test_power_laws():
    laws = fit(PLANE, [size(dofs=n, nodes=n // 100) for n in (1000, 3000, 9000)])
    exponents = {law.quantity: law.exponent for law in laws}
    assert exponents == pytest.approx({"model_s": 1.5, "memory_MB": 1.0, "increment_s": 2.0})
    assert fit(PLANE, [size(dofs=n, nodes=n // 100) for n in (1000, 3000)]) == []  # fewer than 3


def test_measurements_against_their_targets():
    checks = {check.name: check.holds for check in target_checks([*planes, *spaces], grips)}
    assert checks["3-D, 100000 dofs, 500 contact nodes: mean increment, warm"] is False
    assert checks["plane strain, 33000 dofs, nu = 0.49: mesh to last of 16 increments, warm"]
    assert checks["3-D, 200000 dofs: peak memory of the process"]
    grip = "plane strain, maeno2000, 100 contact nodes: 200 steps of a grip (model apart), warm"
    assert checks[grip]
    assert target_checks(planes[:1], {}) == []


def test_what_is_written(tmp_path, monkeypatch):
    sizes = iter([*planes, *spaces[:2]])
    monkeypatch.setattr(bench, "_size", lambda *given: next(sizes))
    pads = {"contact_nodes": 9, "step_ms": 1.0, "parts": 1.0, "wrench_N": 0, "drift": 0, "mass": 1}
    monkeypatch.setattr(
        bench, "run_case", lambda work, _: pads if work is coupled else grips[PLANE]
    )
    paths = measure_speed(tmp_path, lambda message: None, quick=True).write(tmp_path, "speed")
    assert [path.name for path in paths] == ["speed.csv", "speed.json", "speed.png"]
    record = json.loads(paths[1].read_text("utf-8"))
    assert record["growth"][0]["exponent"] == pytest.approx(1.5)
    assert paths[0].read_text("utf-8").count("\n") == 6
    assert paths[2].stat().st_size > 10_000


def test_a_busy_machine_is_named():
    quiet = machine() | {"load_average": 2.0, "cores": 2}
    assert busy(quiet) == busy(quiet | {"load_average": None}) == ""
    assert all(each in caption(quiet) for each in ("cores", "numpy", "mkl"))
    loaded = quiet | {"load_average": 7.15}
    warning = "busy machine (load 7.15 on 2 cores): times are not comparable"
    assert busy(loaded) == warning
    assert caption(loaded).splitlines()[0] == warning.upper()


def test_one_part_that_fails_does_not_stop_the_others(tmp_path):
    sampled = []

    def good(folder, report, quick):
        report("at work")
        return Shown(checks=[Check("a number", 1.0, 2.0, "s")], rows=[{"a": 1}])

    def bad(folder, report, quick):
        raise SolverError("it has no answer")

    found, failures = run_parts(tmp_path, sampled.append, True, {"bad": bad, "good": good})
    assert sampled == ["good: at work"]
    assert found.code == 1
    assert failures == {"bad": "it has no answer"}
    found.write(tmp_path, "bench")
    record = json.loads((tmp_path / "bench.json").read_text("utf-8"))
    assert record["files"] == ["good.csv", "good.json"]
    assert (tmp_path / "good.csv").read_text("utf-8") == "a\n1\n"
    assert record["failures"] == failures
    assert record["checks"][0]["holds"] is False
