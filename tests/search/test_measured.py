"""Metrics and traces against results made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import with_values
from fingerdesign.checks.starter import find_design
from fingerdesign.layout.frames import plate_frames
from fingerdesign.records.arrays import OPEN, SLIP, STICK, ContactHistory, GripTrace
from fingerdesign.records.result import (
    GageResult,
    GripResult,
    IncrementResult,
    MeshSummary,
    ModelSummary,
    Result,
)
from fingerdesign.search.run.measured import (
    grip_metrics,
    grips_of,
    metrics_of,
    own_metrics,
    stick_error_of,
    traces_of,
)
from fingerdesign.search.study.file import Cost

DESIGN = with_values(find_design("narrow"), {"plates.count": 2, "plates.pitch_mm": 2.0})

MODEL, MESH = ModelSummary(2, "t", 10, 5, False), MeshSummary("m", 3, 30.0, 0.0, None)


def row(approach, shear, normal, tangential, stick, readings=(0.0, 0.0)):
    gages = tuple(GageResult(k, r, r, r, 0.0, r) for k, r in enumerate(readings))
    counts = (5, 3, 2)
    pressure = 0.1 * normal
    return IncrementResult(
        approach, shear, normal, tangential, 1.0, stick, *counts, pressure, 3, 0.0, gages
    )


ROWS = (
    row(0.1, 0.0, 2.0, 0.0, 0.7, (10.0, -4.0)),
    row(0.2, 0.0, 6.0, 0.0, 0.6, (30.0, -9.0)),
    row(0.2, 0.01, 6.1, 1.0, 0.95, (28.0, -4.0)),
    row(0.2, 0.02, 6.0, 1.8, 0.87, (26.0, -1.0)),
    row(0.2, 0.03, 5.9, 2.4, 0.8, (25.0, 3.0)),
    row(0.2, 0.04, 5.8, 2.9, None, (25.0, 3.0)),
)


def grip(mu, mass, margin, peak, lifted=True, slips=False):
    return GripResult("paper", mu, mass, lifted, slips, 5.0, 2.0, margin, 0.4, peak, 0.0, 30)


def trace(mu, mass, steps):
    """Forces that rise to 5 N and 2 N; the rest is of no matter here."""
    rise, none = np.linspace(0.0, 1.0, steps), np.zeros(steps)
    return GripTrace(
        controller="paper",
        friction_coefficient=mu,
        object_mass_g=mass,
        approach=none,
        shear=none,
        normal_force=5.0 * rise,
        tangential_force=2.0 * rise,
        stick_ratio=none,
        gage_area_mm=none,
        dx=none,
        dy=none,
        hold=none > 0.0,
        gage_readings=np.zeros((steps, 2)),
    )


def analysis(**changes):
    reported = {"increments": ROWS, "model": MODEL, "mesh": MESH} | changes
    made = Result("narrow", "made", "d" * 64, {}, "plane-strain", **reported)
    return Analysis(made, plates=plate_frames(DESIGN))


def test_metrics_of_the_path():
    found = metrics_of(DESIGN, Cost(), analysis())
    assert (found["normal_force_N"], found["tangential_force_N"]) == (5.8, 2.9)
    assert found["stiffness_N_per_mm"] == pytest.approx(6.0 / 0.2)
    assert found["peak_pressure_MPa"] == pytest.approx(0.61)
    assert found["first_slip_N"] == 2.4  # 0.8 < 0.9 x 0.95; that pressing slips is not counted
    assert found["gage_response"] == pytest.approx(5.0)  # gage 1, the first step that only pulls
    assert "grip_success" not in found


def test_a_path_that_only_presses_has_no_slip_and_no_response():
    found = metrics_of(DESIGN, Cost(), analysis(increments=ROWS[:2]))
    assert found["first_slip_N"] is None
    assert found["gage_response"] is None


def test_the_cost_is_what_it_says():
    prices = Cost(fixed=3.0, plate=2.0, gage=8.0, silicone_per_ml=1.0)
    found = own_metrics(DESIGN, prices)
    assert found["plates"] == 2.0
    assert found["cost"] == pytest.approx(3.0 + 4.0 + 32.0 + found["rubber_volume_ml"])
    one_face = with_values(DESIGN, {"gages.face": "upper"})
    assert own_metrics(one_face, prices)["cost"] == pytest.approx(found["cost"] - 16.0)


def test_rubber_is_the_body_without_plates():
    bare = with_values(DESIGN, {"plates.count": 0})
    plates = DESIGN.plates
    length, thickness = plates.length_mm, plates.thickness_mm
    span = plates.span_mm or DESIGN.body.depth_mm
    less = 2 * length * thickness * span * 1e-3
    whole = own_metrics(bare, Cost())["rubber_volume_ml"]
    assert whole - own_metrics(DESIGN, Cost())["rubber_volume_ml"] == pytest.approx(less)
    box = DESIGN.body.width_mm * DESIGN.body.base_height_mm * DESIGN.body.depth_mm * 1e-3
    assert box < whole < 1.5 * box


def test_traces_are_thinned_and_keep_both_ends():
    rows = tuple(replace(ROWS[3], approach_mm=k / 1000) for k in range(101))
    found = traces_of(analysis(increments=rows))
    assert len(found.approach_mm) == len(found.gages) == 40
    assert (found.approach_mm[0], found.approach_mm[-1]) == (0.0, 0.1)
    assert traces_of(analysis()).stick_ratio[-1] is None
    assert len(found.gage_x_mm) == len(found.gages[0]) == 2


def contact(points, status):
    m, dim = points.shape
    k = len(status)
    facets = np.zeros((0, dim), dtype=np.int64)
    slips = np.zeros((k, m, dim - 1))
    return ContactHistory(points, np.ones(m), facets, status, np.zeros((k, m)), slips, slips)


def test_the_contact_map_of_a_section_runs_along_x():
    x = np.random.default_rng(1).permutation(np.linspace(-4.0, 4.0, 301))
    status = np.where(np.abs(x) < 1.0, STICK, np.where(np.abs(x) < 2.0, SLIP, OPEN))
    made = contact(np.column_stack([x, 10.0 - 0.01 * x**2]), np.tile(status, (len(ROWS), 1)))
    found = traces_of(replace(analysis(), contact=made))
    assert len(found.contact_x_mm) == len(found.status[0]) == 120
    assert found.contact_x_mm == tuple(sorted(found.contact_x_mm))
    assert found.contact_z_mm == ()
    for x_mm, mark in zip(found.contact_x_mm, found.status[2], strict=True):
        assert mark == ("#" if abs(x_mm) < 1.0 else "/" if abs(x_mm) < 2.0 else ".")


def test_the_contact_map_in_space_is_about_what_is_touched():
    rng = np.random.default_rng(2)
    x, z = rng.uniform(-10.0, 10.0, 4000), rng.uniform(-5.0, 5.0, 4000)
    touched = (np.abs(x) < 1.5) & (np.abs(z) < 4.0)
    made = contact(np.column_stack([x, 0 * x, z]), np.tile(np.where(touched, STICK, OPEN), (6, 1)))
    found = traces_of(replace(analysis(), contact=made))
    assert 80 < len(found.contact_x_mm) == len(found.contact_z_mm) <= 120
    assert max(abs(each) for each in found.contact_x_mm) < 2.5
    assert found.status[0].count("#") > 50
    assert "." in found.status[0]
    spread = np.histogram2d(found.contact_x_mm, found.contact_z_mm, (3, 3))[0]
    assert spread.min() > 5  # everywhere, not in a corner


def test_metrics_of_grips():
    grips = (
        grip(0.2, 500.0, 1.2, 15.0),
        grip(0.5, 500.0, 1.6, 8.0),
        grip(0.8, 500.0, None, 4.0, lifted=False, slips=True),
    )
    traces = tuple(trace(each.friction_coefficient, 500.0, 90) for each in grips)
    made = analysis(grips=grips)
    made = replace(made, grip_traces=traces)
    found = metrics_of(DESIGN, Cost(), made)
    assert found["grip_success"] == pytest.approx(2 / 3)
    assert found["safety_margin"] == pytest.approx(1.4)
    assert found["least_margin"] == 1.2
    assert found["peak_force_N"] == 15.0
    half_weight = 0.25 * 9.80665
    ratios = (15.0 * 0.2 / half_weight, 8.0 * 0.5 / half_weight)  # one that fell is not gentle
    assert found["peak_ratio"] == pytest.approx(sum(ratios) / 2)
    path = grips_of(made)[0]
    assert len(path.normal_force_N) == len(path.tangential_force_N) == 60
    assert path.normal_force_N[-1] == 5.0


def test_grips_that_all_fail_have_no_margin():
    found = grip_metrics([grip(0.2, 500.0, None, 15.0, lifted=False)])
    assert found["grip_success"] == 0.0
    assert (found["safety_margin"], found["least_margin"], found["peak_ratio"]) == (None,) * 3


def test_no_model_no_stick_error():
    assert stick_error_of(Case(DESIGN), analysis()) == (None, ())
