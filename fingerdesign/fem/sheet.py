"""Thin plates as sheets: membrane and bending stiffness in slots of the rubber's mesh.

A slot has the plate's thickness t and two faces of paired nodes. The mean of a pair's displacements
is that of the mid-surface, u along its unit tangents and w along its normal:

    membrane  t C : eps(u) : eps(v)                     with the strain (w_upper - w_lower)/t across
    bending   t^3/12 D : grad grad w : grad grad v      (Kirchhoff)

with C the tensor in space and D that of plane stress (in plane strain the number E / (1 - nu^2)).
The strain across matters: pressed by 0.3 MPa on both faces, phosphor bronze stretches by a
microstrain, what a gage reads. Across the edges of the quadratic facets w' jumps; there bending is
joined by an interior penalty

    - {M_nn(w)} [v_n] - {M_nn(v)} [w_n] + penalty [w_n] [v_n]

(Engel et al., CMAME 191 (2002) 3669; Brenner and Sung, J. Sci. Comput. 22 (2005) 83). A plate's
edges are free; on the mirror plane its normal turns by nothing. The faces follow the mid-surface:
springs as stiff as the plate itself in shear hold

    u_upper - u_lower = -t grad w        (the slope at a node: the mean of its facets')

node by node, so that tractions on the faces act at their arm t/2. What is left out is the plate's
own warping, and that of its square ends, which stay plane. On maeno2000 (plates nine times as long
as thick), mixed elements, at complete slip, that makes of the largest reading: membrane 1.0 %, on
one face 0.9 %; in forces 2e-5; against solid plates on four times the dofs. Linear elements know
no curvature: with them the penalty alone bends, and a plate is 1.5 times too stiff.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.design.layout import PlateFrame, plate_frames
from fingerdesign.fem.assembly import lame_parameters
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.sheet_faces import SheetFacets, mean_of_faces, sheet_of, tie_faces

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mesh.types import Mesh

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Over the least value with which bending is never negative; measured on a cantilever, see tests.
_PENALTY = 1.5
_EDGES = {1: ((0,), (1,)), 2: ((0, 1), (1, 2), (0, 2))}
_AROUND = {1: (0, 1), 2: (3, 4, 5)}  # local node that names an edge: its end, its middle


def design_sheets(design: Design, mesh: Mesh) -> sp.csr_matrix:
    """Upper triangle (n dim, n dim) of the stiffness of a design's plates as sheets, N/mm."""
    plate = design.material_of("plates")
    return sheet_stiffness(
        mesh,
        plate_frames(design),
        plate.youngs_modulus_MPa,
        plate.poissons_ratio,
        thickness=design.body.depth_mm if mesh.dimension == 2 else 1.0,
    )


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
    law = _in_space(youngs_modulus, poissons_ratio, mesh.dimension - 1)
    rows, columns, values = [np.empty(0, int)], [np.empty(0, int)], [np.empty(0)]
    for frame in frames:
        sheet = sheet_of(mesh, frame)
        rigidity = _plane_stress(law) * frame.thickness**3 / 12.0 * thickness
        mean = mean_of_faces(sheet)
        one = (
            _assembled([_membrane(sheet, law * frame.thickness * thickness)], sheet)
            + mean.T @ _assembled(_bending(sheet, rigidity), sheet) @ mean
            + tie_faces(sheet, youngs_modulus, poissons_ratio, thickness)
        ).tocoo()
        rows.append(sheet.dofs[one.row])
        columns.append(sheet.dofs[one.col])
        values.append(one.data)
    row, column, value = np.concatenate(rows), np.concatenate(columns), np.concatenate(values)
    upper = row <= column
    size = mesh.points.size
    total = sp.csr_matrix((value[upper], (row[upper], column[upper])), shape=(size, size))
    total.sort_indices()
    return total


def _assembled(parts: list[tuple[IntArray, Array]], sheet: SheetFacets) -> sp.csr_matrix:
    """Sum of blocks (e, k dim, k dim) at nodes (e, k), as a symmetric matrix (o dim, o dim)."""
    dimension, size = len(sheet.normal), len(sheet.dofs)
    rows, columns, values = [], [], []
    for nodes, blocks in parts:
        count = blocks.shape[1]
        dofs = (nodes[:, :, None] * dimension + np.arange(dimension)).reshape(len(nodes), count)
        rows.append(np.repeat(dofs, count, axis=1).ravel())
        columns.append(np.tile(dofs, (1, count)).ravel())
        values.append(blocks.ravel())
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sp.csr_matrix(entries, shape=(size, size))


def _in_space(youngs_modulus: float, poissons_ratio: float, dimension: int) -> Array:
    """Stress of strain (xx, across; or xx, zz, engineering xz, across), MPa."""
    first, shear = lame_parameters(np.array(youngs_modulus), np.array(poissons_ratio))
    axial = [0, 1] if dimension == 1 else [0, 1, 3]
    law = np.zeros((axial[-1] + 1, axial[-1] + 1))
    law[np.ix_(axial, axial)] = first + 2.0 * shear * np.eye(len(axial))
    if dimension == 2:
        law[2, 2] = shear
    return law


def _plane_stress(law: Array) -> Array:
    """Stress of strain where there is none across the sheet, MPa."""
    return np.asarray(law[:-1, :-1] - np.outer(law[:-1, -1], law[-1, :-1]) / law[-1, -1])


def _membrane(sheet: SheetFacets, law: Array) -> tuple[IntArray, Array]:
    """Nodes (f, 2 k) of upper and lower face, and blocks (f, 2 k dim, 2 k dim).

    ``law`` (v, v): force per length of the sheet's own strains and of the strain across it.
    """
    where, weights = quadrature(sheet.dimension, 4)
    slope = sheet.slopes(where)  # (f, q, k, a)
    count, points, nodes, _ = slope.shape
    strain = np.zeros((count, points, len(law), nodes, sheet.dimension))
    for a in range(sheet.dimension):
        strain[:, :, a, :, a] = slope[..., a]
    if sheet.dimension == 2:
        strain[:, :, 2, :, 0] = slope[..., 1]
        strain[:, :, 2, :, 1] = slope[..., 0]
    mean = 0.5 * (strain @ sheet.tangents)  # (f, q, v, k, dim)
    value = tabulate(sheet.dimension, where).value.T / sheet.thickness
    opening = np.zeros_like(mean)
    opening[:, :, -1] = value[:, :, None] * sheet.normal
    both = np.concatenate([mean + opening, mean - opening], axis=3)
    rows = both.reshape(count, points, len(law), -1)
    measure = np.outer(sheet.measure, weights / weights.sum())
    blocks = np.einsum("fqvi,vw,fqwj,fq->fij", rows, law, rows, measure, optimize=True)
    return np.hstack([sheet.nodes, sheet.nodes_below]), np.asarray(blocks)


def _bending(sheet: SheetFacets, law: Array) -> list[tuple[IntArray, Array]]:
    """Nodes and blocks of the facets, and of the edges that join them."""
    curvature = _curvatures(sheet)  # (f, v, n)
    inside = np.einsum("fvi,vw,fwj,f->fij", curvature, law, curvature, sheet.measure, optimize=True)
    sides = _sides(sheet, law, curvature)
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


def _sides(sheet: SheetFacets, law: Array, curvature: Array) -> _Sides:
    count = len(sheet.nodes)
    parts = []
    for edge, middle in zip(_EDGES[sheet.dimension], _AROUND[sheet.dimension], strict=True):
        ends = sheet.flat[:, list(edge)]
        outward, length = _outward(sheet, edge)
        if sheet.dimension == 1:
            where, share = np.array([[float(edge[0])]]), np.ones(1)
            turn = np.einsum("fqna,fa->fqn", sheet.slopes(where), outward)
            voigt = np.ones((count, 1))
        else:
            turn, share = _turn_along(sheet, edge, outward)
            nx, nz = outward.T
            voigt = np.stack([nx**2, nz**2, nx * nz], axis=1)
        moment = np.einsum("fv,vw,fwn->fn", voigt, law, curvature, optimize=True)
        mirror = np.zeros(count, dtype=bool)
        if sheet.mirrored:
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
        both.append(np.einsum("fqna,fa->fqn", sheet.slopes(where), outward))
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
