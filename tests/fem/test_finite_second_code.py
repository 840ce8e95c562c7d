"""The same meshes solved by GetFEM 5.4.2: the law written as an energy, contact as an augmented
Lagrangian on linear multipliers, a full Newton method. Its numbers (per mm) are kept here."""

import numpy as np
import pytest

from fingerdesign import parse_design, parse_scene
from fingerdesign.analysis.finite_path import finite_readings
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.section import mesh_section

BODY = """
design.name = "second_code"
body = {shape = "arc", width_mm = 20.0, base_height_mm = 10.0, arc_radius_mm = 20.0, depth_mm = 1.0}
materials.silicone = {youngs_modulus_MPa = 4.96, poissons_ratio = 0.3}
"""
RUBBER = """
plates = {count = 0}
mesh.section = {contact_size_mm = 0.1, far_size_mm = 1.0, gradation = 0.3}
"""
PLATES = """
plates = {placement = [[0.5, 10.9, 45.0], [-1.5, 10.8, 30.0]], thickness_mm = 0.1, length_mm = 2.0}
gages = {length_mm = 1.0, width_mm = 0.5}
mesh.section = {contact_size_mm = 0.1, plate_size_mm = 0.15, plate_end_size_mm = 0.05, \
far_size_mm = 1.0, gradation = 0.3}
"""
SHEARED = {  # friction 0.5: [approach, shear]: F_n, F_t
    (0.4, 0.0): (1.47444, 0.00013),
    (0.8, 0.0): (3.60641, 0.00039),
    (1.2, 0.0): (6.24886, 0.00080),
    (1.6, 0.0): (9.38088, 0.00144),
    (2.0, 0.0): (13.00820, 0.00241),
    (2.0, 0.3): (13.00934, 0.58074),
    (2.0, 0.6): (13.01475, 1.15792),
}
PRESSED = {  # no friction: approach: F_n, gages in microstrain: upper, lower of each plate
    0.2: (0.63009, (-65.752, 64.253, 12.453, -22.218)),
    0.4: (1.47444, (-103.136, 94.569, -14.079, 0.107)),
    0.6: (2.47190, (-128.964, 112.674, -52.880, 38.088)),
}


def solved(plates, rows, friction):
    design = parse_design(BODY + plates)
    scene = parse_scene(
        f"object.friction_coefficient = {friction}\npath.increments_mm = {[list(r) for r in rows]}"
    )
    return finite_readings(design, mesh_section(design, 8.0), Zone(9.9), scene)


def test_pressed_far_and_sheared_with_friction():
    """Two discretisations of contact differ by 1e-4 where the contact is smallest, 2e-5 later."""
    found = solved(RUBBER, SHEARED, 0.5)
    wanted = np.array(list(SHEARED.values()))
    assert np.allclose(found.normal_force, wanted[:, 0], rtol=2e-4)
    assert np.allclose(found.tangential_force, wanted[:, 1], rtol=0, atol=1e-4)


def test_gages_of_plates_that_turn():
    """Within 0.03 of 129 microstrain, where small strain is off by up to 14."""
    found = solved(PLATES, [(a, 0.0) for a in PRESSED], 0.0)
    for k, (force, gages) in enumerate(PRESSED.values()):
        assert found.normal_force[k] == pytest.approx(force, rel=1e-4)
        assert np.abs(1e6 * found.gages[k].ravel() - gages).max() < 0.03
