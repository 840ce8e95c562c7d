"""A finger of constant section: its triangles swept through graded layers, prisms cut into tets."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import plate_frames
from fingerdesign.errors import MeshError
from fingerdesign.mesh.section import core_name, mesh_section, onto_surface
from fingerdesign.mesh.section_plates import bend_faces, section_frames
from fingerdesign.mesh.sheets import boundary_facets, sheet_facets
from fingerdesign.mesh.types import Mesh, quadratic

if TYPE_CHECKING:
    from fingerdesign.design.meshing import SectionMesh
    from fingerdesign.design.schema import Design

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

_GROWTH = 1.15  # from the free end, where the field changes fastest, toward the mid-plane


def extrude(
    design: Design, zone_half_width: float, symmetric: bool = True, sizes: SectionMesh | None = None
) -> Mesh:
    """Quadratic tetrahedra of an extruded finger, or of its half z >= 0.

    ``sizes`` are those of the section (default: the 3-D sizes of the design's ``[mesh]``).
    Raises MeshError for a finger whose section changes along z.
    """
    if not design.extruded:
        raise MeshError(
            f"{design.design.name} is not of constant section; use mesh.mesher = 'tetwild'"
        )
    section = mesh_section(design, zone_half_width, sizes or _section_sizes(design))
    heights = layer_heights(0.5 * design.body.depth_mm, design.mesh.layers)
    used, triangles = np.unique(section.corners, return_inverse=True)
    triangles = triangles.reshape(section.corners.shape)
    flat = section.points[used]
    layers = len(heights)
    points = np.column_stack([np.tile(flat, (layers, 1)), np.repeat(heights, len(flat))])
    tets = np.vstack([_prisms(triangles, len(flat), k) for k in range(layers - 1)])
    regions = np.tile(np.repeat(section.regions, 3), layers - 1)
    if not symmetric:
        points, tets, regions = _mirrored(points, tets, regions, len(flat))
    tets = _oriented(points, tets)
    nodes, cells = quadratic(points, tets)
    frames = plate_frames(design) if design.plates.model == "sheet" else ()
    slots = sheet_facets(nodes, cells, frames)
    facets = _classify(design, nodes, cells, symmetric, slots) | slots
    nodes = onto_surface(design.body, nodes, facets["contact"])
    nodes = bend_faces(nodes, cells, regions, section_frames(design))
    notes: dict[str, float | int | str] = {"layers": layers - 1}
    return Mesh(
        nodes, cells, regions, facets, "extrude", symmetric, notes, region_names=core_name(design)
    )


def layer_heights(half_depth: float, layers: int) -> Array:
    """Layer borders from z = 0 to the free end, thinning toward it."""
    steps = _GROWTH ** np.arange(layers)[::-1]
    return np.asarray(np.concatenate([[0.0], np.cumsum(steps)]) * (half_depth / steps.sum()))


def _section_sizes(design: Design) -> SectionMesh:
    mesh = design.mesh
    return mesh.section.model_copy(
        update={
            "contact_size_mm": mesh.contact_size_mm,
            "plate_size_mm": mesh.plate_size_mm,
            "plate_end_size_mm": design.plates.thickness_mm,
            "far_size_mm": mesh.far_size_mm,
        }
    )


def _prisms(triangles: IntArray, stride: int, layer: int) -> IntArray:
    """Three tets a prism (3 t, 4); sorted triangle vertices make neighbours agree on diagonals."""
    low = np.sort(triangles, axis=1) + layer * stride
    high = low + stride
    parts = [
        np.column_stack([low, high[:, 2]]),
        np.column_stack([low[:, :2], high[:, 1:]]),
        np.column_stack([low[:, 0], high]),
    ]
    return np.stack(parts, axis=1).reshape(-1, 4)


def _mirrored(
    points: Array, tets: IntArray, regions: IntArray, shared: int
) -> tuple[Array, IntArray, IntArray]:
    """Both halves, the first ``shared`` points lying on z = 0: a mesh that mirrors exactly."""
    number = np.arange(len(points)) + len(points) - shared
    number[:shared] = np.arange(shared)
    both = np.vstack([points, points[shared:] * [1.0, 1.0, -1.0]])
    return both, np.vstack([tets, number[tets]]), np.tile(regions, 2)


def _oriented(points: Array, tets: IntArray) -> IntArray:
    p = points[tets]
    edges = p[:, 1:] - p[:, :1]
    negative = np.linalg.det(edges) < 0
    tets = tets.copy()
    tets[negative] = tets[negative][:, [0, 2, 1, 3]]
    return tets


def _classify(
    design: Design, nodes: Array, cells: IntArray, symmetric: bool, slots: dict[str, IntArray]
) -> dict[str, IntArray]:
    """Boundary facets by name, (f, 6); without those of ``slots``."""
    boundary = boundary_facets(cells, 3)
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
