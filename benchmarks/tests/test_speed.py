"""bench speed: records, power laws, what is requested against what is measured; the suite."""

import json
import os

import numpy as np
import pytest
from fingerdesign_bench.check import Check
from fingerdesign_bench.machine import busy, caption, machine
from fingerdesign_bench.speed import throughput
from fingerdesign_bench.speed.assembly import compared
from fingerdesign_bench.speed.full_solve import FullSystem, as_increment
from fingerdesign_bench.speed.growth import Size, fit
from fingerdesign_bench.speed.precision_run import ROWS, Method, run_once, sized
from fingerdesign_bench.speed.speed import PLANE, SPACE, Speed, _checks, run_case, write_speed
from fingerdesign_bench.speed.steps import SAME, replayed
from fingerdesign_bench.speed.throughput import Throughput, Throughputs, measure_throughput
from fingerdesign_bench.suite import run_suite

from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.design.scene import SceneObject
from fingerdesign.errors import SolverError
from fingerdesign.fem.model import build_model
from fingerdesign.layout.frames import crest_height
from fingerdesign.layout.zone import Zone, candidate_zone
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import bump


def size(kind=PLANE, dofs=1000, nodes=10, **given):
    values = {
        "mesh_s": 0.1,
        "assemble_s": 0.1,
        "condense_s": 0.1,
        "model_s": 1e-5 * dofs**1.5,
        "increment_s": 1e-6 * nodes**2,
        "worst_increment_s": 1.0,
        "total_s": 0.5,
        "cold_s": 0.6,
        "memory_MB": 0.01 * dofs,
        "base_MB": 100.0,
    }
    return Size(kind=kind, dofs=dofs, contact_nodes=nodes, **(values | given))


def test_a_case_in_a_process_of_its_own():
    case = {"fidelity": "plane-strain", "contact": 0.4, "far": 2.0, "layers": 1, "runs": 2}
    found = run_case(case)
    assert found["memory_MB"] >= found["base_MB"] > 10
    assert len(found["runs"]) == 2
    run = found["runs"][0]
    assert len(run["increments"]) == 16
    assert run["total"] >= run["model"] >= run["mesh"] + run["assemble"] + run["condense"]


def test_a_grip_has_200_moves_or_more():
    values = {"mesh.section.contact_size_mm": 0.4, "mesh.section.plate_size_mm": 0.4}
    found = run_case({"grip": True, "fidelity": "plane-strain", "runs": 1, "values": values})
    run = found["runs"][0]
    assert run["moves"] >= 200
    assert run["per_200"] == pytest.approx(run["seconds"] * 200 / run["moves"])


def test_a_case_that_fails_says_why():
    with pytest.raises(SolverError, match="failed: KeyError: 'contact'"):
        run_case({"fidelity": "plane-strain", "runs": 1})


def test_power_laws():
    laws = fit(PLANE, [size(dofs=n, nodes=n // 100) for n in (1000, 3000, 9000)])
    exponents = {law.quantity: law.exponent for law in laws}
    assert exponents == pytest.approx({"model_s": 1.5, "memory_MB": 1.0, "increment_s": 2.0})
    assert laws[0].late_exponent is None
    assert fit(SPACE, [size()]) == []
    assert fit(PLANE, [size(dofs=n, nodes=n // 100) for n in (1000, 3000)]) == []  # fewer than 3


def test_what_is_requested_and_written(tmp_path):
    plane = [size(dofs=n) for n in (1000, 5000, 33000)]
    space = [size(SPACE, n, 500, increment_s=0.05) for n in (1e3, 1e4, 5e4, 100_000, 200_000)]
    grips = {PLANE: {"contact_nodes": 100, "runs": [{"per_200": 0.5}, {"per_200": 0.3}]}}
    checks = _checks([*plane, *space], grips)
    verdicts = {check.name: check.holds for check in checks}
    assert verdicts["3-D, 100000 dofs, 500 contact nodes: mean increment, warm"] is False
    assert verdicts["plane strain, 33000 dofs, nu = 0.49: mesh to last of 16 increments, warm"]
    assert verdicts["3-D, 200000 dofs: peak memory of the process"]
    grip = "plane strain, maeno2000, 100 contact nodes: 200 steps of a grip (model apart), warm"
    assert verdicts[grip]
    assert len(_checks(plane[:1], {})) == 0
    laws = tuple(fit(PLANE, plane))
    found = Speed((*plane, *space), laws, grips, tuple(checks), machine(), 1.0, True)
    paths = write_speed(found, tmp_path)
    assert [path.name for path in paths] == ["speed.csv", "speed.json", "speed.png"]
    record = json.loads(paths[1].read_text("utf-8"))
    assert len(record["checks"]) == len(checks)
    assert record["growth"][0]["exponent"] == pytest.approx(1.5)
    assert paths[2].stat().st_size > 10_000


def test_a_busy_machine_is_named():
    quiet = machine() | {"load_average": 2.0, "cores": 2}
    assert busy(quiet) == busy(quiet | {"load_average": None}) == ""
    assert "BUSY" not in caption(quiet)
    assert all(each in caption(quiet) for each in ("cores", "numpy", "mkl"))
    loaded = quiet | {"load_average": 7.15}
    said = "busy machine (load 7.15 on 2 cores): times are not comparable"
    assert busy(loaded) == said
    assert caption(loaded).splitlines()[0] == said.upper()


def run(workers, seconds, cost=1.0):
    return Throughput(workers, 12, 10, {"invalid": 2}, seconds, (cost,) * 10)


def failing(found):
    return [check.name for check in found.checks() if not check.holds]


def test_the_ratio_and_the_cost_are_held_to_what_is_requested():
    good = Throughputs((run(1, 20.0), run(2, 11.0)), {})
    assert good.runs[0].an_hour == pytest.approx(1800.0)
    assert good.ratio == pytest.approx(20.0 / 11.0)
    assert failing(good) == []
    assert failing(Throughputs((run(1, 20.0), run(2, 12.0)), {})) == [
        "12 variants: time on 2 workers over 1"
    ]
    assert len(failing(Throughputs((run(1, 20.0, 2.1), run(2, 11.0)), {}))) == 1
    assert json.loads(json.dumps(good.as_dict()))["ratio"] == pytest.approx(20.0 / 11.0)


@pytest.mark.slow
def test_two_variants_are_measured_in_caches_of_their_own(monkeypatch, tmp_path):
    monkeypatch.setattr(throughput, "QUICK_VARIANTS", 2)
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path))
    found = measure_throughput(quick=True)
    assert [each.workers for each in found.runs] == [1, 2]
    assert all(each.analysed + sum(each.failures.values()) == 2 for each in found.runs)
    assert all(cost > 0.1 for each in found.runs for cost in each.core_seconds)
    assert os.environ["FINGERDESIGN_CACHE"] == str(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_one_part_that_fails_does_not_stop_the_others(tmp_path):
    sampled = []

    def good(folder, report, quick):
        report("at work")
        path = folder / "good.csv"
        path.write_text("a\n", encoding="utf-8")
        return [path], [Check("a number", 1.0, 2.0, "s")]

    def bad(folder, report, quick):
        raise SolverError("it has no answer")

    found = run_suite(tmp_path / "new", sampled.append, True, {"bad": bad, "good": good})
    assert sampled == ["good: at work"]
    assert found.failures == {"bad": "it has no answer"}
    record = json.loads((tmp_path / "new" / "bench.json").read_text("utf-8"))
    assert record["files"] == ["good.csv"]
    assert record["failures"] == found.failures
    assert record["checks"][0]["holds"] is False
    assert record["quick"] is True
    assert set(record["machine"]["versions"]) >= {"numpy", "scipy", "mkl", "pypardiso", "pytetwild"}


@pytest.mark.parametrize(("dimension", "count"), [(2, 5), (3, 3)])
def test_the_stiffness_is_that_of_scikit_fem(dimension, count):
    ours, theirs, difference, dofs = compared(dimension, count)
    assert dofs == dimension * (2 * count + 1) ** dimension
    assert difference < 1e-13
    assert ours > 0.0
    assert theirs > 0.0


def both(kind, size, plates="none"):
    design = sized(Method(kind, "P2", plates=plates), size)
    zone = candidate_zone(design, SceneObject(), ROWS[-1][0]).half_width
    mesh = mesh_section(design, zone) if kind == "plane strain" else extrude(design, Zone(zone))
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


def test_steps_are_replayed_both_ways():
    problem = contact_problem(bump(9), Plane(0.0), 0.3)
    motions = [Motion(0.01, 0.0), *(Motion(0.01 + 1e-4 * k, 3e-4 * k) for k in range(10))]
    anew, followed, difference = replayed(problem, motions)
    assert anew.shape == followed.shape == (11,)
    assert min(anew.min(), followed.min()) > 0.0
    assert 0.0 < difference < SAME
