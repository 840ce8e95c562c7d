"""What pictures of meshes mark; test_mesh_command.py draws them."""

import numpy as np

from fingerdesign.mesh.pictures import near_cut
from tests.support.boxes import mesh_of

TETRA = np.vstack([np.zeros(3), np.eye(3)])


def tetrahedra(*heights):
    """A unit tetrahedron at each height in z."""
    points = np.vstack([TETRA + np.array([0.0, 0.0, z]) for z in heights])
    return mesh_of(points, np.arange(len(points)).reshape(-1, 4))


def test_only_elements_near_the_cut_are_ringed():
    mesh = tetrahedra(0.5, -0.5, 4.0, -4.0)
    assert near_cut(mesh, [3, 1, 2, 0]).tolist() == [1, 0]
    assert near_cut(mesh, []).tolist() == []
    flat = mesh_of(np.array([[0.0, 9.0], [1.0, 9.0], [0.0, 10.0]]), np.arange(3)[None])
    assert near_cut(flat, [0]).tolist() == [0]
