"""A finger whose section is swept through graded layers of prisms.

Plates and core may end inside the body: layers have borders there, and what lies beyond is rubber.
"""

from itertools import pairwise

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.checks.body import sound_outline
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault, MeshError
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.layers import layered, not_layered, not_sweepable, overlaps
from fingerdesign.layout.rows import mirrors_in_z, plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cells import PRISM, TRIANGLE, facet_kind, outer_facets, quadratic
from fingerdesign.mesh.make import Mesher, mesher
from fingerdesign.mesh.measures import oriented
from fingerdesign.mesh.section.plates import extruded_sizes, inner_of, scaled
from fingerdesign.mesh.section.section import (
    bend_faces,
    mesh_section,
    not_of_slots,
    onto_surface,
    outline_facets,
    sheet_room_faults,
)
from fingerdesign.mesh.sheets import sheet_facets
from fingerdesign.mesh.types import Mesh, core_name

_SAME = 1e-9  # mm: borders that are one
# Heights of layers by default. Gages (the mean of both faces, and one face) and the work of a given
# contact pressure, in per cent of the largest, against nine layers of a finer section on maeno2000
# (8.2 mm high, 10 mm deep), whose half has 2, 3 or 4 layers: 2.2, 8.0, 0.5; 0.4, 2.6, 0.1 (37
# Gflop); 0.1, 0.9, 0.04 (72 Gflop). Graded with 0.75 or 1.15 they are no better. Tetrahedra on the
# nodes of four layers: 7.3 and 2.1 in the gages. So four there, and where a finger is deeper they
# grow away from the gages at z = 0 and from the free end.
_LAYER, _GROWTH, _LEAST_LAYERS = 0.13, 0.25, 3  # Of the crest's height; mm a mm; in half the depth.
_THINNEST = 0.01  # mm: the least height of a layer


def layer_heights(half_depth: float, layers: int, growth: float) -> Array:
    """Layer borders from z = 0 to the free end, each layer ``growth`` times as tall as the next one
    toward the end; mm."""
    steps = growth ** -np.arange(float(layers))
    borders = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(borders * (half_depth / borders[-1]))


def graded_heights(borders: Array, fine: Array, first: float, growth: float) -> Array:
    """Layer borders that hold all of ``borders``, ascending; mm. At the heights ``fine`` layers are
    ``first`` (mm) tall, and grow from there as those of layer_heights do."""
    found = [np.array([borders[0]])]
    rate = max(growth, 1.0 / growth) - 1.0
    for low, high in pairwise(borders):
        place = np.linspace(low, high, 401)
        away = np.abs(place[:, None] - fine[None, :]).min(axis=1)
        density = 1.0 / (first + rate * away)
        layers = 0.5 * (density[1:] + density[:-1]) * np.diff(place)
        total = np.concatenate([[0.0], np.cumsum(layers)])
        count = max(1, int(np.ceil(total[-1] - 0.05)))
        found.append(np.interp(np.linspace(0.0, total[-1], count + 1)[1:], total, place))
        found[-1][-1] = high
    return np.concatenate(found)


def layer_borders(design: Design, ends: Array, coarser: float = 1.0) -> Array:
    """Layer borders from z = 0, or where nothing mirrors there from end to end; mm.

    ends: z of the ends of parts. coarser: times as tall as by default or by ``mesh.layers``.
    """
    half, growth = 0.5 * design.body.depth_mm, design.mesh.layer_growth
    mirrors = mirrors_in_z(design)
    found = distinct(np.array([-half, half, *ends]))
    start = np.array([0.0, *found[found > 0.0]]) if mirrors else found
    if design.mesh.layers is None:
        first = min(_LAYER * float(crest_height(design.body)), half / _LEAST_LAYERS) * coarser
        return graded_heights(start, np.append(found, 0.0), first, 1.0 + _GROWTH * coarser)
    plain = layer_heights(half, max(1, round(design.mesh.layers / coarser)), growth)
    if len(found) == 2:
        return plain if mirrors else both_sides(plain)
    fine = found if growth >= 1.0 else np.append(found, 0.0)
    return graded_heights(start, fine, float(np.diff(plain).min()), growth)


def both_sides(heights: Array) -> Array:
    """Borders from end to end of those from z = 0 to the end."""
    return np.concatenate([-heights[:0:-1], heights])


def distinct(values: Array) -> Array:
    """Values in order, those that are the same but for rounding once."""
    ordered = np.sort(values)
    keep = np.concatenate([[True], np.diff(ordered) > _SAME])
    return np.asarray(ordered[keep])


def extrude(
    design: Design,
    zone: Zone,
    symmetric: bool = True,
    sizes: SectionMesh | None = None,
    coarser: float = 1.0,
) -> Mesh:
    """Quadratic prisms of a finger swept through layers, or of its half z >= 0.

    ``sizes`` are those of the section (default: the 3-D ones of ``[mesh]``, fit for the contact);
    ``coarser`` multiplies them, and the heights of the layers.
    Raises MeshError for a finger that cannot be swept (design.layers), and where plates end so
    near to each other along z that a layer between would be too thin.
    """
    why = not_layered(design)
    if why is None and symmetric and not mirrors_in_z(design):
        why = "its half, for the plates do not mirror in z = 0"
    if why is not None:
        raise MeshError(
            f"{design.design.name} cannot be swept through layers ({why}); use mesh.mesher = "
            "'tetwild'"
        )
    frames = plate_frames(design) if design.plates.model != "none" else ()
    sheets = frames if design.plates.model == "sheet" else ()
    flat_sizes = scaled(sizes or extruded_sizes(design, zone.half_width), coarser)
    inner = inner_of(design, zone, coarser)
    section = mesh_section(design, zone.half_width, flat_sizes, frames, inner)
    parts = _reaches(design, frames)
    drawn, drawn_regions = _drawn(section, sheets)
    flat, triangles = quadratic(section.points, oriented(section.points, drawn))
    heights = _heights(design, list(parts.values()), coarser)
    if mirrors_in_z(design) and not symmetric:
        heights = both_sides(heights)
    slots = {frame.index + 1 for frame in sheets}
    made, numbers = [], []
    for k, middle in enumerate(0.5 * (heights[1:] + heights[:-1])):
        own = _regions_at(float(middle), drawn_regions, parts, slots)
        made.append(prisms_over(triangles[own >= 0], len(flat), k))
        numbers.append(own[own >= 0])
    used, cells = np.unique(np.vstack(made), return_inverse=True)
    cells, regions = cells.reshape(-1, PRISM.nodes), np.concatenate(numbers)
    levels = np.interp(np.arange(2 * len(heights) - 1), np.arange(0, 2 * len(heights), 2), heights)
    nodes = np.column_stack([flat[used % len(flat)], levels[used // len(flat)]])
    faces = sheet_facets(nodes, cells, sheets) if sheets else {}
    facets = _classify(design, nodes, cells, symmetric, faces) | faces
    nodes = onto_surface(design.body, nodes, facets["contact"])
    nodes = bend_faces(nodes, cells, regions, frames)
    notes: dict[str, float | int | str] = {"layers": len(heights) - 1}
    names = core_name(design)
    return Mesh(nodes, cells, regions, facets, "sweep", symmetric, notes, region_names=names)


def prisms_over(triangles: IntArray, count: int, layer: int) -> IntArray:
    """Prisms (t, 18) over quadratic triangles (t, 6) of a section of ``count`` nodes.

    Nodes are numbered section by section: a layer has one at its foot, middle and top.
    """
    foot, middle, top = (triangles + (2 * layer + level) * count for level in range(3))
    corners = TRIANGLE.corners
    parts = [foot[:, :corners], top[:, :corners], foot[:, corners:], top[:, corners:]]
    return np.hstack([*parts, middle])


def _reaches(design: Design, frames: tuple[PlateFrame, ...]) -> dict[int, tuple[float, float]]:
    """Least and greatest z (mm) of each part, by its region."""
    found = {frame.index + 1: (frame.low, frame.high) for frame in frames}
    core = design.body.core
    if core is not None:
        half = 0.5 * design.body.core_depth_mm
        found[design.core_region] = (-half, half)
    return found


def _heights(design: Design, reaches: list[tuple[float, float]], coarser: float) -> Array:
    """Layer borders, mm. Raises MeshError where a layer would be too thin."""
    heights = layer_borders(design, np.ravel(reaches), coarser)
    thin = int(np.argmin(np.diff(heights)))
    if heights[thin + 1] - heights[thin] < _THINNEST:
        raise MeshError(
            f"parts of {design.design.name} end at z = {heights[thin]:.6g} and "
            f"{heights[thin + 1]:.6g} mm, too near to each other for a layer between: let them end "
            "together, or use mesh.mesher = 'tetwild'"
        )
    return heights


def _drawn(section: Mesh, sheets: tuple[PlateFrame, ...]) -> tuple[IntArray, IntArray]:
    """All triangles (t, 3) that some layer has, and their regions: slots are filled as plates."""
    cells, regions = [section.corners], [section.regions]
    for frame in sheets:
        rows = []
        for face in ("upper", "lower"):
            nodes = np.unique(section.facets[f"plate_{frame.index}_{face}"][:, :2])
            rows.append(nodes[np.argsort(frame.local(section.points[nodes])[:, 0])])
        upper, lower = rows
        corners = np.column_stack([lower[:-1], lower[1:], upper[1:], upper[:-1]])
        right = section.points[corners, 0].mean(axis=1) > 0.0
        corners[~right] = np.roll(corners[~right], 1, axis=1)  # mirrored, the other diagonal
        cells += [corners[:, :3], corners[:, [0, 2, 3]]]
        regions.append(np.full(2 * len(upper) - 2, frame.index + 1))
    return np.vstack(cells), np.concatenate(regions)


def _regions_at(
    z: float, regions: IntArray, parts: dict[int, tuple[float, float]], slots: set[int]
) -> IntArray:
    """Regions of the section's triangles at one z: rubber beyond a part's reach, -1 in a slot."""
    found = regions.copy()
    for region, (low, high) in parts.items():
        if not low < z < high:
            found[regions == region] = 0
        elif region in slots:
            found[regions == region] = -1
    return found


def _classify(
    design: Design, nodes: Array, cells: IntArray, symmetric: bool, slots: dict[str, IntArray]
) -> dict[str, IntArray]:
    """Boundary facets by name; without those of ``slots``."""
    found: dict[str, IntArray] = {}
    for boundary in outer_facets(cells):
        if facet_kind(boundary) is not TRIANGLE:
            found |= outline_facets(design.body, nodes, boundary, slots)
            continue
        outer = not_of_slots(boundary, slots)
        z = np.abs(nodes[outer[:, : TRIANGLE.corners], 2])
        found["end"] = outer[(np.abs(z - 0.5 * design.body.depth_mm) < 1e-9).all(axis=1)]
        if symmetric:
            found["symmetry"] = outer[(z < 1e-9).all(axis=1)]
    return found


@mesher("sweep", place=2)
class Extruder(Mesher):
    """A section swept through layers."""

    sections = True
    elements_from = "netgen's size field integrated over the section, times the layers"

    def make(self, design: Design, own: None, zone: Zone, symmetric: bool) -> Mesh:
        return extrude(design, zone, symmetric)

    def why_not(self, design: Design) -> str | None:
        why = not_sweepable(design)
        if why is None and sound_outline(design.body):
            why = overlaps(design)
        return None if why is None else f"swept through layers ({why})"

    def refusals(self, design: Design, symmetric: bool) -> list[Fault]:
        if layered(design):
            return sheet_room_faults(design)
        bound = "'tetwild' for a finger that cannot be swept through layers"
        return [Fault("mesh.mesher", "sweep", bound, "set mesh.mesher = 'tetwild'")]
