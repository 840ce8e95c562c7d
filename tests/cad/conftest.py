"""Designs of every kind of body, plate and core, by name, for the tests of the CAD solids."""

import tomllib
from functools import cache

import pytest

from fingerdesign.cad.solid import build_solid
from fingerdesign.design.schema import Design

BODIES = {
    "arc": "",
    "arc, rounded": "edge_radius_mm = 2.0",
    "arc, chamfered": "edge_radius_mm = 2.0\nedge = 'chamfer'",
    "half circle": "arc_radius_mm = 10.0",
    "half circle, rounded": "arc_radius_mm = 10.0\nedge_radius_mm = 2.0",
    "block": "shape = 'block'",
    "block, rounded": "shape = 'block'\nedge_radius_mm = 2.0",
    "block, rounded to a half circle": (
        "shape = 'block'\nedge_radius_mm = 10.0\nbase_height_mm = 14.0"
    ),
    "block, chamfered": "shape = 'block'\nedge_radius_mm = 2.0\nedge = 'chamfer'",
    "dome": "shape = 'dome'\ndome_radius_mm = 12.0",
    "dome about an axis below the base": "shape = 'dome'\ndome_radius_mm = 1e4",
    "dome, rounded": "shape = 'dome'\ndome_radius_mm = 12.0\nedge_radius_mm = 2.0",
    "dome, chamfered": (
        "shape = 'dome'\ndome_radius_mm = 60.0\nedge_radius_mm = 2.0\nedge = 'chamfer'"
    ),
    "dome of half circles": "shape = 'dome'\narc_radius_mm = 10.0\ndome_radius_mm = 30.0",
    "revolved": "shape = 'revolved'",
    "revolved, hemisphere": "shape = 'revolved'\narc_radius_mm = 10.0",
    "revolved, rounded": "shape = 'revolved'\nedge_radius_mm = 2.0",
    "revolved, chamfered": "shape = 'revolved'\nedge_radius_mm = 2.0\nedge = 'chamfer'",
}
PLATES = {
    "full span": "count = 3",
    "ends inside": "count = 3\nspan_mm = 6.0",
    "off the middle": "count = 3\nspan_mm = 4.0\nspan_offset_mm = 1.0\nstagger_mm = 2.0",
    "two rows": "count = 3\nspan_mm = 6.0\n[[plates.rows]]\ncover_mm = 5.0\ncount = 2",
    "one by one": "placement = [[-4.0, 8.0, 20.0], [3.0, 6.0, -70.0]]",
    "turned": "count = 3\nspan_mm = 6.0\npitch_mm = 2.0\nfollow = 'turned'",
    "bent": "count = 3\npitch_mm = 3.0\nfollow = 'bent'\nangle_deg = 0.0",
    "perforated": "count = 3\nspan_mm = 8.0\nhole_diameter_mm = 0.6",
    "bent, perforated": (
        "count = 3\npitch_mm = 3.0\nfollow = 'bent'\nangle_deg = 0.0\nspan_mm = 8.0\n"
        "hole_diameter_mm = 0.6"
    ),
    "along z": "count = 3\nalong = 'z'\npitch_mm = 2.0\nspan_mm = 6.0",
    "along z, level": "count = 1\nalong = 'z'\nangle_deg = 0.0\nspan_mm = 6.0",
    "along z, perforated": (
        "count = 1\nalong = 'z'\nangle_deg = 180.0\nspan_mm = 6.0\nhole_diameter_mm = 0.6"
    ),
    "along z, upright": "count = 1\nalong = 'z'\nangle_deg = 90.0\nspan_mm = 6.0",
}
SLOW = {"bent, perforated"}  # its files are written in test_export
CORES = {
    "a bone": "bottom_mm = 2.0\ndepth_mm = 5.0",
    "a bone through the depth": "bottom_mm = 2.0",
    "standing on the base": "depth_mm = 5.0",
    "standing, full depth": "",
    "standing, full width": "width_mm = 20.0\ndepth_mm = 5.0",
    "a backing": "width_mm = 20.0",
}


def make_design(body="arc", plates="", core=""):
    """The design of these tables' kinds; its plates are not checked against its body."""
    text = [
        'design.name = "t"',
        f"[body]\n{BODIES[body]}",
        f"[body.core]\n{CORES[core]}" if core else "",
        f"[plates]\n{PLATES[plates] if plates else 'count = 0'}",
    ]
    return Design.model_validate(tomllib.loads("\n".join(text)))


@cache
def built(body="arc", plates="", core="", half=False):
    """The solid of such a design."""
    return build_solid(make_design(body, plates, core), half)


@pytest.fixture
def design_of():
    return make_design


@pytest.fixture
def solid_of():
    return built


def pytest_generate_tests(metafunc):
    """Tests that name ``body``, ``plates`` or ``core`` run for each kind of it."""
    for name, kinds in (("body", BODIES), ("plates", PLATES), ("core", CORES)):
        if name in metafunc.fixturenames:
            marked = [pytest.param(k, marks=[pytest.mark.slow] * (k in SLOW)) for k in kinds]
            metafunc.parametrize(name, marked)
