"""Graded triangles of the finger's cross-section, plates resolved as boxes or as lines (netgen).

Netgen makes the same mesh every time, at 30 to 70 microseconds a triangle; its licence (LGPL) suits
a library that is imported; gmsh's (GPL) and Triangle's (no commercial use) do not.
"""

from dataclasses import asdict

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.schema import Body, Design
from fingerdesign.errors import Fault, MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.profile import profile_of
from fingerdesign.layout.surface import surface_of
from fingerdesign.mesh.cells import boundary_facets, facet_kind, outer_facets, quadratic
from fingerdesign.mesh.measures import cell_volumes, oriented
from fingerdesign.mesh.section.mirror import half_of, mirrored, partners, to_draw
from fingerdesign.mesh.section.netgen import triangulated
from fingerdesign.mesh.section.outline import BODY, Outline
from fingerdesign.mesh.section.plates import Inner, section_frames, section_outline, section_sizes
from fingerdesign.mesh.sheets import open_sheets, room_around, sheet_facets
from fingerdesign.mesh.types import Mesh, core_name


def bend_faces(
    points: Array, cells: IntArray, regions: IntArray, frames: tuple[PlateFrame, ...]
) -> Array:
    """Points (n, dim) of a quadratic mesh with the mid-nodes of bent plates' faces on the bend."""
    moved = points.copy()
    for frame in frames:
        if frame.bend_radius is None:
            continue
        outside = outer_facets(cells[regions == frame.index + 1])
        if points.shape[1] == 3:  # without the faces of constant z: where the plate ends
            outside = [rows[np.ptp(points[rows, 2], axis=1) > 1e-9] for rows in outside]
        face = np.unique(np.concatenate([rows.ravel() for rows in outside]))
        s, v = frame.local(points[face]).T
        on = np.abs(s) < 0.5 * frame.length - 1e-6  # the square ends stay as they are
        face, s = face[on], s[on]
        level = 0.5 * frame.thickness * np.sign(v[on])
        moved[face, :2] = frame.from_local(s, level)
    return moved


def mesh_section(
    design: Design,
    zone_half_width: float,
    sizes: SectionMesh | None = None,
    frames: tuple[PlateFrame, ...] | None = None,
    inner: Inner | None = None,
) -> Mesh:
    """Quadratic triangles of the section z = 0, fine over |x| <= ``zone_half_width`` (mm).

    Plates that z = 0 does not cut are not in it, unless ``frames`` names them. inner: a
    half-width (mm) over which contact edges are finest, and their length. A section that mirrors
    in x = 0 has a mesh that does, node by node, and a mirrored design the mirrored mesh. Raises
    MeshError where netgen returns a mesh that does not fill the section, and for a body that has
    no section in closed form.
    """
    if design.body.shape == "step":
        raise MeshError('body.shape = "step" has no section; analyse it in 3-D')
    sizes = sizes if sizes is not None else section_sizes(design, zone_half_width)
    sheets = design.plates.model == "sheet"
    frames = section_frames(design) if frames is None else frames
    shown, side = to_draw(frames)
    outline = section_outline(design, zone_half_width, sizes, shown, inner)
    other = _mirror_images(design, shown)
    points, triangles, regions = _triangles(design, outline, shown, other)
    if sheets:
        size = sizes.plate_end_size_mm
        points, triangles = open_sheets(points, triangles, shown, design.body, size)
        regions = np.pad(regions, (0, len(triangles) - len(regions)))
        if other is not None:
            points, triangles, regions = mirrored(points, triangles, regions, other)
    points = points * [side, 1.0]
    nodes, cells = quadratic(points, oriented(points, triangles))
    slots = sheet_facets(nodes, cells, frames) if sheets else {}
    facets = outline_facets(design.body, nodes, boundary_facets(cells), slots) | slots
    nodes = onto_surface(design.body, nodes, facets["contact"])
    nodes = bend_faces(nodes, cells, regions, frames)
    return Mesh(nodes, cells, regions, facets, "netgen", region_names=core_name(design))


def _triangles(
    design: Design, outline: Outline, frames: tuple[PlateFrame, ...], other: IntArray | None
) -> tuple[Array, IntArray, IntArray]:
    """Points (n, 2), triangles (t, 3) and regions (t,) of an outline; of its half where it mirrors
    (regions' images are ``other``), and the mirror image of that."""
    drawn = outline if other is None else half_of(outline)
    try:
        points, triangles, domains = triangulated(asdict(drawn), float(design.mesh.time_limit_s))
    except MeshError as error:
        raise MeshError(
            f"netgen: {error}; sizes in [mesh.section] may be too fine for this section"
        ) from error
    used, triangles = np.unique(triangles, return_inverse=True)
    points = points[used]
    triangles = oriented(points, triangles.reshape(-1, 3))
    number = np.arange(design.core_region + 1)
    number[1 : len(frames) + 1] = [frame.index + 1 for frame in frames]
    regions = number[domains - BODY]
    if other is not None:
        points, triangles, regions = mirrored(points, triangles, regions, other)
    solid = frames if design.plates.model != "sheet" else ()
    _check_areas(design, solid, points, triangles, regions)
    return points, triangles, regions


def _mirror_images(design: Design, frames: tuple[PlateFrame, ...]) -> IntArray | None:
    """Each region's mirror image in x = 0; None where the section does not mirror."""
    found = partners(frames)
    if found is None:
        return None
    own = np.array([frame.index + 1 for frame in frames], dtype=np.int64)
    regions = np.arange(design.core_region + 1)
    regions[own] = own[found]
    return regions


def _check_areas(
    design: Design,
    frames: tuple[PlateFrame, ...],
    points: Array,
    triangles: IntArray,
    regions: IntArray,
) -> None:
    areas = cell_volumes(points, triangles)
    requested = profile_of(design.body).area
    # Chords of arcs lie inside them: the linear mesh misses at most this much.
    if not abs(areas.sum() - requested) < 2e-2 * requested:
        raise MeshError(
            f"netgen filled {areas.sum():.4f} of {requested:.4f} mm^2 of the section: make the "
            "sizes in [mesh.section] smaller"
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


def outline_facets(
    body: Body, nodes: Array, boundary: IntArray, slots: dict[str, IntArray]
) -> dict[str, IntArray]:
    """Boundary facets (f, nodes) by name, those of the base, the sides and the contact surface;
    without those of ``slots``."""
    boundary = not_of_slots(boundary, slots)
    x, y, *_ = np.moveaxis(nodes[boundary[:, : facet_kind(boundary).corners]], 2, 0)
    base = (np.abs(y) < 1e-9).all(axis=1)
    side = (np.abs(np.abs(x) - 0.5 * body.width_mm) < 1e-9).all(axis=1) & ~base
    contact = ~side & ~base
    return {"base": boundary[base], "side": boundary[side], "contact": boundary[contact]}


def not_of_slots(boundary: IntArray, slots: dict[str, IntArray]) -> IntArray:
    """Those of the facets (f, nodes) that belong to none of the slots, by their last mid-node."""
    taken = [rows[:, -1] for rows in slots.values() if rows.shape[1] == boundary.shape[1]]
    return boundary[~np.isin(boundary[:, -1], np.concatenate([[-1], *taken]))]


def onto_surface(body: Body, nodes: Array, contact: IntArray) -> Array:
    """Nodes (n, dim) with those of the contact facets moved to the exact surface."""
    nodes = nodes.copy()
    chosen = np.unique(contact)
    nodes[chosen] = surface_of(body).project(nodes[chosen])
    return nodes


def sheet_room_faults(design: Design) -> list[Fault]:
    """Plates too close to each other or to a face to be opened as sheets in a section."""
    if design.plates.model != "sheet":
        return []
    frames = section_frames(design)
    for frame in frames:
        try:
            room_around(frame, frames, design.body)
        except MeshError as error:
            bound = f"'solid' where plates lie as close as here ({str(error).partition(';')[0]})"
            return [Fault("plates.model", "sheet", bound, "set plates.model = 'solid'")]
    return []
