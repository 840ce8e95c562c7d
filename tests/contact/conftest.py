"""Elastic half-spaces with coupled nodes, numpy alone: stand-ins for fingers."""

import numpy as np
import pytest

from fingerdesign.contact.problem import contact_problem
from fingerdesign.reduced import ReducedModel, SurfaceQuadrature
from fingerdesign.shapes.objects import Plane


def model_on(points, facets, areas, compliance, rim):
    m, dim = points.shape
    return ReducedModel(
        points=points,
        facets=facets,
        facet_areas=np.full(len(facets), areas.sum() / len(facets)),
        areas=areas,
        compliance=compliance,
        gage_readout=np.zeros((0, m * dim)),
        point_readout=np.zeros((0, m * dim)),
        reaction_readout=-np.tile(np.eye(dim), m),
        surface=SurfaceQuadrature(points, np.arange(m), np.arange(m), np.ones(m)),
        rim=rim,
        free_end=np.zeros(m, dtype=bool),
        locked=np.zeros((m, dim), dtype=bool),
        depth=1.0,
    )


@pytest.fixture(scope="session")
def strip():
    """Incompressible half-plane under a crest of radius 20 (Flamant, far point 12 mm away)."""
    x = np.linspace(-3.0, 3.0, 121)
    h = x[1] - x[0]
    distance = np.abs(x[:, None] - x[None])
    scalar = 0.1 * (np.log(12.0 / np.where(distance > 0, distance, 0.5 * h)) + (distance == 0))
    rim = np.zeros(len(x), dtype=bool)
    rim[[0, -1]] = True
    facets = np.column_stack([np.arange(120), np.arange(1, 121)])
    points = np.column_stack([x, -(x**2) / 40.0])
    model = model_on(points, facets, np.full(121, h), np.kron(scalar, np.eye(2)), rim)
    return contact_problem(model, Plane(0.0), 0.5)


@pytest.fixture(scope="session")
def patch():
    """A bump of radius 20 on springs coupled by 1/r, equal in x, y and z: a 17 x 17 grid."""
    side = np.linspace(-1.0, 1.0, 17)
    x, z = (grid.ravel() for grid in np.meshgrid(side, side, indexing="ij"))
    points = np.column_stack([x, -(x**2 + z**2) / 40.0, z])
    distance = np.hypot(x[:, None] - x[None], z[:, None] - z[None])
    scalar = 0.05 / np.where(distance > 0, distance, 0.3 * (side[1] - side[0]))
    number = np.arange(17 * 17).reshape(17, 17)
    a, b, c, d = (
        part.ravel()
        for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    facets = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    areas = np.full(len(x), (side[1] - side[0]) ** 2)
    rim = np.maximum(np.abs(x), np.abs(z)) > 0.99
    model = model_on(points, facets, areas, np.kron(scalar, np.eye(3)), rim)
    return contact_problem(model, Plane(0.0), 0.5)
