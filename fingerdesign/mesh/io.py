"""Meshes to and from files, through meshio: .vtu, .msh, .vtk, .xdmf and what else it knows.

Cells carry "region" (0 elastomer, k + 1 plate k). Named facets are cells of one dimension less that
carry their name's number in "facet" (FACET_NUMBERS; FIRST_SLOT + 3 k and the next two for the faces
of plate k's slot; 0 for the cells inside). Gmsh files carry both as physical groups with names
instead.
"""

from __future__ import annotations

import os
import re
import secrets
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.errors import MeshError
from fingerdesign.mesh.sheets import FACES
from fingerdesign.mesh.types import Mesh

IntArray = NDArray[np.int64]

FACET_NUMBERS = {"base": 1, "contact": 2, "side": 3, "end": 4, "symmetry": 5}
FIRST_SLOT, LAST_SLOT = 1000, 4000
FIRST_REGION_GROUP = 100  # Gmsh's physical group of region r is 100 + r; a facet's is its number
CELL_TYPES = {2: ("triangle6", "line3"), 3: ("tetra10", "triangle6")}


def to_meshio(mesh: Mesh) -> Any:
    """A meshio.Mesh with the cells first, then the named facets; 2-D points get z = 0."""
    import meshio

    cell_type, facet_type = CELL_TYPES[mesh.dimension]
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.dimension] = mesh.points
    number_of = {name: _facet_number(name) for name in mesh.facets}
    names = sorted(number_of, key=lambda name: number_of[name])
    rows = [mesh.facets[name] for name in names]
    numbers = [np.full(len(mesh.facets[name]), number_of[name]) for name in names]
    facets = np.vstack(rows) if rows else np.zeros((0, 3 * (mesh.dimension - 1)), dtype=int)
    facet = np.concatenate([np.zeros(0, dtype=np.int64), *numbers]).astype(np.int64)
    cells = [(cell_type, mesh.cells)] + ([(facet_type, facets)] if len(facets) else [])
    region = [mesh.regions, np.zeros(len(facets), dtype=np.int64)]
    marked = [np.zeros(len(mesh.cells), dtype=np.int64), facet]
    physical = [FIRST_REGION_GROUP + mesh.regions, facet]
    dimension = mesh.dimension
    groups = {name: np.array([number_of[name], dimension - 1]) for name in names}
    for number in np.unique(mesh.regions):
        name = "elastomer" if number == 0 else f"plate_{number - 1}"
        groups[name] = np.array([FIRST_REGION_GROUP + number, dimension])
    data = {
        "region": region,
        "facet": marked,
        "gmsh:physical": physical,
        "gmsh:geometrical": physical,
    }
    return meshio.Mesh(
        points,
        cells,
        cell_data={
            name: [part.copy() for part in parts[: len(cells)]] for name, parts in data.items()
        },
        field_data=groups,
    )


def _facet_number(name: str) -> int:
    if name in FACET_NUMBERS:
        return FACET_NUMBERS[name]
    slot = re.fullmatch(rf"plate_([0-9]+)_({'|'.join(FACES)})", name)
    number = FIRST_SLOT + 3 * int(slot[1]) + FACES.index(slot[2]) if slot else LAST_SLOT
    if number >= LAST_SLOT:
        raise MeshError(f"facet name '{name}' has no number: not in FACET_NUMBERS, no slot's face")
    return number


def write_mesh(mesh: Mesh, path: Path | str) -> Path:
    """Write a mesh in the format that the file's ending names; written aside, then renamed."""
    import meshio

    path = Path(path)
    content = to_meshio(mesh)
    gmsh = path.suffix == ".msh"
    # Of a .msh file meshio reads back the groups, not further data of cells of two kinds.
    for name in ("region", "facet") if gmsh else ("gmsh:physical", "gmsh:geometrical"):
        del content.cell_data[name]
    if not gmsh:
        content.field_data = {}
    aside = path.with_name(f".{secrets.token_hex(4)}-{path.name}")
    try:
        # To meshio .msh is ANSYS's first, which has no quadratic cells; and MSH 4 wants entities.
        content.write(aside, file_format="gmsh22" if gmsh else None)
        os.replace(aside, path)
    except (meshio.WriteError, meshio.ReadError, KeyError, OSError, ImportError) as error:
        raise MeshError(f"meshio could not write {path}: {error}") from error
    finally:
        aside.unlink(missing_ok=True)
    return path


def read_mesh(path: Path | str) -> Mesh:
    """Read a mesh that ``write_mesh`` wrote, or any of quadratic triangles or tetrahedra.

    Regions and facet names come from "region" and "facet", or from Gmsh's physical groups; without
    them all is elastomer and no facet is named. MeshError where there are no quadratic cells.
    """
    import meshio

    path = Path(path)
    try:
        found = meshio.read(path)
    except (meshio.ReadError, OSError, KeyError, ValueError, ImportError) as error:
        raise MeshError(f"meshio could not read {path}: {error}") from error
    kinds = {block.type for block in found.cells}
    dimension = 3 if "tetra10" in kinds else 2
    cell_type, facet_type = CELL_TYPES[dimension]
    if cell_type not in kinds:
        raise MeshError(
            f"{path} holds no quadratic cells (tetra10 or triangle6) but {sorted(kinds)}"
        )
    cells, regions = _blocks(found, cell_type, "region", 0)
    facets, numbers = _blocks(found, facet_type, "facet", 0)
    if "region" not in found.cell_data and "gmsh:physical" in found.cell_data:
        _, regions = _blocks(found, cell_type, "gmsh:physical", FIRST_REGION_GROUP)
        _, numbers = _blocks(found, facet_type, "gmsh:physical", 0)
        regions = regions - FIRST_REGION_GROUP
    if regions.min() < 0:
        raise MeshError(f"{path} has cells in negative regions; 0 is the elastomer, k + 1 plate k")
    points = np.asarray(found.points, dtype=float)[:, :dimension]
    name_of = {number: name for name, number in FACET_NUMBERS.items()}
    slots = np.unique(numbers[(numbers >= FIRST_SLOT) & (numbers < LAST_SLOT)]) - FIRST_SLOT
    name_of |= {FIRST_SLOT + int(k): f"plate_{k // 3}_{FACES[k % 3]}" for k in slots}
    named = {
        name: facets[numbers == number]
        for number, name in name_of.items()
        if np.any(numbers == number)
    }
    return Mesh(points, cells, regions, named, f"file {path.name}", "symmetry" in named)


def _blocks(found: Any, kind: str, key: str, default: int) -> tuple[IntArray, IntArray]:
    """All cells of a type, and one integer datum of each."""
    width = {"tetra10": 10, "triangle6": 6, "line3": 3}[kind]
    rows: list[IntArray] = [np.zeros((0, width), dtype=np.int64)]
    values: list[IntArray] = [np.zeros(0, dtype=np.int64)]
    for number, block in enumerate(found.cells):
        if block.type != kind:
            continue
        rows.append(np.asarray(block.data, dtype=np.int64))
        data = found.cell_data.get(key)
        values.append(
            np.full(len(block.data), default, dtype=np.int64)
            if data is None
            else np.asarray(np.rint(data[number]), dtype=np.int64).reshape(-1)
        )
    return np.vstack(rows), np.concatenate(values)
