"""What is stated before any model is built: contact zones of every body, words, volumes."""

import numpy as np
import pytest

from fingerdesign.checks.load import load_design, parse_design
from fingerdesign.design.scene import SceneObject
from fingerdesign.layout.zone import approach_for, candidate_zone, contact_half_width, contact_reach

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
    tilted = SceneObject(tilt_deg=10.0)
    assert contact_reach(BLOCK, tilted, 0.1)[0] == pytest.approx(0.1 / np.tan(np.radians(10)))


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
