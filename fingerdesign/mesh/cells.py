"""Cells of meshes: triangles and tetrahedra, their edges, facets and mid-nodes (numpy only).

All that depends on the shape of a cell follows from its ``CellKind``. Layers are made of prisms,
which ``split_prisms`` cuts into tetrahedra.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError

# Corner pairs of the mid-edge nodes, in the order of VTK, meshio and scikit-fem alike.
TRIANGLE_EDGES = ((0, 1), (1, 2), (0, 2))
TETRA_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
TETRA_FACETS = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))


@dataclass(frozen=True)
class CellKind:
    """A simplex: corners, then (quadratic) the middles of ``edges``; ``facets`` by their corners.

    linear, quadratic: its names in meshio.
    """

    linear: str
    quadratic: str
    edges: tuple[tuple[int, int], ...]
    facets: tuple[tuple[int, ...], ...]

    @property
    def dimension(self) -> int:
        return len(self.facets) - 1

    @property
    def corners(self) -> int:
        """Number of corners."""
        return len(self.facets)

    @property
    def nodes(self) -> int:
        """Number of nodes of the quadratic cell."""
        return self.corners + len(self.edges)

    @property
    def facet(self) -> "CellKind":
        """The kind of its facets."""
        return TRIANGLE if self.dimension == 3 else LINE


LINE = CellKind("line", "line3", ((0, 1),), ((0,), (1,)))
TRIANGLE = CellKind("triangle", "triangle6", TRIANGLE_EDGES, TRIANGLE_EDGES)
TETRA = CellKind("tetra", "tetra10", TETRA_EDGES, TETRA_FACETS)
KINDS = {kind.dimension: kind for kind in (LINE, TRIANGLE, TETRA)}


def kind_of(cells: IntArray) -> CellKind:
    """The kind of linear or quadratic triangles (c, 3 or 6) or tetrahedra (c, 4 or 10)."""
    return TRIANGLE if cells.shape[1] in (TRIANGLE.corners, TRIANGLE.nodes) else TETRA


def quadratic(points: Array, cells: IntArray) -> tuple[Array, IntArray]:
    """Add straight mid-edge nodes to a linear simplicial mesh.

    points (n, dim), cells (c, dim + 1) -> points (n + edges, dim), cells (c, 6 or 10). All points
    stay in their order, unused ones too.

    >>> p, c = quadratic(np.array([[0., 0.], [1., 0.], [0., 1.]]), np.array([[0, 1, 2]]))
    >>> c.tolist(), p[4].tolist()
    ([[0, 1, 2, 3, 4, 5]], [0.5, 0.5])
    """
    ends = _edges(cells, kind_of(cells))
    flat = ends.reshape(-1, 2).astype(np.int64)
    keys = flat[:, 0] * len(points) + flat[:, 1]
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(np.argsort(first))  # number edges as they are met, not by key
    edges = np.empty((len(first), 2), dtype=np.int64)
    edges[order] = flat[first]
    middles = 0.5 * (points[edges[:, 0]] + points[edges[:, 1]])
    added = len(points) + order[inverse.reshape(-1)].reshape(ends.shape[:2])
    return np.vstack([points, middles]), np.hstack([cells.astype(np.int64), added])


def _edges(cells: IntArray, kind: CellKind) -> IntArray:
    """Both ends of each edge of the cells, (c, edges, 2), the lower number first."""
    return np.sort(np.stack([cells[:, list(pair)] for pair in kind.edges], axis=1), axis=2)


def with_mid_nodes(cells: IntArray, corners: IntArray, name: str = "facets") -> IntArray:
    """Add the mid-edge nodes of quadratic cells (c, 6 or 10) to facets (f, dim) of theirs.

    MeshError where an edge of a facet belongs to no cell.
    """
    kind = kind_of(cells)
    if len(corners) == 0:
        return np.zeros((0, kind.facet.nodes), dtype=np.int64)
    count = int(max(cells.max(), corners.max())) + 1
    ends = _edges(cells, kind)
    keys, at = np.unique((ends[..., 0] * count + ends[..., 1]).reshape(-1), return_index=True)
    middles = cells[:, kind.corners :].reshape(-1)[at]
    edges = _edges(corners, kind.facet)
    searched = edges[..., 0] * count + edges[..., 1]
    place = np.minimum(np.searchsorted(keys, searched), len(keys) - 1)
    missing = (keys[place] != searched).any(axis=1)
    if missing.any():
        raise MeshError(f"{int(missing.sum())} facets of {name!r} are no faces of any cell")
    return np.hstack([corners, middles[place]]).astype(np.int64)


def boundary_facets(cells: IntArray) -> IntArray:
    """Facets of one cell only, (f, dimension), of quadratic cells with their mid-edge nodes."""
    kind = kind_of(cells)
    facets = np.concatenate([cells[:, part] for part in kind.facets])
    _, first, uses = np.unique(
        np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = np.asarray(facets[first[uses == 1]])
    if cells.shape[1] == kind.corners:
        return outer
    found = with_mid_nodes(cells, outer)
    return found[np.argsort(found[:, 2])] if kind is TRIANGLE else found


def split_prisms(low: IntArray, high: IntArray) -> IntArray:
    """Cut each prism between triangles (t, 3), node by node, into three tetrahedra (3 t, 4).

    A square side is cut from its low node of lower number, so that neighbours agree; the
    orientation of the tetrahedra is not settled.
    """
    order = np.argsort(low, axis=1)
    low, high = (np.take_along_axis(each, order, axis=1) for each in (low, high))
    parts = [
        np.column_stack([low, high[:, 2]]),
        np.column_stack([low[:, :2], high[:, 1:]]),
        np.column_stack([low[:, 0], high]),
    ]
    return np.stack(parts, axis=1).reshape(-1, 4)


def tetra_facets(cells: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """All facets of tetrahedra, cell by cell: corners (4 c, 3), the fourth corner and the cell."""
    apex = cells[:, [6 - sum(facet) for facet in TETRA_FACETS]].reshape(-1)
    facets = cells[:, np.array(TETRA_FACETS)].reshape(-1, 3)
    return facets, apex, np.repeat(np.arange(len(cells)), len(TETRA_FACETS))


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
    """The tetrahedra around each node: ``tets[start[i]:start[i + 1]]``."""

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
