"""A body that mirrors in z = 0, condensed as two problems of half its size.

With S the mirror image of a field, (u_x, u_y, -u_z) and pressures as they are, S K = K S. So K
couples no even field, S q = q, with an odd one, S q = -q, and

    K^-1 = E K_e^-1 E^T + O K_o^-1 O^T,     K_e = E^T K E,   K_o = O^T K O,

with orthonormal bases E and O. Two factorisations of half the unknowns replace one: for swept
fingers a third of the work. Functionals that are mirror images of each other border each half by
their sum or their difference.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.system import System

_SAME = 1e-9  # mm: places that are one
_ALIKE = 1e-9  # Relative: values that differ by less are those of mirror images.
_ALONG_Z = 2
_WORTH = 10_000  # Fewer unknowns are condensed faster as they are.


@dataclass(frozen=True)
class Mirror:
    """The mirror images of n unknowns or functionals: the ``partner`` (n,) of each, which may be
    itself, and the ``sign`` (n,) of its value in the image; 0: it has no image."""

    partner: IntArray
    sign: Array

    def image(self, values: Array) -> Array:
        """The mirror image (n,) of values (n,)."""
        return np.asarray(self.sign * values[self.partner])

    def halves(self) -> tuple["Half", "Half"]:
        """Even and odd values. What has no image is part of both."""
        here = np.arange(len(self.partner))
        first, alone = np.minimum(here, self.partner), self.partner == here
        found = []
        for turn in (1.0, -1.0):
            own = np.where(alone, (self.sign == turn) | (self.sign == 0.0), True)
            weight = np.where(here == first, 1.0, turn * self.sign)
            weight = own * np.where(alone, 1.0, np.sqrt(0.5) * weight)
            firsts = np.unique(first[own])
            vector = np.searchsorted(firsts, first).clip(max=max(len(firsts) - 1, 0))
            found.append(Half(vector, weight, len(firsts)))
        return found[0], found[1]


@dataclass(frozen=True)
class Half:
    """An orthonormal basis of ``size`` vectors. Each of n unknowns is part of one, ``vector`` (n,),
    with a ``weight`` (n,); 0: of none."""

    vector: IntArray
    weight: Array
    size: int

    @cached_property
    def basis(self) -> sp.csr_matrix:
        """The vectors as columns (n, size)."""
        here = np.arange(len(self.vector))
        shape = len(here), self.size
        return sp.csr_matrix((self.weight, (here, self.vector)), shape=shape)


def _folded(matrix: sp.csr_matrix, rows: Half, columns: Half, upper: bool = False) -> sp.csr_matrix:
    """A matrix (n, m) in two bases (size, size). upper: it is symmetric and given, as the result
    is, by its upper triangle.

    Stored zeros stay, as in a product they would not: the places that are stored decide the order
    of elimination.
    """
    found = matrix.tocoo()
    factor = rows.weight[found.row] * columns.weight[found.col]
    some = factor != 0.0
    row, column = rows.vector[found.row[some]], columns.vector[found.col[some]]
    values = factor[some] * found.data[some]
    if upper:
        values[(row == column) & (found.row != found.col)[some]] *= 2.0
        row, column = np.minimum(row, column), np.maximum(row, column)
    shape = rows.size, columns.size
    return sp.csr_matrix(sp.coo_matrix((values, (row, column)), shape=shape))


class MirroredCondensation:
    """A :class:`Condensation` of a body that mirrors, by halves: the same ``matrix``,
    ``operations``, ``solve`` and ``fields``."""

    def __init__(
        self, system: System, rows: sp.csr_matrix, mirror: Mirror, borders: tuple[Half, Half]
    ) -> None:
        """rows (r, d) and errors: as of a Condensation. borders: halves of the rows, none empty."""
        assert system.places is not None
        pressed = system.places[:, 1] >= system.held.shape[1]
        self.matrix, self.operations = np.zeros((rows.shape[0], rows.shape[0])), 0.0
        self._parts = []
        for half, border in zip(mirror.halves(), borders, strict=True):
            stiffness = _folded(system.stiffness, half, half, upper=True)
            stiffness.sort_indices()
            bordering = _folded(rows, border, half)
            bordering.sort_indices()
            pressures = np.unique(half.vector[pressed & (half.weight != 0.0)])
            part = Condensation(stiffness, bordering, len(pressures))
            self.matrix += border.basis @ (border.basis @ part.matrix).T
            self.operations += part.operations
            self._parts.append((half.basis, border.basis, part))

    def solve(self, loads: Array) -> Array:
        """K^-1 loads for loads (d, k)."""
        return np.asarray(
            sum(basis @ part.solve(basis.T @ loads) for basis, _, part in self._parts)
        )

    def fields(self, rows: IntArray) -> Array:
        """K^-1 R^T of a unit force on each of some rows (k,): one field a column (d + 1, k); the
        last row is zero."""
        found = np.zeros((self._parts[0][0].shape[0] + 1, len(rows)))
        for basis, border, part in self._parts:
            own = border[rows]
            used = np.unique(own.indices)
            found[:-1] += basis @ (part.fields(used)[:-1] @ own[:, used].T)
        return found


Factors = Condensation | MirroredCondensation


def factored(system: System, rows: sp.csr_matrix, points: Array) -> Factors:
    """Condense a system on a mesh's points (n, dim) onto functionals (r, d): by halves where it
    mirrors in z = 0."""
    mirror = mirror_of(system, points) if system.dofs >= _WORTH else None
    if mirror is not None:
        borders = _mirror_of_rows(rows, mirror).halves()
        if all(each.size for each in borders):
            return MirroredCondensation(system, rows, mirror, borders)
    return Condensation(system.stiffness, rows, system.pressures)


def mirror_of(system: System, points: Array) -> Mirror | None:
    """The mirror of a system on a mesh's points (n, dim); None where it has none in z = 0."""
    if system.places is None or points.shape[1] != 3:
        return None
    node, kind = system.places.T
    used = np.unique(node)
    if abs(points[used, _ALONG_Z].min() + points[used, _ALONG_Z].max()) > _SAME:
        return None
    from scipy.spatial import cKDTree  # 0.1 s of each start

    away, nearest = cKDTree(points).query(points[used] * [1.0, 1.0, -1.0])
    if away.max() > _SAME:
        return None
    image = np.full(len(points), -1)
    image[used] = nearest
    kinds = int(kind.max()) + 1
    keys, sought = node * kinds + kind, image[node] * kinds + kind
    order = np.argsort(keys)
    partner = order[np.searchsorted(keys, sought, sorter=order).clip(max=len(keys) - 1)]
    if (keys[partner] != sought).any():
        return None
    mirror = Mirror(partner, np.where(kind == _ALONG_Z, -1.0, 1.0))
    field = np.random.default_rng(0).standard_normal(len(keys))
    force, other = (_product(system.stiffness, each) for each in (field, mirror.image(field)))
    # Row by row: what is soft may differ where a stiff part hides it in the whole.
    sizes = _product(abs(system.stiffness), np.abs(mirror.image(field)))
    alike = np.abs(mirror.image(force) - other) <= _ALIKE * sizes
    return mirror if alike.all() else None


def _product(upper: sp.csr_matrix, values: Array) -> Array:
    """A symmetric matrix, given by its upper triangle, times values (n,)."""
    return np.asarray(upper @ values + upper.T @ values - upper.diagonal() * values)


def _mirror_of_rows(rows: sp.csr_matrix, mirror: Mirror) -> Mirror:
    """The mirror of functionals (r, d), known by their values in a random field and its image."""
    field = np.random.default_rng(1).standard_normal(rows.shape[1])
    here, there = rows @ field, rows @ mirror.image(field)
    near = _ALIKE * (abs(rows) @ np.abs(field))
    order = np.argsort(np.abs(here))
    after = np.searchsorted(np.abs(here), np.abs(there), sorter=order)
    numbers = np.arange(len(here))
    partner, sign = numbers.copy(), np.zeros(len(here))
    # By itself first, then by what is next in order.
    for place in (after, after - 1, None):
        other = numbers if place is None else order[place.clip(0, len(here) - 1)]
        for turn in (-1.0, 1.0):
            met = np.abs(turn * here[other] - there) <= near
            met &= np.abs(turn * there[other] - here) <= near
            partner[met], sign[met] = other[met], turn
    alone = partner[partner] != numbers
    partner[alone], sign[alone] = numbers[alone], 0.0
    return Mirror(partner, sign)
