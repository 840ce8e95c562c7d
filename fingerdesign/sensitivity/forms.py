"""Derivative of the elastic form with node places and moduli, contracted cell by cell.

    a(u, w) = integral 2 mu eps(u) : eps(w) + lame div u div w      (or, with a pressure p of its
              own,       ... - p div w - q div u - p q / lame)

With a velocity v of the nodes, D = grad v, gradients change by -grad u D and volumes by div v:

    da = integral S : grad w - q r,     S = sigma div v - sigma D^T - law(sym(grad u D))
                                        r = div u div v - tr(grad u D) + p div v / lame

by the quadrature of the form itself, so that da is the exact derivative of the discrete form. Of
two given fields it is linear in D (Eshelby's tensor), whatever the parameter:

    da = integral E : D,    E = (sigma(u) : grad w - q div u - p q / lame) I
                                - sigma(u) grad w - sigma(w) grad u
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.fem.elements import physical_gradients, quadrature, strain_order, tabulate
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.fem.system import Body, pressure_nodes
from fingerdesign.sensitivity.change import Change

_ENTRIES = 8_000_000  # Of the largest temporary array: 64 MB.


@dataclass(frozen=True)
class Fields:
    """k fields of a body: moved (n, dim, k) mm, and pressure (pressures, k) MPa (0 rows: none)."""

    moved: Array
    pressure: Array

    def times(self, shares: Array) -> "Fields":
        """Sums (of ``shares`` (j, i)) of the first j fields."""
        first, (nodes, dim, count) = len(shares), self.moved.shape
        moved = self.moved.reshape(-1, count)[:, :first] @ shares
        return Fields(moved.reshape(nodes, dim, -1), self.pressure[:, :first] @ shares)


def products(body: Body, left: Fields, right: Fields, changes: Sequence[Change]) -> Array:
    """w^T (dK/dp) u (changes, left, right), N mm: K's derivative between each pair of fields."""
    found = np.zeros((len(changes), left.moved.shape[2], right.moved.shape[2]))
    active = [_active(body, change) for change in changes]
    for part in _parts(body, active, found.shape[2]):
        here, moved = _State(part, right), left.moved[part.used].reshape(-1, found.shape[1])
        for number, change in enumerate(changes):
            own = active[number][part.cells]
            if own.any():
                found[number] += here.product(change, own, moved, left.pressure)
    return found


def energies(body: Body, left: Fields, right: Fields, changes: Sequence[Change]) -> Array:
    """w^T (dK/dp) u (changes, k), N mm, of k pairs: one nodal force, of all changes alike."""
    found = np.zeros((len(changes), right.moved.shape[2]))
    active = [_active(body, change) for change in changes]
    for part in _parts(body, active, found.shape[1]):
        here = _State(part, right)
        there = here if left is right else _State(part, left)
        force, volume, shear = here.energy_with(there)
        for number, change in enumerate(changes):
            own = active[number][part.cells]
            if own.any() and change.velocity is not None:
                speed = change.velocity[part.nodes[own]].reshape(-1)
                found[number] += speed @ force[own].reshape(len(speed), -1)
            if own.any() and change.moduli is not None:
                one, two = change.moduli[:, part.cells]
                found[number] += one @ volume + two @ shear
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


def _parts(body: Body, active: Sequence[BoolArray], fields: int) -> Iterator["_Part"]:
    """The cells that any change changes, so many at a time as memory allows for ``fields``."""
    kind = body.mesh.kind
    points = quadrature(kind, strain_order(kind))[1].size
    size = max(1, _ENTRIES // (points * body.mesh.dimension**2 * max(fields, 1)))
    numbers = _pressure_numbers(body)
    some = np.flatnonzero(np.any(active, axis=0)) if len(active) else np.empty(0, dtype=np.int64)
    for start in range(0, len(some), size):
        yield _Part(body, some[start : start + size], numbers)


class _Part:
    """Some cells, with the gradients of shape functions at their q points.

    Gradients are (cells, points, derivative, component, fields)."""

    def __init__(self, body: Body, cells: IntArray, numbers: IntArray) -> None:
        mesh, self.cells = body.mesh, cells
        order, self.nodes = strain_order(mesh.kind), mesh.cells[cells]
        self.used, place = np.unique(self.nodes, return_inverse=True)
        self.place = place.reshape(self.nodes.shape)
        slopes, weights = physical_gradients(mesh.points, self.nodes, order)
        self.shape = (*weights.shape[1:], mesh.dimension)
        # (c, q d, n): products over cells are then those of matrices.
        self.slopes = slopes.swapaxes(2, 3).reshape(len(cells), -1, self.nodes.shape[1])
        self.weights = weights * body.thickness
        rule = quadrature(mesh.kind, order)
        self.hats = tabulate(mesh.kind, *rule, degree=1).value  # (corners, q)
        self.numbers, self.mixed = numbers[cells], body.pressed[cells]
        self.first, shear = lame_parameters(body.youngs_modulus[cells], body.poissons_ratio[cells])
        self.law = _law(np.where(self.mixed, 0.0, self.first), shear, mesh.dimension)

    def gradients(self, moved: Array, own: BoolArray | slice = slice(None)) -> Array:
        """Gradients of fields (n, d, k) of the mesh, in cells ``own``."""
        nodes = self.nodes[own]
        found = self.slopes[own] @ moved[nodes].reshape(*nodes.shape, -1)
        return np.asarray(found.reshape(len(nodes), *self.shape, self.shape[1], -1))

    def rates(self, change: Change, own: BoolArray) -> Array:
        """Matrices (c, q, d d + 1, d d + 1), with the points' weights: S and r of the module's
        equations are they times gradient and pressure."""
        dim, first, law = self.shape[1], self.first[own, None], self.law[own, None]
        one = np.eye(dim)
        found = np.zeros((len(first), self.shape[0], dim**2 + 1, dim**2 + 1))
        if change.velocity is not None:
            flow = self.gradients(change.velocity[:, :, None], own)[..., 0]  # (c, q, j, i)
            growth = np.einsum("cqii->cq", flow)
            square = (*growth.shape, dim**2, dim**2)
            still = -np.einsum("cqlj,ik->cqjilk", flow, one).reshape(square)
            still += growth[:, :, None, None] * np.eye(dim**2)
            turn = np.einsum("cqjl,ik->cqjilk", flow, one).reshape(square)
            found[..., :-1, :-1] = still @ law - law @ turn
            found[..., :-1, -1] = -still @ one.ravel()
            found[..., -1, :-1] = growth[:, :, None] * one.ravel()
            found[..., -1, :-1] -= flow.swapaxes(2, 3).reshape(*growth.shape, -1)
            found[..., -1, -1] = growth / first
        if change.moduli is not None:
            rise, shear = change.moduli[:, self.cells[own]]
            inner = np.where(self.mixed[own], 0.0, rise)
            found[..., :-1, :-1] += _law(inner, shear, dim)[:, None]
            found[..., -1, -1] -= rise[:, None] / first**2
        found *= self.weights[own][:, :, None, None]
        return found


class _State:
    """Gradients and pressures (c, q, d d + 1, k) of k fields at the points of some cells."""

    def __init__(self, part: _Part, fields: Fields) -> None:
        self.part = part
        grad = part.gradients(fields.moved)
        count, (points, dim), size = len(grad), part.shape, grad.shape[-1]
        self.both = np.zeros((count, points, dim**2 + 1, size))
        self.both[:, :, :-1] = grad.reshape(count, points, dim**2, size)
        if part.mixed.any():
            own = fields.pressure[part.numbers[part.mixed]]
            self.both[part.mixed, :, -1] = part.hats.T @ own

    def product(self, change: Change, own: BoolArray, moved: Array, pressure: Array) -> Array:
        """This part's share (left, right) in the product of one change, of the cells ``own``.

        moved (u dim, left): left fields at the part's nodes; pressure: of the whole body.
        """
        part, rates, both = self.part, self.part.rates(change, own), self.both[own]
        stress = (rates[:, :, :-1] @ both).reshape(len(both), part.slopes.shape[1], -1)
        used, total = _summed(part.place[own], part.slopes[own].swapaxes(1, 2) @ stress)
        total = total.reshape(-1, both.shape[-1])
        if len(used) < len(part.used):
            dim = part.shape[1]
            moved = moved[(used[:, None] * dim + np.arange(dim)).ravel()]
        found = moved.T @ total
        mixed = part.mixed[own]
        if mixed.any():
            flow = part.hats @ (rates[mixed, :, -1:] @ both[mixed])[:, :, 0]
            used, total = _summed(part.numbers[own][mixed], flow)
            found -= pressure[used].T @ total
        return np.asarray(found)

    def energy_with(self, other: "_State") -> tuple[Array, Array, Array]:
        """Of w^T dK u, with the other state's w: nodal forces (c, n, d, k), N, which velocities are
        multiplied with, and what both Lame parameters of a cell are, (c, k) mm^3."""
        part = self.part
        weights, first = part.weights[:, :, None], part.first[:, None, None]
        grad, div, pressure, stress = self._parts()
        others, other_div, other_pressure, other_stress = other._parts()
        tensor = -np.einsum("cqjik,cqlik->cqjlk", stress, others)
        tensor += tensor if other is self else -np.einsum("cqjik,cqlik->cqjlk", other_stress, grad)
        whole = np.einsum("cqjik,cqjik->cqk", stress, others)
        whole -= other_pressure * (div + pressure / first)
        for i in range(part.shape[1]):
            tensor[:, :, i, i] += whole
        tensor *= weights[:, :, None, None]
        force = part.slopes.swapaxes(1, 2) @ tensor.reshape(len(grad), part.slopes.shape[1], -1)
        volume = div * other_div
        volume[part.mixed] = (pressure * other_pressure / first**2)[part.mixed]
        shear = np.einsum("cqjik,cqjik->cqk", grad + grad.swapaxes(2, 3), others)
        return force, (weights * volume).sum(axis=1), (weights * shear).sum(axis=1)

    def _parts(self) -> tuple[Array, Array, Array, Array]:
        """Gradients, their traces, pressures, and stresses."""
        part, flat, pressure = self.part, self.both[:, :, :-1], self.both[:, :, -1]
        whole = (*self.both.shape[:2], part.shape[1], part.shape[1], -1)
        grad, stress = flat.reshape(whole), (part.law[:, None] @ flat).reshape(whole)
        for i in range(part.shape[1]):
            stress[:, :, i, i] -= pressure
        return grad, np.einsum("cqiik->cqk", grad), pressure, stress


def _law(first: Array, shear: Array, dim: int) -> Array:
    """lame tr I + 2 mu sym, as matrices (c, d d, d d) on gradients."""
    one = np.eye(dim)
    whole = np.outer(one, one)
    turned = np.einsum("jk,il->jilk", one, one).reshape(whole.shape)
    own = np.eye(dim**2) + turned
    return np.asarray(first[:, None, None] * whole + shear[:, None, None] * own)


def _summed(nodes: IntArray, values: Array) -> tuple[IntArray, Array]:
    """Nodes (u,) that occur, and sums (u, ...) of ``values`` (c, n, ...) at them."""
    used, place = np.unique(nodes, return_inverse=True)
    count = nodes.size
    add = sp.csr_matrix(
        (np.ones(count), (place.reshape(-1), np.arange(count))), shape=(len(used), count)
    )
    return used, np.asarray(add @ values.reshape(count, -1))
