"""Meshes to and from files: .vtu, .msh (Gmsh), .vtk, .inp (CalculiX), .xdmf, and what else meshio
knows.

Cells carry "region" (0 elastomer, k + 1 plate k, one more the core, which "core" = 1 marks too).
Named facets are cells of one dimension less that carry their name's number in "facet"
(FACET_NUMBERS; FIRST_SLOT + 3 k and the next two for the faces of plate k's slot; 0 for the cells
inside). Gmsh and CalculiX files carry both as groups and sets with names instead.
"""

from __future__ import annotations

import contextlib
import io
import os
import secrets
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.errors import MeshError
from fingerdesign.mesh.blocks import CELL_TYPES, named_of_blocks
from fingerdesign.mesh.calculix import write_calculix
from fingerdesign.mesh.calculix_reader import read_calculix
from fingerdesign.mesh.named import NamedMesh, facet_number, to_mesh
from fingerdesign.mesh.types import Mesh
from fingerdesign.mesh.xdmf import read_xdmf, write_xdmf

FIRST_REGION_GROUP = 100  # Gmsh's physical group of region r is 100 + r; a facet's is its number


def to_meshio(mesh: Mesh) -> Any:
    """A meshio.Mesh with the cells first, then the named facets; 2-D points get z = 0."""
    import meshio

    cell_type, facet_type = CELL_TYPES[mesh.dimension]
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.dimension] = mesh.points
    number_of = {name: facet_number(name) for name in mesh.facets}
    names = sorted(number_of, key=lambda name: number_of[name])
    rows = [mesh.facets[name] for name in names]
    numbers = [np.full(len(mesh.facets[name]), number_of[name]) for name in names]
    facets = np.vstack(rows) if rows else np.zeros((0, 3 * (mesh.dimension - 1)), dtype=int)
    facet = np.concatenate([np.zeros(0, dtype=np.int64), *numbers]).astype(np.int64)
    cells = [(cell_type, mesh.cells)] + ([(facet_type, facets)] if len(facets) else [])
    nothing, dimension = np.zeros(len(facets), dtype=np.int64), mesh.dimension
    physical = [FIRST_REGION_GROUP + mesh.regions, facet]
    data = {
        "region": [mesh.regions, nothing],
        "facet": [np.zeros(len(mesh.cells), dtype=np.int64), facet],
        "gmsh:physical": physical,
        "gmsh:geometrical": physical,
    }
    for number, name in mesh.region_names.items():
        data[name] = [(mesh.regions == number).astype(np.int64), nothing]
    groups = {name: np.array([number_of[name], dimension - 1]) for name in names}
    for number in np.unique(mesh.regions).tolist():
        groups[mesh.region_name(number)] = np.array([FIRST_REGION_GROUP + number, dimension])
    return meshio.Mesh(
        points,
        cells,
        cell_data={
            name: [part.copy() for part in parts[: len(cells)]] for name, parts in data.items()
        },
        field_data=groups,
    )


def write_mesh(mesh: Mesh, path: Path | str) -> Path:
    """Write a mesh in the format that the file's ending names; written aside, then renamed."""
    path = Path(path)
    aside = path.with_name(f".{secrets.token_hex(4)}-{path.name}")
    try:
        if path.suffix == ".inp":
            write_calculix(mesh, aside)
        elif path.suffix == ".xdmf":
            _write_xdmf(mesh, aside)
        else:
            _write_meshio(mesh, aside)
        os.replace(aside, path)
    except OSError as error:
        raise MeshError(f"{path} could not be written: {error}") from error
    finally:
        aside.unlink(missing_ok=True)
    return path


def _write_meshio(mesh: Mesh, path: Path) -> None:
    import meshio

    content = to_meshio(mesh)
    gmsh = path.suffix == ".msh"
    # Of a .msh file meshio reads back the groups, not further data of cells of two kinds.
    groups = ("gmsh:physical", "gmsh:geometrical")
    for name in list(content.cell_data):
        if (name in groups) != gmsh:
            del content.cell_data[name]
    if not gmsh:
        content.field_data = {}
    try:
        # To meshio .msh is ANSYS's first, which has no quadratic cells; and MSH 4 wants entities.
        content.write(path, file_format="gmsh22" if gmsh else None)
    except (meshio.WriteError, meshio.ReadError, KeyError, ImportError) as error:
        name = path.name.partition("-")[2]
        raise MeshError(f"meshio could not write {name}: {error}") from error


def _write_xdmf(mesh: Mesh, path: Path) -> None:
    content = to_meshio(mesh)
    names = {f"facet {facet_number(name)}": name for name in mesh.facets}
    for number in np.unique(mesh.regions).tolist():
        names[f"region {number}"] = mesh.region_name(number)
    data = {
        name: np.concatenate(parts)
        for name, parts in content.cell_data.items()
        if not name.startswith("gmsh:")
    }
    blocks = [(block.type, block.data) for block in content.cells]
    write_xdmf(path, content.points, blocks, data, names)


def read_mesh(path: Path | str) -> Mesh:
    """Read a mesh that ``write_mesh`` wrote, or any of quadratic triangles or tetrahedra.

    Regions and facet names come from "region" and "facet", or from groups and sets with names;
    without them all is elastomer and no facet is named. MeshError where there are no quadratic
    cells.
    """
    path = Path(path)
    found = read_named(path)
    if not found.quadratic:
        kind = "tetra" if found.dimension == 3 else "triangle"
        raise MeshError(f"{path} holds no quadratic cells (tetra10 or triangle6) but {kind}")
    return to_mesh(found, f"file {path.name}")


def read_named(path: Path | str) -> NamedMesh:
    """Read the triangles or tetrahedra of any file, linear or quadratic, with their names.

    MeshError names what cannot be read: no such cells, of two orders, hexahedra among them.
    """
    path = Path(path)
    if path.suffix == ".inp":
        try:
            return read_calculix(path)
        except OSError as error:
            raise MeshError(f"{path} could not be read: {error}") from error
    if path.suffix == ".xdmf":
        points, blocks, data = read_xdmf(path)
        return named_of_blocks(path, points, blocks, data, {}, {})
    import meshio

    try:
        said = io.StringIO()  # it prints what formats it has tried
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            found = meshio.read(path)
    except SystemExit as error:  # so it answers some files that it cannot read
        raise MeshError(f"meshio could not read {path}: not what its ending says") from error
    except Exception as error:  # its readers raise whatever the file's content leads them to
        why = str(error).strip() or type(error).__name__
        raise MeshError(f"meshio could not read {path}: {why}") from error
    blocks = [(block.type, np.asarray(block.data, dtype=np.int64)) for block in found.cells]
    data = {
        name: [np.asarray(part) for part in parts]
        for name, parts in found.cell_data.items()
        if all(np.ndim(part) == 1 for part in parts)
    }
    sets = {} if found.field_data else dict(found.cell_sets)
    return named_of_blocks(
        path, np.asarray(found.points, dtype=float), blocks, data, found.field_data, sets
    )
