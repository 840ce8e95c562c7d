"""How large a model will be, before it is meshed: elements, nodes, dofs, contact nodes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.forecast.elements import count_section, count_space
from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.fem.model import candidate_facets, element_of, fixed_dofs
from fingerdesign.layout.frames import mirrors_in_z, plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cache import kept_mesh_file, load_mesh, mesh_key
from fingerdesign.mesh.files.imported import imported_mesh
from fingerdesign.mesh.make import mesher_name
from fingerdesign.mesh.section.extrude import layer_borders
from fingerdesign.mesh.section.section import extruded_sizes, inner_of, section_sizes
from fingerdesign.mesh.sizing import MeshSizes
from fingerdesign.mesh.types import Mesh

# Of tetwild's meshes of T tetrahedra, least squares over 100 random designs and the shipped ones:
# nodes 1.33 T + 4.3 T^(2/3) (1.38 to 1.75 T; scatter 4 %), vertices 0.165 T + 1.3 T^(2/3).
_NODES, _CORNERS = (1.33, 4.3), (0.165, 1.3)
_FREE = 0.985  # of tetwild's displacements: the rest is held at the base and the mirror plane
_SPARE_ROWS = 3  # sums of the supports' forces


@dataclass(frozen=True, kw_only=True)
class Counts:
    """The size of a model.

    mesher     "netgen" (a section), or the design's
    elements   triangles or tetrahedra; half: of half of the finger, z >= 0
    dofs       equations of the element used; kept: rows that they are condensed onto
    mesh_kept  the mesh stands already (in the cache, or in a file): these are its own numbers
    """

    dimension: int
    mesher: str
    elements: float
    dofs: float
    contact_nodes: float
    element: str = ""
    kept: float = 0.0
    layers: int = 0
    half: bool = False
    mesh_kept: bool = False


def count_model(case: Case, zone: Zone) -> Counts:
    """Expected counts of the model that ``pipeline.run`` makes of a case in a candidate zone."""
    design = case.design
    if case.fidelity == "plane-strain":
        found = _plane_strain(case, zone)
    elif mesher_name(design) == "extrude":
        found = _extruded(case, zone)
    elif design.mesh.mesher == "file":
        found = _of_mesh(imported_mesh(design, case.symmetric), case, zone)
    else:
        found = _space(case, zone)
    gages = 2 * design.plates.number + 6 * len(case.path_scene.readout.points_mm)
    kept = found.dimension * found.contact_nodes + gages + _SPARE_ROWS
    return replace(found, kept=kept, element=element_of(design))


def _equations(
    design: Design, dimension: int, corners: float, nodes: float, held: float, share: float = 1.0
) -> float:
    """Displacements of the nodes that the element has, less those held, and a mixed one's
    pressures."""
    element = element_of(design)
    own = corners if element == "P1" else nodes
    return share * dimension * (own - held) + (corners if element == "mixed" else 0.0)


def _plane_strain(case: Case, zone: Zone) -> Counts:
    design = case.design
    plan = count_section(design, zone.half_width, section_sizes(design, zone.half_width))
    linear = element_of(design) == "P1"
    held = plan.base_edges if linear else 2.0 * plan.base_edges + 1.0
    return Counts(
        dimension=2,
        mesher="netgen",
        elements=plan.triangles,
        dofs=_equations(design, 2, plan.corners, plan.nodes, held),
        contact_nodes=plan.contact_edges + 1.0,
    )


def _extruded(case: Case, zone: Zone) -> Counts:
    design = case.design
    frames = plate_frames(design) if design.plates.model != "none" else ()
    sizes = extruded_sizes(design, zone.half_width)
    plan = count_section(design, zone.half_width, sizes, frames, inner_of(design, zone))
    heights = _heights(case, plan.least_size)
    layers = (len(heights) - 1) * (1 if case.symmetric or not mirrors_in_z(design) else 2)
    deep = zone.half_depth if zone.half_depth is not None else np.inf
    planes = int((np.abs(heights) <= deep + 1e-9).sum())
    if mirrors_in_z(design) and not case.symmetric:
        planes = 2 * planes - 1
    nodes, corners = plan.nodes * (2 * layers + 1), plan.corners * (layers + 1)
    if element_of(design) == "P1":
        flat, held = plan.corners, (plan.base_edges + 1.0) * (layers + 1)
    else:
        flat, held = plan.nodes, (2.0 * plan.base_edges + 1.0) * (2 * layers + 1)
    dofs = _equations(design, 3, corners, nodes, held)
    return Counts(
        dimension=3,
        mesher="extrude",
        elements=3.0 * plan.triangles * layers,
        dofs=dofs - (flat if case.symmetric else 0.0),
        contact_nodes=(plan.contact_edges + 1.0) * planes,
        layers=layers,
        half=case.symmetric,
    )


def _heights(case: Case, least_size: float) -> Array:
    """Layer borders of the extruded model, mm: from z = 0 where the finger mirrors there."""
    design = case.design
    # The flattest triangles of a section are about half as high as regular ones of the least size.
    flattest = least_size * np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.4]])
    frames = plate_frames(design) if design.plates.model != "none" else ()
    ends = [end for frame in frames for end in (frame.low, frame.high)]
    core = design.body.core
    if core is not None and core.depth_mm is not None:
        ends += [-0.5 * core.depth_mm, 0.5 * core.depth_mm]
    return layer_borders(design, np.array(ends), flattest, np.array([[0, 1, 2]]))[0]


def _space(case: Case, zone: Zone) -> Counts:
    design = case.design
    key = mesh_key(design, MeshSizes.of(design, zone), zone, case.symmetric)
    own = mesher_name(design) == "tetwild"  # the only one whose meshes are kept
    kept = load_mesh(key) if own and kept_mesh_file(key).is_file() else None
    if kept is not None:
        return _of_mesh(kept, case, zone)
    tets, contact_nodes = count_space(design, zone, case.symmetric)
    nodes, corners = (a * tets + b * tets ** (2.0 / 3.0) for a, b in (_NODES, _CORNERS))
    return Counts(
        dimension=3,
        mesher=mesher_name(design),
        elements=tets,
        dofs=_equations(design, 3, corners, nodes, 0.0, _FREE),
        contact_nodes=contact_nodes,
        half=case.symmetric,
    )


def _of_mesh(mesh: Mesh, case: Case, zone: Zone) -> Counts:
    """The counts of a mesh that stands."""
    design = case.design
    corners = np.unique(mesh.corners)
    element = element_of(design)
    fixed = fixed_dofs(mesh).reshape(mesh.points.shape)
    dofs = int((~(fixed[corners] if element == "P1" else fixed)).sum())
    if element == "mixed":
        dofs += len(np.unique(mesh.corners[mesh.regions == 0]))
    facets = candidate_facets(mesh, zone.half_width, zone.half_depth)
    return Counts(
        dimension=mesh.dimension,
        mesher=mesh.mesher,
        elements=len(mesh.cells),
        dofs=dofs,
        contact_nodes=len(np.unique(facets[:, : mesh.dimension])),
        half=mesh.symmetric,
        mesh_kept=True,
    )
