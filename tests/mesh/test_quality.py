"""Quality measures on cells whose values are known, and reports in 2-D and 3-D."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cells import PRISM, SQUARE, quadratic
from fingerdesign.mesh.measures import (
    aspects,
    cell_angles,
    cell_volumes,
    curved_areas,
    curved_cells,
    curved_volumes,
    edge_lengths,
    least_jacobian_ratios,
)
from fingerdesign.mesh.quality import assess
from fingerdesign.mesh.quality_text import quality_text
from fingerdesign.mesh.requested import requested_sizes
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from tests.support.fingers import CORE, SMALL

TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, np.sqrt(0.75)]])
TETRA = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])


def test_regular_cells():
    triangle, tetra = np.array([[0, 1, 2]]), np.array([[0, 1, 2, 3]])
    np.testing.assert_allclose(cell_angles(TRIANGLE, triangle), 60.0)
    np.testing.assert_allclose(cell_angles(TETRA, tetra), np.degrees(np.arccos(1 / 3)))
    np.testing.assert_allclose(aspects(TRIANGLE, triangle), 1.0)
    np.testing.assert_allclose(aspects(TETRA, tetra), 1.0)
    np.testing.assert_allclose(edge_lengths(TETRA, tetra), np.sqrt(8.0))
    np.testing.assert_allclose(np.abs(cell_volumes(TETRA, tetra)), 8.0 / 3.0)
    angles = np.sort(cell_angles(np.vstack([np.zeros(3), np.eye(3)]), tetra)[0])
    np.testing.assert_allclose(angles, [*[np.degrees(np.arccos(1 / np.sqrt(3)))] * 3, *[90.0] * 3])


def test_regular_prisms():
    both = np.vstack([np.column_stack([TRIANGLE, np.full(3, z)]) for z in (0.0, 1.0)])
    corners = np.arange(6)[None]
    assert sorted(cell_angles(both, corners)[0]) == pytest.approx([60.0] * 3 + [90.0] * 6)
    assert aspects(both, corners) == pytest.approx([1.0])
    assert edge_lengths(both, corners) == pytest.approx(np.ones((1, 9)))
    nodes, cells = quadratic(both, corners, PRISM)
    nodes[[6, 9, 15], 0] += 0.1  # the middles of the edges along x, and of the face between
    assert least_jacobian_ratios(nodes, cells) == pytest.approx([0.6])
    leaning = both + [0.0, 1.0, 0.0] * both[:, 2:]
    assert cell_angles(leaning, corners)[0, [0, 3]] == pytest.approx([45.0, 135.0])
    nodes, cells = quadratic(both + [0.0, 0.0, 1.0] * both[:, :1] * both[:, 2:], corners, PRISM)
    nodes[15:] = nodes[np.array(PRISM.squares)].mean(axis=1)  # higher at one side, else straight
    assert curved_cells(nodes, cells).all()


def test_area_of_a_curved_triangle_converges_to_the_sphere():
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


def test_volumes_of_curved_cells_are_exact():
    """x + a x^2 in each direction: the integral of (1 + 2 a x)(1 + 2 b y)(1 + 2 c z)."""
    nodes, cells = quadratic(np.vstack([np.zeros(3), np.eye(3)]), np.arange(4)[None])
    a, b, c = bends = np.array([0.3, -0.2, 0.4])
    wanted = 1 / 6 + (a + b + c) / 12 + (a * b + b * c + c * a) / 30 + a * b * c / 90
    np.testing.assert_allclose(curved_volumes(nodes + bends * nodes**2, cells), [wanted])
    np.testing.assert_allclose(curved_volumes(nodes, cells), [1 / 6], rtol=1e-14)
    nodes, cells = quadratic(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), np.arange(3)[None])
    nodes[4] += 0.1  # under the parabola: 2/3 of the sagitta times the chord
    expected = 0.5 + 2 / 3 * 0.1 * np.sqrt(2) * np.sqrt(2)
    np.testing.assert_allclose(curved_volumes(nodes, cells), [expected])


def test_folded_cells_have_a_jacobian_below_zero():
    for dimension in (2, 3):
        corners = np.vstack([np.zeros(dimension), np.eye(dimension)])
        nodes, cells = quadratic(corners, np.arange(dimension + 1)[None])
        assert least_jacobian_ratios(nodes, cells)[0] == 1.0
        first = cells[0, dimension + 1]  # in the middle of the edge along x: (1/2, 0)
        for shift, least in ((0.1, 0.6), (0.3, -0.2)):  # at the corner 1 - 4 shift
            moved = nodes.copy()
            moved[first, 0] += shift
            np.testing.assert_allclose(least_jacobian_ratios(moved, cells), [least])


DESIGN = with_values(parse_design(SMALL), CORE)


@pytest.fixture(scope="module")
def cored():
    return extrude(DESIGN, Zone(3.0))


def test_every_region_and_face_is_held_against_the_design(cored):
    report = assess(cored, DESIGN)
    assert set(report.volumes) == {"elastomer", "plate_0", "plate_1", "core"}
    assert report.volumes["core"]["target"] == 27.0  # half of the depth
    for values in report.volumes.values():
        assert values["error"] < 1e-6
    faces = {"base", "contact", "side", "end", "symmetry", "plate_0", "plate_1", "core"}
    assert set(report.surface_distance_mm) == faces
    assert max(report.surface_distance_mm.values()) < 1e-9
    assert (report.modelled, report.attempts) == ("half z >= 0", None)
    for mesh in (mesh_section(DESIGN, 3.0), cored):
        report = assess(mesh, DESIGN, requested_sizes(DESIGN, mesh, Zone(3.0)))
        assert (report.dimension, report.elements) == (mesh.dimension, len(mesh.cells))
        assert report.dofs == mesh.points.size
        assert report.worst_plate_volume_error < 1e-9
        assert report.min_dihedral_deg > 1.0
        assert json.loads(json.dumps(asdict(report), allow_nan=False)) == asdict(report)
    notes = {"attempts": 2, "failed_attempts": "attempt 1 (whole): fTetWild gave up"}
    again = assess(replace(cored, symmetric=False, notes=notes), DESIGN)
    assert (again.modelled, again.attempts) == ("whole", 2)
    assert "fTetWild gave up" in quality_text(again)


def test_holes_missing_facets_and_turned_cells_are_found(cored):
    holed = replace(cored, cells=cored.cells[50:], regions=cored.regions[50:])
    assert assess(holed, DESIGN).body_volume_error > 1e-4
    bare = replace(cored, facets={**cored.facets, "base": cored.facets["base"][5:]})
    assert assess(bare, DESIGN).worst_face_area_error > 1e-3
    cells = cored.cells.copy()
    cells[7] = cells[7, [0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13, 17, 16, 15]]
    report = assess(replace(cored, cells=cells), DESIGN)
    assert report.inverted_elements == 1
    least = [row["min_dihedral_deg"] for row in report.worst]
    assert least == sorted(least)
    assert least[0] == report.min_dihedral_deg
    assert sum(report.dihedral_histogram["counts"]) == 9 * report.elements


@pytest.mark.parametrize("name", ["base", "contact", "side", "end", "symmetry"])
def test_a_mid_node_off_its_face_is_found(name, cored):
    points = cored.points.copy()
    points[cored.facets[name][3, 4]] -= 0.01
    away = assess(replace(cored, points=points), DESIGN).surface_distance_mm
    assert 0.004 < away[name] < 0.02


def test_a_plate_or_core_of_another_shape_is_found(cored):
    for region, name in ((1, "plate_0"), (DESIGN.core_region, "core")):
        nodes = np.unique(cored.cells[cored.regions == region])
        points = cored.points.copy()
        points[nodes] += [0.02, 0.0, 0.0]
        report = assess(replace(cored, points=points), DESIGN)
        np.testing.assert_allclose(report.surface_distance_mm[name], 0.02, rtol=0.3)
    regions = np.where(cored.regions == 1, 0, cored.regions)
    report = assess(replace(cored, regions=regions), DESIGN)
    assert report.worst_plate_volume_error == 1.0
    assert report.volumes["plate_0"]["volume"] == 0.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_sizes_are_those_requested_and_coarser_ones_show(dimension, cored):
    mesh = mesh_section(DESIGN, 3.0) if dimension == 2 else cored
    requested = requested_sizes(DESIGN, mesh, Zone(3.0))
    ratio = assess(mesh, DESIGN, requested).size_ratio
    assert set(ratio) == {"contact", "plates", "core", "rest"}
    for values in ratio.values():
        assert 0.3 < values["mean"] < 1.6
        assert values["p5"] <= values["mean"] <= values["p95"]
    keys = {"mesh.contact_size_mm": 0.25, "mesh.section.contact_size_mm": 0.025}
    finer = with_values(DESIGN, keys)
    again = assess(mesh, finer, requested_sizes(finer, mesh, Zone(3.0))).size_ratio
    assert again["contact"]["mean"] > 1.3 * ratio["contact"]["mean"]


def test_sizes_that_are_not_those_of_the_keys_are_explained(cored):
    mesh = replace(cored, mesher="tetwild")
    requested = requested_sizes(DESIGN, mesh, Zone(2.5))
    first, *_ = requested.reasons
    assert first.startswith("at the contact 0.5 mm, not mesh.contact_size_mm = 1")
    assert first in quality_text(assess(mesh, DESIGN, requested))
    assert len(requested.reasons) == 3  # longer along z, plates' ends
    assert len(requested_sizes(DESIGN, mesh, Zone(9.0)).reasons) == 2
    bare = with_values(DESIGN, {"plates.count": 0})
    assert not any("plates" in reason for reason in requested_sizes(bare, mesh, Zone(2.5)).reasons)


def test_each_part_of_a_report_is_of_its_own_cells(cored):
    report = assess(cored, DESIGN)
    points, corners = cored.points, cored.corners
    for name, rows in cored.parts.items():
        edges, volumes = edge_lengths(points, corners[rows]), cell_volumes(points, corners[rows])
        found = report.regions[name]
        assert [found[f"edge_{part}_mm"] for part in ("min", "mean", "max")] == pytest.approx(
            [edges.min(), edges.mean(), edges.max()]
        )
        assert found["min_dihedral_deg"] == cell_angles(points, corners[rows]).min()
        assert found["max_aspect"] == aspects(points, corners[rows]).max()
        assert (found["elements"], found["volume"]) == (rows.sum(), pytest.approx(volumes.sum()))
    least, aspect = cell_angles(points, corners).min(axis=1), aspects(points, corners)
    ends = [report.dihedral_percentiles_deg, report.aspect_percentiles]
    for values, found in zip((least, aspect), ends, strict=True):
        assert list(found.values()) == [np.percentile(values, int(key)) for key in found]
    contact = edge_lengths(points, cored.facets["contact"][:, :4], SQUARE)
    assert report.contact_edge_mm == {"mean": contact.mean(), "max": contact.max()}
