"""Quadrics, NURBS surfaces and borders of faces against closed forms and their definitions."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from fingerdesign.design.scene import SceneObject
from fingerdesign.shapes.faces import Border, CadFace, Smooth, nearest
from fingerdesign.shapes.nurbs import Nurbs
from fingerdesign.shapes.quadrics import Cone, Plane, Sphere, roots, unit

AXIS = np.array([2.0, -1.0, 2.0]) / 3.0
CENTRE = np.array([0.3, 1.2, -0.7])
SHAPES = {
    "plane": Plane(AXIS, 0.4),
    "sphere": Sphere(CENTRE, 2.0),
    "cylinder": Cone(CENTRE, AXIS, 1.5),
    "cone": Cone(CENTRE, AXIS, 1.5, 0.2),
}


@pytest.mark.parametrize("kind", SHAPES)
def test_the_normal_is_the_gradient_of_the_distance(kind):
    shape = SHAPES[kind]
    points = np.random.default_rng(1).uniform(-4, 4, (200, 3))
    normal = shape.normal(points)
    for axis in range(3):
        shift = 1e-6 * np.eye(3)[axis]
        slope = (shape.distance(points + shift) - shape.distance(points - shift)) / 2e-6
        np.testing.assert_allclose(normal[:, axis], slope, atol=2e-7)


@pytest.mark.parametrize("kind", SHAPES)
def test_heights_lie_on_the_shape_and_none_is_missed(kind):
    shape = SHAPES[kind]
    points = np.random.default_rng(2).uniform(-3, 3, (300, 3))
    feet = points - shape.distance(points)[:, None] * shape.normal(points)
    found = shape.heights(feet[:, 0], feet[:, 2])
    for row in found:
        known = np.isfinite(row)
        on = np.column_stack([feet[:, 0], row, feet[:, 2]])[known]
        np.testing.assert_allclose(shape.distance(on), 0.0, atol=1e-10)
    nearest = np.nanmin(np.abs(found - feet[:, 1]), axis=0)
    np.testing.assert_allclose(nearest, 0.0, atol=1e-7)


def test_roots_touch_miss_and_do_not_cancel():
    found = roots(np.ones(3), np.array([0.0, 0.0, -1e8]), np.array([0.0, 1.0, 1.0]), 1.0)
    assert found[:, 0].tolist() == [0.0, 0.0]
    assert np.isnan(found[:, 1]).all()
    np.testing.assert_allclose(sorted(found[:, 2]), [5e-9, 2e8], rtol=1e-12)


def test_a_cone_has_one_half_and_an_upright_plane_no_height():
    cone = Cone(np.zeros(3), np.array([0.0, 1.0, 0.0]), 1.0, -0.5)  # its tip at y = 2
    found = cone.heights(np.array([0.5, 3.0]), np.zeros(2))
    assert sorted(found[np.isfinite(found)]) == pytest.approx([-4.0, 1.0])
    assert np.isnan(Plane(np.array([1.0, 0.0, 0.0]), 0.4).heights(np.ones(2), np.ones(2))).all()
    assert not unit(np.zeros((1, 3))).any()


# NURBS: sums of SciPy's bases, a cylinder and a closed tube.

HALF = np.sqrt(0.5)


def quarter_cylinder():
    """x^2 + y^2 = 100, x, y >= 0, 0 <= z <= 20; outside: away from the axis."""
    flat = np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) * 10.0
    poles = np.array([[[*xy, 20.0 * z] for z in (0, 1)] for xy in flat])
    weights = np.array([[1.0, 1.0], [HALF, HALF], [1.0, 1.0]])
    knots = np.array([0.0, 0, 0, 1, 1, 1]), np.array([0.0, 0, 1, 1])
    return Nurbs((2, 1), *knots, poles, weights, (0.0, 1.0, 0.0, 1.0))


def closed_tube():
    """The whole circle of radius 10 in four quarters, z from 0 to 5."""
    ring = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    poles = np.array([[[10.0 * x, 10.0 * y, 5.0 * z] for z in (0, 1)] for x, y in ring])
    weights = np.tile(np.array([HALF if k % 2 else 1.0 for k in range(9)])[:, None], (1, 2))
    knots = np.array([0.0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]), np.array([0.0, 0, 1, 1])
    return Nurbs((2, 1), *knots, poles, weights, (0.0, 4.0, 0.0, 1.0), (True, False))


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_points_and_derivatives_are_the_rational_sums_of_the_bases(degree):
    rng, step = np.random.default_rng(0), 1e-5
    knots = np.array([0.0] * (degree + 1) + [0.3, 0.5, 0.8] + [1.0] * (degree + 1))
    count = len(knots) - degree - 1
    poles, weights = rng.normal(size=(count, count, 3)), rng.uniform(0.5, 2.0, (count, count))
    surface = Nurbs((degree, degree), knots, knots, poles, weights, (0.0, 1.0, 0.0, 1.0))
    u, v = rng.uniform(0.05, 0.25, (2, 40))  # within one piece
    one, two = (np.stack([BSpline(knots, row, degree)(t) for row in np.eye(count)]) for t in (u, v))
    weighted = np.einsum("in,jn,ij->nij", one, two, weights)
    wanted = np.einsum("nij,ija->na", weighted, poles) / weighted.sum(axis=(1, 2))[:, None]
    found = surface.derivatives(u, v)
    np.testing.assert_allclose(found[0], wanted, atol=1e-12)
    np.testing.assert_allclose(surface.at(u, v), wanted, atol=1e-12)
    ends = [surface.derivatives(u + a * step, v + b * step) for a, b in ((1, 0), (0, 1))]
    starts = [surface.derivatives(u - a * step, v - b * step) for a, b in ((1, 0), (0, 1))]
    by_u, by_v = (np.subtract(*pair) / (2.0 * step) for pair in zip(ends, starts, strict=True))
    size = np.abs(found[3]).max() + np.abs(found[1]).max()
    for exact, slope in zip(found[1:], (by_u[0], by_v[0], by_u[1], by_u[2], by_v[2]), strict=True):
        np.testing.assert_allclose(exact, slope, atol=1e-6 * size)


def test_distance_normal_and_height_of_a_cylinder():
    surface, rng = quarter_cylinder(), np.random.default_rng(2)
    angle, radius, z = (
        rng.uniform(0, np.pi / 2, 500),
        rng.uniform(6, 14, 500),
        rng.uniform(0, 20, 500),
    )
    radial = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(500)])
    points = radius[:, None] * radial + z[:, None] * [0.0, 0.0, 1.0]
    np.testing.assert_allclose(surface.distance(points), radius - 10.0, atol=1e-12)
    np.testing.assert_allclose(surface.normal(points), radial, atol=1e-12)
    x = rng.uniform(0, 9.99, 200)
    found = surface.heights(x, z[:200])
    np.testing.assert_allclose(np.nanmax(found, axis=0), np.sqrt(100 - x**2), atol=1e-11)


def test_a_closed_surface_is_followed_across_its_seam():
    tube, angle = closed_tube(), np.array([-1e-3, -1e-9, 0.0, 1e-9, 1e-3, 2.0, 4.0])
    points = np.column_stack([9.0 * np.cos(angle), 9.0 * np.sin(angle), np.full(7, 2.0)])
    np.testing.assert_allclose(np.abs(tube.distance(points)), 1.0, atol=1e-12)


def test_beyond_its_border_a_surface_goes_on():
    surface = quarter_cylinder()
    angle = np.array([-0.01, np.pi / 2 + 0.01])
    points = np.column_stack([11.0 * np.cos(angle), 11.0 * np.sin(angle), np.full(2, 20.1)])
    np.testing.assert_allclose(surface.distance(points), 1.0, atol=1e-9)


# Within or beyond a face's border: circles, holes, corners.


def polygon(corners, pieces=20):
    """Border arrays of a flat polygon in y = 0, seen from +y with its inside to the left."""
    columns: list[list[np.ndarray]] = [[] for _ in range(6)]
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        share = np.linspace(0, 1, pieces + 1)[:, None]
        places, slope = a + share * (b - a), (b - a) / pieces
        inward = np.cross([0.0, 1.0, 0.0], slope / np.linalg.norm(slope))
        rows = (places[:-1], places[1:], slope, slope, inward, inward)
        for column, values in zip(columns, rows, strict=True):
            column.append(np.broadcast_to(values, (pieces, 3)))
    return tuple(np.concatenate(column) for column in columns)


def circle(radius, pieces, turn=1.0):
    """Border arrays of a circle in y = 0; ``turn`` -1: the face is outside of it."""
    angle = -turn * np.linspace(0, 2 * np.pi, pieces + 1)
    places = radius * np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
    slopes = np.column_stack([-np.sin(angle), 0 * angle, np.cos(angle)])
    slopes *= -turn * radius * 2 * np.pi / pieces
    inward = np.cross([0.0, 1.0, 0.0], slopes / np.linalg.norm(slopes, axis=1)[:, None])
    return places[:-1], places[1:], slopes[:-1], slopes[1:], inward[:-1], inward[1:]


def test_a_notch_reports_inside_at_its_inner_corner():
    notched = np.array([[-1.0, 0, 1], [0, 0, 1], [0, 0, 0], [1, 0, 0], [1, 0, -1], [-1, 0, -1]])
    border = Border(*polygon(notched))
    rng = np.random.default_rng(3)
    x, z = rng.uniform(-1.5, 1.5, (2, 2000))
    inside = (np.abs(x) < 1) & (np.abs(z) < 1) & ~((x > 0) & (z > 0))
    found = border.beyond(np.column_stack([x, 0 * x, z]))
    assert np.array_equal(found == 0.0, inside)
    points = np.array([[-0.99, 0, 0.99], [-1.5, 0, 0.2], [-1.3, 0, 1.4], [-1.0, 0, 0.3]])
    np.testing.assert_allclose(border.beyond(points), [0, 0.5, 0.5, 0], atol=1e-12)


def test_a_ring_of_few_pieces_is_round():
    outer, hole = circle(2.0, 60), circle(1.0, 60, -1.0)
    border = Border(*(np.concatenate(pair) for pair in zip(outer, hole, strict=True)))
    radius = np.array([0.0, 0.999, 1.001, 1.5, 1.999, 2.001, 3.0])
    angle = 0.37 + np.arange(7)
    points = radius[:, None] * np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
    expected = np.maximum(np.maximum(1.0 - radius, radius - 2.0), 0.0)
    np.testing.assert_allclose(border.beyond(points), expected, rtol=1e-4, atol=5e-7)


def test_the_middle_of_a_circle_is_within_and_a_closed_face_has_no_beyond():
    assert Border(*circle(2.0, 60)).beyond(np.zeros((1, 3)))[0] == 0.0
    border = Border(*(np.zeros((0, 3)) for _ in range(6)))
    assert not border.beyond(np.ones((4, 3))).any()


@pytest.mark.parametrize(
    ("keys", "alike", "mirrors"),
    [
        ({"shape": "plane"}, True, True),
        ({"shape": "plane", "tilt_deg": 5.0}, True, True),
        ({"shape": "plane", "tilt_deg": 5.0, "turn_deg": 90.0}, False, False),
        ({"shape": "cylinder", "radius_mm": 5.0}, True, True),
        ({"shape": "cylinder", "radius_mm": 5.0, "turn_deg": 30.0}, False, False),
        ({"shape": "cylinder", "radius_mm": 5.0, "turn_deg": 180.0}, True, True),
        ({"shape": "cylinder", "radius_mm": 5.0, "axis": "x"}, False, True),
        ({"shape": "sphere", "radius_mm": 5.0}, False, True),
    ],
)
def test_which_objects_are_alike_in_every_section_and_which_mirror(keys, alike, mirrors):
    given = SceneObject(**keys)
    assert (given.plane_in_z, given.mirrors_in_z) == (alike, mirrors)
    points = np.random.default_rng(2).uniform(-3.0, 3.0, (50, 3)) - [0.0, 9.0, 0.0]
    here, farther, mirrored = (
        given.made().distance(each)
        for each in (points, points + np.array([0.0, 0.0, 1.0]), points * [1.0, 1.0, -1.0])
    )
    assert np.allclose(here, farther) == alike
    assert np.allclose(here, mirrored) == mirrors


@pytest.mark.parametrize(
    "keys",
    [
        {"shape": "sphere", "radius_mm": 5.0},
        *({"shape": "cylinder", "radius_mm": 5.0, "axis": axis} for axis in "xz"),
        *({"shape": "cylinder", "radius_mm": 5.0, "axis": axis, "turn_deg": 30.0} for axis in "xz"),
    ],
)
def test_the_curvature_is_that_of_the_lower_face(keys):
    given, h = SceneObject(**keys), 0.01
    x, z = h * np.array([[0, 1, -1, 0, 0, 1, -1], [0, 0, 0, 1, -1, 1, -1]])
    o, right, left, front, back, both, neither = given.made().underside(x, z)
    xx, zz = (right + left - 2.0 * o) / h**2, (front + back - 2.0 * o) / h**2
    xz = 0.5 * ((both + neither - 2.0 * o) / h**2 - xx - zz)
    np.testing.assert_allclose(given.curvature(), [[xx, xz], [xz, zz]], atol=1e-5)


def test_a_tilted_plane_turned_by_a_quarter_falls_toward_z():
    made = SceneObject(tilt_deg=5.0, turn_deg=90.0).made()
    fall = made.underside(np.array([0.0, 3.0]), np.array([1.0, 1.0]))
    assert fall == pytest.approx(-np.tan(np.radians(5.0)))


def box_face(name, area, turn, away, sign=1.0):
    start, end, *vectors = polygon(np.array([[-1.0, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]]))
    border = Border(start @ turn + away, end @ turn + away, *(each @ turn for each in vectors))
    outward = np.array([0.0, 1.0, 0.0]) @ turn
    box = {"low": border.start.min(axis=0), "high": border.start.max(axis=0)}
    shape = Plane(sign * outward, sign * float(outward @ away))
    return CadFace(name, shape, sign, border=border, area=area, **box)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearest_face_is_that_as_it_ends_and_at_an_edge_the_one_seen_more_from_outside(order):
    """The top y = 0 and the side x = 1 of a box; of points, their face and both distances."""
    down = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    top = box_face("contact", 4.0, np.eye(3), np.zeros(3))
    side = box_face("side", 5.0, down, np.array([1.0, -1.0, 0.0]), -1.0)
    faces = tuple((top, side)[k] for k in order)
    found = {
        (0.5, -0.2, 0.0): (0, -0.2, 0.2),
        (0.9, -1.0, 0.0): (1, -0.1, 0.1),
        (3.0, 1.0, 0.0): (1, 2.0, 5.0**0.5),
        (0.0, 0.0, 3.0): (0, 0.0, 2.0),
    }
    owner, *distances = (nearest(faces, np.array(list(found)))[k] for k in (0, 1, 3))
    numbers, *wanted = np.array(list(found.values())).T
    assert [order[k] for k in owner] == numbers.tolist()
    np.testing.assert_allclose(distances, wanted, atol=1e-9)
    assert (Smooth.of(faces).name, Smooth.of([side]).name) == ("contact", "side")
    assert not Smooth.of(faces).flat
