"""Bolts, pins and core pins: walls between all of them, in every kind of body."""

from functools import cache
from itertools import combinations, product

import numpy as np
import pytest
from scipy.spatial import cKDTree

from fingerdesign.mold.part import BASE, INSERT
from fingerdesign.mold.plan.limits import limits_of
from fingerdesign.mold.plan.pieces import in_space
from fingerdesign.mold.plan.planning import plan_mold
from tests.support.molds import drawn, shipped

# Small and low, with windows in the side walls, round, with a bone, narrowed inserts.
SEEDS = (13, 27, 30, 42, 51, 60, 75, 81, 86, 87, 94)
NAMES = ("narrow", "both_ways", "pin", "boned", "wide")


def bars(plan):
    """Every hole of the walls as (name, start, end, radius): sockets with their clearance."""
    found = [
        (f"bolt {k}", bolt.at(bolt.low), bolt.at(bolt.high), 0.5 * bolt.diameter)
        for k, bolt in enumerate(plan.bolts)
    ]
    for k, pin in enumerate(plan.pins):
        root, way = np.array(pin.root), np.array(pin.direction)
        into = 0.5 * pin.length if pin.dowel else pin.length
        start = root - (into if pin.dowel else 0.0) * way
        end = root + (into + pin.clearance) * way
        found.append((f"pin {k}", start, end, 0.5 * pin.diameter + pin.clearance))
    for k, pin in enumerate(plan.core_pins):
        ends = [
            in_space(pin.side, pin.place, pin.y, out) for out in (pin.tip, plan.reach(pin.side))
        ]
        found.append((f"core pin {k}", *ends, 0.5 * pin.diameter))
    return found


def apart(one, other):
    """Distance of two bars' surfaces, by points along their outlines; ends are flat."""
    return cKDTree(surface(one)).query(surface(other))[0].min()


def surface(bar):
    """Points along a bar's length on its skin, by turns, and on its axis at both ends."""
    _, start, end, radius = bar
    way = (end - start) / np.linalg.norm(end - start)
    across = np.cross(way, np.eye(3)[np.argmin(np.abs(way))])
    across /= np.linalg.norm(across)
    turns = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)[:, None]
    ring = radius * (np.cos(turns) * across + np.sin(turns) * np.cross(way, across))
    places = start + np.linspace(0.0, 1.0, 61)[:, None] * (end - start)
    return np.vstack([(places[:, None] + ring[None]).reshape(-1, 3), [start, end]])


@cache
def planned(which):
    if isinstance(which, tuple):
        name, process = which
        design = shipped(name, mold__process=process, mold__plate_fixture="comb")
    else:
        design = shipped(which) if isinstance(which, str) else drawn(which)
    return plan_mold(design), limits_of(design.mold)


OTHERS = [*product(("narrow", "boned", "wide"), ("fdm", "machined")), ("wide", "sla")]


@pytest.mark.parametrize("which", [*NAMES, *SEEDS, *OTHERS])
def test_walls_stand_between_all_holes_and_to_every_face(which):
    plan, limits = planned(which)
    for one, other in combinations(bars(plan), 2):
        assert apart(one, other) >= limits.wall_mm - 1e-6, (one[0], other[0])
    assert all(pin.dowel == (limits.name == "machined") for pin in plan.pins)
    assert all(pin.diameter >= limits.pin_mm for pin in plan.pins)
    assert all(fit.clearance >= limits.clearance_mm for fit in plan.pins)
    assert all(bolt.diameter >= limits.hole_mm for bolt in plan.bolts)
    pins = plan.core_pins
    assert all(pin.diameter + 2.0 * pin.clearance >= limits.hole_mm - 1e-9 for pin in pins)
    assert min(plan.wall_x, plan.wall_z, plan.top - plan.crest, plan.base) >= limits.wall_mm - 1e-9
    sheets = max(side.sheet for side in plan.sides if side.side.endswith("x"))
    for name, start, end, radius in bars(plan):
        if name.startswith("core"):
            continue
        room = radius + limits.wall_mm - 1e-9
        across = np.abs(end - start) < 1e-9
        most = np.array([plan.reach_x, plan.top, plan.reach_z])
        assert np.all((most - np.abs(start))[across] >= room), name
        from_x = abs(start[0]) - plan.half_width - sheets
        from_z = min(abs(start[2]), abs(end[2])) - plan.half_depth
        assert max(from_x, from_z) >= room, name  # the finger's footprint
        if across[1]:
            assert room <= start[1] <= plan.top - room, name


@pytest.mark.parametrize("name", ["narrow", "pin", "both_ways"])
def test_walls_and_insert_fit_one_way_only(name):
    """Turned half round, a part meets a pin that is too big, or one in another place."""
    plan, _ = planned(name)
    for axis in ("z", "y"):
        here = {
            (round(p.root[0], 6), round(p.root[2], 6), p.diameter)
            for p in plan.pins
            if abs(p.direction[2]) == (axis == "z") and (axis == "z") != (p.on == INSERT)
        }
        turned = {(-x, -z, d) for x, z, d in here}
        assert here
        assert here != turned


def test_pins_stand_on_what_is_taken_off_first_or_last():
    plan, _ = planned("narrow")
    upright = [pin for pin in plan.pins if pin.on == INSERT]
    assert {pin.direction for pin in upright} == {(0.0, -1.0, 0.0)}
    assert all(pin.root[1] == pytest.approx(plan.rim) for pin in upright)
    level = [pin for pin in plan.pins if pin.on != INSERT]
    assert {pin.on for pin in level} == {"side_wall_right", "side_wall_left"}
    assert all(abs(pin.root[2]) == plan.corner for pin in level)
    assert all(pin.into != BASE for pin in plan.pins)


@pytest.mark.parametrize(
    ("height", "bolts"),
    [
        (10.0, {("y", "M3"), ("z", "M3")}),
        (5.3, {("y", "M2.5"), ("z", "M2.5")}),
        (4.7, {("y", "M2"), ("z", "M2")}),
        (4.0, {("y", "M2")}),
    ],
)
def test_bolts_shrink_with_the_walls_and_then_stand_upright(height, bolts):
    body = {"body__shape": "block", "body__arc_radius_mm": 20.0, "body__base_height_mm": height}
    plan = plan_mold(shipped("homogeneous", plates__count=0, **body))
    assert {(bolt.axis, bolt.size) for bolt in plan.bolts} == bolts
