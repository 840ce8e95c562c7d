"""The mount: the receiver slides onto the base plate and holds it; webs are exact distances."""

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

from fingerdesign.cad.kernel import box
from fingerdesign.checks.load import with_values
from fingerdesign.mold.cad.features import features_of
from fingerdesign.mold.cad.mount import build_mount
from fingerdesign.mold.part import BASE
from fingerdesign.mold.plan.mount import HEAD_MM, flange_holes
from fingerdesign.mold.plan.pieces import BaseHole
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.plan.refusals import MoldRefused
from fingerdesign.mold.solids import least_distance
from tests.support.molds import shipped

LARGE = {"width": 44.0, "depth": 40.0, "arc_radius": 120.0}


@pytest.fixture(scope="module")
def mounted():
    plan = plan_mold(shipped("film_tees"))
    (receiver,) = build_mount(plan)
    base = box((-plan.mount_x, -plan.base, -plan.mount_z), (plan.mount_x, 0.0, plan.mount_z))
    return plan, receiver.solid, base.cut(*features_of(plan).cut[BASE])


def test_the_base_plate_slides_in_from_the_front_and_cannot_be_lifted_out(mounted):
    plan, receiver, base = mounted
    for slid in (0.0, 3.0, 2.0 * plan.mount_z):
        assert receiver.intersect(base.translate(cq.Vector(0, 0, slid))).Volume() < 1e-6
    assert receiver.intersect(base.translate(cq.Vector(0, 0, -1.0))).Volume() > 1.0  # it stops
    assert receiver.intersect(base.translate(cq.Vector(0, 0.5, 0))).Volume() > 1.0  # its lips hold
    body = box((-plan.half_width, 0.0, -plan.half_depth), (plan.half_width, 9.0, plan.half_depth))
    assert receiver.intersect(body).Volume() == 0.0


def test_the_pattern_of_iso_9409_is_a_circle_of_50_mm(mounted):
    plan = plan_mold(with_values(mounted[0].design, {"mold.mount": "iso9409"}))
    holes = np.array(flange_holes(plan))
    assert 2.0 * np.hypot(holes[:, 0], holes[:, 1]) == pytest.approx(np.full(4, 50.0))
    assert build_mount(plan)[0].solid.BoundingBox().xlen == pytest.approx(63.0, abs=0.1)


def test_a_flange_whose_screws_would_be_below_the_base_plate_is_refused(mounted):
    """Heads of 10 mm at (17.7, 17.7): clear of 26 x 14.6 mm, not of 48 x 44.6 mm."""
    large = {f"body.{key}_mm": size for key, size in LARGE.items()} | {"plates.span_mm": 40.0}
    assert plan_mold(with_values(mounted[0].design, large))
    with pytest.raises(MoldRefused, match=r"mold.mount = iso9409: must be inserts.*48 x 44.6"):
        plan_mold(with_values(mounted[0].design, large | {"mold.mount": "iso9409"}))


@pytest.mark.parametrize(
    ("changes", "groove"),
    [
        # A wall of 1.05 mm above and below it in a plate of 4 mm, of 3 mm, of 2.4 mm.
        ({}, (1.0, -2.95, -1.75)),
        ({"base": 3.0}, (1.0, -1.95, -1.05)),
        ({"base": 2.4}, None),
        # The plate is 0.8 mm wider than the finger, or has a hole that ends 1.5 mm from its edge.
        ({"mount_x": 11.8, "base_holes": ()}, (0.75, -2.95, -1.75)),
        ({"base_holes": (BaseHole("lock", -10.0, 0.0, 2.0, 3.0),)}, (0.45, -2.95, -1.75)),
    ],
)
def test_the_groove_leaves_walls_around_it(mounted, changes, groove):
    found = replace(mounted[0], **changes).groove
    assert found == (groove if groove is None else pytest.approx(groove))


def test_screws_heads_have_room_and_inserts_a_wall_between_them():
    plan = plan_mold(shipped("film_tees", mold__mount="iso9409"))
    (receiver,) = build_mount(plan)
    for x, z, _ in flange_holes(plan):
        at = cq.Vector(x, -plan.base - plan.limits.clearance_mm, z)
        head = cq.Solid.makeCylinder(0.5 * HEAD_MM, 6.0, at, cq.Vector(0.0, 1.0, 0.0))
        assert receiver.solid.intersect(head).Volume() < 1e-6
    slim = plan_mold(shipped("homogeneous", body__width_mm=4.0, body__arc_radius_mm=8.0))
    (one, _, wide), (other, *_) = flange_holes(slim)
    assert abs(one - other) == pytest.approx(wide + 2.0)


def test_the_least_distance_of_outlines_is_exact():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    turned = square @ np.array([[np.sqrt(0.5), np.sqrt(0.5)], [-np.sqrt(0.5), np.sqrt(0.5)]])
    away, place = least_distance([square, turned + np.array([1.25 + np.sqrt(0.5), 0.1])])
    assert away == pytest.approx(0.25)
    assert place[0] == pytest.approx(1.25)
    assert least_distance([square])[0] == np.inf
