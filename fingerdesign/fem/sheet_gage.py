"""What gages on sheets read: the stretch of the slot's faces, on which they are bonded.

And the strain inside such a plate, where a point is asked for: linear between its faces'.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import tabulate
from fingerdesign.fem.readout import gage_heights
from fingerdesign.fem.sheet_faces import SheetFacets, sheet_of

if TYPE_CHECKING:
    from fingerdesign.design.layout import PlateFrame
    from fingerdesign.design.schema import Gages
    from fingerdesign.mesh.types import Mesh

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

_INSIDE = 1e-6  # barycentric: a point on an edge belongs to both facets


def sheet_gage_rows(mesh: Mesh, frames: Sequence[PlateFrame], gages: Gages) -> sp.csr_matrix:
    """Rows (2 plates, n dim): mean strain along each plate over its gage, upper then lower face.

    The mean over the length is exact: the difference of the end displacements along the plate
    divided by the length. Across the width it is a Gauss rule in z (mid-plane mirrored).
    """
    heights, weights = gage_heights(gages)
    if mesh.symmetric:
        heights = np.abs(heights)
    rows = []
    for frame in frames:
        sheet = sheet_of(mesh, frame)
        for face in (sheet.nodes, sheet.nodes_below):
            total = sp.csr_matrix((1, mesh.points.size))
            for end in (0.5, -0.5):
                share = np.sign(end) / gages.length_mm
                place = end * gages.length_mm
                if mesh.dimension == 2:
                    total = total + share * _along(mesh, sheet, face, np.array([place]))
                    continue
                for weight, z in zip(weights, heights, strict=True):
                    row = _along(mesh, sheet, face, np.array([place, z]))
                    total = total + weight * share * row
            rows.append(total)
    if not rows:
        return sp.csr_matrix((0, mesh.points.size))
    return sp.vstack(rows, format="csr")


def plate_at(frames: Sequence[PlateFrame], point: Array) -> PlateFrame | None:
    """The plate in whose slot a point (dim,) lies, if any."""
    for frame in frames:
        along, off = frame.local(point[None, :2])[0]
        if abs(along) <= 0.5 * frame.length and abs(off) <= 0.5 * frame.thickness:
            return frame
    return None


def plate_strain_rows(
    mesh: Mesh, frame: PlateFrame, poissons_ratio: float, point: Array
) -> sp.csr_matrix:
    """Rows (6, n dim): xx, yy, zz, xy, xz, yz (engineering shear) at a point (dim,) in a plate.

    Strains along the plate are linear between its faces; across it there is no stress and no shear.
    """
    sheet, dimension = sheet_of(mesh, frame), mesh.dimension
    offset = point[:2] - np.array([frame.x, frame.y])
    place = np.append(offset @ frame.axis, point[2:])
    level = float(offset @ frame.normal) / frame.thickness
    facet, reference = _holding(sheet, place)
    slope = sheet.slopes(reference[:, None])[facet, 0]  # (k, a)
    size, count = sheet.dimension, len(slope)
    local = np.zeros((3, 3, 2, count, dimension))  # along, across, z
    axis_of = (0, 2)
    for a in range(size):
        for b in range(size):
            for side, share in enumerate((0.5 + level, 0.5 - level)):
                part = 0.5 * share * slope[:, a, None] * sheet.tangents[b]
                local[axis_of[a], axis_of[b], side] += part
                local[axis_of[b], axis_of[a], side] += part
    squeeze = poissons_ratio / (1.0 - poissons_ratio)
    local[1, 1] = -squeeze * (local[0, 0] + local[2, 2])
    turn = np.eye(3)
    turn[0, :2], turn[1, :2] = frame.axis, frame.normal
    strain = np.einsum("ai,bj,ab...->ij...", turn, turn, local)
    pairs = ((0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0), (0, 1, 2.0), (0, 2, 2.0), (1, 2, 2.0))
    rows = np.array([factor * strain[i, j].ravel() for i, j, factor in pairs])
    nodes = sheet.own[np.concatenate([sheet.nodes[facet], sheet.nodes_below[facet]])]
    dofs = (nodes[:, None] * dimension + np.arange(dimension)).ravel()
    where = (np.repeat(np.arange(6), len(dofs)), np.tile(dofs, 6))
    return sp.csr_matrix((rows.ravel(), where), shape=(6, mesh.points.size))


def _along(mesh: Mesh, sheet: SheetFacets, face: IntArray, place: Array) -> sp.csr_matrix:
    """Row (1, n dim): displacement along the plate at a place (s,) in the surface's coordinates,
    of the face with the facets ``face`` (f, k)."""
    facet, reference = _holding(sheet, place)
    value = tabulate(sheet.dimension, reference[:, None]).value[:, 0]
    dimension = mesh.dimension
    dofs = sheet.own[face[facet]][:, None] * dimension + np.arange(dimension)
    entries = np.outer(value, sheet.tangents[0])
    where = (np.zeros(dofs.size, dtype=int), dofs.ravel())
    return sp.csr_matrix((entries.ravel(), where), shape=(1, mesh.points.size))


def _holding(sheet: SheetFacets, place: Array) -> tuple[int, Array]:
    """The facet that holds a place (s,) in the surface's coordinates, and where in it (s,)."""
    offset = place - sheet.flat[:, 0]
    reference = np.einsum("fba,fa->fb", sheet.inverse, offset)
    least = np.minimum(reference.min(axis=1), 1.0 - reference.sum(axis=1))
    facet = int(np.argmax(least))
    if least[facet] < -_INSIDE:
        raise SolverError(f"{place.tolist()} mm from its plate's centre is off the plate")
    return facet, reference[facet]
