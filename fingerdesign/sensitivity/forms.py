"""Derivative of the elastic form with node places and moduli, contracted cell by cell.

    a(u, w) = integral 2 mu eps(u) : eps(w) + lame div u div w      (or, with a pressure p of its
              own,       ... - p div w - q div u - p q / lame)

With a velocity v of the nodes, D = grad v, gradients change by -grad u D and volumes by div v:

    da = integral S : grad w - q r,     S = sigma div v - sigma D^T - law(sym(grad u D))
                                        r = div u div v - tr(grad u D) + p div v / lame

by the quadrature of the form itself, so that da is the exact derivative of the discrete form. Its
matrix is found once for cells that are alike but for their places: those above each other in a
swept body.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.fem.elements import physical_gradients, quadrature, strain_order, tabulate
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.fem.system import Body, System, pressure_nodes
from fingerdesign.runtime.threads import in_threads
from fingerdesign.sensitivity.change import Change

_ENTRIES = 400_000  # Of the largest temporary array: 8 MB.
_PAIRS = 24  # That are multiplied at a time: they stay in the processor's cache.
_ALIKE = 1e-12  # Of the body's size, and of the fastest node: a smaller difference is rounding.


def products(
    body: Body,
    system: System,
    changes: Sequence[Change],
    fields: Array,
    loads: Array,
    pairs: tuple[Array, Array],
) -> tuple[Array, Array]:
    """w^T (dK/dp) u, N mm, of all fields and of k of their sums: (changes, r, k); and of j pairs of
    sums: (changes, j).

    fields (r, more than d): the system's unknowns, then zeros. Shares of the first f fields in the
    sums: loads (f, k), and of both sides of the pairs (f, j).
    """
    first, count = loads.shape
    found = np.zeros((len(changes), len(fields), count))
    between = np.zeros((len(changes), pairs[0].shape[1]))
    shares = [sp.csr_matrix(side.T) for side in pairs]

    def of(part: "_Part") -> tuple[IntArray, Array, Array | None]:
        used, local = _numbered(part.unknowns)
        left = fields.take(used, axis=1)
        moved = part.without_translation((left[:first].T @ loads)[local], 1)
        moved = moved.reshape(*local.shape[:2], local.shape[2] * count)
        add = sp.csr_matrix((np.ones(local.size), (local.ravel(), np.arange(local.size))))
        matrices = part.matrices(changes)
        force = np.empty((len(used), len(matrices), count))
        for number, each in enumerate(matrices):
            force[:, number] = add @ (each @ moved).reshape(local.size, count)
        product = left @ force.reshape(len(used), len(matrices) * count)
        own = product.reshape(len(left), *force.shape[1:]).swapaxes(0, 1)
        if not between.size:
            return part.numbers, own, None
        both = [part.without_translation((side @ left[:first])[:, local], 2) for side in shares]
        return part.numbers, own, _of_pairs(matrices, *both)

    for numbers, own, paired in in_threads(of, _parts(body, system, changes, max(count, 1))):
        found[numbers] += own
        if paired is not None:
            between[numbers] += paired
    return found, between


def _of_pairs(matrices: Array, here: Array, there: Array) -> Array:
    """w^T dK u (a, j) by matrices (a, c, m, m) of pairs of fields (j, c, m, z)."""
    found = np.zeros((len(matrices), len(here)))
    for number in range(here.shape[1]):
        own = matrices[:, number].reshape(len(matrices), -1)
        for start in range(0, len(here), _PAIRS):
            some = slice(start, start + _PAIRS)
            both = here[some, number] @ there[some, number].swapaxes(1, 2)
            found[:, some] += own @ both.reshape(len(both), -1).T
    return found


def _numbered(values: IntArray) -> tuple[IntArray, IntArray]:
    """The numbers that occur, rising, and each value's place among them."""
    occurs = np.zeros(values.max() + 1, dtype=bool)
    occurs[values] = True
    return np.flatnonzero(occurs), (np.cumsum(occurs) - 1)[values]


def _unknowns(body: Body, system: System) -> tuple[IntArray, float]:
    """Numbers (c, m) of each cell's unknowns, node by node, then its pressures, and their unit.

    The number of unknowns stands for what is fixed or not there.
    """
    mesh, count = body.mesh, system.dofs
    number = np.full(mesh.points.size, count)
    moved, column = system.lift.nonzero()
    number[moved] = column
    found = number.reshape(mesh.points.shape)[mesh.cells].reshape(len(mesh.cells), -1)
    if system.pressure_lift is None:
        return found, 0.0
    inside = body.pressed
    moduli = body.youngs_modulus[inside], body.poissons_ratio[inside]
    pressures = np.full(mesh.corners.shape, count)
    own = pressure_nodes(mesh.corners[inside], *moduli)[0]
    pressures[inside] = system.pressure_lift.nonzero()[1][own]
    return np.hstack([found, pressures]), float(system.pressure_lift.data[0])


def _classes(body: Body, changes: Sequence[Change]) -> list[IntArray]:
    """Cells (c, z) of c classes, one array a z; those of a class have one matrix, whatever the
    change."""
    mesh, chance = body.mesh, np.random.default_rng(0)
    moving, moduli = np.zeros_like(mesh.points), np.zeros((2, len(mesh.cells)))
    for change, share in zip(changes, chance.uniform(1.0, 2.0, len(changes)), strict=True):
        if change.velocity is not None:
            moving += share * change.velocity.toarray()
        if change.moduli is not None:
            moduli += share * change.moduli
    keys = [body.youngs_modulus, body.poissons_ratio, body.pressed, *moduli]
    parts = [np.unique(np.array(keys), axis=1, return_inverse=True)[1].reshape(-1, 1)]
    for field in (mesh.points, moving):
        own = field[mesh.cells] - field[mesh.cells[:, :1]]
        unit = _ALIKE * max(np.abs(field).max(), 1e-300)
        parts.append(np.round(own / unit).reshape(len(own), -1).astype(np.int64))
    key = np.hstack(parts)
    key = key @ chance.integers(1, 2**62, key.shape[1])
    alike, times = np.unique(key, return_inverse=True, return_counts=True)[1:]
    order, ends = np.argsort(alike, kind="stable"), np.cumsum(times)
    return [
        order[(ends[times == size] - size)[:, None] + np.arange(size)] for size in np.unique(times)
    ]


def _parts(body: Body, system: System, changes: Sequence[Change], count: int) -> Iterator["_Part"]:
    """The cells that any change changes: those that the same ones change, near each other along x,
    as many at a time as memory has for ``count`` fields."""
    unknowns, unit = _unknowns(body, system)
    for cells in _classes(body, changes) if changes else []:
        active = np.array([_active(body, change, cells[:, 0]) for change in changes])
        kinds, alike = np.unique(active, axis=1, return_inverse=True)
        along = body.mesh.points[body.mesh.corners[cells[:, 0]], 0].mean(axis=1)
        size = max(1, _ENTRIES // (unknowns.shape[1] * count * cells.shape[1]))
        for number, kind in enumerate(kinds.T):
            some = np.flatnonzero(alike.ravel() == number)
            some = cells[some[np.argsort(along[some], kind="stable")]]
            for start in range(0, len(some) * kind.any(), size):
                own = some[start : start + size]
                there = unknowns[own].swapaxes(1, 2)
                yield _Part.of(body, own[:, 0], there, np.flatnonzero(kind), unit)


def _at(velocity: sp.csr_matrix, nodes: IntArray) -> Array:
    """Velocities (c, n, dim) at the nodes of cells."""
    return np.asarray(velocity[nodes.ravel()].toarray()).reshape(*nodes.shape, -1)


def _active(body: Body, change: Change, cells: IntArray) -> BoolArray:
    """Which cells' stiffness a parameter changes."""
    found = np.zeros(len(cells), dtype=bool)
    if change.velocity is not None:
        velocity = _at(change.velocity, body.mesh.cells[cells])
        found |= (velocity != velocity[:, :1]).any(axis=(1, 2))
    if change.moduli is not None:
        found |= change.moduli[:, cells].any(axis=0)
    return found


@dataclass(frozen=True)
class _Part:
    """c classes of z cells, with the gradients of n shape functions at their q points.

    cells (c,): one of each class; unknowns (c, m, z); numbers (a,) of the changes that change them;
    slopes (c, q d, n); weights (c, q); mixed (c,): those with pressures; first (c,) and
    law (c, d d, d d): of Lame's first parameter, and of what of it is not the pressure's; hats
    (corners, q), times the pressures' unit, or none.
    """

    cells: IntArray
    nodes: IntArray
    unknowns: IntArray
    numbers: IntArray
    slopes: Array
    weights: Array
    mixed: BoolArray
    first: Array
    law: Array
    hats: Array

    @classmethod
    def of(
        cls, body: Body, cells: IntArray, unknowns: IntArray, numbers: IntArray, unit: float
    ) -> "_Part":
        """These cells of a body."""
        mesh, mixed = body.mesh, body.pressed[cells]
        order, nodes = strain_order(mesh.kind), mesh.cells[cells]
        slopes, weights = physical_gradients(mesh.points, nodes, order)
        slopes = slopes.swapaxes(2, 3).reshape(len(cells), -1, nodes.shape[1])
        hats = unit * tabulate(mesh.kind, *quadrature(mesh.kind, order), degree=1).value
        hats = hats[: unknowns.shape[1] - nodes.shape[1] * mesh.dimension]
        first, shear = lame_parameters(body.youngs_modulus[cells], body.poissons_ratio[cells])
        law = _law(np.where(mixed, 0.0, first), shear, mesh.dimension)
        weights = weights * body.thickness
        return cls(cells, nodes, unknowns, numbers, slopes, weights, mixed, first, law, hats)

    def without_translation(self, values: Array, axis: int) -> Array:
        """Fields of cells, with unknowns along ``axis``, less what their first nodes do.

        A plate of metal moves much and strains little: the stresses of its motion would round.
        """
        own, dim = np.moveaxis(values, axis, 0), int(np.sqrt(self.law.shape[1]))
        size = self.slopes.shape[2] * dim
        for i, first in enumerate(own[:dim].copy()):
            own[i:size:dim] -= first
        return values

    def matrices(self, changes: Sequence[Change]) -> Array:
        """dK (a, c, m, m) of one cell of each class, by all that change it."""
        size = self.unknowns.shape[1]
        found = np.empty((len(self.numbers), len(self.cells), size, size))
        for each, number in zip(found, self.numbers, strict=True):
            self._fill(each, changes[number])
        return found

    def _fill(self, found: Array, change: Change) -> None:
        """Put dK (c, m, m) of a change there."""
        stress, pull, square = self._laws(change)
        slopes, hats, (count, points, dim) = self.slopes, self.hats, pull.shape[:3]
        turned, nodes = slopes.swapaxes(1, 2), slopes.shape[2]
        stress = stress.swapaxes(4, 5).reshape(count, points, dim**3, dim)
        force = stress @ slopes.reshape(count, points, dim, nodes)
        solid = turned @ force.reshape(count, points * dim, -1)
        solid = solid.reshape(count, nodes, dim, dim, nodes).swapaxes(3, 4)
        size = nodes * dim
        found[:, :size, :size] = solid.reshape(count, size, size)
        pressed = (pull[..., None] * hats.T[:, None, None]).reshape(count, points * dim, -1)
        found[:, :size, size:] = (turned @ pressed).reshape(count, size, -1)
        found[:, size:, :size] = found[:, :size, size:].swapaxes(1, 2)
        found[:, size:, size:] = -(hats * square[:, None]) @ hats.T

    def _laws(self, change: Change) -> tuple[Array, Array, Array]:
        """The matrix (c, q, j, i, l, k) of S on grad u and (c, q, j, i) on p, and r on p (c, q),
        with the points' weights; derivatives j and l along axes, of components i and k."""
        first, law, weights = self.first[:, None], self.law, self.weights
        (count, points), dim = weights.shape, int(np.sqrt(law.shape[1]))
        stress = np.zeros((count, points, dim**2, dim**2))
        pull, square = np.zeros((count, points, dim, dim)), np.zeros((count, points))
        if change.velocity is not None:
            flow = self.slopes @ _at(change.velocity, self.nodes)
            flow = flow.reshape(count, points, dim, dim) * weights[:, :, None, None]
            growth = np.einsum("cqii->cq", flow)
            still = np.zeros((count, points, dim**2, dim**2))
            turn = np.zeros((count, dim**2, points * dim**2))
            there = still.reshape(count, points, *(dim,) * 4)
            across = turn.reshape(count, dim, dim, points, dim, dim)  # (c, j, i, q, l, k)
            for i in range(dim):
                there[..., i, :, i] = -flow.swapaxes(2, 3)
                across[:, :, i, :, :, i] = flow.transpose(0, 2, 1, 3)
            still += growth[:, :, None, None] * np.eye(dim**2)
            # One product a cell, not one a point.
            stress += (still.reshape(count, -1, dim**2) @ law).reshape(still.shape)
            stress -= (law @ turn).reshape(count, dim**2, points, -1).swapaxes(1, 2)
            pull -= (still @ np.eye(dim).ravel()).reshape(pull.shape)
            square += growth / first
        if change.moduli is not None:
            rise, shear = change.moduli[:, self.cells]
            own = _law(np.where(self.mixed, 0.0, rise), shear, dim)
            stress += weights[:, :, None, None] * own[:, None]
            square -= weights * (rise[:, None] / first**2)
        return stress.reshape(count, points, *(dim,) * 4), pull, square


def _law(first: Array, shear: Array, dim: int) -> Array:
    """lame tr I + 2 mu sym, as matrices (c, d d, d d) on gradients."""
    one = np.eye(dim)
    whole = np.outer(one, one)
    turned = np.einsum("jk,il->jilk", one, one).reshape(whole.shape)
    own = np.eye(dim**2) + turned
    return np.asarray(first[:, None, None] * whole + shear[:, None, None] * own)
