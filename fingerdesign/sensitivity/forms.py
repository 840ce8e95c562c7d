"""Derivative of the elastic form with node places and moduli, contracted cell by cell.

    a(u, w) = integral lame div u div w + mu grad u : (grad w + grad w^T)
              (or, with a pressure p of its own,       ... - p div w - q div u - p q / lame)

With a velocity v of the nodes the gradient s of a shape function changes by ds = -(grad v) s, and
volumes by div v. With h = ds + s div v / 2 and P = integral s h^T of each two shape functions

    da = A + A^T,      A_ik = lame P_ik + mu P_ki + mu (tr P) delta_ik      (components i and k)

and of a pressure with the hat n: -integral n (ds + s div v), and -integral n n div v / lame. All by
the quadrature of the form itself, so that da is the exact derivative of the discrete form. With
moduli, h = s / 2. The matrix is found once for cells that are alike but for their places: those
above each other in a swept body.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.fem.elements import physical_gradients, quadrature, strain_order, tabulate
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.fem.system import Body, System, pressure_nodes
from fingerdesign.runtime.threads import in_threads
from fingerdesign.sensitivity.change import Change

_ENTRIES = 400_000  # Of the largest temporary array: 8 MB.
_PRESSURES, _ALL = 1, 2  # of a cell's unknowns
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

    fields (d + 1, r): the system's unknowns, then zeros. Shares of the first f fields in the sums:
    loads (f, k), and of both sides of the pairs (f, j).
    """
    first, count = loads.shape
    found = np.zeros((len(changes), fields.shape[1], count))
    between = np.zeros((len(changes), pairs[0].shape[1]))
    alike = np.array_equal(*pairs)

    def of(part: "_Part") -> tuple[IntArray, Array, Array]:
        used, local = _numbered(part.unknowns)
        own = fields.take(used, axis=0, mode="clip")  # a quarter of the time of "raise"

        def summed(shares: Array) -> Array:
            return part.without_translation((own[:, :first] @ shares)[local])

        def by(matrix: Array, values: Array) -> Array:
            return (matrix @ values.reshape(*local.shape[:2], -1)).reshape(local.size, -1)

        moved, here = summed(loads), summed(pairs[0])
        there = here if alike else summed(pairs[1])
        add = sp.csr_matrix((np.ones(local.size), (local.ravel(), np.arange(local.size))))
        force = np.empty((len(used), len(part.numbers), count))
        paired = np.zeros((len(part.numbers), pairs[0].shape[1]))
        for number, matrix in enumerate(part.matrices(changes)):
            force[:, number] = add @ by(matrix, moved)
            if here.size:
                each = here.reshape(local.size, -1), by(matrix, there)
                paired[number] = np.einsum("lj,lj->j", *each)
        product = own.T @ force.reshape(len(used), -1)
        product = product.reshape(fields.shape[1], *force.shape[1:]).swapaxes(0, 1)
        return part.numbers, product, paired

    for numbers, own, paired in in_threads(of, _parts(body, system, changes, max(count, 1))):
        found[numbers] += own
        between[numbers] += paired
    return found, between


def _numbered(values: IntArray) -> tuple[IntArray, IntArray]:
    """The numbers that occur, rising, and each value's place among them."""
    occurs = np.zeros(values.max() + 1, dtype=bool)
    occurs[values] = True
    return np.flatnonzero(occurs), (np.cumsum(occurs) - 1)[values]


def _unknowns(body: Body, system: System) -> tuple[IntArray, float]:
    """Numbers (c, m) of each cell's unknowns, axis by axis, then its pressures, and their unit.

    The number of unknowns stands for what is fixed or not there.
    """
    mesh, count = body.mesh, system.dofs
    number = np.full(mesh.points.size, count)
    moved, column = system.lift.nonzero()
    number[moved] = column
    found = number.reshape(mesh.points.shape)[mesh.cells].swapaxes(1, 2)
    found = found.reshape(len(mesh.cells), -1)
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
    moved = body.mesh.cells.shape[1] * body.mesh.dimension
    for cells in _classes(body, changes) if changes else []:
        acting = np.array([_acting(body, change, cells[:, 0]) for change in changes])
        along = body.mesh.points[body.mesh.corners[cells[:, 0]], 0].mean(axis=1)
        for level, own in ((_ALL, unknowns), (_PRESSURES, unknowns[:, moved:])):
            kinds, alike = np.unique(acting == level, axis=1, return_inverse=True)
            size = max(1, _ENTRIES // (max(own.shape[1], 1) * count * cells.shape[1]))
            for number, kind in enumerate(kinds.T):
                some = np.flatnonzero(alike.ravel() == number)
                some = cells[some[np.argsort(along[some], kind="stable")]]
                for start in range(0, len(some) * kind.any(), size):
                    here = some[start : start + size]
                    there = own[here].swapaxes(1, 2)
                    yield _Part(body, here[:, 0], there, np.flatnonzero(kind), unit)


def _at(velocity: sp.csr_matrix, nodes: IntArray) -> Array:
    """Velocities (c, n, dim) at the nodes of cells."""
    return np.asarray(velocity[nodes.ravel()].toarray()).reshape(*nodes.shape, -1)


def _acting(body: Body, change: Change, cells: IntArray) -> IntArray:
    """The part of each cell's stiffness that a parameter changes: nothing, _PRESSURES or _ALL."""
    found = np.zeros(len(cells), dtype=np.int64)
    if change.moduli is not None:
        first, shear = change.moduli[:, cells] != 0.0
        found[first & body.pressed[cells]] = _PRESSURES
        found[shear | (first & ~body.pressed[cells])] = _ALL
    if change.velocity is not None:
        velocity = _at(change.velocity, body.mesh.cells[cells])
        found[(velocity != velocity[:, :1]).any(axis=(1, 2))] = _ALL
    return found


class _Part:
    """c classes of z cells, with the gradients of n shape functions at their q points.

    cells (c,): one of each class; unknowns (c, m, z): all, or the pressures alone; numbers (a,) of
    the changes that change them; slopes (c, q, d, n); weights (c, q); mixed (c,): those with
    pressures; first and shear (c,): both of Lame's; hats (corners, q), times the pressures' unit,
    or none; solid: the number of a cell's unknowns that are displacements.
    """

    def __init__(
        self, body: Body, cells: IntArray, unknowns: IntArray, numbers: IntArray, unit: float
    ) -> None:
        mesh, order = body.mesh, strain_order(body.mesh.kind)
        self.cells, self.nodes, self.mixed = cells, mesh.cells[cells], body.pressed[cells]
        self.unknowns, self.numbers = unknowns, numbers
        slopes, weights = physical_gradients(mesh.points, self.nodes, order)
        self.slopes = np.ascontiguousarray(slopes.swapaxes(2, 3))
        self.weights = weights * body.thickness
        hats = unit * tabulate(mesh.kind, *quadrature(mesh.kind, order), degree=1).value
        self.hats = hats[: unknowns.shape[1] % (self.nodes.shape[1] * mesh.dimension)]
        self.solid = unknowns.shape[1] - len(self.hats)
        moduli = body.youngs_modulus[cells], body.poissons_ratio[cells]
        self.first, self.shear = lame_parameters(*moduli)

    def without_translation(self, values: Array) -> Array:
        """Fields (c, m, z, k) of cells, less what their first nodes do.

        A plate of metal moves much and strains little: the stresses of its motion would round.
        """
        dim, nodes = self.slopes.shape[2:]
        for axis in range(dim if self.solid else 0):
            own = values[:, axis * nodes : (axis + 1) * nodes]
            own -= own[:, :1].copy()
        return values

    def matrices(self, changes: Sequence[Change]) -> Iterator[Array]:
        """dK (c, m, m) of one cell of each class, by each that changes it."""
        size = self.unknowns.shape[1]
        for number in self.numbers:
            change, found = changes[number], np.zeros((len(self.cells), size, size))
            if change.velocity is not None:
                self._move(found, _at(change.velocity, self.nodes))
            if change.moduli is not None:
                self._stiffen(found, *change.moduli[:, self.cells])
            yield found

    def _move(self, found: Array, velocity: Array) -> None:
        """Add what a velocity (c, n, d) of the nodes does to dK (c, m, m)."""
        size, (count, points, dim, nodes) = self.solid, self.slopes.shape
        flow = self.slopes.reshape(count, -1, nodes) @ velocity
        flow = flow.reshape(count, points, dim, dim)  # of the component k along the axis i: (i, k)
        growth = np.trace(flow, axis1=2, axis2=3)
        turned, grown = -flow @ self.slopes, growth[:, :, None, None] * self.slopes
        self._add(found, turned + 0.5 * grown, np.where(self.mixed, 0.0, self.first), self.shear)
        if not len(self.hats):
            return
        pull = self.weights[:, :, None] * (turned + grown).reshape(count, points, size)
        pull = -self.hats @ pull
        found[:, size:, :size] += pull
        found[:, :size, size:] += pull.swapaxes(1, 2)
        self._add_pressures(found, self.weights * growth, self.first)

    def _stiffen(self, found: Array, first: Array, shear: Array) -> None:
        """Add what rates (c,) of both of Lame's parameters do to dK (c, m, m)."""
        if self.solid:
            self._add(found, 0.5 * self.slopes, np.where(self.mixed, 0.0, first), shear)
        if len(self.hats) and first.any():
            self._add_pressures(found, -self.weights * first[:, None], self.first**2)

    def _add(self, found: Array, changed: Array, first: Array, shear: Array) -> None:
        """Add A + A^T of h (c, q, d, n) and of both of Lame's parameters (c,)."""
        count, points, dim, nodes = changed.shape
        size, both = dim * nodes, [self.slopes, self.weights[:, :, None, None] * changed]
        left, right = (
            np.concatenate(each, axis=1).reshape(count, 2 * points, size)
            for each in (both, both[::-1])
        )
        product = left.swapaxes(1, 2) @ right  # P + P^T
        product = product.reshape(count, dim, nodes, dim, nodes)
        own = product.swapaxes(1, 3).copy()
        trace = sum(product[:, axis, :, axis] for axis in range(dim))
        for axis in range(dim):
            own[:, axis, :, axis] += trace
        own *= shear[:, None, None, None, None]
        if first.any():
            own += first[:, None, None, None, None] * product
        found[:, :size, :size] += own.reshape(count, size, size)

    def _add_pressures(self, found: Array, weights: Array, yielding: Array) -> None:
        """Add -hats hats^T of these weights (c, q) over (c,), where cells have pressures."""
        size = self.solid
        with np.errstate(divide="ignore", invalid="ignore"):
            weights = np.where(self.mixed[:, None], weights / yielding[:, None], 0.0)
        found[:, size:, size:] -= (self.hats * weights[:, None]) @ self.hats.T
