"""Quality measures on cells whose values are known, and reports in 2-D and 3-D."""

from __future__ import annotations

import json

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.mesh.extrude import extrude
from fingerdesign.mesh.measures import (
    aspects,
    cell_angles,
    cell_volumes,
    curved_areas,
    edge_lengths,
)
from fingerdesign.mesh.quality import assess
from fingerdesign.mesh.section import mesh_section

TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, np.sqrt(0.75)]])
TETRA = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])


def test_regular_cells() -> None:
    triangle, tetra = np.array([[0, 1, 2]]), np.array([[0, 1, 2, 3]])
    np.testing.assert_allclose(cell_angles(TRIANGLE, triangle), 60.0)
    np.testing.assert_allclose(cell_angles(TETRA, tetra), np.degrees(np.arccos(1 / 3)))
    np.testing.assert_allclose(aspects(TRIANGLE, triangle), 1.0)
    np.testing.assert_allclose(aspects(TETRA, tetra), 1.0)
    np.testing.assert_allclose(edge_lengths(TETRA, tetra), np.sqrt(8.0))
    np.testing.assert_allclose(np.abs(cell_volumes(TETRA, tetra)), 8.0 / 3.0)


def test_a_corner_tetrahedron_has_right_angles() -> None:
    points = np.vstack([np.zeros(3), np.eye(3)])
    angles = np.sort(cell_angles(points, np.array([[0, 1, 2, 3]]))[0])
    np.testing.assert_allclose(angles[3:], 90.0)
    np.testing.assert_allclose(angles[:3], np.degrees(np.arccos(1 / np.sqrt(3))))


def test_a_flat_tetrahedron_has_a_bad_aspect_and_angle() -> None:
    points = np.vstack([np.zeros(3), np.eye(3)])
    points[3] = [0.3, 0.3, 0.01]
    cell = np.array([[0, 1, 2, 3]])
    assert cell_angles(points, cell).min() < 3.0
    assert aspects(points, cell)[0] > 20.0


def test_area_of_a_curved_triangle_converges_to_the_sphere() -> None:
    errors = []
    for size in (0.2, 0.1):
        corners = np.array([[0.0, 0.0, 1.0], [size, 0.0, 1.0], [0.0, size, 1.0]])
        nodes = np.vstack(
            [corners, [0.5 * (corners[i] + corners[j]) for i, j in ((0, 1), (1, 2), (0, 2))]]
        )
        nodes /= np.linalg.norm(nodes, axis=1)[:, None]
        a, b, c = nodes[:3]
        # Solid angle of a triangle (van Oosterom and Strackee 1983).
        exact = 2 * np.arctan2(np.linalg.det([a, b, c]), 1 + a @ b + b @ c + c @ a)
        errors.append(abs(curved_areas(nodes, np.arange(6)[None])[0] / exact - 1))
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 8.0


@pytest.mark.parametrize("plates", [0, 2])
def test_reports_of_a_section_and_of_its_extrusion(plates: int) -> None:
    design = parse_design(
        f"""
        design.name = "t"
        plates.count = {plates}
        plates.pitch_mm = 3.0
        plates.thickness_mm = 0.3
        mesh.layers = 2
        mesh.contact_size_mm = 1.0
        mesh.plate_size_mm = 1.0
        [mesh.section]
        contact_size_mm = 0.5
        plate_size_mm = 0.5
        plate_end_size_mm = 0.2
        far_size_mm = 2.0
        """
    )
    for mesh in (mesh_section(design, 3.0), extrude(design, 3.0)):
        report = assess(mesh, design)
        assert report.dimension == mesh.dimension
        assert report.elements == len(mesh.cells)
        assert report.dofs == mesh.points.size
        assert report.body_volume_error < 1e-2
        assert report.worst_plate_volume_error < 1e-9
        assert report.contact_residual_mm < 1e-9
        assert report.min_dihedral_deg > 1.0
        assert ("plates" in report.regions) == (plates > 0)
        assert json.loads(json.dumps(report.to_dict(), allow_nan=False)) == report.to_dict()
        assert f"{report.elements}" in report.text()


def test_a_hole_shows_in_the_volume_and_a_missing_facet_in_the_area() -> None:
    design = parse_design(
        'design.name = "t"\nplates.count = 0\nmesh.layers = 2\nmesh.contact_size_mm = 1.0'
    )
    mesh = extrude(design, 3.0)
    whole = assess(mesh, design)
    from dataclasses import replace

    holed = replace(mesh, cells=mesh.cells[50:], regions=mesh.regions[50:])
    assert assess(holed, design).body_volume_error > 10 * whole.body_volume_error
    bare = replace(mesh, facets={**mesh.facets, "base": mesh.facets["base"][5:]})
    assert assess(bare, design).worst_face_area_error > 10 * whole.worst_face_area_error
