"""Work-precision diagrams: a short one of its own, what is written, and how failures are named."""

import csv
import json

import numpy as np
import pytest
from fingerdesign_bench.machine import machine
from fingerdesign_bench.speed import precision_run
from fingerdesign_bench.speed.precision import measure_precision, shown
from fingerdesign_bench.speed.precision_lines import Chart, Group, Line, Reference
from fingerdesign_bench.speed.precision_plan import CHARTS
from fingerdesign_bench.speed.precision_run import QUANTITIES, STAGES, Method, errors, sized

from fingerdesign.errors import MeshError

FINE = Reference("fine", Method("plane strain", "mixed"), 0.2, 0.2)
OTHER = Reference("other", Method("plane strain", "P2"), 0.2, 0.2)
LINES = (
    Line("P2", Method("plane strain", "P2"), (0.8, 0.4), FINE),
    Line("P1", Method("plane strain", "P1", 0.4999), (0.8,), FINE, "locks"),
    Line("broken", Method("extruded", "P2"), (0.8,), FINE),
)
CHART = Chart("short", "A short chart", (Group("all", LINES, (FINE, OTHER)),))


@pytest.fixture(scope="module")
def found():
    whole = precision_run.run_once

    def run_once(method, size):
        if method.kind == "extruded":
            raise MeshError("no mesh today")
        return whole(method, size)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(precision_run, "run_once", run_once)
        yield measure_precision(lambda message: None, quick=True, charts=[CHART])


def test_points_stages_and_errors(found):
    assert [(p.line.label, p.run.size_mm) for p in found.points] == [
        ("P2", 0.8),
        ("P2", 0.4),
        ("P1", 0.8),
        ("broken", 0.8),
    ]
    good = found.points[0].record()
    assert good["element"] == "P2"
    assert good["dofs"] > 1000
    assert good["seconds"] == pytest.approx(sum(good[f"{stage}_s"] for stage in STAGES))
    assert good["gflop"] > 0.0
    assert good["cpu_s"] > 0.0
    assert all(0.0 < good[key] < 0.2 for key in QUANTITIES)
    assert found.differences["short", "all"]["normal_force_error"] > 0.0


def test_failures_and_locking_are_named(found):
    failed = found.points[-1].record()
    assert failed["failure"] == "no mesh today"
    assert failed["normal_force_error"] is None
    remarks = found.remarks["short"]
    assert any(each.startswith("P1 (all): locks: F_n still") for each in remarks)
    assert "broken (all), 0.8 mm: failed: no mesh today" in remarks


def test_what_is_written(found, tmp_path):
    paths = shown(found, tmp_path, machine()).write(tmp_path, "precision")
    names = ["precision.csv", "precision.json", "precision-short.png"]
    assert [path.name for path in paths if path.stat().st_size > 0] == names
    rows = list(csv.DictReader(paths[0].read_text("utf-8").splitlines()))
    assert len(rows) == 4
    assert {"chart", "line", "seconds", "mesh_s", "gage_error", "failure"} <= set(rows[0])
    assert rows[-1]["failure"] == "no mesh today"
    record = json.loads(paths[1].read_text("utf-8"))
    assert record["references"]["fine"]["element"] == "mixed"
    assert "processor" in record["machine"]
    assert record["remarks"]["short"]


def test_errors_by_hand():
    reference = np.tile([2.0, 1.0, 0.5, 4.0, 2.0], (5, 1))
    found = reference.copy()
    found[1] = [2.2, 3.0, 0.4, 4.4, 2.2]  # not sheared yet: its F_t does not count
    found[3, 1] = 1.05
    worst = errors(found, reference)
    assert [*worst] == [*QUANTITIES]
    assert [*worst.values()] == pytest.approx([0.1, 0.05, 0.1, 0.1, 0.1])


def test_the_plan_is_whole():
    """Every line is judged by a finer reference, of another method than its own."""
    for chart in CHARTS:
        for group in chart.groups:
            for line in group.lines:
                judge = line.reference
                assert chart.fingers or judge.method != line.method
                if judge.method.kind != "plane strain" and line.method.kind == "plane strain":
                    assert line.floor  # the model's own error is what it shows
                else:
                    assert judge.size_mm <= min(line.sizes)
                assert sized(line.method, line.sizes[0]).mesh.element == line.method.element
