"""A finger of constant section: its triangles swept through graded layers, prisms cut into tets.

Tetrahedra, because all that reads a mesh (readouts, sheets, quality, files) is made for simplices.
``fingerdesign bench hexahedra`` measures what that costs: forces are as good for the arithmetic as
with triquadratic hexahedra, or better; the strains of gages are not, by a factor of five or more.
"""

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

_LEAST_DEG = 1.1  # issue 4 asks 1 degree of extruded layers; snapped nodes may take a little of it
_END = 0.25  # of the plates' size: no smaller elements at the ends of thin plates
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
    used, triangles = np.unique(section.corners, return_inverse=True)
    triangles = triangles.reshape(section.corners.shape)
    flat = section.points[used]
    half = 0.5 * design.body.depth_mm
    heights = layer_heights(half, design.mesh.layers)
    tallest = float(np.diff(heights).max())
    heights = layer_heights(half, design.mesh.layers, tallest_layer(flat, triangles, tallest))
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


def layer_heights(half_depth: float, layers: int, most: float = np.inf) -> Array:
    """Layer borders from z = 0 to the free end, thinning toward it; mm.

    ``layers`` of them, or more where none may be taller than ``most`` (mm): from the free end they
    then grow as they would and stop at that height.
    """
    steps = _GROWTH ** np.arange(layers)
    steps *= half_depth / steps.sum()
    if steps[-1] > most:
        grown = np.minimum(steps, most)
        missing = int(np.ceil((half_depth - grown.sum()) / most - 1e-9))
        steps = np.concatenate([grown, np.full(missing, most)])
        steps *= half_depth / steps.sum()
    return np.asarray(np.concatenate([[0.0], np.cumsum(steps[::-1])]))


def tallest_layer(points: Array, triangles: IntArray, tallest: float) -> float:
    """Greatest height (mm) of a layer whose tetrahedra keep dihedral angles of _LEAST_DEG.

    points (n, 2), triangles (t, 3) of the section; tallest: the greatest height that is wanted.
    Prisms far taller than their triangles are cut into tetrahedra as flat as the triangles are
    small: where plates are thin, and nowhere else.
    """
    angle = _least_dihedral(points, triangles, tallest)
    for _ in range(8):
        if angle >= _LEAST_DEG:
            break
        tallest *= float(np.clip(0.98 * angle / _LEAST_DEG, 0.2, 0.98))
        angle = _least_dihedral(points, triangles, tallest)
    return tallest


def _least_dihedral(points: Array, triangles: IntArray, height: float) -> float:
    """Least dihedral angle, degrees, of a layer of ``height`` (mm) cut into tetrahedra."""
    both = np.column_stack([np.tile(points, (2, 1)), np.repeat([0.0, height], len(points))])
    corners = both[_prisms(triangles, len(points), 0)]
    gradients = np.linalg.inv(corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    gradients = np.concatenate([-gradients.sum(axis=1, keepdims=True), gradients], axis=1)
    gradients /= np.linalg.norm(gradients, axis=2, keepdims=True)
    first, second = np.triu_indices(4, k=1)
    cosine = -np.einsum("tij,tij->ti", gradients[:, first], gradients[:, second])
    return float(np.degrees(np.arccos(np.clip(cosine.max(), -1.0, 1.0))))


def _section_sizes(design: Design) -> SectionMesh:
    mesh = design.mesh
    return mesh.section.model_copy(
        update={
            "contact_size_mm": mesh.contact_size_mm,
            "plate_size_mm": mesh.plate_size_mm,
            "plate_end_size_mm": max(design.plates.thickness_mm, _END * mesh.plate_size_mm),
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
