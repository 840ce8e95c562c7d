"""The mesh that every mesher makes and everything after it reads (numpy only)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fingerdesign.arrays import Array, IntArray

# Corner pairs of the mid-edge nodes, in the order of VTK, meshio and scikit-fem alike.
TRIANGLE_EDGES = ((0, 1), (1, 2), (0, 2))
TETRA_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
TETRA_FACETS = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))


@dataclass(frozen=True)
class Mesh:
    """A quadratic simplicial mesh in mm, in the section (dim 2) or the finger (dim 3).

    points   (n, dim): corner and mid-edge nodes
    cells    (c, 6) or (c, 10): corners, then the mid-edge nodes of TRIANGLE_EDGES / TETRA_EDGES;
             positively oriented
    regions  (c,): 0 the elastomer, k + 1 plate k, and what ``region_names`` says (a core)
    facets   name -> (f, 3) or (f, 6): boundary facets, corners then mid-edge nodes; names "base",
             "contact" (the curved face), "side", "end" (z faces), "symmetry" (z = 0 of a half);
             of plates as sheets "plate_k_upper", "_lower" and "_end": faces of plate k's slot
    symmetric  True when the mesh is the half z >= 0 of a finger that mirrors in z = 0
    """

    points: Array
    cells: IntArray
    regions: IntArray
    facets: dict[str, IntArray]
    mesher: str
    symmetric: bool = False
    notes: dict[str, float | int | str] = field(default_factory=dict)
    region_names: dict[int, str] = field(default_factory=dict)

    def region_name(self, number: int) -> str:
        """Name of a region: "elastomer", "plate_0", ..., or its own."""
        usual = "elastomer" if number == 0 else f"plate_{number - 1}"
        return self.region_names.get(number, usual)

    @property
    def dimension(self) -> int:
        return int(self.points.shape[1])

    @property
    def corners(self) -> IntArray:
        """Corner nodes of the cells, (c, dim + 1)."""
        return self.cells[:, : self.dimension + 1]


def quadratic(points: Array, cells: IntArray) -> tuple[Array, IntArray]:
    """Add straight mid-edge nodes to a linear simplicial mesh.

    points (n, dim), cells (c, dim + 1) -> points (n + edges, dim), cells (c, 6 or 10).
    Unused points are kept: their order is the caller's.

    >>> p, c = quadratic(np.array([[0., 0.], [1., 0.], [0., 1.]]), np.array([[0, 1, 2]]))
    >>> c.tolist(), p[4].tolist()
    ([[0, 1, 2, 3, 4, 5]], [0.5, 0.5])
    """
    pairs = TRIANGLE_EDGES if cells.shape[1] == 3 else TETRA_EDGES
    ends = np.sort(np.stack([cells[:, list(pair)] for pair in pairs], axis=1), axis=2)
    flat = ends.reshape(-1, 2).astype(np.int64)
    keys = flat[:, 0] * len(points) + flat[:, 1]
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(np.argsort(first))  # number edges as they are met, not by key
    edges = np.empty((len(first), 2), dtype=np.int64)
    edges[order] = flat[first]
    middles = 0.5 * (points[edges[:, 0]] + points[edges[:, 1]])
    added = len(points) + order[inverse.reshape(-1)].reshape(len(cells), len(pairs))
    return np.vstack([points, middles]), np.hstack([cells.astype(np.int64), added])
