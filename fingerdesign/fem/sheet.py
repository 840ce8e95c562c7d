"""Thin plates as sheets: membrane, bending and shear stiffness in slots of the rubber's mesh.

A slot has the plate's thickness t and two faces of paired nodes. Means over a pair, marked m, are
of the mid-surface; differences, d = upper - lower, turn and thicken the plate. With u along the
mid-surface and w across it the energy is half the integral over the mid-surface of

    membrane  t C : e : e               e = (grad u_m, w_d / t)
    bending   t^3/12 D : k : k          k = - grad u_d / t
    shear     5/6 G t |g|^2             g = grad w_m + u_d / t

(Reissner's and Mindlin's plate), C the tensor in space, D that of plane stress, both over the
quadratic facets; the shear by two points along an edge, three in a triangle, which keeps thin
plates from locking (Zienkiewicz, Taylor and Too, IJNME 3 (1971) 275). A plate's edges are free.

Tractions on the faces thus act at their arm t/2, and the rubber has its true shape. Left out are
the warping of cross-sections and of the square ends. The strain across matters: pressed by 0.3 MPa
on both faces phosphor bronze stretches by a microstrain, what a gage reads.

docs/reference/benchmarks.md compares them with solid plates. Faces are read worse than the mean
of both: gages end near the plate's square ends, where sections warp.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.stiffness import lame_parameters
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.cells import LINE, SQUARE, TRIANGLE, CellKind, facet_kind
from fingerdesign.mesh.sheets import CAP
from fingerdesign.mesh.types import Mesh

_SHEAR_FACTOR = 5.0 / 6.0  # The shear correction of a rectangular section.
# Corners of a facet from which coordinates along it begin, and to which they lead.
_AXES = {LINE: (0, 1), TRIANGLE: (0, 1, 2), SQUARE: (0, 1, 3)}
_SAME_PLACE = 1e-6  # mm: far below any element, far above rounding


@dataclass(frozen=True)
class SheetFacets:
    """One plate: the facets of its upper face stand for its mid-surface.

    own (o,): numbers in the mesh of the plate's nodes; all other numbers are places in ``own``.
    nodes, nodes_below (f, k): of the upper face, and those that they face; tangents (s, dim),
    normal (dim,), s = dim - 1; flat (f, s + 1, s): a corner and its neighbours in coordinates along
    the tangents (the plate's axis from its centre, and across: z of a plate along x, x of one
    along z); upper, lower
    (p,): nodes that face each other; between (b,), pair (b,): nodes on the end faces midway between
    those of a pair (faces that end in the body's outside have none); thickness mm.
    """

    own: IntArray
    nodes: IntArray
    nodes_below: IntArray
    tangents: Array
    normal: Array
    flat: Array
    upper: IntArray
    lower: IntArray
    between: IntArray
    pair: IntArray
    thickness: float

    @property
    def dofs(self) -> IntArray:
        """Dofs (o dim,) of the mesh that are the plate's, node by node."""
        dimension = len(self.normal)
        return np.asarray((self.own[:, None] * dimension + np.arange(dimension)).ravel())

    @property
    def dimension(self) -> int:
        """Dimension of the surface: 1 in plane strain, 2 in space."""
        return int(self.tangents.shape[0])

    @property
    def kind(self) -> CellKind:
        """The kind of the facets."""
        return facet_kind(self.nodes)

    @property
    def inverse(self) -> Array:
        """d reference_b / d coordinate_a, (f, b, a): facets are flat and straight."""
        return np.asarray(np.linalg.inv(self._jacobian))

    @property
    def measure(self) -> Array:
        """Length or area (f,)."""
        factor = 0.5 if self.kind is TRIANGLE else 1.0
        return np.asarray(factor * np.abs(np.linalg.det(self._jacobian)))

    @property
    def _jacobian(self) -> Array:
        return (self.flat[:, 1:] - self.flat[:, :1]).transpose(0, 2, 1)

    def slopes(self, where: Array) -> Array:
        """Derivatives (f, q, k, s) of the shape functions along the tangents, at reference points
        ``where`` (s, q)."""
        gradient = tabulate(self.kind, where).gradient
        return np.asarray(np.einsum("nbq,fba->fqna", gradient, self.inverse, optimize=True))


def sheet_of(mesh: Mesh, frame: PlateFrame) -> SheetFacets:
    """The facets of one plate's slot. Raises SolverError where the mesh has none for it."""
    names = [f"plate_{frame.index}_{face}" for face in ("upper", "lower", "end")]
    if not all(name in mesh.facets for name in names):
        raise SolverError(
            f"the mesh has no slot for plate {frame.index}: mesh it with plates.model = 'sheet'"
        )
    facets = mesh.facets[names[0]]
    upper, lower, end = (np.unique(mesh.facets[name]) for name in names)
    cap = mesh.facets.get(f"plate_{frame.index}_{CAP}")
    end = end if cap is None else np.union1d(end, cap)
    partner = lower[_facing(mesh, frame, upper, lower)]
    between = np.setdiff1d(end, np.concatenate([upper, lower]))
    own = np.concatenate([upper, partner, between])
    place = np.empty(len(mesh.points), dtype=np.int64)
    place[own] = np.arange(len(own))
    normal, tangents = frame.normal, frame.axis[None, :]
    if mesh.dimension == 3:
        normal, tangents = frame.direction(normal), frame.direction(tangents)
        across = frame.to_space(np.zeros(2), 1.0)
        tangents = np.vstack([tangents, across])
    nodes, corners = place[facets], facets[:, _AXES[facet_kind(facets)]]
    return SheetFacets(
        own=own,
        nodes=nodes,
        nodes_below=nodes + len(upper),
        tangents=tangents,
        normal=normal,
        flat=places_on(frame, mesh.points[corners.ravel()]).reshape(*corners.shape, -1),
        upper=place[upper],
        lower=place[partner],
        between=place[between],
        pair=_facing(mesh, frame, between, upper),
        thickness=frame.thickness,
    )


def places_on(frame: PlateFrame, points: Array) -> Array:
    """Coordinates (n, s) along a flat plate's tangents of points (n, dim)."""
    along = frame.local(points)[:, :1]
    if points.shape[1] == 2:
        return np.asarray(along)
    return np.column_stack([along, frame.across(points)])


def _facing(mesh: Mesh, frame: PlateFrame, nodes: IntArray, others: IntArray) -> IntArray:
    """For each node the place in ``others`` of the one at the same place along the plate."""
    from scipy.spatial import cKDTree

    here, there = (places_on(frame, mesh.points[which]) for which in (nodes, others))
    distance, found = cKDTree(there).query(here, distance_upper_bound=_SAME_PLACE)
    if not np.isfinite(distance).all():
        raise SolverError(f"the faces of plate {frame.index}'s slot do not mirror each other")
    return np.asarray(found, dtype=np.int64)


def sheet_stiffness(
    mesh: Mesh,
    frames: Sequence[PlateFrame],
    youngs_modulus: float,
    poissons_ratio: float,
    thickness: float = 1.0,
) -> sp.csr_matrix:
    """Upper triangle (n dim, n dim) in CSR, N/mm, of all plates.

    youngs_modulus MPa; ``thickness`` (mm): the depth of a plane-strain body. Raises SolverError
    where the mesh has no slot for a plate.
    """
    law = _in_space(youngs_modulus, poissons_ratio, mesh.dimension - 1) * thickness
    flat = law[:-1, :-1] - np.outer(law[:-1, -1], law[-1, :-1]) / law[-1, -1]  # no stress across
    shear = _SHEAR_FACTOR * youngs_modulus / (2.0 * (1.0 + poissons_ratio)) * thickness
    entries = [(np.empty(0, int), np.empty(0, int), np.empty(0))]
    for frame in frames:
        sheet, t = sheet_of(mesh, frame), frame.thickness
        blocks = _membrane(sheet, law * t)
        blocks += _bending(sheet, flat * t**3 / 12.0)
        blocks += _shear(sheet, shear * t)
        nodes, count = np.hstack([sheet.nodes, sheet.nodes_below]), blocks.shape[1]
        dofs = sheet.dofs.reshape(-1, mesh.dimension)[nodes].reshape(len(nodes), count)
        pairs = np.repeat(dofs, count, axis=1).ravel(), np.tile(dofs, (1, count)).ravel()
        entries += [(*pairs, blocks.ravel()), *_plane_ends(sheet, law[0, 0])]
    row, column, value = (np.concatenate(each) for each in zip(*entries, strict=True))
    upper = row <= column
    size = mesh.points.size
    total = sp.csr_matrix((value[upper], (row[upper], column[upper])), shape=(size, size))
    total.sort_indices()
    return total


def _in_space(youngs_modulus: float, poissons_ratio: float, dimension: int) -> Array:
    """Stress of strain (xx, across; or xx, zz, engineering xz, across), MPa."""
    first, shear = lame_parameters(np.array(youngs_modulus), np.array(poissons_ratio))
    axial = [0, 1] if dimension == 1 else [0, 1, 3]
    law = np.zeros((axial[-1] + 1, axial[-1] + 1))
    law[np.ix_(axial, axial)] = first + 2.0 * shear * np.eye(len(axial))
    if dimension == 2:
        law[2, 2] = shear
    return law


def _membrane(sheet: SheetFacets, law: Array) -> Array:
    """Blocks (f, 2 k dim, 2 k dim): upper nodes, then those below; ``law``: force per length of
    the mid-surface's strains and of the strain across."""
    where, weights = quadrature(sheet.kind, 4)
    strain = _surface_strain(sheet, where)
    mean = np.zeros((*strain.shape[:2], len(law), *strain.shape[3:]))
    mean[:, :, :-1] = 0.5 * strain
    across = np.zeros_like(mean)
    value = tabulate(sheet.kind, where).value.T / sheet.thickness
    across[:, :, -1] = value[:, :, None] * sheet.normal
    return _energy(sheet, mean + across, mean - across, law, weights)


def _bending(sheet: SheetFacets, law: Array) -> Array:
    """Blocks as in ``_membrane``; ``law``: moment per length of the curvatures."""
    where, weights = quadrature(sheet.kind, 2)
    curvature = _surface_strain(sheet, where) / sheet.thickness
    return _energy(sheet, -curvature, curvature, law, weights)


def _shear(sheet: SheetFacets, stiffness: float) -> Array:
    """Blocks as in ``_membrane``, integrated by as few points as leave no motion free."""
    where, weights = quadrature(sheet.kind, 2)
    slope = 0.5 * sheet.slopes(where).transpose(0, 1, 3, 2)  # (f, q, a, k)
    mean = slope[..., None] * sheet.normal
    value = tabulate(sheet.kind, where).value.T / sheet.thickness
    turn = value[None, :, None, :, None] * sheet.tangents[None, None, :, None, :]
    law = stiffness * np.eye(sheet.dimension)
    return _energy(sheet, mean + turn, mean - turn, law, weights)


def _surface_strain(sheet: SheetFacets, where: Array) -> Array:
    """Strains (f, q, v, k, dim) along the surface of nodal displacements: xx; or xx, zz, xz."""
    slope = sheet.slopes(where)  # (f, q, k, a)
    count, points, nodes, _ = slope.shape
    strain = np.zeros((count, points, 2 * sheet.dimension - 1, nodes, sheet.dimension))
    for a in range(sheet.dimension):
        strain[:, :, a, :, a] = slope[..., a]
    if sheet.dimension == 2:
        strain[:, :, 2, :, 0] = slope[..., 1]
        strain[:, :, 2, :, 1] = slope[..., 0]
    return np.asarray(strain @ sheet.tangents)


def _energy(sheet: SheetFacets, above: Array, below: Array, law: Array, weights: Array) -> Array:
    """Integrals of law : s : s; s (f, q, v, k, dim) of upper nodes' motions and of those below."""
    rows = np.concatenate([above, below], axis=3).reshape(*above.shape[:3], -1)
    measure = np.outer(sheet.measure, weights / weights.sum())
    scaled = np.einsum("vw,fqwj,fq->fqvj", law, rows, measure, optimize=True)
    size = rows.shape[1] * rows.shape[2]
    left = rows.reshape(len(rows), size, -1).transpose(0, 2, 1)
    return np.asarray(left @ scaled.reshape(len(rows), size, -1))


def _plane_ends(sheet: SheetFacets, modulus: float) -> Iterator[tuple[IntArray, IntArray, Array]]:
    """Dofs, dofs and stiffness of springs that hold each end face's middle nodes between their
    pair, as stiff as a strip of the plate. Each shares in the area as often as facets have its
    node, so that on the mirror plane of a half model a spring is half of the whole's."""
    dimension = len(sheet.normal)
    uses = np.bincount(sheet.nodes.ravel(), minlength=len(sheet.own))[sheet.upper]
    shares = (uses / uses.sum())[sheet.pair].repeat(dimension)
    springs = modulus * float(sheet.measure.sum()) / sheet.thickness * shares
    trio = sheet.between, sheet.upper[sheet.pair], sheet.lower[sheet.pair]
    dofs = [sheet.dofs.reshape(-1, dimension)[nodes].ravel() for nodes in trio]
    shared = list(zip(dofs, (1.0, -0.5, -0.5), strict=True))
    for (one, a), (two, b) in product(shared, repeat=2):
        yield one, two, springs * (a * b)
