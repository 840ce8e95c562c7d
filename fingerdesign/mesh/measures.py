"""Measures of simplices: angles, aspects, edges, straight and curved volumes (numpy only)."""

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.mesh.cells import KINDS, TETRA, TRIANGLE, kind_of


def cell_volumes(points: Array, cells: IntArray) -> Array:
    """Signed areas of triangles or volumes of tetrahedra, (c,), by their corners."""
    a, *others = (points[cells[:, k]] for k in range(points.shape[1] + 1))
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
    """Which quadratic cells (c, 6 or 10) have a mid-edge node off its edge's middle, (c,).

    ``tolerance``: of the edge's length.
    """
    kind = kind_of(cells)
    found = np.zeros(len(cells), dtype=bool)
    for edge, (i, j) in enumerate(kind.edges):
        a, b = points[cells[:, i]], points[cells[:, j]]
        away = np.linalg.norm(points[cells[:, kind.corners + edge]] - 0.5 * (a + b), axis=1)
        found |= away > tolerance * np.linalg.norm(b - a, axis=1)
    return found


def curved_volumes(points: Array, cells: IntArray) -> Array:
    """Signed areas (c,) of quadratic triangles (c, 6), or volumes of tetrahedra (c, 10), exact.

    The Jacobian determinant is quadratic in the plane and cubic in space: the middles of the edges,
    or the corners (1/40) and the middles of the faces (9/40), integrate it.
    """
    dim = points.shape[1]
    volumes = cell_volumes(points, cells[:, : dim + 1])
    bent = curved_cells(points, cells)
    if not bent.any():
        return volumes
    eye = np.eye(dim + 1)
    if dim == 2:
        samples = [(0.5 * (eye[i] + eye[j]), 1.0 / 3.0) for i, j in TRIANGLE.edges]
    else:
        samples = [(eye[i], 1.0 / 40.0) for i in range(4)]
        samples += [((1.0 - eye[i]) / 3.0, 9.0 / 40.0) for i in range(4)]
    nodes = points[cells[bent]]
    total = sum(weight * jacobians(nodes, place) for place, weight in samples)
    volumes[bent] = total / (2.0 if dim == 2 else 6.0)
    return volumes


def jacobians(nodes: Array, place: Array) -> Array:
    """Jacobian determinants (c,) of quadratic triangles or tetrahedra at one place in them.

    nodes (c, 6, 2) or (c, 10, 3); place (dim + 1,): barycentric coordinates. Of straight-sided
    cells: 2 or 6 times their area or volume.
    """
    dim = nodes.shape[2]
    gradient = np.zeros((nodes.shape[1], dim + 1))
    gradient[: dim + 1] = np.diag(4.0 * place - 1.0)
    for edge, (i, j) in enumerate(KINDS[dim].edges):
        gradient[dim + 1 + edge, i] = 4.0 * place[j]
        gradient[dim + 1 + edge, j] = 4.0 * place[i]
    to_local = np.vstack([-np.ones(dim), np.eye(dim)])  # barycentric coordinates by local ones
    return np.asarray(np.linalg.det(np.einsum("cni,nj->cij", nodes, gradient @ to_local)))


def least_jacobian_ratios(points: Array, cells: IntArray) -> Array:
    """Least Jacobian of quadratic triangles or tetrahedra over the straight one's, (c,).

    Sampled at corners, edges' middles and centroid; 1 for straight edges, <= 0 folded; 0 for cells
    that have no volume.
    """
    dim = points.shape[1]
    ratio = np.ones(len(cells))
    bent = curved_cells(points, cells)
    nodes = points[cells[bent]]
    straight = (2.0 if dim == 2 else 6.0) * cell_volumes(points, cells[bent][:, : dim + 1])
    corners = np.eye(dim + 1)
    places = [*corners, *(0.5 * (corners[i] + corners[j]) for i, j in KINDS[dim].edges)]
    places.append(np.full(dim + 1, 1.0 / (dim + 1)))
    least = np.min([jacobians(nodes, place) for place in places], axis=0)
    ratio[bent] = np.divide(least, straight, out=np.zeros(len(least)), where=straight != 0.0)
    return ratio


def cell_angles(points: Array, cells: IntArray) -> Array:
    """Angles of triangles (c, 3), or dihedral angles of tetrahedra (c, 6), degrees."""
    if cells.shape[1] == 3:
        corners = points[cells]
        found = []
        for i in range(3):
            u = corners[:, (i + 1) % 3] - corners[:, i]
            v = corners[:, (i + 2) % 3] - corners[:, i]
            cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
            found.append(np.arctan2(np.abs(cross), np.einsum("ij,ij->i", u, v)))
        return np.asarray(np.degrees(np.stack(found, axis=1)))
    a, b, c, d = (points[cells[:, k]] for k in range(4))
    pairs = ((c - b, d - b), (d - a, c - a), (b - a, d - a), (c - a, b - a))
    faces = np.stack([np.cross(*pair) for pair in pairs], axis=1)  # all outward, or all inward
    one, other = (faces[:, k] for k in np.triu_indices(4, 1))
    sine = np.linalg.norm(np.cross(one, other), axis=2)
    return np.asarray(np.degrees(np.arctan2(sine, -np.einsum("tpk,tpk->tp", one, other))))


def edge_lengths(points: Array, cells: IntArray) -> Array:
    """Lengths (c, edges) of all corner-to-corner edges of simplices, mm."""
    one, other = (points[cells[:, ends]] for ends in np.triu_indices(cells.shape[1], 1))
    return np.asarray(np.linalg.norm(other - one, axis=2))


def aspects(points: Array, cells: IntArray) -> Array:
    """Longest edge over inscribed radius, scaled so that a regular simplex has 1, (c,)."""
    longest = edge_lengths(points, cells).max(axis=1)
    volume = np.maximum(np.abs(cell_volumes(points, cells)), 1e-300)
    if cells.shape[1] == 3:
        around = edge_lengths(points, cells).sum(axis=1)
        return np.asarray(longest * around / volume / (4.0 * np.sqrt(3.0)))
    surface = np.zeros(len(cells))
    for facet in TETRA.facets:
        a, b, c = (points[cells[:, corner]] for corner in facet)
        surface += 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.asarray(longest * surface / (3.0 * volume) / (2.0 * np.sqrt(6.0)))


def curved_areas(points: Array, facets: IntArray) -> Array:
    """Areas (f,) of quadratic triangles (f, 6) in space, by a six-point rule (degree 4)."""
    nodes = points[facets]
    total = np.zeros(len(facets))
    for weight, inner in (
        (0.223381589678011, 0.108103018168070),
        (0.109951743655322, 0.816847572980459),
    ):
        outer = 0.5 * (1.0 - inner)
        for spot in range(3):
            b = np.full(3, outer)
            b[spot] = inner
            du = np.array([1 - 4 * b[0], 4 * b[1] - 1, 0, 4 * (b[0] - b[1]), 4 * b[2], -4 * b[2]])
            dv = np.array([1 - 4 * b[0], 0, 4 * b[2] - 1, -4 * b[1], 4 * b[1], 4 * (b[0] - b[2])])
            normal = np.cross(np.einsum("fni,n->fi", nodes, du), np.einsum("fni,n->fi", nodes, dv))
            total += 0.5 * weight * np.linalg.norm(normal, axis=1)
    return total
