"""CalculiX and Abaqus input decks read: nodes, tetrahedra or triangles, sets and surfaces.

meshio's own reader is not used: of the surfaces that write_calculix writes it returned 0 of 3
(plane) and 0 of 5 (space), as it skips SURFACE cards and drops the element numbers that they name;
sets of sets come nested, and CPE3, CPS6, M3D3 or lower-case types are refused.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.cells import boundary_facets
from fingerdesign.mesh.files.calculix import FACES_OF
from fingerdesign.mesh.files.named import NamedMesh, region_number

_NODES_OF = {"C3D4": 4, "C3D10": 10, "CPE3": 3, "CPS3": 3, "CPE6": 6, "CPS6": 6}
_NODES_OF |= {"S3": 3, "S6": 6, "STRI3": 3, "STRI65": 6, "M3D3": 3, "M3D6": 6}
_FLAT = {10: 6, 4: 3}  # nodes of the triangles that name boundaries of such tetrahedra

Options = dict[str, str]
Lines = list[list[str]]


def read_calculix(path: Path) -> NamedMesh:
    """Read nodes, triangles and tetrahedra, ELSETs, NSETs and element-face SURFACEs of a deck.

    Boundaries are its surfaces, else its sets of triangles, else its node sets (facets with all
    corners in them). Other keywords are skipped. MeshError names what cannot be understood.
    """
    deck = _Deck()
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            for keyword, options, lines in _cards(file):
                deck.read_card(keyword, options, lines)
        return deck.mesh(path)
    except (ValueError, IndexError) as error:
        raise MeshError(f"{path}: not the numbers that its keywords announce: {error}") from error
    except KeyError as error:
        raise MeshError(f"{path}: {error} is used but not defined (before)") from error


def _cards(lines: IO[str]) -> Iterator[tuple[str, Options, Lines]]:
    """Keyword, its options in capitals, and its data lines, card by card."""
    keyword, options, data = "", Options(), Lines()
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


class _Deck:
    """The nodes, elements, sets and surfaces of the cards read so far."""

    def __init__(self) -> None:
        self.nodes: dict[int, list[float]] = {}
        self.elements: dict[int, list[int]] = {}
        self.sets: dict[str, dict[str, list[int]]] = {"ELSET": {}, "NSET": {}}
        self.surfaces: dict[str, list[tuple[int, int]]] = {}

    def read_card(self, keyword: str, options: Options, lines: Lines) -> None:
        """Read one card; those of other keywords are skipped."""
        if keyword == "NODE":
            for number, *place in lines:
                self.nodes[int(number)] = [float(value) for value in place[:3]]
        elif keyword == "ELEMENT":
            self._read_elements(options, lines)
        elif keyword in self.sets:
            self._read_set(keyword, options, lines)
        elif keyword == "SURFACE" and options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
            own = self.surfaces.setdefault(options["NAME"].lower(), [])
            for name, face in (line[:2] for line in lines):
                members = [int(name)] if name.isdigit() else self.sets["ELSET"][name.lower()]
                own += [(member, int(face.upper().lstrip("S")) - 1) for member in members]

    def _read_set(self, keyword: str, options: Options, lines: Lines) -> None:
        sets = self.sets[keyword]
        own = sets.setdefault(options[keyword].lower(), [])
        for line in lines:
            if "GENERATE" in options:
                first, last, *step = (int(part) for part in line)
                own += range(first, last + 1, step[0] if step else 1)
            else:
                for part in filter(None, line):
                    own += [int(part)] if part.isdigit() else sets[part.lower()]

    def _read_elements(self, options: Options, lines: Lines) -> None:
        kind = options.get("TYPE", "").upper().rstrip("HMIRT")
        count = _NODES_OF.get(kind)
        if count is None:
            if kind.startswith(("C3D", "DC3D", "SC")):
                raise MeshError(f"elements of type {options.get('TYPE')} are no tetrahedra")
            return
        numbers = [int(part) for line in lines for part in filter(None, line)]
        name = options["ELSET"].lower() if "ELSET" in options else None
        own = [] if name is None else self.sets["ELSET"].setdefault(name, [])
        for start in range(0, len(numbers), count + 1):
            number, *nodes = numbers[start : start + count + 1]
            self.elements[number] = nodes
            own.append(number)

    def mesh(self, path: Path) -> NamedMesh:
        """The mesh, with numbers from 0."""
        widths = {len(nodes) for nodes in self.elements.values()}
        solid = next((width for width in (10, 4, 6, 3) if width in widths), 0)
        if not solid or {10, 4} <= widths:
            raise MeshError(f"{path} holds no tetrahedra or triangles, or of two orders")
        order = {number: row for row, number in enumerate(self.nodes)}
        points = np.array(list(self.nodes.values()), dtype=float).reshape(len(order), -1)
        cells = sorted(n for n, nodes in self.elements.items() if len(nodes) == solid)
        row_of = {number: row for row, number in enumerate(cells)}
        try:
            rows = np.array([[order[n] for n in self.elements[number]] for number in cells])
            dimension = 3 if solid in _FLAT else 2
            facets = self._facets(rows, row_of, order, dimension)
        except KeyError as error:
            raise MeshError(f"{path}: node {error} is not defined") from error
        return NamedMesh(points[:, :dimension], rows, self._regions(row_of), facets)

    def _regions(self, row_of: dict[int, int]) -> NDArray[np.str_]:
        """The name of each cell's region: that of a region of ours, or its smallest set's."""
        names = np.full(len(row_of), "", dtype=object)
        sets = self.sets["ELSET"]

        def rank(name: str) -> tuple[bool, int]:
            return name != "core" and region_number(name) is None, len(sets[name])

        for name in sorted(sets, key=rank):
            inside = np.array([row_of[n] for n in sets[name] if n in row_of], dtype=int)
            names[inside[names[inside] == ""]] = name
        return np.array(names, dtype=str)

    def _facets(
        self, rows: IntArray, row_of: dict[int, int], order: dict[int, int], dimension: int
    ) -> dict[str, IntArray]:
        """Facets (f, dimension) by name."""
        faces, flat = FACES_OF[dimension], _FLAT.get(rows.shape[1], 0)
        found: dict[str, IntArray] = {}
        for name, members in self.surfaces.items():
            chosen = [(row_of[n], face) for n, face in members if n in row_of]
            found[name] = np.array([rows[row, list(faces[face])] for row, face in chosen])
        for name, own in self._flat_sets(flat).items():
            if name not in found:
                found[name] = np.array([[order[n] for n in nodes[:dimension]] for nodes in own])
        outer = boundary_facets(rows[:, : dimension + 1])
        for name, numbers in self.sets["NSET"].items():
            if name not in found and name != "nall":
                inside = [order[n] for n in numbers]
                found[name] = outer[np.isin(outer, inside).all(axis=1)]
        return {name: facets for name, facets in found.items() if len(facets)}

    def _flat_sets(self, width: int) -> dict[str, list[list[int]]]:
        """The surface elements of ``width`` nodes in each element set that has any; 0: none."""
        every = {n: nodes for n, nodes in self.elements.items() if width and len(nodes) == width}
        found = {}
        for name, numbers in self.sets["ELSET"].items():
            if own := [every[n] for n in numbers if n in every]:
                found[name] = own
        return found
