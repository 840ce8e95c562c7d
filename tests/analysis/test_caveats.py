"""Warnings on keys that may not mean, or not do, what their writer thinks."""

import pytest

from fingerdesign.analysis.analysis import CAVEATS, of_choices
from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import parse_design, parse_scene
from fingerdesign.report.page import said as sentence

MOTION = parse_scene("path.increments_mm = [[0.1, 0.0]]")


def warned(text, scene=MOTION, fidelity="3d"):
    case = Case(parse_design(f'design.name = "a"\n{text}'), scene, fidelity)
    return [
        sentence(CAVEATS, name, **values)[0] for name, values in of_choices(case, scene).items()
    ]


@pytest.mark.parametrize(
    "text",
    [
        "",
        'mesh.element = "P2"',
        'mesh.element = "P1"\nmaterials.silicone.poissons_ratio = 0.3',
        'plates.model = "none"\nplates.count = 0',
    ],
)
def test_nothing_is_said_of_what_is_well(text):
    assert warned(text) == []


def test_linear_elements_lock_in_rubber():
    (said,) = warned('mesh.element = "P1"')
    assert said.startswith("linear elements lock at nu = 0.49: forces and strains are off by ten")
    assert said.endswith("leave mesh.element at auto")


def test_plates_left_out_make_the_readings_the_rubber_s():
    (said,) = warned('plates.model = "none"')
    assert "the readings are the rubber's own strains" in said


def test_rows_of_newtons_under_millimetres_are_said():
    path = 'path.control = "force"\npath.increments_{} = [[1.0, 0.0]]'
    (said,) = warned("", parse_scene(path.format("mm")))
    assert said.startswith("path.increments_mm was read as newtons")
    assert warned("", parse_scene(path.format("N"))) == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('body.shape = "revolved"\nplates.count = 0', "the turned body straight along the whole"),
        (
            'body.shape = "dome"\nbody.dome_radius_mm = 20.0\nplates.count = 0',
            "forces come out several times too large",
        ),
        ("plates.span_mm = 4.0", "takes plates and core as they are in the section z = 0"),
    ],
)
def test_a_section_of_a_finger_that_changes_along_z_is_a_sketch(text, words):
    (said,) = warned(text, fidelity="plane-strain")
    assert words in said
    assert said.endswith("take --fidelity 3d")
    assert warned(text) == []


def test_plane_strain_of_an_extruded_finger_is_as_it_should_be():
    assert warned("", fidelity="plane-strain") == []
