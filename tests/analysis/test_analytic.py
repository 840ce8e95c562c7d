"""The formulas' rung: where it speaks, and that it agrees with plane strain where it should."""

import numpy as np
import pytest

from fingerdesign import parse_design, parse_scene
from fingerdesign.analysis.fidelity.ladder import analytic_readings
from fingerdesign.analysis.fidelity.models import solve
from fingerdesign.analysis.fidelity.rungs import rung

BARE = """
design.name = "bare"
body.width_mm = 24.0
body.base_height_mm = 12.0
body.arc_radius_mm = 20.0
plates.count = 0
materials.silicone.poissons_ratio = 0.499
"""
PATH = "[[0.05, 0.0], [0.1, 0.0], [0.1, 0.01], [0.1, 0.02]]"


def motion(rows=PATH):
    return f"[object]\nfriction_coefficient = 0.5\n[path]\nincrements_mm = {rows}"


def test_it_agrees_with_plane_strain():
    design, scene = parse_design(BARE), parse_scene(motion())
    said = analytic_readings(design, scene)
    solved = solve(design, scene, rung(design, scene, "plane strain", 1.0)).readings
    np.testing.assert_allclose(said.normal_force, solved.normal_force, rtol=0.2)
    np.testing.assert_allclose(said.contact_width, solved.contact_width, rtol=0.15)
    np.testing.assert_allclose(said.stick_ratio[2:], solved.stick_ratio[2:], atol=0.06)


def test_given_forces_come_out_and_partial_slip_is_cattaneos():
    design = parse_design(BARE)
    scene = parse_scene(
        '[object]\nfriction_coefficient = 0.5\n[path]\ncontrol = "force"\n'
        "increments_N = [[4.0, 0.0], [4.0, 1.5]]"
    )
    said = analytic_readings(design, scene)
    np.testing.assert_allclose(said.normal_force, 4.0, rtol=1e-9)
    np.testing.assert_allclose(said.tangential_force, [0.0, 1.5], atol=1e-9)
    np.testing.assert_allclose(said.stick_ratio, [1.0, np.sqrt(1.0 - 1.5 / 2.0)], rtol=1e-6)


@pytest.mark.parametrize(
    ("keys", "rows"),
    [
        ("plates.count = 1", PATH),
        ("", "[[0.1, 0.0], [0.05, 0.0]]"),
        ("", "[[0.1, 0.02], [0.2, 0.04]]"),
        ("", "[[0.1, 0.0], [0.1, 0.05], [0.1, 0.01]]"),
        ("", "[[0.1, 0.0, 0.0], [0.1, 0.0, 0.05]]"),
    ],
)
def test_where_it_does_not_speak(keys, rows):
    text = BARE.replace("plates.count = 0", keys) if keys else BARE
    assert analytic_readings(parse_design(text), parse_scene(motion(rows))) is None
