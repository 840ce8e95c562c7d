"""Features of dead gages, completed from all others by how features go together (numpy only).

The network needs every feature, and a gage that is dead has none. If the features x (f,), in
standard deviations, are normal with the covariance C, those of dead gages D are most likely

    x_D = - P_DD^-1 P_DO x_O,     P = C^-1,   O: all others.

That leaves 0.44 of the standard deviation as an error on film_tees, and half the sum of both
neighbours 0.81. With a network that was trained on such sums, of 240 lifts with all faults, among
them a gage that dies, 233 are good at a median margin of 1.59; with sums 235 at 1.68.

A file holds the matrix as 16-bit integers below its diagonal, which is 1, and the roots apart:

    P_ij = root_i matrix_ij root_j
"""

from base64 import b64decode, b64encode
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.control.features import feature_count, gages_of, readings_at

LARGEST = 32767  # of 16 bits with a sign
# Added to each variance: what is known of a feature is never exact. 0.001 and 0.1 complete as well.
_UNKNOWN = 0.01


@dataclass(frozen=True)
class Relations:
    """Inverse covariance of the features: root (f,) > 0; matrix (f, f), symmetric, its diagonal 1;
    see the module."""

    root: Array
    matrix: Array
    # By which gages are dead: a hand meets the same ones step after step.
    _maps: dict[bytes, Array] = field(default_factory=dict, init=False, compare=False, repr=False)

    @classmethod
    def of(cls, rows: Array) -> Self:
        """Those of rows (n, f) of features in standard deviations; rows with dead gages, which are
        NaN, do not count."""
        whole = rows[np.isfinite(rows).all(axis=1)]
        covariance = whole.T @ whole / max(len(whole), 1) + _UNKNOWN * np.eye(rows.shape[1])
        precision = np.linalg.inv(covariance)
        root = np.sqrt(np.diag(precision))
        return cls.from_integers(root, in_integers(precision / np.outer(root, root)))

    @classmethod
    def of_neighbours(cls, gages: int) -> Self:
        """Half the sum of both neighbours, as files of former formats mean it."""
        count = feature_count(gages)
        matrix = np.eye(count)
        for first in readings_at(gages):
            for left in range(first, first + gages - 1):
                matrix[left, left + 1] = matrix[left + 1, left] = -0.5
        return cls(np.ones(count), matrix)

    @classmethod
    def from_integers(cls, root: Array, below: NDArray[np.int16]) -> Self:
        """From the roots, and the integers below the diagonal, row after row."""
        matrix = np.zeros((len(root), len(root)))
        matrix[np.tril_indices(len(root), -1)] = below.astype(float) / LARGEST
        return cls(root, matrix + matrix.T + np.eye(len(root)))

    @classmethod
    def from_record(cls, record: dict[str, Any]) -> Self:
        """Read what :meth:`to_record` wrote. ValueError, KeyError or TypeError for another one."""
        below = np.frombuffer(b64decode(record["matrix_base64"], validate=True), "<i2")
        return cls.from_integers(np.array(record["root"], dtype=float), below)

    def to_record(self) -> dict[str, Any]:
        """Plain values for a file."""
        integers = in_integers(self.matrix).astype("<i2").tobytes()
        root = [float(f"{value:.9g}") for value in self.root.tolist()]
        return {"root": root, "matrix_base64": b64encode(integers).decode("ascii")}

    def completed(self, rows: Array) -> Array:
        """Rows (n, f) with numbers in place of NaN, those of the gages that are dead in a row."""
        found, dead = np.array(rows), np.isnan(rows)
        for one in np.unique(dead[dead.any(axis=1)], axis=0) if len(dead) > 1 else dead:
            own = np.flatnonzero((dead == one).all(axis=1))
            found[np.ix_(own, one)] = np.where(one, 0.0, rows[own]) @ self._map(one).T
        return found

    def _map(self, dead: NDArray[np.bool_]) -> Array:
        """Matrix (d, f) from all features, 0 where they are dead, to the dead ones."""
        key = dead.tobytes()
        if key not in self._maps:
            both = self.matrix[np.ix_(dead, dead)] * self.root[dead]
            self._maps[key] = np.asarray(-np.linalg.solve(both, self.matrix[dead] * self.root))
        return self._maps[key]

    def fault(self, features: int) -> str:
        """The first fault of its numbers, in words; "" without one."""
        if self.root.shape != (features,) or self.matrix.shape != (features, features):
            return f"relations are not of {features} features"
        if not (np.isfinite(self.root) & (self.root > 0.0)).all():
            return "a root of the relations is not above 0"
        own = [*range(gages_of(features))]
        kinds = np.add.outer(own, readings_at(len(own)))
        blocks = self.matrix[kinds[:, :, None], kinds[:, None, :]]
        if not (np.linalg.eigvalsh(blocks) > 0.0).all():
            return "the relations of a gage's features are not positive definite"
        return ""


def in_integers(matrix: Array) -> NDArray[np.int16]:
    """The part below the diagonal of a matrix (f, f), row after row, as 16-bit integers."""
    below = matrix[np.tril_indices(len(matrix), -1)]
    return np.rint(LARGEST * below).clip(-LARGEST, LARGEST).astype(np.int16)
