"""Thin plates as sheets: membrane and bending stiffness added to the elastomer's.

A plate is its mid-surface, a set of facets inside the mesh; along the surface's unit tangents the
displacement is u, along its normal w, both those of the quadratic elements:

    membrane  t C : eps(u) : eps(v)
    bending   t^3/12 C : grad grad w : grad grad v      (Kirchhoff)

C is the plane-stress tensor of the plate less that of the rubber, which fills the plate's volume in
this model (in plane strain the number E / (1 - nu^2), plate less rubber). Across the facets' edges
w' jumps; there bending is joined by an interior penalty

    - {M_nn(w)} [v_n] - {M_nn(v)} [w_n] + penalty [w_n] [v_n]

(Engel et al., CMAME 191 (2002) 3669; Brenner and Sung, J. Sci. Comput. 22 (2005) 83). A plate's
edges are free; on the mirror plane its normal turns by nothing.

What a sheet leaves out: the rubber displaced by the plate, and the arm t/2 at which shear tractions
act on its faces. Both are of the order of thickness over length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.design.layout import PlateFrame, plate_frames
from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import quadrature, tabulate

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mesh.types import Mesh

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Over the least value with which bending is never negative; measured on a cantilever, see tests.
_PENALTY = 1.5
_EDGES = {1: ((0,), (1,)), 2: ((0, 1), (1, 2), (0, 2))}
_AROUND = {1: (0, 1), 2: (3, 4, 5)}  # local node that names an edge: its end, its middle


@dataclass(frozen=True)
class SheetFacets:
    """One plate's facets: nodes (f, n) in the mesh, tangents (s, dim), normal (dim,), s = dim - 1.

    flat (f, s + 1, s): corners in coordinates along the tangents (x along the plate's axis, and z);
    from the plate's centre.
    """

    nodes: IntArray
    tangents: Array
    normal: Array
    flat: Array

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


def sheet_of(mesh: Mesh, frame: PlateFrame) -> SheetFacets:
    """The facets of one plate. Raises SolverError where the mesh has none for it."""
    name = f"plate_{frame.index}"
    if name not in mesh.facets:
        raise SolverError(
            f"the mesh has no facets '{name}': mesh the design again with plates.model = 'sheet'"
        )
    nodes = mesh.facets[name]
    corners = mesh.points[nodes[:, : mesh.dimension]]
    offset = corners[..., :2] - np.array([frame.x, frame.y])
    flat = (offset @ frame.axis)[..., None]
    if mesh.dimension == 2:
        return SheetFacets(nodes, frame.axis[None, :], frame.normal, flat)
    tangents = np.array([[*frame.axis, 0.0], [0.0, 0.0, 1.0]])
    flat = np.concatenate([flat, corners[..., 2:]], axis=2)
    return SheetFacets(nodes, tangents, np.append(frame.normal, 0.0), flat)


def design_sheets(design: Design, mesh: Mesh) -> sp.csr_matrix:
    """Upper triangle (n dim, n dim) of the stiffness of a design's plates as sheets, N/mm."""
    plate, rubber = design.material_of("plates"), design.material_of("body")
    return sheet_stiffness(
        mesh,
        plate_frames(design),
        (plate.youngs_modulus_MPa, plate.poissons_ratio),
        (rubber.youngs_modulus_MPa, rubber.poissons_ratio),
        thickness=design.body.depth_mm if mesh.dimension == 2 else 1.0,
    )


def sheet_stiffness(
    mesh: Mesh,
    frames: Sequence[PlateFrame],
    plate: tuple[float, float],
    rubber: tuple[float, float],
    thickness: float = 1.0,
) -> sp.csr_matrix:
    """Upper triangle (n dim, n dim) in CSR, N/mm, of all plates' membranes and bending.

    plate, rubber: Young's modulus (MPa) and Poisson's ratio; ``thickness`` (mm): the depth of a
    plane-strain body. Raises SolverError where the plate is softer than the rubber.
    """
    dimension = mesh.dimension
    law = _plane_stress(*plate, dimension - 1) - _plane_stress(*rubber, dimension - 1)
    if np.linalg.eigvalsh(law).min() < 0.0:
        raise SolverError(
            f"plates of {plate[0]:g} MPa in a body of {rubber[0]:g} MPa are no stiff sheets; use "
            "plates.model = 'solid'"
        )
    size = mesh.points.size
    rows, columns, values = [], [], []
    for frame in frames:
        sheet = sheet_of(mesh, frame)
        membrane = _membrane(sheet, law * frame.thickness * thickness)
        bending = _bending(mesh, sheet, law * frame.thickness**3 / 12.0 * thickness)
        for nodes, blocks in (membrane, *bending):
            count = blocks.shape[1]
            dofs = nodes[:, :, None] * dimension + np.arange(dimension)
            dofs = dofs.reshape(len(nodes), count)
            rows.append(np.repeat(dofs, count, axis=1).ravel())
            columns.append(np.tile(dofs, (1, count)).ravel())
            values.append(blocks.ravel())
    if not rows:
        return sp.csr_matrix((size, size))
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    upper = sp.csr_matrix(sp.triu(sp.coo_matrix(entries, shape=(size, size)), format="csr"))
    upper.sum_duplicates()
    return upper


def _plane_stress(youngs_modulus: float, poissons_ratio: float, dimension: int) -> Array:
    """Stress of strain (xx; or xx, zz and engineering xz) at no stress across the sheet, MPa."""
    nu = poissons_ratio
    modulus = youngs_modulus / (1.0 - nu**2)
    if dimension == 1:
        return np.array([[modulus]])
    return modulus * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])


def _membrane(sheet: SheetFacets, law: Array) -> tuple[IntArray, Array]:
    """Nodes (f, n) and blocks (f, n dim, n dim)."""
    where, weights = quadrature(sheet.dimension, 2)
    slope = _slopes(sheet, where)  # (f, q, n, a)
    count, points, nodes, _ = slope.shape
    strain = np.zeros((count, points, len(law), nodes, sheet.dimension))
    for a in range(sheet.dimension):
        strain[:, :, a, :, a] = slope[..., a]
    if sheet.dimension == 2:
        strain[:, :, 2, :, 0] = slope[..., 1]
        strain[:, :, 2, :, 1] = slope[..., 0]
    rows = (strain @ sheet.tangents).reshape(count, points, len(law), -1)
    measure = np.outer(sheet.measure, weights / weights.sum())
    blocks = np.einsum("fqvi,vw,fqwj,fq->fij", rows, law, rows, measure, optimize=True)
    return sheet.nodes, np.asarray(blocks)


def _bending(mesh: Mesh, sheet: SheetFacets, law: Array) -> list[tuple[IntArray, Array]]:
    """Nodes and blocks of the facets, and of the edges that join them."""
    curvature = _curvatures(sheet)  # (f, v, n)
    inside = np.einsum("fvi,vw,fwj,f->fij", curvature, law, curvature, sheet.measure, optimize=True)
    sides = _sides(mesh, sheet, law, curvature)
    parts = [(sheet.nodes, inside), *_joined(sheet, sides, law[0, 0])]
    across = np.outer(sheet.normal, sheet.normal)
    found = []
    for nodes, blocks in parts:
        size = nodes.shape[1] * len(across)
        spread = np.einsum("fij,kl->fikjl", blocks, across, optimize=True)
        found.append((nodes, spread.reshape(len(nodes), size, size)))
    return found


@dataclass(frozen=True)
class _Sides:
    """Each facet's edges, (e,): facet, name (the same on both sides) and whether on the mirror.

    turn (e, q, n): outward derivative of w; moment (e, n): M_nn of w; measure (e, q).
    """

    facet: IntArray
    name: IntArray
    mirror: NDArray[np.bool_]
    turn: Array
    moment: Array
    measure: Array


def _sides(mesh: Mesh, sheet: SheetFacets, law: Array, curvature: Array) -> _Sides:
    count = len(sheet.nodes)
    parts = []
    for edge, middle in zip(_EDGES[sheet.dimension], _AROUND[sheet.dimension], strict=True):
        ends = sheet.flat[:, list(edge)]
        outward, length = _outward(sheet, edge)
        if sheet.dimension == 1:
            where, share = np.array([[float(edge[0])]]), np.ones(1)
            turn = np.einsum("fqna,fa->fqn", _slopes(sheet, where), outward)
            voigt = np.ones((count, 1))
        else:
            turn, share = _turn_along(sheet, edge, outward)
            nx, nz = outward.T
            voigt = np.stack([nx**2, nz**2, nx * nz], axis=1)
        moment = np.einsum("fv,vw,fwn->fn", voigt, law, curvature, optimize=True)
        mirror = np.zeros(count, dtype=bool)
        if mesh.symmetric:
            mirror = np.abs(ends[:, :, -1]).max(axis=1) < 1e-9
        parts.append((sheet.nodes[:, middle], mirror, turn, moment, length[:, None] * share))
    name, mirror, turn, moment, measure = (np.concatenate(p) for p in zip(*parts, strict=True))
    facet = np.tile(np.arange(count), len(parts))
    return _Sides(facet, name, mirror, turn, moment, measure)


def _outward(sheet: SheetFacets, edge: tuple[int, ...]) -> tuple[Array, Array]:
    """Unit vectors (f, s) out of the facets through an edge, and the edges' lengths (1 in 2-D)."""
    centre = sheet.flat.mean(axis=1)
    first = sheet.flat[:, edge[0]]
    if sheet.dimension == 1:
        return np.sign(first - centre), np.ones(len(first))
    along = sheet.flat[:, edge[1]] - first
    length = np.linalg.norm(along, axis=1)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / length[:, None]
    turned = np.sign(np.einsum("fa,fa->f", normal, first - centre))
    return normal * turned[:, None], length


def _turn_along(sheet: SheetFacets, edge: tuple[int, ...], outward: Array) -> tuple[Array, Array]:
    """Outward derivative (f, q, n) at two Gauss points of an edge, from its lower-numbered end."""
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    t, share = quadrature(1, 3)
    both = []
    for a, b in (edge, edge[::-1]):
        where = corner[a][:, None] + (corner[b] - corner[a])[:, None] * t
        both.append(np.einsum("fqna,fa->fqn", _slopes(sheet, where), outward))
    forward = sheet.nodes[:, edge[0]] < sheet.nodes[:, edge[1]]
    return np.where(forward[:, None, None], both[0], both[1]), share


def _joined(sheet: SheetFacets, sides: _Sides, rigidity: float) -> list[tuple[IntArray, Array]]:
    """Interior-penalty blocks of edges between two facets, and of those on the mirror plane.

    With D = rigidity, |e| the edge's and |T| the facets' measure and N edges a facet, bending is
    never negative from the penalty N D |e| / 4 (1/|T1| + 1/|T2|) on; the mirror plane is an edge
    between a facet and its image.
    """
    edges = sheet.dimension + 1
    stiff = sides.measure.sum(axis=1) / sheet.measure[sides.facet]
    order = np.argsort(sides.name, kind="stable")
    same = np.flatnonzero(sides.name[order][1:] == sides.name[order][:-1])
    one, two = order[same], order[same + 1]
    turn = np.concatenate([sides.turn[one], sides.turn[two]], axis=2)
    moment = 0.5 * np.concatenate([sides.moment[one], sides.moment[two]], axis=1)
    penalty = _PENALTY * edges * rigidity / 4.0 * (stiff[one] + stiff[two])
    nodes = np.hstack([sheet.nodes[sides.facet[one]], sheet.nodes[sides.facet[two]]])
    parts = [(nodes, _penalised(turn, moment, penalty, sides.measure[one]))]
    edge = np.flatnonzero(sides.mirror)
    penalty = _PENALTY * edges * rigidity * stiff[edge]
    blocks = _penalised(sides.turn[edge], sides.moment[edge], penalty, sides.measure[edge])
    return [*parts, (sheet.nodes[sides.facet[edge]], blocks)]


def _penalised(turn: Array, moment: Array, penalty: Array, measure: Array) -> Array:
    mixed = np.einsum("eqi,ej,eq->eij", turn, moment, measure, optimize=True)
    square = np.einsum("eqi,eqj,eq,e->eij", turn, turn, measure, penalty, optimize=True)
    return np.asarray(square - mixed - mixed.transpose(0, 2, 1))


def _slopes(sheet: SheetFacets, where: Array) -> Array:
    """Derivatives (f, q, n, a) of the shape functions along the tangents at reference points."""
    gradient = tabulate(sheet.dimension, where).gradient
    return np.asarray(np.einsum("nbq,fba->fqna", gradient, sheet.inverse, optimize=True))


def _curvatures(sheet: SheetFacets) -> Array:
    """Second derivatives (f, v, n): xx; or xx, zz and twice xz. Constant in each facet."""
    dimension = sheet.dimension
    corner = np.hstack([np.zeros((dimension, 1)), np.eye(dimension)])
    slope = tabulate(dimension, corner).gradient  # (n, b, corner), linear in the reference
    reference = slope[:, :, 1:] - slope[:, :, :1]  # (n, b, c)
    second = np.einsum("nbc,fba,fcd->fnad", reference, sheet.inverse, sheet.inverse, optimize=True)
    if dimension == 1:
        return np.asarray(second[:, None, :, 0, 0])
    return np.stack([second[..., 0, 0], second[..., 1, 1], 2.0 * second[..., 0, 1]], axis=1)
