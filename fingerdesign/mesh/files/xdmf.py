"""Meshes as XDMF 3 with their numbers in the XML itself: one file, no HDF5.

Cells first, then the named facets, as one mixed topology; cell data as in the other formats.
A comment says which number of "facet" and "region" has which name.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError

# XDMF's numbers of cell types, and their nodes (xdmf.org, "XDMF Model and Format": Topology).
TYPES = {"triangle": (4, 3), "tetra": (6, 4)}
TYPES |= {"line3": (34, 3), "triangle6": (36, 6), "tetra10": (38, 10)}
_UNIFORM = {"triangle": "Triangle", "tetra": "Tetrahedron"}
_UNIFORM |= {"line3": "Edge_3", "triangle6": "Triangle_6", "tetra10": "Tetrahedron_10"}


def write_xdmf(
    path: Path,
    points: Array,
    blocks: list[tuple[str, IntArray]],
    data: dict[str, IntArray],
    names: dict[str, str],
) -> None:
    """Write points (n, 3), blocks of cells (type, (c, nodes)) and whole-number cell data (all c,).

    names: what the numbers of the data mean, by "facet 2" or "region 0".
    """
    root = ElementTree.Element("Xdmf", Version="3.0")
    domain = ElementTree.SubElement(root, "Domain")
    grid = ElementTree.SubElement(domain, "Grid", Name="finger", GridType="Uniform")
    # An Information element would be the place, but meshio refuses those that are not its own.
    grid.append(ElementTree.Comment(", ".join(f"{key}: {name}" for key, name in names.items())))
    geometry = ElementTree.SubElement(grid, "Geometry", GeometryType="XYZ")
    text = "\n".join(f"{x!r} {y!r} {z!r}" for x, y, z in points.tolist())
    _item(geometry, f"{len(points)} 3", "Float", text)
    rows = [np.insert(cells, 0, TYPES[kind][0], axis=1) for kind, cells in blocks]
    count = sum(len(cells) for _, cells in blocks)
    topology = ElementTree.SubElement(
        grid, "Topology", TopologyType="Mixed", NumberOfElements=str(count)
    )
    lines = (" ".join(map(str, row)) for part in rows for row in part.tolist())
    _item(topology, str(sum(part.size for part in rows)), "Int", "\n".join(lines))
    for key, values in data.items():
        attribute = ElementTree.SubElement(
            grid, "Attribute", Name=key, AttributeType="Scalar", Center="Cell"
        )
        _item(attribute, str(len(values)), "Int", " ".join(map(str, values.tolist())))
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _item(parent: ElementTree.Element, dimensions: str, number: str, text: str) -> None:
    item = ElementTree.SubElement(
        parent,
        "DataItem",
        Dimensions=dimensions,
        NumberType=number,
        Precision="8",
        Format="XML",
    )
    item.text = "\n" + text + "\n"


def read_xdmf(
    path: Path,
) -> tuple[Array, list[tuple[str, IntArray]], dict[str, list[IntArray]]]:
    """Points (n, 3), blocks of cells of one type each, and cell data by name and block.

    MeshError where the file is no XDMF of one grid, or keeps its numbers in other files (HDF5).
    """
    try:
        grid = ElementTree.parse(path).getroot().find("Domain/Grid")
        if grid is None:
            raise ValueError("there is no grid")
        geometry, topology = grid.find("Geometry"), grid.find("Topology")
        if geometry is None or topology is None:
            raise ValueError("a grid without geometry or topology")
        points = np.asarray(_numbers(geometry, float)).reshape(-1, 3)
        blocks, order = _topology(topology)
        data = {}
        for attribute in grid.findall("Attribute"):
            if attribute.get("Center") == "Cell":
                values = _numbers(attribute, float)
                data[attribute.get("Name", "")] = [
                    np.rint(values[rows]).astype(np.int64) for rows in order
                ]
    except (ElementTree.ParseError, ValueError, IndexError, OSError) as error:
        raise MeshError(f"{path} could not be read as XDMF: {error}") from error
    return points, blocks, data


def _numbers(parent: ElementTree.Element, kind: type) -> NDArray[np.float64]:
    item = parent.find("DataItem")
    if item is None or item.get("Format", "XML") != "XML":
        raise ValueError(
            "its numbers lie in another file; write them into the XML, or take .vtu or .msh"
        )
    return np.array((item.text or "").split(), dtype=kind)


def _topology(topology: ElementTree.Element) -> tuple[list[tuple[str, IntArray]], list[IntArray]]:
    """Blocks of cells by type, and the numbers of the cells in each."""
    flat = _numbers(topology, int).astype(np.int64)
    given = topology.get("TopologyType", topology.get("Type", ""))
    for kind, name in _UNIFORM.items():
        if given.lower() == name.lower():
            cells = flat.reshape(-1, TYPES[kind][1])
            return [(kind, cells)], [np.arange(len(cells))]
    if given.lower() != "mixed":
        raise ValueError(f"cells of type {given}")
    of_code = {code: (kind, nodes) for kind, (code, nodes) in TYPES.items()}
    rows: dict[str, list[IntArray]] = {}
    order: dict[str, list[int]] = {}
    place = number = 0
    while place < len(flat):
        if int(flat[place]) not in of_code:
            raise ValueError(f"cells of XDMF's type {int(flat[place])}")
        kind, nodes = of_code[int(flat[place])]
        rows.setdefault(kind, []).append(flat[place + 1 : place + 1 + nodes])
        order.setdefault(kind, []).append(number)
        place, number = place + 1 + nodes, number + 1
    return (
        [(kind, np.array(each, dtype=np.int64)) for kind, each in rows.items()],
        [np.array(each, dtype=np.int64) for each in order.values()],
    )
