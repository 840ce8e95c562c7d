"""Forces and stiffness of quadratic cells at finite strain, in a few large products.

Where the law has its own pressure p (mixed, "perturbed Lagrangian": p = -lame ln J holds in the
mean), the body makes stationary

    integral mu/2 (tr F^T F - 3 - 2 ln J) - p ln J - p^2 / (2 lame)

over quadratic displacements and linear pressures (Simo and Taylor, CMAME 85 (1991) 273;
Taylor-Hood pair as in fem/system.py). With G_i = grad N_i and g_i = F^-T G_i,

    forces     integral  mu F G_i - (mu + p) g_i,          -integral L_m (ln J + p / lame)
    stiffness  integral  mu G_i . G_j delta_kl + (mu + p) g_i[l] g_j[k] (+ lame g_i[k] g_j[l]
               where p = -lame ln J outright),   -integral g_i L_m,   -integral L_m L_n / lame

A stiff plate that a step has turned is stretched by that step's own linear motion, by half the turn
squared. This is harmless in the forces, where the next step removes it. In the stiffness it may
outweigh the soft body. There the stress of such cells is the one that the step *predicted* from its
start (a stress of its own at each point: Magisano, Leonetti, Garcea, IJNME 109 (2017) 1237); at the
answer both are the same.

The quadrature has the order of the small-strain model; at rest both stiffnesses agree to rounding.
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.fem.elements import physical_gradients, quadrature, strain_order, tabulate
from fingerdesign.fem.finite.law import Deformation, deformation, second_piola, second_piola_change
from fingerdesign.mesh.cells import kind_of


@dataclass(frozen=True)
class Group:
    """Cells of one kind, with what does not change with the deformation.

    dofs (c, l): numbers of each cell's unknowns, node by node, pressures last; gradients
    (c, q, n, d) 1/mm and weights (c, q) mm^3 at rest; first, shear (c,) MPa; pull (c, n, n): mu
    integral G_i . G_j; linear (s, q): shape functions of the s pressures, none (0) where the law
    has its own; squeeze (c, s, s): integral L_m L_n / lame.
    """

    dofs: IntArray
    gradients: Array
    weights: Array
    first: Array
    shear: Array
    pull: Array
    linear: Array
    squeeze: Array

    def evaluate(
        self, values: Array, stiffness: bool = True, before: Array | None = None
    ) -> tuple[Array, Array | None]:
        """Forces (c, l) and stiffness (c, l, l) at the unknowns ``values`` (all of the body's).

        before: values where the step began whose end this is; None: the stiffness is the forces'
        derivative. Raises Inverted where a cell is turned inside out.
        """
        cells, points, nodes, dim = self.gradients.shape
        split = nodes * dim
        local = values[self.dofs]
        at = deformation(self._gradient(values))
        if len(self.linear):
            pressure = local[:, split:] @ self.linear
        else:
            pressure = -self.first[:, None] * at.log_volume
        spatial = self.gradients @ at.inverse  # g_i
        both = self.weights * (self.shear[:, None] + pressure)
        drawn = self.gradients @ np.swapaxes(at.gradient, -1, -2)
        parts = [_weighted(self.weights * self.shear[:, None], drawn) - _weighted(both, spatial)]
        if len(self.linear):
            volume = (self.weights * at.log_volume) @ self.linear.T
            squeezed = np.einsum("cmn,cn->cm", self.squeeze, local[:, split:])
            parts.append(-volume - squeezed)
        found = np.concatenate(parts, axis=1)
        if not stiffness:
            return found, None
        pull = self.pull
        if before is not None and not len(self.linear):
            pull = pull + self._predicted(values, before, at)
        return found, self._stiffness(spatial.reshape(cells, points, split), both, pull)

    def _gradient(self, values: Array) -> Array:
        """du/dX (c, q, d, d)."""
        cells, _, nodes, dim = self.gradients.shape
        moved = values[self.dofs[:, : nodes * dim]].reshape(cells, 1, nodes, dim)
        return np.asarray(np.swapaxes(moved, -1, -2) @ self.gradients)

    def _predicted(self, values: Array, before: Array, at: Deformation) -> Array:
        """integral G_i . (S predicted - S) G_j (c, n, n), N/mm."""
        there = self._gradient(before)
        began, change = deformation(there), self._gradient(values) - there
        moduli = (self.first[:, None], self.shear[:, None])
        stress = second_piola(began, *moduli) + second_piola_change(began, change, *moduli)
        stress -= second_piola(at, *moduli)
        pulled = self.weights[:, :, None, None] * (self.gradients @ stress)
        return np.asarray((pulled @ np.swapaxes(self.gradients, -1, -2)).sum(axis=1))

    def _stiffness(self, flat: Array, both: Array, pull: Array) -> Array:
        """(c, l, l) from g (c, q, n d), the weights times mu + p (c, q), and what pulls alike in
        each direction (c, n, n)."""
        cells, nodes = len(flat), self.gradients.shape[2]
        dim, split = self.gradients.shape[3], flat.shape[2]
        turned = np.matmul(np.swapaxes(flat * both[:, :, None], 1, 2), flat)
        shaped = turned.reshape(cells, nodes, dim, nodes, dim)
        block = np.swapaxes(shaped, 2, 4).copy()  # g_i[l] g_j[k]
        for k in range(dim):
            block[:, :, k, :, k] += pull
        size = split + len(self.linear)
        whole = np.zeros((cells, size, size))
        whole[:, :split, :split] = block.reshape(cells, split, split)
        if len(self.linear):
            weighted = self.weights[:, None, :] * self.linear[None]
            coupling = -np.matmul(np.swapaxes(flat, 1, 2), np.swapaxes(weighted, 1, 2))
            whole[:, :split, split:] = coupling
            whole[:, split:, :split] = np.swapaxes(coupling, 1, 2)
            whole[:, split:, split:] = -self.squeeze
        else:
            stiff = (self.first[:, None] * self.weights)[:, :, None]
            whole[:, :split, :split] += np.matmul(np.swapaxes(flat * stiff, 1, 2), flat)
        return whole


def _weighted(weights: Array, vectors: Array) -> Array:
    """Sums (c, n k) over q of weights (c, q) times vectors (c, q, n, k)."""
    cells, points = weights.shape
    return (weights[:, None, :] @ vectors.reshape(cells, points, -1))[:, 0]


def group(
    points: Array,
    cells: IntArray,
    first: Array,
    shear: Array,
    thickness: float,
    pressures: IntArray | None = None,
    scale: float = 1.0,
) -> Group:
    """The group of ``cells`` (c, nodes) with Lame's parameters (c,), MPa.

    pressures (c, corners): numbers of their pressure unknowns, each ``scale`` MPa a unit; None:
    none. Raises ValueError where a cell is inverted at rest.
    """
    dimension, kind = points.shape[1], kind_of(cells)
    gradients, weights = physical_gradients(points, cells, strain_order(kind))
    weights = thickness * weights
    dofs = (cells[:, :, None] * dimension + np.arange(dimension)).reshape(len(cells), -1)
    pull = np.einsum(
        "cq,cqia,cqja->cij", weights * shear[:, None], gradients, gradients, optimize=True
    )
    linear = np.empty((0, weights.shape[1]))
    squeeze = np.empty((len(cells), 0, 0))
    if pressures is not None:
        table = tabulate(kind, *quadrature(kind, strain_order(kind)), degree=1)
        linear = scale * table.value
        dofs = np.concatenate([dofs, pressures], axis=1)
        squeeze = np.einsum(
            "cq,mq,nq->cmn", weights / first[:, None], linear, linear, optimize=True
        )
    return Group(dofs, gradients, weights, first, shear, pull, linear, squeeze)
