"""From blocks of cells, as most file formats hold them, to a mesh with names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.named import NamedMesh, facet_name

CELL_TYPES = {2: ("triangle6", "line3"), 3: ("tetra10", "triangle6")}
LINEAR = {"tetra10": "tetra", "triangle6": "triangle", "line3": "line"}


def named_of_blocks(
    path: Path,
    points: Any,
    blocks: list[tuple[str, IntArray]],
    data: dict[str, list[IntArray]],
    groups: dict[str, Any],
    sets: dict[str, Any],
) -> NamedMesh:
    """The triangles or tetrahedra among blocks (type, (c, nodes)), with their names.

    data: numbers by cell, block by block ("region", "facet", "core", or "gmsh:physical"); groups:
    name -> (number, dimension) of Gmsh's; sets: name -> cells of each block. MeshError where there
    are no such cells, of two orders, or hexahedra among them.
    """
    kinds = {kind for kind, _ in blocks}
    cell_type, facet_type = _types(path, kinds)
    dimension = 3 if cell_type.startswith("tetra") else 2
    cells, names = list[IntArray](), list[Any]()
    facets: dict[str, list[IntArray]] = {}
    for number, (kind, rows) in enumerate(blocks):
        if kind not in (cell_type, facet_type) or not len(rows):
            continue
        inner = kind == cell_type
        own = _names_of_block(number, len(rows), inner, data, groups, sets, dimension)
        if inner:
            cells.append(rows)
            names.append(own)
        else:
            for name in np.unique(own[own != ""]).tolist():
                facets.setdefault(name, []).append(rows[own == name, :dimension])
    if not cells:
        raise MeshError(f"{path} holds no {cell_type} cells")
    every = [*cells, *(rows for parts in facets.values() for rows in parts)]
    if min(rows.min() for rows in every) < 0 or max(rows.max() for rows in every) >= len(points):
        raise MeshError(f"{path} has cells with nodes that it does not hold")
    return NamedMesh(
        points[:, :dimension],
        np.vstack(cells),
        np.concatenate(names).astype(str),
        {name: np.vstack(rows) for name, rows in facets.items()},
    )


def _types(path: Path, kinds: set[str]) -> tuple[str, str]:
    """The types of cells and facets to read: of the highest dimension, of one order."""
    other = sorted(kind for kind in kinds if kind.startswith(("hexa", "wedge", "pyramid")))
    if other:
        raise MeshError(f"{path} holds {', '.join(other)}: only tetrahedra can be read")
    for dimension in (3, 2):
        cell, facet = CELL_TYPES[dimension]
        if {cell, LINEAR[cell]} <= kinds:
            raise MeshError(f"{path} holds {LINEAR[cell]} and {cell}: cells of one order, please")
        if cell in kinds:
            return cell, facet
        if LINEAR[cell] in kinds:
            return LINEAR[cell], LINEAR[facet]
    raise MeshError(
        f"{path} holds no quadratic cells (tetra10 or triangle6) nor linear ones, but "
        f"{sorted(kinds)}"
    )


def _names_of_block(
    number: int,
    count: int,
    inner: bool,
    data: dict[str, list[IntArray]],
    groups: dict[str, Any],
    sets: dict[str, Any],
    dimension: int,
) -> NDArray[np.object_]:
    """The name (count,) of each cell of a block, or "": by its numbers, its groups or sets."""
    found = np.full(count, "", dtype=object)
    if "region" in data or "facet" in data:
        key = "region" if inner else "facet"
        values = np.rint(data[key][number]).astype(int) if key in data else np.zeros(count, int)
        if inner and values.min(initial=0) < 0:
            raise MeshError("there are cells in negative regions; 0 is the elastomer")
        for value in np.unique(values).tolist():
            if inner:
                found[values == value] = "elastomer" if value == 0 else f"plate_{value - 1}"
            else:
                found[values == value] = facet_name(value)
        if inner and "core" in data:
            found[np.rint(data["core"][number]) == 1] = "core"
    elif "gmsh:physical" in data and groups:
        values = np.asarray(data["gmsh:physical"][number])
        level = dimension if inner else dimension - 1
        for name, (group, of_dimension) in groups.items():
            if int(of_dimension) == level:
                found[values == int(group)] = name
    for name, members in sets.items():
        own = members[number] if number < len(members) else None
        if own is not None and len(own):
            found[np.asarray(own, dtype=int)] = name
    return found
