"""What a gage reads at finite strain: how much longer its own line on the plate has become.

    strain = mean over the width of (length now / length at rest) - 1

for the line between the gage's two ends on the plate's face; along a bent plate the line is a chain
of chords. A turned plate reads nothing. To first order this is the small-strain reading of
:func:`fingerdesign.fem.readout.gage_rows` (of a bent plate to 1e-6 of it: chords for arcs).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array
from fingerdesign.errors import SolverError
from fingerdesign.fem.readout import displacement_rows, gage_heights

if TYPE_CHECKING:
    from fingerdesign.design.schema import Gages
    from fingerdesign.layout.frames import PlateFrame
    from fingerdesign.mesh.types import Mesh


_CHORDS = 12  # of a bent plate's line


@dataclass(frozen=True)
class GageLines:
    """Lines (g, widths, chords + 1) of points on the plates' faces.

    places (g w p, dim) mm at rest; rows (g w p dim, n dim): their displacements; weights (w,):
    shares of the lines across a gage's width; shape (g, w, p), g = 2 plates: upper, lower of each.
    """

    places: Array
    rows: sp.csr_matrix
    weights: Array
    shape: tuple[int, int, int]

    def strains(self, displacement: Array) -> Array:
        """Plain strains (plates, 2), upper and lower, at nodal displacements (n, dim), mm."""
        moved = np.asarray(self.rows @ displacement.ravel()).reshape(self.places.shape)
        start = np.diff(self.places.reshape(*self.shape, self.places.shape[1]), axis=2)
        change = np.diff(moved.reshape(*self.shape, self.places.shape[1]), axis=2)
        before = np.linalg.norm(start, axis=-1)
        # |a + b| - |a| without a difference of nearly equal numbers
        after = np.linalg.norm(start + change, axis=-1)
        longer = np.sum(change * (2.0 * start + change), axis=-1) / (after + before)
        strain = longer.sum(axis=2) / before.sum(axis=2)
        return np.asarray((strain @ self.weights).reshape(-1, 2))


def gage_lines(mesh: Mesh, frames: Sequence[PlateFrame], gages: Gages) -> GageLines:
    """The lines of all plates' gages. Raises SolverError for plates that are modelled as sheets."""
    if any(name.startswith("plate_") for name in mesh.facets):
        raise SolverError(
            'plates.model = "sheet": finite strain reads gages on solid plates; '
            'set plates.model = "solid"'
        )
    offsets, weights = gage_heights(gages)
    if mesh.dimension == 2:
        offsets, weights = offsets[:1], np.ones(1)
    pieces = 1 if all(frame.bend_radius is None for frame in frames) else _CHORDS
    places: list[Array] = [np.empty((0, mesh.dimension))]
    rows: list[sp.csr_matrix] = [sp.csr_matrix((0, mesh.points.size))]
    for frame in frames:
        for side in (0.5, -0.5):
            line = _line(frame, gages.length_mm, side * frame.thickness, pieces)
            for offset in offsets:
                where = line
                if mesh.dimension == 3:
                    where = frame.to_space(line, frame.middle + float(offset))
                places.append(where)
                rows += [_displacement(mesh, point, frame.index + 1) for point in where]
    shape = (2 * len(frames), len(weights), pieces + 1)
    return GageLines(np.concatenate(places), sp.vstack(rows, format="csr"), weights, shape)


def _line(frame: PlateFrame, length: float, v: float, pieces: int) -> Array:
    """Points (pieces + 1, 2) of a gage of ``length`` mm on the face at ``v``, in its section."""
    if frame.bend_radius is not None:  # s is measured along the mid-surface
        length *= frame.bend_radius / (frame.bend_radius + v)
    return frame.from_local(np.linspace(-0.5, 0.5, pieces + 1) * length, v)


def _displacement(mesh: Mesh, point: Array, prefer: int) -> sp.csr_matrix:
    """Rows (dim, n dim): the displacement at a point, beyond the mirror plane its image's."""
    if not mesh.symmetric or point[2] >= 0.0:
        return displacement_rows(mesh, point, prefer)
    turn = np.array([1.0, 1.0, -1.0])
    return sp.csr_matrix(sp.diags_array(turn) @ displacement_rows(mesh, point * turn, prefer))
