"""A finger whose section is swept through graded layers, its prisms cut into tets.

Plates and core may end inside the body: layers have borders there, and what lies beyond is rubber.

Tetrahedra, because all that reads a mesh (readouts, sheets, quality, files) is made for simplices.
A study measured the cost (docs/reference/finished_studies.md): for the same arithmetic, forces are
as good as with triquadratic hexahedra, or better; strains of gages are three times less accurate.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.checks.body import sound_outline
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault, MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.layers import layered, not_layered, not_sweepable, overlaps
from fingerdesign.layout.rows import mirrors_in_z, plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cells import boundary_facets, quadratic, split_prisms
from fingerdesign.mesh.make import Mesher, mesher
from fingerdesign.mesh.measures import cell_angles, oriented
from fingerdesign.mesh.section.plates import extruded_sizes, inner_of
from fingerdesign.mesh.section.section import (
    bend_faces,
    mesh_section,
    onto_surface,
    sheet_room_faults,
)
from fingerdesign.mesh.sheets import sheet_facets
from fingerdesign.mesh.types import Mesh, core_name

LEAST_DEG = 1.1  # 1 degree is required of extruded layers; snapped nodes may take a little of it
_SAME = 1e-9  # mm: borders that are one


def layer_heights(half_depth: float, layers: int, growth: float, most: float = np.inf) -> Array:
    """Layer borders from z = 0 to the free end, each layer ``growth`` times as tall as the next one
    toward the end; mm.

    ``layers`` of them, or more where none may be taller than ``most`` (mm): from the thinnest they
    then grow as they would and stop at that height.
    """
    steps = max(growth, 1.0 / growth) ** np.arange(float(layers))
    steps *= half_depth / steps.sum()
    if steps[-1] > most:
        grown = np.minimum(steps, most)
        missing = int(np.ceil((half_depth - grown.sum()) / most - 1e-9))
        steps = np.concatenate([grown, np.full(missing, most)])
        steps *= half_depth / steps.sum()
    if growth >= 1.0:
        steps = steps[::-1]
    return np.asarray(np.concatenate([[0.0], np.cumsum(steps)]))


def graded_heights(
    borders: Array, fine: Array, first: float, growth: float, most: float = np.inf
) -> Array:
    """Layer borders that hold all of ``borders``, ascending; mm.

    At the heights ``fine`` layers are ``first`` (mm) tall, and grow from there as those of
    layer_heights do, up to ``most``.
    """
    found = [np.array([borders[0]])]
    rate = max(growth, 1.0 / growth) - 1.0
    for low, high in pairwise(borders):
        place = np.linspace(low, high, 401)
        away = np.abs(place[:, None] - fine[None, :]).min(axis=1)
        density = 1.0 / np.minimum(first + rate * away, most)
        total = np.concatenate(
            [[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(place))]
        )
        count = max(1, int(np.ceil(total[-1] - 0.05)))
        found.append(np.interp(np.linspace(0.0, total[-1], count + 1)[1:], total, place))
        found[-1][-1] = high
    return np.concatenate(found)


def layer_borders(
    design: Design, ends: Array, points: Array, triangles: IntArray
) -> tuple[Array, float]:
    """Layer borders from z = 0, or where nothing mirrors there from end to end, and the thinnest
    layer that is needed; mm.

    ends: z of the ends of parts; points (n, 2), triangles (t, 3): the section.
    """
    half, growth = 0.5 * design.body.depth_mm, design.mesh.layer_growth
    plain = layer_heights(half, design.mesh.layers, growth)
    most = tallest_layer(points, triangles, float(np.diff(plain).max()))
    plain = layer_heights(half, design.mesh.layers, growth, most)
    first = float(np.diff(plain).min())
    mirrors = mirrors_in_z(design)
    found = distinct(np.array([-half, half, *ends]))
    if len(found) == 2:
        return (plain if mirrors else np.concatenate([-plain[:0:-1], plain])), first
    start = np.array([0.0, *found[found > 0.0]]) if mirrors else found
    fine = found if growth >= 1.0 else np.append(found, 0.0)
    return graded_heights(start, fine, first, growth, most), first


def distinct(values: Array) -> Array:
    """Values in order, those that are the same but for rounding once."""
    ordered = np.sort(values)
    keep = np.concatenate([[True], np.diff(ordered) > _SAME])
    return np.asarray(ordered[keep])


def tallest_layer(points: Array, triangles: IntArray, tallest: float) -> float:
    """Greatest height (mm) of a layer whose tetrahedra keep dihedral angles of LEAST_DEG.

    points (n, 2), triangles (t, 3) of the section; tallest: the greatest height that is allowed.
    Prisms far taller than their triangles are cut into tetrahedra as flat as the triangles are
    small: where plates are thin, and nowhere else.
    """
    angle = least_dihedral(points, triangles, tallest)
    for _ in range(8):
        if angle >= LEAST_DEG:
            break
        tallest *= float(np.clip(0.98 * angle / LEAST_DEG, 0.2, 0.98))
        angle = least_dihedral(points, triangles, tallest)
    return tallest


def least_dihedral(points: Array, triangles: IntArray, height: float) -> float:
    """Least dihedral angle, degrees, of a layer of ``height`` (mm) cut into tetrahedra."""
    both = np.column_stack([np.tile(points, (2, 1)), np.repeat([0.0, height], len(points))])
    return float(cell_angles(both, split_prisms(triangles, triangles + len(points))).min())


def extrude(
    design: Design, zone: Zone, symmetric: bool = True, sizes: SectionMesh | None = None
) -> Mesh:
    """Quadratic tetrahedra of a finger swept through layers, or of its half z >= 0.

    ``sizes`` are those of the section (default: the 3-D ones of ``[mesh]``, fit for the contact).
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
    flat_sizes = sizes or extruded_sizes(design, zone.half_width)
    section = mesh_section(design, zone.half_width, flat_sizes, frames, inner_of(design, zone))
    parts = _reaches(design, frames)
    drawn, drawn_regions = _drawn(section, sheets, parts)
    used, triangles = np.unique(drawn, return_inverse=True)
    triangles = triangles.reshape(drawn.shape)
    flat = section.points[used]
    heights = _heights(design, list(parts.values()), flat, triangles)
    points = np.column_stack([np.tile(flat, (len(heights), 1)), np.repeat(heights, len(flat))])
    slots = {frame.index + 1 for frame in sheets}
    tets, numbers = [], []
    for k, middle in enumerate(0.5 * (heights[1:] + heights[:-1])):
        own = _regions_at(float(middle), drawn_regions, parts, slots)
        own_cells = triangles[own >= 0] + k * len(flat)
        # Cut alike, all layers would lean to one side; in turn mirrored, errors are half as large.
        sides = (own_cells, own_cells + len(flat))
        tets.append(split_prisms(*sides[:: 1 if k % 2 == 0 else -1]))
        numbers.append(np.repeat(own[own >= 0], 3))
    cells, regions = np.vstack(tets), np.concatenate(numbers)
    if mirrors_in_z(design) and not symmetric:
        # Both halves, whose first points lie on z = 0: a mesh that mirrors exactly.
        number = np.arange(len(points)) + len(points) - len(flat)
        number[: len(flat)] = np.arange(len(flat))
        points = np.vstack([points, points[len(flat) :] * [1.0, 1.0, -1.0]])
        cells, regions = np.vstack([cells, number[cells]]), np.tile(regions, 2)
    nodes, cells = quadratic(points, oriented(points, cells))
    faces = sheet_facets(nodes, cells, sheets)
    facets = _classify(design, nodes, cells, symmetric, faces) | faces
    nodes = onto_surface(design.body, nodes, facets["contact"])
    nodes = bend_faces(nodes, cells, regions, frames)
    notes: dict[str, float | int | str] = {"layers": len(heights) - 1}
    return Mesh(
        nodes, cells, regions, facets, "extrude", symmetric, notes, region_names=core_name(design)
    )


def _reaches(design: Design, frames: tuple[PlateFrame, ...]) -> dict[int, tuple[float, float]]:
    """Least and greatest z (mm) of each part, by its region."""
    found = {frame.index + 1: (frame.low, frame.high) for frame in frames}
    core = design.body.core
    if core is not None:
        half = 0.5 * design.body.core_depth_mm
        found[design.core_region] = (-half, half)
    return found


def _heights(
    design: Design, reaches: list[tuple[float, float]], points: Array, triangles: IntArray
) -> Array:
    """Layer borders of a section's mesh, mm. Raises MeshError where a layer would be too thin."""
    heights, first = layer_borders(design, np.ravel(reaches), points, triangles)
    steps = np.diff(heights)
    thin = int(np.argmin(steps))
    too_thin = steps[thin] < (1.0 - _SAME) * first
    if too_thin and least_dihedral(points, triangles, float(steps[thin])) < LEAST_DEG:
        raise MeshError(
            f"parts of {design.design.name} end at z = {heights[thin]:.4g} and "
            f"{heights[thin + 1]:.4g} mm, too near to each other for a layer between: let them end "
            "together, or use mesh.mesher = 'tetwild'"
        )
    return heights


def _drawn(
    section: Mesh, sheets: tuple[PlateFrame, ...], parts: dict[int, tuple[float, float]]
) -> tuple[IntArray, IntArray]:
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
    """Boundary facets by name, (f, 6); without those of ``slots``."""
    boundary = boundary_facets(cells)
    taken = [np.sort(rows[:, 3:], axis=1) for rows in slots.values()]
    if taken:
        key = np.vstack([*taken, np.sort(boundary[:, 3:], axis=1)])
        _, first = np.unique(key, axis=0, return_index=True)
        boundary = boundary[np.sort(first[first >= len(key) - len(boundary)]) - len(key)]
    corners = nodes[boundary[:, :3]]
    half, end = 0.5 * design.body.width_mm, 0.5 * design.body.depth_mm

    def lies_at(axis: int, value: float) -> NDArray[np.bool_]:
        return np.asarray((np.abs(corners[:, :, axis] - value) < 1e-9).all(axis=1))

    base = lies_at(1, 0.0)
    side = (lies_at(0, half) | lies_at(0, -half)) & ~base
    named = {"base": base, "side": side, "end": lies_at(2, end) | lies_at(2, -end)}
    if symmetric:
        named["symmetry"] = lies_at(2, 0.0)
    rest = ~np.any(list(named.values()), axis=0)
    return {name: boundary[mask] for name, mask in (named | {"contact": rest}).items()}


@mesher("extrude", place=2)
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
        return [Fault("mesh.mesher", "extrude", bound, "set mesh.mesher = 'tetwild'")]
