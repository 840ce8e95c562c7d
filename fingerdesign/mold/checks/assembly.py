"""What every check of a mold is given: design, plan, limits, and the parts as exact mesh solids.

First what triangles say of themselves (numpy, scipy), then points on them and rays through solids.
Solids are manifold3d's, in double precision (its Mesh64; Mesh would round to single). Lengths mm.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from manifold3d import Error, Manifold, Mesh64

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.mold.part import MoldMeshes, doubled_areas
from fingerdesign.mold.plan.plan import (
    CorePin,
    Limits,
    MoldPlan,
    Side,
    Slot,
    across,
    direction,
    limits_of,
)

# Flat faces differ by rounding only; the CAD turns curved ones by up to 0.3 rad a triangle.
_FLAT_RAD, _SMOOTH_RAD = 1e-5, 0.4


def partners(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Half-edges 3 t + k (from corner k to k + 1) with the one that runs back along each."""
    tail, head = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    size = int(triangles.max()) + 1
    there, back = tail * size + head, head * size + tail
    order = np.argsort(there, kind="stable")
    place = np.minimum(np.searchsorted(there[order], back), len(order) - 1)
    second = order[place]
    found = there[second] == back
    return np.flatnonzero(found), second[found]


def oriented(vertices: Array, triangles: IntArray) -> tuple[Array, Array]:
    """Outward unit normals (t, 3) and areas (t,), mm^2, by the right-hand rule."""
    normals = doubled_areas(vertices, triangles)
    sizes = np.linalg.norm(normals, axis=1)
    return normals / np.maximum(sizes, np.finfo(float).tiny)[:, None], np.asarray(0.5 * sizes)


def areas(vertices: Array, triangles: IntArray) -> Array:
    """Area of each triangle (t,), mm^2."""
    return oriented(vertices, triangles)[1]


def curved(vertices: Array, triangles: IntArray) -> BoolArray:
    """Which triangles (t,) stand for curved faces: a neighbour is turned, but only a little."""
    normals, _ = oriented(vertices, triangles)
    first, second = partners(triangles)
    turn = np.linalg.norm(normals[first // 3] - normals[second // 3], axis=1)
    found = np.zeros(len(triangles), dtype=bool)
    found[first[(turn > _FLAT_RAD) & (turn < _SMOOTH_RAD)] // 3] = True
    return found


def curved_area(vertices: Array, triangles: IntArray) -> float:
    """Area of the triangles that stand for curved faces, mm^2."""
    return float(areas(vertices, triangles)[curved(vertices, triangles)].sum())


# Rays run nearly along axes, where the library finds what they pass quickest, but not so near
# that they would run within a face.
_ASKEW = np.array([0.0131, 0.0071, 0.0097])


def surface_points(
    vertices: Array, triangles: IntArray, count: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """``count`` points drawn evenly over the area, then every triangle's centroid (at most as many
    again, the largest first), with the outward unit normals: (n, 3) each."""
    normals, sizes = oriented(vertices, triangles)
    whole = sizes > 0.0
    triangles, normals, sizes = triangles[whole], normals[whole], sizes[whole]
    chosen = rng.choice(len(triangles), size=count, p=sizes / sizes.sum())
    u, v = rng.random((2, count))
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    a, b, c = (vertices[triangles[chosen, k]] for k in range(3))
    drawn = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    large = np.argsort(-sizes, kind="stable")[:count]
    centroids = vertices[triangles[large]].mean(axis=1)
    return np.vstack([drawn, centroids]), np.vstack([normals[chosen], normals[large]])


def inside(solid: Manifold, points: Array) -> BoolArray:
    """Whether points (n, 3) lie inside a solid: on the shortest way out of its box, a ray passes
    its surface oddly often."""
    low, high = bounds(solid)
    near = np.flatnonzero(np.all((points >= low) & (points <= high), axis=1))
    starts = points[near]
    ways = np.hstack([high - starts, starts - low])
    least = np.argmin(ways, axis=1)
    direction = np.vstack([np.eye(3), -np.eye(3)])[least] + _ASKEW
    ends = starts + direction * (1.02 * ways.min(axis=1) + 0.01)[:, None]
    held = np.zeros(len(points), dtype=bool)
    held[near] = [len(solid.ray_cast(a, b)) % 2 == 1 for a, b in pairs(starts, ends)]
    return held


def pairs(first: Array, second: Array) -> Sequence[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Rows of two arrays (n, 3) as plain numbers, for the library's rays."""
    both = zip(first.tolist(), second.tolist(), strict=True)
    return [(tuple(a), tuple(b)) for a, b in both]


def place_text(point: Array) -> str:
    """A place as a sentence has it, mm."""
    return f"({', '.join(f'{value:.2f}' for value in point)})"


def bounds(solid: Manifold) -> tuple[Array, Array]:
    """Low and high corners of a solid's box."""
    box = np.asarray(solid.bounding_box(), dtype=float)
    return box[:3], box[3:]


def seen_from(side: Side, points: Array) -> tuple[Array, Array]:
    """Coordinates (place, distance outward) of points (n, 3) as seen from a side."""
    return points @ across(side), points @ direction(side)


def from_slot(slot: Slot, points: Array) -> Array:
    """How far points (n, 3) on a slot's side lie beyond it and its mouth, mm; negative: within. NaN
    for points of the other half of the mold."""
    place, out = seen_from(slot.side, points)
    angle = np.radians(slot.angle_deg)
    dx, dy = place - slot.place, points[:, 1] - slot.y
    along = np.abs(dx * np.cos(angle) + dy * np.sin(angle)) - 0.5 * slot.length
    over = np.abs(dy * np.cos(angle) - dx * np.sin(angle)) - 0.5 * slot.width
    beyond = np.hypot(np.maximum(along, 0.0), np.maximum(over, 0.0))
    beyond = beyond + np.minimum(np.maximum(along, over), 0.0)
    if slot.mouth:
        below = [along, slot.mouth[1] - points[:, 1], out - slot.mouth[0], dy]
        beyond = np.minimum(beyond, np.max(below, axis=0))
    return np.asarray(np.where(out > 0.0, beyond, np.nan))


def from_pin(pin: CorePin, points: Array) -> Array:
    """How far points (n, 3) lie beyond a core pin's hole, mm; NaN for the other half."""
    place, out = seen_from(pin.side, points)
    beyond = np.hypot(place - pin.place, points[:, 1] - pin.y) - 0.5 * pin.diameter
    return np.asarray(np.where(out > 0.0, beyond, np.nan))


def planned(plan: MoldPlan, points: Array, clearance_mm: float, slack_mm: float) -> BoolArray:
    """Whether points (n, 3) lie in an opening of the plan, or within ``slack_mm`` of one; core pins
    have a clearance all round."""
    below = points[:, 1] < slack_mm
    open_ = (points[:, 1] > 0.0) & (points[:, 1] < plan.seam + slack_mm) & (plan.seam > 0.0)
    for hole in plan.base_holes:
        radius = 0.5 * max(hole.diameter, hole.outer_diameter) + slack_mm
        open_ |= below & (np.hypot(points[:, 0] - hole.x, points[:, 2] - hole.z) <= radius)
    for side in plan.sides:
        for slot in side.slots:  # NaN compares false
            open_ |= from_slot(slot, points) <= slack_mm
    for pin in plan.core_pins:
        open_ |= from_pin(pin, points) <= clearance_mm + slack_mm
    return open_


@dataclass(frozen=True)
class Assembly:
    """A closed mold: ``solids`` by name (parts, plates, "rubber")."""

    design: Design
    plan: MoldPlan
    meshes: MoldMeshes
    limits: Limits
    solids: Mapping[str, Manifold]

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
    return Assembly(design, plan, meshes, limits_of(design.mold), solids)
