"""Each of the faults that a part's triangles can have is found by the check that names it."""

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

from fingerdesign.mold.checks.assembly import curved_area, heights, topology, volume
from fingerdesign.mold.checks.fits import part_checks
from fingerdesign.mold.part import PartMesh

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
# Two triangles a face: -x, +x, -y, +y, -z, +z.
CORNERS = "013 032 467 475 045 051 237 276 026 064 157 173"
FACES = np.array([[int(corner) for corner in face] for face in CORNERS.split()])


def part(vertices=CUBE, triangles=FACES, exact=1.0, chord=0.0):
    return PartMesh(
        "part", vertices, triangles, None, 0, "process", exact, chord, vertices, triangles, exact
    )


def failed(part_):
    return {check.name for check in part_checks(part_, 0.01) if not check.ok}


def test_a_cube_passes():
    assert failed(part()) == set()
    assert volume(CUBE, FACES) == pytest.approx(1.0)


def test_a_missing_triangle_is_not_watertight():
    assert "watertight" in failed(part(triangles=FACES[1:]))


def test_a_turned_triangle_is_wound_wrong():
    turned = FACES.copy()
    turned[0] = turned[0, ::-1]
    assert "winding" in failed(part(triangles=turned))
    assert topology(turned).open_edges == 0


def test_inside_out_fails_by_volume_alone():
    assert failed(part(triangles=FACES[:, ::-1])) == {"volume"}


def test_two_cubes_that_share_a_corner_are_not_manifold():
    other = np.where(FACES == 0, 7, FACES + 7)
    vertices = np.vstack([CUBE, CUBE[1:] + 1.0])
    touching = part(vertices, np.vstack([FACES, other]), exact=2.0)
    assert failed(touching) == {"manifold", "one shell"}


def test_a_void_is_another_shell():
    hollow = np.vstack([FACES, FACES[:, ::-1] + 8])
    vertices = np.vstack([CUBE, 0.25 + 0.5 * CUBE])
    assert failed(part(vertices, hollow, exact=0.875)) == {"one shell"}
    around_a_core = replace(part(vertices, hollow, exact=0.875), made="silicone")
    assert failed(around_a_core) == set()


def test_a_flat_triangle_is_degenerate():
    middle = 0.5 * (CUBE[0] + CUBE[3])
    vertices = np.vstack([CUBE, middle])
    split = np.vstack([FACES[1:], [[0, 1, 8], [1, 3, 8], [0, 8, 3]]])
    assert heights(vertices, split).min() == pytest.approx(0.0, abs=1e-12)
    assert failed(part(vertices, split)) == {"no degenerate triangles"}


def test_vertices_that_single_precision_makes_one():
    far = CUBE + 1000.0
    far[1, 2] = far[0, 2] + 1e-5
    assert "as written" in failed(part(far, exact=volume(far, FACES)))


def test_volume_and_chord_are_held():
    assert failed(part(exact=1.002, chord=0.01)) == {"volume"}
    assert "volume" in failed(part(exact=1.0005, chord=0.01))  # flat faces have no chord to blame
    assert failed(replace(part(), chord=0.02)) == {"chord"}


def test_only_curved_faces_count_as_curved():
    assert curved_area(CUBE, FACES) == 0.0
    found = Manifold.cylinder(10.0, 2.0, 2.0, 64).to_mesh64()
    vertices, triangles = np.array(found.vert_properties), np.array(found.tri_verts, dtype=int)
    assert curved_area(vertices, triangles) == pytest.approx(40.0 * np.pi, rel=1e-2)
