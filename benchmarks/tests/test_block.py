"""Structured blocks and discs: volumes, names, gradings, conformity, exact curved nodes."""

import numpy as np
import pytest
from fingerdesign_bench.accuracy.block import block_section, upside_down
from fingerdesign_bench.accuracy.disc import disc, half_disc, right_half
from fingerdesign_bench.accuracy.revolve import revolved_half, round_block_section

from fingerdesign.fem.elements import physical_gradients
from fingerdesign.mesh.cells import TETRA_FACETS, TRIANGLE_EDGES

MESHES = {
    "rectangle": (lambda: block_section(60.0, 40.0, 1.5, 0.2), 120.0 * 40.0),
    "half disc": (lambda: half_disc(8.0, 1.0, 0.05), 32.0 * np.pi),
    "round block": (
        lambda: revolved_half(round_block_section(30.0, 20.0, 1.2, 0.3)),
        0.5 * np.pi * 900.0 * 20.0,
    ),
    "half ball": (lambda: revolved_half(quarter_disc()), np.pi * 512.0 / 3.0),
    "disc": (lambda: disc(50.0, 8.0, 0.4), 2500.0 * np.pi),
}


def quarter_disc():
    return right_half(half_disc(8.0, 1.0, 0.2))


def volume(mesh):
    return physical_gradients(mesh.points, mesh.cells, 4)[1].sum()


@pytest.fixture(params=MESHES, scope="module")
def case(request):
    build, size = MESHES[request.param]
    return build(), size


def test_volume_also_upside_down(case):
    mesh, size = case
    assert volume(mesh) == pytest.approx(size, rel=2e-4)
    assert volume(upside_down(mesh)) == pytest.approx(volume(mesh), rel=1e-12)


def test_facets_are_the_whole_boundary_once(case):
    mesh, _ = case
    dimension = mesh.dimension
    local = TRIANGLE_EDGES if dimension == 2 else TETRA_FACETS
    every = np.sort(np.vstack([mesh.cells[:, each] for each in local]), axis=1)
    faces, count = np.unique(every, axis=0, return_counts=True)
    named = np.sort(np.vstack([each[:, :dimension] for each in mesh.facets.values()]), axis=1)
    assert count.max() == 2
    assert np.array_equal(np.unique(named, axis=0), faces[count == 1])
    assert len(named) == (count == 1).sum()


def test_nodes_of_a_ball_lie_on_it():
    mesh = revolved_half(quarter_disc())
    surface = mesh.points[np.unique(mesh.facets["contact"])]
    assert np.abs(np.linalg.norm(surface - np.array([0.0, -8.0, 0.0]), axis=1) - 8.0).max() < 1e-12
    assert mesh.points[:, 2].min() == 0.0
