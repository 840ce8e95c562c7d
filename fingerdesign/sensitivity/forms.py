"""Derivative of the elastic form with node places and moduli, contracted cell by cell.

    a(u, w) = integral 2 mu eps(u) : eps(w) + lame div u div w      (or, with a pressure p of its
              own,       ... - p div w - q div u - p q / lame)

With a velocity v of the nodes, D = grad v, gradients change by -grad u D and volumes by div v:

    da = integral S : grad w - q r,     S = sigma div v - sigma D^T - law(sym(grad u D))
                                        r = div u div v - tr(grad u D) + p div v / lame

by the quadrature of the form itself, so that da is the exact derivative of the discrete form.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.fem.elements import physical_gradients, quadrature, strain_order, tabulate
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.fem.system import Body, pressure_nodes
from fingerdesign.sensitivity.change import Change

_ENTRIES = 4_000_000  # Of the largest temporary array: 32 MB.


@dataclass(frozen=True)
class Fields:
    """k fields of a body: moved (n, dim, k) mm, and pressure (pressures, k) MPa (0 rows: none)."""

    moved: Array
    pressure: Array

    def times(self, shares: Array) -> "Fields":
        """Sums (of ``shares`` (k, j)) of the fields."""
        return Fields(self.moved @ shares, self.pressure @ shares)


def products(body: Body, left: Fields, right: Fields, changes: Sequence[Change]) -> Array:
    """w^T (dK/dp) u (changes, left, right), N mm: K's derivative between each pair of fields."""
    active = [_active(body, change) for change in changes]
    found = np.zeros((len(changes), left.moved.shape[2], right.moved.shape[2]))
    order = strain_order(body.mesh.kind)
    points_in_cell = quadrature(body.mesh.kind, order)[1].size
    width = points_in_cell * body.mesh.dimension**2 * right.moved.shape[2]
    size = max(1, _ENTRIES // width)
    numbers = _pressure_numbers(body)
    some = np.flatnonzero(np.any(active, axis=0)) if changes else np.empty(0, dtype=np.int64)
    for start in range(0, len(some), size):
        part = _Part(body, some[start : start + size], order, numbers, right)
        for number, change in enumerate(changes):
            own = active[number][part.cells]
            if own.any():
                found[number] += part.product(change, own, left)
    return found


def _active(body: Body, change: Change) -> BoolArray:
    """Cells (c,) whose stiffness a parameter changes."""
    found = np.zeros(len(body.mesh.cells), dtype=bool)
    if change.velocity is not None:
        found |= (change.velocity[body.mesh.cells] != 0.0).any(axis=(1, 2))
    if change.moduli is not None:
        found |= change.moduli.any(axis=0)
    return found


def _pressure_numbers(body: Body) -> IntArray:
    """Pressures (c, corners) of each cell; -1 where it has none."""
    numbers = np.full(body.mesh.corners.shape, -1, dtype=np.int64)
    inside = body.pressed
    if inside.any():
        moduli = body.youngs_modulus[inside], body.poissons_ratio[inside]
        numbers[inside] = pressure_nodes(body.mesh.corners[inside], *moduli)[0]
    return numbers


class _Part:
    """Some cells, with gradients, stresses and pressures of the right fields at their points.

    Arrays are (cells, points, derivative, component, fields)."""

    def __init__(
        self, body: Body, cells: IntArray, order: int, numbers: IntArray, right: Fields
    ) -> None:
        mesh = body.mesh
        self.body, self.cells, self.nodes = body, cells, mesh.cells[cells]
        self.slopes, weights = physical_gradients(mesh.points, self.nodes, order)
        self.weights = weights * body.thickness
        rule = quadrature(mesh.kind, order)
        self.hats = tabulate(mesh.kind, *rule, degree=1).value  # (corners, q)
        self.numbers, self.mixed = numbers[cells], body.pressed[cells]
        first, shear = lame_parameters(body.youngs_modulus[cells], body.poissons_ratio[cells])
        self.first, self.shear = first, shear
        self.law = np.where(self.mixed, 0.0, first), shear
        self.grad = self._gradients(right.moved)
        self.div = np.einsum("cqiik->cqk", self.grad)
        self.pressure = np.zeros_like(self.div)
        if self.mixed.any():
            own = right.pressure[self.numbers[self.mixed]]
            self.pressure[self.mixed] = np.einsum("mq,cmk->cqk", self.hats, own, optimize=True)
        self.stress = _stress(self.grad, *self.law)
        for i in range(mesh.dimension):
            self.stress[:, :, i, i] -= self.pressure

    def _gradients(self, moved: Array) -> Array:
        own = moved[self.nodes]  # (c, n, i, k)
        return np.asarray(np.einsum("cqnj,cnik->cqjik", self.slopes, own, optimize=True))

    def product(self, change: Change, own: BoolArray, left: Fields) -> Array:
        """This part's share (left, right) in the product of one change, of the cells ``own``."""
        stress, rate = self._changed(change, own)
        weights, nodes = self.weights[own], self.nodes[own]
        stress *= weights[:, :, None, None, None]
        force = np.einsum("cqnj,cqjik->cnik", self.slopes[own], stress, optimize=True)
        used, total = _summed(nodes, force)
        found = np.tensordot(left.moved[used], total, axes=((0, 1), (0, 1)))
        mixed = self.mixed[own]
        if mixed.any():
            flow = np.einsum(
                "mq,cq,cqk->cmk", self.hats, weights[mixed], rate[mixed], optimize=True
            )
            used, total = _summed(self.numbers[own][mixed], flow)
            found -= left.pressure[used].T @ total
        return np.asarray(found)

    def _changed(self, change: Change, own: BoolArray) -> tuple[Array, Array]:
        """S and r of the module's equations."""
        grad, pressure = self.grad[own], self.pressure[own]
        first = self.first[own, None, None]
        stress, rate = np.zeros_like(grad), np.zeros_like(pressure)
        if change.velocity is not None:
            flow = self._gradients(change.velocity[:, :, None])[own][..., 0]  # (c, q, j, i)
            growth = np.einsum("cqii->cq", flow)[:, :, None]
            turned = np.einsum("cqlik,cqjl->cqjik", grad, flow, optimize=True)
            stress += self.stress[own] * growth[:, :, None, None]
            stress -= np.einsum("cqlik,cqlj->cqjik", self.stress[own], flow, optimize=True)
            stress -= _stress(turned, self.law[0][own], self.law[1][own])
            rate += self.div[own] * growth - np.einsum("cqiik->cqk", turned)
            rate += pressure * growth / first
        if change.moduli is not None:
            one, two = change.moduli[:, self.cells[own]]
            mixed = self.mixed[own]
            stress += _stress(grad, np.where(mixed, 0.0, one), two)
            rate -= pressure * one[:, None, None] / first**2
        return stress, rate


def _stress(grad: Array, first: Array, shear: Array) -> Array:
    """lame tr I + 2 mu sym of gradients (c, q, d, d, k)."""
    found = shear[:, None, None, None, None] * (grad + grad.swapaxes(2, 3))
    trace = first[:, None, None] * np.einsum("cqiik->cqk", grad)
    for i in range(grad.shape[2]):
        found[:, :, i, i] += trace
    return np.asarray(found)


def _summed(nodes: IntArray, values: Array) -> tuple[IntArray, Array]:
    """Nodes (u,) that occur, and sums (u, ...) of ``values`` (c, n, ...) at them."""
    used, place = np.unique(nodes, return_inverse=True)
    count = nodes.size
    add = sp.csr_matrix(
        (np.ones(count), (place.reshape(-1), np.arange(count))), shape=(len(used), count)
    )
    total = add @ values.reshape(count, -1)
    return used, total.reshape(len(used), *values.shape[2:])
