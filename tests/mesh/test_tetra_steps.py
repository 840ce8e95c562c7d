"""Tetrahedra on their way to a finger: inside or not, refined, flat ones mended."""

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.errors import MeshError
from fingerdesign.layout.surface import ContactSurface
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.tetra.boundary import check_closed, enclosed
from fingerdesign.mesh.tetra.carriers import carriers_of
from fingerdesign.mesh.tetra.finish import TOO_LONG, refine
from fingerdesign.mesh.tetra.snap import TARGET_DEG, improve, least_dihedral
from fingerdesign.mesh.types import TETRA_EDGES, TETRA_FACETS
from tests.support.boxes import simplices

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
SIDES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 5, 1], [0, 4, 5]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)


def test_points_in_a_cube_and_in_one_with_a_hollow():
    points = np.random.default_rng(0).uniform(-0.3, 1.3, (5000, 3))
    within = ((points > 0.0) & (points < 1.0)).all(axis=1)
    np.testing.assert_array_equal(enclosed(points, CUBE, SIDES), within)
    hollow = 0.5 + 0.4 * (CUBE - 0.5)
    vertices, triangles = np.vstack([CUBE, hollow]), np.vstack([SIDES, SIDES[:, ::-1] + 8])
    inner = (np.abs(points - 0.5) < 0.2).all(axis=1)
    np.testing.assert_array_equal(enclosed(points, vertices, triangles), within & ~inner)


def test_a_finely_faceted_dome_agrees_with_its_closed_form():
    from fingerdesign.cad.export import triangulate
    from fingerdesign.cad.solid import build_solid

    design = parse_design(
        'design.name = "t"\nbody.shape = "dome"\nbody.dome_radius_mm = 12.0\nplates.count = 0'
    )
    outside = triangulate([build_solid(design, half=True).outline], 0.01)
    check_closed(*outside)
    rng = np.random.default_rng(1)
    points = rng.uniform([-11.0, -1.0, -1.0], [11.0, 13.0, 6.0], (20_000, 3))
    surface = ContactSurface.of(design.body)
    points = points[np.abs(surface.distance(points)) > 0.011]  # the chords' tolerance
    box = (np.abs(points[:, 0]) < 10.0) & (points[:, 1] > 0.0)
    box &= (points[:, 2] > 0.0) & (points[:, 2] < 5.0)
    with np.errstate(invalid="ignore"):
        wanted = box & surface.encloses(points)
    np.testing.assert_array_equal(enclosed(points, *outside), wanted)


def test_an_open_outside_is_refused():
    check_closed(CUBE, SIDES)
    with pytest.raises(MeshError, match="3 edges are open"):
        check_closed(CUBE, SIDES[1:])


def test_flat_tetrahedra_are_mended_without_leaving_their_faces():
    # A fan around an inner node that lies almost in the base, and one on it almost in an edge.
    design = parse_design('design.name = "t"\nplates.count = 0')
    carriers = carriers_of(design, (), symmetric=True)
    ring = np.array([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 3.0], [-1.0, 0.0, 3.0]])
    points = np.vstack([ring, [[0.0, 0.0, 1.05], [0.0, 0.04, 2.0], [0.0, 2.0, 2.0]]])
    base = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    tets = np.array([[a, b, c, 5] for a, b, c in base] + [[a, b, 5, 6] for a, b, _ in base])
    flip = cell_volumes(points, tets) < 0
    tets[flip] = tets[flip][:, [0, 2, 1, 3]]
    lies_on = np.zeros((len(points), len(carriers.faces)), dtype=bool)
    lies_on[:5, [face.name == "base" for face in carriers.faces].index(True)] = True
    lies_on[[0, 1, 2, 3, 6], :3] = True  # the hull is held: three faces each
    before = least_dihedral(points[tets]).min()
    better = improve(points, tets, lies_on, carriers)
    assert before < 5.0
    assert least_dihedral(better[tets]).min() > TARGET_DEG
    assert better[4, 1] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_array_equal(better[[0, 1, 2, 3, 6]], points[[0, 1, 2, 3, 6]])


def size(points):
    """Fine at the corner (0, 0, 0)."""
    return 0.02 + 0.25 * np.linalg.norm(points, axis=1)


def test_refined_meshes_conform_and_reach_their_sizes():
    corners, kuhn = simplices(*[np.array([0.0, 1.0])] * 3)
    scale = np.ones(3)
    points, tets, regions = refine(corners, kuhn, np.arange(6), size, scale, 100_000)
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
    assert least_dihedral(points[tets]).min() > 0.4 * least_dihedral(corners[kuhn]).min()
    assert len(tets) > 500


def test_a_mesh_fine_enough_stays_and_scale_stretches():
    corners, kuhn = simplices(*[np.array([0.0, 1.0])] * 3)

    def refined(size, scale):
        return refine(corners, kuhn, np.zeros(6, int), lambda p: np.full(len(p), size), scale, 9999)

    np.testing.assert_array_equal(refined(2.0, np.ones(3))[1], kuhn)
    coarse, fewer = (refined(0.3, np.array([1.0, 1.0, z])) for z in (1.0, 0.25))
    assert len(kuhn) < len(fewer[1]) < 0.8 * len(coarse[1])
