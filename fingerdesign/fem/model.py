"""Mesh + materials -> ReducedModel: assemble, border, factor once, read everything off."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.design.layout import plate_frames
from fingerdesign.errors import SolverError
from fingerdesign.fem.assembly import assemble_stiffness
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.readout import gage_rows, strain_rows
from fingerdesign.fem.trace import ContactTrace, contact_trace
from fingerdesign.reduced import ReducedModel

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mesh.types import Mesh

Array = NDArray[np.float64]
_FREE_END = 0.5  # mm: reach of the corner singularity where pressures are not compared
# Base reaction against contact force: rounding leaves 1e-10 to 2e-8 (plates 27,000 times stiffer
# than the body); a model that loses force is wrong in the first digits.
_BALANCE = 1e-6


@dataclass(frozen=True)
class FiniteElementModel:
    """The reduced model with what is needed to recover full fields."""

    reduced: ReducedModel
    mesh: Mesh
    trace: ContactTrace
    free: NDArray[np.bool_]
    condensation: Condensation
    timings: dict[str, float]

    def displacement_fields(self, forces: Array) -> Array:
        """Nodal displacements (k, n, dim) mm of the mesh for contact forces (k, m, dim) N."""
        loads = (self.trace.operator.T @ forces.reshape(len(forces), -1).T)[self.free]
        fields = np.zeros((len(forces), len(self.free)))
        fields[:, self.free] = self.condensation.solve(loads).T
        return fields.reshape(len(forces), *self.mesh.points.shape)


def build_model(
    design: Design,
    mesh: Mesh,
    zone_half_width: float,
    readout_points: Array | None = None,
) -> FiniteElementModel:
    """Condense the finger onto the contact nodes with |x| <= ``zone_half_width`` (mm).

    readout_points: (p, 3) mm where strain tensors are wanted. Raises SolverError where the
    condensed model is out of balance.
    """
    start = time.perf_counter()
    stiffness = stiffness_of(design, mesh)
    assembled = time.perf_counter()
    fixed = fixed_dofs(mesh)
    free = ~fixed
    thickness = design.body.depth_mm if mesh.dimension == 2 else 1.0
    zone = candidate_facets(mesh, zone_half_width)
    trace = contact_trace(mesh.points, zone, thickness)
    frames = plate_frames(design)
    points, signs = _readout_points(mesh, readout_points)
    base = np.unique(mesh.facets["base"])
    parts = [
        trace.operator,
        gage_rows(mesh, frames, design.gages),
        *[
            sp.diags_array(sign) @ strain_rows(mesh, point)
            for point, sign in zip(points, signs, strict=True)
        ],
        _reaction_rows(stiffness, base, mesh.dimension),
    ]
    rows = sp.vstack(parts, format="csr")[:, free]
    reduced_stiffness = stiffness[free][:, free].tocsr()
    reduced_stiffness.sort_indices()
    rows, silent = _drop_empty(rows)
    matrix = np.zeros((len(silent), len(silent)))
    condensation = Condensation(reduced_stiffness, rows)
    matrix[np.ix_(~silent, ~silent)] = condensation.matrix
    reduced = _reduced(design, mesh, trace, matrix, len(frames), len(points))
    done = time.perf_counter()
    timings = {"assemble": assembled - start, "condense": done - assembled}
    return FiniteElementModel(reduced, mesh, trace, free, condensation, timings)


def stiffness_of(design: Design, mesh: Mesh) -> sp.csr_matrix:
    """Upper triangle of the stiffness of all dofs (whole depth in plane strain)."""
    body, plate = design.material_of("body"), design.material_of("plates")
    inside = mesh.regions == 0
    return assemble_stiffness(
        mesh.points,
        mesh.cells,
        np.where(inside, body.youngs_modulus_MPa, plate.youngs_modulus_MPa),
        np.where(inside, body.poissons_ratio, plate.poissons_ratio),
        thickness=design.body.depth_mm if mesh.dimension == 2 else 1.0,
    )


def fixed_dofs(mesh: Mesh) -> NDArray[np.bool_]:
    """Dofs (n dim,) held: all on the base, z on the mirror plane."""
    fixed = np.zeros(mesh.points.shape, dtype=bool)
    fixed[np.unique(mesh.facets["base"])] = True
    if mesh.symmetric:
        fixed[np.unique(mesh.facets["symmetry"]), 2] = True
    return fixed.reshape(-1)


def candidate_facets(mesh: Mesh, zone_half_width: float) -> NDArray[np.int64]:
    """Contact facets all of whose corners lie in |x| <= zone (mm), or all that there are."""
    facets = mesh.facets["contact"]
    corners = mesh.points[facets[:, : mesh.dimension], 0]
    return np.asarray(facets[(np.abs(corners) <= zone_half_width + 1e-9).all(axis=1)])


def _readout_points(mesh: Mesh, points: Array | None) -> tuple[Array, Array]:
    """Points (p, dim) inside the mesh, and signs (p, 6): xz and yz turn round in the mirror."""
    if points is None or len(points) == 0:
        return np.empty((0, mesh.dimension)), np.empty((0, 6))
    points = np.asarray(points, dtype=float)
    signs = np.ones((len(points), 6))
    if mesh.dimension == 2:
        return points[:, :2], signs  # in plane strain nothing depends on z
    if mesh.symmetric:
        behind = points[:, 2] < 0
        signs[behind, 4:] = -1.0
        points = points * np.where(behind[:, None], [1.0, 1.0, -1.0], 1.0)
    return points, signs


def _reaction_rows(
    stiffness: sp.csr_matrix, base: NDArray[np.int64], dimension: int
) -> sp.csr_matrix:
    """Rows (dim, dofs): force of the support on the base, sum over base nodes of K u."""
    indicator = np.zeros((stiffness.shape[0], dimension))
    for k in range(dimension):
        indicator[base * dimension + k, k] = 1.0
    total = stiffness @ indicator + stiffness.T @ indicator
    total -= stiffness.diagonal()[:, None] * indicator
    return sp.csr_matrix(total.T)


def _drop_empty(rows: sp.csr_matrix) -> tuple[sp.csr_matrix, NDArray[np.bool_]]:
    """Rows with an entry, and the mask of those without (motions that are held)."""
    silent = np.diff(rows.indptr) == 0
    return rows[~silent].tocsr(), silent


def _reduced(
    design: Design, mesh: Mesh, trace: ContactTrace, matrix: Array, plates: int, points: int
) -> ReducedModel:
    dimension = mesh.dimension
    size = len(trace.nodes) * dimension
    marks = np.cumsum([size, 2 * plates, 6 * points, dimension])
    where = mesh.points[trace.nodes]
    locked = np.zeros(where.shape, dtype=bool)
    if mesh.symmetric:
        locked[np.isin(trace.nodes, mesh.facets["symmetry"]), 2] = True
    compliance = matrix[:size, :size].copy()
    reaction = matrix[marks[2] : marks[3], :size]
    _decouple(compliance, locked.reshape(-1))
    _check_balance(reaction, locked, len(trace.nodes))
    edge = 0.5 * design.body.depth_mm - _FREE_END
    return ReducedModel(
        points=where,
        facets=trace.facets,
        facet_areas=trace.facet_areas,
        areas=trace.areas,
        compliance=compliance,
        gage_readout=matrix[marks[0] : marks[1], :size].copy(),
        point_readout=matrix[marks[1] : marks[2], :size].copy(),
        reaction_readout=reaction.copy(),
        surface=trace.surface,
        rim=_rim(mesh, trace),
        free_end=np.abs(where[:, 2]) > edge if dimension == 3 else np.zeros(len(where), dtype=bool),
        locked=locked,
        depth=design.body.depth_mm,
        symmetry_factor=2 if mesh.symmetric else 1,
        gage_x=np.array([frame.x for frame in plate_frames(design)]),
    )


def _decouple(compliance: Array, locked: NDArray[np.bool_]) -> None:
    """Give locked components a compliance of their own, so that their force comes out zero."""
    compliance[locked] = 0.0
    compliance[:, locked] = 0.0
    index = np.flatnonzero(locked)
    compliance[index, index] = np.diag(compliance)[~locked].mean()


def _check_balance(reaction: Array, locked: NDArray[np.bool_], nodes: int) -> None:
    """Every unit contact force must come out at the base (all but z of a half model)."""
    dimension = reaction.shape[0]
    held = dimension - 1 if locked.any() else dimension
    expected = -np.tile(np.eye(dimension), nodes)
    expected[:, locked.reshape(-1)] = 0.0
    error = float(np.abs(reaction - expected)[:held].max())
    if not error < _BALANCE:
        raise SolverError(
            f"the condensed model loses {error:.1e} of each contact force: stiffnesses or lengths "
            "differ by more than double precision can carry; bring the moduli closer together or "
            "the body's height closer to its width"
        )


def _rim(mesh: Mesh, trace: ContactTrace) -> NDArray[np.bool_]:
    """Nodes that also belong to contact facets outside the candidate zone."""
    facets = mesh.facets["contact"][:, : mesh.dimension]
    count_all = np.bincount(facets.ravel(), minlength=len(mesh.points))
    count_zone = np.bincount(trace.nodes[trace.facets].ravel(), minlength=len(mesh.points))
    return np.asarray((count_all > count_zone)[trace.nodes])
