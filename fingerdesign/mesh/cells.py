"""Cells of meshes: triangles, tetrahedra, prisms; their edges, facets, mid-nodes (numpy only).

All that depends on the shape of a cell follows from its ``CellKind``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError

# Corner pairs of the mid-edge nodes, in the order of VTK, meshio and scikit-fem alike.
TRIANGLE_EDGES = ((0, 1), (1, 2), (0, 2))
TETRA_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
TETRA_FACETS = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))
_SQUARE_EDGES = ((0, 1), (1, 2), (2, 3), (0, 3))
# A prism's corners: a triangle at the lower z, then the same at the higher z; VTK's order.
_PRISM_EDGES = ((0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5), (0, 3), (1, 4), (2, 5))
_PRISM_SQUARES = ((0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))


@dataclass(frozen=True)
class CellKind:
    """A shape of cells; its quadratic nodes are the corners, then the middles of ``edges``, then
    the centres of ``squares`` (faces of four corners, which go round).

    facets: by their corners; words: its name in the plural; linear, quadratic: those in meshio.
    """

    words: str
    linear: str
    quadratic: str
    dimension: int
    corners: int
    edges: tuple[tuple[int, int], ...]
    facets: tuple[tuple[int, ...], ...]
    squares: tuple[tuple[int, ...], ...] = ()

    @property
    def nodes(self) -> int:
        """Number of nodes of the quadratic cell."""
        return self.corners + len(self.edges) + len(self.squares)


LINE = CellKind("lines", "line", "line3", 1, 2, ((0, 1),), ((0,), (1,)))
TRIANGLE = CellKind("triangles", "triangle", "triangle6", 2, 3, TRIANGLE_EDGES, TRIANGLE_EDGES)
SQUARE = CellKind("squares", "quad", "quad9", 2, 4, _SQUARE_EDGES, _SQUARE_EDGES, ((0, 1, 2, 3),))
TETRA = CellKind("tetrahedra", "tetra", "tetra10", 3, 4, TETRA_EDGES, TETRA_FACETS)
PRISM = CellKind(
    *("prisms", "wedge", "wedge18", 3, 6, _PRISM_EDGES),
    *(((0, 1, 2), (3, 4, 5), *_PRISM_SQUARES), _PRISM_SQUARES),
)
FACETS = {kind.corners: kind for kind in (LINE, TRIANGLE, SQUARE)}
FACETS_BY_NODES = {kind.nodes: kind for kind in FACETS.values()}


def kind_of(cells: IntArray) -> CellKind:
    """The kind of linear or quadratic simplices (c, nodes), or of quadratic prisms (c, 18)."""
    if cells.shape[1] == PRISM.nodes:
        return PRISM
    return TRIANGLE if cells.shape[1] in (TRIANGLE.corners, TRIANGLE.nodes) else TETRA


def facet_kind(facets: IntArray) -> CellKind:
    """The kind of quadratic facets (f, nodes)."""
    return FACETS_BY_NODES[facets.shape[1]]


def quadratic(
    points: Array, cells: IntArray, kind: CellKind | None = None
) -> tuple[Array, IntArray]:
    """Add straight mid-edge nodes, and centres of square faces, to a linear mesh.

    points (n, dim), cells (c, corners) -> points (n + added, dim), cells (c, nodes). All points
    stay in their order, unused ones too. kind: of the cells (simplices where none is given).

    >>> p, c = quadratic(np.array([[0., 0.], [1., 0.], [0., 1.]]), np.array([[0, 1, 2]]))
    >>> c.tolist(), p[4].tolist()
    ([[0, 1, 2, 3, 4, 5]], [0.5, 0.5])
    """
    kind = kind_of(cells) if kind is None else kind
    ends = _ends(cells, kind)
    flat = ends.reshape(-1, 2).astype(np.int64)
    keys = flat[:, 0] * len(points) + flat[:, 1]
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(np.argsort(first))  # number edges as they are met, not by key
    edges = np.empty((len(first), 2), dtype=np.int64)
    edges[order] = flat[first]
    middles = 0.5 * (points[edges[:, 0]] + points[edges[:, 1]])
    added = len(points) + order[inverse.reshape(-1)].reshape(ends.shape[:2])
    return np.vstack([points, middles]), np.hstack([cells.astype(np.int64), added])


def _ends(cells: IntArray, kind: CellKind) -> IntArray:
    """Two corners between which each added node lies, (c, added, 2), the lower number first. A
    square's centre lies between the corner of its least number and the one across."""
    found = [cells[:, list(pair)] for pair in kind.edges]
    for square in kind.squares:
        corners = cells[:, list(square)]
        least = np.argmin(corners, axis=1)
        both = np.column_stack([least, (least + 2) % 4])
        found.append(np.take_along_axis(corners, both, axis=1))
    return np.sort(np.stack(found, axis=1), axis=2)


def with_mid_nodes(cells: IntArray, corners: IntArray, name: str = "facets") -> IntArray:
    """Add the mid-nodes of quadratic cells (c, nodes) to facets (f, corners) of theirs. MeshError
    where an edge of a facet belongs to no cell."""
    kind, facet = kind_of(cells), FACETS[corners.shape[1]]
    if len(corners) == 0:
        return np.zeros((0, facet.nodes), dtype=np.int64)
    count = int(max(cells.max(), corners.max())) + 1
    ends = _ends(cells, kind)
    keys, at = np.unique((ends[..., 0] * count + ends[..., 1]).reshape(-1), return_index=True)
    middles = cells[:, kind.corners :].reshape(-1)[at]
    edges = _ends(corners, facet)
    searched = edges[..., 0] * count + edges[..., 1]
    place = np.minimum(np.searchsorted(keys, searched), len(keys) - 1)
    missing = (keys[place] != searched).any(axis=1)
    if missing.any():
        raise MeshError(f"{int(missing.sum())} facets of {name!r} are no faces of any cell")
    return np.hstack([corners, middles[place]]).astype(np.int64)


def boundary_facets(cells: IntArray) -> IntArray:
    """Facets of one simplex only, (f, dimension), of quadratic cells with their mid-edge nodes."""
    kind = kind_of(cells)
    outer = _outer(cells, kind.facets)
    if cells.shape[1] == kind.corners:
        return outer
    found = with_mid_nodes(cells, outer)
    return found[np.argsort(found[:, 2])] if kind is TRIANGLE else found


def outer_facets(cells: IntArray) -> list[IntArray]:
    """Facets of one quadratic cell only, with their mid-nodes: (f, nodes), an array a kind."""
    facets = kind_of(cells).facets
    found = []
    for corners in sorted({len(facet) for facet in facets}):
        outer = _outer(cells, [facet for facet in facets if len(facet) == corners])
        found.append(with_mid_nodes(cells, outer))
    return found


def _outer(cells: IntArray, facets: Sequence[tuple[int, ...]]) -> IntArray:
    """Those of the cells' facets, by their corners, that belong to one cell only."""
    every = np.concatenate([cells[:, part] for part in facets])
    own = np.sort(every, axis=1)
    _, first, uses = np.unique(own, axis=0, return_index=True, return_counts=True)
    return np.asarray(every[first[uses == 1]])


def split_prisms(low: IntArray, high: IntArray) -> IntArray:
    """Cut each prism between triangles (t, 3), node by node, into three tetrahedra (3 t, 4).

    A square side is cut from its low node of lower number, so that neighbours agree; the
    orientation of the tetrahedra is not settled.
    """
    order = np.argsort(low, axis=1)
    low, high = (np.take_along_axis(each, order, axis=1) for each in (low, high))
    parts = [np.hstack([low[:, : 3 - k], high[:, 2 - k :]]) for k in range(3)]
    return np.stack(parts, axis=1).reshape(-1, 4)


# Of a prism whose first corner has the least number, by the cut of the side across from it.
_CUT = {
    (1, 5): ((0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)),
    (2, 4): ((0, 1, 2, 4), (0, 4, 2, 5), (0, 4, 5, 3)),
}
# Turned and tipped so that each corner comes first.
_FIRST = np.array(
    [
        *((0, 1, 2, 3, 4, 5), (1, 2, 0, 4, 5, 3), (2, 0, 1, 5, 3, 4)),
        *((3, 5, 4, 0, 2, 1), (4, 3, 5, 1, 0, 2), (5, 4, 3, 2, 1, 0)),
    ]
)


def tetrahedra_of(prisms: IntArray) -> IntArray:
    """Cut quadratic prisms (c, 18) into quadratic tetrahedra (3 c, 10) of the same nodes. Each side
    is cut from its corner of the least number, so that neighbours agree."""
    middle = np.zeros((6, 6), dtype=np.int64)
    for number, ends in enumerate(PRISM.edges, start=PRISM.corners):
        middle[ends, ends[::-1]] = number
    for number, (a, b, c, d) in enumerate(PRISM.squares, start=PRISM.corners + len(PRISM.edges)):
        middle[(a, c, b, d), (c, a, d, b)] = number
    order = _FIRST[np.argmin(prisms[:, :6], axis=1)]
    corners = np.take_along_axis(prisms[:, :6], order, axis=1)
    least = np.argmin(corners[:, [1, 2, 5, 4]], axis=1) % 2
    found = np.empty((len(prisms), 3, TETRA.nodes), dtype=np.int64)
    for kind, cut in enumerate(((1, 5), (2, 4))):
        own = np.flatnonzero(least == kind)
        for place, tetra in enumerate(_CUT[cut]):
            local = order[own][:, tetra]
            between = [middle[local[:, i], local[:, j]] for i, j in TETRA.edges]
            local = np.hstack([local, np.stack(between, axis=1)])
            found[own, place] = np.take_along_axis(prisms[own], local, axis=1)
    return found.reshape(-1, TETRA.nodes)


def triangles_of(squares: IntArray) -> IntArray:
    """Cut quadratic squares (f, 9) into triangles (2 f, 6) of the same nodes, as prisms are cut."""
    first = np.argmin(squares[:, :4], axis=1)
    turned = (first[:, None] + np.arange(4)) % 4
    a, b, c, d = np.take_along_axis(squares[:, :4], turned, axis=1).T
    ab, bc, cd, da = np.take_along_axis(squares[:, 4:8], turned, axis=1).T
    centre = squares[:, 8]
    halves = [np.stack([a, b, c, ab, bc, centre], 1), np.stack([a, c, d, centre, cd, da], 1)]
    return np.stack(halves, axis=1).reshape(-1, TRIANGLE.nodes)


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
