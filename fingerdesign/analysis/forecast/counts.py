"""Size of a model, before it is meshed: elements, nodes, dofs, contact nodes.

The meshers' size fields are integrated over body and section, by cells only as fine as the field:
that takes a tenth of a second on any body. The integral is multiplied by what the mesher was found
to make of it.
"""

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.arrays import Array
from fingerdesign.design.body import Body
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.schema import Design
from fingerdesign.fem.model import candidate_facets, element_of, fixed_dofs
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.layers import not_a_sheet
from fingerdesign.layout.profile import profile_of
from fingerdesign.layout.rows import mirrors_in_z, plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cache import load_mesh, mesh_key
from fingerdesign.mesh.counting import elements_within, expected_elements
from fingerdesign.mesh.files.imported import imported_mesh
from fingerdesign.mesh.make import mesher_name
from fingerdesign.mesh.section.extrude import layer_borders
from fingerdesign.mesh.section.outline import Outline
from fingerdesign.mesh.section.plates import (
    Inner,
    extruded_sizes,
    inner_of,
    section_frames,
    section_outline,
    section_sizes,
)
from fingerdesign.mesh.section.size_field import SectionSize, lengths_of, line_of
from fingerdesign.mesh.sizing import MeshSizes, SizeField
from fingerdesign.mesh.tetra.tetwild import size_field
from fingerdesign.mesh.tetra.ways import THICK, sized_frames
from fingerdesign.mesh.types import Mesh

EQUILATERAL = np.sqrt(3.0) / 4.0
# fTetWild made 1.65 times the integral on 20 random designs, 3.1 times where plates have holes (3
# of them): their rims are finer than any size names. Scatter 22 % (a standard deviation), 0.7 to
# 1.7 times.
MADE, MADE_WITH_HOLES = 1.65, 3.1
# Facets of the contact zone over the like integral of its surface.
MADE_AT_CONTACT = 0.68
# Netgen's size in a section is the least, over all points, curves and domains of the outline that
# it is given, of their own size grown with the distance, s + gradation x distance. Meshing takes
# 0.1 to 2.5 s of a core and 0.2 s to load netgen, this 0.003 to 0.09 s; a refusal for lack of
# memory counts dozens of models. Of the ten shipped parametric designs netgen makes 0.95 to 1.07
# times the triangles found here.
#
# Netgen grades faster than requested where the request is small. Of the mixtures tried on 153
# sections (51 random and shipped designs; the design's own sizes, those of extruding, random ones
# with gradations of 0.1 to 0.5) this one scattered least: triangles made over the integral 1.10,
# scatter 11 % (a standard deviation), 0.82 to 1.72 times; with the requested gradation 18 %,
# 0.39 to 1.79.
MADE_OF_SECTION = 1.10
GRADATION = (0.15, 0.6)  # Netgen's own, and the part that it takes of the requested one.
_SECTION_CELL = 2.0  # largest cell of the integral over the size there
_SECTION_DEEPEST = 14  # times a cell is cut into four at the most
_SECTION_CELLS = 80_000  # of one level: of more, some stand for all
# Of tetwild's meshes of T tetrahedra, least squares over 100 random designs and the shipped ones:
# nodes 1.33 T + 4.3 T^(2/3) (1.38 to 1.75 T; scatter 4 %), vertices 0.165 T + 1.3 T^(2/3).
_NODES, _CORNERS = (1.33, 4.3), (0.165, 1.3)
_FREE = 0.985  # of tetwild's displacements: the rest is held at the base and the mirror plane
_SPARE_ROWS = 3  # sums of the supports' forces


def count_space(design: Design, zone: Zone, symmetric: bool) -> tuple[float, float]:
    """Tetrahedra, and nodes of the candidate facets, that ``tetrahedralise``'s mesh of a finger, or
    of its half z >= 0, is expected to have."""
    frames = _sized(design, symmetric)
    field = size_field(design, frames, MeshSizes.of(design, zone), zone)
    low, high = field.box(design.body, symmetric)
    made = MADE_WITH_HOLES if any(frame.holes for frame in frames) else MADE
    return made * expected_elements(field, low, high), _contact_nodes(field, low, high)


def _sized(design: Design, symmetric: bool) -> tuple[PlateFrame, ...]:
    """The plates that the sizes go by, of the way that is tried first.

    Room to cut plates in is not checked: on CAD surfaces that takes seconds.
    """
    frames = plate_frames(design) if design.plates.model != "none" else ()
    thick = design.plates.thickness_mm > THICK * design.mesh.plate_size_mm
    solid = thick or any(not_a_sheet(frame, symmetric) for frame in frames)
    return frames if solid and design.plates.model != "sheet" else sized_frames(frames)


def _contact_nodes(field: SizeField, low: Array, high: Array) -> float:
    """Nodes of the candidate facets."""
    reach = np.array([field.zone.half_width, field.zone.half_depth or np.inf])
    first, last = np.maximum(low[[0, 2]], -reach), np.minimum(high[[0, 2]], reach)
    share = (np.arange(24) + 0.5) / 24
    x, z = np.meshgrid(*(first[k] + (last[k] - first[k]) * share for k in range(2)))
    x, z = x.reshape(-1), z.reshape(-1)
    y = field.surface.height(x, z)
    known = np.isfinite(y)
    size = field(np.column_stack([x, y, z])[known])
    cell = float(np.prod(last - first)) / len(x)
    facets = cell * (1.0 / (EQUILATERAL * field.sizes.stretch * size**2)).sum() * MADE_AT_CONTACT
    return float(0.5 * facets + 1.5 * np.sqrt(facets) + 1.0)


@dataclass(frozen=True)
class SectionCount:
    """triangles; edges of the outer boundary, the base, the contact zone."""

    triangles: float
    boundary_edges: float
    base_edges: float
    contact_edges: float

    @property
    def corners(self) -> float:
        """Vertices, by Euler's formula."""
        return 0.5 * (self.triangles + self.boundary_edges) + 1.0

    @property
    def nodes(self) -> float:
        """Vertices and middles of edges."""
        return self.corners + 0.5 * (3.0 * self.triangles + self.boundary_edges)


def count_section(
    design: Design,
    zone_half_width: float,
    sizes: SectionMesh,
    frames: tuple[PlateFrame, ...] | None = None,
    inner: Inner | None = None,
) -> SectionCount:
    """Expected size of ``mesh_section``'s mesh of a parametric body; see MADE for how well.

    zone_half_width: of the contact candidates, mm; frames: the plates that are drawn, by default
    those that z = 0 cuts; inner: see ``mesh_section``.
    """
    frames = section_frames(design) if frames is None else frames
    outline = section_outline(design, zone_half_width, sizes, frames, inner)
    field = SectionSize(outline, GRADATION[0] + GRADATION[1] * outline.gradation)
    inside = _section_integral(design.body, field)
    for frame in frames if design.plates.model == "solid" else ():
        along = np.linspace(-0.5, 0.5, 21)[:-1] + 0.025
        size = field(frame.from_local(along * frame.length, 0.0))
        # Where elements are larger than the plate is thick there are two for each such length.
        rows = 2.0 / size - frame.thickness / (EQUILATERAL * size**2)
        inside += float(np.mean(np.maximum(rows, 0.0)) * frame.length)
    outer, base = _boundary(outline, field)
    zone = min(zone_half_width, 0.5 * design.body.width_mm)
    x = np.linspace(-zone, zone, 401)
    line = np.column_stack([x, profile_of(design.body).height(x)])
    contact = float(_edges_along(line, field, 1).sum())
    return SectionCount(MADE_OF_SECTION * inside, outer, base, contact)


def _section_integral(body: Body, field: SectionSize) -> float:
    """Integral of 1 / (sqrt(3)/4 h^2) over the section, by cells no larger than the size."""
    profile = profile_of(body)
    half, crest = profile.half_width, profile.crest
    # An even coarser start where the far size is fine: it is cut until it is fine enough anyway.
    first = max(field.far, np.sqrt(2.0 * half * crest / (_SECTION_CELLS // 8)))
    count = np.maximum(np.ceil([2.0 * half / first, crest / first]), 1)

    def inside(cells: Array, sides: Array) -> Array:
        over = (profile.height(cells[:, 0]) - cells[:, 1]) / sides[1]
        return np.asarray(np.clip(over + 0.5, 0.0, 1.0))

    box = np.array([-half, 0.0]), np.array([half, crest])
    bounds = (_SECTION_CELL, _SECTION_DEEPEST, _SECTION_CELLS // 4)
    return elements_within(field, box, count, inside, lambda size: EQUILATERAL * size**2, bounds)


def _boundary(outline: Outline, field: SectionSize) -> tuple[float, float]:
    """Edges of the outer boundary, and of those on the base."""
    places = np.array([(x, y) for x, y, _ in outline.points])
    total = base = 0.0
    for numbers, left, right, _ in outline.curves:
        if left and right:
            continue
        line = line_of(places[numbers])
        edges = _edges_along(line, field, 20)
        total += float(edges.sum())
        base += float(edges[np.maximum(line[1:, 1], line[:-1, 1]) < 1e-9].sum())
    return total, base


def _edges_along(line: Array, field: SectionSize, samples: int) -> Array:
    """Edges (n - 1,) on the pieces of a line of n points: the mean of 1 / size, times length."""
    share = (np.arange(samples) + 0.5) / samples
    between = line[:-1, None] + share[:, None] * np.diff(line, axis=0)[:, None]
    inverse = 1.0 / field(between.reshape(-1, 2))
    return np.asarray(lengths_of(line) * inverse.reshape(-1, samples).mean(axis=1))


@dataclass(frozen=True, kw_only=True)
class Counts:
    """The size of a model.

    mesher     "netgen" (a section), or the design's
    elements   triangles or tetrahedra; half: of half of the finger, z >= 0
    dofs       equations of the element used; retained: rows that they are condensed onto
    parts      2: the model is a whole finger that mirrors, condensed by halves (fem/mirror.py)
    mesh_kept  the mesh exists already (in the cache, or in a file): these are its own numbers
    """

    dimension: int
    mesher: str
    elements: float
    dofs: float
    contact_nodes: float
    element: str = ""
    retained: float = 0.0
    layers: int = 0
    half: bool = False
    mesh_kept: bool = False
    parts: int = 1


def count_model(case: Case, zone: Zone) -> Counts:
    """Expected counts of the model that ``pipeline.run`` makes of a case in a candidate zone."""
    design = case.design
    if case.fidelity == "plane-strain":
        found = _plane_strain(case, zone)
    elif mesher_name(design) == "sweep":
        found = _extruded(case, zone)
    elif design.mesh.mesher == "file":
        found = _of_mesh(imported_mesh(design, case.symmetric), case, zone)
    else:
        found = _space(case, zone)
    gages = 2 * design.plates.number + 6 * len(case.path_scene.readout.points_mm)
    retained = found.dimension * found.contact_nodes + gages + _SPARE_ROWS
    return replace(found, retained=retained, element=element_of(design))


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
    heights, mirrored = _heights(case), mirrors_in_z(design) and not case.symmetric
    layers = (len(heights) - 1) * (2 if mirrored else 1)
    deep = zone.half_depth if zone.half_depth is not None else np.inf
    planes = int((np.abs(heights) <= deep + 1e-9).sum())
    planes = 2 * planes - 1 if mirrored else planes
    nodes, corners = plan.nodes * (2 * layers + 1), plan.corners * (layers + 1)
    flat, held = plan.nodes, (2.0 * plan.base_edges + 1.0) * (2 * layers + 1)
    if element_of(design) == "P1":
        flat, held = plan.corners, (plan.base_edges + 1.0) * (layers + 1)
    dofs = _equations(design, 3, corners, nodes, held)
    return Counts(
        dimension=3,
        mesher="sweep",
        elements=plan.triangles * layers,
        dofs=dofs - (flat if case.symmetric else 0.0),
        contact_nodes=(plan.contact_edges + 1.0) * planes,
        layers=layers,
        half=case.symmetric,
        parts=2 if mirrored and element_of(design) != "P1" else 1,
    )


def _heights(case: Case) -> Array:
    """Layer borders of the swept model, mm: from z = 0 where the finger mirrors there."""
    design = case.design
    frames = plate_frames(design) if design.plates.model != "none" else ()
    ends = [end for frame in frames for end in (frame.low, frame.high)]
    core = design.body.core
    if core is not None and core.depth_mm is not None:
        ends += [-0.5 * core.depth_mm, 0.5 * core.depth_mm]
    return layer_borders(design, np.array(ends))


def _space(case: Case, zone: Zone) -> Counts:
    design = case.design
    if mesher_name(design) == "tetwild":  # the only one whose meshes are cached
        key = mesh_key(design, MeshSizes.of(design, zone), zone, case.symmetric)
        if (cached := load_mesh(key)) is not None:
            return _of_mesh(cached, case, zone)
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
    """The counts of a mesh that exists."""
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
