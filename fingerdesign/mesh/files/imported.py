"""A mesh made elsewhere (``mesh.mesher = "file"``): read by its names, checked, put on the design.

The file's tetrahedra, linear or quadratic, in mm and in the design's axes, carry the regions
"elastomer", "plate_0", ... and "core", and the boundaries "base" and "contact"; "side", "end" and
"symmetry" are found by their place where no name tells them. A mesh of the half z >= 0 will do
where the finger and its scene mirror in z = 0.
"""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.mesh import mesh_file_faults
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, MeshError
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.files.io import read_named
from fingerdesign.mesh.files.named import NamedMesh
from fingerdesign.mesh.make import Mesher, mesher
from fingerdesign.mesh.measures import (
    cell_volumes,
    curved_areas,
    edge_lengths,
    face_distances,
    least_jacobian_ratios,
    outer_areas,
    volumes_by_region,
)
from fingerdesign.mesh.sheets import FACES
from fingerdesign.mesh.tetra.boundary import BoundaryFacets, boundary_facets
from fingerdesign.mesh.tetra.carriers import Carriers, carriers_of, in_core, outer_faces
from fingerdesign.mesh.tetra.snap import curve_facets, snap_to_carriers
from fingerdesign.mesh.types import (
    TETRA_EDGES,
    TETRA_FACETS,
    Mesh,
    core_name,
    facet_keys,
    pieces,
    quadratic,
    same_keys,
    with_mid_nodes,
)

VOLUME_ERROR = 1e-2  # of body, plates, core: chords of a coarse mesh miss less
AREA_ERROR = 2e-2  # of base and contact
PLACED = 0.95  # of a part's volume that must lie where the design has that part


def used_nodes(found: NamedMesh) -> NamedMesh:
    """Without nodes that no cell has: their dofs would be free."""
    used, cells = np.unique(found.cells, return_inverse=True)
    number = np.full(len(found.points), -1)
    number[used] = np.arange(len(used))
    facets = {name: number[rows] for name, rows in found.facets.items()}
    for name, rows in facets.items():
        if len(rows) and rows.min() < 0:
            raise MeshError(f"facets of {name!r} have nodes that no cell has")
    return NamedMesh(found.points[used], cells.reshape(found.cells.shape), found.region, facets)


def oriented(found: NamedMesh, path: Path) -> NamedMesh:
    """Every cell positively oriented: those that are not are turned."""
    if found.dimension != 3:
        raise MeshError(f"{path.name} holds triangles in the plane, no tetrahedra")
    if not np.isfinite(found.points).all():
        raise MeshError(f"{path.name} has nodes that are not finite")
    volumes = cell_volumes(found.points, found.cells[:, :4])
    apart = len(np.unique(np.round(found.points, 7), axis=0))
    if apart < len(found.points):
        raise MeshError(
            f"{path.name} has {len(found.points) - apart} nodes where another one lies: its parts "
            "are not joined (in Gmsh: fragment the volumes before meshing)"
        )
    flat = np.abs(volumes) <= 1e-12 * np.abs(volumes).max()
    if flat.any():
        raise MeshError(f"{path.name} has {int(flat.sum())} tetrahedra without a volume")
    turned = [0, 2, 1, 3, *([6, 5, 4, 7, 9, 8] if found.quadratic else [])]
    cells = np.where((volumes < 0.0)[:, None], found.cells[:, turned], found.cells)
    return replace(found, cells=cells)


def regions_of(found: NamedMesh, design: Design, path: Path) -> IntArray:
    """The number of each cell's region. MeshError where names are missing or unknown."""
    wanted = {"elastomer": 0}
    if design.plates.model == "solid":
        wanted |= {f"plate_{k}": k + 1 for k in range(design.plates.number)}
    if design.body.core is not None:
        wanted["core"] = design.core_region
    lower = np.char.lower(found.region)
    names = set(np.unique(lower).tolist())
    said = ", ".join(sorted(names - {""})) or "none"
    if "" in names:
        raise MeshError(
            f"{path.name} has {int((lower == '').sum())} cells in no named region (named: {said}); "
            f"name regions {_listed(wanted)} (in Gmsh: physical volumes)"
        )
    if names != set(wanted):
        lack, strange = sorted(set(wanted) - names), sorted(names - set(wanted))
        parts = [f"lacks {_listed(lack)}"] if lack else []
        parts += [f"has {_listed(strange)}, which the design has not"] if strange else []
        raise MeshError(
            f"of the regions that {design.design.name} needs, {path.name} {' and '.join(parts)} "
            f"(found: {said})"
        )
    order, inverse = np.unique(lower, return_inverse=True)
    return np.array([wanted[str(name)] for name in order])[inverse.reshape(-1)].astype(np.int64)


def _listed(names: Iterable[str]) -> str:
    every = list(names)
    return ", ".join(every if len(every) < 8 else [*every[:3], "...", every[-1]])


def check_places(mesh: Mesh, design: Design, path: Path) -> None:
    """MeshError unless volumes are the design's, and plates and core lie where it has them."""
    fit = volumes_by_region(mesh, design)
    whole = sum(row["volume"] for row in fit.regions.values())
    wanted = sum(row["wanted"] for row in fit.regions.values())
    wrong = [
        f"{name} {row['volume']:.6g} of {row['wanted']:.6g} mm^3"
        for name, row in fit.regions.items()
        if not row["error"] <= VOLUME_ERROR
    ]
    if wrong or not fit.body_error <= VOLUME_ERROR:
        parts = wrong or [f"the body {whole:.6g} of {wanted:.6g} mm^3"]
        raise MeshError(
            f"{path.name} is not {design.design.name} (more than {VOLUME_ERROR:.0%} off): "
            + "; ".join(parts[:4])
            + "; is it in mm, and of this design?"
        )
    volumes = cell_volumes(mesh.points, mesh.corners)
    centroids = mesh.points[mesh.corners].mean(axis=1)
    for region in np.unique(mesh.regions[mesh.regions > 0]).tolist():
        own = mesh.regions == region
        if region == design.core_region and design.body.core is not None:
            inside = in_core(design.body, centroids[own])
        else:
            inside = plate_frames(design)[region - 1].holds(centroids[own])
        share = float(volumes[own][inside].sum() / volumes[own].sum())
        if share < PLACED:
            raise MeshError(
                f"only {share:.0%} of {mesh.region_name(region)} in {path.name} lie where "
                f"{design.design.name} has it: place, angle or number is another"
            )


def check_faces(mesh: Mesh, design: Design, path: Path) -> None:
    """MeshError where base or contact is not the design's, by place and area, or a cell folds."""
    away = face_distances(mesh, design)
    most = VOLUME_ERROR * crest_height(design.body)
    for name in ("base", "contact"):
        if not away[name] <= most:
            raise MeshError(
                f"nodes of {name!r} in {path.name} lie up to {away[name]:.3g} mm off the design's "
                f"(more than {most:.2g} mm)"
            )
    _check_areas(mesh, design, path)
    folded = int((least_jacobian_ratios(mesh.points, mesh.cells) <= 0.0).sum())
    if folded:
        raise MeshError(f"{folded} quadratic tetrahedra of {path.name} fold over")


def _check_areas(mesh: Mesh, design: Design, path: Path) -> None:
    wanted = outer_areas(mesh, design)
    faces = outer_faces(design.body, mesh.symmetric)
    for name in ("base", "contact"):
        area = float(curved_areas(mesh.points, mesh.facets[name]).sum())
        allowed = AREA_ERROR * wanted[name]
        if any(name in (joined := face.boundaries) and len(joined) > 1 for face in faces):
            # No edge tells where it ends: a row of facets at its border may be the neighbour's.
            edge = float(edge_lengths(mesh.points, mesh.facets[name][:, :3]).max())
            allowed += edge * 2.0 * (design.body.width_mm + design.body.depth_mm)
            allowed = min(allowed, 0.5 * wanted[name])
        if not abs(area - wanted[name]) <= allowed:
            raise MeshError(
                f"{name!r} in {path.name} has {area:.6g} mm^2 where {design.design.name} has "
                f"{wanted[name]:.6g} mm^2{' (its half)' if mesh.symmetric else ''}: facets of it "
                "lack that name, or others have it"
            )


# Whether a mesh made elsewhere is one whole: joined facet to facet, no cracks, no cavities.

OFF = 0.3  # of a facet's longest edge: outside facets farther off the design's faces are cracks
OFF_HEIGHT = 1e-2  # of the finger's height, besides


def check_joined(points: Array, corners: IntArray, path: Path) -> None:
    """MeshError where cells (c, 4) overlap (three at a facet), or are not all joined by facets."""
    keys = facet_keys(corners[:, np.array(TETRA_FACETS)].reshape(-1, 3), len(points))
    cells = np.repeat(np.arange(len(corners)), 4)
    first, second = same_keys(keys)
    thrice = first[np.isin(second, first)]
    if len(thrice):
        owners = np.unique(cells[thrice])
        raise MeshError(
            f"{path.name} has {len(np.unique(keys[thrice]))} facets that more than two tetrahedra "
            f"share {_where(points[corners[owners]].mean(axis=1))}: cells overlap or are double"
        )
    count, piece = pieces(cells[first], cells[second], len(corners))
    if count > 1:
        size = np.bincount(piece)
        away = piece != size.argmax()
        raise MeshError(
            f"{path.name} falls into {count} pieces that share no facet; {int(away.sum())} of "
            f"{len(piece)} tetrahedra are not joined to the rest "
            f"{_where(points[corners[away]].mean(axis=1))} (in Gmsh: fragment the volumes, so "
            "that they share their surfaces)"
        )


def check_outside(points: Array, faces: BoundaryFacets, design: Design, path: Path) -> None:
    """MeshError where the mesh's outside runs inside the body: a crack, or cells that lack."""
    corners = faces.corners[faces.outside]
    places = points[corners]
    edge = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).max(axis=1)
    off = faces.misfit[faces.outside]
    far = off > OFF * edge + OFF_HEIGHT * crest_height(design.body)
    if far.any():
        raise MeshError(
            f"{int(far.sum())} facets on the outside of {path.name} lie up to "
            f"{off[far].max():.3g} mm off the faces of {design.design.name} "
            f"{_where(places[far].mean(axis=1))}: the mesh is torn, or cells lack"
        )
    if design.body.shape == "step":  # its solid may have voids
        return
    sides = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    _, edges = np.unique(sides[:, 0] * len(points) + sides[:, 1], return_inverse=True)
    owner = np.repeat(np.arange(len(corners)), 3)
    first, second = same_keys(edges.reshape(-1))
    count, piece = pieces(owner[first], owner[second], len(corners))
    if count > 1:
        inner = piece != np.bincount(piece).argmax()
        raise MeshError(
            f"the outside of {path.name} has {count} surfaces, where that of {design.design.name} "
            f"has one: {int(inner.sum())} facets bound a cavity or crack "
            f"{_where(places[inner].mean(axis=1))}"
        )


def _where(middles: Array) -> str:
    x, y, z = middles[0]
    return f"(near x = {x:.4g}, y = {y:.4g}, z = {z:.4g})"


NEAR = 0.1  # of the mean edge: nodes this near to a CAD face are put on it
_HALF = 1e-6  # mm below z = 0 that rounding may put a half model's nodes


def imported_mesh(design: Design, symmetric: bool = True) -> Mesh:
    """Read ``design.mesh.file``, check it against the design, and make it quadratic.

    symmetric: whether half a finger will do (design and scene mirror in z = 0); a whole mesh is
    taken as it is. Nodes near to the design's faces are put on them, mid-nodes too (the notes count
    those that were not). DesignError where the file cannot be read; MeshError says in words what is
    wrong with its names, cells, joints, volumes, areas or places.
    """
    faults = mesh_file_faults(design.mesh)
    if faults or design.mesh.file is None:
        raise DesignError(faults, design.design.name)
    path = Path(design.mesh.file)
    found = oriented(used_nodes(read_named(path)), path)
    regions = regions_of(found, design, path)
    half = bool(found.points[:, 2].min() > -_HALF)
    if half and not symmetric:
        raise MeshError(
            f"{path.name} holds the half z >= 0, but the finger or its scene does not mirror in "
            "z = 0; mesh the whole finger"
        )
    frames = plate_frames(design) if design.plates.model == "solid" else ()
    carriers = carriers_of(design, frames, half)
    corners, places = found.cells[:, :4], found.points
    check_joined(places, corners, path)
    slots = _slots(found, design, path)
    besides = np.vstack([np.zeros((0, 3), dtype=np.int64), *slots.values()])
    faces = boundary_facets(places, corners, regions, carriers, besides)
    named = _named_facets(found, faces, path) | slots
    nodes = (places, found.cells) if found.quadratic else quadratic(places, found.cells)
    mesh = Mesh(*nodes, regions, {}, "file", half, region_names=core_name(design))
    check_places(mesh, design, path)
    check_outside(places, faces, design, path)
    mesh = _fitted(mesh, faces, carriers)
    facets = {name: with_mid_nodes(mesh.cells, rows, name) for name, rows in named.items()}
    mesh = replace(mesh, facets=facets, notes=mesh.notes | {"file": path.name})
    check_faces(mesh, design, path)
    return mesh


def _slots(found: NamedMesh, design: Design, path: Path) -> dict[str, IntArray]:
    """Facets (f, 3) of the slots of plates that are sheets, by name. MeshError where one lacks."""
    if design.plates.model != "sheet":
        return {}
    given = {name.lower(): rows for name, rows in found.facets.items()}
    names = [f"plate_{k}_{face}" for k in range(design.plates.number) for face in FACES]
    lacking = [name for name in names if name not in given]
    if lacking:
        raise MeshError(
            f"{path.name} has no boundary named {lacking[0]!r} ({len(lacking)} of {len(names)} "
            "lack): plates as sheets are slots whose upper, lower and end faces have names; or set "
            "plates.model = 'solid'"
        )
    return {name: given[name] for name in names}


def _named_facets(found: NamedMesh, faces: BoundaryFacets, path: Path) -> dict[str, IntArray]:
    """Outer facets (f, 3) by name: base and contact as the file says; the others as it says or, of
    facets that it does not name, by their place."""
    given = {name.lower(): rows for name, rows in found.facets.items()}
    for name in ("base", "contact"):
        if name not in given or not len(given[name]):
            raise MeshError(
                f"{path.name} has no boundary named {name!r} (found: "
                f"{', '.join(sorted(given)) or 'none'}); name the triangles of the fixed base "
                "'base' and those of the contact surface 'contact' (in Gmsh: physical surfaces)"
            )
    outer = faces.corners[faces.outside]
    nodes = len(found.points)
    keys, taken = facet_keys(outer, nodes), np.zeros(len(outer), dtype=bool)
    named = {}
    for name in ("base", "contact", "side", "end", "symmetry"):
        rows = given.get(name)
        if rows is None:
            continue
        own = np.isin(keys, facet_keys(rows, nodes))
        if own.sum() != len(np.unique(facet_keys(rows, nodes))):
            raise MeshError(f"{path.name}: facets of {name!r} do not lie on the mesh's outside")
        if (own & taken).any():
            raise MeshError(f"{path.name}: facets of {name!r} belong to another boundary too")
        taken |= own
        named[name] = outer[own]
    place = faces.name[faces.outside]
    for name in ("side", "end", "symmetry"):
        own = ~taken & (place == name)
        if name not in given and own.any():
            named[name] = outer[own]
    return named


def _fitted(mesh: Mesh, faces: BoundaryFacets, carriers: Carriers) -> Mesh:
    """Corners near to the design's faces moved onto them, mid-nodes straight or on curved faces.

    Where that would turn a cell over, and of facets that lie farther off, all stays as it came.
    """
    edge = float(edge_lengths(mesh.points, faces.corners).mean())
    near = faces.misfit <= NEAR * edge
    kept = BoundaryFacets(**{key: values[near] for key, values in vars(faces).items()})
    notes: dict[str, float | int | str] = {"far_facets": int((~near).sum())}
    try:
        corners = kept.on_carriers(len(mesh.points), carriers)
        points = snap_to_carriers(mesh.points, corners, carriers)
        shift = points - mesh.points
        for k, (i, j) in enumerate(TETRA_EDGES):  # mid-nodes go along
            middle, (a, b) = mesh.cells[:, 4 + k], (mesh.cells[:, i], mesh.cells[:, j])
            points[middle] = mesh.points[middle] + 0.5 * (shift[a] + shift[b])
        whole = with_mid_nodes(mesh.cells, kept.corners)
        points, straightened = curve_facets(points, mesh.cells, carriers, whole, kept.carrier)
        if cell_volumes(points, mesh.corners).min() <= 0.0:
            raise MeshError("moved onto the design's faces, its cells would turn over")
    except MeshError as error:
        return replace(mesh, notes=notes | {"left_as_it_came": str(error)})
    notes["straightened_nodes"] = len(straightened)
    return replace(mesh, points=points, notes=notes)


def import_words(mesh: Mesh) -> list[str]:
    """What became of a mesh that was read from a file, in sentences for its user."""
    if mesh.mesher != "file":
        return []
    name, far = mesh.notes.get("file", "the file"), mesh.notes.get("far_facets", 0)
    found = [f"the mesh was read from {name}, its nodes put on the design's faces"]
    if "left_as_it_came" in mesh.notes:
        found = [f"the mesh of {name} is as it came: {mesh.notes['left_as_it_came']}"]
    elif far:
        found.append(f"{far} of its facets lie too far off the design's faces and stayed there")
    if mesh.notes.get("straightened_nodes", 0):
        count = mesh.notes["straightened_nodes"]
        found.append(f"{count} mid-nodes stayed straight, or their cells would fold")
    return found


@mesher("file", place=3)
class MeshFile(Mesher):
    """A mesh made elsewhere."""

    elements_from = "the mesh's file"

    def make(self, design: Design, own: None, zone: Zone, symmetric: bool) -> Mesh:
        return imported_mesh(design, symmetric)
