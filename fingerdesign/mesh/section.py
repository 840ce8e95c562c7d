"""Graded triangles of the finger's cross-section, plates resolved (netgen's 2-D mesher).

Netgen makes the same mesh every time and takes 0.3 s; its licence (LGPL) suits a library that is
imported, unlike gmsh's (GPL) and Triangle's (no commercial use).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import PlateFrame, crest_height, plate_frames, surface_height
from fingerdesign.errors import MeshError
from fingerdesign.mesh.types import TRIANGLE_EDGES, Mesh, quadratic

if TYPE_CHECKING:
    from fingerdesign.design.meshing import SectionMesh
    from fingerdesign.design.schema import Body, Design

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def mesh_section(design: Design, zone_half_width: float, sizes: SectionMesh | None = None) -> Mesh:
    """Quadratic triangles of the section z = 0, fine over |x| <= ``zone_half_width`` (mm).

    Raises MeshError where netgen returns a mesh that does not fill the section.
    """
    sizes = sizes if sizes is not None else design.mesh.section
    frames = plate_frames(design) if design.plates.model == "solid" else ()
    zone = min(zone_half_width, 0.5 * design.body.width_mm)
    points, triangles, regions = _netgen(design.body, frames, zone, design.gages.length_mm, sizes)
    points, triangles, regions = _drop_unused(points, triangles, regions)
    _check_areas(design.body, frames, points, triangles, regions)
    nodes, cells = quadratic(points, triangles)
    facets = _classify(design.body, nodes, cells)
    nodes = _onto_arc(design.body, nodes, facets["contact"])
    return Mesh(nodes, cells, regions, facets, "netgen")


def _netgen(
    body: Body,
    frames: tuple[PlateFrame, ...],
    zone: float,
    gage_length: float,
    sizes: SectionMesh,
) -> tuple[Array, IntArray, IntArray]:
    from netgen.geom2d import SplineGeometry

    geometry = SplineGeometry()

    def add_point(x: float, y: float, size: float | None = None) -> int:
        return int(
            geometry.AppendPoint(x, y) if size is None else geometry.AppendPoint(x, y, maxh=size)
        )

    def add_line(a: int, b: int, left: int, right: int, size: float) -> None:
        geometry.Append(["line", a, b], leftdomain=left, rightdomain=right, maxh=size)

    half, height = 0.5 * body.width_mm, body.base_height_mm
    radius, centre = body.arc_radius_mm, crest_height(body) - body.arc_radius_mm
    corners = [add_point(x, y) for x, y in ((-half, 0), (half, 0), (half, height), (-half, height))]
    add_line(corners[0], corners[1], 1, 0, sizes.far_size_mm)
    add_line(corners[1], corners[2], 1, 0, sizes.far_size_mm)
    add_line(corners[3], corners[0], 1, 0, sizes.far_size_mm)

    # The arc from right to left, cut where the zone ends; the control point of each piece is where
    # its end tangents meet, which makes netgen's rational spline an exact circle.
    stations = [half, zone, 0.0, -zone, -half] if zone < 0.999 * half else [half, 0.0, -half]
    arc_ends = [corners[2]]
    arc_ends += [add_point(x, float(surface_height(body, x))) for x in stations[1:-1]]
    arc_ends.append(corners[3])
    for k in range(len(stations) - 1):
        pair = np.array([[x, float(surface_height(body, x)) - centre] for x in stations[k : k + 2]])
        meet = np.linalg.solve(pair, [radius**2, radius**2])
        control = add_point(float(meet[0]), float(meet[1] + centre))
        inside = max(abs(stations[k]), abs(stations[k + 1])) <= zone + 1e-12
        geometry.Append(
            ["spline3", arc_ends[k], control, arc_ends[k + 1]],
            leftdomain=1,
            rightdomain=0,
            maxh=sizes.contact_size_mm if inside else sizes.far_size_mm,
        )

    for frame in frames:
        domain = 2 + frame.index
        # Vertices at the gage's ends, so that its strain is a difference of nodal displacements.
        along = [-0.5 * frame.length, 0.5 * frame.length]
        if gage_length < 0.98 * frame.length:
            along[1:1] = [-0.5 * gage_length, 0.5 * gage_length]
        rows = []
        for side in (-0.5, 0.5):
            where = [
                np.array([frame.x, frame.y])
                + s * frame.axis
                + side * frame.thickness * frame.normal
                for s in along
            ]
            last = len(where) - 1
            ends = (0, last)
            rows.append(
                [
                    add_point(float(x), float(y), sizes.plate_end_size_mm if k in ends else None)
                    for k, (x, y) in enumerate(where)
                ]
            )
        lower, upper = rows
        for k in range(len(along) - 1):
            add_line(lower[k], lower[k + 1], domain, 1, sizes.plate_size_mm)
            add_line(upper[k + 1], upper[k], domain, 1, sizes.plate_size_mm)
        add_line(lower[-1], upper[-1], domain, 1, sizes.plate_end_size_mm)
        add_line(upper[0], lower[0], domain, 1, sizes.plate_end_size_mm)
        geometry.SetDomainMaxH(domain, sizes.plate_size_mm)

    made = geometry.GenerateMesh(maxh=sizes.far_size_mm, grading=sizes.gradation)
    points = np.array(made.Coordinates(), dtype=float)[:, :2]
    elements = made.Elements2D().NumPy()
    triangles = np.asarray(elements["nodes"][:, :3], dtype=np.int64) - 1
    return points, triangles, np.asarray(elements["index"], dtype=np.int64) - 1


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
    body: Body,
    frames: tuple[PlateFrame, ...],
    points: Array,
    triangles: IntArray,
    regions: IntArray,
) -> None:
    areas = _areas(points, triangles)
    radius, half = body.arc_radius_mm, 0.5 * body.width_mm
    centre = crest_height(body) - radius
    asked = (
        half * np.sqrt(radius**2 - half**2) + radius**2 * np.arcsin(half / radius)
    ) + 2 * half * centre
    # Chords of the arc lie inside it: the linear mesh misses at most this much.
    if not abs(areas.sum() - asked) < 2e-3 * asked:
        raise MeshError(f"netgen filled {areas.sum():.4f} of {asked:.4f} mm^2 of the section")
    for frame in frames:
        filled = areas[regions == frame.index + 1].sum()
        if not abs(filled - frame.length * frame.thickness) < 1e-6 * frame.length * frame.thickness:
            raise MeshError(f"netgen lost part of plate {frame.index}: {filled:.6f} mm^2")


def _classify(body: Body, nodes: Array, cells: IntArray) -> dict[str, IntArray]:
    """Boundary edges by name, as (f, 3) corner, corner, middle."""
    edges = np.concatenate([cells[:, [a, b, 3 + k]] for k, (a, b) in enumerate(TRIANGLE_EDGES)])
    _, first, count = np.unique(edges[:, 2], return_index=True, return_counts=True)
    boundary = edges[first[count == 1]]
    ends = nodes[boundary[:, :2]]
    base = (np.abs(ends[:, :, 1]) < 1e-9).all(axis=1)
    side = (np.abs(np.abs(ends[:, :, 0]) - 0.5 * body.width_mm) < 1e-9).all(axis=1)
    return {
        "base": boundary[base],
        "side": boundary[side & ~base],
        "contact": boundary[~side & ~base],
    }


def _onto_arc(body: Body, nodes: Array, contact: IntArray) -> Array:
    nodes = nodes.copy()
    chosen = np.unique(contact)
    centre = np.array([0.0, crest_height(body) - body.arc_radius_mm])
    offset = nodes[chosen] - centre
    nodes[chosen] = centre + body.arc_radius_mm * offset / np.linalg.norm(
        offset, axis=1, keepdims=True
    )
    return nodes
