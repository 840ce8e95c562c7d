"""What every check of a mold is given: design, plan, limits, and the parts as exact mesh solids.

Solids are manifold3d's, in double precision (its Mesh64; Mesh would round to single). Lengths mm.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from manifold3d import Error, Manifold, Mesh64
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.mold.checks.triangles import inside, surface_points
from fingerdesign.mold.part import BASE, CORE, RUBBER, Check, MoldMeshes, PartMesh
from fingerdesign.mold.plan.plan import CorePin, Limits, MoldPlan, Slot, limits_of

# The openings that a mold's plan makes in the cavity's wall: slots and round holes.


def across(side: str, points: Array) -> tuple[Array, Array]:
    """Coordinates (place, distance outward) of points (n, 3) as seen from a side."""
    sign = 1.0 if side[0] == "+" else -1.0
    if side.endswith("z"):
        return points[:, 0], sign * points[:, 2]
    return points[:, 2], sign * points[:, 0]


def from_slot(slot: Slot, points: Array) -> Array:
    """How far points (n, 3) on a slot's side lie beyond it and its relief, mm; negative: within.
    NaN for points of the other half of the mold."""
    place, out = across(slot.side, points)
    angle = np.radians(slot.angle_deg)
    dx, dy = place - slot.place, points[:, 1] - slot.y
    along = np.abs(dx * np.cos(angle) + dy * np.sin(angle)) - 0.5 * slot.length
    over = np.abs(dy * np.cos(angle) - dx * np.sin(angle)) - 0.5 * slot.width
    beyond = np.hypot(np.maximum(along, 0.0), np.maximum(over, 0.0))
    beyond = beyond + np.minimum(np.maximum(along, over), 0.0)
    if slot.relief:
        x, y = slot.relief_centre
        beyond = np.minimum(beyond, np.hypot(place - x, points[:, 1] - y) - 0.5 * slot.relief)
    return np.asarray(np.where(out > 0.0, beyond, np.nan))


def from_pin(pin: CorePin, points: Array) -> Array:
    """How far points (n, 3) lie beyond a core pin's hole, mm; NaN for the other half."""
    place, out = across(pin.side, points)
    beyond = np.hypot(place - pin.place, points[:, 1] - pin.y) - 0.5 * pin.diameter
    return np.asarray(np.where(out > 0.0, beyond, np.nan))


def planned(
    plan: MoldPlan, points: Array, clearance_mm: float, slack_mm: float
) -> NDArray[np.bool_]:
    """Whether points (n, 3) lie in an opening of the plan, or within ``slack_mm`` of one; core pins
    have a clearance all round."""
    open_ = np.zeros(len(points), dtype=bool)
    below = points[:, 1] < slack_mm
    for hole in plan.base_holes:
        radius = 0.5 * max(hole.diameter, hole.outer_diameter) + slack_mm
        open_ |= below & (np.hypot(points[:, 0] - hole.x, points[:, 2] - hole.z) <= radius)
    for side in plan.sides:
        for slot in side.slots:  # a jig's are shifted; NaN compares false
            open_ |= from_slot(slot, points) <= slack_mm + side.shift
    for pin in plan.core_pins:
        open_ |= from_pin(pin, points) <= clearance_mm + slack_mm
    return open_


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


# Whether a part stands behind every place of the finger's surface.

POINTS = 10000  # 0.08 mm^2 each on a finger of 800 mm^2
# A sheet's slot is wider than planned by no more than its fillets; seams are closed.
SLACK_MM = 0.05


def backing_check(assembly: Assembly, rng: np.random.Generator) -> Check:
    """Points two chords outside the outline must lie in a part, a plate or a planned opening."""
    outline = assembly.meshes.outline
    points, normals = surface_points(outline.vertices, outline.triangles, POINTS, rng)
    points = points[:POINTS] + 2.0 * assembly.chord * normals[:POINTS]
    left = ~planned(assembly.plan, points, assembly.limits.clearance_mm, SLACK_MM)
    wanted = int(left.sum())
    for part in (*assembly.meshes.parts, *assembly.meshes.plates):
        rest = np.flatnonzero(left)
        left[rest[inside(assembly.solids[part.name], points[rest])]] = False
    bare = points[left]
    share = len(bare) / POINTS
    where, size = _largest(bare)
    sentence = f"a part stands behind each of {wanted} points on the finger's surface"
    if len(bare):
        place = ", ".join(f"{value:.2f}" for value in where)
        sentence = (
            f"{len(bare)} of {POINTS} points on the finger's surface have no part behind them; the "
            f"largest hole is about {size:.2f} mm wide, at ({place})"
        )
    return Check("surface backed by parts", "", not len(bare), share, 0.0, "1", sentence)


def _largest(points: Array) -> tuple[Array, float]:
    """Middle and greatest extent of the largest cluster of points (n, 3), mm."""
    if not len(points):
        return np.zeros(3), 0.0
    near = cKDTree(points).query_pairs(1.0, output_type="ndarray")
    shape = (len(points), len(points))
    links = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=shape)
    _, labels = connected_components(links, directed=False)
    cluster = points[labels == np.bincount(labels).argmax()]
    return cluster.mean(axis=0), float(np.ptp(cluster, axis=0).max())
