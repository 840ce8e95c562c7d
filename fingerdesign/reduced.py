"""The finger as the contact problem sees it: small dense matrices (numpy only).

The body is linear, so everything that contact and gages need is linear in the contact forces:

    displacement  u = C f      C = compliance, mm/N
    gage strain   e = B f      B = gage readout, 1/N

with f the nodal contact forces on the finger (N) in the global axes x, y(, z), node by node. Node i
represents the hat function phi_i of a corner of the contact facets: its traction is f_i / a_i with
a_i = integral of phi_i, its displacement and gap are means weighted with phi_i / a_i. Tractions are
thus piecewise linear, never negative where the nodal ones are not, integrate to the forces, and
reproduce uniform pressure exactly, also on quadratic tetrahedra, whose own corner forces cannot.

Forces are those of the modelled part: the whole depth in plane strain, half the finger where it
mirrors in z = 0 (``symmetry_factor`` 2).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray


@dataclass(frozen=True)
class SurfaceQuadrature:
    """Points on the exact contact surface and the weights phi_i(x_q) w_q / a_i of each node. points
    (q, dim) mm; node, point, weight (entries,): the weights of a node sum to 1."""

    points: Array
    node: IntArray
    point: IntArray
    weight: Array

    def mean(self, values: Array, nodes: int) -> Array:
        """Means (nodes, ...) at the nodes of values (q, ...) at the points."""
        values = np.asarray(values, dtype=float)
        flat = values.reshape(len(values), -1)
        out = np.stack(
            [
                np.bincount(self.node, self.weight * column[self.point], minlength=nodes)
                for column in flat.T
            ],
            axis=1,
        )
        return out.reshape((nodes, *values.shape[1:]))


@dataclass(frozen=True)
class ReducedModel:
    """Compliance and readouts of a finger condensed onto its contact candidates.

    points            (m, dim) mm, corner nodes of the candidate facets
    facets            (f, dim) node numbers; facet_areas (f,) mm^2 (plane strain: length x depth)
    areas             (m,) mm^2, a_i = integral of phi_i
    compliance        (m dim, m dim) mm/N, symmetric positive definite
    gage_readout      (2 plates, m dim) 1/N: upper and lower face of plate 0, of plate 1, ...
    point_readout     (6 points, m dim) 1/N: xx, yy, zz, xy, xz, yz (engineering shear) per point
    reaction_readout  (dim, m dim): supports' force on the body per contact force: minus the sum
    rim               (m,) bool: nodes where the candidate zone ends although the surface goes on
    free_end          (m,) bool: nodes within 0.5 mm of a free end (corner singularity in 3-D)
    locked            (m, dim) bool: components without a motion (z on the mirror plane)
    gage_x            (plates,) mm, places of the gages along x; NaN: its row runs along z
    gage_positions    (plates, 3) mm, the gages' centres
    load_displacement (m, dim) mm under the body's own loads at share 1; None where it has none
    load_gage_strain  (plates, 2) what the gages read under those alone; None where it has none
    """

    points: Array
    facets: IntArray
    facet_areas: Array
    areas: Array
    compliance: Array
    gage_readout: Array
    point_readout: Array
    reaction_readout: Array
    surface: SurfaceQuadrature
    rim: NDArray[np.bool_]
    free_end: NDArray[np.bool_]
    locked: NDArray[np.bool_]
    depth: float
    symmetry_factor: int = 1
    gage_x: Array = field(default_factory=lambda: np.empty(0))
    gage_positions: Array = field(default_factory=lambda: np.empty((0, 3)))
    load_displacement: Array | None = None
    load_gage_strain: Array | None = None
    notes: dict[str, float | int | str] = field(default_factory=dict)

    @property
    def dimension(self) -> int:
        return int(self.points.shape[1])

    @property
    def nodes(self) -> int:
        return len(self.points)

    @cached_property
    def balanced(self) -> NDArray[np.bool_]:
        """Axes (dim,) along which no component is locked: forces there balance the base's."""
        return np.asarray(~self.locked.any(axis=0))

    @property
    def gage_centres_x(self) -> Array:
        """x of all gages (plates,), mm, those of rows along z too; a model without positions has
        rows along x alone."""
        return self.gage_positions[:, 0] if len(self.gage_positions) else self.gage_x

    def with_gages(self, plates: Sequence[int]) -> Self:
        """The same finger with the gages of some plates only, in the order given."""
        chosen = np.asarray(plates, dtype=np.int64)
        rows = (2 * chosen[:, None] + np.arange(2)).reshape(-1)
        places, alone = self.gage_positions, self.load_gage_strain
        return replace(
            self,
            gage_readout=self.gage_readout[rows],
            gage_x=self.gage_x[chosen],
            gage_positions=places[chosen] if len(places) else places,
            load_gage_strain=None if alone is None else alone[chosen],
        )

    def restricted(self, nodes: IntArray) -> Self:
        """The same finger with some of the candidates alone (k,), rising, and facets among them."""
        place = np.full(self.nodes, -1)
        place[nodes] = np.arange(len(nodes))
        inside, seen = (place[self.facets] >= 0).all(axis=1), place[self.surface.node] >= 0
        dofs = (nodes[:, None] * self.dimension + np.arange(self.dimension)).reshape(-1)
        mean, load = self.surface, self.load_displacement
        return replace(
            self,
            points=self.points[nodes],
            facets=place[self.facets[inside]],
            facet_areas=self.facet_areas[inside],
            areas=self.areas[nodes],
            compliance=self.compliance[dofs][:, dofs],
            gage_readout=self.gage_readout[:, dofs],
            point_readout=self.point_readout[:, dofs],
            reaction_readout=self.reaction_readout[:, dofs],
            surface=SurfaceQuadrature(
                mean.points, place[mean.node[seen]], mean.point[seen], mean.weight[seen]
            ),
            rim=self.rim[nodes],
            free_end=self.free_end[nodes],
            locked=self.locked[nodes],
            load_displacement=None if load is None else load[nodes],
        )

    def displacement(self, force: Array) -> Array:
        """Contact displacements (m, dim) mm for nodal forces (m, dim) N."""
        return (self.compliance @ force.reshape(-1)).reshape(force.shape)

    def gage_strain(self, force: Array) -> Array:
        """Strains (plates, 2) at the upper and lower faces for nodal forces (m, dim) N."""
        return (self.gage_readout @ force.reshape(-1)).reshape(-1, 2)

    def point_strain(self, force: Array) -> Array:
        """Strain tensors (points, 6) for nodal forces (m, dim) N."""
        return (self.point_readout @ force.reshape(-1)).reshape(-1, 6)

    def total_force(self, force: Array) -> Array:
        """Force on the whole finger (dim,) N."""
        return np.asarray(self.symmetry_factor * force.sum(axis=0))

    @cached_property
    def mid_line(self) -> tuple[IntArray, IntArray, Array]:
        """The line z = 0 across the facets: pairs of end points, each a mix of two nodes.

        first, second (s, 2) node numbers and weight (s, 2): a point is
        (1 - weight) first + weight second. In plane strain these are the facets themselves.
        """
        if self.dimension == 2:
            return self.facets, self.facets, np.zeros(self.facets.shape)
        z = self.points[:, 2].copy()
        z[np.abs(z) < 1e-9] = 0.0
        pieces: list[list[tuple[int, int, float]]] = []
        seen: set[tuple[int, int]] = set()
        for facet in self.facets[(z[self.facets].min(1) <= 0) & (z[self.facets].max(1) >= 0)]:
            ends: list[tuple[int, int, float]] = [
                (int(i), int(i), 0.0) for i in facet if z[i] == 0.0
            ]
            for a, b in ((0, 1), (1, 2), (0, 2)):
                i, j = int(facet[a]), int(facet[b])
                if z[i] * z[j] < 0.0:
                    ends.append((i, j, float(z[i] / (z[i] - z[j]))))
            if len(ends) < 2:
                continue
            if all(i == j for i, j, _ in ends[:2]):
                edge = (min(ends[0][0], ends[1][0]), max(ends[0][0], ends[1][0]))
                if edge in seen:
                    continue
                seen.add(edge)
            pieces.append(ends[:2])
        first, second, weight = np.array(pieces, dtype=float).reshape(-1, 2, 3).transpose(2, 0, 1)
        return first.astype(np.int64), second.astype(np.int64), weight
