"""Meshes made elsewhere: read by their names, checked, and put on the design's faces."""

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations

import meshio
import numpy as np
import pytest

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.stages import make_mesh, zone_of
from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.design.io import parse_scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, MeshError
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.files.imported import import_words, imported_mesh, oriented
from fingerdesign.mesh.files.io import write_mesh
from fingerdesign.mesh.files.named import NamedMesh
from fingerdesign.mesh.quality import assess
from fingerdesign.mesh.quality_text import quality_text
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.types import in_tetrahedra
from fingerdesign.pipeline import analyse
from tests.support.fingers import SMALL

Write = Callable[..., Design]


@pytest.fixture(scope="module")
def made():
    return in_tetrahedra(extrude(parse_design(SMALL), Zone(3.0)))


def linear(mesh, path, regions, facets):
    """Write the mesh's straight cells as others would: groups of their own numbers and order."""
    corners = np.unique(mesh.corners)
    number = np.full(len(mesh.points), -1)
    number[corners] = np.arange(len(corners))
    tets = number[mesh.corners][:, [0, 2, 1, 3]]  # turned over, all of them
    groups = {name: np.array([50 + k, 3]) for k, name in enumerate(regions.values())}
    names = [regions[int(region)] for region in mesh.regions]
    cells, physical = [("tetra", tets)], [np.array([groups[name][0] for name in names])]
    for k, (name, written) in enumerate(facets.items()):
        groups[written] = np.array([70 + k, 2])
        cells.append(("triangle", number[mesh.facets[name][:, :3]]))
        physical.append(np.full(len(mesh.facets[name]), 70 + k))
    points = np.vstack([mesh.points[corners], [[99.0, 99.0, 99.0]]])  # a node of no cell
    data = {"gmsh:physical": physical, "gmsh:geometrical": physical}
    meshio.Mesh(points, cells, cell_data=data, field_data=groups).write(path, "gmsh22")


REGIONS = {0: "elastomer", 1: "plate_0", 2: "plate_1"}
FACETS = {"base": "base", "contact": "contact"}


def test_a_turned_cell_has_its_mid_nodes_between_its_corners(tmp_path):
    corners = np.vstack([np.zeros(3), np.eye(3)])
    edges = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
    right = np.vstack([corners, [corners[[*edge]].mean(axis=0) for edge in edges]])
    over = corners[[1, 0, 2, 3]]
    wrong = np.vstack([over, [over[[*edge]].mean(axis=0) for edge in edges]]) + 5.0
    given = NamedMesh(
        np.vstack([right, wrong]), np.arange(20).reshape(2, 10), np.array(["", ""]), {}
    )
    found = oriented(given, tmp_path)
    assert found.cells[0].tolist() == list(range(10))
    places = found.points[found.cells[1]]
    assert np.linalg.det(places[1:4] - places[0]) > 0.0
    assert places[4:] == pytest.approx(np.array([places[[*edge]].mean(axis=0) for edge in edges]))


def of_file(path, **values):
    own = {"mesh.mesher": "file", "mesh.file": str(path), **values}
    return with_values(parse_design(SMALL), own)


@pytest.mark.parametrize("ending", ["msh", "vtu", "inp"])
def test_our_own_mesh_comes_back(made, ending, tmp_path):
    again = imported_mesh(of_file(write_mesh(made, tmp_path / f"m.{ending}")))
    np.testing.assert_allclose(again.points, made.points, atol=1e-9)
    for name in ("cells", "regions"):
        np.testing.assert_array_equal(getattr(again, name), getattr(made, name))
    assert again.symmetric
    for name, rows in made.facets.items():
        own, old = (np.sort(each, axis=1) for each in (again.facets[name], rows))
        np.testing.assert_array_equal(own[np.lexsort(own.T)], old[np.lexsort(old.T)])


def test_linear_cells_become_quadratic_on_the_surface(made, tmp_path):
    linear(made, tmp_path / "m.msh", REGIONS, FACETS)
    design = of_file(tmp_path / "m.msh")
    mesh = imported_mesh(design)
    report = assess(mesh, design)
    assert set(mesh.facets) == {"base", "contact", "side", "end", "symmetry"}
    assert mesh.cells.shape[1] == 10
    assert report.body_volume_error < 1e-6 < report.body_volume_error_straight
    assert report.contact_residual_mm < 1e-9
    assert report.worst_plate_volume_error < 1e-9
    assert report.inverted_elements == 0
    assert report.worst_face_area_error < 1e-6
    assert mesh.notes["far_facets"] == 0
    assert "read from m.msh, its nodes put on the design's faces" in quality_text(report)


def test_nodes_near_the_designs_faces_are_put_on_them_and_far_ones_stay(made, tmp_path):
    scaled = made.points * [1.0003, 0.9998, 1.0002]
    assert assess(replace(made, points=scaled), parse_design(SMALL)).contact_residual_mm > 1e-4
    wavy = made.points.copy()
    wavy[:, 2] += 0.03 * wavy[:, 2] * np.sin(9.0 * wavy[:, 0])  # at the free end
    for points, far in ((scaled, False), (wavy, True)):
        own = of_file(write_mesh(replace(made, points=points), tmp_path / "m.msh"))
        mesh = imported_mesh(own)
        report = assess(mesh, own)
        assert (int(mesh.notes["far_facets"]) > 10) == far
        assert ("stayed there" in " ".join(import_words(mesh))) == far
        assert (report.surface_distance_mm["end"] > 0.1) == far
        assert report.contact_residual_mm < 1e-9
        assert report.inverted_elements == 0


def test_slots_of_sheets_come_back_and_must_have_names(tmp_path):
    sheets = parse_design(SMALL + 'plates.model = "sheet"\n')
    made = in_tetrahedra(extrude(sheets, Zone(3.0)))
    own = with_values(
        sheets, {"mesh.mesher": "file", "mesh.file": str(write_mesh(made, tmp_path / "m.msh"))}
    )
    mesh = imported_mesh(own)
    np.testing.assert_allclose(mesh.points, made.points, atol=1e-9)
    assert set(mesh.facets) == set(made.facets)
    bare = {name: rows for name, rows in made.facets.items() if name != "plate_1_end"}
    write_mesh(replace(made, facets=bare), tmp_path / "m.msh")
    with pytest.raises(MeshError, match=r"no boundary named 'plate_1_end' \(1 of 6 lack\)"):
        imported_mesh(own)


@pytest.mark.slow
def test_the_answer_is_that_of_the_same_mesh(tmp_path):
    design, scene = parse_design(SMALL), parse_scene("path.increments_mm = [[0.2, 0.05]]")
    mesh = in_tetrahedra(make_mesh(design, "3d", zone_of(Case(design, scene), scene), True))
    first, again = (
        analyse(of_file(write_mesh(mesh, tmp_path / f"m.{ending}")), scene)
        for ending in ("vtu", "inp")
    )
    for old, new in zip(first.increments, again.increments, strict=True):
        assert new.normal_force_N == pytest.approx(old.normal_force_N, rel=1e-9)
        readings = [[gage.reading for gage in each.gages] for each in (new, old)]
        np.testing.assert_allclose(*readings, rtol=1e-6)
    assert any("m.inp" in reason for reason in again.model.reasons)
    assert again.mesh.mesher == "file"


def test_half_and_whole(made, tmp_path):
    half = of_file(write_mesh(made, tmp_path / "half.msh"))
    with pytest.raises(MeshError, match="holds the half z >= 0"):
        imported_mesh(half, symmetric=False)
    both = in_tetrahedra(extrude(parse_design(SMALL), Zone(3.0), symmetric=False))
    mesh = imported_mesh(of_file(write_mesh(both, tmp_path / "whole.msh")), symmetric=True)
    assert not mesh.symmetric
    assert "symmetry" not in mesh.facets


@pytest.mark.parametrize(
    ("regions", "facets", "values", "words"),
    [
        ({**REGIONS, 2: "Plate2"}, FACETS, {}, "lacks plate_1 and has plate2"),
        ({0: "elastomer", 1: "plate_1", 2: "plate_0"}, FACETS, {}, "only 0% of plate_0"),
        (REGIONS, {"base": "base"}, {}, r"no boundary named 'contact' \(found: base\)"),
        (REGIONS, {"base": "base", "end": "contact"}, {}, "'contact' in m.msh lie up to"),
        (REGIONS, {}, {}, r"no boundary named 'base' \(found: none\)"),
        # A mesh of another design.
        (REGIONS, FACETS, {"plates.count": 3, "plates.pitch_mm": 2.0}, "lacks plate_2"),
        (REGIONS, FACETS, {"plates.count": 0}, "has plate_0, plate_1, which the design has not"),
        (REGIONS, FACETS, {"body.base_height_mm": 5.3}, "elastomer .* is it in mm"),
        (REGIONS, FACETS, {"plates.length_mm": 2.2}, "plate_0 .* of .* mm.3"),
        (REGIONS, FACETS, {"plates.offset_mm": 0.5}, "of plate_0 in m.msh lie where"),
    ],
)
def test_wrong_names_and_places_are_reported(regions, facets, values, words, made, tmp_path):
    linear(made, tmp_path / "m.msh", regions, facets)
    with pytest.raises(MeshError, match=words):
        imported_mesh(of_file(tmp_path / "m.msh", **values))


def broken(made):
    """What may be wrong with a mesh, by the words that say so."""

    def fewer(name):
        rows = made.facets[name]
        return {"facets": made.facets | {name: rows[: -(len(rows) // 3)]}}

    nodes, apart = len(made.points), made.cells.copy()
    apart[made.regions == 1] += nodes  # the plate has nodes of its own
    flat = made.points.copy()
    flat[made.cells[0, 3]] = flat[made.cells[0, :3]].mean(axis=0)
    outer = {tuple(sorted(row[:3])) for rows in made.facets.values() for row in rows.tolist()}
    within = next(c for c in made.cells.tolist() if tuple(sorted(c[:3])) not in outer)
    added = np.array([[within[k] for k in (0, 1, 2, 4, 5, 6)]])
    same = np.vstack([made.points] * 2)
    whole = [
        k
        for k, cell in enumerate(made.corners.tolist())
        if not outer & set(combinations(sorted(cell), 3)) and made.regions[k] == 0
    ]
    away = made.points[made.corners[whole]].mean(axis=1) - [4.5, 2.5, 1.5]
    kept = np.arange(len(made.cells)) != whole[int(np.linalg.norm(away, axis=1).argmin())]
    near = same + 1e-5 * (np.arange(2 * nodes) >= nodes)[:, None] * [1.0, 1.0, 0.0]
    twice = np.append(np.arange(len(made.cells)), 0)
    base, contact = made.facets["base"], made.facets["contact"]
    return {
        "nodes where another one lies": {"points": same, "cells": apart},
        "without a volume": {"points": flat},
        "falls into 2 pieces that share no facet": {"points": near, "cells": apart},
        "more than two tetrahedra": {"cells": made.cells[twice], "regions": made.regions[twice]},
        "belong to another boundary too": {"facets": made.facets | {"base": contact}},
        "mesh's outside": {"facets": made.facets | {"base": np.vstack([added, base])}},
        r"'base' in m.msh has .* mm.2 where small has": fewer("base"),
        r"'contact' in m.msh has .* mm.2 where small has": fewer("contact"),
        "cells lack": {"cells": made.cells[kept], "regions": made.regions[kept]},
    }


def test_unsound_meshes_are_reported(made, tmp_path):
    for words, changes in broken(made).items():
        path = write_mesh(replace(made, **changes), tmp_path / "m.msh")
        with pytest.raises(MeshError, match=words):
            imported_mesh(of_file(path))


def test_files_are_judged_by_their_content_and_named_where_they_are_read(made, tmp_path):
    first, second = tmp_path / "a.vtk", tmp_path / "b.vtk"
    write_mesh(made, first)
    second.write_bytes(first.read_bytes())
    assert of_file(first).digest() == of_file(second).digest()
    second.write_bytes(first.read_bytes() + b"\n")
    assert of_file(first).digest() != of_file(second).digest()
    second.write_text("this is no mesh\n")
    with pytest.raises(MeshError, match="could not read"):
        imported_mesh(of_file(second))
    with pytest.raises(DesignError, match=r"mesh\.file"):
        imported_mesh(of_file(tmp_path / "missing.msh"))
    with first.open("r+b") as file:
        file.truncate(2_000_000_000)  # sparse: it takes no room
    with pytest.raises(DesignError, match="at most 1 GB"):
        of_file(first)
    for line in ('mesh.mesher = "file"', 'mesh.file = "m.msh"'):
        with pytest.raises(DesignError, match=r"mesh\.file = "):
            parse_design(f'design.name = "t"\n{line}')
