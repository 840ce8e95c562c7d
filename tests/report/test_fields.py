"""Fields open where users open them, and their strain is the displacement's."""

import dataclasses

import numpy as np
import pytest

from fingerdesign.analysis.page.fields import centroid_strain, write_fields
from fingerdesign.records.arrays import FieldHistory


def bent(mesh):
    """The mesh with its mid-edge nodes moved off the edges' middles."""
    corners = np.unique(mesh.corners)
    points = mesh.points.copy()
    free = np.ones(len(points), dtype=bool)
    free[corners] = False
    points[free] += np.random.default_rng(1).normal(scale=0.002, size=(free.sum(), points.shape[1]))
    return dataclasses.replace(mesh, points=points)


def known_strain(gradient):
    """xx, yy, zz, xy, xz, yz (engineering shear) of a constant 3 x 3 gradient, microstrain."""
    g = 1e6 * gradient
    shear = [g[0, 1] + g[1, 0], g[0, 2] + g[2, 0], g[1, 2] + g[2, 1]]
    return np.array([g[0, 0], g[1, 1], g[2, 2], *shear])


@pytest.mark.parametrize("which", ["plane_strain", "solid"])
def test_linear_displacement_gives_its_strain_on_curved_cells(which, request):
    mesh = bent(request.getfixturevalue(which).mesh)
    gradient = np.zeros((3, 3))
    d = mesh.dimension
    gradient[:d, :d] = np.random.default_rng(0).normal(scale=1e-3, size=(d, d))
    strain = centroid_strain(mesh, mesh.points @ gradient[:d, :d].T)
    assert np.allclose(strain, known_strain(gradient), rtol=0, atol=1e-6)


def test_quadratic_displacement_is_exact_at_the_centroid(plane_strain):
    mesh = plane_strain.mesh
    x, y = mesh.points.T
    displacement = np.stack([1e-4 * x * y, 1e-4 * x**2], axis=1)
    cx, cy = mesh.points[mesh.corners].mean(axis=1).T
    strain = centroid_strain(mesh, displacement)
    assert np.allclose(strain[:, 0], 100 * cy, atol=1e-6)
    assert np.allclose(strain[:, 3], 300 * cx, atol=1e-6)
    assert not strain[:, [2, 4, 5]].any()


@pytest.mark.parametrize("which", ["plane_strain", "solid"])
def test_files_open_in_pyvista_with_all_they_hold(which, request, tmp_path):
    import pyvista

    analysis = request.getfixturevalue(which)
    some = FieldHistory((0, 7), analysis.fields.displacement[[0, 7]])
    paths = write_fields(tmp_path, analysis.mesh, some)
    assert [path.name for path in paths] == ["fields_01.vtu", "fields_08.vtu"]
    grid = pyvista.read(paths[1])
    mesh = analysis.mesh
    assert set(grid.celltypes) == {22 if mesh.dimension == 2 else 24}  # VTK's quadratic cells
    assert np.array_equal(grid.cell_data["region"], mesh.regions)
    moved = grid.point_data["displacement_mm"]
    assert moved.shape == (len(mesh.points), 3)
    assert np.allclose(moved[:, : mesh.dimension], some.displacement[1], atol=1e-6)
    strain = centroid_strain(mesh, some.displacement[1])
    for column, part in enumerate(("xx", "yy", "zz", "xy", "xz", "yz")):
        values = grid.cell_data[f"strain_{part}_microstrain"]
        assert np.allclose(values, strain[:, column], rtol=1e-5, atol=1e-3)
    # Straight-edged here, so VTK's own idea of each mid-edge node must be where ours is.
    volumes = grid.compute_cell_sizes(length=False, area=True, volume=True)
    size = volumes["Area" if mesh.dimension == 2 else "Volume"]
    corners = mesh.points[mesh.corners]
    exact = np.linalg.det(corners[:, 1:] - corners[:, :1]) / (2 if mesh.dimension == 2 else 6)
    assert np.allclose(size, exact, rtol=1e-6, atol=1e-12)


def test_without_fields_the_mesh_alone_is_written(plane_strain, tmp_path):
    import meshio

    (path,) = write_fields(tmp_path, plane_strain.mesh, None)
    assert path.name == "fields_mesh.vtu"
    assert np.array_equal(meshio.read(path).cells[0].data, plane_strain.mesh.cells)


def test_fields_of_another_mesh_are_refused(plane_strain, solid, tmp_path):
    with pytest.raises(ValueError, match="not of the mesh"):
        write_fields(tmp_path, plane_strain.mesh, solid.fields)
