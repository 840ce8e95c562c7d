"""The mesh that every mesher makes and everything after it reads (numpy only)."""

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError

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

    @property
    def parts(self) -> dict[str, BoolArray]:
        """Which cells (c,) belong to "elastomer", "plates" and "core"."""
        cores = [number for number, name in self.region_names.items() if name == "core"]
        core = np.isin(self.regions, cores)
        return {"elastomer": self.regions == 0, "plates": (self.regions > 0) & ~core, "core": core}


def core_name(design: Design) -> dict[int, str]:
    """The region's name that a core adds to a mesh."""
    return {} if design.body.core is None else {design.core_region: "core"}


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


def with_mid_nodes(cells: IntArray, corners: IntArray, name: str = "facets") -> IntArray:
    """Add the mid-edge nodes of quadratic cells (c, 6 or 10) to facets (f, dim) of theirs.

    MeshError where an edge of a facet is no cell's.
    """
    tets = cells.shape[1] == 10
    first = 4 if tets else 3
    pairs = TETRA_EDGES if tets else TRIANGLE_EDGES
    own = TRIANGLE_EDGES if tets else ((0, 1),)
    if len(corners) == 0:
        return np.zeros((0, len(own) + (3 if tets else 2)), dtype=np.int64)
    count = int(max(cells.max(), corners.max())) + 1
    ends = np.sort(np.stack([cells[:, list(pair)] for pair in pairs], axis=1), axis=2)
    keys, at = np.unique((ends[..., 0] * count + ends[..., 1]).reshape(-1), return_index=True)
    middles = cells[:, first:].reshape(-1)[at]
    edges = np.sort(np.stack([corners[:, list(pair)] for pair in own], axis=1), axis=2)
    wanted = edges[..., 0] * count + edges[..., 1]
    place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    missing = (keys[place] != wanted).any(axis=1)
    if missing.any():
        raise MeshError(f"{int(missing.sum())} facets of {name!r} are no faces of any cell")
    return np.hstack([corners, middles[place]]).astype(np.int64)


def boundary_facets(cells: IntArray, dimension: int) -> IntArray:
    """Facets of one cell only, (f, dimension), of quadratic cells with their mid-edge nodes."""
    local = TETRA_FACETS if dimension == 3 else TRIANGLE_EDGES
    facets = np.concatenate([cells[:, part] for part in local])
    _, first, uses = np.unique(
        np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = np.asarray(facets[first[uses == 1]])
    if cells.shape[1] == dimension + 1:
        return outer
    found = with_mid_nodes(cells, outer)
    return found[np.argsort(found[:, 2])] if dimension == 2 else found


def prisms(low: IntArray, high: IntArray) -> IntArray:
    """Three tetrahedra (3 t, 4) for each prism between triangles (t, 3), node by node.

    A square side is cut from its low node of lower number, so that neighbours agree; the
    tetrahedra are still to be turned.
    """
    order = np.argsort(low, axis=1)
    low, high = (np.take_along_axis(each, order, axis=1) for each in (low, high))
    parts = [
        np.column_stack([low, high[:, 2]]),
        np.column_stack([low[:, :2], high[:, 1:]]),
        np.column_stack([low[:, 0], high]),
    ]
    return np.stack(parts, axis=1).reshape(-1, 4)


def facet_keys(facets: IntArray, nodes: int) -> IntArray:
    """One number (f,) for each facet of tetrahedra, by its three corners in any order."""
    a, b, c = np.sort(facets[:, :3], axis=1).astype(np.int64).T
    return np.asarray((a * nodes + b) * nodes + c)


def same_keys(keys: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs of places that have the same key, (p,) and (p,): each with the next of its kind."""
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    return order[same], order[same + 1]


def pieces(first: IntArray, second: IntArray, count: int) -> tuple[int, IntArray]:
    """Number of connected pieces of ``count`` things joined by pairs, and each thing's piece."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    number, piece = connected_components(graph, directed=False)
    return int(number), np.asarray(piece, dtype=np.int64)


@dataclass(frozen=True)
class Stars:
    """Which tetrahedra are around each node: ``tets[start[i]:start[i + 1]]``."""

    cells: IntArray
    start: IntArray
    tets: IntArray

    @classmethod
    def of(cls, cells: IntArray, count: int) -> Self:
        flat = cells.ravel()
        order = np.argsort(flat, kind="stable")
        start = np.searchsorted(flat[order], np.arange(count + 1))
        return cls(cells, start, order // 4)

    def around(self, node: int) -> IntArray:
        """Numbers of the tetrahedra that have a node."""
        return np.asarray(self.tets[self.start[node] : self.start[node + 1]])
