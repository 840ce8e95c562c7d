"""Printed parts in one 3MF: a flat face down, apart from each other, in millimetres, read back."""

import locale
import zipfile

import numpy as np
import pytest

from fingerdesign.errors import GeometryError
from fingerdesign.mold.part import PartMesh
from fingerdesign.mold.products import three_mf
from fingerdesign.mold.products.three_mf import flat_faces, laid_out, read_3mf, write_3mf

CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
BOX = np.array(
    [
        *([0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4]),
        *([1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]),
    ]
)


def part(name, size, draw=(0.0, 1.0, 0.0), low=(0.0, 0.0, 0.0), vertices=None):
    points = CORNERS * size + low if vertices is None else vertices
    return PartMesh(
        name, points, BOX, draw, 0, "process", float(np.prod(size)), 0.0, points, BOX, 1.0
    )


def test_largest_face_lies_on_the_bed():
    (posed,) = laid_out((part("wall", (2.0, 7.0, 5.0), draw=None, low=(3.0, 4.0, 5.0)),))
    assert posed.flat_area == pytest.approx(35.0)
    assert posed.size == pytest.approx((7.0, 5.0, 2.0))
    assert posed.vertices.min(axis=0) == pytest.approx(0.0)


def test_turning_keeps_the_part_from_being_mirrored():
    wedge = CORNERS * [2.0, 7.0, 5.0]
    wedge[6] += [0.0, 3.0, 1.0]
    for draw in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, -1.0), None):
        given = part("wedge", (1, 1, 1), draw, vertices=wedge)
        (posed,) = laid_out((given,))
        assert three_mf._volume(posed.vertices, BOX) == pytest.approx(
            three_mf._volume(wedge, BOX), rel=1e-12
        )


def test_the_face_away_from_the_finger_is_taken_before_its_like():
    (posed,) = laid_out((part("side", (2.0, 7.0, 5.0), draw=(1.0, 0.0, 0.0)),))
    assert posed.down == pytest.approx((1.0, 0.0, 0.0))
    (other,) = laid_out((part("side", (2.0, 7.0, 5.0), draw=(-1.0, 0.0, 0.0)),))
    assert other.down == pytest.approx((-1.0, 0.0, 0.0))


def test_a_face_that_something_stands_out_of_is_none_to_lie_on():
    bumped = CORNERS * [10.0, 10.0, 1.0]
    bumped[6, 2] = 2.0  # the face z = 1 is no longer flat
    normals = [tuple(np.round(n, 3)) for _, n in flat_faces(part("b", (1, 1, 1), vertices=bumped))]
    assert (0.0, 0.0, -1.0) in normals
    assert (0.0, 0.0, 1.0) not in normals


def test_neighbours_keep_apart():
    posed = laid_out(tuple(part(f"p{k}", (10.0 + k, 3.0 + k, 20.0)) for k in range(7)))
    boxes = [(*each.place, each.place[0] + each.size[0], each.place[1] + each.size[1]) for each in
             posed]  # fmt: skip
    for k, a in enumerate(boxes):
        for b in boxes[:k]:
            gaps = (a[0] - b[2], b[0] - a[2], a[1] - b[3], b[1] - a[3])
            assert max(gaps) >= 5.0 - 1e-9


def test_written_and_read_back_in_millimetres(tmp_path):
    before = locale.setlocale(locale.LC_ALL)
    posed = laid_out((part("base_plate", (30.0, 4.0, 20.0)), part("contact_insert", (30, 9, 20))))
    path = tmp_path / "mold.3mf"
    held = write_3mf(posed, path, "a finger's mold")
    assert [each.name for each in held] == [each.name for each in posed]
    assert {each.name: round(each.volume, 3) for each in held} == {
        "base_plate": 2400.0,
        "contact_insert": 5400.0,
    }
    with zipfile.ZipFile(path) as archive:
        text = archive.read("3D/3dmodel.model").decode()
    assert 'unit="millimeter"' in text
    assert "a finger's mold" in text or "a finger&apos;s mold" in text
    assert locale.setlocale(locale.LC_ALL) == before  # the library sets it to C


def test_a_file_that_lost_something_is_refused(tmp_path, monkeypatch):
    posed = laid_out((part("base_plate", (30.0, 4.0, 20.0)),))
    real = read_3mf
    monkeypatch.setattr(
        three_mf,
        "read_3mf",
        lambda path: tuple(
            three_mf.Held(h.name, h.vertices, h.triangles, h.volume * 1.001) for h in real(path)
        ),
    )
    with pytest.raises(GeometryError, match="base_plate has"):
        write_3mf(posed, tmp_path / "mold.3mf", "x")


def test_a_folder_that_is_not_there_is_a_sentence(tmp_path):
    posed = laid_out((part("base_plate", (30.0, 4.0, 20.0)),))
    with pytest.raises(GeometryError, match=r"mold\.3mf could not be written"):
        write_3mf(posed, tmp_path / "none" / "mold.3mf", "x")
