"""Triangles keep an absolute chord on every kind of face, shared faces once, vertices merged."""

import cadquery as cq
import numpy as np
import pytest

from fingerdesign.cad import triangles as tessellation
from fingerdesign.cad.bodies import outline_solid
from fingerdesign.cad.export import check_watertight, enclosed_volume
from fingerdesign.cad.kernel import volume_of
from fingerdesign.cad.triangles import merge_vertices, triangulate, triangulate_measured
from fingerdesign.design.body import Body
from fingerdesign.errors import GeometryError
from fingerdesign.layout.surface import surface_of

SHARES = np.vstack([np.random.default_rng(8).dirichlet([1.0, 1.0, 1.0], 12), np.ones((1, 3)) / 3])


def places_on(vertices, triangles, off):
    """Places (triangles, 13, 3) on those triangles whose corners are on a face: ``off`` (n,)."""
    chosen = triangles[np.all(np.abs(off)[triangles] < 1e-6, axis=1)]
    a, b, c = (vertices[chosen[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    # Corners of flat faces can all lie on a curved one: sides, ends, base and symmetry plane.
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    curved = np.abs(normal).max(axis=1) < 1.0 - 1e-12
    return np.einsum("ks,tsd->tkd", SHARES, vertices[chosen[curved]])


def written(vertices, triangles, volume, slack):
    """Closed in single precision, as files hold it, around about this volume."""
    single = vertices.astype(np.float32).astype(float)
    check_watertight("part", single, triangles)
    assert enclosed_volume(single, triangles) == pytest.approx(volume, abs=slack)


@pytest.mark.parametrize("tolerance", [0.05, 0.01])
def test_the_chord_tolerance_holds_on_every_body(body, tolerance, design_of, solid_of):
    outline, surface = solid_of(body).outline, surface_of(design_of(body).body)
    vertices, triangles = triangulate([outline], tolerance)
    written(vertices, triangles, volume_of(outline), tolerance * outline.Area())
    places = places_on(vertices, triangles, surface.distance(vertices))
    if body in ("block", "block, chamfered"):
        assert len(triangles) < 30  # nothing is curved
        return
    away = np.abs(surface.distance(places.reshape(-1, 3)))
    assert 0.0 < away.max() <= 1.02 * tolerance


@pytest.mark.slow
def test_where_the_kernel_exceeds_the_chord_it_is_requested_again(monkeypatch):
    """A dome whose arc is a half circle, of those met at random: 1.7 times at 0.75 tolerances."""
    body = Body(
        shape="dome",
        width_mm=12.384428604499746,
        arc_radius_mm=6.192214302249873,
        base_height_mm=10.647887518619957,
        depth_mm=17.09852573914453,
        dome_radius_mm=65.70118134830223,
    )
    outline, tolerance = outline_solid(body), 0.0037790899604266317
    vertices, triangles = triangulate([outline], tolerance)
    surface = surface_of(body)
    places = places_on(vertices, triangles, surface.distance(vertices))
    assert np.abs(surface.distance(places.reshape(-1, 3))).max() < 0.0039
    monkeypatch.setattr(tessellation, "TRIES", (0.75,))
    with pytest.raises(GeometryError, match="leave a face by more than"):
        triangulate([outline], tolerance)


def test_faces_shared_by_parts_come_once(core, solid_of):
    solid = solid_of("arc", "perforated", core)
    check_watertight("outline", *triangulate([solid.outline], 0.02))
    triangles = triangulate(solid.parts, 0.02)[1]
    alone = [len(triangulate([part], 0.02)[1]) for part in solid.parts]
    assert alone[0] <= len(triangles) < sum(alone)
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert np.unique(edges, axis=0, return_counts=True)[1].min() >= 2


def test_near_vertices_become_one_and_a_senseless_tolerance_is_refused(solid_of):
    base = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    doubled = np.vstack([base, base + 3e-9])
    points, triangles = merge_vertices(doubled, np.array([[0, 1, 2], [3, 4, 5], [0, 3, 1]]))
    assert (len(points), len(triangles)) == (3, 2)  # the third has collapsed
    for tolerance in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(GeometryError, match="must be above 0"):
            triangulate([solid_of("arc").outline], tolerance)


@pytest.mark.parametrize(
    ("solid", "inside"),
    [
        (cq.Solid.makeCylinder(3.0, 4.0), lambda r, z: 3.0 - r),
        (cq.Solid.makeCone(3.0, 1.0, 4.0), lambda r, z: (3.0 - 0.5 * z - r) / np.hypot(1.0, 0.5)),
        (cq.Solid.makeSphere(3.0, angleDegrees1=-90), lambda r, z: 3.0 - np.hypot(r, z)),
        (cq.Solid.makeTorus(3.0, 1.0), lambda r, z: 1.0 - np.hypot(r - 3.0, z)),
    ],
    ids=["cylinder", "cone", "sphere", "torus"],
)
def test_the_greatest_chord_is_measured(solid, inside):
    vertices, triangles, chord = triangulate_measured([solid], 0.02)
    corners = vertices[triangles]
    looks = [corners.mean(axis=1), *(0.5 * (corners[:, k] + corners[:, k - 1]) for k in range(3))]
    x, y, z = np.vstack(looks).T
    # Places on the flat ends of cylinder and cone are not on the round side.
    off = np.abs(inside(np.hypot(x, y), z))[(np.abs(z) > 1e-6) & (np.abs(z - 4.0) > 1e-6)]
    assert 0.001 < chord <= 0.02
    assert chord == pytest.approx(off.max(), rel=1e-3)
