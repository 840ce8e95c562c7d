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
from dataclasses import dataclass, fields

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.fem.elements import physical_gradients, quadrature, strain_order, tabulate
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.fem.system import Body, pressure_nodes
from fingerdesign.sensitivity.change import Change

_ENTRIES = 2_000_000  # Of the largest temporary array: 16 MB.
_CELLS = 4  # Whose stresses are multiplied at a time: they stay in the processor's cache.


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
        here = _State.of(part, right)
        alike: dict[bytes, list[int]] = {}
        for number, whole in enumerate(active):
            alike.setdefault(whole[part.cells].tobytes(), []).append(number)
        for own, numbers in alike.items():
            cells = np.frombuffer(own, dtype=bool)
            if cells.any():
                found[numbers] += here.only(cells).products([changes[n] for n in numbers], left)
    return found


def energies(body: Body, left: Fields, right: Fields, changes: Sequence[Change]) -> Array:
    """w^T (dK/dp) u (changes, k), N mm, of k pairs: one nodal force, of all changes alike."""
    found = np.zeros((len(changes), right.moved.shape[2]))
    active = [_active(body, change) for change in changes]
    for part in _parts(body, active, found.shape[1]):
        here = _State.of(part, right)
        there = here if left is right else _State.of(part, left)
        force, volume, shear = here.energy_with(there)
        used, add = _sums(part.nodes)
        force = add @ force.reshape(part.nodes.size, -1)
        for number, change in enumerate(changes):
            if change.velocity is not None:
                found[number] += change.velocity[used].ravel() @ force.reshape(-1, found.shape[1])
            if change.moduli is not None:
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


def _parts(body: Body, active: Sequence[BoolArray], count: int) -> Iterator["_Part"]:
    """The cells that any change changes, as many at a time as memory has for ``count`` fields.

    By their places along x: most changes are of one plate, and its cells are then in few parts.
    """
    kind = body.mesh.kind
    points = quadrature(kind, strain_order(kind))[1].size
    size = max(1, _ENTRIES // (points * body.mesh.dimension**2 * max(count, 1)))
    numbers = _pressure_numbers(body)
    some = np.flatnonzero(np.any(active, axis=0)) if len(active) else np.empty(0, dtype=np.int64)
    some = some[
        np.argsort(body.mesh.points[body.mesh.corners[some], 0].mean(axis=1), kind="stable")
    ]
    for start in range(0, len(some), size):
        yield _Part.of(body, some[start : start + size], numbers)


@dataclass(frozen=True)
class _Part:
    """c cells, with the gradients of n shape functions at their q points.

    slopes (c, q d, n): products over cells are then those of matrices; weights (c, q); numbers
    (c, corners) of pressures, in ``mixed`` cells (c,); first (c,) and law (c, d d, d d): of
    Lame's first parameter, and of what of it is not the pressure's; hats (corners, q).
    """

    cells: IntArray
    nodes: IntArray
    slopes: Array
    weights: Array
    numbers: IntArray
    mixed: BoolArray
    first: Array
    law: Array
    hats: Array

    @classmethod
    def of(cls, body: Body, cells: IntArray, numbers: IntArray) -> "_Part":
        """These cells of a body."""
        mesh, mixed = body.mesh, body.pressed[cells]
        order, nodes = strain_order(mesh.kind), mesh.cells[cells]
        slopes, weights = physical_gradients(mesh.points, nodes, order)
        slopes = slopes.swapaxes(2, 3).reshape(len(cells), -1, nodes.shape[1])
        hats = tabulate(mesh.kind, *quadrature(mesh.kind, order), degree=1).value
        first, shear = lame_parameters(body.youngs_modulus[cells], body.poissons_ratio[cells])
        law = _law(np.where(mixed, 0.0, first), shear, mesh.dimension)
        weights = weights * body.thickness
        return cls(cells, nodes, slopes, weights, numbers[cells], mixed, first, law, hats)

    @property
    def shape(self) -> tuple[int, int]:
        """Points in a cell, and dimension."""
        points = self.weights.shape[1]
        return points, self.slopes.shape[1] // points

    def only(self, own: BoolArray) -> "_Part":
        """Some of the cells."""
        every = {each.name: getattr(self, each.name) for each in fields(self)}
        return _Part(
            **{name: each if name == "hats" else each[own] for name, each in every.items()}
        )

    def gradients(self, moved: Array) -> Array:
        """Gradients (c, q, derivative, component, k) of fields (n, d, k) of the mesh."""
        found = self.slopes @ moved[self.nodes].reshape(*self.nodes.shape, -1)
        return np.asarray(found.reshape(len(found), *self.shape, self.shape[1], -1))

    def rates(self, change: Change) -> tuple[Array, Array]:
        """Matrices (c, q, d d, d d + 1) and rows (c, q, d d + 1), with the points' weights: S and r
        of the module's equations are they times gradient and pressure."""
        (points, dim), first, law = self.shape, self.first[:, None], self.law
        one, count, weights = np.eye(dim), len(self.cells), self.weights
        stress = np.zeros((count, points, dim**2, dim**2 + 1))
        rate = np.zeros((count, points, dim**2 + 1))
        if change.velocity is not None:
            flow = self.gradients(change.velocity[:, :, None])[..., 0]  # (c, q, j, i)
            flow *= weights[:, :, None, None]
            growth = np.einsum("cqii->cq", flow)
            still = np.zeros((count, points, dim**2, dim**2))
            turn = np.zeros((count, dim**2, points * dim**2))
            there = still.reshape(count, points, *(dim,) * 4)  # (c, q, j, i, l, k)
            across = turn.reshape(count, dim, dim, points, dim, dim)  # (c, j, i, q, l, k)
            for i in range(dim):
                there[..., i, :, i] = -flow.swapaxes(2, 3)
                across[:, :, i, :, :, i] = flow.transpose(0, 2, 1, 3)
            still += growth[:, :, None, None] * np.eye(dim**2)
            # One product a cell, not one a point.
            stress[..., :-1] = (still.reshape(count, -1, dim**2) @ law).reshape(still.shape)
            stress[..., :-1] -= (law @ turn).reshape(count, dim**2, points, -1).swapaxes(1, 2)
            stress[..., -1] = -still @ one.ravel()
            rate[..., :-1] = growth[:, :, None] * one.ravel()
            rate[..., :-1] -= flow.swapaxes(2, 3).reshape(*growth.shape, -1)
            rate[..., -1] = growth / first
        if change.moduli is not None:
            rise, shear = change.moduli[:, self.cells]
            own = _law(np.where(self.mixed, 0.0, rise), shear, dim)
            stress[..., :-1] += weights[:, :, None, None] * own[:, None]
            rate[..., -1] -= weights * (rise[:, None] / first**2)
        return stress, rate


@dataclass(frozen=True)
class _State:
    """Gradients and pressures (c, q, d d + 1, k) of k fields at the points of some cells."""

    part: _Part
    both: Array

    @classmethod
    def of(cls, part: _Part, given: Fields) -> "_State":
        """The state of fields of the body."""
        grad = part.gradients(given.moved)
        count, (points, dim), size = len(grad), part.shape, grad.shape[-1]
        both = np.zeros((count, points, dim**2 + 1, size))
        both[:, :, :-1] = grad.reshape(count, points, dim**2, size)
        if part.mixed.any():
            own = given.pressure[part.numbers[part.mixed]]
            both[part.mixed, :, -1] = part.hats.T @ own
        return cls(part, both)

    def only(self, own: BoolArray) -> "_State":
        """That of some of the cells."""
        return self if own.all() else _State(self.part.only(own), self.both[own])

    def products(self, changes: Sequence[Change], left: Fields) -> Array:
        """These cells' share (changes, left, right) in the products of changes."""
        part, both, number = self.part, self.both, len(changes)
        count, flat, fields = len(both), part.slopes.shape[1], self.both.shape[-1]
        found = [part.rates(change) for change in changes]
        # Rows by the stress' derivative and component, then by change: one product for all.
        stress = np.stack([each[0] for each in found], axis=3).reshape(
            *both.shape[:2], -1, both.shape[2]
        )
        turned = part.slopes.swapaxes(1, 2)
        force = np.empty((count, turned.shape[1], stress.shape[2] // part.shape[1] * fields))
        for first in range(0, count, _CELLS):
            some = slice(first, first + _CELLS)
            here = (stress[some] @ both[some]).reshape(-1, flat, force.shape[2])
            np.matmul(turned[some], here, out=force[some])
        used, add = _sums(part.nodes)
        force = (add @ force.reshape(part.nodes.size, -1)).reshape(-1, number * fields)
        product = left.moved[used].reshape(len(force), -1).T @ force
        rate = np.stack([each[1] for each in found], axis=1)
        hats = part.hats[:, None, :, None] * rate[:, None]  # (c, corners, changes, q, d d + 1)
        hats = hats.reshape(count, len(part.hats) * number, both.shape[1] * both.shape[2])
        flow = (hats @ both.reshape(count, -1, fields))[part.mixed]
        pressed, add = _sums(part.numbers[part.mixed])
        product -= left.pressure[pressed].T @ (add @ flow.reshape(add.shape[1], number * fields))
        return np.asarray(product.reshape(len(product), number, fields).swapaxes(0, 1))

    def energy_with(self, other: "_State") -> tuple[Array, Array, Array]:
        """Of w^T dK u, with the other state's w: nodal forces (c, n, d, k), N, which velocities are
        multiplied with, and what both Lame parameters of a cell are, (c, k) mm^3."""
        part = self.part
        weights, first = part.weights[:, :, None], part.first[:, None, None]
        grad, div, pressure, stress = self._parts()
        there = (grad, div, pressure, stress) if other is self else other._parts()
        others, other_div, other_pressure, other_stress = there
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


def _sums(nodes: IntArray) -> tuple[IntArray, sp.csr_matrix]:
    """Nodes (u,) that occur among those of cells (c, n), and the matrix (u, c n) that sums values
    of cells at them."""
    used, place = np.unique(nodes, return_inverse=True)
    entries = np.ones(nodes.size), (place.reshape(-1), np.arange(nodes.size))
    return used, sp.csr_matrix(entries, shape=(len(used), nodes.size))
