"""A body at finite strain as contact sees it: linear about where it is now.

    K du = R^T f - r(u)         r forces and K stiffness at the displacement u, f contact forces (N)
    R (u + du) = C f + d        C = R K^-1 R^T,  d = R u - R K^-1 r

so the contact solver of the small-strain model finds f, and du follows. R is the contact trace of
the body at rest: forces are those of the whole, tractions per area at rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.body import CondensedBody, condense_body, reduced_model
from fingerdesign.fem.elements import lame_parameters, physical_gradients, quadrature, tabulate
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.system import Body, pressure_nodes
from fingerdesign.reduced import ReducedModel

# Forces and stiffness of quadratic simplices at finite strain, in a few large products.
#
# Where the law below has its own pressure p (mixed, "perturbed
# Lagrangian": p = -lame ln J holds in the mean), the body makes stationary
#
#     integral mu/2 (tr F^T F - 3 - 2 ln J) - p ln J - p^2 / (2 lame)
#
# over quadratic displacements and linear pressures (Simo and Taylor, CMAME 85 (1991) 273;
# Taylor-Hood pair as in fem/system.py). With G_i = grad N_i and g_i = F^-T G_i,
#
#     forces     integral  mu F G_i - (mu + p) g_i,          -integral L_m (ln J + p / lame)
#     stiffness  integral  mu G_i . G_j delta_kl + (mu + p) g_i[l] g_j[k] (+ lame g_i[k] g_j[l]
#                where p = -lame ln J outright),   -integral g_i L_m,   -integral L_m L_n / lame
#
# A stiff plate that a step has turned is stretched by that step's own linear motion, by half the
# turn squared: harmless in the forces, where the next step undoes it, but in the stiffness it may
# outweigh the soft body. There the stress of such cells is the one that the step *predicted* from
# where it began (a stress of its own at each point: Magisano, Leonetti, Garcea, IJNME 109 (2017)
# 1237); at the answer both are the same.
#
# Quadrature has the order of the small-strain model, whose stiffness this is at rest, to rounding.

# The elastomer at finite strain: a compressible neo-Hookean law (numpy only).
#
#     W = mu/2 (tr F^T F - 3 - 2 ln J) + lame/2 (ln J)^2,        J = det F
#     P = dW/dF = mu F - (mu + p) F^-T,                          p = -lame ln J
#
# with F the deformation gradient, P the first Piola-Kirchhoff stress (MPa), p a pressure
# (compression positive). Small strains give Hooke's law with the same lame and mu. In plane strain
# F_33 = 1. Source: Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd
# ed. (2008), 6.4.3. Nearly incompressible, p is an unknown of its own.


class Inverted(SolverError):
    """A deformation turns part of an element inside out: the step was too long."""


@dataclass(frozen=True)
class Deformation:
    """gradient F (..., d, d), its inverse, and log_volume ln J (...)."""

    gradient: Array
    inverse: Array
    log_volume: Array


def deformation(displacement_gradient: Array) -> Deformation:
    """Of du/dX (..., d, d), d 2 (plane strain) or 3. Raises Inverted where J is not positive."""
    gradient = displacement_gradient + np.eye(displacement_gradient.shape[-1])
    volume = np.asarray(np.linalg.det(gradient), dtype=float)
    inverted = ~(volume > 0.0)
    if inverted.any():
        raise Inverted(f"{int(inverted.sum())} points of the elements are turned inside out")
    return Deformation(gradient, np.asarray(np.linalg.inv(gradient), dtype=float), np.log(volume))


def second_piola(at: Deformation, first: Array, shear: Array) -> Array:
    """S = F^-1 P (..., d, d), MPa, with p = -lame ln J; first and shear (...) MPa."""
    both = shear - first * at.log_volume
    eye = np.eye(at.gradient.shape[-1])
    return np.asarray(shear[..., None, None] * eye - both[..., None, None] * _metric(at))


def second_piola_change(at: Deformation, change: Array, first: Array, shear: Array) -> Array:
    """First-order change of S (..., d, d) by ``change`` (..., d, d) of du/dX."""
    half = np.swapaxes(at.gradient, -1, -2) @ change
    metric = _metric(at)
    mixed = metric @ (half + np.swapaxes(half, -1, -2))
    both = shear - first * at.log_volume
    volume = 0.5 * first * np.einsum("...kk->...", mixed)
    return np.asarray(volume[..., None, None] * metric + both[..., None, None] * (mixed @ metric))


def _metric(at: Deformation) -> Array:
    """C^-1 = F^-1 F^-T."""
    return np.asarray(at.inverse @ np.swapaxes(at.inverse, -1, -2))


_ORDER = 2


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
    """The group of ``cells`` (c, 6 or 10) with Lame's parameters (c,), MPa.

    pressures (c, corners): numbers of their pressure unknowns, each ``scale`` MPa a unit; None:
    none. Raises ValueError where a cell is inverted at rest.
    """
    dimension = points.shape[1]
    gradients, weights = physical_gradients(points, cells, _ORDER)
    weights = thickness * weights
    dofs = (cells[:, :, None] * dimension + np.arange(dimension)).reshape(len(cells), -1)
    pull = np.einsum(
        "cq,cqia,cqja->cij", weights * shear[:, None], gradients, gradients, optimize=True
    )
    linear = np.empty((0, weights.shape[1]))
    squeeze = np.empty((len(cells), 0, 0))
    if pressures is not None:
        table = tabulate(dimension, *quadrature(dimension, _ORDER), degree=1)
        linear = scale * table.value
        dofs = np.concatenate([dofs, pressures], axis=1)
        squeeze = np.einsum(
            "cq,mq,nq->cmn", weights / first[:, None], linear, linear, optimize=True
        )
    return Group(dofs, gradients, weights, first, shear, pull, linear, squeeze)


# A body's equations at finite strain: forces and stiffness on the free unknowns.
#
# Unknowns ("values") are the nodal displacements, mm, dof i dim + k, then the pressures of a nearly
# incompressible material, each in a unit that makes its pivot as large as the stiffness's. Held
# displacements stay zero. The pattern is found once; every evaluation is a few batched products and
# one sum.

_CELLS = 4096  # at a time: 100 MB of temporaries in 3-D


@dataclass(frozen=True)
class FiniteSystem:
    """Groups of cells, and where their unknowns go.

    count: unknowns, held ones among them; free (d,): the numbers of those that are free, in the
    order of the equations (a pressure behind its node); pressures: how many they are; places, one
    (c pairs,) a group: where the upper triangle of each cell's stiffness is added (the last place
    takes what is held); indices, indptr: CSR pattern of the upper triangle; scale: MPa per unit of
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
        """How many equations there are."""
        return len(self.free)

    @property
    def at_rest(self) -> Array:
        """Values (count,) of the body as it was made."""
        return np.zeros(self.count)

    def displacement(self, values: Array) -> Array:
        """Nodal displacements (n, dim), mm."""
        return values[: self.body.mesh.points.size].reshape(self.body.mesh.points.shape)

    def forces(self, values: Array) -> Array:
        """What the body resists with (count,): N, and mm^3-like terms for the pressures."""
        return self._summed([part.evaluate(values, stiffness=False)[0] for part in self.groups])

    def tangent(self, values: Array, before: Array | None = None) -> tuple[Array, sp.csr_matrix]:
        """Forces (count,) and the stiffness's upper triangle (d, d) on the free unknowns.

        before: where the step began whose end ``values`` are, see above; None: the
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
    """The system of a body of element "P2" or "mixed" without attached stiffness.

    Raises SolverError for another body, ValueError where a cell is inverted at rest.
    """
    if body.element == "P1":
        raise SolverError(
            'mesh.element = "P1": finite strain takes "P2" or "mixed"; linear elements lock'
        )
    if body.attached is not None:
        raise SolverError("finite strain knows no sheets")
    own = body.pressed
    numbers, nodes = np.empty((0, 0), dtype=np.int64), np.empty(0, dtype=np.int64)
    if own.any():
        corners = body.mesh.corners[own]
        numbers, nodes = pressure_nodes(corners, body.youngs_modulus[own], body.poissons_ratio[own])
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
            part = chosen[start : start + _CELLS]
            pressures = mesh.points.size + numbers[start : start + _CELLS] if mixed else None
            found.append(
                group(
                    mesh.points,
                    mesh.cells[part],
                    first[part],
                    shear[part],
                    body.thickness,
                    pressures,
                    scale,
                )
            )
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


@dataclass(frozen=True)
class FiniteBody:
    """A body, its equations, and its small-strain model at rest (trace, supports, readouts).

    trace (m dim, d): contact displacements of the free unknowns; free_ends, depth: as in
    fem.body.reduced_model.
    """

    system: FiniteSystem
    at_rest: CondensedBody
    trace: sp.csr_matrix
    free_ends: tuple[float, float] | None
    depth: float | None

    def contact_displacement(self, values: Array) -> Array:
        """R u (m, dim), mm."""
        moved = self.at_rest.trace.operator @ values[: self.system.body.mesh.points.size]
        return np.asarray(moved).reshape(-1, self.system.body.mesh.dimension)

    def loads(self, force: Array) -> Array:
        """Contact forces (m, dim) N on the free unknowns, (d,)."""
        return np.asarray(self.trace.T @ force.ravel())

    def supports(self, values: Array) -> Array:
        """Sum of the supports' forces on the body (dim,), N, at equilibrium."""
        body = self.system.body
        forces = self.system.forces(values)[: body.mesh.points.size]
        return np.asarray(np.where(body.fixed, forces, 0.0).reshape(body.mesh.points.shape).sum(0))

    def linearised(
        self, values: Array, before: Array | None = None, spent: Linearised | None = None
    ) -> Linearised:
        """The tangent at ``values``, the end of a step from ``before`` (FiniteSystem.tangent).

        spent: a tangent of this body that is not needed any more, whose order of elimination is
        taken over. Raises SolverError where the tangent is not that of a stable body.
        """
        forces, stiffness = self.system.tangent(values, before)
        silent = np.diff(self.trace.indptr) == 0  # motions that are held
        if spent is None:
            rows = self.trace[~silent].tocsr()
            condensation = Condensation(stiffness, rows, self.system.pressures)
        else:
            condensation = spent.condensation
            condensation.renew(stiffness)
        compliance = np.zeros((len(silent), len(silent)))
        compliance[np.ix_(~silent, ~silent)] = condensation.matrix
        return Linearised(self, forces, condensation, compliance)


@dataclass(frozen=True)
class Linearised:
    """One tangent of a body: forces (count,) where it was taken, compliance (m dim, m dim)."""

    body: FiniteBody
    forces: Array
    condensation: Condensation
    compliance: Array

    def answer(self, loads: Array) -> Array:
        """Change of the values (count,) by loads (d,) on the free unknowns."""
        change = np.zeros(self.body.system.count)
        change[self.body.system.free] = self.condensation.solve(loads[:, None])[:, 0]
        return change

    def model(self, offset: Array) -> ReducedModel:
        """What contact sees, with contact displacement ``offset`` (m, dim) mm at no force."""
        condensed = replace(
            self.body.at_rest, compliance=self.compliance, load_displacement=offset.ravel()
        )
        return reduced_model(condensed, free_ends=self.body.free_ends, depth=self.body.depth)


def finite_body(
    body: Body,
    free_ends: tuple[float, float] | None = None,
    depth: float | None = None,
    at_rest: CondensedBody | None = None,
) -> FiniteBody:
    """The body, ready to be followed; at_rest: its small-strain model, where there is one. Raises
    SolverError as condense_body and finite_system do."""
    system = finite_system(body)
    at_rest = condense_body(body) if at_rest is None else at_rest
    trace = (at_rest.trace.operator @ system.lift).tocsr()
    trace.eliminate_zeros()
    trace.sort_indices()
    return FiniteBody(system, at_rest, trace, free_ends, depth)
