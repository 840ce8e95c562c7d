"""The two faces of a plate's slot: their facets, and which node faces which."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import tabulate

if TYPE_CHECKING:
    from fingerdesign.layout.frames import PlateFrame
    from fingerdesign.mesh.types import Mesh


_SAME_PLACE = 1e-6  # mm: far below any element, far above rounding


@dataclass(frozen=True)
class SheetFacets:
    """One plate: the facets of its upper face stand for its mid-surface.

    own (o,): numbers in the mesh of the plate's nodes; all other numbers are places in ``own``.
    nodes, nodes_below (f, k): of the upper face, and those that they face; tangents (s, dim),
    normal (dim,), s = dim - 1; flat (f, s + 1, s): corners in coordinates along the tangents (the
    plate's axis from its centre, and across: z of a plate along x, x of one along z); upper, lower
    (p,): nodes that face each other; between (b,), pair (b,): nodes on the end faces midway between
    those of a pair (faces that end in the body's outside have none); thickness mm.
    """

    own: IntArray
    nodes: IntArray
    nodes_below: IntArray
    tangents: Array
    normal: Array
    flat: Array
    upper: IntArray
    lower: IntArray
    between: IntArray
    pair: IntArray
    thickness: float

    @property
    def dofs(self) -> IntArray:
        """Dofs (o dim,) of the mesh that are the plate's, node by node."""
        dimension = len(self.normal)
        return np.asarray((self.own[:, None] * dimension + np.arange(dimension)).ravel())

    @property
    def dimension(self) -> int:
        """Of the surface: 1 in plane strain, 2 in space."""
        return int(self.tangents.shape[0])

    @property
    def inverse(self) -> Array:
        """d reference_b / d coordinate_a, (f, b, a): facets are flat and straight."""
        return np.asarray(np.linalg.inv(self._jacobian))

    @property
    def measure(self) -> Array:
        """Length or area (f,)."""
        factor = 1.0 if self.dimension == 1 else 0.5
        return np.asarray(factor * np.abs(np.linalg.det(self._jacobian)))

    @property
    def _jacobian(self) -> Array:
        return (self.flat[:, 1:] - self.flat[:, :1]).transpose(0, 2, 1)

    def slopes(self, where: Array) -> Array:
        """Derivatives (f, q, k, s) of the shape functions along the tangents, at reference points
        ``where`` (s, q)."""
        gradient = tabulate(self.dimension, where).gradient
        return np.asarray(np.einsum("nbq,fba->fqna", gradient, self.inverse, optimize=True))


def sheet_of(mesh: Mesh, frame: PlateFrame) -> SheetFacets:
    """The facets of one plate's slot. Raises SolverError where the mesh has none for it."""
    names = [f"plate_{frame.index}_{face}" for face in ("upper", "lower", "end")]
    if not all(name in mesh.facets for name in names):
        raise SolverError(
            f"the mesh has no slot for plate {frame.index}: mesh it with plates.model = 'sheet'"
        )
    facets = mesh.facets[names[0]]
    upper, lower, end = (np.unique(mesh.facets[name]) for name in names)
    partner = lower[_facing(mesh, frame, upper, lower)]
    between = np.setdiff1d(end, np.concatenate([upper, lower]))
    own = np.concatenate([upper, partner, between])
    place = np.empty(len(mesh.points), dtype=np.int64)
    place[own] = np.arange(len(own))
    normal, tangents = frame.normal, frame.axis[None, :]
    if mesh.dimension == 3:
        normal, tangents = frame.direction(normal), frame.direction(tangents)
        across = frame.to_space(np.zeros(2), 1.0)
        tangents = np.vstack([tangents, across])
    nodes, corners = place[facets], facets[:, : mesh.dimension]
    return SheetFacets(
        own=own,
        nodes=nodes,
        nodes_below=nodes + len(upper),
        tangents=tangents,
        normal=normal,
        flat=places_on(frame, mesh.points[corners.ravel()]).reshape(*corners.shape, -1),
        upper=place[upper],
        lower=place[partner],
        between=place[between],
        pair=_facing(mesh, frame, between, upper),
        thickness=frame.thickness,
    )


def places_on(frame: PlateFrame, points: Array) -> Array:
    """Coordinates (n, s) along a flat plate's tangents of points (n, dim)."""
    along = frame.local(points)[:, :1]
    if points.shape[1] == 2:
        return np.asarray(along)
    return np.column_stack([along, frame.across(points)])


def _facing(mesh: Mesh, frame: PlateFrame, nodes: IntArray, others: IntArray) -> IntArray:
    """For each node the place in ``others`` of the one at the same place along the plate."""
    here, there = (places_on(frame, mesh.points[which]) for which in (nodes, others))
    distance, found = cKDTree(there).query(here, distance_upper_bound=_SAME_PLACE)
    if not np.isfinite(distance).all():
        raise SolverError(f"the faces of plate {frame.index}'s slot do not mirror each other")
    return np.asarray(found, dtype=np.int64)
