"""Cutting a tetrahedral mesh along a plate's mid-surface: what is to be cut, by nodes alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.layout import PlateFrame
from fingerdesign.errors import MeshError
from fingerdesign.mesh.types import TETRA_FACETS

_ON = 1e-7  # mm: snapped nodes lie on their planes to rounding
_FILLED = 1e-6  # relative: what is missing is a facet or nothing


@dataclass(frozen=True)
class Cut:
    """Where a mesh is to be opened for one plate, by numbers of its nodes (see slot_rim.py).

    sheet (f, 3): F, its normal to the plate's upper side; wings (w, 3): two rim nodes, then the far
    one; flaps (p, 3): a rim node, then two far ones.
    """

    sheet: IntArray
    wings: IntArray
    flaps: IntArray

    @property
    def facets(self) -> IntArray:
        """Sheet, wings and flaps, (f + w + p, 3)."""
        return np.vstack([self.sheet, self.wings, self.flaps])

    @property
    def nodes(self) -> IntArray:
        """Nodes that become an upper and a lower one."""
        return np.unique(self.sheet)


@dataclass(frozen=True)
class Stars:
    """Which tetrahedra are around each node: ``tets[start[i]:start[i + 1]]``."""

    cells: IntArray
    start: IntArray
    tets: IntArray

    @classmethod
    def of(cls, cells: IntArray, count: int) -> Stars:
        flat = cells.ravel()
        order = np.argsort(flat, kind="stable")
        start = np.searchsorted(flat[order], np.arange(count + 1))
        return cls(cells, start, order // 4)

    def around(self, node: int) -> IntArray:
        """Numbers of the tetrahedra that have a node."""
        return np.asarray(self.tets[self.start[node] : self.start[node + 1]])


def outer_facets(cells: IntArray) -> IntArray:
    """Corners (f, 3) of the facets that belong to one tetrahedron only."""
    facets = cells[:, np.array(TETRA_FACETS)].reshape(-1, 3)
    _, first, uses = np.unique(
        np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True
    )
    return np.asarray(facets[first[uses == 1]])


def sheet_facets_of(
    points: Array, cells: IntArray, carrier: BoolArray, frame: PlateFrame
) -> IntArray:
    """F: facets (f, 3) on a plate's mid-surface, their normals to the upper side.

    carrier (t,): the tetrahedra of the plate's carrier box. MeshError where they do not fill it.
    """
    own = cells[carrier]
    facets = own[:, np.array(TETRA_FACETS)].reshape(-1, 3)
    on = np.abs(frame.local(points)[:, 1]) < _ON
    facets = facets[on[facets].all(axis=1)]
    _, first, uses = np.unique(
        np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True
    )
    facets = facets[first[uses == 1]]
    a, b, c = (points[facets[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    up = normal @ frame.direction(frame.normal)
    facets = np.where(up[:, None] > 0.0, facets, facets[:, [0, 2, 1]])
    across = frame.across(points)
    asked = _extent(points, frame)
    filled = float(0.5 * np.abs(up).sum())
    s = np.abs(frame.local(points)[:, 0])
    reach = facets.ravel()
    strays = (s[reach] > 0.5 * frame.length + _ON).any() if len(facets) else True
    strays = strays or bool((across[reach] > frame.high + _ON).any())
    if strays or not abs(filled / asked - 1.0) < _FILLED:
        raise MeshError(
            f"the mesh follows {filled:.6g} of {asked:.6g} mm^2 of plate {frame.index}'s "
            "mid-surface"
        )
    return np.asarray(facets)


def _extent(points: Array, frame: PlateFrame) -> float:
    """Area of the plate's mid-surface within the mesh (a half ends at its symmetry plane), mm^2."""
    across = frame.across(points)
    span = min(frame.high, float(across.max())) - max(frame.low, float(across.min()))
    ends = frame.to_space(frame.from_local(np.array([-0.5, 0.5]) * frame.length, 0.0), frame.middle)
    length = frame.length
    if frame.along == "z" and ends[:, 2].min() < points[:, 2].min() - _ON:
        length *= (ends[:, 2].max() - float(points[:, 2].min())) / float(np.ptp(ends[:, 2]))
    return length * span
