"""Meshes as CalculiX (and Abaqus) input: nodes, C3D10 or CPE6 elements, sets and surfaces.

A deck takes one in with ``*INCLUDE, INPUT=mesh.inp``: an ELSET for each region and "eall" for all,
an NSET (with mid-nodes) and an element-face SURFACE for each named boundary, each under the name
that it has here. Node and element numbers are ours plus one.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import IO

import numpy as np

from fingerdesign.arrays import IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.files.named import NamedMesh, region_number
from fingerdesign.mesh.types import Mesh, boundary_facets

# Corners of the faces S1, S2, ... (CalculiX 2.20 manual, 6.2.6 and 6.2.15); mid-nodes are in VTK's
# order.
TETRA_FACES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
TRIANGLE_FACES = ((0, 1), (1, 2), (2, 0))
_ROW = 12  # numbers a line; CalculiX reads 16


def write_calculix(mesh: Mesh, path: Path) -> None:
    """Write a mesh as an input file to include. OSError where it cannot be written."""
    kind = "C3D10" if mesh.dimension == 3 else "CPE6"
    with path.open("w", encoding="ascii") as file:
        half = "; the half z >= 0 of a finger that mirrors in z = 0" if mesh.symmetric else ""
        file.write(f"** Finger: lengths in mm{half}\n*NODE, NSET=nall\n")
        points = np.zeros((len(mesh.points), 3))
        points[:, : mesh.dimension] = mesh.points
        for number, (x, y, z) in enumerate(points.tolist(), start=1):
            file.write(f"{number}, {_short(x)}, {_short(y)}, {_short(z)}\n")
        for region in np.unique(mesh.regions):
            rows = np.flatnonzero(mesh.regions == region)
            file.write(f"*ELEMENT, TYPE={kind}, ELSET={mesh.region_name(int(region))}\n")
            for number, nodes in zip(rows.tolist(), (mesh.cells[rows] + 1).tolist(), strict=True):
                file.write(f"{number + 1}, {', '.join(map(str, nodes))}\n")
        names = [mesh.region_name(int(region)) for region in np.unique(mesh.regions)]
        file.write("*ELSET, ELSET=eall\n" + "".join(f"{name},\n" for name in names))
        for name, facets in mesh.facets.items():
            file.write(f"*NSET, NSET={name}\n")
            numbers = (np.unique(facets) + 1).tolist()
            for start in range(0, len(numbers), _ROW):
                file.write(", ".join(map(str, numbers[start : start + _ROW])) + ",\n")
            cells, faces = cell_faces(mesh, facets, name)
            file.write(f"*SURFACE, NAME={name}, TYPE=ELEMENT\n")
            for cell, face in zip(cells.tolist(), faces.tolist(), strict=True):
                file.write(f"{cell + 1}, S{face + 1}\n")


def _short(value: float) -> str:
    """A number in the 20 characters that CalculiX reads; more exist with an exponent only."""
    text = repr(value)
    return text if len(text) <= 20 else f"{value:.13e}"


def cell_faces(mesh: Mesh, facets: IntArray, name: str = "facets") -> tuple[IntArray, IntArray]:
    """The cell (f,) that each boundary facet belongs to, and the number of its face from 0, (f,).

    MeshError where a facet is no face of a cell.
    """
    local = TETRA_FACES if mesh.dimension == 3 else TRIANGLE_FACES
    width = mesh.dimension
    every = np.sort(mesh.cells[:, local].reshape(-1, width), axis=1)
    wanted = np.sort(facets[:, :width], axis=1)
    _, inverse = np.unique(np.vstack([every, wanted]), axis=0, return_inverse=True)
    inverse = inverse.reshape(-1)
    place = np.full(int(inverse.max(initial=0)) + 1, -1)
    place[inverse[: len(every)]] = np.arange(len(every))
    found = place[inverse[len(every) :]]
    if np.any(found < 0):
        raise MeshError(f"{int((found < 0).sum())} facets of {name!r} are no faces of any cell")
    return found // len(local), found % len(local)


# CalculiX and Abaqus input decks read: nodes, tetrahedra or triangles, sets and surfaces.
#
# meshio's own reader is not used: of what write_calculix writes it returned 0 of 3 surfaces (plane)
# and 0 of 5 (space), as it skips SURFACE cards and drops the element numbers that they name; sets
# of sets come nested, and CPE3, CPS6, M3D3 or lower-case types are refused. What is left it reads
# in 0.7 to 0.9 of the time.

_NODES_OF = {"C3D4": 4, "C3D10": 10, "CPE3": 3, "CPS3": 3, "CPE6": 6, "CPS6": 6}
_NODES_OF |= {"S3": 3, "S6": 6, "STRI3": 3, "STRI65": 6, "M3D3": 3, "M3D6": 6}


def read_calculix(path: Path) -> NamedMesh:
    """Read nodes, triangles and tetrahedra, ELSETs, NSETs and element-face SURFACEs of a deck.

    Boundaries are its surfaces, else its sets of triangles, else its node sets (facets with all
    corners in them). Other keywords are skipped. MeshError names what cannot be understood.
    """
    deck = _Deck()
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            for keyword, options, lines in _cards(file):
                deck.take(keyword, options, lines)
        return deck.mesh(path)
    except (ValueError, IndexError) as error:
        raise MeshError(f"{path}: not the numbers that its keywords announce: {error}") from error
    except KeyError as error:
        raise MeshError(f"{path}: {error} is used but not defined (before)") from error


def _cards(lines: IO[str]) -> Iterator[tuple[str, dict[str, str], list[list[str]]]]:
    """Keyword, its options in capitals, and its data lines, card by card."""
    keyword, options, data = "", dict[str, str](), list[list[str]]()
    for line in lines:
        text = line.strip()
        if not text or text.startswith("**"):
            continue
        if not text.startswith("*"):
            data.append([part.strip() for part in text.rstrip(",").split(",")])
            continue
        if keyword:
            yield keyword, options, data
        first, *rest = text[1:].split(",")
        keyword, data = first.strip().upper(), []
        pairs = [part.partition("=") for part in rest if part.strip()]
        options = {key.strip().upper(): value.strip() for key, _, value in pairs}
    if keyword:
        yield keyword, options, data


def _ours(name: str) -> bool:
    return name == "core" or region_number(name) is not None


class _Deck:
    """What has been read of a deck so far."""

    def __init__(self) -> None:
        self.nodes: dict[int, list[float]] = {}
        self.elements: dict[int, list[int]] = {}
        self.elsets: dict[str, list[int]] = {}
        self.nsets: dict[str, list[int]] = {}
        self.surfaces: dict[str, list[tuple[int, int]]] = {}

    def take(self, keyword: str, options: dict[str, str], lines: list[list[str]]) -> None:
        """Take in one card."""
        if keyword == "NODE":
            for number, *place in lines:
                self.nodes[int(number)] = [float(value) for value in place[:3]]
        elif keyword == "ELEMENT":
            self._elements(options, lines)
        elif keyword in ("ELSET", "NSET"):
            sets = self.elsets if keyword == "ELSET" else self.nsets
            own = sets.setdefault(options[keyword].lower(), [])
            for line in lines:
                if "GENERATE" in options:
                    first, last, *step = (int(part) for part in line)
                    own += range(first, last + 1, step[0] if step else 1)
                else:
                    for part in filter(None, line):
                        own += [int(part)] if part.isdigit() else sets[part.lower()]
        elif keyword == "SURFACE" and options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
            own_faces = self.surfaces.setdefault(options["NAME"].lower(), [])
            for who, face in (line[:2] for line in lines):
                members = [int(who)] if who.isdigit() else self.elsets[who.lower()]
                own_faces += [(member, int(face.upper().lstrip("S")) - 1) for member in members]

    def _elements(self, options: dict[str, str], lines: list[list[str]]) -> None:
        kind = options.get("TYPE", "").upper().rstrip("HMIRT")
        count = _NODES_OF.get(kind)
        if count is None:
            if kind.startswith(("C3D", "DC3D", "SC")):
                raise MeshError(f"elements of type {options.get('TYPE')} are no tetrahedra")
            return
        numbers = [int(part) for line in lines for part in filter(None, line)]
        own = self.elsets.setdefault(options["ELSET"].lower(), []) if "ELSET" in options else []
        for start in range(0, len(numbers), count + 1):
            number, *nodes = numbers[start : start + count + 1]
            self.elements[number] = nodes
            own.append(number)

    def mesh(self, path: Path) -> NamedMesh:
        """What was read, with numbers from 0."""
        widths = {len(nodes) for nodes in self.elements.values()}
        solid = next((width for width in (10, 4, 6, 3) if width in widths), 0)
        if not solid or {10, 4} <= widths:
            raise MeshError(f"{path} holds no tetrahedra or triangles, or of two orders")
        flat = {10: 6, 4: 3}.get(solid, 0)
        order = {number: row for row, number in enumerate(self.nodes)}
        points = np.array(list(self.nodes.values()), dtype=float).reshape(len(order), -1)
        cells = sorted(n for n, nodes in self.elements.items() if len(nodes) == solid)
        row_of = {number: row for row, number in enumerate(cells)}
        try:
            rows = np.array([[order[n] for n in self.elements[number]] for number in cells])
            names = np.full(len(cells), "", dtype=object)
            order_of = {name: (not _ours(name), len(own)) for name, own in self.elsets.items()}
            for name in sorted(order_of, key=lambda each: order_of[each]):
                inside = np.array([row_of[n] for n in self.elsets[name] if n in row_of], dtype=int)
                names[inside[names[inside] == ""]] = name  # ours, or the smallest
            facets = self._facets(rows, row_of, solid, flat, order)
        except KeyError as error:
            raise MeshError(f"{path}: node {error} is not defined") from error
        dimension = 3 if solid in (4, 10) else 2
        return NamedMesh(points[:, :dimension], rows, np.array(names, dtype=str), facets)

    def _facets(
        self, rows: IntArray, row_of: dict[int, int], solid: int, flat: int, order: dict[int, int]
    ) -> dict[str, IntArray]:
        found: dict[str, IntArray] = {}
        faces = TETRA_FACES if solid in (4, 10) else TRIANGLE_FACES
        outer = boundary_facets(rows[:, : len(faces)], len(faces[0]))
        for name, members in self.surfaces.items():
            chosen = [(row_of[n], face) for n, face in members if n in row_of]
            found[name] = np.array([rows[row, list(faces[face])] for row, face in chosen])
        for name, numbers in self.elsets.items():
            own = [self.elements[n] for n in numbers if len(self.elements.get(n, [])) == flat]
            if own and name not in found:
                width = len(faces[0])
                found[name] = np.array([[order[n] for n in nodes[:width]] for nodes in own])
        for name, nodes_in in self.nsets.items():
            if name not in found and name != "nall":
                own_nodes = [order[n] for n in nodes_in]
                found[name] = outer[np.isin(outer, own_nodes).all(axis=1)]
        return {name: facets for name, facets in found.items() if len(facets)}
