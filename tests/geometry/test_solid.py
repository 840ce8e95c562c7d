"""CAD solids: named faces, conformal plates, volumes and areas against closed forms."""

from __future__ import annotations

import pytest

from fingerdesign import parse_design
from fingerdesign.design.layout import PlateFrame, plate_frames
from fingerdesign.design.schema import Design
from fingerdesign.design.volume import outline_volume
from fingerdesign.errors import GeometryError
from fingerdesign.geometry.checks import (
    check_volume,
    face_areas,
    plate_gap,
    plate_volume,
)
from fingerdesign.geometry.solid import build_solid

CASES = {
    "full span": "plates.count = 3",
    "ends inside": "plates.count = 3\nplates.span_mm = 6.0",
    "no plates": "plates.count = 0",
    "dome": ('body.shape="dome"\nbody.dome_radius_mm=12.0\nplates.count=3\nplates.span_mm=5.0'),
    "half circle": "body.arc_radius_mm = 10.0\nplates.count = 3",
    "domed half circle": (
        'body.shape = "dome"\nbody.arc_radius_mm = 10.0\nbody.dome_radius_mm = 30.0\nplates.count=1'
    ),
}


def design_of(case: str) -> Design:
    return parse_design(f'design.name = "t"\n{CASES[case]}')


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize("case", CASES)
def test_volumes_and_face_areas_are_those_of_the_closed_forms(case: str, half: bool) -> None:
    design = design_of(case)
    solid = build_solid(design, half)  # checks its volumes itself
    whole = outline_volume(design.body, half)
    assert solid.outline.Volume() == pytest.approx(whole, rel=1e-6)
    wanted = face_areas(design.body, half)
    assert set(wanted) == {name for name in solid.faces if not name.startswith("plate_")}
    for name, area in wanted.items():
        found = sum(face.Area() for face in solid.faces[name])
        assert found == pytest.approx(area, rel=1e-6), name


def test_body_and_plates_share_their_faces() -> None:
    solid = build_solid(design_of("ends inside"))
    # 6 faces of the outline and 3 boxes of 6 faces, each face once.
    assert len(solid.unique_faces()) == 6 + 3 * 6
    assert len(solid.body.Faces()) == 6 + 3 * 6
    full = build_solid(design_of("full span"))
    # Plate ends lie in the body's end faces: 4 walls each are shared, 2 ends are the plate's own.
    assert len(full.body.Faces()) == 6 + 3 * 4
    assert len(full.unique_faces()) == 6 + 3 * 6
    assert len(full.faces["end"]) == 2 * (1 + 3)


def test_plates_that_overlap_are_named() -> None:
    design = design_of("full span")
    crossing = design.model_copy(
        update={"plates": design.plates.model_copy(update={"pitch_mm": 0.1})}
    )
    with pytest.raises(GeometryError, match="plates 0 and 1 overlap"):
        build_solid(crossing)


def test_a_plate_that_leaves_the_body_is_named() -> None:
    design = design_of("full span")
    shallow = design.model_copy(
        update={"plates": design.plates.model_copy(update={"cover_mm": 0.5})}
    )
    with pytest.raises(GeometryError, match=r"plate 0 .* leaves the body"):
        build_solid(shallow)


def test_a_plate_low_in_a_half_circle_is_inside() -> None:
    design = design_of("half circle")
    low = design.plates.model_copy(update={"placement": ((7.0, 2.0, 0.0),)})
    assert len(build_solid(design.model_copy(update={"plates": low})).plates) == 1


def test_a_wrong_volume_is_an_error() -> None:
    check_volume("body", 1.0 + 5e-10, 1.0, 1e-9)
    with pytest.raises(GeometryError, match="differs from 1 mm"):
        check_volume("body", 1.001, 1.0, 1e-9)
    with pytest.raises(GeometryError):
        check_volume("body", float("nan"), 1.0, 1e-9)


def test_plate_gap_and_volume() -> None:
    first = PlateFrame(0, 0.0, 0.0, 0.0, 2.0, 0.1, -2.0, 2.0)
    second = PlateFrame(1, 0.0, 0.5, 0.0, 2.0, 0.1, -2.0, 2.0)
    assert plate_gap(first, second) == pytest.approx(0.4)
    assert plate_gap(first, PlateFrame(2, 0.5, 0.3, 90.0, 2.0, 0.1, -2.0, 2.0)) < 0.0
    assert plate_volume(first) == pytest.approx(0.8)
    assert plate_volume(first, half=True) == pytest.approx(0.4)
    assert len(plate_frames(design_of("full span"))) == 3
