"""Grips with two fingers and an object on its support, from a design to its result."""

import pytest
from fingerdesign_cli.main import main

from fingerdesign import parse_design
from fingerdesign.analysis.case import Case
from fingerdesign.pipeline import run

DESIGN = """
[design]
name = "coarse"
[plates]
length_mm = 1.0
cover_mm = 1.2
[gages]
length_mm = 0.6
[mesh.section]
contact_size_mm = 0.2
plate_size_mm = 0.3
plate_end_size_mm = 0.1
[grip]
friction_coefficients = [0.4]
object_mass_g = 60.0
controller = "oracle_1.5"
max_steps = 60
plant = "lift"
hold_steps = 8
"""
WEIGHT = 0.060 * 9.80665


def gripped(more):
    design = parse_design(DESIGN + more)
    analysis = run(Case(design, None, "plane-strain", fields=False))
    return analysis.result.grips[0], analysis.grip_traces[0]


def test_a_lift_is_held_on_and_recorded():
    grip, trace = gripped("[grip.hardware]\ngage_noise_microstrain = 0.5\n")
    assert (grip.lifted, grip.gross_slip) == (True, False)
    assert 2.0 * grip.final_tangential_force_N == pytest.approx(WEIGHT, rel=1e-6)
    assert (trace.rise > 0.0).tolist() == [False] * (len(trace.rise) - 9) + [True] * 9


def test_the_finger_with_plates_carries_more_than_a_bare_one():
    grip, _ = gripped('opposite = "bare"\n')
    assert grip.lifted
    assert 0.5 * WEIGHT * 1.001 < grip.final_tangential_force_N < 0.6 * WEIGHT


def test_a_lifts_keys_without_a_lift_are_refused(tmp_path, capsys):
    path = tmp_path / "coarse.toml"
    path.write_text(DESIGN.replace('plant = "lift"', 'opposite = "bare"'))
    assert main(["check", str(path)]) == 2
    reported = capsys.readouterr().err
    assert "grip.opposite" in reported
    assert "grip.hold_steps" in reported
