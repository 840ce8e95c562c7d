"""Measures of simplices: angles, aspects, edges, straight and curved volumes (numpy only)."""

import re
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.profile import profile_of
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import core_volume, face_areas, outline_volume, plate_volume
from fingerdesign.mesh.tetra.carriers import core_faces, outer_faces, plane, plate_faces
from fingerdesign.mesh.types import TETRA_EDGES, TETRA_FACETS, TRIANGLE_EDGES, Mesh, boundary_facets
from fingerdesign.shapes.faces import Carrier


def cell_volumes(points: Array, cells: IntArray) -> Array:
    """Signed areas of triangles or volumes of tetrahedra, (c,), by their corners."""
    a, *others = (points[cells[:, k]] for k in range(points.shape[1] + 1))
    if len(others) == 3:
        b, c, d = others
        return np.asarray(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0)
    u, v = (other - a for other in others)
    return np.asarray(0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]))


def oriented(points: Array, cells: IntArray) -> IntArray:
    """Linear cells, those of a negative area or volume turned round."""
    turned = cells.copy()
    negative = cell_volumes(points, cells) < 0.0
    turned[negative, 1:3] = cells[negative, 2:0:-1]
    return turned


def curved_cells(points: Array, cells: IntArray, tolerance: float = 1e-9) -> BoolArray:
    """Which quadratic cells (c, 6 or 10) have a mid-edge node off its edge's middle, (c,).

    ``tolerance``: of the edge's length.
    """
    pairs, first = (TRIANGLE_EDGES, 3) if cells.shape[1] == 6 else (TETRA_EDGES, 4)
    found = np.zeros(len(cells), dtype=bool)
    for edge, (i, j) in enumerate(pairs):
        a, b = points[cells[:, i]], points[cells[:, j]]
        away = np.linalg.norm(points[cells[:, first + edge]] - 0.5 * (a + b), axis=1)
        found |= away > tolerance * np.linalg.norm(b - a, axis=1)
    return found


def curved_volumes(points: Array, cells: IntArray) -> Array:
    """Signed areas (c,) of quadratic triangles (c, 6), or volumes of tetrahedra (c, 10), exact.

    The Jacobian determinant is quadratic in the plane and cubic in space: the middles of the edges,
    or the corners (1/40) and the middles of the faces (9/40), integrate it.
    """
    dim = points.shape[1]
    volumes = cell_volumes(points, cells[:, : dim + 1])
    bent = curved_cells(points, cells)
    if not bent.any():
        return volumes
    eye = np.eye(dim + 1)
    if dim == 2:
        samples = [(0.5 * (eye[i] + eye[j]), 1.0 / 3.0) for i, j in TRIANGLE_EDGES]
    else:
        samples = [(eye[i], 1.0 / 40.0) for i in range(4)]
        samples += [((1.0 - eye[i]) / 3.0, 9.0 / 40.0) for i in range(4)]
    nodes = points[cells[bent]]
    total = sum(weight * jacobians(nodes, place) for place, weight in samples)
    volumes[bent] = total / (2.0 if dim == 2 else 6.0)
    return volumes


def jacobians(nodes: Array, place: Array) -> Array:
    """Jacobian determinants (c,) of quadratic triangles or tetrahedra at one place in them.

    nodes (c, 6, 2) or (c, 10, 3); place (dim + 1,): barycentric coordinates. Of straight-sided
    cells: 2 or 6 times their area or volume.
    """
    dim = nodes.shape[2]
    gradient = np.zeros((nodes.shape[1], dim + 1))
    gradient[: dim + 1] = np.diag(4.0 * place - 1.0)
    for edge, (i, j) in enumerate(TRIANGLE_EDGES if dim == 2 else TETRA_EDGES):
        gradient[dim + 1 + edge, i] = 4.0 * place[j]
        gradient[dim + 1 + edge, j] = 4.0 * place[i]
    to_local = np.vstack([-np.ones(dim), np.eye(dim)])  # barycentric coordinates by local ones
    return np.asarray(np.linalg.det(np.einsum("cni,nj->cij", nodes, gradient @ to_local)))


def least_jacobian_ratios(points: Array, cells: IntArray) -> Array:
    """Least Jacobian of quadratic triangles or tetrahedra over the straight one's, (c,).

    Sampled at corners, edges' middles and centroid; 1 for straight edges, <= 0 folded; 0 for cells
    that have no volume.
    """
    dim = points.shape[1]
    ratio = np.ones(len(cells))
    bent = curved_cells(points, cells)
    nodes = points[cells[bent]]
    straight = (2.0 if dim == 2 else 6.0) * cell_volumes(points, cells[bent][:, : dim + 1])
    corners = np.eye(dim + 1)
    pairs = TRIANGLE_EDGES if dim == 2 else TETRA_EDGES
    places = [*corners, *(0.5 * (corners[i] + corners[j]) for i, j in pairs)]
    places.append(np.full(dim + 1, 1.0 / (dim + 1)))
    least = np.min([jacobians(nodes, place) for place in places], axis=0)
    ratio[bent] = np.divide(least, straight, out=np.zeros(len(least)), where=straight != 0.0)
    return ratio


def cell_angles(points: Array, cells: IntArray) -> Array:
    """Angles of triangles (c, 3), or dihedral angles of tetrahedra (c, 6), degrees."""
    if cells.shape[1] == 3:
        corners = points[cells]
        found = []
        for i in range(3):
            u = corners[:, (i + 1) % 3] - corners[:, i]
            v = corners[:, (i + 2) % 3] - corners[:, i]
            cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
            found.append(np.arctan2(np.abs(cross), np.einsum("ij,ij->i", u, v)))
        return np.asarray(np.degrees(np.stack(found, axis=1)))
    a, b, c, d = (points[cells[:, k]] for k in range(4))
    pairs = ((c - b, d - b), (d - a, c - a), (b - a, d - a), (c - a, b - a))
    faces = np.stack([np.cross(*pair) for pair in pairs], axis=1)  # all outward, or all inward
    one, other = (faces[:, k] for k in np.triu_indices(4, 1))
    sine = np.linalg.norm(np.cross(one, other), axis=2)
    return np.asarray(np.degrees(np.arctan2(sine, -np.einsum("tpk,tpk->tp", one, other))))


def edge_lengths(points: Array, cells: IntArray) -> Array:
    """Lengths (c, edges) of all corner-to-corner edges of simplices, mm."""
    one, other = (points[cells[:, ends]] for ends in np.triu_indices(cells.shape[1], 1))
    return np.asarray(np.linalg.norm(other - one, axis=2))


def aspects(points: Array, cells: IntArray) -> Array:
    """Longest edge over inscribed radius, scaled so that a regular simplex has 1, (c,)."""
    longest = edge_lengths(points, cells).max(axis=1)
    volume = np.maximum(np.abs(cell_volumes(points, cells)), 1e-300)
    if cells.shape[1] == 3:
        around = edge_lengths(points, cells).sum(axis=1)
        return np.asarray(longest * around / volume / (4.0 * np.sqrt(3.0)))
    surface = np.zeros(len(cells))
    for facet in TETRA_FACETS:
        a, b, c = (points[cells[:, corner]] for corner in facet)
        surface += 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.asarray(longest * surface / (3.0 * volume) / (2.0 * np.sqrt(6.0)))


def curved_areas(points: Array, facets: IntArray) -> Array:
    """Areas (f,) of quadratic triangles (f, 6) in space, by a six-point rule (degree 4)."""
    nodes = points[facets]
    total = np.zeros(len(facets))
    for weight, inner in (
        (0.223381589678011, 0.108103018168070),
        (0.109951743655322, 0.816847572980459),
    ):
        outer = 0.5 * (1.0 - inner)
        for spot in range(3):
            b = np.full(3, outer)
            b[spot] = inner
            du = np.array([1 - 4 * b[0], 4 * b[1] - 1, 0, 4 * (b[0] - b[1]), 4 * b[2], -4 * b[2]])
            dv = np.array([1 - 4 * b[0], 0, 4 * b[2] - 1, -4 * b[1], 4 * b[1], 4 * (b[0] - b[2])])
            normal = np.cross(np.einsum("fni,n->fi", nodes, du), np.einsum("fni,n->fi", nodes, dv))
            total += 0.5 * weight * np.linalg.norm(normal, axis=1)
    return total


_TOUCHES = 1e-6  # mm: a plate that ends in a face of the body


def worst_area_error(mesh: Mesh, design: Design) -> float:
    """Greatest relative error of an outer face's area, by the curved facets; 0 in the section."""
    if mesh.dimension == 2:
        return 0.0
    wanted = outer_areas(mesh, design)
    none = np.zeros((0, 6), dtype=np.int64)
    facets = {name: mesh.facets.get(name, none) for name in wanted}
    found = {name: curved_areas(mesh.points, rows).sum() for name, rows in facets.items()}
    groups = [{name} for name in wanted]
    for face in outer_faces(design.body, mesh.symmetric):
        joined = [group for group in groups if group & set(face.boundaries)]
        if len(joined) > 1:  # no edge tells where one ends and the next begins
            groups = [group for group in groups if group not in joined] + [set().union(*joined)]
    areas = [[sum(each[name] for name in group) for each in (found, wanted)] for group in groups]
    return max(abs(float(area) / given - 1.0) for area, given in areas if given > 0.0)


def outer_areas(mesh: Mesh, design: Design) -> dict[str, float]:
    """Areas of the outer faces by name, mm^2, less the mouths of sheets' slots."""
    wanted = dict(face_areas(design.body, mesh.symmetric))
    if design.plates.model != "sheet":
        return wanted
    for frame in plate_frames(design):
        mouth = frame.length * frame.thickness
        for name, area in _mouths(frame, design, mesh.symmetric, mouth):
            if name in wanted:
                wanted[name] -= area
    return wanted


def _mouths(
    frame: PlateFrame, design: Design, symmetric: bool, mouth: float
) -> list[tuple[str, float]]:
    """Where a slot opens in the body's outside, and how much of it."""
    body = design.body
    if frame.along == "x":
        low, high = -0.5 * body.depth_mm, 0.5 * body.depth_mm
        found = [("end", mouth)] if frame.high > high - _TOUCHES else []
        if symmetric:
            return [*found, ("symmetry", mouth)]
        return [*found, ("end", mouth)] if frame.low < low + _TOUCHES else found
    half = 0.5 * body.width_mm
    share = 0.5 if symmetric else 1.0
    sides = (frame.high > half - _TOUCHES) + (frame.low < -half + _TOUCHES)
    found = [("side", share * mouth * sides)] if sides else []
    if symmetric:
        level = abs(frame.axis[0]) > 0.5  # along z: cut across; upright: cut along its mid-surface
        found.append(("symmetry", frame.span * (frame.thickness if level else frame.length)))
    return found


@dataclass(frozen=True)
class VolumeFit:
    """Volumes (mm^3; in the section areas, mm^2) against the closed forms; errors are relative.

    regions: by name "volume" (curved cells), "straight" (by corners), "wanted" and "error"
    """

    regions: dict[str, dict[str, float]]
    body_error: float
    body_error_straight: float
    worst_plate_error: float


def meshed_plates(mesh: Mesh, design: Design) -> tuple[PlateFrame, ...]:
    """The frames that the mesh has, or should have: all in space; those that z = 0 cuts in 2-D."""
    if design.plates.model == "none":
        return ()
    frames = plate_frames(design)
    if mesh.dimension == 3:
        return frames
    return tuple(f for f in frames if f.along == "x" and f.low < 0.0 < f.high)


def wanted_volumes(mesh: Mesh, design: Design) -> dict[int, float]:
    """Volume by region, mm^3 (section: area, mm^2), of what the design says is solid there."""
    frames = meshed_plates(mesh, design)
    if mesh.dimension == 2:
        whole = profile_of(design.body).area
        plates = {frame.index + 1: frame.length * frame.thickness for frame in frames}
        core = design.body.core
        inner = core.width_mm * core.height_mm if core is not None else 0.0
    else:
        whole = outline_volume(design.body, mesh.symmetric)
        plates = {frame.index + 1: plate_volume(frame, mesh.symmetric) for frame in frames}
        inner = core_volume(design, mesh.symmetric)
    wanted = {0: whole - sum(plates.values()) - inner}
    if design.plates.model == "solid":
        wanted |= plates
    if inner:
        wanted[design.core_region] = inner
    return wanted


def volumes_by_region(mesh: Mesh, design: Design) -> VolumeFit:
    """Compare the volume of every region with the design's; a missing region has the error 1."""
    wanted = wanted_volumes(mesh, design)
    count = max(int(mesh.regions.max(initial=0)), *wanted) + 1
    curved = np.bincount(mesh.regions, curved_volumes(mesh.points, mesh.cells), count)
    straight = np.bincount(mesh.regions, cell_volumes(mesh.points, mesh.corners), count)
    present = np.bincount(mesh.regions, minlength=count) > 0
    regions = {}
    for number in range(count):
        if not present[number] and number not in wanted:
            continue
        requested = wanted.get(number, 0.0)
        regions[mesh.region_name(number)] = {
            "volume": float(curved[number]),
            "straight": float(straight[number]),
            "wanted": float(requested),
            "error": _error(float(curved[number]), requested),
        }
    whole = sum(wanted.values())
    strange = [n for n in range(1, count) if present[n] and n not in wanted]
    plates = [
        values["error"] for name, values in regions.items() if name not in ("elastomer", "core")
    ]
    return VolumeFit(
        regions,
        _error(float(curved.sum()), whole),
        _error(float(straight.sum()), whole),
        1.0 if strange else max(plates, default=0.0),
    )


def _error(found: float, wanted: float) -> float:
    return abs(found / wanted - 1.0) if wanted > 0.0 else 1.0


def face_distances(mesh: Mesh, design: Design) -> dict[str, float]:
    """Greatest distance (mm) of the nodes of each named face, mid-nodes too, to the CAD face.

    Besides the mesh's named facets, "plate_k" and "core": the surface of that region.
    """
    frames = {frame.index: frame for frame in meshed_plates(mesh, design)}
    outer = outer_faces(design.body, mesh.symmetric)
    found = {}
    for name, facets in mesh.facets.items():
        slot = re.fullmatch(r"plate_(\d+)_(upper|lower|end)", name)
        if slot and int(slot[1]) in frames:
            faces = plate_faces(frames[int(slot[1])])
        else:
            faces = [face for face in outer if name in face.boundaries]
        if faces:
            found[name] = _greatest(mesh, np.unique(facets), faces)
    cut: list[Carrier] = [plane("symmetry", (0.0, 0.0, -1.0), 0.0)] if mesh.dimension == 3 else []
    for number in np.unique(mesh.regions[mesh.regions > 0]):
        if number == design.core_region and design.body.core is not None:
            faces = core_faces(design.body)
        elif int(number) - 1 in frames:
            faces = plate_faces(frames[int(number) - 1])
        else:
            continue
        surface = boundary_facets(mesh.cells[mesh.regions == number], mesh.dimension)
        faces = faces + cut if mesh.symmetric else faces
        found[mesh.region_name(int(number))] = _greatest(mesh, np.unique(surface), faces)
    return found


def _greatest(mesh: Mesh, nodes: IntArray, faces: list[Carrier]) -> float:
    points = np.zeros((len(nodes), 3))
    points[:, : mesh.dimension] = mesh.points[nodes]
    away = np.min([np.abs(face.misfit(points)) for face in faces], axis=0)
    return float(away.max(initial=0.0))
