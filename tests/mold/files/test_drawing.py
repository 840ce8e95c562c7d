"""Flat pieces to cut: outlines from a sheet's triangles, DXF with layers and units, read back."""

import ezdxf
import numpy as np
import pytest

from fingerdesign.errors import GeometryError
from fingerdesign.mold.part import PartMesh
from fingerdesign.mold.products import drawing
from fingerdesign.mold.products.drawing import (
    Sheet,
    as_circle,
    border_loops,
    comb_sheet,
    polygon_area,
    write_dxf,
)

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def comb(axis="z", thickness=0.3, volume=None):
    """A sheet 10 x 8 with one opening 4 x 2, from z = 5 to 5 + thickness."""
    outer = np.array([[0, 0], [10, 0], [10, 8], [0, 8]], float)
    inner = np.array([[3, 3], [7, 3], [7, 5], [3, 5]], float)
    ring = np.vstack([outer, inner])
    low = np.column_stack([ring, np.full(8, 5.0)])
    points = np.vstack([low, low + np.array([0, 0, thickness])])
    caps, walls = [], []
    for k in range(4):
        j = (k + 1) % 4
        caps += [[8 + k, 8 + j, 12 + j], [8 + k, 12 + j, 12 + k], [k, 4 + j, j], [k, 4 + k, 4 + j]]
        walls += [[k, j, 8 + j], [k, 8 + j, 8 + k], [4 + j, 4 + k, 12 + k], [4 + j, 12 + k, 12 + j]]
    triangles = np.array([*caps, *walls])
    if axis == "x":
        points, triangles = points[:, [2, 1, 0]], triangles[:, ::-1]
    volume = (80.0 - 8.0) * thickness if volume is None else volume
    return PartMesh(
        *("comb_front", points, triangles, (0, 0, 1), 1, "sheet", volume, 0.0),
        *(points, triangles, volume),
    )


@pytest.mark.parametrize(("axis", "side"), [("z", "+z"), ("z", "-z"), ("x", "+x"), ("x", "-x")])
def test_outline_and_opening_of_a_sheet(axis, side):
    found = comb_sheet(comb(axis), side)
    assert len(found.outline) == 4
    assert polygon_area(found.outline) == pytest.approx(80.0)
    assert [polygon_area(each) for each in found.openings] == pytest.approx([8.0])
    assert found.circles == ()


def test_a_round_hole_is_distinguished_from_a_slot():
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    circle = np.column_stack([3.0 + 1.5 * np.cos(angle), -2.0 + 1.5 * np.sin(angle)])
    assert as_circle(circle) == pytest.approx((3.0, -2.0, 1.5))
    assert as_circle(circle + 1.23456e-4) == (3.0, -2.0, 1.5)  # in micrometres: what is cut
    assert as_circle(circle * [1.0, 1.01]) is None
    assert as_circle(SQUARE) is None


def test_an_outline_that_is_not_the_solid_is_refused():
    with pytest.raises(GeometryError, match="comb_front: its outline times its thickness"):
        comb_sheet(comb(volume=20.0), "+z")


def test_a_border_that_meets_itself_is_refused():
    with pytest.raises(GeometryError, match="meets itself"):
        border_loops(np.array([[0, 1, 2], [0, 3, 4]]), "comb_front")


def sheets():
    plate = Sheet(
        "plate_A",
        SQUARE * [2.0, 10.0],
        circles=((1.0, 2.0, 0.3),),
        gages=(SQUARE + np.array([0.5, 4.5]),),
        bends=(np.array([[0.0, 5.0], [2.0, 5.0]]),),
        text=("plate_A: 15 of 0.1 mm phosphor bronze",),
    )
    return (plate, Sheet("comb_front", SQUARE * 8.0, openings=(SQUARE + np.array([2.0, 2.0]),)))


def test_drawn_in_millimetres_on_its_layers(tmp_path):
    path = tmp_path / "plates.dxf"
    write_dxf(sheets(), path)
    document = ezdxf.filemanagement.readfile(path)
    assert document.header["$INSUNITS"] == 4
    kinds = sorted((each.dxf.layer, each.dxftype()) for each in document.modelspace())
    assert kinds == [
        ("BEND", "LINE"),
        ("CUT", "LWPOLYLINE"),
        ("CUT", "LWPOLYLINE"),
        ("GAGES", "LWPOLYLINE"),
        ("HOLES", "CIRCLE"),
        ("HOLES", "LWPOLYLINE"),
        ("TEXT", "TEXT"),
    ]


def test_pieces_lie_apart(tmp_path):
    path = tmp_path / "plates.dxf"
    write_dxf(sheets(), path)
    lines = ezdxf.filemanagement.readfile(path).modelspace().query('LWPOLYLINE[layer=="CUT"]')
    spans = [[x for x, _ in line.get_points("xy")] for line in lines]
    assert min(spans[1]) - max(spans[0]) >= 5.0


def test_area_of_the_metal_left():
    assert sheets()[0].area == pytest.approx(20.0 - np.pi * 0.09)
    assert sheets()[1].area == pytest.approx(63.0)


def test_a_drawing_that_is_not_what_was_given_is_refused(tmp_path, monkeypatch):
    real = drawing._draw
    monkeypatch.setattr(
        drawing,
        "_draw",
        lambda space, sheet, shift: real(
            space, Sheet(sheet.name, sheet.outline * 1.01, text=sheet.text), shift
        ),
    )
    with pytest.raises(GeometryError, match="areas on layer CUT"):
        write_dxf(sheets(), tmp_path / "plates.dxf")


def test_a_folder_that_is_not_there_is_a_sentence(tmp_path):
    with pytest.raises(GeometryError, match=r"plates\.dxf could not be written"):
        write_dxf(sheets(), tmp_path / "none" / "plates.dxf")
