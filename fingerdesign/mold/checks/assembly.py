"""What every check of a mold is given: design, plan, limits, and the parts as exact mesh solids.

Solids are manifold3d's, in double precision (its Mesh64; Mesh would round to single). Lengths mm.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from manifold3d import Error, Manifold, Mesh64

from fingerdesign.arrays import Array, IntArray
from fingerdesign.mold.part import BASE, CORE, RUBBER, MoldMeshes, PartMesh
from fingerdesign.mold.plan import MoldPlan
from fingerdesign.mold.profiles import Limits, limits_of

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

OUTLINE = "outline"


@dataclass(frozen=True)
class Assembly:
    """A closed mold: ``solids`` by name (parts, plates, "rubber", "outline") and ``blanks`` of the
    parts that fill the block (all but base plate and core)."""

    design: Design
    plan: MoldPlan
    meshes: MoldMeshes
    limits: Limits
    solids: Mapping[str, Manifold]
    blanks: Mapping[str, Manifold]

    @property
    def staying(self) -> tuple[str, ...]:
        """Names of what stays with the finger or is the finger: rubber, plates, drawless parts."""
        fixed = [part.name for part in self.meshes.parts if part.draw is None]
        return (RUBBER, *(plate.name for plate in self.meshes.plates), *fixed)

    @property
    def chord(self) -> float:
        """The greatest distance of any part's triangles from its surface, mm."""
        return max(part.chord for part in (*self.meshes.parts, self.meshes.outline))


def solid_of(vertices: Array, triangles: IntArray) -> Manifold:
    """Triangles (t, 3) of vertices (n, 3) as a solid; its status says what is wrong with them."""
    points = np.array(vertices, dtype=np.float64, order="C")
    return Manifold(Mesh64(points, np.array(triangles, dtype=np.uint64, order="C")))


def sound(solid: Manifold) -> bool:
    """Whether the triangles were those of a solid."""
    return bool(solid.status() == Error.NoError and not solid.is_empty())


def assemble(design: Design, plan: MoldPlan, meshes: MoldMeshes) -> Assembly:
    """All solids of a mold; one that is not ``sound`` is in it too."""
    everything = (*meshes.parts, *meshes.plates, meshes.rubber)
    solids = {part.name: solid_of(part.vertices, part.triangles) for part in everything}
    solids[OUTLINE] = solid_of(meshes.outline.vertices, meshes.outline.triangles)
    blanks = {part.name: _blank(part, solids) for part in filling(meshes)}
    return Assembly(design, plan, meshes, limits_of(design.mold), solids, blanks)


def filling(meshes: MoldMeshes) -> tuple[PartMesh, ...]:
    """The parts whose blanks fill the block around the cavity."""
    return tuple(part for part in meshes.parts if part.name not in (BASE, CORE))


def _blank(part: PartMesh, solids: Mapping[str, Manifold]) -> Manifold:
    same = part.blank_triangles is part.triangles and part.blank_vertices is part.vertices
    return solids[part.name] if same else solid_of(part.blank_vertices, part.blank_triangles)
