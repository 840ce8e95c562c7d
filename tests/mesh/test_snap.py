"""Snapping to CAD faces, quadratic facets, Jacobians of curved tetrahedra."""

from __future__ import annotations

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.mesh.boundary import boundary_facets, carriers_of
from fingerdesign.mesh.snap import (
    least_jacobian_ratio,
    quadratic_facets,
    snap_to_carriers,
    tet_volumes,
)
from fingerdesign.mesh.types import quadratic

UNIT = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


def test_nodes_go_to_all_faces_that_they_lie_on() -> None:
    design = parse_design(
        'design.name = "t"\nbody.shape = "dome"\nbody.dome_radius_mm = 12.0\nplates.count = 0'
    )
    carriers = carriers_of(design.body, (), symmetric=True)
    names = [plane.name for plane in carriers.planes] + ["contact"]
    places = {
        ("contact",): [1.0, 12.5, 1.0],
        ("contact", "end"): [2.0, 11.5, 4.99],
        ("contact", "symmetry"): [2.0, 12.5, 0.01],
        ("side", "end", "contact"): [9.99, 8.9, 5.01],
        ("base", "side"): [9.99, 0.02, 2.0],
    }
    points = np.array(list(places.values()))
    lies_on = np.zeros((len(points), len(names)), dtype=bool)
    for row, wanted in enumerate(places):
        for name in wanted:
            numbers = [i for i, known in enumerate(names) if known == name]
            nearest = min(numbers, key=lambda n: abs(carriers.distances(points[[row]], (n,))[0, 0]))
            lies_on[row, nearest] = True
    snapped = snap_to_carriers(points, lies_on, carriers)
    for row in range(len(points)):
        numbers = tuple(int(n) for n in np.flatnonzero(lies_on[row]))
        np.testing.assert_allclose(carriers.distances(snapped[[row]], numbers), 0.0, atol=1e-12)
    assert np.abs(snapped - points).max() < 0.5  # to the near faces, nowhere else


def test_where_a_half_circle_meets_its_sides_height_decides_what_nodes_lie_on() -> None:
    design = parse_design('design.name = "t"\nbody.arc_radius_mm = 10.0\nplates.count = 0')
    carriers = carriers_of(design.body, (), symmetric=True)
    assert carriers.smooth
    points = np.array([[9.995, 9.8, 2.0], [9.975, 10.6, 2.0], [9.98, 10.4, 3.0], [8.0, 10.0, 2.0]])
    found = boundary_facets(points, np.array([[0, 1, 2, 3]]), np.zeros(1, dtype=int), carriers)
    (facet,) = np.flatnonzero((found.corners != 3).all(axis=1))
    assert carriers.name(int(found.carrier[facet])) == "side"  # one corner is below the edge
    lies_on = found.on_carriers(points, carriers)
    names = [plane.name for plane in carriers.planes]
    assert lies_on[:3, carriers.contact_number].tolist() == [False, True, True]
    assert lies_on[0, [i for i, plane in enumerate(carriers.planes) if plane.normal[0] > 0.5]].all()
    assert not lies_on[1:3, [i for i, name in enumerate(names) if name == "side"]].any()
    snapped = snap_to_carriers(points, lies_on, carriers)
    np.testing.assert_allclose(carriers.contact.distance(snapped[1:3]), 0.0, atol=1e-12)
    assert snapped[0, 0] == pytest.approx(10.0)


def test_facets_of_a_cube_are_named_by_the_face_that_carries_them() -> None:
    # One tetrahedron in the corner x = -10, y = 0, z = 0 of a finger's half.
    design = parse_design('design.name = "t"\nplates.count = 0')
    carriers = carriers_of(design.body, (), symmetric=True)
    points = UNIT + np.array([-10.0, 0.0, 0.0])
    found = boundary_facets(points, np.array([[0, 1, 2, 3]]), np.zeros(1, dtype=int), carriers)
    names = {
        carriers.name(int(number)): misfit
        for number, misfit in zip(found.carrier, found.misfit, strict=True)
        if misfit < 1e-12
    }
    assert set(names) == {"base", "side", "symmetry"}
    a, b, c = (points[found.corners[:, i]] for i in range(3))
    centre = points.mean(axis=0)
    assert np.all(np.einsum("ij,ij->i", np.cross(b - a, c - a), a - centre) > 0.0)


def test_quadratic_facets_find_the_mid_nodes() -> None:
    nodes, cells = quadratic(UNIT, np.array([[0, 1, 2, 3]]))
    facets = quadratic_facets(cells, np.array([[3, 1, 2]]), len(nodes))
    np.testing.assert_allclose(nodes[facets[0, 3]], 0.5 * (UNIT[3] + UNIT[1]))
    np.testing.assert_allclose(nodes[facets[0, 4]], 0.5 * (UNIT[1] + UNIT[2]))
    np.testing.assert_allclose(nodes[facets[0, 5]], 0.5 * (UNIT[3] + UNIT[2]))


def test_jacobian_ratio_is_1_straight_and_negative_inverted() -> None:
    nodes, cells = quadratic(UNIT, np.array([[0, 1, 2, 3]]))
    assert least_jacobian_ratio(nodes, cells)[0] == pytest.approx(1.0)
    bent = nodes.copy()
    bent[cells[0, 4]] += [0.0, 0.6, 0.0]  # the middle of edge 0-1, pushed far across
    assert least_jacobian_ratio(bent, cells)[0] < 0.0
    assert tet_volumes(UNIT, np.array([[0, 1, 2, 3], [0, 2, 1, 3]])) == pytest.approx(
        [1 / 6, -1 / 6]
    )
