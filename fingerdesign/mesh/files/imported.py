"""A mesh made elsewhere (``mesh.mesher = "file"``): read by its names, checked, put on the design.

The file's tetrahedra, linear or quadratic, in mm and in the design's axes, carry the regions
"elastomer", "plate_0", ... and "core", and the boundaries "base" and "contact"; "side", "end" and
"symmetry" are found by their place where they have no names. A mesh of the half z >= 0 will do
where the finger and its scene mirror in z = 0.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from fingerdesign.arrays import IntArray
from fingerdesign.design.mesh import mesh_file_faults
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, MeshError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cells import TETRA_EDGES, facet_keys, quadratic, with_mid_nodes
from fingerdesign.mesh.files.checks import (
    check_faces,
    check_joined,
    check_outside,
    check_places,
    regions_of,
)
from fingerdesign.mesh.files.io import read_named
from fingerdesign.mesh.files.named import NamedMesh
from fingerdesign.mesh.make import Mesher, mesher
from fingerdesign.mesh.measures import cell_volumes, edge_lengths
from fingerdesign.mesh.sheets import FACES
from fingerdesign.mesh.tetra.boundary import BoundaryFacets, carried_facets
from fingerdesign.mesh.tetra.carriers import Carriers, carriers_of
from fingerdesign.mesh.tetra.snap import curve_facets, snap_to_carriers
from fingerdesign.mesh.types import Mesh, core_name

NEAR = 0.1  # of the mean edge: nodes this near to a CAD face are moved onto it
_HALF = 1e-6  # mm below z = 0 that rounding may put a half model's nodes


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


def imported_mesh(design: Design, symmetric: bool = True) -> Mesh:
    """Read ``design.mesh.file``, check it against the design, and make it quadratic.

    symmetric: whether half a finger will do (design and scene mirror in z = 0); a whole mesh is
    taken as it is. Nodes near to the design's faces are put on them, mid-nodes too (the notes count
    those that were not). DesignError where the file cannot be read; MeshError names what is
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
    slot_facets = np.vstack([np.zeros((0, 3), dtype=np.int64), *slots.values()])
    faces = carried_facets(places, corners, regions, carriers, slot_facets)
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
    """Outer facets (f, 3) by name: those of the file or, except for base and contact, by place."""
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
    Where that would turn a cell over, and of facets that lie farther off, all stays as it came."""
    edge = float(edge_lengths(mesh.points, faces.corners).mean())
    near = faces.misfit <= NEAR * edge
    near_faces = BoundaryFacets(**{key: values[near] for key, values in vars(faces).items()})
    notes: dict[str, float | int | str] = {"far_facets": int((~near).sum())}
    try:
        corners = near_faces.on_carriers(len(mesh.points), carriers)
        points = snap_to_carriers(mesh.points, corners, carriers)
        shift = points - mesh.points
        for k, (i, j) in enumerate(TETRA_EDGES):  # mid-nodes go along
            middle, (a, b) = mesh.cells[:, 4 + k], (mesh.cells[:, i], mesh.cells[:, j])
            points[middle] = mesh.points[middle] + 0.5 * (shift[a] + shift[b])
        whole = with_mid_nodes(mesh.cells, near_faces.corners)
        points, straightened = curve_facets(points, mesh.cells, carriers, whole, near_faces.carrier)
        if cell_volumes(points, mesh.corners).min() <= 0.0:
            raise MeshError("moved onto the design's faces, its cells would turn over")
    except MeshError as error:
        return replace(mesh, notes=notes | {"left_as_it_came": str(error)})
    notes["straightened_nodes"] = len(straightened)
    return replace(mesh, points=points, notes=notes)


def import_words(mesh: Mesh) -> list[str]:
    """Sentences for the user about a mesh that was read from a file."""
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
