"""The two faces of a plate's slot: their facets, which node faces which, and what holds them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import tabulate

if TYPE_CHECKING:
    from fingerdesign.design.layout import PlateFrame
    from fingerdesign.mesh.types import Mesh

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

_SAME_PLACE = 1e-6  # mm: far below any element, far above rounding
_SHEAR_FACTOR = 5.0 / 6.0  # of a rectangular section


@dataclass(frozen=True)
class SheetFacets:
    """One plate: the facets of its upper face stand for its mid-surface.

    own (o,): numbers in the mesh of the plate's nodes; all other numbers are places in ``own``.
    nodes, nodes_below (f, k): of the upper face, and those that they face; tangents (s, dim),
    normal (dim,), s = dim - 1; flat (f, s + 1, s): corners in coordinates along the tangents (the
    plate's axis from its centre, and z); upper, lower (p,): nodes that face each other; between
    (b,), pair (b,): nodes on the end faces midway between those of a pair; thickness mm; mirrored:
    whether the facets end on a mirror plane at z = 0.
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
    mirrored: bool

    @property
    def dofs(self) -> IntArray:
        """Dofs (o dim,) of the mesh that are the plate's, node by node."""
        return _dofs(self.own, len(self.normal))

    @property
    def dimension(self) -> int:
        """Of the surface: 1 in plane strain, 2 in space."""
        return int(self.tangents.shape[0])

    @property
    def inverse(self) -> Array:
        """d reference_b / d coordinate_a, (f, b, a): facets are flat and straight."""
        return np.asarray(np.linalg.inv(self._jacobian))

    @property
    def measure(self) -> Array:
        """Length or area (f,)."""
        factor = 1.0 if self.dimension == 1 else 0.5
        return np.asarray(factor * np.abs(np.linalg.det(self._jacobian)))

    @property
    def _jacobian(self) -> Array:
        return (self.flat[:, 1:] - self.flat[:, :1]).transpose(0, 2, 1)

    def slopes(self, where: Array) -> Array:
        """Derivatives (f, q, k, s) of the shape functions along the tangents, at reference points
        ``where`` (s, q)."""
        gradient = tabulate(self.dimension, where).gradient
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
    partner = lower[_facing(mesh, frame, upper, lower)]
    between = np.setdiff1d(end, np.concatenate([upper, lower]))
    own = np.concatenate([upper, partner, between])
    place = np.empty(len(mesh.points), dtype=np.int64)
    place[own] = np.arange(len(own))
    normal, tangents = frame.normal, frame.axis[None, :]
    if mesh.dimension == 3:
        normal = np.append(normal, 0.0)
        tangents = np.array([[*frame.axis, 0.0], [0.0, 0.0, 1.0]])
    nodes = place[facets]
    return SheetFacets(
        own=own,
        nodes=nodes,
        nodes_below=nodes + len(upper),
        tangents=tangents,
        normal=normal,
        flat=_flat(mesh, frame, facets[:, : mesh.dimension]),
        upper=place[upper],
        lower=place[partner],
        between=place[between],
        pair=_facing(mesh, frame, between, upper),
        thickness=frame.thickness,
        mirrored=mesh.symmetric,
    )


def _flat(mesh: Mesh, frame: PlateFrame, nodes: IntArray) -> Array:
    """Coordinates (..., s) of nodes along the plate's tangents."""
    where = mesh.points[nodes]
    along = (where[..., :2] - np.array([frame.x, frame.y])) @ frame.axis
    return np.concatenate([along[..., None], where[..., 2:]], axis=-1)


def _facing(mesh: Mesh, frame: PlateFrame, nodes: IntArray, others: IntArray) -> IntArray:
    """For each node the place in ``others`` of the one at the same place along the plate."""
    here, there = _flat(mesh, frame, nodes), _flat(mesh, frame, others)
    distance, found = cKDTree(there).query(here, distance_upper_bound=_SAME_PLACE)
    if not np.isfinite(distance).all():
        raise SolverError(f"the faces of plate {frame.index}'s slot do not mirror each other")
    return np.asarray(found, dtype=np.int64)


def mean_of_faces(sheet: SheetFacets) -> sp.csr_matrix:
    """(o dim, o dim): displacements of the mid-surface, in the rows of the upper face's dofs."""
    dimension, size = len(sheet.normal), len(sheet.dofs)
    upper, lower = _dofs(sheet.upper, dimension), _dofs(sheet.lower, dimension)
    rows, columns = np.concatenate([upper, upper]), np.concatenate([upper, lower])
    return sp.csr_matrix((np.full(len(rows), 0.5), (rows, columns)), shape=(size, size))


def tie_faces(
    sheet: SheetFacets, youngs_modulus: float, poissons_ratio: float, depth: float
) -> sp.csr_matrix:
    """Symmetric stiffness (o dim, o dim), N/mm, that makes the faces turn with the mid-surface.

    Each pair has its share of the area; sheared by grad w + (u_upper - u_lower)/t it answers with
    the plate's transverse shear modulus. ``depth``: mm, of a plane-strain body.
    """
    size, thickness = len(sheet.dofs), sheet.thickness
    area = float(sheet.measure.sum()) * depth / len(sheet.upper)
    shear = youngs_modulus / (2.0 * (1.0 + poissons_ratio))
    total = sp.csr_matrix((size, size))
    for tangent, slope in zip(sheet.tangents, _nodal_slopes(sheet), strict=True):
        gap = _along(sheet.upper, tangent, size) - _along(sheet.lower, tangent, size)
        strain = gap / thickness + slope
        total = total + _SHEAR_FACTOR * shear * thickness * area * (strain.T @ strain)
    # The square ends stay plane: their middle nodes keep between those of their pair.
    for component in np.eye(len(sheet.normal)):
        ends = 0.5 * (
            _along(sheet.upper[sheet.pair], component, size)
            + _along(sheet.lower[sheet.pair], component, size)
        )
        off = _along(sheet.between, component, size) - ends
        total = total + youngs_modulus / thickness * area * (off.T @ off)
    return sp.csr_matrix(total)


def _nodal_slopes(sheet: SheetFacets) -> list[sp.csr_matrix]:
    """Rows (p, o dim) per tangent: slope of the mean w at each pair, the mean of its facets'."""
    nodes, count = sheet.nodes, len(sheet.upper)  # the upper face's nodes come first in ``own``
    slope = sheet.slopes(_reference_nodes(sheet.dimension))  # (f, node, shape, a)
    weight = np.broadcast_to(sheet.measure[:, None], nodes.shape)
    share = weight / np.bincount(nodes.ravel(), weight.ravel(), minlength=count)[nodes]
    rows = np.broadcast_to(nodes[:, :, None], slope.shape[:3]).ravel()
    columns = np.broadcast_to(nodes[:, None, :], slope.shape[:3]).ravel()
    size = len(sheet.dofs)
    mean = 0.5 * (_along(sheet.upper, sheet.normal, size) + _along(sheet.lower, sheet.normal, size))
    found = []
    for a in range(sheet.dimension):
        entries = ((share[:, :, None] * slope[..., a]).ravel(), (rows, columns))
        found.append(sp.csr_matrix(sp.csr_matrix(entries, shape=(count, count)) @ mean))
    return found


def _reference_nodes(dimension: int) -> Array:
    """Reference coordinates (s, k) of a facet's nodes: corners, then mid-edge nodes."""
    if dimension == 1:
        return np.array([[0.0, 1.0, 0.5]])
    return np.array([[0.0, 1.0, 0.0, 0.5, 0.5, 0.0], [0.0, 0.0, 1.0, 0.0, 0.5, 0.5]])


def _along(nodes: IntArray, direction: Array, size: int) -> sp.csr_matrix:
    """Rows (p, size): displacement of each node along a direction."""
    dimension = len(direction)
    rows = np.repeat(np.arange(len(nodes)), dimension)
    return sp.csr_matrix(
        (np.tile(direction, len(nodes)), (rows, _dofs(nodes, dimension))), shape=(len(nodes), size)
    )


def _dofs(nodes: IntArray, dimension: int) -> IntArray:
    return np.asarray((nodes[:, None] * dimension + np.arange(dimension)).ravel())
