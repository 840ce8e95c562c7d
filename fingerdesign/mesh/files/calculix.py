"""Meshes as CalculiX (and Abaqus) input: nodes, C3D10 or CPE6 elements, sets and surfaces.

A deck takes one in with ``*INCLUDE, INPUT=mesh.inp``: an ELSET for each region and "eall" for all,
an NSET (with mid-nodes) and an element-face SURFACE for each named boundary, each under the name
that it has here. Node and element numbers are ours plus one; prisms are cut into tetrahedra.
"""

from pathlib import Path

import numpy as np

from fingerdesign.arrays import IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.types import Mesh, in_tetrahedra

# Corners of the faces S1, S2, ... by dimension (CalculiX 2.20 manual, 6.2.6 and 6.2.15); mid-nodes
# are in VTK's order.
FACES_OF = {
    2: ((0, 1), (1, 2), (2, 0)),
    3: ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
}
_ROW = 12  # numbers a line; CalculiX reads 16


def write_calculix(mesh: Mesh, path: Path) -> None:
    """Write a mesh as an input file to include. OSError where it cannot be written."""
    mesh = in_tetrahedra(mesh)  # CalculiX has no prism of 18 nodes
    kind = "C3D10" if mesh.dimension == 3 else "CPE6"
    with path.open("w", encoding="ascii") as file:
        half = "; the half z >= 0 of a finger that mirrors in z = 0" if mesh.symmetric else ""
        file.write(f"** Finger: lengths in mm{half}\n*NODE, NSET=nall\n")
        for number, (x, y, z) in enumerate(mesh.in_space.tolist(), start=1):
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
    MeshError where a facet is no face of a cell."""
    local = FACES_OF[mesh.dimension]
    width = mesh.dimension
    every = np.sort(mesh.cells[:, local].reshape(-1, width), axis=1)
    own = np.sort(facets[:, :width], axis=1)
    _, inverse = np.unique(np.vstack([every, own]), axis=0, return_inverse=True)
    inverse = inverse.reshape(-1)
    place = np.full(int(inverse.max(initial=0)) + 1, -1)
    place[inverse[: len(every)]] = np.arange(len(every))
    found = place[inverse[len(every) :]]
    if np.any(found < 0):
        raise MeshError(f"{int((found < 0).sum())} facets of {name!r} are no faces of any cell")
    return found // len(local), found % len(local)
