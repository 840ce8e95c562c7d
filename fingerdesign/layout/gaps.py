"""Distances between plates in space, and from plates to the core, in closed form (numpy only).

A plate is a polygon drawn straight across its section plane; a bent one a chain of such pieces.
Two that are drawn in the same direction are as far apart as their polygons in the plane and their
spans across it (the two squares add); one along x and one along z are told by their edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.schema import Core
from fingerdesign.layout.frames import PlateFrame

# Distances between plates along x and plates along z, in closed form (numpy only); mm.
#
# The one is a polygon in (x, y) spanning z, the other a polygon in (z, y) spanning x. They overlap
# where the heights at which the one lies within the other's span meet the heights at which the
# other lies within the one's. Apart, they are nearest at a corner of one or at an edge of each.


def crossing_distances(
    first: Array, first_spans: Array, second: Array, second_spans: Array
) -> Array:
    """Distances (n,) between prisms of quads (n, 4, 2) and spans (n, 2) drawn crosswise.

    The planes of ``first`` and ``second`` share their second coordinate, the height; each one's
    first coordinate runs along the other's span.
    """
    one, two = _heights_within(first, second_spans), _heights_within(second, first_spans)
    with np.errstate(invalid="ignore"):
        overlap = (one[:, 0] <= two[:, 1]) & (two[:, 0] <= one[:, 1])  # False for NaN
    corners = np.minimum(
        _corners_apart(first, first_spans, second, second_spans),
        _corners_apart(second, second_spans, first, first_spans),
    )
    a = _edges(first, first_spans)
    b = _edges(second, second_spans)[..., ::-1]  # (z, y, x) to (x, y, z)
    edges = _segment_distances(a[:, :, None], b[:, None, :]).min(axis=(1, 2))
    return np.where(overlap, 0.0, np.minimum(corners, edges))


def _heights_within(quads: Array, strips: Array) -> Array:
    """Least and greatest height (n, 2) of each quad's part with first coordinate in its strip.

    NaN where no part of it does.
    """
    x, y = quads[..., 0], quads[..., 1]
    x_next, y_next = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    inside = (x >= strips[:, :1]) & (x <= strips[:, 1:])
    heights = [np.where(inside, y, np.nan)]
    for side in (strips[:, :1], strips[:, 1:]):
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (side - x) / (x_next - x)
            met = (share >= 0.0) & (share <= 1.0)
            heights.append(np.where(met, y + share * (y_next - y), np.nan))
    every = np.concatenate(heights, axis=1)
    known = ~np.isnan(every).all(axis=1)
    low = np.where(np.isnan(every), np.inf, every).min(axis=1)
    high = np.where(np.isnan(every), -np.inf, every).max(axis=1)
    return np.where(known[:, None], np.column_stack([low, high]), np.nan)


def _corners_apart(first: Array, first_spans: Array, second: Array, second_spans: Array) -> Array:
    """Least distance (n,) of a corner of the first prism to the second prism."""
    found = np.full(len(first), np.inf)
    for end in range(2):
        plane = np.stack(
            [np.broadcast_to(first_spans[:, end : end + 1], first.shape[:2]), first[..., 1]],
            axis=-1,
        )
        across = first[..., 0]
        beyond = np.maximum(
            np.maximum(second_spans[:, :1] - across, across - second_spans[:, 1:]), 0.0
        )
        found = np.minimum(found, np.hypot(_to_quads(plane, second), beyond).min(axis=1))
    return found


def _to_quads(points: Array, quads: Array) -> Array:
    """Distances (n, p) of points (n, p, 2) to anticlockwise convex quads (n, 4, 2), 0 inside."""
    start = quads[:, None]
    edge = np.roll(quads, -1, axis=1)[:, None] - start
    offset = points[:, :, None] - start
    share = np.clip((offset * edge).sum(-1) / (edge * edge).sum(-1), 0.0, 1.0)
    away = np.linalg.norm(offset - share[..., None] * edge, axis=-1).min(axis=2)
    turn = edge[..., 0] * offset[..., 1] - edge[..., 1] * offset[..., 0]
    inside = (turn >= 0.0).all(axis=2) | (turn <= 0.0).all(axis=2)
    return np.where(inside, 0.0, away)


def _edges(quads: Array, spans: Array) -> Array:
    """The twelve edges (n, 12, 2, 3) of each prism, in (plane, plane, across)."""
    low, high = (
        np.concatenate(
            [quads, np.broadcast_to(spans[:, end, None, None], (*quads.shape[:2], 1))], axis=2
        )
        for end in range(2)
    )
    return np.concatenate(
        [
            np.stack([low, np.roll(low, -1, axis=1)], axis=2),
            np.stack([high, np.roll(high, -1, axis=1)], axis=2),
            np.stack([low, high], axis=2),
        ],
        axis=1,
    )


def _segment_distances(first: Array, second: Array) -> Array:
    """Distances between segments (..., 2, 3), broadcast against each other.

    The closest points of the two lines, each clamped to its segment in turn; of parallel ones any.
    """
    p, q = first[..., 0, :], second[..., 0, :]
    u, v = first[..., 1, :] - p, second[..., 1, :] - q
    w = p - q
    uu, vv, uv = (u * u).sum(-1), (v * v).sum(-1), (u * v).sum(-1)
    uw, vw = (u * w).sum(-1), (v * w).sum(-1)
    det = uu * vv - uv * uv
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.where(det > 1e-12 * uu * vv, np.clip((uv * vw - vv * uw) / det, 0.0, 1.0), 0.0)
    t = np.clip((uv * s + vw) / vv, 0.0, 1.0)
    s = np.clip((uv * t - uw) / uu, 0.0, 1.0)
    gap = w + s[..., None] * u - t[..., None] * v
    return np.asarray(np.sqrt((gap * gap).sum(-1)))


MOST_PIECES = 16  # of a bent plate
_STRAY_MM = 1e-3  # by which its pieces may
_CHUNK = 4000  # pairs judged at a time, nearest first


@dataclass(frozen=True)
class PlateGap:
    """The least distance between two plates, mm (0: they touch or cross), and which ones."""

    distance: float
    first: int
    second: int


@dataclass(frozen=True)
class Prisms:
    """Convex pieces of plates: quads (n, 4, 2) in the section plane, spans (n, 2), whose they are.

    ``crosswise`` (n,): drawn in the plane (z, y) and spanning x, not in (x, y) and spanning z.
    """

    quads: Array
    spans: Array
    crosswise: NDArray[np.bool_]
    owner: IntArray

    @classmethod
    def of(cls, frames: tuple[PlateFrame, ...]) -> Prisms:
        """The pieces of plates; those that have no place (NaN) are left out."""
        quads, owner = [], []
        placed = [k for k, f in enumerate(frames) if np.isfinite(f.place) and np.isfinite(f.y)]
        if all(frame.bend_radius is None for frame in frames):
            quads, owner = [flat_corners(tuple(frames[k] for k in placed))], placed
        else:
            for k in placed:
                pieces = _quads(frames[k])
                quads.append(pieces)
                owner += [k] * len(pieces)
        index = np.array(owner, dtype=np.int64)
        spans = np.array([[frame.low, frame.high] for frame in frames]).reshape(-1, 2)
        crosswise = np.array([frame.along == "z" for frame in frames], dtype=bool)
        stacked = np.concatenate(quads) if quads else np.zeros((0, 4, 2))
        return cls(stacked, spans[index], crosswise[index], index)

    def rows(self, index: IntArray) -> Prisms:
        """Some of the pieces, in that order."""
        return Prisms(
            self.quads[index], self.spans[index], self.crosswise[index], self.owner[index]
        )

    @property
    def most_pieces(self) -> int:
        """The most pieces that a plate has."""
        return int(np.bincount(self.owner).max()) if len(self.owner) else 1

    def plate_boxes(self, plates: int) -> tuple[Array, Array]:
        """Least and greatest x, y, z of each plate, (plates, 3); NaN: it has no place."""
        low, high = self.boxes()
        least, most = np.full((plates, 3), np.inf), np.full((plates, 3), -np.inf)
        np.minimum.at(least, self.owner, low)
        np.maximum.at(most, self.owner, high)
        placed = np.isfinite(least)
        return np.where(placed, least, np.nan), np.where(placed, most, np.nan)

    def boxes(self) -> tuple[Array, Array]:
        """Least and greatest x, y, z of each piece, (n, 3)."""
        low, high = self.quads.min(axis=1), self.quads.max(axis=1)
        flip = self.crosswise[:, None]

        def ordered(plane: Array, across: Array) -> Array:
            along_x = np.column_stack([plane[:, 0], plane[:, 1], across])
            along_z = np.column_stack([across, plane[:, 1], plane[:, 0]])
            return np.where(flip, along_z, along_x)

        return ordered(low, self.spans[:, 0]), ordered(high, self.spans[:, 1])


def flat_corners(frames: tuple[PlateFrame, ...]) -> Array:
    """Section corners (plates, 4, 2) of flat plates, anticlockwise, all at once."""
    values = np.array([[f.place, f.y, f.angle_deg, f.length, f.thickness] for f in frames])
    place, y, angle, length, thickness = values.reshape(-1, 5).T[..., None]
    s = 0.5 * length * np.array([-1.0, 1.0, 1.0, -1.0])
    v = 0.5 * thickness * np.array([-1.0, -1.0, 1.0, 1.0])
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.stack([place + s * cosine - v * sine, y + s * sine + v * cosine], axis=-1)


def _quads(frame: PlateFrame) -> Array:
    if frame.bend_radius is None:
        return frame.corners()[None]
    enough = np.sqrt(frame.length**2 / (8.0 * max(frame.bend_radius, 1e-3) * _STRAY_MM))
    pieces = int(np.clip(np.ceil(enough), 1, MOST_PIECES))
    outline = frame.outline(pieces)
    lower, upper = outline[: pieces + 1], outline[:pieces:-1]
    return np.stack([lower[:-1], lower[1:], upper[1:], upper[:-1]], axis=1)


def least_gap(
    first: tuple[PlateFrame, ...], second: tuple[PlateFrame, ...] | None = None
) -> PlateGap | None:
    """The closest pair of plates, or of one in ``first`` and one in ``second``; None: no pair."""
    other = first if second is None else second
    a, b = Prisms.of(first), Prisms.of(other)
    low_a, high_a = a.plate_boxes(len(first))
    low_b, high_b = b.plate_boxes(len(other))
    i, j = np.divmod(np.arange(len(first) * len(other)), max(len(other), 1))
    known = np.isfinite(low_a[i, 0]) & np.isfinite(low_b[j, 0])
    known &= (i < j) if second is None else True
    i, j = i[known], j[known]
    if not len(i):
        return None
    between = np.maximum(np.maximum(low_b[j] - high_a[i], low_a[i] - high_b[j]), 0.0)
    least = np.linalg.norm(between, axis=1)
    order = np.argsort(least, kind="stable")
    i, j, least = i[order], j[order], least[order]
    best, pair = np.inf, (0, 0)
    step = max(1, _CHUNK // (a.most_pieces * b.most_pieces))
    for start in range(0, len(i), step):
        if least[start] > best or best == 0.0:
            break
        part = slice(start, start + step)
        one, two, plates = _piece_pairs(a, b, i[part], j[part])
        distances = prism_distances(a.rows(one), b.rows(two))
        k = int(np.argmin(distances))
        if distances[k] < best:
            best, found = float(distances[k]), start + int(plates[k])
            pair = (first[i[found]].index, other[j[found]].index)
    return PlateGap(best, min(pair), max(pair))


def neighbour_gaps(frames: tuple[PlateFrame, ...]) -> Array:
    """Distances (plates - 1,) from each plate to the next, mm; all of them have a place."""
    pieces = Prisms.of(frames)
    index = np.arange(len(frames) - 1, dtype=np.int64)
    one, two, pair = _piece_pairs(pieces, pieces, index, index + 1)
    found = np.full(len(index), np.inf)
    np.minimum.at(found, pair, prism_distances(pieces.rows(one), pieces.rows(two)))
    return found


def _piece_pairs(
    a: Prisms, b: Prisms, first: IntArray, second: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Every piece of plate ``first[k]`` with every one of ``second[k]``: pieces, pieces, k."""
    if a.most_pieces * b.most_pieces == 1:
        pairs = np.arange(len(first), dtype=np.int64)
        return np.searchsorted(a.owner, first), np.searchsorted(b.owner, second), pairs
    one, two, pair = [], [], []
    for k, (i, j) in enumerate(zip(first, second, strict=True)):
        of_i, of_j = np.flatnonzero(a.owner == i), np.flatnonzero(b.owner == j)
        one.append(np.repeat(of_i, len(of_j)))
        two.append(np.tile(of_j, len(of_i)))
        pair.append(np.full(len(of_i) * len(of_j), k))
    return np.concatenate(one), np.concatenate(two), np.concatenate(pair)


def prism_distances(a: Prisms, b: Prisms) -> Array:
    """Distances (n,) between the pieces of ``a`` and those of ``b``, one by one; 0: overlap."""
    found = np.zeros(len(a.owner))
    alike = a.crosswise == b.crosswise
    one, two = a.rows(np.flatnonzero(alike)), b.rows(np.flatnonzero(alike))
    found[alike] = np.hypot(
        pair_distances(one.quads, two.quads), _interval_gaps(one.spans, two.spans)
    )
    if not alike.all():
        rest = np.flatnonzero(~alike)
        one, two = a.rows(rest), b.rows(rest)
        found[rest] = crossing_distances(one.quads, one.spans, two.quads, two.spans)
    return found


def core_gaps(core: Core, depth: float, frames: tuple[PlateFrame, ...]) -> Array:
    """Distances (plates,) from each plate to the core, mm; 0: they touch or cross; NaN: no place.

    ``depth``: the core's extent along z, mm.
    """
    pieces = Prisms.of(frames)
    found = np.full(len(frames), np.nan)
    if not len(pieces.owner):
        return found
    low, high = core.bottom_mm, core.bottom_mm + core.height_mm
    along_x, along_z = 0.5 * core.width_mm, 0.5 * depth
    half = np.where(pieces.crosswise, along_z, along_x)
    corners = np.stack([np.array([-1.0, 1.0, 1.0, -1.0])] * len(half)) * half[:, None]
    heights = np.broadcast_to(np.array([low, low, high, high]), corners.shape)
    across = np.where(pieces.crosswise, along_x, along_z)
    section = pair_distances(pieces.quads, np.stack([corners, heights], axis=-1))
    spans = _interval_gaps(pieces.spans, np.column_stack([-across, across]))
    distances = np.hypot(section, spans)
    found[np.unique(pieces.owner)] = np.inf
    np.minimum.at(found, pieces.owner, distances)
    return found


def _interval_gaps(first: Array, second: Array) -> Array:
    """Distances (n,) between intervals (n, 2)."""
    apart = np.maximum(first[:, 0] - second[:, 1], second[:, 0] - first[:, 1])
    return np.asarray(np.maximum(apart, 0.0))


def pair_distances(first: Array, second: Array) -> Array:
    """Distances between the convex quads (n, 4, 2) and (n, 4, 2) of the plane: shape (n,).

    0 where they overlap, by separating axes; else the least distance of a corner of one to an
    edge of the other, which is exact for convex polygons.
    """
    edges = np.concatenate(
        [np.roll(first, -1, axis=1) - first, np.roll(second, -1, axis=1) - second], axis=1
    )
    normals = np.stack([-edges[..., 1], edges[..., 0]], axis=-1)
    along_first = np.einsum("nkd,ncd->nkc", normals, first)
    along_second = np.einsum("nkd,ncd->nkc", normals, second)
    apart = (along_first.min(2) > along_second.max(2)) | (along_second.min(2) > along_first.max(2))
    distance = np.minimum(corners_to_edges(first, second), corners_to_edges(second, first))
    return np.where(apart.any(axis=1), distance, 0.0)


def corners_to_edges(points: Array, polygon: Array) -> Array:
    """Least distance (n,) of the points (n, p, 2) to the edges of the polygons (n, 4, 2)."""
    start = polygon[:, None]
    edge = np.roll(polygon, -1, axis=1)[:, None] - start
    offset = points[:, :, None] - start
    share = (offset * edge).sum(-1) / (edge * edge).sum(-1)
    rest = offset - np.clip(share, 0.0, 1.0)[..., None] * edge
    return np.asarray(np.sqrt((rest * rest).sum(-1)).min(axis=(1, 2)))
