"""What is stated before any model is built: contact zones of every body, words, volumes."""

import numpy as np
import pytest

from fingerdesign.checks.load import load_design, parse_design
from fingerdesign.design.scene import SceneObject
from fingerdesign.layout.zone import (
    Zone,
    approach_for,
    candidate_zone,
    contact_half_width,
    contact_reach,
)
from fingerdesign.mesh.make import mesher_name

PLANE = SceneObject()
NAME = 'design.name = "a"\n'


def design_of(*lines):
    return parse_design(NAME + "\n".join(lines))


PIN = design_of('body.shape = "revolved"', "body.width_mm = 16", "plates.count = 0")
BLOCK = design_of('body.shape = "block"', "plates.count = 0")
EDGED = design_of('body.shape = "block"', "body.edge_radius_mm = 3", "plates.count = 0")


def test_a_pin_is_touched_in_a_round_spot():
    assert PIN.body.kind.curvatures(PIN.body) == (1 / 20, 1 / 20)
    wide, deep = contact_reach(PIN, PLANE, 0.1)
    assert wide == deep == pytest.approx(np.sqrt(20 * 0.1))
    zone = candidate_zone(PIN, PLANE, 0.1)
    assert zone.half_depth is not None
    assert zone.half_depth > deep


def test_a_flat_top_is_touched_all_over():
    assert contact_half_width(BLOCK, 0.01) == 10.0
    assert contact_half_width(EDGED, 0.01) == 7.0
    assert candidate_zone(BLOCK, PLANE, 0.01).fills(BLOCK)
    assert contact_half_width(BLOCK, 0.0) == 0.0


def test_round_objects_and_edges_on_a_flat_top():
    ball = SceneObject(shape="sphere", radius_mm=8.0)
    wide, deep = contact_reach(BLOCK, ball, 0.1)
    assert wide == deep < np.sqrt(2 * 8 * 0.1)
    across = SceneObject(shape="cylinder", radius_mm=8.0, axis="x")
    wide, deep = contact_reach(BLOCK, across, 0.1)
    assert wide == np.inf
    assert deep < np.sqrt(2 * 8 * 0.1)
    along = SceneObject(shape="cylinder", radius_mm=8.0)
    assert 0.5 < contact_reach(BLOCK, along, 0.1)[0] < 2.0
    tilted = SceneObject(tilt_deg=10.0, turn_deg=60.0)
    assert contact_reach(BLOCK, tilted, 0.1)[0] == pytest.approx(0.2 / np.tan(np.radians(10)))


@pytest.mark.parametrize(
    ("name", "pairs"),
    [
        ("film_tees", ((0.068, 4.76), (0.136, 13.38), (0.272, 42.23), (0.407, 85.77))),
        ("maeno2000", ((0.082, 5.05), (0.165, 13.36), (0.329, 39.21), (0.494, 76.75))),
        ("homogeneous", ((0.127, 4.67), (0.254, 11.02), (0.507, 26.99), (0.761, 46.66))),
    ],
)
def test_approaches_are_those_of_plane_strain_also_where_the_contact_is_as_wide_as_high(
    name, pairs
):
    """Approach, mm, and force, N, of `analyse --fidelity plane-strain`; contacts up to 1.4 h."""
    design = load_design(name)
    for approach, force in pairs:
        assert approach_for(design, PLANE, force) == pytest.approx(approach, rel=0.12)


@pytest.mark.parametrize("design", [PIN, BLOCK, EDGED], ids=["pin", "block", "edged"])
@pytest.mark.parametrize(
    "rigid",
    [
        PLANE,
        SceneObject(tilt_deg=5.0),
        SceneObject(shape="sphere", radius_mm=8.0),
        SceneObject(shape="cylinder", radius_mm=8.0, axis="x"),
        SceneObject(shape="cylinder", radius_mm=8.0, turn_deg=30.0),
    ],
    ids=["plane", "tilted", "ball", "across", "turned"],
)
def test_more_force_is_a_deeper_approach_and_a_wider_zone(design, rigid):
    depths = [approach_for(design, rigid, force) for force in (0.1, 1.0, 5.0)]
    assert 0 < depths[0] < depths[1] < depths[2]
    widths = [candidate_zone(design, rigid, depth).half_width for depth in depths]
    assert 0 < widths[0] <= widths[1] <= widths[2] <= 10.0


def test_approaches_on_a_flat_top_are_hertzs_and_a_columns():
    """Of a block of 20 x 10 x 10 mm: a ball, a line along x 20 mm long, a plane, a wedge."""
    material = BLOCK.material_of("body")
    modulus = material.youngs_modulus_MPa / (1.0 - material.poissons_ratio**2)
    ball = approach_for(BLOCK, SceneObject(shape="sphere", radius_mm=8.0), 1.0)
    assert 4.0 / 3.0 * modulus * np.sqrt(8.0) * ball**1.5 == pytest.approx(1.0)
    across = SceneObject(shape="cylinder", radius_mm=8.0, axis="x")
    along = SceneObject(shape="cylinder", radius_mm=8.0)
    assert approach_for(BLOCK, across, 2.0, 0.0) == approach_for(BLOCK, along, 1.0, 0.0)
    column = 1.0 * 10.0 / (modulus * 200.0)
    assert approach_for(BLOCK, PLANE, 1.0) == pytest.approx(column)
    assert approach_for(BLOCK, SceneObject(tilt_deg=5.0), 1.0) == pytest.approx(2.0 * column)
    assert approach_for(BLOCK, PLANE, 1e9) == 5.0


def test_a_zone_is_wider_than_its_forecast_and_ends_with_the_body():
    wide, deep = contact_reach(PIN, PLANE, 0.1)
    zone = candidate_zone(PIN, PLANE, 0.1, (-1.0, 2.0))
    assert zone.half_width == pytest.approx(1.0 + 1.15 * wide + 0.3)
    assert zone.half_depth == pytest.approx(2.0 + 1.15 * deep + 0.3)
    assert Zone(2.0, 3.0, 1.0).widened(2.0, PIN) == Zone(4.0, 6.0, 1.0)
    assert Zone(5.0, 3.3, 1.0).widened(2.0, PIN) == Zone(8.0, None, 1.0)  # over 0.8 of 8 mm


@pytest.mark.parametrize(
    ("lines", "mesher"),
    [
        ("plates.stagger_mm = 0.1", "tetwild"),
        ("plates.stagger_mm = 0.12", "sweep"),
        ('plates.model = "none"\nplates.stagger_mm = 0.1', "sweep"),
        ("body.core = {depth_mm = 6.1, height_mm = 2.0}", "tetwild"),
    ],
)
def test_layers_that_are_too_thin_are_left_to_tetrahedra(lines, mesher):
    finite = "plates.cover_mm = 3.0\nplates.span_mm = 6.0"
    assert mesher_name(design_of('mesh.mesher = "auto"', finite, lines)) == mesher
