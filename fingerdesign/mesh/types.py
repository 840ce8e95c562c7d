"""The mesh that every mesher makes and everything after it reads (numpy only)."""

import re
from dataclasses import dataclass, field, replace

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.mesh.cells import (
    PRISM,
    SQUARE,
    CellKind,
    facet_kind,
    kind_of,
    tetrahedra_of,
    triangles_of,
)


@dataclass(frozen=True)
class Mesh:
    """A quadratic mesh in mm, in the section (dim 2) or the finger (dim 3).

    points   (n, dim): corner and mid-nodes
    cells    (c, 6) triangles, (c, 10) tetrahedra or (c, 18) prisms: corners, then the mid-nodes of
             ``kind``; positively oriented
    regions  (c,): 0 the elastomer, k + 1 plate k, and those of ``region_names`` (a core)
    facets   name -> (f, 3, 6 or 9): boundary facets, corners then mid-nodes; names "base",
             "contact" (the curved face), "side", "end" (z faces), "symmetry" (z = 0 of a half);
             of plates as sheets "plate_k_upper", "_lower", "_end" and (of prisms) "_cap":
             faces of plate k's slot
    symmetric  True when the mesh is the half z >= 0 of a finger that mirrors in z = 0
    moved    True when its nodes were moved: other meshes have the same cells
    """

    points: Array
    cells: IntArray
    regions: IntArray
    facets: dict[str, IntArray]
    mesher: str
    symmetric: bool = False
    notes: dict[str, float | int | str] = field(default_factory=dict)
    region_names: dict[int, str] = field(default_factory=dict)
    moved: bool = False

    def region_name(self, number: int) -> str:
        """Name of a region: "elastomer", "plate_0", ..., or its own."""
        usual = "elastomer" if number == 0 else f"plate_{number - 1}"
        return self.region_names.get(number, usual)

    @property
    def dimension(self) -> int:
        return int(self.points.shape[1])

    @property
    def in_space(self) -> Array:
        """Nodes (n, 3); those of a section at z = 0."""
        return np.pad(self.points, ((0, 0), (0, 3 - self.dimension)))

    @property
    def kind(self) -> CellKind:
        """The kind of all cells."""
        return kind_of(self.cells)

    @property
    def corners(self) -> IntArray:
        """Corner nodes of the cells, (c, corners)."""
        return self.cells[:, : self.kind.corners]

    @property
    def parts(self) -> dict[str, BoolArray]:
        """Masks (c,) of the cells that belong to "elastomer", "plates" and "core"."""
        cores = [number for number, name in self.region_names.items() if name == "core"]
        core = np.isin(self.regions, cores)
        return {"elastomer": self.regions == 0, "plates": (self.regions > 0) & ~core, "core": core}


def in_tetrahedra(mesh: Mesh) -> Mesh:
    """The same nodes, with prisms cut into tetrahedra and square facets into triangles."""
    if mesh.kind is not PRISM:
        return mesh
    facets: dict[str, IntArray] = {}
    for name, rows in mesh.facets.items():
        label = re.sub("_cap$", "_end", name)  # tetrahedra have one kind of facets
        own = triangles_of(rows) if facet_kind(rows) is SQUARE else rows
        facets[label] = np.vstack([facets.get(label, own[:0]), own])
    cells, regions = tetrahedra_of(mesh.cells), np.repeat(mesh.regions, 3)
    return replace(mesh, cells=cells, regions=regions, facets=facets)


def core_name(design: Design) -> dict[int, str]:
    """The region's name that a core adds to a mesh."""
    return {} if design.body.core is None else {design.core_region: "core"}
