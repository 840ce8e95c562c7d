"""What gages on sheets read: the mid-surface's stretch, and its bending at half the thickness.

    upper, lower = [u_s]/length -+ (t/2) [dw/ds]/length

with [.] the difference between the gage's ends, u_s the displacement along the plate and w that
toward the upper side. Both means over the gage's length are exact; the slope at an end is the mean
of those of the facets that meet there.
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
from fingerdesign.fem.sheet import SheetFacets, sheet_of

if TYPE_CHECKING:
    from fingerdesign.design.layout import PlateFrame
    from fingerdesign.design.schema import Gages
    from fingerdesign.mesh.types import Mesh

Array = NDArray[np.float64]

_INSIDE = 1e-6  # barycentric: a point on an edge belongs to both facets


def sheet_gage_rows(mesh: Mesh, frames: Sequence[PlateFrame], gages: Gages) -> sp.csr_matrix:
    """Rows (2 plates, n dim): mean strain along each plate over its gage, upper then lower face."""
    heights, weights = gage_heights(gages)
    rows = []
    for frame in frames:
        sheet = sheet_of(mesh, frame)
        stretch = sp.csr_matrix((1, mesh.points.size))
        turn = sp.csr_matrix((1, mesh.points.size))
        for end in (0.5, -0.5):
            share = np.sign(end) / gages.length_mm
            if mesh.dimension == 2:
                places = [(1.0, np.array([end * gages.length_mm]))]
            else:
                zs = np.abs(heights) if mesh.symmetric else heights
                places = [
                    (w, np.array([end * gages.length_mm, z]))
                    for w, z in zip(weights, zs, strict=True)
                ]
            for weight, place in places:
                along, slope = _row_pair(sheet, place, mesh.points.size)
                stretch = stretch + weight * share * along
                turn = turn + weight * share * slope
        half = 0.5 * frame.thickness
        rows += [stretch - half * turn, stretch + half * turn]
    if not rows:
        return sp.csr_matrix((0, mesh.points.size))
    return sp.vstack(rows, format="csr")


def _row_pair(sheet: SheetFacets, place: Array, size: int) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Rows (1, size) of u_s and dw/ds at a place (s,) in the surface's coordinates."""
    offset = place - sheet.flat[:, 0]
    reference = np.einsum("fba,fa->fb", sheet.inverse, offset)
    least = np.minimum(reference.min(axis=1), 1.0 - reference.sum(axis=1))
    holding = np.flatnonzero(least >= -_INSIDE)
    if len(holding) == 0:
        raise SolverError(f"a gage's end at {place.tolist()} mm from its plate's centre is off it")
    dimension = len(sheet.normal)
    share = 1.0 / len(holding)
    columns, along, slope = [], [], []
    for facet in holding:
        table = tabulate(sheet.dimension, reference[facet][:, None])
        gradient = table.gradient[:, :, 0] @ sheet.inverse[facet][:, 0]  # d/ds of each node
        columns.append((sheet.nodes[facet][:, None] * dimension + np.arange(dimension)).ravel())
        along.append(share * np.outer(table.value[:, 0], sheet.tangents[0]).ravel())
        slope.append(share * np.outer(gradient, sheet.normal).ravel())
    where = (np.zeros(sum(map(len, columns)), dtype=int), np.concatenate(columns))
    return (
        sp.csr_matrix((np.concatenate(along), where), shape=(1, size)),
        sp.csr_matrix((np.concatenate(slope), where), shape=(1, size)),
    )
