"""Pictures of a mold: what moves where, what each step shows, the drawing, one that fails."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.layout.fitting import gage_fit
from fingerdesign.mold.aids import aids_of
from fingerdesign.mold.picture import (
    exploded_parts,
    numbered,
    pictures_job,
    pictures_of,
    step_parts,
)
from fingerdesign.mold.products.casting import casting_of
from fingerdesign.mold.products.notes import View, casting_notes
from fingerdesign.mold.render import FILLED, FRONT_VIEW, SIZE, VIEW_ANGLE, camera_at, camera_axes
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
    assert sorted(numbered(meshes).values()) == list(range(1, 11))


def test_the_camera_sees_every_corner(meshes):
    points = np.vstack([shown.points for shown in exploded_parts(meshes)])
    axes = camera_axes(FRONT_VIEW)
    offset = (points - camera_at(points, axes, SIZE)) @ axes.T
    slope = np.tan(np.radians(0.5 * VIEW_ANGLE))
    places = offset[:, :2] / -offset[:, 2:] / slope / [SIZE[0] / SIZE[1], 1.0]
    assert np.abs(places).max() == pytest.approx(FILLED)  # of half the frame: it wastes little
    assert places.min(axis=0) + places.max(axis=0) == pytest.approx(0.0, abs=0.04)


STEPS = (
    View("Close the mold", 3, "+z", "put", ("end_wall_back", "comb_back")),
    View("Close the mold", 4, "+z", "put", ("plates",)),
)


@pytest.mark.slow
def test_drawn_in_a_process_with_its_badges_and_steps(meshes):
    with pictures_job(meshes, STEPS) as job:
        shown = pictures_of(job, meshes, STEPS)
    png = shown.opened.png
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", png[16:24]) == SIZE
    tops = {badge.name: badge.top for badge in shown.opened.badges}
    assert tops["contact_insert"] < tops["end_wall_front"] < tops["base_plate"]
    assert "1 contact insert" in shown.opened.alternative
    assert list(shown.steps) == [("Close the mold", 3), ("Close the mold", 4)]
    assert "plates are put in place" in shown.steps["Close the mold", 4].alternative
    assert shown.steps["Close the mold", 3].png != shown.steps["Close the mold", 4].png


@pytest.mark.parametrize("up", ["+x", "-x", "+y", "-y", "+z", "-z"])
def test_a_picture_is_turned_until_its_axis_is_up(up):
    right, above, out = camera_axes((-0.7, 0.5, 1.0), up)
    axis = np.eye(3)["xyz".index(up[1])] * (1 if up[0] == "+" else -1)
    assert axis @ right == pytest.approx(0.0, abs=1e-12)
    assert axis @ above > 0.8
    assert np.linalg.det([right, above, out]) == pytest.approx(1.0)


@pytest.mark.parametrize("fixture", ["comb", "slots"])
def test_every_part_is_put_once_and_what_is_drawn_is_taken(hand_made, fixture):
    design, plan, made = hand_made(fixture)
    _, views = casting_notes(casting_of(plan, made, gage_fit(design)))
    aids = aids_of(casting_of(plan, made, gage_fit(design)))
    aside = {*aids, *(piece.name for piece in made.coupon), "mount"}

    def named(verb):
        own = (view for view in views if view.verb == verb and view.section != "Make the parts")
        return [name for view in own for name in view.names]

    put, taken = ([n for n in named(verb) if n not in aside] for verb in ("put", "take"))
    assert sorted(put) == sorted([*(part.name for part in made.parts), "plates", "rubber"])
    assert sorted(taken) == sorted(part.name for part in made.parts if part.draw is not None)
    helped = {name: {n for n in named(name) if n in aside} for name in ("put", "take")}
    lasting = {n for n in helped["put"] if n.startswith(("bolts", "band", "tape"))}
    assert lasting <= helped["take"] <= helped["put"] | {"leg_ends", "leg_stubs"}
    shown = step_parts(made, views, aids)
    for view, things in zip(views, shown, strict=True):
        there = {each.name for each in things}
        for name in view.names:
            meshes = aids.get(name, ())
            assert {mesh.name for mesh in meshes} <= there
            assert meshes or name not in aids or name.startswith("core_pins"), name
