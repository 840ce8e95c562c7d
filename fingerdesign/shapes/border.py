"""Where a face of a STEP body ends: is a point of its surface within, and how far is it beyond?

The border is cut into short cubic (Hermite) pieces, exact to h^4/(384 R^3) mm for pieces of length
h on a curve of radius R. Numpy; scipy finds the near pieces.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.shapes.quadrics import dot, unit

_NEAR = 8  # pieces looked at: those that meet in a corner, and their neighbours

_CORNER_MM = 1e-7  # places nearer to each other are the one corner where two pieces meet


@dataclass(frozen=True)
class Border:
    """Pieces from ``start`` to ``end`` (n, 3) with derivatives by a parameter from 0 to 1 there,
    and unit vectors in the face, toward its inside, at both ends; n = 0: a closed face."""

    start: Array
    end: Array
    leaving: Array
    arriving: Array
    inward_start: Array
    inward_end: Array

    def beyond(self, points: Array) -> Array:
        """Distance (n,) from points of the face's surface, (n, 3), to the face as it ends.

        0 within the face.
        """
        if not len(self.start) or not len(points):
            return np.zeros(len(points))
        flat, t, place, away = self._near(points)
        k = away.shape[1]
        slope, weight = self._curve(flat, t)[1], t[:, None]
        inward = (1.0 - weight) * self.inward_start[flat] + weight * self.inward_end[flat]
        inward = unit(inward - dot(inward, unit(slope))[:, None] * unit(slope))
        # Where two pieces meet in the nearest point, the sum of their directions tells inside.
        best = np.argmin(away, axis=1) + k * np.arange(len(points))
        apart = np.linalg.norm(place.reshape(len(points), k, 3) - place[best][:, None], axis=2)
        toward = ((apart < _CORNER_MM)[..., None] * inward.reshape(len(points), k, 3)).sum(axis=1)
        within = dot(points - place[best], toward) >= 0.0
        return np.asarray(np.where(within, 0.0, away.min(axis=1)))

    def distance(self, points: Array) -> Array:
        """Distance (n,) from any points (n, 3) to the border; infinite where there is none."""
        if not len(self.start) or not len(points):
            return np.full(len(points), np.inf)
        return np.asarray(self._near(points)[3].min(axis=1))

    def _near(self, points: Array) -> tuple[NDArray[Any], Array, Array, Array]:
        """Of k near pieces for each point: their numbers, the parameters (n k,) and places (n k, 3)
        nearest to it, and the distances (n, k)."""
        _, near = self._tree.query(points, k=min(_NEAR, len(self.start)))
        near = near.reshape(len(points), -1)
        k = near.shape[1]
        flat, p = near.ravel(), np.repeat(points, k, axis=0)
        a, chord = self.start[flat], self.end[flat] - self.start[flat]
        t = np.clip(dot(p - a, chord) / np.maximum(dot(chord, chord), 1e-300), 0.0, 1.0)
        for _ in range(2):  # onto the curve itself
            place, slope = self._curve(flat, t)
            t = t + dot(p - place, slope) / np.maximum(dot(slope, slope), 1e-300)
            t = np.clip(t, 0.0, 1.0)
        place = self._curve(flat, t)[0]
        return flat, t, place, np.linalg.norm(p - place, axis=1).reshape(len(points), k)

    def _curve(self, rows: NDArray[Any], t: Array) -> tuple[Array, Array]:
        """Places and derivatives (n, 3) of pieces at parameters (n,)."""
        t = t[:, None]
        a, b, da, db = (each[rows] for each in (self.start, self.end, self.leaving, self.arriving))
        place = (1 + 2 * t) * (1 - t) ** 2 * a + t**2 * (3 - 2 * t) * b
        place += t * (1 - t) ** 2 * da + t**2 * (t - 1) * db
        slope = 6 * t * (1 - t) * (b - a) + (1 - t) * (1 - 3 * t) * da + t * (3 * t - 2) * db
        return place, slope

    @cached_property
    def _tree(self) -> Any:
        from scipy.spatial import cKDTree

        return cKDTree(self._curve(np.arange(len(self.start)), np.full(len(self.start), 0.5))[0])
