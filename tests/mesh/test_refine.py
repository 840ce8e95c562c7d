"""Edges too long for the sizes asked are halved: conforming, volume kept, angles bounded."""

import numpy as np

from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.tetra.finish import TOO_LONG, refine
from fingerdesign.mesh.tetra.snap import least_dihedral
from fingerdesign.mesh.types import TETRA_EDGES, TETRA_FACETS

CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
KUHN = np.array(
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]
)


def size(points):
    """Fine at the corner (0, 0, 0)."""
    return 0.02 + 0.25 * np.linalg.norm(points, axis=1)


def test_refined_meshes_conform_and_reach_their_sizes():
    scale = np.ones(3)
    points, tets, regions = refine(CUBE, KUHN, np.arange(6), size, scale, 100_000)
    volumes = cell_volumes(points, tets)
    assert volumes.min() > 0.0
    np.testing.assert_allclose(np.bincount(regions, weights=volumes), 1.0 / 6.0)
    facets = np.sort(tets[:, TETRA_FACETS].reshape(-1, 3), axis=1)
    unique, uses = np.unique(facets, axis=0, return_counts=True)
    on_hull = [
        (np.abs(points[unique][:, :, axis] - side) < 1e-12).all(axis=1)
        for axis in range(3)
        for side in (0.0, 1.0)
    ]
    np.testing.assert_array_equal(uses == 1, np.any(on_hull, axis=0))  # no hanging node inside
    ends = tets[:, TETRA_EDGES]
    length = np.linalg.norm(points[ends[..., 1]] - points[ends[..., 0]], axis=2)
    assert (length <= TOO_LONG * 0.5 * size(points)[ends].sum(axis=2) + 1e-12).all()
    assert least_dihedral(points[tets]).min() > 0.4 * least_dihedral(CUBE[KUHN]).min()
    assert len(tets) > 500


def test_a_mesh_fine_enough_stays_and_scale_stretches():
    same = refine(CUBE, KUHN, np.zeros(6, int), lambda p: np.full(len(p), 2.0), np.ones(3), 100)
    np.testing.assert_array_equal(same[1], KUHN)
    coarse = refine(CUBE, KUHN, np.zeros(6, int), lambda p: np.full(len(p), 0.3), np.ones(3), 9999)
    flat = np.array([1.0, 1.0, 0.25])
    fewer = refine(CUBE, KUHN, np.zeros(6, int), lambda p: np.full(len(p), 0.3), flat, 9999)
    assert len(KUHN) < len(fewer[1]) < 0.8 * len(coarse[1])
