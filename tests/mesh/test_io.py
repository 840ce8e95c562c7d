"""Meshes through files and back: points, quadratic cells, regions and facet names."""

from __future__ import annotations

import tomllib
from pathlib import Path

import meshio
import numpy as np
import pytest

from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError
from fingerdesign.mesh.extrude import extrude
from fingerdesign.mesh.io import read_mesh, to_meshio, write_mesh
from fingerdesign.mesh.section import mesh_section
from fingerdesign.mesh.types import TETRA_EDGES, TRIANGLE_EDGES, Mesh

DESIGN = Design.model_validate(
    tomllib.loads("""
    design.name = "t"
    plates.count = 1
    plates.thickness_mm = 0.3
    mesh.layers = 2
    mesh.contact_size_mm = 1.5
    mesh.plate_size_mm = 1.0
    [mesh.section]
    contact_size_mm = 1.0
    plate_size_mm = 0.5
    plate_end_size_mm = 0.3
    far_size_mm = 2.0
    """)
)


@pytest.fixture(scope="module", params=[2, 3])
def mesh(request: pytest.FixtureRequest) -> Mesh:
    return mesh_section(DESIGN, 3.0) if request.param == 2 else extrude(DESIGN, 3.0)


@pytest.mark.parametrize("ending", ["vtu", "msh", "vtk", "inp", "xdmf"])
def test_round_trip(mesh: Mesh, ending: str, tmp_path: Path) -> None:
    path = write_mesh(mesh, tmp_path / f"finger.{ending}")
    again = read_mesh(path)
    np.testing.assert_allclose(again.points, mesh.points, atol=1e-12)
    np.testing.assert_array_equal(again.cells, mesh.cells)
    np.testing.assert_array_equal(again.regions, mesh.regions)
    assert set(again.facets) == set(mesh.facets)
    for name, facets in mesh.facets.items():
        found = again.facets[name]
        if ending == "inp":  # faces are said by their element: corners in its order
            found, facets = np.sort(found, axis=1), np.sort(facets, axis=1)
        np.testing.assert_array_equal(found, facets)
    assert again.symmetric == mesh.symmetric
    assert again.dimension == mesh.dimension


def test_the_order_of_mid_nodes_is_meshios(mesh: Mesh) -> None:
    block = to_meshio(mesh).cells[0]
    assert block.type == {2: "triangle6", 3: "tetra10"}[mesh.dimension]
    inner = np.flatnonzero(mesh.regions == 1)  # straight-sided
    edges = TRIANGLE_EDGES if mesh.dimension == 2 else TETRA_EDGES
    for middle, (i, j) in enumerate(edges):
        cells = block.data[inner]
        halfway = 0.5 * (mesh.points[cells[:, i]] + mesh.points[cells[:, j]])
        np.testing.assert_allclose(mesh.points[cells[:, mesh.dimension + 1 + middle]], halfway)


def test_gmsh_files_name_their_physical_groups(mesh: Mesh, tmp_path: Path) -> None:
    found = meshio.read(write_mesh(mesh, tmp_path / "finger.msh"))
    assert {"base", "contact", "elastomer", "plate_0"} <= set(found.field_data)
    assert list(found.field_data["contact"]) == [2, mesh.dimension - 1]


def test_unknown_formats_and_linear_meshes_are_refused(mesh: Mesh, tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="could not write"):
        write_mesh(mesh, tmp_path / "finger.unknown")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(MeshError, match="could not read"):
        read_mesh(tmp_path / "missing.vtu")
    linear = meshio.Mesh(np.eye(3), [("triangle", np.array([[0, 1, 2]]))])
    linear.write(tmp_path / "linear.vtu")
    with pytest.raises(MeshError, match="no quadratic cells"):
        read_mesh(tmp_path / "linear.vtu")
