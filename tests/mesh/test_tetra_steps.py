"""Tetrahedra on their way to a finger: inside or not, refined, mended, snapped to CAD faces."""

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.errors import MeshError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mesh.cells import TETRA_EDGES, TETRA_FACETS, boundary_facets
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.tetra.boundary import carried_facets as named_facets
from fingerdesign.mesh.tetra.boundary import enclosed
from fingerdesign.mesh.tetra.carriers import Chain, beyond, carriers_of
from fingerdesign.mesh.tetra.collapse import collapse
from fingerdesign.mesh.tetra.improve import least_dihedral
from fingerdesign.mesh.tetra.refine import TOO_LONG, refine
from fingerdesign.mesh.tetra.snap import snap_to_carriers
from tests.support.boxes import simplices

CUBE, KUHN = simplices(*[np.array([0.0, 1.0])] * 3)
SIDES = boundary_facets(KUHN)
TURNED = np.linalg.det(CUBE[SIDES] - 0.5) < 0.0
SIDES[TURNED] = SIDES[TURNED][:, ::-1]  # wound outward


def test_points_in_a_cube_and_in_one_with_a_hollow():
    points = np.random.default_rng(0).uniform(-0.3, 1.3, (5000, 3))
    within = ((points > 0.0) & (points < 1.0)).all(axis=1)
    np.testing.assert_array_equal(enclosed(points, CUBE, SIDES), within)
    with pytest.raises(MeshError, match="3 edges are open"):
        enclosed(points, CUBE, SIDES[1:])
    hollow = 0.5 + 0.4 * (CUBE - 0.5)
    vertices, triangles = np.vstack([CUBE, hollow]), np.vstack([SIDES, SIDES[:, ::-1] + 8])
    inner = (np.abs(points - 0.5) < 0.2).all(axis=1)
    np.testing.assert_array_equal(enclosed(points, vertices, triangles), within & ~inner)


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
    def refined(size, scale):
        return refine(CUBE, KUHN, np.zeros(6, int), lambda p: np.full(len(p), size), scale, 9999)

    np.testing.assert_array_equal(refined(2.0, np.ones(3))[1], KUHN)
    coarse, fewer = (refined(0.3, np.array([1.0, 1.0, z])) for z in (1.0, 0.25))
    assert len(KUHN) < len(fewer[1]) < 0.8 * len(coarse[1])


def chamfered(points, tets, edge, far):
    """A second node ``far`` from an edge's first one, as fTetWild leaves where it cuts an edge."""
    one, two = edge
    new = points[one] + far * (points[two] - points[one])
    split = np.isin(tets, edge).sum(axis=1) == 2
    near, rest = tets[split].copy(), tets[split].copy()
    near[near == two] = len(points)
    rest[rest == one] = len(points)
    return np.vstack([points, new]), np.vstack([tets[~split], near, rest])


def on_hull_of(points):
    return np.column_stack(
        [np.abs(points[:, k] - side) < 1e-12 for k in range(3) for side in (0.0, 1.0)]
    )


@pytest.mark.parametrize("far", [1e-3, 0.0])  # flat, and without any volume
def test_nodes_of_flat_tetrahedra_become_one_and_every_face_stays(far):
    points, tets, _ = refine(
        CUBE, KUHN, np.zeros(6, int), lambda p: np.full(len(p), 0.6), np.ones(3), 9999
    )
    on = on_hull_of(points)
    ends = np.unique(np.sort(tets[:, TETRA_EDGES].reshape(-1, 2), axis=1), axis=0)
    corner = next(e for e in ends.tolist() if on[e].sum(axis=1).tolist() == [3, 2])
    spoilt, cells = chamfered(points, tets, corner, far)
    assert least_dihedral(spoilt[cells]).min() < 1.0
    mended, whole, _ = collapse(spoilt, cells, np.zeros(len(cells), int), on_hull_of(spoilt))
    assert len(whole) == len(tets)
    assert least_dihedral(mended[whole]).min() > 5.0
    assert cell_volumes(mended, whole).sum() == pytest.approx(1.0, abs=1e-12)
    assert on_hull_of(mended).sum() == on.sum()


def test_a_node_goes_into_none_that_leaves_one_of_its_faces():
    points, cells = chamfered(CUBE, KUHN, (0, 7), 1e-3)  # inside, next to a corner
    regions = np.zeros(len(cells), int)
    nowhere_else = np.zeros((9, 1), dtype=bool)
    nowhere_else[8] = True  # on a face of its own
    assert len(collapse(points, cells, regions, nowhere_else)[1]) == len(cells)
    assert len(collapse(points, cells, regions, on_hull_of(points))[1]) == len(KUHN)


def test_a_node_beyond_the_symmetry_plane_is_on_it():
    carriers = carriers_for("")
    points = np.array([[0.0, 0.0, -0.01], [0.0, -0.01, 1.0], [0.0, 1.0, 0.5]])
    names = [
        [carriers.faces[k].name for k in np.flatnonzero(row)] for row in beyond(points, carriers)
    ]
    assert names == [["symmetry"], ["base"], []]


NOTHING = np.zeros((0, 3), dtype=int)


def carriers_for(keys, symmetric=True):
    design = parse_design(f'design.name = "t"\n{keys}')
    return carriers_of(design, plate_frames(design), symmetric)


@pytest.mark.parametrize(
    ("keys", "places"),
    [
        (
            'body.shape = "dome"\nbody.dome_radius_mm = 12.0',
            {("contact", "end"): [2.0, 11.5, 4.99], ("side", "end", "contact"): [9.99, 8.9, 5.01]},
        ),
        (
            'body.shape = "revolved"',
            {("contact", "side"): [7.0, 10.0, 7.1], ("side", "symmetry"): [9.99, 4.0, 0.01]},
        ),
        (
            'body.shape = "block"\nbody.edge_radius_mm = 2.0\nbody.edge = "chamfer"',
            {("contact",): [1.0, 10.02, 1.0], ("side", "end"): [10.0, 6.01, 5.0]},
        ),
    ],
)
def test_nodes_go_to_all_faces_that_they_lie_on(keys, places):
    carriers = carriers_for(f"{keys}\nplates.count = 0")
    points = np.array(list(places.values()))
    away = np.stack([face.misfit(points) for face in carriers.faces], axis=1)
    lies_on = np.zeros(away.shape, dtype=bool)
    for row, wanted in enumerate(places):
        for name in wanted:
            others = [face.name != name for face in carriers.faces]
            lies_on[row, np.where(others, np.inf, away[row]).argmin()] = True
    snapped = snap_to_carriers(points, lies_on, carriers)
    left = np.stack([face.distance(snapped) for face in carriers.faces], axis=1)
    assert np.abs(left[lies_on]).max() < 1e-12
    assert np.abs(snapped - points).max() < 0.5  # to the near faces, nowhere else


def test_a_point_that_cannot_be_on_all_of_its_faces_is_an_error():
    carriers = carriers_for("plates.count = 0", symmetric=False)
    lies_on = np.array([[face.name == "end" for face in carriers.faces]])
    with pytest.raises(MeshError, match="cannot be snapped to end, end"):
        snap_to_carriers(np.zeros((1, 3)), lies_on, carriers)


@pytest.mark.parametrize("shape", ['body.shape = "arc"', 'body.shape = "revolved"'])
def test_where_a_half_circle_meets_its_sides_height_decides_what_facets_are(shape):
    carriers = carriers_for(f"{shape}\nbody.arc_radius_mm = 10.0\nplates.count = 0")
    joined = [face for face in carriers.faces if isinstance(face, Chain) and face.side is not None]
    assert len(joined) == 1  # no edge between: one face carries both
    y = np.array([9.8, 10.6, 10.4, 10.0])
    points = np.column_stack([[9.995, 9.975, 9.98, 8.0], y, [0.02, 0.02, 0.5, 0.2]])
    found = named_facets(
        points, np.array([[0, 1, 2, 3]]), np.zeros(1, dtype=int), carriers, NOTHING
    )
    (facet,) = np.flatnonzero((found.corners != 3).all(axis=1))
    assert found.name[facet] == "side"  # one corner is below the edge
    assert found.carrier[facet] == carriers.faces.index(joined[0])
    lies_on = np.zeros((3, len(carriers.faces)), dtype=bool)
    lies_on[:, found.carrier[facet]] = True
    snapped = snap_to_carriers(points[:3], lies_on, carriers)
    out = np.hypot(snapped[:, 0], snapped[:, 2]) if "revolved" in shape else snapped[:, 0]
    assert out[0] == pytest.approx(10.0, abs=1e-12)  # the straight side
    np.testing.assert_allclose(np.hypot(out[1:], snapped[1:, 1] - 10.0), 10.0, atol=1e-12)
