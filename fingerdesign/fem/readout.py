"""Linear functionals of the displacement: strains at points, and what the gages read."""

from collections.abc import Sequence
from itertools import product

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.gages import Gages
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.fem.elements import inverse_map, jacobians, margin, quadrature, tabulate
from fingerdesign.fem.sheet import SheetFacets, places_on, sheet_of
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.types import Mesh

_INSIDE = 1e-6  # barycentric: a point on a face or an edge belongs to both cells or facets
_NEAR = 0.02  # barycentric: a point just outside a curved or snapped boundary
_ZERO = 1e-12  # A smaller shape function is zero but for rounding.
_BENT = 0.1  # Barycentric: a bent plate's face may lie so far outside its own straight cells.
_STRAIN_ROWS = ((0, 3, 4), (3, 1, 5), (4, 5, 2))  # of xx, yy, zz, xy, xz, yz: by a and b of ab
_GAUSS_POINTS = 6  # across a gage's width, and along it where its plate is bent


def _holding_cells(
    mesh: Mesh, points: Array, cells: IntArray
) -> tuple[IntArray, IntArray, Array, Array]:
    """Pairs of a point (p, dim) and a cell whose box holds it: their numbers, reference coordinates
    (dim, pairs) and the least barycentric ones (pairs,), < 0 outside the cell."""
    corners = mesh.points[mesh.corners[cells]]
    low, high = corners.min(axis=1), corners.max(axis=1)
    room = 0.05 * (high - low).max(axis=1, keepdims=True) + 1e-9
    low, high = low - room, high + room
    point, near = np.nonzero(((points[:, None] >= low) & (points[:, None] <= high)).all(axis=2))
    reference = inverse_map(mesh.kind, mesh.points[mesh.cells[cells[near]]], points[point])
    return point, cells[near], reference, margin(mesh.kind, reference)


def locate(mesh: Mesh, point: Array) -> IntArray:
    """Cells holding a point (dim,); on the border of several regions those of the highest (a plate
    before the elastomer). Raises DesignError for a point outside the mesh."""
    _, cells, _, least = _holding_cells(mesh, point[None], np.arange(len(mesh.cells)))
    inside = least >= -_INSIDE
    if not inside.any():
        if least.max(initial=-np.inf) < -_NEAR:
            place = [round(float(v), 6) for v in point]
            raise DesignError(
                [Fault("readout.points_mm", place, "inside the finger", "move the point inward")]
            )
        inside = least == least.max()
    regions = mesh.regions[cells]
    return np.asarray(cells[inside & (regions == regions[inside].max())])


def displacement_rows(mesh: Mesh, points: Array, region: int | None = None) -> sp.csr_matrix:
    """Rows (p dim, n dim): the displacements at points (p, dim) of a region; of the whole mesh
    where none is named or none has that number. SolverError for a point outside."""
    own = np.flatnonzero(mesh.regions == region)
    own = own if len(own) else np.arange(len(mesh.cells))  # few cells: a hundred times faster
    point, cells, reference, least = _holding_cells(mesh, points, own)
    best = np.lexsort((least, point))
    best = best[np.diff(point[best], append=-1) != 0]
    if len(best) < len(points) or least[best].min(initial=0.0) < -_BENT:
        raise SolverError("a point to be read lies outside of its part's mesh")
    value = tabulate(mesh.kind, reference[:, best]).value.T
    return _interpolated(mesh, mesh.cells[cells[best]], value)


def _interpolated(mesh: Mesh, nodes: IntArray, value: Array) -> sp.csr_matrix:
    """Rows (p dim, n dim): displacements where nodes (p, k) have the shape functions ``value``."""
    if mesh.moved:  # So that rows have the same places on any mesh with these cells.
        value = np.where(np.abs(value) < _ZERO, 0.0, value)
    axes = np.arange(mesh.dimension)
    columns = nodes[:, :, None] * mesh.dimension + axes
    rows = np.arange(len(nodes))[:, None, None] * mesh.dimension + axes
    entries = [np.broadcast_to(each, columns.shape).ravel() for each in (value[..., None], rows)]
    shape = (len(nodes) * mesh.dimension, mesh.points.size)
    return sp.csr_matrix((entries[0], (entries[1], columns.ravel())), shape=shape)


def plate_displacements(
    mesh: Mesh, frame: PlateFrame, points: Array, v: float | Array
) -> sp.csr_matrix:
    """Rows (p dim, n dim): displacements at points (p, dim) on a plate's faces at ``v`` (mm along
    its normal; one, or (p,)); in a half model those at z < 0 mirror those at z > 0."""
    turn = np.ones_like(points)
    if mesh.symmetric:
        turn[points[:, 2] < 0.0, 2] = -1.0
    if f"plate_{frame.index}_upper" not in mesh.facets:
        rows = displacement_rows(mesh, points * turn, frame.index + 1)
    else:
        sheet = sheet_of(mesh, frame)
        facet, reference = _holding(sheet, places_on(frame, points * turn))
        upper = np.broadcast_to(v, len(points))[:, None] > 0.0
        nodes = np.where(upper, sheet.nodes[facet], sheet.nodes_below[facet])
        value = tabulate(sheet.kind, reference.T).value.T
        rows = _interpolated(mesh, sheet.own[nodes], value)
    return sp.csr_matrix(sp.diags_array(turn.ravel()) @ rows)


def strain_rows(mesh: Mesh, point: Array) -> sp.csr_matrix:
    """Rows (6, n dim): xx, yy, zz, xy, xz, yz (engineering shear) at a point, recovered.

    A quadratic polynomial is fitted to the strains at the Gauss points of the surrounding cells of
    the same region, where quadratic elements are one order more accurate than elsewhere
    (superconvergent patch recovery: Zienkiewicz and Zhu, IJNME 33 (1992) 1331).
    """
    patch = _patch(mesh, locate(mesh, point))
    nodes = mesh.cells[patch]
    table = tabulate(mesh.kind, *quadrature(mesh.kind, 2))
    jacobian = jacobians(mesh.points[nodes], table.gradient)
    slopes = np.einsum("nbq,cqba->cqna", table.gradient, np.linalg.inv(jacobian), optimize=True)
    where = np.einsum("nq,cna->cqa", table.value, mesh.points[nodes], optimize=True)
    samples = where.reshape(-1, mesh.dimension)
    if mesh.symmetric and np.abs(mesh.points[nodes][:, :, 2]).min() < 1e-9:
        # The patch goes on beyond the mirror plane, where odd components change their sign.
        mirrored = samples * [1.0, 1.0, -1.0]
        both = _value_at_origin(np.vstack([samples, mirrored]) - point)
        here, there = both.reshape(2, *where.shape[:2])
    else:
        here = _value_at_origin(samples - point).reshape(where.shape[:2])
        there = np.zeros_like(here)
    even = np.einsum("cq,cqna->cna", here + there, slopes)  # d/dx_a of the field, per cell node
    odd = np.einsum("cq,cqna->cna", here - there, slopes)
    return _strain_from_gradient(mesh, nodes, even, odd)


def _patch(mesh: Mesh, cells: IntArray) -> IntArray:
    """Cells of the region that touch ``cells``, widened until a quadratic is well determined."""
    same = np.flatnonzero(mesh.regions == mesh.regions[cells[0]])
    enough = 3 * (6 if mesh.dimension == 2 else 10)  # samples against polynomial terms
    per_cell = mesh.kind.corners  # samples of quadrature of order 2
    patch = cells
    for _ in range(4):
        touched = np.isin(mesh.corners[same], mesh.corners[patch]).any(axis=1)
        patch = same[touched]
        if len(patch) * per_cell >= enough:
            break
    return patch


def _value_at_origin(offsets: Array) -> Array:
    """Weights (s,) of samples at ``offsets`` (s, dim) in the fitted quadratic's value at 0."""
    scale = np.abs(offsets).max(axis=0)
    scaled = offsets / np.maximum(scale, 1e-12 * scale.max())
    dimension = offsets.shape[1]
    squares = [scaled[:, a] * scaled[:, b] for a in range(dimension) for b in range(a, dimension)]
    basis = np.column_stack([np.ones(len(offsets)), scaled, *squares])
    return np.asarray(np.linalg.pinv(basis, rcond=1e-8)[0])


def _strain_from_gradient(mesh: Mesh, nodes: IntArray, even: Array, odd: Array) -> sp.csr_matrix:
    """Strain rows of recovered gradients; du_a/dx_b is odd in z where just one of a, b is z."""
    dimension, entries = mesh.dimension, []
    for a, b in product(range(dimension), repeat=2):
        value = (odd if (a == 2) != (b == 2) else even)[:, :, b].ravel()
        row = np.full(value.shape, _STRAIN_ROWS[a][b])
        entries.append((value, row, (nodes * dimension + a).ravel()))
    values, rows, columns = (np.concatenate(each) for each in zip(*entries, strict=True))
    return sp.csr_matrix((values, (rows, columns)), shape=(6, mesh.points.size))


def gage_rows(
    mesh: Mesh, frames: Sequence[PlateFrame], gages: Gages, weights: tuple[float, float]
) -> sp.csr_matrix:
    """Rows (2 plates, n dim): what the gages read, upper then lower face.

    weights: of the mean strains along the plate and across it, over the same rectangle (see
    :meth:`Gages.weights`); in plane strain there is none across. A plate that is a sheet has its
    gages on the faces of its slot.
    Of a flat plate the mean over the length is exact: the difference of the end displacements along
    the plate divided by the length. On a bent one, with rho the radius of the face that carries the
    gage, the strain along it is du_t/ds + u_n / rho: the first part is again a difference of end
    displacements, the second a Gauss rule along the face. ``gages.length_mm`` is measured on that
    face. Across the width it is a Gauss rule about the plate's middle + z_mm. The strain across is
    the difference over the width, by a Gauss rule along the face.
    """
    rows = []
    for frame in frames:
        faces = np.array([0.5, -0.5]) * frame.thickness
        places = [_gage_places(mesh, frame, gages, v, weights) for v in faces]
        points, vectors = (np.concatenate(each) for each in zip(*places, strict=True))
        moved = plate_displacements(mesh, frame, points, np.repeat(faces, len(points) // 2))
        rows.append(sp.block_diag(list(vectors.reshape(2, 1, -1)), format="csr") @ moved)
    found = sp.vstack([sp.csr_matrix((0, mesh.points.size)), *rows], format="csr")
    pairs = pairing(frames, gages)
    return found if pairs is None else sp.csr_matrix(pairs @ found)


def pairing(frames: Sequence[PlateFrame], gages: Gages) -> sp.csr_matrix | None:
    """Matrix (2 plates, 2 plates) that takes strains to the readings of bridges of two plates.

    A pair reads half of the strain of the plate at a positive angle less that of the other, face by
    face, at both plates' places. None where each plate has a bridge of its own. Raises ValueError
    where one plate of a pair is missing.
    """
    if gages.grid != "double_axial":
        return None
    numbers = [frame.index for frame in frames]
    halves = zip(numbers[::2], numbers[1::2], strict=False)
    if len(numbers) % 2 or any(one % 2 or two != one + 1 for one, two in halves):
        raise ValueError(f"plates {numbers} are no whole pairs")
    signs = [0.5 * np.sign(np.sin(np.radians(2.0 * frame.angle_deg))) for frame in frames]
    blocks = [
        np.kron([[one, two], [one, two]], np.eye(2))
        for one, two in zip(signs[::2], signs[1::2], strict=True)
    ]
    return sp.block_diag([sp.csr_matrix((0, 0)), *blocks], format="csr")


def gage_heights(gages: Gages) -> tuple[Array, Array]:
    """Gauss points across a gage's width, mm from its plate's middle, and their shares (sum 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    return gages.z_mm + 0.5 * gages.width_mm * nodes, 0.5 * weights


def gage_shares(frame: PlateFrame, length: float, v: float) -> tuple[Array, Array]:
    """Mean strain of a gage as a sum of displacements: places s (k,) on the face at ``v``, and the
    section-plane vectors (k, 2), 1/mm, whose products with the displacements there add up to it."""
    if frame.bend_radius is None:
        places = np.array([0.5, -0.5]) * length
        return places, np.outer([1.0 / length, -1.0 / length], frame.axis)
    radius = frame.bend_radius + v
    end = 0.5 * length * frame.bend_radius / radius  # s is measured along the mid-surface
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    inner = [frame.upward(s) * w for s, w in zip(end * nodes, 0.5 * weights / radius, strict=True)]
    ends = [frame.tangent(end) / length, -frame.tangent(-end) / length]
    return np.concatenate([[end, -end], end * nodes]), np.array([*ends, *inner])


def gage_crossing(frame: PlateFrame, gages: Gages, v: float) -> tuple[Array, Array, Array]:
    """Both ends (2, k, 3), mm, at + and - of k lines across a gage on the face at ``v``, their
    shares (k,) of its length (sum 1), and their direction (3,)."""
    reach = 0.5 * gages.length_mm
    if frame.bend_radius is not None:  # s is measured along the mid-surface
        reach *= frame.bend_radius / (frame.bend_radius + v)
    nodes, shares = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    where, middle = frame.from_local(reach * nodes, v), frame.middle + gages.z_mm
    ends = [frame.to_space(where, middle + half * gages.width_mm) for half in (0.5, -0.5)]
    return np.array(ends), 0.5 * shares, frame.to_space(np.zeros(2), 1.0)[0]


def _gage_places(
    mesh: Mesh, frame: PlateFrame, gages: Gages, v: float, weights: tuple[float, float]
) -> tuple[Array, Array]:
    """Points (k, dim) on the face at ``v`` (mm, along the normal), and the vectors (k, dim), 1/mm,
    whose products with the displacements there add up to the gage's reading."""
    along, shares = gage_shares(frame, gages.length_mm, v)
    where, shares = frame.from_local(along, v), weights[0] * shares
    if mesh.dimension == 2:
        return where, shares
    offsets, heights = gage_heights(gages)
    points = np.vstack([frame.to_space(where, frame.middle + offset) for offset in offsets])
    vectors = np.vstack([weight * frame.direction(shares) for weight in heights])
    if weights[1] != 0.0:
        ends, parts, across = gage_crossing(frame, gages, v)
        pull = weights[1] / gages.width_mm * np.outer(parts, across)
        points, vectors = np.vstack([points, *ends]), np.vstack([vectors, pull, -pull])
    return points, vectors


def plate_at(frames: Sequence[PlateFrame], point: Array) -> PlateFrame | None:
    """The plate in whose slot a point (dim,) lies, if any."""
    for frame in frames:
        along, off = np.abs(frame.local(point[None])[0])
        within = along <= 0.5 * frame.length and off <= 0.5 * frame.thickness
        if within and len(point) == 3:
            within = bool(frame.low <= frame.across(point[None])[0] <= frame.high)
        if within:
            return frame
    return None


def plate_strain_rows(
    mesh: Mesh, frame: PlateFrame, poissons_ratio: float, point: Array
) -> sp.csr_matrix:
    """Rows (6, n dim): xx, yy, zz, xy, xz, yz (engineering shear) at a point (dim,) in a plate.

    Strains along the plate are linear between its faces; across it there is no stress and no shear.
    """
    sheet, dimension = sheet_of(mesh, frame), mesh.dimension
    level = float(frame.local(point[None])[0, 1]) / frame.thickness
    (facet,), reference = _holding(sheet, places_on(frame, point[None]))
    slope = sheet.slopes(reference.T)[facet, 0]  # (k, a)
    local = np.zeros((3, 3, 2, len(slope), dimension))  # along, through, across
    axes = list(enumerate((0, 2)[: sheet.dimension]))
    for (a, one), (b, two) in product(axes, repeat=2):
        for side, share in enumerate((0.5 + level, 0.5 - level)):
            part = 0.5 * share * slope[:, a, None] * sheet.tangents[b]
            local[one, two, side] += part
            local[two, one, side] += part
    squeeze = poissons_ratio / (1.0 - poissons_ratio)
    local[1, 1] = -squeeze * (local[0, 0] + local[2, 2])
    vectors = frame.direction(np.stack([frame.axis, frame.normal]))
    turn = np.vstack([vectors, frame.to_space(np.zeros(2), 1.0)])
    strain = np.einsum("ai,bj,ab...->ij...", turn, turn, local)
    pairs = ((0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0), (0, 1, 2.0), (0, 2, 2.0), (1, 2, 2.0))
    rows = np.array([factor * strain[i, j].ravel() for i, j, factor in pairs])
    nodes = sheet.own[np.concatenate([sheet.nodes[facet], sheet.nodes_below[facet]])]
    dofs = (nodes[:, None] * dimension + np.arange(dimension)).ravel()
    where = (np.repeat(np.arange(6), len(dofs)), np.tile(dofs, 6))
    return sp.csr_matrix((rows.ravel(), where), shape=(6, mesh.points.size))


def _holding(sheet: SheetFacets, places: Array) -> tuple[IntArray, Array]:
    """The facets (p,) that hold places (p, s) in the surface's coordinates, and where (p, s)."""
    offset = places[:, None] - sheet.flat[:, 0]
    reference = np.einsum("fba,pfa->pfb", sheet.inverse, offset)
    least = margin(sheet.kind, np.moveaxis(reference, 2, 0))
    facet = least.argmax(axis=1)
    off = least.max(axis=1) < -_INSIDE
    if off.any():
        raise SolverError(f"{places[off][0].tolist()} mm from its plate's centre is off the plate")
    return facet, reference[np.arange(len(facet)), facet]
