"""The mesh that every mesher makes and everything after it reads (numpy only)."""

from dataclasses import dataclass, field

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.mesh.cells import KINDS, CellKind


@dataclass(frozen=True)
class Mesh:
    """A quadratic simplicial mesh in mm, in the section (dim 2) or the finger (dim 3).

    points   (n, dim): corner and mid-edge nodes
    cells    (c, 6) or (c, 10): corners, then the mid-edge nodes of ``kind``; positively oriented
    regions  (c,): 0 the elastomer, k + 1 plate k, and those of ``region_names`` (a core)
    facets   name -> (f, 3) or (f, 6): boundary facets, corners then mid-edge nodes; names "base",
             "contact" (the curved face), "side", "end" (z faces), "symmetry" (z = 0 of a half);
             of plates as sheets "plate_k_upper", "_lower" and "_end": faces of plate k's slot
    symmetric  True when the mesh is the half z >= 0 of a finger that mirrors in z = 0
    """

    points: Array
    cells: IntArray
    regions: IntArray
    facets: dict[str, IntArray]
    mesher: str
    symmetric: bool = False
    notes: dict[str, float | int | str] = field(default_factory=dict)
    region_names: dict[int, str] = field(default_factory=dict)

    def region_name(self, number: int) -> str:
        """Name of a region: "elastomer", "plate_0", ..., or its own."""
        usual = "elastomer" if number == 0 else f"plate_{number - 1}"
        return self.region_names.get(number, usual)

    @property
    def dimension(self) -> int:
        return int(self.points.shape[1])

    @property
    def kind(self) -> CellKind:
        """The kind of all cells."""
        return KINDS[self.dimension]

    @property
    def corners(self) -> IntArray:
        """Corner nodes of the cells, (c, dim + 1)."""
        return self.cells[:, : self.kind.corners]

    @property
    def parts(self) -> dict[str, BoolArray]:
        """Masks (c,) of the cells that belong to "elastomer", "plates" and "core"."""
        cores = [number for number, name in self.region_names.items() if name == "core"]
        core = np.isin(self.regions, cores)
        return {"elastomer": self.regions == 0, "plates": (self.regions > 0) & ~core, "core": core}


def core_name(design: Design) -> dict[int, str]:
    """The region's name that a core adds to a mesh."""
    return {} if design.body.core is None else {design.core_region: "core"}
