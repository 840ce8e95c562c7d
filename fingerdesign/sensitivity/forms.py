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

_ENTRIES = 2_000_000  # Of the largest temporary array: 16 MB.


@dataclass(frozen=True)
class Fields:
    """k fields of a body: moved (n, dim, k) mm, and pressure (pressures, k) MPa (0 rows: none)."""

    moved: Array
    pressure: Array


def reactions(body: Body, fields: Fields, changes: Sequence[Change]) -> Fields:
    """(dK/dp) u of every change and field, N; the fields of a change stand side by side."""
    count = fields.moved.shape[2]
    force, flow = (
        np.zeros((*each.shape[:-1], len(changes) * count))
        for each in (fields.moved, fields.pressure)
    )
    active = [_active(body, change) for change in changes]
    for part in _parts(body, active, count):
        here = _State(part, fields)
        for number, change in enumerate(changes):
            own = active[number][part.cells]
            if own.any():
                mine = slice(number * count, (number + 1) * count)
                here.react(change, own, force[..., mine], flow[:, mine])
    return Fields(force, flow)


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
    """Some cells, with gradients, stresses and pressures of k fields at their q points.

    Gradients and stresses are (cells, points, derivative, component, fields)."""

    def __init__(self, body: Body, cells: IntArray, numbers: IntArray) -> None:
        mesh, self.cells = body.mesh, cells
        order, self.nodes = strain_order(mesh.kind), mesh.cells[cells]
        slopes, weights = physical_gradients(mesh.points, self.nodes, order)
        self.shape = (*weights.shape, mesh.dimension)
        # (c, q d, n): products over cells are then those of matrices.
        self.slopes = slopes.swapaxes(2, 3).reshape(len(cells), -1, self.nodes.shape[1])
        self.weights = weights * body.thickness
        rule = quadrature(mesh.kind, order)
        self.hats = tabulate(mesh.kind, *rule, degree=1).value  # (corners, q)
        self.numbers, self.mixed = numbers[cells], body.pressed[cells]
        self.first, shear = lame_parameters(body.youngs_modulus[cells], body.poissons_ratio[cells])
        self.law = np.where(self.mixed, 0.0, self.first), shear

    def gradients(self, moved: Array) -> Array:
        """Gradients of fields (n, d, k) of the mesh."""
        own = moved[self.nodes].reshape(*self.nodes.shape, -1)
        return np.asarray(self.slopes @ own).reshape(*self.shape, self.shape[2], -1)


class _State:
    """Gradients, stresses and pressures of k fields at the points of some cells."""

    def __init__(self, part: _Part, fields: Fields) -> None:
        self.part = part
        self.grad = part.gradients(fields.moved)
        self.div = np.einsum("cqiik->cqk", self.grad)
        self.pressure = np.zeros_like(self.div)
        if part.mixed.any():
            own = fields.pressure[part.numbers[part.mixed]]
            self.pressure[part.mixed] = part.hats.T @ own
        self.stress = _stress(self.grad, *part.law)
        for i in range(self.grad.shape[2]):
            self.stress[:, :, i, i] -= self.pressure

    def react(self, change: Change, own: BoolArray, force: Array, flow: Array) -> None:
        """Add (dK/dp) u of the cells ``own`` to nodal forces (n, d, k), and to pressures' flows."""
        part = self.part
        stress, rate = self._changed(change, own)
        weights, nodes = part.weights[own], part.nodes[own]
        stress *= weights[:, :, None, None, None]
        flat = stress.reshape(len(nodes), part.slopes.shape[1], -1)
        _add(force, nodes, part.slopes[own].swapaxes(1, 2) @ flat)
        mixed = part.mixed[own]
        if mixed.any():
            rate = rate[mixed] * weights[mixed][:, :, None]
            _add(flow, part.numbers[own][mixed], -(part.hats @ rate))

    def _changed(self, change: Change, own: BoolArray) -> tuple[Array, Array]:
        """S and r of the module's equations."""
        part = self.part
        grad, pressure = self.grad[own], self.pressure[own]
        first = part.first[own, None, None]
        stress, rate = np.zeros_like(grad), np.zeros_like(pressure)
        if change.velocity is not None:
            flow = part.gradients(change.velocity[:, :, None])[own][..., 0]  # (c, q, j, i)
            growth = np.einsum("cqii->cq", flow)[:, :, None]
            whole = (*grad.shape[:3], -1)
            turned = (flow @ grad.reshape(whole)).reshape(grad.shape)
            carried = flow.swapaxes(2, 3) @ self.stress[own].reshape(whole)
            stress += self.stress[own] * growth[:, :, None, None]
            stress -= carried.reshape(grad.shape)
            stress -= _stress(turned, part.law[0][own], part.law[1][own])
            rate += self.div[own] * growth - np.einsum("cqiik->cqk", turned)
            rate += pressure * growth / first
        if change.moduli is not None:
            one, two = change.moduli[:, part.cells[own]]
            mixed = part.mixed[own]
            stress += _stress(grad, np.where(mixed, 0.0, one), two)
            rate -= pressure * one[:, None, None] / first**2
        return stress, rate

    def energy_with(self, other: "_State") -> tuple[Array, Array, Array]:
        """Of w^T dK u, with the other state's w: nodal forces (c, n, d, k), N, which velocities are
        multiplied with, and what both Lame parameters of a cell are, (c, k) mm^3."""
        part, same = self.part, other is self
        weights, first = part.weights[:, :, None], part.first[:, None, None]
        tensor = np.einsum("cqjik,cqlik->cqjlk", self.stress, other.grad)
        if not same:
            tensor = 0.5 * (tensor + np.einsum("cqjik,cqlik->cqjlk", other.stress, self.grad))
        tensor *= -2.0
        loss = other.pressure * (self.div + self.pressure / first)
        whole = np.einsum("cqjik,cqjik->cqk", self.stress, other.grad) - loss
        for i in range(tensor.shape[2]):
            tensor[:, :, i, i] += whole
        tensor *= weights[:, :, None, None]
        flat = tensor.reshape(len(part.cells), part.slopes.shape[1], -1)
        force = part.slopes.swapaxes(1, 2) @ flat
        volume = self.div * other.div
        volume[part.mixed] = (self.pressure * other.pressure / first**2)[part.mixed]
        shear = np.einsum("cqjik,cqjik->cqk", self.grad + self.grad.swapaxes(2, 3), other.grad)
        return force, (weights * volume).sum(axis=1), (weights * shear).sum(axis=1)


def _stress(grad: Array, first: Array, shear: Array) -> Array:
    """lame tr I + 2 mu sym of gradients (c, q, d, d, k)."""
    found = shear[:, None, None, None, None] * (grad + grad.swapaxes(2, 3))
    trace = first[:, None, None] * np.einsum("cqiik->cqk", grad)
    for i in range(grad.shape[2]):
        found[:, :, i, i] += trace
    return np.asarray(found)


def _add(total: Array, nodes: IntArray, values: Array) -> None:
    """Add values of cells (c, n, ...) to those of their ``nodes`` (c, n) in ``total``."""
    used, place = np.unique(nodes, return_inverse=True)
    count = nodes.size
    add = sp.csr_matrix(
        (np.ones(count), (place.reshape(-1), np.arange(count))), shape=(len(used), count)
    )
    total[used] += (add @ values.reshape(count, -1)).reshape(len(used), *total.shape[1:])
