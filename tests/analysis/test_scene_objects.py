"""Objects, directions and force control through the whole road, on coarse meshes."""

import re

import numpy as np
import pytest

from fingerdesign import analyse, load_design, parse_scene, with_values
from fingerdesign.analysis.case import Case
from fingerdesign.analysis.path import object_at_touch, touch_point
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.layout.surface import ContactSurface
from fingerdesign.layout.zone import approach_for, candidate_zone
from fingerdesign.pipeline import analyse_into

COARSE = {
    "mesh.section.contact_size_mm": 0.1,
    "mesh.section.far_size_mm": 1.5,
    "mesh.mesher": "sweep",
    "mesh.contact_size_mm": 0.7,
    "mesh.far_size_mm": 3.0,
    "mesh.layers": 3,
    "body.depth_mm": 6.0,
}
PATH = "path.increments_mm = [[0.15, 0.0], [0.15, 0.04]]\n"


@pytest.fixture(scope="module")
def design():
    return with_values(load_design("homogeneous"), COARSE)


def forces(design, text, fidelity="plane-strain"):
    """F_n and F_t of each increment; in space of linear elements, for what is compared."""
    if fidelity == "3d":
        design = with_values(design, {"mesh.element": "P1"})
    result = analyse(design, parse_scene(text), fidelity)
    return np.array([[i.normal_force_N, i.tangential_force_N] for i in result.increments])


def test_a_slope_the_other_way_mirrors_and_a_smaller_cylinder_presses_less(design):
    left = forces(design, PATH + "object.tilt_deg = 3")
    right = forces(design, PATH.replace("0.04", "-0.04") + "object.tilt_deg = -3")
    # The section's mesh is not its own mirror image.
    assert right * [1, -1] == pytest.approx(left, abs=3e-3 * left[0, 0])
    assert left[0, 1] > 0.01 * left[0, 0]  # a slope pulls sideways where it is pressed
    text = PATH + 'object = {{shape = "cylinder", radius_mm = {}}}'
    normal = [forces(design, text.format(radius))[0, 0] for radius in (5, 20, 100)]
    assert normal == sorted(normal)


@pytest.mark.parametrize(
    ("one", "other", "fidelity", "within"),
    [
        ("{tilt_deg = 3, turn_deg = 180}", "{tilt_deg = -3}", "plane-strain", 1e-9),
        ('{shape = "cylinder", radius_mm = 50000}', "{}", "plane-strain", 1e-3),
        (
            '{shape = "cylinder", radius_mm = 30, axis = "x", turn_deg = 90}',
            '{shape = "cylinder", radius_mm = 30}',
            "3d",
            1e-5,
        ),
    ],
)
def test_one_object_in_two_ways_is_the_same(design, one, other, fidelity, within):
    expected = forces(design, f"{PATH}object = {other}", fidelity)
    # Of the largest force: pressed alone, the section's mesh leaves F_t a thousandth of F_n, which
    # hangs on single nodes.
    most = within * np.abs(expected).max()
    assert forces(design, f"{PATH}object = {one}", fidelity) == pytest.approx(expected, abs=most)


def test_forces_requested_come_out_at_about_the_approach_that_is_foreseen(design):
    text = 'path.control = "force"\npath.increments_N = [[3, 0], [3, 0.7], [3, -0.5]]'
    found = analyse(design, parse_scene(text), "plane-strain").increments
    forces = [[each.normal_force_N, each.tangential_force_N] for each in found]
    assert np.array(forces) == pytest.approx(np.array([[3, 0], [3, 0.7], [3, -0.5]]), abs=1e-7)
    assert approach_for(design, SceneObject(), 3.0) == pytest.approx(found[0].approach_mm, rel=0.3)


@pytest.mark.parametrize(
    ("rows", "words", "solved"),
    [
        ("[[2, 0], [3, 0.9], [3, 1.6]]", r"row 3 of 3 .*complete slip", [0.0, 0.9]),
        ("[[3, 0], [2000, 0]]", r"row 2 of 2 .*ask for less force", [0.0]),
    ],
)
def test_forces_that_no_motion_gives_are_refused(design, tmp_path, rows, words, solved):
    round_one = 'object = {shape = "cylinder", radius_mm = 4e4}'
    scene = parse_scene(f'{round_one}\npath.control = "force"\npath.increments_N = {rows}')
    with pytest.raises(SolverError, match=words):
        analyse(design, scene, "plane-strain")
    found = analyse_into(Case(design, scene, "plane-strain", "pull"), tmp_path)
    assert found.status == "failed"
    assert re.match(words, found.failure)
    pulls = [row.tangential_force_N for row in found.increments]
    assert pulls == pytest.approx(solved, abs=1e-7)


@pytest.mark.parametrize(
    "scene",
    [
        PATH + 'object = {shape = "sphere", radius_mm = 5}',
        PATH + 'object = {shape = "cylinder", radius_mm = 5, axis = "x"}',
        PATH + "object = {tilt_deg = 3, turn_deg = 40}",
        "path.increments_mm = [[0.1, 0, 0, 1]]",
    ],
)
def test_plane_strain_refuses_what_it_cannot_hold(design, scene):
    with pytest.raises(DesignError, match="3d"):
        analyse(design, parse_scene(scene), "plane-strain")


def test_objects_touch_the_crest_and_no_more(design):
    surface = ContactSurface.of(design.body)
    x, z = (grid.ravel() for grid in np.meshgrid(np.linspace(-5, 5, 101), np.linspace(-3, 3, 61)))
    points = np.column_stack([x, surface.height(x, z), z])
    for given in (
        {"shape": "sphere", "radius_mm": 4.0},
        {"shape": "cylinder", "radius_mm": 2.0, "axis": "x", "turn_deg": 30.0},
        {"tilt_deg": 2.0, "turn_deg": 90.0},
    ):
        rigid = object_at_touch(SceneObject(**given), design.body)
        assert -1e-9 < rigid.distance(points).min() < 1e-3


def test_a_turned_body_is_touched_where_it_is():
    """Its square's corners have no surface: a tilted plane meets the round cap, not a corner."""
    body = Design.model_validate(
        {
            "design": {"name": "pin"},
            "body": {"shape": "revolved", "width_mm": 12.0, "arc_radius_mm": 9.0},
            "plates": {"count": 0},
        }
    ).body
    rigid = SceneObject(tilt_deg=4.0, turn_deg=45.0)
    x, z = touch_point(rigid, body)
    reach = 9.0 * np.sin(np.radians(4.0))  # of a sphere: where its normal is the plane's
    assert np.hypot(x, z) == pytest.approx(reach, rel=1e-4)
    surface = ContactSurface.of(body)
    grid = np.linspace(-6.0, 6.0, 121)
    across, along = (each.ravel() for each in np.meshgrid(grid, grid))
    inside = np.hypot(across, along) < 6.0
    points = np.column_stack([across, surface.height(across, along), along])[inside]
    assert -1e-9 < object_at_touch(rigid, body).distance(points).min() < 1e-2


def test_zones_follow_the_object(design):
    def zone(approach=0.1, **given):
        rigid = SceneObject(**given)
        return candidate_zone(design, rigid, approach, touch_point(rigid, design.body))

    assert zone().half_depth is None
    ball = zone(shape="sphere", radius_mm=3.0)
    assert ball.half_depth < 2.0
    assert ball.half_width < zone().half_width
    assert zone(shape="cylinder", radius_mm=3.0).half_depth is None
    assert zone(shape="cylinder", radius_mm=3.0, axis="x").half_depth < 2.0
    assert zone(tilt_deg=5.0).half_width > zone().half_width + 0.5
    grown = ball.widened(100.0, design)
    assert grown.fills(design)


def test_a_tilted_cylinder_is_met_where_it_touches(design):
    """Its first touch is 6 mm off the crest, far outside the zone of one that is not tilted."""
    text = 'object = {shape = "cylinder", radius_mm = 20, axis = "x", tilt_deg = 15}'
    found = forces(design, "path.increments_mm = [[0.2, 0.0], [0.4, 0.0]]\n" + text, "3d")
    assert 0.1 < found[0, 0] < found[1, 0]


def test_a_touch_that_the_mesh_does_not_feel_is_warned_of(design):
    text = 'object = {shape = "cylinder", radius_mm = 0.05}\n'
    scene = parse_scene(text + "path.increments_mm = [[1e-5, 0], [0.2, 0]]")
    result = analyse(design, scene, "plane-strain")
    assert result.increments[0].normal_force_N == 0.0
    assert any(each.startswith("in 1 row from row 1 on") for each in result.warnings)


def test_an_unusual_friction_is_searched_for_other_answers(design, monkeypatch):
    searched = []

    def found(problem, state, motion, known, starts):
        searched.append(motion)
        return [known]

    monkeypatch.setattr("fingerdesign.analysis.analysis.other_solutions", found)
    for friction, count in ((0.5, 0), (3, 1)):
        text = f"{PATH}object.friction_coefficient = {friction}"
        warnings = analyse(design, parse_scene(text), "plane-strain").warnings
        assert len(searched) == count
        assert any("more than one answer" in each for each in warnings) == bool(count)
