"""A body's equations at finite strain: forces and stiffness on the free unknowns.

Unknowns ("values") are the nodal displacements, mm, dof i dim + k, then the pressures of a nearly
incompressible material, each in a unit that makes its pivot as large as the stiffness's. Fixed
displacements stay zero. The pattern is found once; an evaluation is a few batched products and one
sum.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.finite.cells import Group, group
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.fem.system import Body, pressure_nodes

_CELLS = 4096  # Cells evaluated at a time: 100 MB of temporaries in 3-D.


@dataclass(frozen=True)
class FiniteSystem:
    """Groups of cells, and where their unknowns go.

    count: unknowns, fixed ones among them; free (d,): the numbers of those that are free, in the
    order of the equations (a pressure behind its node); pressures: how many they are; places, one
    (c pairs,) a group: where the upper triangle of each cell's stiffness is added (the last place
    takes fixed ones); indices, indptr: CSR pattern of the upper triangle; scale: MPa per unit of
    pressure.
    """

    body: Body
    groups: tuple[Group, ...]
    count: int
    free: IntArray
    pressures: int
    places: tuple[NDArray[np.int32], ...]
    indices: NDArray[np.int32]
    indptr: NDArray[np.int32]
    scale: float

    @property
    def dofs(self) -> int:
        """Number of equations."""
        return len(self.free)

    @property
    def at_rest(self) -> Array:
        """Values (count,) of the body as it was made."""
        return np.zeros(self.count)

    def displacement(self, values: Array) -> Array:
        """Nodal displacements (n, dim), mm."""
        return values[: self.body.mesh.points.size].reshape(self.body.mesh.points.shape)

    def forces(self, values: Array) -> Array:
        """Internal forces (count,): N, and volume terms (mm^3) for the pressures."""
        return self._summed([part.evaluate(values, stiffness=False)[0] for part in self.groups])

    def tangent(self, values: Array, before: Array | None = None) -> tuple[Array, sp.csr_matrix]:
        """Forces (count,) and the stiffness's upper triangle (d, d) on the free unknowns.

        before: the start of the step that ends at ``values`` (cells.py); None: the
        stiffness is the forces' derivative.
        """
        forces = []
        data = np.zeros(len(self.indices) + 1)
        for part, place in zip(self.groups, self.places, strict=True):
            found, stiffness = part.evaluate(values, before=before)
            assert stiffness is not None
            forces.append(found)
            rows, columns = np.triu_indices(stiffness.shape[1])
            entries = stiffness[:, rows, columns].ravel()
            data += np.bincount(place, entries, minlength=len(data))
        shape = (self.dofs, self.dofs)
        matrix = sp.csr_matrix((data[:-1], self.indices, self.indptr), shape=shape)
        return self._summed(forces), matrix

    def _summed(self, parts: list[Array]) -> Array:
        total = np.zeros(self.count)
        for part, found in zip(self.groups, parts, strict=True):
            total += np.bincount(part.dofs.ravel(), found.ravel(), minlength=self.count)
        return total

    @property
    def lift(self) -> sp.csr_matrix:
        """(n dim, d): nodal displacements of free unknowns."""
        moves = np.flatnonzero(self.free < self.body.mesh.points.size)
        entries = (np.ones(len(moves)), (self.free[moves], moves))
        return sp.csr_matrix(entries, shape=(self.body.mesh.points.size, self.dofs))


def finite_system(body: Body) -> FiniteSystem:
    """The system of a body of element "P2" or "mixed" without attached stiffness. Raises
    SolverError for another body, ValueError where a cell is inverted at rest."""
    if body.element == "P1":
        raise SolverError(
            'mesh.element = "P1": finite strain takes "P2" or "mixed"; linear elements lock'
        )
    if body.attached is not None:
        raise SolverError("finite strain has no model for sheets, leads and gages on plates")
    own = body.pressed
    numbers, nodes = np.empty((0, 0), dtype=np.int64), np.empty(0, dtype=np.int64)
    if own.any():
        corners = body.mesh.corners[own]
        numbers, nodes, _ = pressure_nodes(
            corners, body.youngs_modulus[own], body.poissons_ratio[own]
        )
    scale = _pressure_scale(body, own, numbers)
    groups = _groups(body, own, numbers, scale)
    size = body.mesh.points.size
    node = np.concatenate([np.arange(size) // body.mesh.dimension, nodes])
    free = np.concatenate([np.flatnonzero(~body.fixed), size + np.arange(len(nodes))])
    free = free[np.argsort(node[free], kind="stable")]
    count = size + len(nodes)
    places, indices, indptr = _pattern(groups, free, count)
    return FiniteSystem(body, groups, count, free, len(nodes), places, indices, indptr, scale)


def _groups(body: Body, own: BoolArray, numbers: IntArray, scale: float) -> tuple[Group, ...]:
    mesh, found = body.mesh, []
    first, shear = lame_parameters(body.youngs_modulus, body.poissons_ratio)
    for mixed in (True, False):
        chosen = np.flatnonzero(own == mixed)
        for start in range(0, len(chosen), _CELLS):
            some = slice(start, start + _CELLS)
            part, points = chosen[some], mesh.points
            pressures = points.size + numbers[some] if mixed else None
            given = mesh.cells[part], first[part], shear[part]
            found.append(group(points, *given, body.thickness, pressures, scale))
    return tuple(found)


def _pressure_scale(body: Body, own: BoolArray, numbers: IntArray) -> float:
    """MPa per unit of pressure, by the rule of system.with_pressures on one group of cells."""
    if not own.any():
        return 1.0
    part = _groups(body, own, numbers, 1.0)[0]
    dim = body.mesh.dimension
    stiff = float(np.median(np.einsum("cii->ci", part.pull))) * (dim + 1) / dim
    soft = float(np.median(np.einsum("cii->ci", part.squeeze)))
    return float(np.sqrt(float(np.median(part.shear / part.first)) * stiff / soft))


def _pattern(
    groups: tuple[Group, ...], free: IntArray, count: int
) -> tuple[tuple[NDArray[np.int32], ...], NDArray[np.int32], NDArray[np.int32]]:
    """places, indices and indptr of :class:`FiniteSystem`."""
    equations = len(free)
    equation = np.full(count, -1, dtype=np.int64)
    equation[free] = np.arange(equations)
    keys = []
    for part in groups:
        rows, columns = np.triu_indices(part.dofs.shape[1])
        numbers = equation[part.dofs]
        one, other = numbers[:, rows], numbers[:, columns]
        key = np.minimum(one, other) * equations + np.maximum(one, other)
        key[(one < 0) | (other < 0)] = equations * equations
        keys.append(key.ravel())
    nothing = np.array([equations * equations])
    entries, place = np.unique(np.concatenate([*keys, nothing]), return_inverse=True)
    row, column = np.divmod(entries[:-1], equations)
    per_row = np.bincount(row, minlength=equations)
    indptr = np.concatenate([[0], np.cumsum(per_row)]).astype(np.int32)
    bounds = np.cumsum([0, *(len(key) for key in keys)])
    places = tuple(place[low:high].astype(np.int32) for low, high in pairwise(bounds))
    return places, column.astype(np.int32), indptr
