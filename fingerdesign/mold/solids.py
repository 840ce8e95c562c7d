"""Triangles and solids of a mold's parts: normals, areas, points on them, rays through them; mm.

Solids are manifold3d's, in double precision (its Mesh64; Mesh would round to single).
"""

from collections.abc import Sequence

import numpy as np
from manifold3d import Error, Manifold, Mesh64

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.mold.part import EDGE_DEG
from fingerdesign.mold.plan.pieces import Side, across, direction

# Flat faces differ by rounding only; the CAD kernel turns curved ones by up to 0.3 rad a triangle.
_FLAT_RAD, _SMOOTH_RAD = 1e-5, 0.4
# Rays run nearly along axes, where the library finds what they pass quickest, but not so near
# that they would run within a face.
_ASKEW = np.array([0.0131, 0.0071, 0.0097])
STRAIGHT = 1e-7  # mm; a point this near the line between its neighbours adds nothing
START_MM = 1e-6  # distance from the surface at which a ray into it starts
# A ray that ends on a face turned by more than the sharpest edge has crossed an edge, no wall.
OPPOSITE = np.cos(np.radians(EDGE_DEG))


def solid_of(vertices: Array, triangles: IntArray) -> Manifold:
    """Triangles (t, 3) of vertices (n, 3) as a solid; its status says what is wrong with them."""
    points = np.array(vertices, dtype=np.float64, order="C")
    return Manifold(Mesh64(points, np.array(triangles, dtype=np.uint64, order="C")))


def hull_of(points: Array) -> Manifold:
    """The convex hull of points (n, 3)."""
    return Manifold.hull_points(points)


def sound(solid: Manifold) -> bool:
    """True where the triangles were those of a solid."""
    return bool(solid.status() == Error.NoError and not solid.is_empty())


def bounds(solid: Manifold) -> tuple[Array, Array]:
    """Low and high corners of a solid's box."""
    box = np.asarray(solid.bounding_box(), dtype=float)
    return box[:3], box[3:]


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
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    sizes = np.linalg.norm(normals, axis=1)
    units = np.asarray(normals / np.maximum(sizes, np.finfo(float).tiny)[:, None])
    return units, np.asarray(0.5 * sizes)


def section_loops(solid: Manifold, side: Side, out: float) -> list[Array]:
    """Closed polygons (n, 2), (place, y), of a solid's section at a distance from the mid-plane."""
    turn = [[*across(side), 0.0], [0.0, 1.0, 0.0, 0.0], [*direction(side), 0.0]]
    section = solid.transform(np.array(turn)).slice(out).simplify(STRAIGHT)
    return [np.asarray(loop) for loop in section.to_polygons()]


def least_distance(loops: Sequence[Array]) -> tuple[float, Array]:
    """Least distance between closed polygons (n, 2) that do not meet, mm, and a corner where it is:
    exact, since one end of it is a corner; infinite of less than two."""
    least, place = np.inf, np.zeros(2)
    for k, loop in enumerate(loops):
        others = [each for j, each in enumerate(loops) if j != k]
        if not others or not len(loop):
            continue
        starts = np.vstack(others)
        ways = np.vstack([np.roll(each, -1, axis=0) - each for each in others])
        sizes = np.maximum((ways**2).sum(axis=1), np.finfo(float).tiny)
        away = loop[:, None] - starts
        share = np.clip((away * ways).sum(axis=2) / sizes, 0.0, 1.0)
        distance = np.linalg.norm(away - share[..., None] * ways, axis=2)
        if distance.min() < least:
            least = float(distance.min())
            place = loop[int(distance.min(axis=1).argmin())]
    return least, place


def areas(vertices: Array, triangles: IntArray) -> Array:
    """Area of each triangle (t,), mm^2."""
    return oriented(vertices, triangles)[1]


def curved(vertices: Array, triangles: IntArray) -> BoolArray:
    """Find triangles (t,) that stand for curved faces: a neighbour is turned, but only a little."""
    normals, _ = oriented(vertices, triangles)
    first, second = partners(triangles)
    turn = np.linalg.norm(normals[first // 3] - normals[second // 3], axis=1)
    found = np.zeros(len(triangles), dtype=bool)
    found[first[(turn > _FLAT_RAD) & (turn < _SMOOTH_RAD)] // 3] = True
    return found


def curved_area(vertices: Array, triangles: IntArray) -> float:
    """Area of the triangles that stand for curved faces, mm^2."""
    return float(areas(vertices, triangles)[curved(vertices, triangles)].sum())


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
    """Test if points (n, 3) lie inside a solid: on the shortest way out of its box, a ray passes
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


def thicknesses(solid: Manifold, points: Array, normals: Array) -> Array:
    """Thickness (n,) mm of a solid at points (n, 3) of its surface, inward along outward normals;
    infinite where none is met."""
    low, high = bounds(solid)
    reach = float(np.linalg.norm(high - low))
    starts, ends = points - START_MM * normals, points - reach * normals
    found = np.full(len(points), np.inf)
    for row, (start, end) in enumerate(pairs(starts, ends)):
        for hit in solid.ray_cast(start, end):
            distance = hit.distance * (reach - START_MM)
            if distance > START_MM:
                if float(np.dot(hit.normal, normals[row])) < -OPPOSITE:
                    found[row] = distance + START_MM
                break
    return found
