"""Graded triangles of the finger's cross-section, plates resolved as boxes or as lines (netgen).

Netgen makes the same mesh every time, at about 30 microseconds a triangle; its licence (LGPL) suits
a library that is imported, unlike gmsh's (GPL) and Triangle's (no commercial use).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.layout import PlateFrame
from fingerdesign.design.volume import section_area
from fingerdesign.errors import MeshError
from fingerdesign.geometry.surface import surface_of
from fingerdesign.mesh.outline import BODY, Outline, body_outline, core_box
from fingerdesign.mesh.section_plates import add_plates, add_sheets, bend_faces, section_frames
from fingerdesign.mesh.section_process import run_netgen
from fingerdesign.mesh.section_sizes import section_sizes
from fingerdesign.mesh.sheets import boundary_facets, open_sheets, sheet_facets
from fingerdesign.mesh.types import Mesh, quadratic

if TYPE_CHECKING:
    from fingerdesign.design.meshing import SectionMesh
    from fingerdesign.design.schema import Body, Design


def mesh_section(
    design: Design,
    zone_half_width: float,
    sizes: SectionMesh | None = None,
    frames: tuple[PlateFrame, ...] | None = None,
) -> Mesh:
    """Quadratic triangles of the section z = 0, fine over |x| <= ``zone_half_width`` (mm).

    Plates that z = 0 does not cut are not in it, unless ``frames`` says which are. Raises MeshError
    where netgen returns a mesh that does not fill the section, and for a body that has no section
    in closed form.
    """
    if design.body.shape == "step":
        raise MeshError('body.shape = "step" has no section; analyse it in 3-D')
    sizes = sizes if sizes is not None else section_sizes(design, zone_half_width)
    sheets = design.plates.model == "sheet"
    frames = section_frames(design) if frames is None else frames
    core = core_box(design.body, design.core_region)
    zone = min(zone_half_width, 0.5 * design.body.width_mm)
    outline = body_outline(design.body, zone, sizes, core)
    if sheets:
        add_sheets(outline, frames, design.gages.length_mm, sizes, design.body)
    else:
        add_plates(outline, frames, design.gages.length_mm, sizes)
    points, triangles, regions = _netgen(outline, float(design.mesh.time_limit_s))
    points, triangles, regions = _drop_unused(points, triangles, regions)
    _check_areas(design, () if sheets else frames, points, triangles, regions)
    if sheets:
        end_size = sizes.plate_end_size_mm
        points, triangles = open_sheets(points, triangles, frames, design.body, end_size)
        filled = np.zeros(len(triangles) - len(regions), dtype=np.int64)
        regions = np.concatenate([regions, filled])
    nodes, cells = quadratic(points, triangles)
    slots = sheet_facets(nodes, cells, frames) if sheets else {}
    facets = _classify(design.body, nodes, cells, slots) | slots
    nodes = onto_surface(design.body, nodes, facets["contact"])
    nodes = bend_faces(nodes, cells, regions, frames)
    return Mesh(nodes, cells, regions, facets, "netgen", region_names=core_name(design))


def core_name(design: Design) -> dict[int, str]:
    """The region's name that a core adds to a mesh."""
    return {} if design.body.core is None else {design.core_region: "core"}


def _netgen(outline: Outline, time_limit_s: float) -> tuple[Array, IntArray, IntArray]:
    """Points, triangles and their regions (see types.Mesh), made in a process of its own."""
    try:
        points, triangles, domains = run_netgen(outline.as_dict(), time_limit_s)
    except MeshError as error:
        raise MeshError(
            f"netgen: {error}; sizes in [mesh.section] may be too fine for this section"
        ) from error
    return points, triangles, domains - BODY


def _drop_unused(
    points: Array, triangles: IntArray, regions: IntArray
) -> tuple[Array, IntArray, IntArray]:
    used, inverse = np.unique(triangles, return_inverse=True)
    points, triangles = points[used], inverse.reshape(triangles.shape)
    flipped = _areas(points, triangles) < 0
    triangles[flipped] = triangles[flipped][:, [0, 2, 1]]
    return points, triangles, regions


def _areas(points: Array, triangles: IntArray) -> Array:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return np.asarray(0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]))


def _check_areas(
    design: Design,
    frames: tuple[PlateFrame, ...],
    points: Array,
    triangles: IntArray,
    regions: IntArray,
) -> None:
    areas = _areas(points, triangles)
    asked = section_area(design.body)
    # Chords of arcs lie inside them: the linear mesh misses at most this much.
    if not abs(areas.sum() - asked) < 2e-2 * asked:
        raise MeshError(
            f"netgen filled {areas.sum():.4f} of {asked:.4f} mm^2 of the section: make the sizes "
            "in [mesh.section] smaller"
        )
    parts = [
        (f"plate {f.index}", f.index + 1, f.length * f.thickness, 2e-2 if f.bend_radius else 1e-6)
        for f in frames
    ]
    core = design.body.core
    if core is not None:
        parts.append(("the core", design.core_region, core.width_mm * core.height_mm, 1e-6))
    for name, region, size, most in parts:
        filled = areas[regions == region].sum()
        if not abs(filled - size) < most * size:
            raise MeshError(f"netgen lost part of {name}: {filled:.6f} of {size:.6f} mm^2")


def _classify(
    body: Body, nodes: Array, cells: IntArray, slots: dict[str, IntArray]
) -> dict[str, IntArray]:
    """Boundary edges by name, as (f, 3) corner, corner, middle; without those of ``slots``."""
    boundary = boundary_facets(cells, 2)
    taken = [rows[:, 2] for rows in slots.values()]
    if taken:
        boundary = boundary[~np.isin(boundary[:, 2], np.concatenate(taken))]
    ends = nodes[boundary[:, :2]]
    base = (np.abs(ends[:, :, 1]) < 1e-9).all(axis=1)
    side = (np.abs(np.abs(ends[:, :, 0]) - 0.5 * body.width_mm) < 1e-9).all(axis=1)
    return {
        "base": boundary[base],
        "side": boundary[side & ~base],
        "contact": boundary[~side & ~base],
    }


def onto_surface(body: Body, nodes: Array, contact: IntArray) -> Array:
    """Nodes (n, dim) with those of the contact facets moved to the exact surface."""
    nodes = nodes.copy()
    chosen = np.unique(contact)
    nodes[chosen] = surface_of(body).project(nodes[chosen])
    return nodes
