"""Faces of a body of the user's own that would hold a mold part, named; those that do not."""

import cadquery as cq
import pytest

from fingerdesign.cad.bodies import outline_solid
from fingerdesign.cad.from_python import with_body
from fingerdesign.checks.load import parse_design
from fingerdesign.errors import GeometryError
from fingerdesign.mold.cad.build import build_mold, undercuts
from fingerdesign.mold.plan.planning import plan_mold

PLAIN = parse_design('design.name = "cut"\nplates.count = 0')


def block():
    return cq.Workplane("XY").box(16.0, 10.0, 12.0).translate((0, 5.0, 0))


def along_z(*corners):
    """A prism over all of the depth through corners (x, y)."""
    return cq.Workplane("XY", origin=(0, 0, -20)).polyline(corners).close().extrude(40.0)


def found(make):
    design = with_body(PLAIN, make, mirrors_in_z=True)
    plan = plan_mold(design)
    return design, plan, undercuts(outline_solid(design.body), plan)


def test_a_dovetail_in_the_contact_surface_is_named_and_refused():
    def make():
        return block().cut(along_z((-1, 10), (1, 10), (2, 8), (-2, 8)))

    design, plan, faces = found(make)
    assert {each.part for each in faces} == {"contact_insert"}
    assert len(faces) == 2
    for each in faces:
        assert 1.0 < abs(each.place[0]) < 2.0
        assert 8.0 < each.place[1] < 10.0
    with pytest.raises(GeometryError, match=rf"face {faces[0].face} of body.step at \(.*insert"):
        build_mold(design, plan)


def test_a_groove_that_widens_upward_comes_out():
    def make():
        return block().cut(along_z((-2, 10), (2, 10), (1, 8), (-1, 8)))

    design, plan, faces = found(make)
    assert faces == ()
    assert build_mold(design, plan).rubber.solid.isValid()


def test_a_hole_along_x_through_the_finger_holds_parts():
    def make():
        return block().cut(cq.Workplane("YZ", origin=(-20, 4, 0)).circle(1.5).extrude(40.0))

    _, _, faces = found(make)
    assert faces


def test_shipped_shapes_have_none():
    from fingerdesign.checks.starter import find_design

    for name in ("domed", "pin", "block", "maeno2000"):
        design = find_design(name)
        assert undercuts(outline_solid(design.body), plan_mold(design)) == ()
