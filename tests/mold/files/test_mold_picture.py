"""A mold's exploded picture: what moves where, the drawing itself, a drawing that fails."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.errors import PictureError
from fingerdesign.mold import page as mold_picture
from fingerdesign.mold.page import (
    AXES,
    FILLED,
    SIZE,
    VIEW_ANGLE,
    camera_at,
    exploded_job,
    exploded_of,
    exploded_parts,
    numbered,
)
from tests.support.molds import box


@pytest.fixture(scope="module")
def meshes(hand_made):
    """The block's mold, a core in it."""
    made = hand_made()[2]
    return replace(made, parts=(*made.parts, box("core", (-4, 0, -3), (4, 3, 3))))


def test_each_part_moves_along_its_draw_and_the_finger_stays(meshes):
    moves = {each.name: np.array(each.move) for each in exploded_parts(meshes)}
    assert moves["contact_insert"][1] > 0.0
    assert moves["end_wall_front"][2] > moves["comb_front"][2] > 0.0
    assert moves["side_wall_left"][0] < 0.0
    assert moves["base_plate"][1] < moves["core"][1] < 0.0
    assert not moves["rubber"].any()
    assert not moves["plate_0"].any()
    assert sorted(numbered(meshes).values()) == list(range(1, 10))


def test_the_camera_sees_every_corner(meshes):
    points = np.vstack([shown.points for shown in exploded_parts(meshes)])
    offset = (points - camera_at(points, AXES, SIZE)) @ AXES.T
    slope = np.tan(np.radians(0.5 * VIEW_ANGLE))
    places = offset[:, :2] / -offset[:, 2:] / slope / [SIZE[0] / SIZE[1], 1.0]
    assert np.abs(places).max() == pytest.approx(FILLED)  # of half the frame: it wastes little
    assert places.min(axis=0) + places.max(axis=0) == pytest.approx(0.0, abs=0.04)


def test_drawn_in_a_process_with_its_badges(meshes):
    with exploded_job(meshes) as job:
        shown = exploded_of(job, meshes)
    assert shown.png[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", shown.png[16:24]) == SIZE
    tops = {badge.name: badge.top for badge in shown.badges}
    assert tops["contact_insert"] < tops["end_wall_front"] < tops["base_plate"]
    assert "1 contact insert" in shown.alternative


def test_a_drawing_that_fails_is_a_sentence(meshes, monkeypatch):
    monkeypatch.setattr(mold_picture, "COLOURS", dict.fromkeys(mold_picture.COLOURS, "no colour"))
    with exploded_job(meshes) as job, pytest.raises(PictureError, match=r"it failed: .*colour"):
        exploded_of(job, meshes)
