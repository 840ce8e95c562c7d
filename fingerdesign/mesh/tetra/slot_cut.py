"""Cutting a tetrahedral mesh along a plate's mid-surface: what is to be cut, by nodes alone."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.cells import Stars, boundary_facets

Triple = tuple[int, int, int]
_STEEPEST = np.radians(75.0)  # of a wing against the plate's plane: a slot's end must open
_ON = 1e-7  # mm: snapped nodes lie on their planes to rounding
# A way around a rim is this much longer where it is upright, and where it lies over the sheet: such
# a way opens to a wedge above the plate, which turns tetrahedra over.
_STEEP, _OVER = 4.0, 40.0
_FILLED = 1e-6  # relative: what is missing is a facet or nothing


@dataclass(frozen=True)
class Cut:
    """The facets at which a mesh opens for one plate, by numbers of its nodes.

    sheet (f, 3): F, its normal to the plate's upper side; wings (w, 3): two rim nodes, then the far
    one; flaps (p, 3): a rim node, then two far ones.
    """

    sheet: IntArray
    wings: IntArray
    flaps: IntArray

    @property
    def facets(self) -> IntArray:
        """Sheet, wings and flaps, (f + w + p, 3)."""
        return np.vstack([self.sheet, self.wings, self.flaps])

    @property
    def nodes(self) -> IntArray:
        """Nodes that become an upper and a lower one."""
        return np.unique(self.sheet)


def sheet_facets_of(
    points: Array, cells: IntArray, carrier: BoolArray, frame: PlateFrame
) -> IntArray:
    """F: facets (f, 3) on a plate's mid-surface, their normals to the upper side.

    carrier (t,): the tetrahedra of the plate's carrier box. MeshError where they do not fill it.
    """
    on = np.abs(frame.local(points)[:, 1]) < _ON
    facets = boundary_facets(cells[carrier])
    facets = facets[on[facets].all(axis=1)]
    a, b, c = (points[facets[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    up = normal @ frame.direction(frame.normal)
    facets = np.where(up[:, None] > 0.0, facets, facets[:, [0, 2, 1]])
    across = frame.across(points)
    requested = _extent(points, frame)
    filled = float(0.5 * np.abs(up).sum())
    s = np.abs(frame.local(points)[:, 0])
    reach = facets.ravel()
    strays = (s[reach] > 0.5 * frame.length + _ON).any() if len(facets) else True
    strays = strays or bool((across[reach] > frame.high + _ON).any())
    if strays or not abs(filled / requested - 1.0) < _FILLED:
        raise MeshError(
            f"the mesh follows {filled:.6g} of {requested:.6g} mm^2 of plate {frame.index}'s "
            "mid-surface"
        )
    return np.asarray(facets)


def _extent(points: Array, frame: PlateFrame) -> float:
    """Area of the plate's mid-surface within the mesh (a half ends at its symmetry plane), mm^2."""
    across = frame.across(points)
    span = min(frame.high, float(across.max())) - max(frame.low, float(across.min()))
    ends = frame.to_space(frame.from_local(np.array([-0.5, 0.5]) * frame.length, 0.0), frame.middle)
    length = frame.length
    if frame.along == "z" and ends[:, 2].min() < points[:, 2].min() - _ON:
        length *= (ends[:, 2].max() - float(points[:, 2].min())) / float(np.ptp(ends[:, 2]))
    return length * span


def plan_cut(
    points: Array,
    stars: Stars,
    sheet: IntArray,
    outer: IntArray,
    frame: PlateFrame,
    taken: BoolArray,
) -> Cut:
    """Find wings and flaps around the facets F (f, 3).

    outer (o, 3): facets of the mesh's outside; taken (n,): nodes on mid-surfaces, which a strip
    must not touch. MeshError where a rim edge or node leaves no way.
    """
    normal = frame.direction(frame.normal)
    edges, uses = np.unique(_edges(sheet), axis=0, return_counts=True)
    rim = edges[uses == 1]
    both = np.sort(np.vstack([outer, sheet]), axis=1)
    if len(np.unique(both, axis=0)) < len(both):
        raise MeshError(
            f"the mid-surface of plate {frame.index} lies on the outside of what is meshed (a "
            "symmetry plane?): as a sheet it would be cut in its own plane"
        )
    outside = {(int(a), int(b)) for a, b in _edges(outer)}
    ends_at: dict[int, list[int]] = {}
    wings: list[Triple] = []
    middle = points[np.unique(sheet)].mean(axis=0)
    for a, b in rim.tolist():
        if (a, b) in outside:
            continue
        far = _wing(points, stars, (a, b), normal, middle, taken, frame)
        ends_at.setdefault(a, []).append(far)
        ends_at.setdefault(b, []).append(far)
        wings.append((a, b, far))
    if not wings:
        raise MeshError(f"plate {frame.index} has no free edge inside the body")
    flaps: list[Triple] = []
    for node, ends in ends_at.items():
        if len(ends) > 2:
            raise MeshError(f"plate {frame.index}'s mid-surface touches itself in a node")
        goals = {ends[1]} if len(ends) == 2 else _next_to(outer, node, taken)
        fan = sheet[(sheet == node).any(axis=1)]
        path = _path(points, stars, node, fan, ends[0], goals, normal, taken)
        if path is None:
            raise MeshError(f"no facets lead on around the rim of plate {frame.index}")
        flaps += [(node, x, y) for x, y in pairwise(path)]
    return Cut(sheet, _as_facets(wings), _as_facets(flaps))


def _edges(facets: IntArray) -> IntArray:
    """Edges (3f, 2) of facets (f, 3), the lower node first."""
    return np.asarray(np.sort(facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1))


def _next_to(outer: IntArray, node: int, taken: BoolArray) -> set[int]:
    """Free nodes next to a node along the body's outside."""
    near = np.unique(outer[(outer == node).any(axis=1)])
    return {int(n) for n in near if n != node and not taken[n]}


def _as_facets(found: list[Triple]) -> IntArray:
    return np.array(found, dtype=np.int64).reshape(-1, 3)


def _wing(
    points: Array,
    stars: Stars,
    edge: tuple[int, int],
    normal: Array,
    middle: Array,
    taken: BoolArray,
    frame: PlateFrame,
) -> int:
    """The node over a rim edge that lies most nearly in the plate's plane beyond it."""
    a, b = edge
    both = np.intersect1d(stars.around(a), stars.around(b))
    nodes = np.unique(stars.cells[both])
    nodes = nodes[~taken[nodes]]
    along = points[b] - points[a]
    along /= np.linalg.norm(along)
    outward = np.cross(along, normal)
    if outward @ (points[a] - middle) < 0.0:
        outward = -outward
    offset = points[nodes] - points[a]
    steep = np.abs(np.arctan2(offset @ normal, offset @ outward))
    if len(nodes) == 0 or steep.min() > _STEEPEST:
        raise MeshError(f"no facet leads on beyond an end of plate {frame.index}")
    return int(nodes[np.argmin(steep)])


def _path(
    points: Array,
    stars: Stars,
    node: int,
    fan: IntArray,
    first: int,
    goals: set[int],
    normal: Array,
    taken: BoolArray,
) -> list[int] | None:
    """Shortest way over the link of a node from ``first`` to one of ``goals``, in the plate's plane
    as far as may be and around the facets ``fan`` (f, 3) of F at the node, not over them; None
    where there is none."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    cells = stars.cells[stars.around(node)]
    link = cells[cells != node].reshape(-1, 3)
    edges = np.unique(np.sort(link[:, [0, 1, 1, 2, 0, 2]].reshape(-1, 2), axis=1), axis=0)
    names, edges = np.unique(edges[~taken[edges].any(axis=1)], return_inverse=True)
    ends = [k for k, name in enumerate(names.tolist()) if name in goals]
    if first not in names or not ends:
        return None
    one, two = edges.reshape(-1, 2).T
    unit = points[names] - points[node]
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    steep = (unit @ normal) ** 2
    spans = points[fan[fan != node].reshape(-1, 2)] - points[node]
    worse = _STEEP * steep + _OVER * over(unit, spans)
    cost = np.linalg.norm(unit[one] - unit[two], axis=1) * (1.0 + worse[one] + worse[two])
    graph = coo_array((cost, (one, two)), shape=(len(names),) * 2)
    start = int(np.searchsorted(names, first))
    away, before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
    path = [min(ends, key=lambda k: away[k])]
    if not np.isfinite(away[path[0]]):
        return None
    while path[-1] != start:
        path.append(int(before[path[-1]]))
    return [int(name) for name in names[path[::-1]]]


def over(unit: Array, spans: Array) -> BoolArray:
    """Mask (n,) of the directions (n, 3) that lie over one of the triangles 0, p, q of ``spans``
    (f, 2, 3): whose projections into its plane are between p and q."""
    p, q = spans[:, 0], spans[:, 1]
    normal = np.cross(p, q)
    normal /= (normal**2).sum(axis=1)[:, None]
    of_p = unit @ np.cross(q, normal).T
    of_q = unit @ np.cross(normal, p).T
    return np.asarray(((of_p >= -_ON) & (of_q >= -_ON)).any(axis=1))
