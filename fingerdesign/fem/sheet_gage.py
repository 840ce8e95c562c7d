"""What gages on sheets read: the stretch of the slot's faces, on which they are bonded.

And the strain inside such a plate, where a point is asked for: linear between its faces'.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import tabulate
from fingerdesign.fem.readout import gage_heights, gage_shares
from fingerdesign.fem.sheet_faces import SheetFacets, places_on, sheet_of

if TYPE_CHECKING:
    from fingerdesign.design.schema import Gages
    from fingerdesign.layout.frames import PlateFrame
    from fingerdesign.mesh.types import Mesh


_INSIDE = 1e-6  # barycentric: a point on an edge belongs to both facets


def sheet_gage_rows(mesh: Mesh, frames: Sequence[PlateFrame], gages: Gages) -> sp.csr_matrix:
    """Rows (2 plates, n dim): mean strain along each plate over its gage, upper then lower face.

    As ``readout.gage_rows`` has them for solid plates that are flat: exact along the plate, a Gauss
    rule across it about the plate's middle + z_mm.
    """
    rows = []
    for frame in frames:
        sheet = sheet_of(mesh, frame)
        points, vectors = _gage_places(mesh, frame, gages)
        places = places_on(frame, points)
        for face in (sheet.nodes, sheet.nodes_below):
            parts = [
                _displacement(mesh, sheet, face, place, vector)
                for place, vector in zip(places, vectors, strict=True)
            ]
            rows.append(sp.csr_matrix(sum(parts[1:], parts[0])))
    if not rows:
        return sp.csr_matrix((0, mesh.points.size))
    return sp.vstack(rows, format="csr")


def _gage_places(mesh: Mesh, frame: PlateFrame, gages: Gages) -> tuple[Array, Array]:
    """Points (k, dim) on the mid-surface, and the vectors (k, dim), 1/mm, whose products with a
    face's displacements there add up to the gage's strain; in a half model z < 0 is mirrored."""
    along, shares = gage_shares(frame, gages.length_mm, 0.0)
    where = frame.from_local(along, 0.0)
    if mesh.dimension == 2:
        return where, shares
    offsets, weights = gage_heights(gages)
    points = np.vstack([frame.to_space(where, frame.middle + offset) for offset in offsets])
    vectors = np.vstack([weight * frame.direction(shares) for weight in weights])
    if mesh.symmetric:
        turned = np.where(points[:, 2:] < 0.0, [1.0, 1.0, -1.0], 1.0)
        points, vectors = points * turned, vectors * turned
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
    place = places_on(frame, point[None])[0]
    level = float(frame.local(point[None])[0, 1]) / frame.thickness
    facet, reference = _holding(sheet, place)
    slope = sheet.slopes(reference[:, None])[facet, 0]  # (k, a)
    size, count = sheet.dimension, len(slope)
    local = np.zeros((3, 3, 2, count, dimension))  # along, through, across
    axis_of = (0, 2)
    for a in range(size):
        for b in range(size):
            for side, share in enumerate((0.5 + level, 0.5 - level)):
                part = 0.5 * share * slope[:, a, None] * sheet.tangents[b]
                local[axis_of[a], axis_of[b], side] += part
                local[axis_of[b], axis_of[a], side] += part
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


def _displacement(
    mesh: Mesh, sheet: SheetFacets, face: IntArray, place: Array, vector: Array
) -> sp.csr_matrix:
    """Row (1, n dim): product of ``vector`` (dim,) with the displacement at a place (s,) in the
    surface's coordinates, of the face with the facets ``face`` (f, k)."""
    facet, reference = _holding(sheet, place)
    value = tabulate(sheet.dimension, reference[:, None]).value[:, 0]
    dimension = mesh.dimension
    dofs = sheet.own[face[facet]][:, None] * dimension + np.arange(dimension)
    where = (np.zeros(dofs.size, dtype=int), dofs.ravel())
    return sp.csr_matrix((np.outer(value, vector).ravel(), where), shape=(1, mesh.points.size))


def _holding(sheet: SheetFacets, place: Array) -> tuple[int, Array]:
    """The facet that holds a place (s,) in the surface's coordinates, and where in it (s,)."""
    offset = place - sheet.flat[:, 0]
    reference = np.einsum("fba,fa->fb", sheet.inverse, offset)
    least = np.minimum(reference.min(axis=1), 1.0 - reference.sum(axis=1))
    facet = int(np.argmax(least))
    if least[facet] < -_INSIDE:
        raise SolverError(f"{place.tolist()} mm from its plate's centre is off the plate")
    return facet, reference[facet]
