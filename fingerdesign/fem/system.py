"""The equations of a body: stiffness on the free dofs, and how displacements follow from them.

Three elements on one quadratic mesh, geometry included: "P2", quadratic displacements; "P1",
displacements linear between the corners; "mixed", quadratic with a pressure of its own where the
material is nearly incompressible (:func:`pressure_coupling`), P2 elsewhere.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import (
    inverse_jacobians,
    physical_gradients,
    quadrature,
    strain_order,
    tabulate,
)
from fingerdesign.fem.sparse import merged
from fingerdesign.fem.stiffness import STRAIGHT, lame_parameters, stiffness_blocks, sum_blocks
from fingerdesign.mesh.cells import TETRA, kind_of
from fingerdesign.mesh.measures import curved_cells
from fingerdesign.mesh.types import Mesh

# The pressure of a nearly incompressible material as an unknown of its own (Taylor-Hood).
#
#     [ A   B ] [u]   [f]      A = integral 2 mu eps(u) : eps(v)
#     [ B^T -M ] [p] = [0],     B = - integral p div v,    M = integral p q / lame
#
# with quadratic displacements and linear continuous pressures p = -lame div u (MPa, compression
# positive), so that the volume does not lock as lame grows. Each material has pressures of its own:
# they jump where it ends. Source: Hughes, The Finite Element Method (1987), 4.3-4.4; stability of
# the pair: Taylor and Hood, Computers and Fluids 1 (1973) 73.


@dataclass(frozen=True)
class Pressures:
    """nodes, materials (pressures,): of each, the corner and the material's number; coupling
    (n dim, pressures): B; compliance (pressures, pressures): upper triangle of M."""

    nodes: IntArray
    materials: IntArray
    coupling: sp.csr_matrix
    compliance: sp.csr_matrix


def pressure_coupling(
    points: Array,
    cells: IntArray,
    youngs_modulus: Array,
    poissons_ratio: Array,
    thickness: float = 1.0,
) -> Pressures:
    """B and M of the given cells (c, nodes), all of which carry pressures (0 < nu < 0.5)."""
    dimension = points.shape[1]
    corners = kind_of(cells).corners
    first, _ = lame_parameters(youngs_modulus, poissons_ratio)
    numbers, nodes, materials = pressure_nodes(cells[:, :corners], youngs_modulus, poissons_ratio)
    count = len(nodes)
    coupling, mass = _blocks(points, cells)
    row = (cells[:, :, None, None] * dimension + np.arange(dimension)[:, None]).repeat(corners, 3)
    column = np.broadcast_to(numbers[:, None, None, :], row.shape)
    entries = (-thickness * coupling.ravel(), (row.ravel(), column.ravel()))
    b = sp.coo_matrix(entries, shape=(points.size, count)).tocsr()
    mass *= (thickness / first)[:, None, None]
    low = np.broadcast_to(numbers[:, :, None], mass.shape).ravel()
    high = np.broadcast_to(numbers[:, None, :], mass.shape).ravel()
    upper = low <= high
    m = sp.coo_matrix((mass.ravel()[upper], (low[upper], high[upper])), shape=(count, count))
    return Pressures(nodes, materials, b, m.tocsr())


def pressure_nodes(
    corners: IntArray, youngs_modulus: Array, poissons_ratio: Array
) -> tuple[IntArray, IntArray, IntArray]:
    """Pressure numbers (c, corners), one a material and corner node; the node and the material's
    number of each."""
    pairs = np.column_stack([youngs_modulus, poissons_ratio])
    materials = np.unique(pairs, axis=0, return_inverse=True)[1].reshape(-1, 1)
    size = int(corners.max()) + 1
    keys = materials * size + corners
    used, numbers = np.unique(keys, return_inverse=True)
    return numbers.reshape(corners.shape).astype(np.int64), used % size, used // size


def _blocks(points: Array, cells: IntArray) -> tuple[Array, Array]:
    """Integrals of dN_i/dx_k L_m as (c, i, k, m), and of L_m L_n as (c, m, n)."""
    kind = kind_of(cells)
    order = strain_order(kind)
    rule = quadrature(kind, order)
    table, linear = tabulate(kind, *rule), tabulate(kind, *rule, degree=1)
    straight = ~curved_cells(points, cells, STRAIGHT)
    inverse, determinant = inverse_jacobians(points, cells, straight)
    constant = np.einsum("iaq,mq,q->iam", table.gradient, linear.value, table.weights)
    mass = np.einsum("mq,nq,q->mn", linear.value, linear.value, table.weights)
    scaled = determinant[:, None, None] * inverse
    coupling = np.einsum("iam,cak->cikm", constant, scaled, optimize=True)
    masses = determinant[:, None, None] * mass
    curved = np.flatnonzero(~straight)
    gradients, weights = physical_gradients(points, cells[curved], order)
    coupling[curved] = np.einsum(
        "cqik,mq,cq->cikm", gradients, linear.value, weights, optimize=True
    )
    masses[curved] = np.einsum("mq,nq,cq->cmn", linear.value, linear.value, weights, optimize=True)
    return coupling, masses


@dataclass(frozen=True)
class System:
    """K q = L^T load for the free dofs q, of which the nodal displacements are u = L q.

    stiffness (d, d): upper triangle in CSR, sorted; empty once factors have it (fem/body.py); lift
    (n dim, d): L; support (dim, d): sum of K q over held dofs, component by component; held (n dim,
    dim): how much of each node's load goes into the supports at once; pressures: how many
    eigenvalues of K are below zero; pressure_lift (pressures, d): the pressures, MPa, of q.
    places (d, 2): the node of each dof and its kind, a component, or dim and on of pressures, by
    their material; None of P1.
    """

    stiffness: sp.csr_matrix
    lift: sp.csr_matrix
    support: sp.csr_matrix
    held: sp.csr_matrix
    pressures: int = 0
    pressure_lift: sp.csr_matrix | None = None
    places: IntArray | None = None

    @property
    def dofs(self) -> int:
        """Number of equations."""
        return int(self.stiffness.shape[0])


@dataclass(frozen=True)
class Body:
    """A linear elastic body on a quadratic mesh, fixed somewhere, loaded through contact facets.

    youngs_modulus (c,) MPa and poissons_ratio (c,) per cell; fixed (n dim,) bool: dofs i dim + k
    fixed at zero; contact (f, 3, 6 or 9): the candidate facets, corners then mid-nodes;
    thickness mm of a plane-strain body (1 in 3-D); pressure_cells (c,) bool: where a mixed element
    has pressures (None: wherever nu > 0); attached (n dim, n dim): upper triangle of a stiffness
    (N/mm) to be added, of sheets say; project: points (q, dim) near the contact facets -> points on
    the exact surface, from which gaps are measured.
    """

    mesh: Mesh
    youngs_modulus: Array
    poissons_ratio: Array
    fixed: BoolArray
    contact: IntArray
    thickness: float = 1.0
    element: Literal["P1", "P2", "mixed"] = "P2"
    pressure_cells: BoolArray | None = None
    project: Callable[[Array], Array] | None = None
    attached: sp.csr_matrix | None = None

    @property
    def pressed(self) -> BoolArray:
        """Cells (c,) that have pressures of their own."""
        if self.element != "mixed":
            return np.zeros(len(self.mesh.cells), dtype=bool)
        inside = self.poissons_ratio > 0.0
        return inside if self.pressure_cells is None else inside & self.pressure_cells


def assemble_system(body: Body) -> System:
    """Assemble the system of a sound body; for P1 the fixed dofs of corners count. Raises
    SolverError for a body that is fixed everywhere, ValueError for an inverted cell."""
    mesh, element, fixed, thickness = body.mesh, body.element, body.fixed, body.thickness
    youngs_modulus, poissons_ratio, inside = body.youngs_modulus, body.poissons_ratio, body.pressed
    cells, spread = _element_nodes(mesh, element)
    if spread is not None:
        fixed = fixed.reshape(mesh.points.shape)[np.unique(mesh.corners)].reshape(-1)
    first, shear = lame_parameters(youngs_modulus, poissons_ratio)
    degree, lame = 1 if element == "P1" else 2, np.where(inside, 0.0, first) * thickness
    rows, columns, blocks = stiffness_blocks(
        mesh.points, mesh.cells, lame, shear * thickness, degree
    )
    nodes = fixed.size // mesh.dimension
    whole = sum_blocks(cells[:, rows].T, cells[:, columns].T, blocks, nodes)
    every = None
    if spread is not None:
        every = sp.kron(spread, sp.identity(mesh.dimension), format="csr")
    attached = body.attached
    if attached is not None:
        if every is not None:
            full = attached + sp.triu(attached, k=1).T
            attached = sp.triu(every.T @ full @ every, format="csr")
        whole = (whole + attached).tocsr()
    system = held_system(whole, fixed, mesh.dimension)
    if every is not None:
        lifted = every @ system.lift, every @ system.held
        system = replace(system, lift=lifted[0], held=lifted[1], places=None)
    if not inside.any():
        return system
    part = pressure_coupling(
        mesh.points, cells[inside], youngs_modulus[inside], poissons_ratio[inside], thickness
    )
    ratio = float(np.median(shear[inside] / first[inside]))
    return with_pressures(system, part, ratio, zeros=mesh.moved or mesh.kind is not TETRA)


def _element_nodes(mesh: Mesh, element: str) -> tuple[IntArray, sp.csr_matrix | None]:
    """The element's nodes in each cell, and the values at the mesh's nodes (n, nodes) of its own.
    None where both are the same."""
    if element != "P1":
        return mesh.cells, None
    corners, cells = np.unique(mesh.corners, return_inverse=True)
    cells, kind = cells.reshape(mesh.corners.shape), mesh.kind
    # The corners whose mean a node has: a corner its own, others those of their edge or square.
    ends = [*((corner,) for corner in range(kind.corners)), *kind.edges, *kind.squares]
    row = [mesh.cells[:, [node] * len(own)].ravel() for node, own in enumerate(ends)]
    column = np.concatenate([cells[:, own].ravel() for own in ends])
    entries = (np.ones(len(column)), (np.concatenate(row), column))
    spread = sp.csr_matrix(entries, shape=(len(mesh.points), len(corners)))
    uses = np.diff(spread.indptr)
    spread.data = 1.0 / np.repeat(uses, uses)
    return cells, spread


def held_system(whole: sp.csr_matrix, fixed: BoolArray, dimension: int) -> System:
    """The system on the free dofs of an upper-triangular stiffness of all."""
    free = np.flatnonzero(~fixed)
    if len(free) == 0:
        raise SolverError("every displacement of the body is fixed: nothing is left to solve for")
    marks = np.zeros((len(fixed), dimension))
    index = np.flatnonzero(fixed)
    marks[index, index % dimension] = 1.0
    # Entries of held dofs alone: few of millions.
    across, down, own = whole[:, index], whole[index], marks[index]
    total = across @ own + down.T @ own - whole.diagonal()[:, None] * marks
    met = _places(across) @ own + _places(down).T @ own
    ones = np.ones(len(free))
    lift = sp.csr_matrix((ones, (free, np.arange(len(free)))), shape=(len(fixed), len(free)))
    stiffness = whole[free][:, free].tocsr()
    stiffness.sort_indices()
    loose = int((stiffness.diagonal() == 0.0).sum())
    if loose:
        raise SolverError(f"{loose} displacements belong to no cell: drop the mesh's unused nodes")
    places = np.column_stack([free // dimension, free % dimension])
    support = _stored(total[free], met[free])
    return System(stiffness, lift, support, sp.csr_matrix(marks), places=places)


def _places(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """1 where a matrix has an entry, be it zero."""
    return sp.csr_matrix((np.ones(matrix.nnz), matrix.indices, matrix.indptr), shape=matrix.shape)


def _stored(values: Array, met: Array) -> sp.csr_matrix:
    """Values (n, k) as rows, stored where ``met`` is not 0: sums of many entries, which rounding
    alone may make zero or not, have the same places on any mesh of this topology."""
    row, column = np.nonzero(met.T)
    return sp.csr_matrix((values[column, row], (row, column)), shape=values.T.shape)


def with_pressures(system: System, part: Pressures, ratio: float, zeros: bool = False) -> System:
    """The system with pressures among its dofs, each behind the displacements of its node.

    ratio: mu / lame of the material; the pressures are scaled so that their pivots are of the
    stiffness's size. Behind their nodes, not at the end, they let the ordering find factors that
    need less work (measured: 86 for 100 GFLOP at 72k dofs, 664 for 766 at 194k). zeros: stored
    ones stay. They let the ordering treat a node as one: of six swept fingers its time falls by 35
    to 53 % for 0 to 4 % more work (one 10 %), in sections by a quarter for none. Tetrahedra need
    up to a quarter more work with them. Meshes with the same cells then have the same places, and
    one order of elimination serves them all.
    """
    count, before = part.compliance.shape[0], system.dofs
    stiff, soft = np.median(system.stiffness.diagonal()), np.median(part.compliance.diagonal())
    scale = float(np.sqrt(ratio * stiff / soft))
    coupling = scale * part.coupling
    node = np.append(system.lift.nonzero()[0] // system.held.shape[1], part.nodes)
    place = np.empty(len(node), dtype=np.int32)  # as the matrices' own: half to move
    place[np.argsort(node, kind="stable")] = np.arange(len(node))
    coupled = coupling[system.lift.nonzero()[0]]  # a product would drop zeros
    stiffness = _upper(system.stiffness, coupled, -(scale**2) * part.compliance, place)
    if not zeros:
        stiffness.eliminate_zeros()
    back = np.argsort(place)
    lift = sp.hstack([system.lift, sp.csr_matrix((system.lift.shape[0], count))], format="csc")
    marks = system.held.toarray()
    pressing = _stored(coupling.T @ marks, _places(coupling).T @ marks)
    support = sp.hstack([system.support, pressing], format="csc")
    own = sp.csr_matrix(
        (np.full(count, scale), (np.arange(count), place[before:])), shape=(count, len(place))
    )
    lifts = lift[:, back].tocsr(), support[:, back].tocsr(), system.held
    places = None
    if system.places is not None:
        pressing = np.column_stack([part.nodes, system.held.shape[1] + part.materials])
        places = np.vstack([system.places, pressing])[back]
    return System(stiffness, *lifts, count, own, places)


def _upper(
    stiffness: sp.csr_matrix, coupled: sp.csr_matrix, own: sp.csr_matrix, place: NDArray[np.int32]
) -> sp.csr_matrix:
    """Upper triangle of [[K, B], [B^T, M]], its dofs moved to ``place``: those of K keep their
    order. stiffness, own: upper triangles of K and M."""
    first, last = np.split(place, [stiffness.shape[0]])
    b, m = coupled.tocoo(), own.tocoo()
    ends = np.append(first[b.row], last[m.row]), np.append(last[b.col], last[m.col])
    entries = np.append(b.data, m.data), (np.minimum(*ends), np.maximum(*ends))
    added = sp.coo_matrix(entries, shape=(len(place), len(place))).tocsr()
    return merged(stiffness, added, first)
