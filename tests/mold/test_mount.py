"""The mount: the receiver slides onto the base plate and holds it; webs are exact distances."""

import cadquery as cq
import numpy as np
import pytest

from fingerdesign.cad.kernel import box
from fingerdesign.checks.load import with_values
from fingerdesign.mold.cad.features import features_of
from fingerdesign.mold.cad.mount import build_mount
from fingerdesign.mold.part import BASE
from fingerdesign.mold.plan.mount import flange_holes
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.mold.solids import least_distance
from tests.support.molds import shipped


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


def test_the_least_distance_of_outlines_is_exact():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    turned = square @ np.array([[np.sqrt(0.5), np.sqrt(0.5)], [-np.sqrt(0.5), np.sqrt(0.5)]])
    away, place = least_distance([square, turned + np.array([1.25 + np.sqrt(0.5), 0.1])])
    assert away == pytest.approx(0.25)
    assert place[0] == pytest.approx(1.25)
    assert least_distance([square])[0] == np.inf
