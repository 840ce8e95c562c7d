"""A mesh made elsewhere (``mesh.mesher = "file"``): read by its names, checked, put on the design.

The file's tetrahedra, linear or quadratic, in mm and in the design's axes, carry the regions
"elastomer", "plate_0", ... and "core", and the boundaries "base" and "contact"; "side", "end" and
"symmetry" are found by their place where no name tells them. A mesh of the half z >= 0 will do
where the finger and its scene mirror in z = 0.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.layout import plate_frames
from fingerdesign.design.meshing import mesh_file_faults
from fingerdesign.errors import DesignError, MeshError
from fingerdesign.mesh.boundary import BoundaryFacets, boundary_facets
from fingerdesign.mesh.carriers import Carriers, carriers_of
from fingerdesign.mesh.import_checks import (
    check_faces,
    check_places,
    oriented,
    regions_of,
    used_nodes,
)
from fingerdesign.mesh.import_topology import check_joined, check_outside
from fingerdesign.mesh.io import read_named
from fingerdesign.mesh.measures import cell_volumes, edge_lengths
from fingerdesign.mesh.named import NamedMesh, with_mid_nodes
from fingerdesign.mesh.sheets import FACES
from fingerdesign.mesh.snap import curve_facets, quadratic_facets, snap_to_carriers
from fingerdesign.mesh.types import TETRA_EDGES, Mesh, quadratic

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


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
    named = _named_facets(found, faces, path)
    mesh = Mesh(*_nodes(found), regions, {}, "file", half)
    if design.body.core is not None:
        mesh = replace(mesh, region_names={design.core_region: "core"})
    check_places(mesh, design, path)
    check_outside(places, faces, design, path)
    mesh = _fitted(mesh, faces, carriers)
    facets = {name: with_mid_nodes(mesh.cells, rows, name) for name, rows in named.items()}
    facets |= {name: with_mid_nodes(mesh.cells, rows, name) for name, rows in slots.items()}
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
    keys, taken = _keys(outer, nodes), np.zeros(len(outer), dtype=bool)
    named = {}
    for name in ("base", "contact", "side", "end", "symmetry"):
        rows = given.get(name)
        if rows is None:
            continue
        own = np.isin(keys, _keys(rows, nodes))
        if own.sum() != len(np.unique(_keys(rows, nodes))):
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


def _keys(facets: IntArray, nodes: int) -> IntArray:
    a, b, c = np.sort(facets[:, :3], axis=1).astype(np.int64).T
    return np.asarray((a * nodes + b) * nodes + c)


def _nodes(found: NamedMesh) -> tuple[Array, IntArray]:
    if found.quadratic:
        return found.points, found.cells
    return quadratic(found.points, found.cells)


def _fitted(mesh: Mesh, faces: BoundaryFacets, carriers: Carriers) -> Mesh:
    """Corners near to the design's faces moved onto them, mid-nodes straight or on curved faces.

    Where that would turn a cell over, and of facets that lie farther off, all stays as it came.
    """
    edge = float(edge_lengths(mesh.points, faces.corners).mean())
    near = faces.misfit <= NEAR * edge
    kept = BoundaryFacets(
        faces.corners[near],
        faces.carrier[near],
        faces.outside[near],
        faces.cell[near],
        faces.name[near],
        faces.misfit[near],
    )
    far = int((~near).sum())
    try:
        corners = kept.on_carriers(len(mesh.points), carriers)
        points = snap_to_carriers(mesh.points, corners, carriers)
        shift = points - mesh.points
        for k, (i, j) in enumerate(TETRA_EDGES):  # mid-nodes go along
            middle, (a, b) = mesh.cells[:, 4 + k], (mesh.cells[:, i], mesh.cells[:, j])
            points[middle] = mesh.points[middle] + 0.5 * (shift[a] + shift[b])
        whole = quadratic_facets(mesh.cells, kept.corners, len(points))
        curved = curve_facets(points, mesh.cells, carriers, whole, kept.carrier)
        turned = cell_volumes(curved.points, mesh.corners).min() <= 0.0
    except MeshError as error:
        return replace(mesh, notes={"left_as_it_came": str(error), "far_facets": far})
    if turned:
        why = "moved onto the design's faces, its cells would turn over"
        return replace(mesh, notes={"left_as_it_came": why, "far_facets": far})
    return replace(
        mesh,
        points=curved.points,
        notes={"far_facets": far, "straightened_nodes": len(curved.straightened)},
    )


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
