"""A mold's exploded picture: what moves where, the drawing itself, a drawing that fails."""

import struct

import numpy as np
import pytest

from fingerdesign.errors import PictureError
from fingerdesign.mold import picture as mold_picture
from fingerdesign.mold.part import MoldMeshes
from fingerdesign.mold.picture import (
    SIZE,
    View,
    exploded_job,
    exploded_of,
    exploded_parts,
    numbered,
)
from tests.support.molds import box


def meshes():
    rubber = box("rubber", (-10, 0, -5), (10, 12, 5), None, 9, "silicone")
    parts = (
        box("contact_insert", (-20, 12, -15), (20, 18, 15), (0, 1, 0), 0),
        box("end_wall_front", (-20, 0, 5.3), (20, 12, 15), (0, 0, 1), 1),
        box("comb_front", (-10, 0, 5), (10, 12, 5.3), (0, 0, 1), 2, "sheet"),
        box("side_wall_left", (-18, 0, -5), (-10, 12, 5), (-1, 0, 0), 3),
        box("base_plate", (-20, -4, -15), (20, 0, 15), None, 9),
        box("core", (-4, 0, -3), (4, 3, 3), None, 9),
    )
    plates = (box("plate_0", (-1, 9, -8), (1, 9.1, 8), None, 9, "metal"),)
    return MoldMeshes(parts, plates, rubber, rubber, (-18, 0, -15), (18, 18, 15))


def test_each_part_moves_along_its_draw_and_the_finger_stays():
    moves = {each.name: np.array(each.move) for each in exploded_parts(meshes())}
    assert moves["contact_insert"][1] > 0.0
    assert moves["end_wall_front"][2] > moves["comb_front"][2] > 0.0
    assert moves["side_wall_left"][0] < 0.0
    assert moves["base_plate"][1] < moves["core"][1] < 0.0
    assert not moves["rubber"].any()
    assert not moves["plate_0"].any()
    assert sorted(numbered(meshes()).values()) == [1, 2, 3, 4, 5, 6]


def test_the_camera_sees_every_corner():
    points = np.vstack([shown.points for shown in exploded_parts(meshes())])
    view = View.of(points)
    places = view.places(points)
    assert places.min() > 0.0
    assert places.max() < 1.0
    assert np.ptp(places, axis=0).max() > 0.9  # and wastes little of the frame
    assert places.min(axis=0) + places.max(axis=0) == pytest.approx(1.0, abs=0.02)


def test_drawn_in_a_process_with_its_badges():
    with exploded_job(meshes()) as job:
        shown = exploded_of(job, meshes())
    assert shown.png[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", shown.png[16:24]) == SIZE
    tops = {badge.name: badge.top for badge in shown.badges}
    assert tops["contact_insert"] < tops["end_wall_front"] < tops["base_plate"]
    assert "1 contact insert" in shown.alternative


def test_a_drawing_that_fails_is_a_sentence(monkeypatch):
    monkeypatch.setattr(mold_picture, "COLOURS", dict.fromkeys(mold_picture.COLOURS, "no colour"))
    with exploded_job(meshes()) as job, pytest.raises(PictureError, match=r"it failed: .*colour"):
        exploded_of(job, meshes())
