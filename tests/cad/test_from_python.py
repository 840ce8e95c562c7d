"""Bodies made by a CadQuery function of the user's own."""

import cadquery as cq
import pytest

import fingerdesign
from fingerdesign import DesignError
from fingerdesign.errors import GeometryError
from fingerdesign.layout.rows import mirrors_in_z
from tests.support.steps import read_here


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch, tmp_path):
    read_here(monkeypatch, tmp_path)


@pytest.fixture
def plain():
    return fingerdesign.parse_design('design.name = "t"\nplates.count = 3\nbody.edge_radius_mm = 1')


def brick(height=12.0):
    return cq.Workplane("XY").box(20, height, 10).translate((0, 0.5 * height, 0))


def test_two_calls_make_one_body(plain):
    first = fingerdesign.with_body(plain, brick, mirrors_in_z=True)
    assert first.body.shape == "step"
    assert first.body.base_height_mm == 12.0
    assert first.body.edge_radius_mm is None
    assert first.plates == plain.plates
    assert mirrors_in_z(first)
    again = fingerdesign.with_body(plain, brick, mirrors_in_z=True)
    assert again == first
    assert again == fingerdesign.with_body(plain, lambda: brick().val(), mirrors_in_z=True)
    other = fingerdesign.with_body(first, lambda: brick(13.0), mirrors_in_z=True)
    assert other.body.base_height_mm == 13.0
    assert other.digest() != first.digest()
    turned = fingerdesign.with_body(plain, lambda: brick().rotate((0, 0, 0), (1, 0, 0), 90), up="z")
    assert (turned.body.base_height_mm, turned.body.step.up) == (12.0, "z")


def test_what_is_no_body_is_refused(plain):
    with pytest.raises(GeometryError, match="returned str"):
        fingerdesign.with_body(plain, lambda: "a brick")
    with pytest.raises(DesignError, match=r"body\.step\.file"):
        fingerdesign.with_body(plain, lambda: cq.Workplane("XY").rect(5, 5))
    with pytest.raises(DesignError, match=r"body\.step\.wp"):
        fingerdesign.with_body(plain, brick, wp="z")
    with pytest.raises(DesignError, match=r"body\.step\.file"):
        fingerdesign.with_body(plain, brick, file="other.step")
    with pytest.raises(ZeroDivisionError):
        fingerdesign.with_body(plain, lambda: 1 / 0)
