"""Gage readings at finite strain: the elongation of the gage's own lines on the plate.

    strain = mean over the lines of (length now / length at rest) - 1

for lines between the gage's two ends on the plate's face, distributed over its width; along a bent
plate a line is a chain of chords. Strain across the plate is that of lines across it. A turned
plate reads nothing. To first order this is the small-strain reading of
:func:`fingerdesign.fem.readout.gage_rows` (of a bent plate to 1e-6 of it: chords for arcs).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array
from fingerdesign.design.gages import Gages
from fingerdesign.errors import SolverError
from fingerdesign.fem.readout import gage_crossing, gage_heights, pairing, plate_displacements
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.types import Mesh

_CHORDS = 12  # Chords that replace the arc of a bent plate's line.


@dataclass(frozen=True)
class _Lines:
    """Lines (g, k, chords + 1) of points on the plates' faces, along them or across.

    places (g k p, dim) mm at rest; rows (g k p dim, n dim): their displacements; weights (k,):
    what a gage's lines count in its reading; shape (g, k, p), g = 2 plates: upper, lower of each.
    """

    places: Array
    rows: sp.csr_matrix
    weights: Array
    shape: tuple[int, int, int]

    def strains(self, displacement: Array) -> Array:
        """Weighted strains (g,) at nodal displacements (n, dim), mm."""
        start, change = (
            np.diff(each.reshape(*self.shape, self.places.shape[1]), axis=2)
            for each in (self.places, np.asarray(self.rows @ displacement.ravel()))
        )
        before = np.linalg.norm(start, axis=-1)
        # |a + b| - |a| without a difference of nearly equal numbers
        after = np.linalg.norm(start + change, axis=-1)
        longer = np.sum(change * (2.0 * start + change), axis=-1) / (after + before)
        strain = longer.sum(axis=2) / before.sum(axis=2)
        return np.asarray(strain @ self.weights)


@dataclass(frozen=True)
class GageLines:
    """All lines whose strains add up to the plates' readings; pairs: see readout.pairing."""

    parts: tuple[_Lines, ...]
    pairs: sp.csr_matrix | None

    def strains(self, displacement: Array) -> Array:
        """Plain readings (plates, 2), upper and lower, at nodal displacements (n, dim), mm."""
        found = sum(part.strains(displacement) for part in self.parts)
        return np.asarray(found if self.pairs is None else self.pairs @ found).reshape(-1, 2)


def gage_lines(
    mesh: Mesh, frames: Sequence[PlateFrame], gages: Gages, weights: tuple[float, float]
) -> GageLines:
    """The lines of all plates' gages; weights: of strain along and across the plates. Raises
    SolverError for plates that are modelled as sheets."""
    if any(name.startswith("plate_") for name in mesh.facets):
        raise SolverError(
            'plates.model = "sheet": finite strain reads gages on solid plates; '
            'set plates.model = "solid"'
        )
    solid = mesh.dimension == 3
    offsets, heights = gage_heights(gages) if solid else (np.zeros(1), np.ones(1))
    pieces = 1 if all(frame.bend_radius is None for frame in frames) else _CHORDS
    faces = [(frame, side * frame.thickness) for frame in frames for side in (0.5, -0.5)]
    along = [_along(frame, gages.length_mm, v, pieces, offsets, solid) for frame, v in faces]
    parts = [_lines(mesh, frames, along, weights[0] * heights)]
    if solid and weights[1] != 0.0 and frames:
        across = [gage_crossing(frame, gages, v)[0].swapaxes(0, 1) for frame, v in faces]
        shares = gage_crossing(frames[0], gages, 0.0)[1]
        parts.append(_lines(mesh, frames, across, weights[1] * shares))
    return GageLines(tuple(parts), pairing(frames, gages))


def _lines(
    mesh: Mesh, frames: Sequence[PlateFrame], places: Sequence[Array], weights: Array
) -> _Lines:
    """Lines of points (k, p, dim), one array a face of each plate."""
    rows = [sp.csr_matrix((0, mesh.points.size))]
    for number, lines in enumerate(places):
        flat = lines.reshape(-1, mesh.dimension)
        rows.append(plate_displacements(mesh, frames[number // 2], flat, 0.0))
    points = np.array(places).reshape(-1, mesh.dimension)
    count = points.shape[0] // max(len(places) * len(weights), 1)
    shape = (len(places), len(weights), count)
    return _Lines(points, sp.vstack(rows, format="csr"), weights, shape)


def _along(
    frame: PlateFrame, length: float, v: float, pieces: int, offsets: Array, solid: bool
) -> Array:
    """Points (k, pieces + 1, dim) of the lines of a gage of ``length`` mm on the face at ``v``."""
    if frame.bend_radius is not None:  # s is measured along the mid-surface
        length *= frame.bend_radius / (frame.bend_radius + v)
    line = frame.from_local(np.linspace(-0.5, 0.5, pieces + 1) * length, v)
    at = frame.middle + offsets
    return np.array([frame.to_space(line, z) for z in at] if solid else [line])
