"""Triquadratic hexahedra of extruded sections: their mesh, stiffness, pressures, contact trace.

Only ``bench hexahedra`` uses them, to say whether tetrahedra are the right choice. Each triangle of
a section is cut into three quadrilaterals about its middle, and these are swept through layers. The
27 nodes of a cell, and the 9 of a face, are tensor products of the nodes 0, 1/2 and 1, first place
fastest. Equal to scikit-fem's ElementHex2 to rounding (tested).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.fem.elements import isotropic, lame_parameters, sum_blocks
from fingerdesign.fem.system import Pressures, System, held_system, with_pressures
from fingerdesign.fem.trace import ContactTrace
from fingerdesign.mesh.types import Mesh
from fingerdesign.reduced import SurfaceQuadrature

_CHUNK = 512  # cells at a time: 60 MB of temporaries


@dataclass(frozen=True)
class HexMesh:
    """points (n, 3) mm; cells (c, 27); regions (c,); contact (f, 9): faces, z the second place."""

    points: Array
    cells: IntArray
    regions: IntArray
    contact: IntArray


def extruded_hexahedra(section: Mesh, heights: Array, project: Callable[[Array], Array]) -> HexMesh:
    """Sweep a quadratic section, each triangle cut in three, through layers between ``heights``.

    project: points (k, 2) near the contact surface -> on it.
    """
    flat, quads, edges = _quadrilaterals(section, project)
    levels = np.sort(np.concatenate([heights, 0.5 * (heights[1:] + heights[:-1])]))
    count, layers = len(flat), len(heights) - 1
    points = np.column_stack([np.tile(flat, (len(levels), 1)), np.repeat(levels, count)])

    def swept(nodes: IntArray) -> IntArray:
        parts = [
            np.hstack([nodes + (2 * layer + k) * count for k in range(3)])
            for layer in range(layers)
        ]
        return np.vstack(parts)

    return HexMesh(points, swept(quads), np.tile(section.regions, 3 * layers), swept(edges))


def _quadrilaterals(
    section: Mesh, project: Callable[[Array], Array]
) -> tuple[Array, IntArray, IntArray]:
    """Points (n, 2), quadrilaterals (q, 9) and contact edges (e, 3) of a section cut in three."""
    cells, known = section.cells, len(section.points)
    centroid = known + np.arange(len(cells))
    points = np.vstack([section.points, section.points[section.corners].mean(axis=1)])
    sides = ((0, 3, 5), (1, 4, 3), (2, 5, 4))  # corner, middles of the edges after and before it
    corners = np.vstack(
        [np.column_stack([cells[:, a], cells[:, b], centroid, cells[:, c]]) for a, b, c in sides]
    )
    ends = np.sort(corners[:, [[0, 1], [1, 2], [2, 3], [3, 0]]].reshape(-1, 2), axis=1)
    edges, numbers = np.unique(ends, axis=0, return_inverse=True)
    middles = len(points) + numbers.reshape(-1, 4)
    contact = section.facets["contact"]
    halves = np.vstack([contact[:, [0, 2]], contact[:, [2, 1]]])
    found = _rows_in(np.sort(halves, axis=1), edges)
    added = points[edges].mean(axis=1)
    added[found] = project(added[found])
    both = np.vstack([points, added])
    # The middle of a quadrilateral whose edges are curved: Coons' patch.
    centre = 0.5 * both[middles].sum(axis=1) - 0.25 * both[corners].sum(axis=1)
    inner = len(both) + np.arange(len(corners))
    a, b, c, d = corners.T
    quads = np.column_stack(
        [a, middles[:, 0], b, middles[:, 3], inner, middles[:, 1], d, middles[:, 2], c]
    )
    line = np.column_stack([halves[:, 0], len(points) + found, halves[:, 1]])
    return np.vstack([both, centre]), quads, line


def _rows_in(rows: IntArray, table: IntArray) -> IntArray:
    """Places of rows (r, 2) in a table (t, 2), sorted by rows, that holds them all."""
    size = int(table.max()) + 1
    return np.asarray(np.searchsorted(table[:, 0] * size + table[:, 1], rows @ [size, 1]))


def shapes(places: Array, dimension: int, degree: int = 2) -> tuple[Array, Array]:
    """Values (n, q^dim) and gradients (n, dim, q^dim) of the tensor products at ``places`` (q,)."""
    x = np.asarray(places)
    if degree == 1:
        value, slope = np.stack([1 - x, x]), np.stack([-np.ones_like(x), np.ones_like(x)])
    else:
        value = np.stack([2 * (x - 0.5) * (x - 1), 4 * x * (1 - x), 2 * x * (x - 0.5)])
        slope = np.stack([4 * x - 3, 4 - 8 * x, 4 * x - 1])
    parts = []
    for axis in range(-1, dimension):
        table: Array = np.ones((1, 1))
        for k in range(dimension):  # later places are slower
            table = np.asarray(np.kron(slope if k == axis else value, table), dtype=np.float64)
        parts.append(table)
    return parts[0], np.stack(parts[1:], axis=1)


def gauss(dimension: int, count: int = 3) -> tuple[Array, Array]:
    """Gauss places (q,) in [0, 1] of one direction, and the weights (q^dim,) of all."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    whole: Array = np.ones(1)
    for _ in range(dimension):
        whole = np.asarray(np.kron(0.5 * weights, whole), dtype=np.float64)
    return 0.5 * (nodes + 1.0), whole


def hex_system(
    mesh: HexMesh,
    youngs_modulus: Array,
    poissons_ratio: Array,
    fixed: BoolArray,
    pressure_cells: BoolArray | None = None,
) -> System:
    """The equations, as :func:`fingerdesign.fem.system.assemble_system` makes them of tetrahedra.

    pressure_cells (c,): where a trilinear pressure is an unknown of its own (None: nowhere).
    """
    first, shear = lame_parameters(youngs_modulus, poissons_ratio)
    mixed = np.zeros(len(mesh.cells), bool) if pressure_cells is None else pressure_cells
    rows, columns = np.triu_indices(27)
    blocks = np.empty((len(rows), len(mesh.cells), 9))
    for start in range(0, len(mesh.cells), _CHUNK):
        part = slice(start, start + _CHUNK)
        gradients, weights = _gradients(mesh, part)
        flat = gradients.reshape(*gradients.shape[:2], 81)
        product = np.matmul((flat * weights[:, :, None]).transpose(0, 2, 1), flat)
        pairs = product.reshape(-1, 27, 3, 27, 3)[:, rows, :, columns, :]
        own = isotropic(pairs, np.where(mixed, 0.0, first)[part], shear[part])
        blocks[:, part] = own.reshape(len(rows), -1, 9)
    whole = sum_blocks(mesh.cells[:, rows].T, mesh.cells[:, columns].T, blocks, len(mesh.points))
    system = held_system(whole, fixed, 3)
    if not mixed.any():
        return system
    return with_pressures(system, _pressures(mesh, mixed, first), float(np.median(shear / first)))


def _gradients(mesh: HexMesh, part: slice | IntArray) -> tuple[Array, Array]:
    """Shape gradients (c, q, 27, 3) and volume weights (c, q)."""
    places, weights = gauss(3)
    slope = shapes(places, 3)[1]
    where = mesh.points[mesh.cells[part]]
    jacobian = np.einsum("cna,nbq->cqab", where, slope, optimize=True)
    gradients = np.einsum("nbq,cqba->cqna", slope, np.linalg.inv(jacobian), optimize=True)
    return gradients, np.linalg.det(jacobian) * weights


def _pressures(mesh: HexMesh, chosen: BoolArray, first: Array) -> Pressures:
    """One continuous trilinear pressure over the chosen cells, of one material."""
    corner = np.array([i + 3 * j + 9 * k for k in (0, 2) for j in (0, 2) for i in (0, 2)])
    picked = np.flatnonzero(chosen)
    nodes, numbers = np.unique(mesh.cells[picked][:, corner], return_inverse=True)
    numbers = numbers.reshape(len(picked), 8)
    linear = shapes(gauss(3)[0], 3, degree=1)[0]
    row, column, value, mass = [], [], [], []
    for start in range(0, len(picked), _CHUNK):
        part = picked[start : start + _CHUNK]
        gradients, weights = _gradients(mesh, part)
        block = np.einsum("cqik,mq,cq->cikm", gradients, linear, weights, optimize=True)
        dofs = mesh.cells[part][:, :, None, None] * 3 + np.arange(3)[:, None]
        row.append(np.broadcast_to(dofs, block.shape).ravel())
        own = numbers[start : start + _CHUNK][:, None, None, :]
        column.append(np.broadcast_to(own, block.shape).ravel())
        value.append(-block.ravel())
        masses = np.einsum("mq,nq,cq->cmn", linear, linear, weights, optimize=True)
        mass.append((masses / first[part][:, None, None]).ravel())
    shape = (mesh.points.size, len(nodes))
    entries = (np.concatenate(value), (np.concatenate(row), np.concatenate(column)))
    low = np.repeat(numbers, 8, axis=1).ravel()
    high = np.tile(numbers, (1, 8)).ravel()
    upper = low <= high
    compliance = sp.coo_matrix(
        (np.concatenate(mass)[upper], (low[upper], high[upper])), shape=(len(nodes),) * 2
    )
    return Pressures(nodes, sp.coo_matrix(entries, shape=shape).tocsr(), compliance.tocsr())


def hex_trace(points: Array, faces: IntArray) -> ContactTrace:
    """The trace of contact faces (f, 9) with bilinear hats at their corners.

    As :func:`fingerdesign.fem.trace.contact_trace` has it of triangles; each face is reported as
    two triangles, of half its area, to what measures areas.
    """
    places, weights = gauss(2, 4)
    value, slope = shapes(places, 2)
    hats = shapes(places, 2, degree=1)[0]
    tangents = np.einsum("fna,nbq->fqab", points[faces], slope, optimize=True)
    measure = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=2) * weights
    corners = faces[:, [0, 2, 6, 8]]
    nodes, local = np.unique(corners, return_inverse=True)
    local = local.reshape(corners.shape)
    integral = np.einsum("iq,fq->fi", hats, measure)
    areas: Array = np.bincount(local.ravel(), integral.ravel()).astype(float)
    blocks = np.einsum("iq,nq,fq->fin", hats, value, measure, optimize=True)
    blocks /= areas[local][:, :, None]
    row = np.broadcast_to(local[:, :, None], blocks.shape).ravel()
    column = np.broadcast_to(faces[:, None, :], blocks.shape).ravel()
    scalar = sp.coo_matrix((blocks.ravel(), (row, column)), shape=(len(nodes), len(points)))
    entry = (hats[None] * measure[:, None, :]) / areas[local][:, :, None]
    number = np.arange(measure.size).reshape(len(faces), 1, -1)
    surface = SurfaceQuadrature(
        points=np.einsum("nq,fna->fqa", value, points[faces]).reshape(-1, 3),
        node=np.broadcast_to(local[:, :, None], entry.shape).ravel(),
        point=np.broadcast_to(number, entry.shape).ravel(),
        weight=entry.ravel(),
    )
    return ContactTrace(
        nodes=nodes,
        facets=np.vstack([local[:, [0, 1, 2]], local[:, [1, 3, 2]]]),
        facet_areas=np.tile(0.5 * measure.sum(axis=1), 2),
        areas=areas,
        operator=sp.kron(scalar, sp.identity(3), format="csr"),
        surface=surface,
    )
