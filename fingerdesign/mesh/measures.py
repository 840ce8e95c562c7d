"""Measures of cells: angles, aspects, edges, straight and curved volumes (numpy only)."""

from itertools import product

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.mesh.cells import (
    LINE,
    PRISM,
    SQUARE,
    TETRA,
    TRIANGLE,
    CellKind,
    facet_kind,
    kind_of,
)

# Places (barycentric) and weights that integrate the Jacobians of quadratic simplices exactly: they
# are quadratic in the plane and cubic in space.
_EYES = {kind: np.eye(kind.corners) for kind in (TRIANGLE, TETRA)}
_EXACT = {
    TRIANGLE: [(0.5 * (_EYES[TRIANGLE][i] + _EYES[TRIANGLE][j]), 1 / 3) for i, j in TRIANGLE.edges],
    TETRA: [
        *((each, 1.0 / 40.0) for each in _EYES[TETRA]),
        *(((1.0 - each) / 3.0, 9.0 / 40.0) for each in _EYES[TETRA]),
    ],
}
# Volume of a straight cell over its Jacobian.
_SHARE = {TRIANGLE: 0.5, TETRA: 1.0 / 6.0, PRISM: 0.5}
# Surface over thrice the volume of regular cells of edge 1.
_REGULAR = {TETRA: 2.0 * np.sqrt(6.0), PRISM: (0.5 * np.sqrt(3.0) + 3.0) / (0.75 * np.sqrt(3.0))}
_PRISM_TETRAHEDRA = ((0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3))
# Weights and places of a rule of degree 4 on triangles, of three points each.
_SIX_POINTS = (0.223381589678011, 0.108103018168070), (0.109951743655322, 0.816847572980459)
_LINEAR = {2: LINE, 3: TRIANGLE, 4: TETRA, 6: PRISM}  # The kind of cells by their corners.


def cell_volumes(points: Array, corners: IntArray) -> Array:
    """Signed areas of triangles or volumes of tetrahedra or prisms, (c,), by their corners."""
    if corners.shape[1] == PRISM.corners:
        parts = [cell_volumes(points, corners[:, part]) for part in _PRISM_TETRAHEDRA]
        return np.asarray(np.sum(parts, axis=0))
    a, *others = (points[corners[:, k]] for k in range(points.shape[1] + 1))
    if len(others) == 3:
        b, c, d = others
        return np.asarray(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0)
    u, v = (other - a for other in others)
    return np.asarray(0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]))


def oriented(points: Array, cells: IntArray) -> IntArray:
    """Linear cells, those of a negative area or volume turned round."""
    turned = cells.copy()
    negative = cell_volumes(points, cells) < 0.0
    turned[negative, 1:3] = cells[negative, 2:0:-1]
    return turned


def curved_cells(points: Array, cells: IntArray, tolerance: float = 1e-9) -> BoolArray:
    """Which quadratic cells (c, nodes) are no affine images of the reference cell, (c,).

    They have a mid-node off its edge's or face's middle, or are prisms of other than parallel
    edges; ``tolerance``: of the edge's length.
    """
    kind = kind_of(cells)
    nodes = points[cells]
    found = np.zeros(len(cells), dtype=bool)
    for number, ends in enumerate((*kind.edges, *kind.squares), start=kind.corners):
        around = nodes[:, ends]
        away = np.linalg.norm(nodes[:, number] - around.mean(axis=1), axis=1)
        found |= away > tolerance * np.linalg.norm(around[:, -1] - around[:, 0], axis=1)
    if kind is PRISM:
        edges = nodes[:, 3:6] - nodes[:, :3]
        apart = np.linalg.norm(edges - edges[:, :1], axis=2).max(axis=1)
        found |= apart > tolerance * np.linalg.norm(edges[:, 0], axis=1)
    return found


def curved_volumes(points: Array, cells: IntArray) -> Array:
    """Signed areas (c,) of quadratic triangles, or volumes of tetrahedra or prisms, exact.

    Of a prism only the section is curved: its triangle at three heights is.
    """
    kind = kind_of(cells)
    volumes = cell_volumes(points, cells[:, : kind.corners])
    bent = curved_cells(points, cells)
    if not bent.any():
        return volumes
    nodes = points[cells[bent]]
    if kind is PRISM:
        simpson = ((0.0, 1.0 / 6.0), (0.5, 2.0 / 3.0), (1.0, 1.0 / 6.0))
        pairs = product(_EXACT[TRIANGLE], simpson)
        samples = [(np.append(place, z), weight * part) for (place, weight), (z, part) in pairs]
    else:
        samples = _EXACT[kind]
    total = sum(weight * jacobians(kind, nodes, place) for place, weight in samples)
    volumes[bent] = _SHARE[kind] * total
    return volumes


def jacobians(kind: CellKind, nodes: Array, place: Array) -> Array:
    """Jacobian determinants (c,) of quadratic cells with ``nodes`` (c, n, dim) at one place.

    place: barycentric coordinates, of a prism those of its triangle and the height from 0 to 1. Of
    straight-sided cells: their area or volume over _SHARE.
    """
    return np.asarray(np.linalg.det(np.einsum("cni,nj->cij", nodes, _slopes(kind, place))))


def _slopes(kind: CellKind, place: Array) -> Array:
    """Derivatives (n, dim) of quadratic shape functions by reference coordinates, at one place."""
    if kind is PRISM:
        z = float(place[3])
        line = np.array([(1.0 - z) * (1.0 - 2.0 * z), z * (2.0 * z - 1.0), 4.0 * z * (1.0 - z)])
        rise = np.array([4.0 * z - 3.0, 4.0 * z - 1.0, 4.0 - 8.0 * z])
        flat, value = _slopes(TRIANGLE, place[:3]), _values(place[:3])
        return np.concatenate(
            [
                np.column_stack([line[level] * flat[rows], rise[level] * value[rows]])
                for rows in (slice(0, 3), slice(3, 6))
                for level in range(2)
            ]
            + [np.column_stack([line[2] * flat, rise[2] * value])]
        )
    corners = kind.corners
    gradient = np.zeros((kind.nodes, corners))
    gradient[:corners] = np.diag(4.0 * place - 1.0)
    for edge, (i, j) in enumerate(kind.edges):
        gradient[corners + edge, i] = 4.0 * place[j]
        gradient[corners + edge, j] = 4.0 * place[i]
    return gradient @ np.vstack([-np.ones(corners - 1), np.eye(corners - 1)])


def _values(place: Array) -> Array:
    """Quadratic shape functions (6,) of a triangle at barycentric coordinates."""
    middles = [4.0 * place[i] * place[j] for i, j in TRIANGLE.edges]
    return np.concatenate([place * (2.0 * place - 1.0), middles])


def least_jacobian_ratios(points: Array, cells: IntArray) -> Array:
    """Least Jacobian of quadratic cells over the straight one's, (c,). Sampled at corners, edges'
    middles and centroid; 1 for straight edges, <= 0 folded; 0 for cells that have no volume."""
    kind = kind_of(cells)
    ratio = np.ones(len(cells))
    bent = curved_cells(points, cells)
    nodes = points[cells[bent]]
    straight = cell_volumes(points, cells[bent][:, : kind.corners]) / _SHARE[kind]
    flat = TRIANGLE if kind is PRISM else kind
    corners = _EYES[flat]
    places = [*corners, *(0.5 * (corners[i] + corners[j]) for i, j in flat.edges)]
    places.append(np.full(flat.corners, 1.0 / flat.corners))
    if kind is PRISM:
        places = [np.append(place, height) for place in places for height in (0.0, 0.5, 1.0)]
    least = np.min([jacobians(kind, nodes, place) for place in places], axis=0)
    ratio[bent] = np.divide(least, straight, out=np.zeros(len(least)), where=straight != 0.0)
    return ratio


def cell_angles(points: Array, corners: IntArray) -> Array:
    """Angles of triangles (c, 3), or dihedral angles of tetrahedra (c, 6) or prisms (c, 9)."""
    kind = _LINEAR[corners.shape[1]]
    if kind is TRIANGLE:
        nodes = points[corners]
        found = []
        for i in range(3):
            u = nodes[:, (i + 1) % 3] - nodes[:, i]
            v = nodes[:, (i + 2) % 3] - nodes[:, i]
            cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
            found.append(np.arctan2(np.abs(cross), np.einsum("ij,ij->i", u, v)))
        return np.asarray(np.degrees(np.stack(found, axis=1)))
    if kind is PRISM:
        return _prism_angles(points[corners])
    a, b, c, d = (points[corners[:, k]] for k in range(4))
    pairs = ((c - b, d - b), (d - a, c - a), (b - a, d - a), (c - a, b - a))
    faces = np.stack([np.cross(*pair) for pair in pairs], axis=1)  # all outward, or all inward
    one, other = (faces[:, k] for k in np.triu_indices(4, 1))
    return _between(one, other)


def _prism_angles(nodes: Array) -> Array:
    """Dihedral angles (c, 9), degrees, of prisms with corners (c, 6, 3)."""
    outward = ((0, 2, 1), (3, 4, 5), *PRISM.squares)
    faces = []
    for face in outward:
        a, b, c, *more = (nodes[:, k] for k in face)
        faces.append(np.cross(c - a, more[0] - b) if more else np.cross(b - a, c - a))
    meeting = [
        [k for k, face in enumerate(outward) if set(edge) <= set(face)] for edge in PRISM.edges
    ]
    one, other = (np.stack([faces[pair[k]] for pair in meeting], axis=1) for k in (0, 1))
    return _between(one, other)


def _between(one: Array, other: Array) -> Array:
    """Angles (c, e), degrees, between faces of outward normals (c, e, 3)."""
    sine = np.linalg.norm(np.cross(one, other), axis=2)
    return np.asarray(np.degrees(np.arctan2(sine, -np.einsum("tpk,tpk->tp", one, other))))


def edge_lengths(points: Array, corners: IntArray, kind: CellKind | None = None) -> Array:
    """Lengths (c, edges) of the edges of cells, or of facets of a named kind, by corners; mm."""
    ends = np.array((kind or _LINEAR[corners.shape[1]]).edges)
    one, other = (points[corners[:, side]] for side in ends.T)
    return np.asarray(np.linalg.norm(other - one, axis=2))


def aspects(points: Array, corners: IntArray) -> Array:
    """Longest edge over inscribed radius, scaled so that a regular cell has 1, (c,)."""
    kind = _LINEAR[corners.shape[1]]
    lengths = edge_lengths(points, corners)
    longest = lengths.max(axis=1)
    volume = np.maximum(np.abs(cell_volumes(points, corners)), 1e-300)
    if kind is TRIANGLE:
        around = lengths.sum(axis=1)
        return np.asarray(longest * around / volume / (4.0 * np.sqrt(3.0)))
    surface = np.sum([flat_areas(points, corners[:, facet]) for facet in kind.facets], axis=0)
    return np.asarray(longest * surface / (3.0 * volume) / _REGULAR[kind])


def flat_areas(points: Array, corners: IntArray) -> Array:
    """Areas (f,) of plane triangles (f, 3) or four-sided faces (f, 4), whose corners go round."""
    a, b, c, *more = (points[corners[:, k]] for k in range(corners.shape[1]))
    normal = np.cross(c - a, more[0] - b) if more else np.cross(b - a, c - a)
    return np.asarray(0.5 * np.linalg.norm(normal, axis=1))


def curved_areas(points: Array, facets: IntArray) -> Array:
    """Areas (f,) of quadratic triangles (f, 6) or squares (f, 9) in space. By a six-point rule
    (degree 4), or Gauss's of three points each way."""
    nodes = points[facets]
    if facet_kind(facets) is SQUARE:
        return _square_areas(nodes)
    total = np.zeros(len(facets))
    for weight, inner in _SIX_POINTS:
        outer = 0.5 * (1.0 - inner)
        for spot in range(3):
            b = np.full(3, outer)
            b[spot] = inner
            du = np.array([1 - 4 * b[0], 4 * b[1] - 1, 0, 4 * (b[0] - b[1]), 4 * b[2], -4 * b[2]])
            dv = np.array([1 - 4 * b[0], 0, 4 * b[2] - 1, -4 * b[1], 4 * b[1], 4 * (b[0] - b[2])])
            normal = np.cross(np.einsum("fni,n->fi", nodes, du), np.einsum("fni,n->fi", nodes, dv))
            total += 0.5 * weight * np.linalg.norm(normal, axis=1)
    return total


def _square_areas(nodes: Array) -> Array:
    """Areas (f,) of quadratic squares with nodes (f, 9, 3)."""
    first, second = np.array([(0, 1, 1, 0, 2, 1, 2, 0, 2), (0, 0, 1, 1, 0, 2, 1, 2, 2)])
    places, weights = np.polynomial.legendre.leggauss(3)
    places, weights = 0.5 * (places + 1.0), 0.5 * weights
    value = np.stack([(1 - places) * (1 - 2 * places), places * (2 * places - 1)])
    value = np.vstack([value, 4 * places * (1 - places)])
    slope = np.stack([4 * places - 3, 4 * places - 1, 4 - 8 * places])
    total = np.zeros(len(nodes))
    for i, one in enumerate(weights):
        for j, other in enumerate(weights):
            du = np.einsum("fni,n->fi", nodes, slope[first, i] * value[second, j])
            dv = np.einsum("fni,n->fi", nodes, value[first, i] * slope[second, j])
            total += one * other * np.linalg.norm(np.cross(du, dv), axis=1)
    return total
