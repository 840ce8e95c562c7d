"""Within or beyond a face's border: squares, circles, holes, corners."""

import numpy as np

from fingerdesign.shapes.faces import Border


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


SQUARE = np.array([[-1.0, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]])


def test_a_square_within_beside_and_off_its_corners():
    border = Border(*polygon(SQUARE))
    points = np.array([[0, 0, 0], [0.99, 0, 0.99], [1.5, 0, 0.2], [1.3, 0, 1.4], [1.0, 0, 0.3]])
    np.testing.assert_allclose(border.beyond(points), [0, 0, 0.5, 0.5, 0], atol=1e-12)


def test_a_notch_reports_inside_at_its_inner_corner():
    notched = np.array([[-1.0, 0, 1], [0, 0, 1], [0, 0, 0], [1, 0, 0], [1, 0, -1], [-1, 0, -1]])
    border = Border(*polygon(notched))
    rng = np.random.default_rng(3)
    x, z = rng.uniform(-1.5, 1.5, (2, 2000))
    inside = (np.abs(x) < 1) & (np.abs(z) < 1) & ~((x > 0) & (z > 0))
    found = border.beyond(np.column_stack([x, 0 * x, z]))
    assert np.array_equal(found == 0.0, inside)


def test_a_ring_of_few_pieces_is_round():
    outer, hole = circle(2.0, 60), circle(1.0, 60, -1.0)
    border = Border(*(np.concatenate(pair) for pair in zip(outer, hole, strict=True)))
    radius = np.array([0.0, 0.999, 1.001, 1.5, 1.999, 2.001, 3.0])
    angle = 0.37 + np.arange(7)
    points = radius[:, None] * np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
    expected = np.maximum(np.maximum(1.0 - radius, radius - 2.0), 0.0)
    np.testing.assert_allclose(border.beyond(points), expected, rtol=1e-4, atol=5e-7)


def test_the_middle_of_a_circle_is_within_though_no_border_point_is_nearest():
    assert Border(*circle(2.0, 60)).beyond(np.zeros((1, 3)))[0] == 0.0


def test_a_closed_face_has_no_beyond():
    border = Border(*(np.zeros((0, 3)) for _ in range(6)))
    assert not border.beyond(np.ones((4, 3))).any()
