"""Scenes: their keys, and whether a finger can take them."""

import pytest

from fingerdesign.checks.load import parse_design
from fingerdesign.checks.scene import scene_faults
from fingerdesign.design.io import judge_scene, parse_scene
from fingerdesign.errors import DesignError
from fingerdesign.shapes.friction import FrictionLaw
from tests.support.faults import faults_of

PATH = "path.increments_mm = [[0.1, 0.0], [0.2, 0.05], [0.0, 0.05]]\n"
PULL = "path.control = 'force'\npath.increments_N = "
FORCE = 'path.control = "force"\n'
DESIGN = parse_design('design.name = "a"')


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("", "path.increments_mm"),
        ("path.increments_mm = []", "path.increments_mm"),
        ("path.increments_mm = [[-0.1, 0]]", "path.increments_mm[0][0]"),
        ("path.increments_mm = [[0.1, 0], [0.1]]", "path.increments_mm[1]"),
        ("path.increments_mm = [[0.1, nan]]", "path.increments_mm[0][1]"),
        ("path.increments_mm = [[0.1, true]]", "path.increments_mm[0][1]"),
        ("path.increments_mm = 3", "path.increments_mm"),
        (PATH + "object.friction_coefficient = -0.1", "object.friction_coefficient"),
        (PATH + "object.friction = 0.1", "object.friction"),
        (PATH + 'object.friction_law = "tresca"', "object.friction_law"),
        (PATH + "object.shear_strength_MPa = 0.1", "object.shear_strength_MPa"),
        (PATH + 'object.friction_law = "shear_strength"', "object.shear_strength_MPa"),
        (
            PATH + 'object = {friction_law = "shear_strength", shear_strength_MPa = -1}',
            "object.shear_strength_MPa",
        ),
        (
            PATH + "object = {friction_law = 'shear_strength', shear_strength_MPa = 0.1, "
            "friction_coefficient = 0.3}",
            "object.friction_coefficient",
        ),
        (PATH + 'object.friction_law = "capped"', "object.shear_limit_MPa"),
        (
            PATH + "object = {friction_law = 'capped', shear_strength_MPa = 0.2, "
            "shear_limit_MPa = 0.1}",
            "object.shear_limit_MPa",
        ),
        (
            PATH + "object = {friction_law = 'power', friction_exponent = 0.3}",
            "object.reference_pressure_MPa",
        ),
        (
            PATH + "object = {friction_law = 'power', friction_exponent = 1.0, "
            "reference_pressure_MPa = 0.1}",
            "object.friction_exponent",
        ),
        (PATH + "path.substeps = 0", "path.substeps"),
        (PATH + "readout.points_mm = [[0, 1]]", "readout.points_mm[0][2]"),
        (PATH + "design.name = 'a'", "design"),
        (PATH + 'object.shape = "cylinder"', "object.radius_mm"),
        (PATH + 'object.shape = "sphere"', "object.radius_mm"),
        (PATH + "object.radius_mm = 3", "object.radius_mm"),
        (PATH + "object.tilt_deg = 46", "object.tilt_deg"),
        (PATH + 'object = {shape = "sphere", radius_mm = 3, tilt_deg = 1}', "object.tilt_deg"),
        (PATH + 'object = {shape = "cylinder", radius_mm = 3, axis = "y"}', "object.axis"),
        (PATH + "object.turn_deg = 30", "object.turn_deg"),
        (PATH + 'object.axis = "x"', "object.axis"),
        (PATH + 'object = {shape = "cylinder", radius_mm = 3, tilt_deg = 9}', "object.tilt_deg"),
        ("path.increments_mm = [[0.1, 0, 0, 0, 0]]", "path.increments_mm[0]"),
        ("path.increments_N = [[1, 0]]", "path.increments_N"),
        (FORCE, "path.increments_N"),
        (FORCE + "path.increments_N = [[1, 0], [0, 0]]", "path.increments_N[1][0]"),
        (FORCE + "path.increments_N = [[1, 0, 0]]", "path.increments_N[0]"),
        (FORCE + "path.increments_mm = [[1, 0, 0]]", "path.increments_mm[0]"),
        (
            FORCE + "path.increments_mm = [[1, 0]]\npath.increments_N = [[1, 0]]",
            "path.increments_N",
        ),
    ],
)
def test_wrong_scenes_are_refused_by_key(text, key):
    assert set(faults_of(text, parse_scene)) == {key}


def test_a_pull_before_touch_is_shown_as_it_was_given():
    with pytest.raises(DesignError) as caught:
        parse_scene("path.increments_mm = [[-0.1, 0.7]]")
    assert [each.value for each in caught.value.faults] == ["-0.1"]


@pytest.mark.parametrize(
    ("line", "law"),
    [
        ("", FrictionLaw(0.5)),
        ("friction_coefficient = 0.3", FrictionLaw(0.3)),
        (
            "friction_law = 'capped', shear_strength_MPa = 0.1, shear_limit_MPa = 0.4",
            FrictionLaw(0.5, 0.1, 0.4),
        ),
        ("friction_law = 'capped', shear_limit_MPa = 0.4", FrictionLaw(0.5, 0.0, 0.4)),
        ("friction_law = 'shear_strength', shear_strength_MPa = 0.1", FrictionLaw(0.0, 0.1)),
        (
            "friction_law = 'power', friction_exponent = 0.31, reference_pressure_MPa = 0.2",
            FrictionLaw(0.5, exponent=0.31, reference=0.2),
        ),
    ],
)
def test_the_object_has_the_law_that_its_keys_say(line, law):
    assert parse_scene(f"{PATH}object = {{{line}}}").object.law == law


def test_forces_that_coulomb_would_refuse_are_left_to_a_law_of_pressure():
    """What a contact carries depends on its area then: the path finds out."""
    rows = PULL + "[[1.0, 0.0], [1.0, 0.9]]\n"
    assert scene_faults(parse_scene(rows), DESIGN)
    own = "object = {friction_law = 'shear_strength', shear_strength_MPa = 0.1}"
    assert not scene_faults(parse_scene(rows + own), DESIGN)


@pytest.mark.parametrize(
    "line",
    [
        "object.friction_coefficient = 0.31",
        "object = {friction_law = 'shear_strength', shear_strength_MPa = 0.1}",
        "object.tilt_deg = 1.0",
        "path.substeps = 2",
        "readout.points_mm = [[0.0, 1.0, 0.0]]",
        'object = {shape = "sphere", radius_mm = 3.0}',
    ],
)
def test_whatever_changes_a_scene_changes_its_digest(line):
    """Results are stored by it: without the friction, one would stand for another friction."""
    assert parse_scene(PATH + line).digest() != parse_scene(PATH).digest()
    assert parse_scene(PATH + line).digest() == parse_scene(line + "\n" + PATH).digest()


def test_two_rows_in_another_order_are_another_scene():
    rows = ["[0.1, 0.0]", "[0.2, 0.05]"]
    one, other = (f"path.increments_mm = [{', '.join(each)}]" for each in (rows, rows[::-1]))
    assert parse_scene(one).digest() != parse_scene(other).digest()


def test_rows_of_forces_under_either_key():
    for key in ("increments_mm", "increments_N"):
        path = parse_scene(FORCE + f"path.{key} = [[1, 0], [1, 0.4]]").path
        assert path.rows == ((1.0, 0.0), (1.0, 0.4))
        assert path.key == f"path.{key}"


@pytest.mark.parametrize(
    ("text", "mirrors", "plane"),
    [
        (PATH, True, True),
        (PATH + "object.tilt_deg = 5", True, True),
        (PATH + "object = {tilt_deg = 5, turn_deg = 90}", False, False),
        (PATH + 'object = {shape = "sphere", radius_mm = 3}', True, False),
        (PATH + 'object = {shape = "cylinder", radius_mm = 3}', True, True),
        (PATH + 'object = {shape = "cylinder", radius_mm = 3, axis = "x"}', True, False),
        (PATH + 'object = {shape = "cylinder", radius_mm = 3, turn_deg = 30}', False, False),
        ("path.increments_mm = [[0.1, 0, 0.1]]", False, True),
        ("path.increments_mm = [[0.1, 0, 0, 1]]", False, True),
        ("path.increments_mm = [[0.1, 0, 0, 0]]", True, True),
    ],
)
def test_what_mirrors_and_what_plane_strain_can_hold(text, mirrors, plane):
    scene = parse_scene(text)
    assert scene.mirrors_in_z is mirrors
    assert scene.object.plane_in_z is plane


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        ("path.increments_mm = [[0.1, 0, 0, 1], [0.1, 0, 0, 11]]", "path.increments_mm[1][3]"),
        (
            "path.increments_mm = [[0.1, 0], [7, 0], [6.5, -8]]",  # over half of its height
            "path.increments_mm[1][0] path.increments_mm[2][1]",
        ),
        ("path.increments_mm = [[6.33, -6.33, 6.33, -10.0]]", ""),
        ("path.increments_mm = [[0.1, 0, -6.35], [0.1, 0, 6.34]]", "path.increments_mm[0][2]"),
        (PATH, ""),
        (PATH + "readout.points_mm = [[0, 13, 0], [0, 5, 0], [0, 20, 0]]", "readout.points_mm[2]"),
        (PULL + "[[3, 1.5], [2, -1.0]]", ""),
        (PULL + "[[3, 1.5], [2, -1.2], [9, 4.6]]", "path.increments_N[1][1]"),
        ("object.tilt_deg = 5\n" + PULL + "[[3, 1.8], [3, -1.15]]", ""),
        ("object.tilt_deg = 5\n" + PULL + "[[3, 1.0], [3, 1.9]]", "path.increments_N[1][1]"),
        ("object = {tilt_deg = 5, turn_deg = 90}\n" + PULL + "[[3, 1.9]]", ""),
        (
            "path.increments_mm = [[9, 0]]\nreadout.points_mm = [[0, 20, 0]]",
            "path.increments_mm[0][0] readout.points_mm[0]",
        ),
    ],
)
def test_what_a_finger_cannot_take_is_refused_by_key(text, keys):
    scene = parse_scene(text)
    assert [fault.key for fault in scene_faults(scene, DESIGN)] == keys.split()
    impossible = DESIGN.body.model_copy(update={"arc_radius_mm": 5.0})
    assert scene_faults(scene, DESIGN.model_copy(update={"body": impossible})) == []


@pytest.mark.parametrize(
    ("point", "inside"),
    [
        ((0, 12.67, 0), True),
        ((0, 12.69, 0), False),
        ((9.99, 10.0, 5.0), True),
        ((10.01, 5, 0), False),
        ((0, 5, 5.01), False),
        ((0, -0.01, 0), False),
        ((0, 0, 0), True),
    ],
)
def test_readout_points_lie_inside(point, inside):
    scene = parse_scene(PATH + f"readout.points_mm = [{list(point)}]")
    assert (scene_faults(scene, DESIGN) == []) is inside


def test_readout_points_lie_inside_a_round_section_and_all_outside_are_named():
    pin = parse_design('design.name = "a"\nbody.shape = "revolved"\nplates.count = 0')
    text = PATH + "readout.points_mm = [[7, 1, 7], [0, 14, 0], [7.1, 1, 7.1], [0, 1, -10.1]]"
    (fault,) = scene_faults(parse_scene(text), pin)
    assert fault.key == "readout.points_mm[1]"
    assert fault.remedy.endswith("outside; so are 2, 3")


def test_every_fault_of_a_scenes_keys_at_once():
    found = judge_scene(
        "path.increments_mm = []\nreadout.points_mm = [[0, 13]]\n"
        'object = {shape = "sphere", axis = "x", tilt_deg = 3}'
    )
    assert found.value is None
    keys = {"path.increments_mm", "readout.points_mm[0][2]"}
    keys |= {f"object.{key}" for key in ("radius_mm", "axis", "tilt_deg")}
    assert {fault.key for fault in found.faults} == keys
