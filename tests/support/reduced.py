"""Reduced models by hand: nodes with a given compliance; and paths of motions on them."""

import numpy as np

from fingerdesign.contact.increment import ContactState, Workspace, solve_increment
from fingerdesign.reduced import ReducedModel, SurfaceQuadrature


def followed(problem, motions, workspace=None):
    """Yield the increments of a path of motions, from touch on."""
    state, workspace = ContactState.untouched(problem), workspace or Workspace()
    for motion in motions:
        found = solve_increment(problem, state, motion, workspace)
        yield found
        state = found.state


def reduced_model(points, compliance, facets=None, **changes):
    """Nodes (m, dim) with areas of one; facets: else a chain in 2-D, a strip in 3-D."""
    m, dim = points.shape
    if facets is None:
        facets = np.column_stack([np.arange(m - dim + 1) + k for k in range(dim)])
    known = {
        "facet_areas": np.ones(len(facets)),
        "areas": np.ones(m),
        "gage_readout": np.zeros((0, m * dim)),
        "point_readout": np.zeros((0, m * dim)),
        "reaction_readout": -np.tile(np.eye(dim), m),
        "surface": SurfaceQuadrature(points, np.arange(m), np.arange(m), np.ones(m)),
        "rim": np.zeros(m, dtype=bool),
        "free_end": np.zeros(m, dtype=bool),
        "locked": np.zeros((m, dim), dtype=bool),
        "depth": 1.0,
    }
    return ReducedModel(points=points, facets=facets, compliance=compliance, **known | changes)


def bump(nodes):
    """A bump of radius 20 on springs coupled by 1/r, equal in x, y and z: a square grid."""
    side = np.linspace(-1.0, 1.0, nodes)
    x, z = (grid.ravel() for grid in np.meshgrid(side, side, indexing="ij"))
    number = np.arange(nodes**2).reshape(nodes, nodes)
    low, high = number[:-1, :-1].ravel(), number[1:, 1:].ravel()
    ways = number[1:, :-1].ravel(), number[:-1, 1:].ravel()
    facets = np.concatenate(
        [np.column_stack([low, ways[0], high]), np.column_stack([low, high, ways[1]])]
    )
    distance = np.hypot(x[:, None] - x[None], z[:, None] - z[None])
    scalar = 0.05 / np.where(distance > 0, distance, 0.3 * (side[1] - side[0]))
    area = (side[1] - side[0]) ** 2
    return reduced_model(
        np.column_stack([x, -(x**2 + z**2) / 40.0, z]),
        np.kron(scalar, np.eye(3)),
        facets,
        facet_areas=np.full(len(facets), 0.5 * area),
        areas=np.full(len(x), area),
        rim=np.maximum(np.abs(x), np.abs(z)) > 0.99,
    )
