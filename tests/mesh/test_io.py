"""Meshes through files and back: points, quadratic cells, regions and facet names."""

from dataclasses import fields, replace

import meshio
import numpy as np
import pytest

from fingerdesign import parse_design, with_values
from fingerdesign.errors import MeshError
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cache import load_mesh, mesh_key, store_mesh
from fingerdesign.mesh.cells import with_mid_nodes
from fingerdesign.mesh.files.calculix import cell_faces
from fingerdesign.mesh.files.io import read_named, to_meshio, write_mesh
from fingerdesign.mesh.section.extrude import extrude
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.sizing import MeshSizes
from fingerdesign.mesh.types import in_tetrahedra
from tests.support.fingers import CORE, SMALL

DESIGN = with_values(
    parse_design(SMALL),
    CORE
    | {"mesh.section.contact_size_mm": 1.0, "mesh.section.plate_size_mm": 0.5}
    | {"mesh.section.plate_end_size_mm": 0.3, "mesh.section.far_size_mm": 2.0},
)


@pytest.fixture(scope="module", params=[2, 3])
def mesh(request):
    return mesh_section(DESIGN, 3.0) if request.param == 2 else extrude(DESIGN, Zone(3.0))


@pytest.mark.parametrize("ending", ["vtu", "msh", "vtk", "inp"])
@pytest.mark.parametrize("kind", ["section", "solid", "sheet"])
def test_round_trip(kind, ending, tmp_path):
    """Points, cells and facets, and the names of core, plates and the slots of sheets."""
    design = with_values(DESIGN, {"plates.model": "sheet" if kind == "sheet" else "solid"})
    mesh = mesh_section(design, 3.0) if kind == "section" else extrude(design, Zone(3.0))
    again = read_named(write_mesh(mesh, tmp_path / f"finger.{ending}"))
    mesh = in_tetrahedra(mesh)  # so prisms are read
    np.testing.assert_allclose(again.points, mesh.points, atol=1e-12)
    np.testing.assert_array_equal(again.cells, mesh.cells)
    names = [mesh.region_name(int(number)) for number in mesh.regions]
    np.testing.assert_array_equal(again.region, names)
    assert set(again.facets) == set(mesh.facets)
    for name, facets in mesh.facets.items():
        found, corners = with_mid_nodes(again.cells, again.facets[name], name), facets
        if ending == "inp":  # faces are said by their element: corners in its order
            found, corners = np.sort(found, axis=1), np.sort(facets, axis=1)
        np.testing.assert_array_equal(found, corners)
    assert again.dimension == mesh.dimension


def test_the_order_of_mid_nodes_is_meshios(mesh):
    block = to_meshio(mesh).cells[0]
    assert block.type == {2: "triangle6", 3: "wedge18"}[mesh.dimension]
    kind, cells = mesh.kind, block.data[mesh.regions == 1]  # straight-sided
    for middle, ends in enumerate((*kind.edges, *kind.squares), start=kind.corners):
        halfway = mesh.points[cells[:, ends]].mean(axis=1)
        np.testing.assert_allclose(mesh.points[cells[:, middle]], halfway, atol=1e-12)


def test_gmsh_files_name_their_physical_groups(mesh, tmp_path):
    found = meshio.read(write_mesh(mesh, tmp_path / "finger.msh"))
    assert {"base", "contact", "elastomer", "plate_0"} <= set(found.field_data)
    assert list(found.field_data["contact"]) == [2, mesh.dimension - 1]


def test_unknown_formats_are_refused(mesh, tmp_path):
    with pytest.raises(MeshError, match="could not write"):
        write_mesh(mesh, tmp_path / "finger.unknown")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(MeshError, match="could not read"):
        read_named(tmp_path / "missing.vtu")
    with pytest.raises(MeshError, match="plate_1_inside"):
        to_meshio(replace(mesh, facets={"plate_1_inside": mesh.facets["base"]}))


def test_calculix_has_a_set_and_a_surface_for_each_name(mesh, tmp_path):
    text = write_mesh(mesh, tmp_path / "m.inp").read_text()
    kind = "C3D10" if mesh.dimension == 3 else "CPE6"
    assert f"*ELEMENT, TYPE={kind}, ELSET=plate_0\n" in text
    for name, facets in mesh.facets.items():
        nodes = text.partition(f"*NSET, NSET={name}\n")[2].partition("*")[0]
        numbers = [int(part) for part in nodes.replace("\n", "").split(",")[:-1]]
        np.testing.assert_array_equal(np.array(numbers) - 1, np.unique(facets))
        assert f"*SURFACE, NAME={name}, TYPE=ELEMENT\n" in text
    assert max(len(line) for line in text.splitlines()) < 256


def test_calculix_numbers_have_at_most_twenty_characters(mesh, tmp_path):
    points = mesh.points.copy()
    points[:3, 0] = [-8.881784197001252e-16, -1.2345678901234567e-05, 1.2345678901234567e100]
    path = write_mesh(replace(mesh, points=points), tmp_path / "m.inp")
    lines = path.read_text().split("*ELEMENT")[0].splitlines()[2:]
    assert max(len(part.strip()) for line in lines for part in line.split(",")) <= 20
    np.testing.assert_allclose(read_named(path).points, points, rtol=1e-13)


def test_faces_are_numbered_as_calculix_does(mesh):
    # CalculiX: C3D10 S1 1-2-3, S2 1-4-2, S3 2-4-3, S4 3-4-1; CPE6 S1 1-2, S2 2-3, S3 3-1.
    mesh = in_tetrahedra(mesh)
    solid = ({1, 2, 3}, {1, 4, 2}, {2, 4, 3}, {3, 4, 1})
    faces = solid if mesh.dimension == 3 else ({1, 2}, {2, 3}, {3, 1})
    cells, numbers = cell_faces(mesh, mesh.facets["contact"])
    for row, cell, number in zip(mesh.facets["contact"], cells, numbers, strict=True):
        corners = {
            int(np.flatnonzero(mesh.cells[cell] == node)[0]) + 1 for node in row[: mesh.dimension]
        }
        assert corners == faces[number]
    with pytest.raises(MeshError, match="no faces of any cell"):
        cell_faces(mesh, np.array([[0, 0, 0]]))


DECK = """** made by hand
*Heading
a tetrahedron and its mirror image
*NODE
10, 0., 0., 0.
20, 1., 0., 0.
30, 0., 1., 0.
40, 0., 0., 1.
50, 0., 0., -1.
*ELEMENT, TYPE=C3D4
7, 10, 20, 30,
40
8, 10, 30, 20, 50
*ELSET, ELSET=Elastomer, GENERATE
7, 8, 1
*ELSET, ELSET=all
Elastomer, 7
*Surface, Name=CONTACT
7, S3
*NSET, NSET=base
10, 20, 40
*MATERIAL, NAME=x
"""


def test_a_deck_made_by_hand_is_read(tmp_path):
    path = tmp_path / "hand.inp"
    path.write_text(DECK)
    found = read_named(path)
    assert found.region.tolist() == ["elastomer", "elastomer"]
    assert found.cells.tolist() == [[0, 1, 2, 3], [0, 2, 1, 4]]
    assert {name: np.sort(rows).tolist() for name, rows in found.facets.items()} == {
        "contact": [[1, 2, 3]],
        "base": [[0, 1, 3]],
    }


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("C3D4", "C3D8", "C3D8 are no tetrahedra"),
        ("7, 10, 20", "7, 11, 20", "node 11 is not defined"),
        ("1., 0., 0.", "one, 0., 0.", "not the numbers"),
        ("*ELEMENT, TYPE=C3D4", "*ELEMENTS", "no tetrahedra or triangles"),
        ("Elastomer, 7", "elastomers, 7", "elastomers"),
    ],
)
def test_decks_that_cannot_be_understood(old, new, words, tmp_path):
    path = tmp_path / "hand.inp"
    assert old in DECK
    path.write_text(DECK.replace(old, new))
    with pytest.raises(MeshError, match=words):
        read_named(path)


def test_cells_that_are_no_simplices_or_of_two_orders_are_refused(tmp_path):
    points = np.random.default_rng(3).random((18, 3))
    tet, whole = np.arange(4)[None], np.arange(10)[None]
    for cells, words in (
        ([("tetra", tet), ("hexahedron", np.arange(8)[None])], "hexahedron"),
        ([("tetra", tet), ("tetra10", whole + 4)], "of one order"),
        ([("line", np.array([[0, 1]]))], "no quadratic cells"),
    ):
        meshio.Mesh(points, cells).write(tmp_path / "m.vtu")
        with pytest.raises(MeshError, match=words):
            read_named(tmp_path / "m.vtu")


# Kept meshes, and files under a kept mesh's name that are no mesh: nothing crashes.


@pytest.fixture
def folder(tmp_path, own_cache):
    return tmp_path / "meshes"


def key_of(zone=None, symmetric=True, **changes):
    """The key of a kept mesh of DESIGN with some values changed."""
    design, zone = with_values(DESIGN, changes), zone or Zone(3.0, 2.0, 1.0)
    return mesh_key(design, MeshSizes.of(design, zone), zone, symmetric)


def test_a_mesh_is_kept_for_its_geometry_sizes_zone_and_half():
    same = key_of()
    for zone in (Zone(3.1, 2.0, 1.0), Zone(3.0, 2.1, 1.0), Zone(3.0, 2.0, 1.1), Zone(3.0)):
        assert key_of(zone) != same
    assert key_of(symmetric=False) != same
    geometry = {"plates.angle_deg": 40.0, "body.core.height_mm": 1.4, "body.width_mm": 21.0}
    sizes = {"mesh.contact_size_mm": 1.4, "mesh.far_size_mm": 2.5, "plates.model": "sheet"}
    for name, value in (geometry | sizes).items():
        assert key_of(**{name: value}) != same, name
    assert key_of(**{"body.material": "silicone", "body.core.material": "pla"}) == same


@pytest.mark.parametrize("field", [each.name for each in fields(MeshSizes)])
def test_each_size_is_part_of_a_mesh_key(field):
    zone = Zone(3.0, 2.0, 1.0)
    sizes = MeshSizes.of(DESIGN, zone)
    other = replace(sizes, **{field: 1.01 * getattr(sizes, field)})
    assert mesh_key(DESIGN, other, zone, True) != mesh_key(DESIGN, sizes, zone, True)


def test_a_mesh_comes_back_as_it_was_and_garbage_is_nothing_kept(folder, mesh):
    mesh = in_tetrahedra(mesh)
    assert store_mesh("key", mesh)
    again, path = load_mesh("key"), folder / "key.npz"
    for name in ("points", "cells", "regions"):
        np.testing.assert_array_equal(getattr(again, name), getattr(mesh, name))
    for name in ("notes", "region_names", "mesher", "symmetric"):
        assert getattr(again, name) == getattr(mesh, name)
    assert {name: rows.tolist() for name, rows in again.facets.items()} == {
        name: rows.tolist() for name, rows in mesh.facets.items()
    }
    with np.load(path) as data:
        good = dict(data)
    for bad in (
        {"cells": good["cells"] + len(mesh.points)},
        {"points": good["points"][:0]},
        {"points": np.full_like(good["points"], np.nan)},
        {"about": np.array("[]")},
        {"about": np.array('{"facets": 3}')},
    ):
        np.savez(path, **good | bad)
        assert load_mesh("key") is None
    path.write_bytes(b"garbage")
    assert load_mesh("key") is None
