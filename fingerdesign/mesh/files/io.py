"""Meshes to and from files: .vtu, .msh (Gmsh), .vtk, .inp (CalculiX), and what else meshio knows.

Cells carry "region" (0 elastomer, k + 1 plate k, one more the core, which "core" = 1 marks too).
Named facets are cells of one dimension less that carry their name's number in "facet"
(FACET_NUMBERS; FIRST_SLOT + 3 k and the next two for the faces of plate k's slot; 0 for the cells
inside). Gmsh and CalculiX files carry both as groups and sets with names instead.
"""

import contextlib
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.cells import (
    FACETS,
    LINE,
    PRISM,
    SQUARE,
    TETRA,
    TRIANGLE,
    CellKind,
    facet_kind,
    tetrahedra_of,
    triangles_of,
)
from fingerdesign.mesh.files.calculix import write_calculix
from fingerdesign.mesh.files.calculix_read import read_calculix
from fingerdesign.mesh.files.named import NamedMesh, facet_name, facet_number, region_name
from fingerdesign.mesh.types import Mesh, in_tetrahedra
from fingerdesign.runtime.files import whole_file

Names = NDArray[np.object_]

FIRST_REGION_GROUP = 100  # Gmsh's physical group of region r is 100 + r; a facet's is its number


def to_meshio(mesh: Mesh, gmsh: bool = False) -> Any:
    """A meshio.Mesh with the cells first, then the named facets; 2-D points get z = 0.

    gmsh: with groups; meshio reads these back from a .msh file, not further data of two kinds of
    cells.
    """
    import meshio

    kind, dimension = mesh.kind, mesh.dimension
    number_of = {name: facet_number(name) for name in mesh.facets}
    names = sorted(number_of, key=lambda name: number_of[name])
    cells, facet = [(kind.quadratic, mesh.cells)], list[IntArray]()
    for each in FACETS.values():
        own = [name for name in names if facet_kind(mesh.facets[name]) is each]
        rows = np.vstack([np.zeros((0, each.nodes), int), *(mesh.facets[name] for name in own)])
        if len(rows):
            cells.append((each.quadratic, rows))
            counts = [len(mesh.facets[name]) for name in own]
            facet.append(np.repeat([number_of[name] for name in own], counts))
    nothing = [np.zeros(len(rows), dtype=np.int64) for rows in facet]
    groups: dict[str, IntArray] = {}
    if gmsh:
        physical = [FIRST_REGION_GROUP + mesh.regions, *facet]
        data = {"gmsh:physical": physical, "gmsh:geometrical": physical}
        groups = {name: np.array([number_of[name], dimension - 1]) for name in names}
        for number in np.unique(mesh.regions).tolist():
            groups[mesh.region_name(number)] = np.array([FIRST_REGION_GROUP + number, dimension])
    else:
        data = {
            "region": [mesh.regions, *nothing],
            "facet": [np.zeros(len(mesh.cells), dtype=np.int64), *facet],
        }
        for number, name in mesh.region_names.items():
            data[name] = [(mesh.regions == number).astype(np.int64), *nothing]
    return meshio.Mesh(mesh.in_space, cells, cell_data=data, field_data=groups)


def write_mesh(mesh: Mesh, path: Path | str) -> Path:
    """Write a mesh in the format that the file's ending names; written aside, then renamed."""
    path = Path(path)
    try:
        with whole_file(path) as aside:
            if path.suffix == ".inp":
                write_calculix(mesh, aside)
            else:
                _write_meshio(mesh, aside)
    except OSError as error:
        raise MeshError(f"{path} could not be written: {error}") from error
    return path


def _write_meshio(mesh: Mesh, path: Path) -> None:
    import meshio

    gmsh = path.suffix == ".msh"
    # Formats that hold prisms of 18 nodes; others get tetrahedra.
    prisms = path.suffix in (".vtu", ".vtk", ".msh")
    content = to_meshio(mesh if prisms else in_tetrahedra(mesh), gmsh)
    try:
        # To meshio .msh is ANSYS's first, which has no quadratic cells; and MSH 4 wants entities.
        content.write(path, file_format="gmsh22" if gmsh else None)
    except (meshio.WriteError, meshio.ReadError, KeyError, ImportError) as error:
        name = path.name.partition("-")[2]
        raise MeshError(f"meshio could not write {name}: {error}") from error


def read_named(path: Path | str) -> NamedMesh:
    """Read the triangles or tetrahedra of any file, linear or quadratic, with their names.

    Quadratic prisms are cut into tetrahedra. MeshError names what cannot be read: no such cells, of
    two orders, hexahedra among them.
    """
    path = Path(path)
    if path.suffix == ".inp":
        try:
            return read_calculix(path)
        except OSError as error:
            raise MeshError(f"{path} could not be read: {error}") from error
    found = _read_meshio(path)
    kind, cell_type, facet_types = _types(path, {block.type for block in found.cells})
    cells, names = list[IntArray](), list[Any]()
    for number, block in enumerate(found.cells):
        if block.type == cell_type and len(block.data):
            rows = np.asarray(block.data, dtype=np.int64)
            own = _names(found, number, kind.dimension, "region")
            cells.append(tetrahedra_of(rows) if kind is PRISM else rows)
            names.append(np.repeat(own, len(cells[-1]) // len(rows)))
    if not cells:
        raise MeshError(f"{path} holds no {cell_type} cells")
    facets = _facets(found, kind, facet_types)
    points = np.asarray(found.points, dtype=float)[:, : kind.dimension]
    used = np.concatenate([rows.ravel() for rows in (*cells, *facets.values())])
    if used.min() < 0 or used.max() >= len(points):
        raise MeshError(f"{path} has cells with nodes that it does not hold")
    return NamedMesh(points, np.vstack(cells), np.concatenate(names).astype(str), facets)


def _facets(found: Any, kind: CellKind, types: tuple[str, ...]) -> dict[str, IntArray]:
    """The named facets (f, dimension) of a meshio mesh, of these of its types; squares are cut."""
    facets: dict[str, list[IntArray]] = {}
    for number, block in enumerate(found.cells):
        if block.type in types and len(block.data):
            rows = np.asarray(block.data, dtype=np.int64)
            own = _names(found, number, kind.dimension - 1, "facet")
            if block.type == SQUARE.quadratic:
                rows, own = triangles_of(rows), np.repeat(own, 2)
            for name in np.unique(own[own != ""]).tolist():
                facets.setdefault(name, []).append(rows[own == name, : kind.dimension])
    return {name: np.vstack(rows) for name, rows in facets.items()}


def _read_meshio(path: Path) -> Any:
    import meshio

    try:
        silent = io.StringIO()  # it prints what formats it has tried
        with contextlib.redirect_stdout(silent), contextlib.redirect_stderr(silent):
            return meshio.read(path)
    except SystemExit as error:  # so it answers some files that it cannot read
        raise MeshError(f"meshio could not read {path}: not of its ending's format") from error
    except Exception as error:  # its readers raise any kind of error
        why = str(error).strip() or type(error).__name__
        raise MeshError(f"meshio could not read {path}: {why}") from error


def _types(path: Path, names: set[str]) -> tuple[CellKind, str, tuple[str, ...]]:
    """The kind of cells to read, the highest in the file, and meshio's types of cells and facets,
    of one order."""
    other = sorted(name for name in names if name.startswith(("hexa", "wedge", "pyramid")))
    if other == [PRISM.quadratic] and not any(name.startswith("tetra") for name in names):
        return PRISM, PRISM.quadratic, (TRIANGLE.quadratic, SQUARE.quadratic)
    if other:
        raise MeshError(f"{path} holds {', '.join(other)}: only tetrahedra can be read")
    for kind, facet in ((TETRA, TRIANGLE), (TRIANGLE, LINE)):
        if {kind.quadratic, kind.linear} <= names:
            orders = f"{kind.linear} and {kind.quadratic}"
            raise MeshError(f"{path} holds {orders}: cells must be of one order")
        if kind.quadratic in names:
            return kind, kind.quadratic, (facet.quadratic,)
        if kind.linear in names:
            return kind, kind.linear, (facet.linear,)
    raise MeshError(
        f"{path} holds no quadratic cells (tetra10 or triangle6) nor linear ones, but "
        f"{sorted(names)}"
    )


def _names(found: Any, number: int, level: int, key: str) -> Names:
    """The name (count,) of each cell of a meshio block, or "": by its numbers, its groups or sets.

    level: the cells' dimension; key: of the numbers that our own files hold, "region" or "facet".
    """
    data = {key: np.asarray(parts[number]) for key, parts in found.cell_data.items()}
    data = {key: values for key, values in data.items() if values.ndim == 1}
    names = np.full(len(found.cells[number].data), "", dtype=object)
    if "region" in data or "facet" in data:
        numbers = np.rint(data.get(key, np.zeros(len(names)))).astype(int)
        names = _named(numbers, facet_name if key == "facet" else region_name)
        if key == "region" and "core" in data:
            names[np.rint(data["core"]) == 1] = "core"
    elif "gmsh:physical" in data:
        for name, (group, dimension) in found.field_data.items():
            if int(dimension) == level:
                names[data["gmsh:physical"] == int(group)] = name
    for name, members in ({} if found.field_data else found.cell_sets).items():
        if number < len(members) and members[number] is not None and len(members[number]):
            names[np.asarray(members[number], dtype=int)] = name
    return names


def _named(values: IntArray, name_of: Callable[[int], str]) -> Names:
    unique, inverse = np.unique(values, return_inverse=True)
    return np.array([name_of(value) for value in unique.tolist()], dtype=object)[inverse]
