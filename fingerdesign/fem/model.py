"""Design + mesh -> ReducedModel: the finger as one body, with its gages and readout points."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.body import Body as FingerBody
from fingerdesign.design.gages import Gages
from fingerdesign.design.schema import Design, Part
from fingerdesign.fem.bars import bar_stiffness
from fingerdesign.fem.body import CondensedBody, condense_body
from fingerdesign.fem.readout import gage_rows, plate_at, plate_strain_rows, strain_rows
from fingerdesign.fem.reduction import decouple, reduced_model
from fingerdesign.fem.sheet import sheet_stiffness
from fingerdesign.fem.system import Body
from fingerdesign.fem.thermal import thermal_loads
from fingerdesign.fem.trace import ContactTrace, on_another
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.surface import surface_of
from fingerdesign.mesh.cells import facet_kind
from fingerdesign.mesh.types import Mesh
from fingerdesign.reduced import ReducedModel

# From this Poisson's ratio "auto" takes the mixed element. Measured on a finger with three plates
# (bench.precision_run.VALUES), five increments, errors of F_n and of the largest gage reading
# against a mesh of 60k (196k) dofs; mixed takes 1.2 to 1.3 times as long as P2 on the same mesh:
#                    nu =   0.3           0.4           0.45          0.49          0.499
#   2-D, 9k dofs   P2   2e-4, 0.4 %   7e-4, 0.7 %   6e-4, 1.1 %   2e-3, 2.2 %   3e-3, 4.1 %
#                mixed  1e-4, 0.3 %   4e-4, 0.3 %   3e-4, 0.3 %   8e-4, 0.4 %   8e-4, 0.4 %
#   3-D, 81k dofs  P2   1e-3, 0.7 %   3e-3, 1.7 %   4e-3, 2.8 %   8e-3, 4.7 %   1e-2, 6.5 %
#                mixed  1e-3, 0.6 %   2e-3, 0.7 %   2e-3, 0.7 %   3e-3, 0.8 %   3e-3, 0.9 %
# At 0.3 both are alike for the time; from 0.4 on no finer P2 mesh of the same time comes near.
MIXED_FROM = 0.4
_FREE_END = 0.5  # mm: reach of the corner singularity where pressures are not compared


@dataclass(frozen=True)
class FiniteElementModel:
    """The reduced model with what is needed to recover full fields."""

    reduced: ReducedModel
    condensed: CondensedBody
    timings: dict[str, float]

    @property
    def mesh(self) -> Mesh:
        return self.condensed.body.mesh

    @property
    def dofs(self) -> int:
        """Equations solved."""
        return self.condensed.dofs

    @property
    def element(self) -> str:
        """The element used: "P1", "P2" or "mixed"."""
        return self.condensed.body.element

    def displacement_fields(self, forces: Array) -> Array:
        """Nodal displacements (k, n, dim) mm of the mesh for contact forces (k, m, dim) N."""
        return self.condensed.displacement_fields(forces)


def build_model(
    design: Design,
    mesh: Mesh,
    zone_half_width: float,
    readout_points: Array | None = None,
    zone_half_depth: float | None = None,
    store: bool = False,
    frames: tuple[PlateFrame, ...] | None = None,
) -> FiniteElementModel:
    """Condense the finger onto the contact nodes with |x| <= ``zone_half_width`` (mm).

    readout_points: (p, 3) mm where strain tensors are read; zone_half_depth: mm, candidates only
    within |z| <= it as well; store: use and store answers; frames: the plates that the mesh shows,
    None: all. Where ``grip.warming_K`` warms the
    finger, the load of its own is one kelvin; a free plate's own expansion reads nothing. Raises
    SolverError where the condensed model is out of balance.
    """
    start = time.perf_counter()
    frames = plate_frames(design) if frames is None else frames
    body = body_of(design, mesh, candidate_facets(mesh, zone_half_width, zone_half_depth))
    gages = gage_rows(mesh, frames, design.gages, design.gage_weights)
    points, signs = _readout_points(mesh, readout_points)
    readouts = [gages]
    for point, sign in zip(points, signs, strict=True):
        rows = _point_rows(design, mesh, point)
        readouts.append(sp.csr_matrix(sp.diags_array(sign) @ rows))
    warms = design.grip.warming_K != 0.0
    if warms:
        readouts.append(sp.csr_matrix(thermal_loads(body, expansions_of(design, mesh)).T))
    read = time.perf_counter() - start
    condensed = condense_body(body, readouts, store)
    positions = gage_positions(frames, design.gages)
    alone = None
    if warms:  # the load of its own is that of one kelvin
        condensed = replace(condensed, load_displacement=condensed.readouts[-1][0])
        free = (design.expansion_of("plates") or 0.0) * (gages @ mesh.points.ravel())
        alone = (condensed.between[: gages.shape[0], -1] - free).reshape(-1, 2)
    depth = design.body.depth_mm
    reduced = reduced_model(
        condensed,
        gage_readout=condensed.readouts[0],
        point_readout=np.vstack(
            [np.empty((0, len(condensed.compliance))), *condensed.readouts[1 : 1 + len(points)]]
        ),
        gage_positions=positions,
        gage_x=places_along_x(frames, positions),
        free_ends=free_ends(design.body, mesh),
        depth=depth,
        load_gage_strain=alone,
    )
    timings = dict(condensed.timings)
    timings["condense"] += read
    return FiniteElementModel(reduced, condensed, timings)


@dataclass(frozen=True)
class ContactOf:
    """The contact of a model and its answers there, without its factors (2 GB of 300k dofs)."""

    mesh: Mesh
    trace: ContactTrace
    reduced: ReducedModel


def reduced_onto(design: Design, mesh: Mesh, of: ContactOf) -> ReducedModel:
    """The reduced model of a finger's mesh on the contact nodes of another mesh; both are swept.
    Answers are used again and stored."""
    trace, frames = on_another(of.trace, of.mesh, mesh), plate_frames(design)
    gages = gage_rows(mesh, frames, design.gages, design.gage_weights)
    body = body_of(design, mesh, mesh.facets["contact"])
    condensed = condense_body(body, [gages], store=True, trace=trace)
    compliance = condensed.compliance.copy()
    decouple(compliance, of.reduced.locked.reshape(-1))
    positions = gage_positions(frames, design.gages)
    return replace(
        of.reduced,
        compliance=compliance,
        gage_readout=condensed.readouts[0],
        gage_positions=positions,
        gage_x=places_along_x(frames, positions),
    )


def body_of(design: Design, mesh: Mesh, contact: IntArray) -> Body:
    """The finger as an elastic body fixed at its base, with ``contact`` (f, nodes) candidates."""
    young, poisson = materials_of(design, mesh)
    thickness, frames = design.body.depth_mm if mesh.dimension == 2 else 1.0, plate_frames(design)
    attached = bar_stiffness(design, mesh, frames)
    if design.plates.model == "sheet":
        plate = design.material_of("plates")
        moduli = plate.youngs_modulus_MPa, plate.poissons_ratio
        sheets = sheet_stiffness(mesh, frames, *moduli, thickness)
        attached = sheets if attached is None else (sheets + attached).tocsr()
    return Body(
        mesh=mesh,
        youngs_modulus=young,
        poissons_ratio=poisson,
        fixed=fixed_dofs(mesh),
        contact=contact,
        thickness=thickness,
        project=surface_of(design.body).project,
        element=element_of(design),
        pressure_cells=mesh.regions == 0,
        attached=attached,
    )


def element_of(design: Design) -> Literal["P1", "P2", "mixed"]:
    """The element that ``mesh.element`` asks for; "auto" decides by the body's Poisson's ratio."""
    if design.mesh.element != "auto":
        return design.mesh.element
    return "mixed" if design.material_of("body").poissons_ratio >= MIXED_FROM else "P2"


def materials_of(design: Design, mesh: Mesh) -> tuple[Array, Array]:
    """Young's modulus (MPa) and Poisson's ratio of each cell."""
    young = _by_part(design, mesh, lambda part: design.material_of(part).youngs_modulus_MPa)
    return young, _by_part(design, mesh, lambda part: design.material_of(part).poissons_ratio)


def expansions_of(design: Design, mesh: Mesh) -> Array:
    """Linear thermal expansion of each cell, 1/K; 0 where it is not known."""
    return _by_part(design, mesh, lambda part: design.expansion_of(part) or 0.0)


def _by_part(design: Design, mesh: Mesh, value: Callable[[Part], float]) -> Array:
    """The value (c,) of the part that each cell belongs to."""
    found = np.full(len(mesh.regions), value("plates"))
    found[mesh.regions == 0] = value("body")
    if design.body.core is not None:
        found[mesh.regions == design.core_region] = value("core")
    return found


def fixed_dofs(mesh: Mesh) -> BoolArray:
    """Fixed dofs (n dim,): all on the base, z on the mirror plane."""
    fixed = np.zeros(mesh.points.shape, dtype=bool)
    fixed[np.unique(mesh.facets["base"])] = True
    if mesh.symmetric:
        fixed[np.unique(mesh.facets["symmetry"]), 2] = True
    return fixed.reshape(-1)


def gage_positions(frames: Sequence[PlateFrame], gages: Gages) -> Array:
    """Centres of the gages (plates, 3), mm: on the mid-surfaces, of pairs between them."""
    if not frames:
        return np.empty((0, 3))
    centres = np.vstack([f.to_space(f.centre, f.middle + gages.z_mm) for f in frames])
    if gages.grid == "double_axial":
        centres = centres.reshape(-1, 2, 3).mean(axis=1).repeat(2, axis=0)
    return centres


def places_along_x(frames: Sequence[PlateFrame], positions: Array) -> Array:
    """Give x (plates,), mm, of gages at positions (plates, 3); NaN in a row along z, which has no
    place along the shear: it would read nothing of it and seem to slip there."""
    in_row = np.array([frame.along == "x" for frame in frames], dtype=bool)
    return np.where(in_row, positions[:, 0], np.nan)


def free_ends(body: FingerBody, mesh: Mesh) -> tuple[float, float] | None:
    """z between which the contact is clear of the body's free ends, mm; None where it has none.

    A free end is a flat z face that the contact surface runs into: there, within _FREE_END, the
    corner singularity spoils pressures. A turned body has none; a step body's are those of its
    "end" facets that share a node with its contact facets.
    """
    if mesh.dimension == 2 or body.kind.turned:
        return None
    high = 0.5 * body.depth_mm
    low = -high
    if body.shape == "step":
        end = mesh.facets.get("end", np.empty((0, 6), dtype=np.int64))
        z = mesh.points[np.intersect1d(end, mesh.facets["contact"]), 2]
        if not len(z):
            return None
        high = float(z.max()) if z.max() > 0.0 else np.inf
        low = float(z.min()) if z.min() < 0.0 else -np.inf
    return low + _FREE_END, high - _FREE_END


def candidate_facets(
    mesh: Mesh, zone_half_width: float, zone_half_depth: float | None = None
) -> IntArray:
    """Contact facets with all corners in |x| <= zone (and |z| <= zone_half_depth), mm."""
    facets = mesh.facets["contact"]
    corners = mesh.points[facets[:, : facet_kind(facets).corners]]
    inside = np.abs(corners[:, :, 0]) <= zone_half_width + 1e-9
    if zone_half_depth is not None and mesh.dimension == 3:
        inside &= np.abs(corners[:, :, 2]) <= zone_half_depth + 1e-9
    return np.asarray(facets[inside.all(axis=1)])


def _point_rows(design: Design, mesh: Mesh, point: Array) -> sp.csr_matrix:
    """Strain rows (6, n dim) at a point of the elastomer or of a plate, solid or sheet."""
    frame = plate_at(plate_frames(design), point) if design.plates.model == "sheet" else None
    if frame is None:
        return strain_rows(mesh, point)
    return plate_strain_rows(mesh, frame, design.material_of("plates").poissons_ratio, point)


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
