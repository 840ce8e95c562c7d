"""Warnings on keys that may not mean, or not do, what their writer thinks."""

import pytest

from fingerdesign.caveats import _choices
from fingerdesign.design.io import parse_design, parse_scene
from fingerdesign.pipeline import Case

MOTION = parse_scene("path.increments_mm = [[0.1, 0.0]]")


def warned(text: str, scene=MOTION) -> list[str]:
    return _choices(Case(parse_design(f'design.name = "a"\n{text}'), scene), scene)


@pytest.mark.parametrize(
    "text",
    [
        "",
        'mesh.element = "P2"',
        'mesh.element = "P1"\nmaterials.silicone.poissons_ratio = 0.3',
        'plates.model = "none"\nplates.count = 0',
    ],
)
def test_nothing_is_said_of_what_is_well(text) -> None:
    assert warned(text) == []


def test_linear_elements_lock_in_rubber() -> None:
    (said,) = warned('mesh.element = "P1"')
    assert said.startswith("linear elements lock at nu = 0.49: forces and strains are off by ten")
    assert said.endswith("leave mesh.element at auto")


def test_plates_left_out_make_the_readings_the_rubber_s() -> None:
    (said,) = warned('plates.model = "none"')
    assert "the readings are the rubber's own strains" in said


def test_rows_of_newtons_under_millimetres_are_said() -> None:
    path = 'path.control = "force"\npath.increments_{} = [[1.0, 0.0]]'
    (said,) = warned("", parse_scene(path.format("mm")))
    assert said.startswith("path.increments_mm was read as newtons")
    assert warned("", parse_scene(path.format("N"))) == []
