"""What pictures of meshes say and mark; test_mesh_command.py draws them."""

import numpy as np
import pytest

from fingerdesign.mesh.pictures import cropped, cut_open, near_cut, picture_title
from fingerdesign.mesh.types import Mesh

TETRA = np.vstack([np.zeros(3), np.eye(3)])


def tetrahedra(*heights, symmetric=False):
    """A unit tetrahedron at each height in z."""
    points = np.vstack([TETRA + np.array([0.0, 0.0, z]) for z in heights])
    cells = np.arange(len(points)).reshape(-1, 4)
    return Mesh(points, cells, np.zeros(len(cells), dtype=int), {}, "by hand", symmetric)


def test_only_elements_near_the_cut_are_ringed():
    mesh = tetrahedra(0.5, -0.5, 4.0, -4.0)
    assert near_cut(mesh, [3, 1, 2, 0]).tolist() == [1, 0]
    assert near_cut(mesh, []).tolist() == []
    flat = Mesh(
        np.array([[0.0, 9.0], [1.0, 9.0], [0.0, 10.0]]),
        np.arange(3)[None],
        np.zeros(1, dtype=int),
        {},
        "by hand",
        False,
    )
    assert near_cut(flat, [0]).tolist() == [0]
    assert picture_title(flat) == "the section z = 0; 1 elements (by hand)"


def test_titles_say_how_much_is_drawn():
    assert picture_title(tetrahedra(0.0), "pin").startswith("pin: the whole finger, and cut open")
    assert picture_title(tetrahedra(0.0, symmetric=True)).startswith("the half z >= 0; 1 elem")


@pytest.mark.parametrize(("height", "volume"), [(-0.5, 1.0 / 6.0 - 1.0 / 48.0), (-2.0, 1.0 / 6.0)])
def test_the_cut_is_flat_and_takes_nothing_from_what_lies_behind(height, volume):
    import pyvista

    mesh = tetrahedra(height)
    grid = pyvista.UnstructuredGrid({pyvista.CellType.TETRA: mesh.cells}, mesh.points)
    kept = cut_open(grid)
    assert kept.bounds[5] == pytest.approx(min(0.0, height + 1.0))
    assert kept.volume == pytest.approx(volume)


def test_white_around_a_picture_is_cut_off():
    image = np.full((6, 8, 3), 255, dtype=np.uint8)
    image[2:4, 3:7] = 0
    kept, corner = cropped(image)
    assert (kept.shape, corner) == ((2, 4, 3), (3, 2))
    white = np.full((2, 2, 3), 255, dtype=np.uint8)
    assert cropped(white)[0].shape == white.shape
